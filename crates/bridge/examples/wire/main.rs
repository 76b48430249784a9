//! Measurement tools for `tests/bridge/run`. They write and read a rope on either side of a bridge,
//! send bare pings of the same size over UDP and TCP, and relay with delay, jitter and loss.
//!
//! ```sh
//! wire write RIG HZ COUNT                 in the domain that LARIAT_DOMAIN names
//! wire frames RIG HZ SECONDS              pictures of 1280 x 1024
//! wire read RIG SECONDS                   until nothing came for SECONDS; prints JSON, with every gap over 40 ms
//! wire serve udp|tcp ADDRESS:PORT         sends back what comes, and the time when it came
//! wire ping udp|tcp ADDRESS:PORT BYTES HZ COUNT
//! wire relay LISTEN TO DELAY_US JITTER_US LOST_OF_1000
//! ```

mod relay;
mod rope;

use std::error::Error;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::time::{Duration, Instant};

use lariat_wire::{
    DESCRIPTORS, Delivery, Descriptors, Domain, FrameHeader, PixelFormat, Receiver, Rig, Writer,
    now_ns, take_short_slices,
};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["write", rig, hz, count] => write(&rig.parse()?, hz.parse()?, count.parse()?),
        ["frames", rig, hz, seconds] => frames(&rig.parse()?, hz.parse()?, seconds.parse()?),
        ["read", rig, seconds] => read(&rig.parse()?, Duration::from_secs_f64(seconds.parse()?)),
        ["serve", "udp", at] => serve_udp(at),
        ["serve", "tcp", at] => serve_tcp(at),
        ["ping", how, to, bytes, hz, count] => ping(
            how,
            to.parse()?,
            bytes.parse()?,
            hz.parse()?,
            count.parse()?,
        ),
        ["relay", listens, to, delay_us, jitter_us, lost_of_1000] => {
            let weather = relay::Weather {
                delay: Duration::from_micros(delay_us.parse()?),
                jitter: Duration::from_micros(jitter_us.parse()?),
                lost_of_1000: lost_of_1000.parse()?,
            };
            Ok(relay::Relay::new(listens.parse()?, to.parse()?, weather, 1)?.run(|| true)?)
        }
        _ => Err("see the head of examples/wire/main.rs".into()),
    }
}

/// A fixed rate, without drift.
struct Beat {
    due: Instant,
    period: Duration,
}

impl Beat {
    fn new(hz: f64) -> Self {
        Self {
            due: Instant::now(),
            period: Duration::from_secs_f64(1.0 / hz),
        }
    }

    fn wait(&mut self) {
        // Keeps a camera's pace; nothing else wakes it.
        std::thread::sleep(self.due.saturating_duration_since(Instant::now()));
        self.due += self.period;
    }
}

fn write(rig: &Rig, hz: f64, count: u64) -> Result<()> {
    let domain = Domain::open()?;
    let writer = Writer::<Descriptors>::create(&domain, rig, &DESCRIPTORS, &Delivery::NewestWins)?;
    // The bridge opens the channel at its next check.
    let deadline = Instant::now() + Duration::from_secs(10);
    while writer.readers() == 0 && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(10));
    }
    // By then the far side has set up its link.
    std::thread::sleep(Duration::from_millis(300));
    let mut beat = Beat::new(hz);
    for count in 1..=count {
        beat.wait();
        let mut slot = writer.slot()?;
        rope::write(&mut slot, count, now_ns());
        // Stamps the message again, now that it is in shared memory.
        rope::stamp(&mut slot, now_ns());
        slot.send()?;
    }
    // Messages in transit are still to be read.
    std::thread::sleep(Duration::from_millis(700));
    Ok(())
}

fn frames(rig: &Rig, hz: f64, seconds: f64) -> Result<()> {
    let (width, height) = (1280, 1024);
    let bytes = 3 * (width * height) as usize;
    let domain = Domain::open()?;
    let writer = Writer::<[u8]>::frames(&domain, rig, &Delivery::NewestWins, bytes)?;
    // Texture makes the JPEG as large as a camera's. It is drawn once, because a camera's exposure
    // takes no CPU time.
    let texture = (0..(width * (height + 1)) as usize).flat_map(|at| {
        let grain = (((at as u64 * 0x9e37_79b9) >> 16) & 15) as u8;
        [
            grain + (at % 160) as u8,
            grain + (at / 16384) as u8,
            90 + grain,
        ]
    });
    let texture: Vec<u8> = texture.collect();
    let mut beat = Beat::new(hz);
    for count in 0..(hz * seconds) as usize {
        beat.wait();
        let mut slot = writer.frame_slot(bytes)?;
        slot.copy_from_slice(&texture[3 * (count % width as usize)..][..bytes]);
        *slot.header_mut() = FrameHeader {
            width,
            height,
            stride: 3 * width,
            pixel_format: PixelFormat::Rgb8 as u32,
            ..FrameHeader::default()
        };
        slot.header_mut().trace.exposed_ns = now_ns();
        slot.send()?;
    }
    Ok(())
}

fn read(rig: &Rig, patience: Duration) -> Result<()> {
    let domain = Domain::open()?;
    // A control loop does the same.
    take_short_slices();
    let reader = Receiver::descriptors(&domain, rig)?;
    let (mut late_ns, mut off_ns) = (Vec::new(), Vec::new());
    let (mut back, mut last, mut gaps_ms, mut arrived_ns) = (0, None, Vec::new(), 0);
    let mut heard = Instant::now() + Duration::from_secs(20);
    while Instant::now() < heard {
        reader.sleep(Some(heard), None)?;
        let now_ns = now_ns();
        while let Some(message) = reader.next()? {
            heard = Instant::now() + patience;
            let written_ns = rope::written_ns(&message);
            late_ns.push(now_ns.saturating_sub(written_ns));
            off_ns.push(message.trace.exposed_ns.abs_diff(written_ns));
            let at = (message.trace.fitted, message.trace.exposed_ns);
            back += u64::from(
                last.is_some_and(|(fitted, exposed_ns)| at.0 <= fitted || at.1 <= exposed_ns),
            );
            last = Some(at);
            let gap_ms = now_ns.saturating_sub(arrived_ns) / 1_000_000;
            if arrived_ns > 0 && gap_ms > 40 {
                gaps_ms.push(gap_ms);
            }
            arrived_ns = now_ns;
        }
    }
    println!(
        "{{{}, \"back\": {back}, \"gaps_ms\": {gaps_ms:?}, \"stamps_off\": {{{}}}}}",
        figures(&mut late_ns),
        figures(&mut off_ns)
    );
    Ok(())
}

/// Formats percentiles in µs as JSON.
fn figures(ns: &mut [u64]) -> String {
    ns.sort_unstable();
    let at = |share: f64| match ns.len() {
        0 => "null".into(),
        count => format!(
            "{:.1}",
            ns[((count - 1) as f64 * share).round() as usize] as f64 * 1e-3
        ),
    };
    format!(
        "\"count\": {}, \"p50_us\": {}, \"p99_us\": {}, \"p999_us\": {}, \"max_us\": {}",
        ns.len(),
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0)
    )
}

/// Length of a ping's head: the time when it left, then its length. On the way back, the time when
/// it arrived at the far end replaces the length.
const HEAD: usize = 16;

fn number(bytes: &[u8]) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes[i]))
}

fn serve_udp(at: &str) -> Result<()> {
    let socket = UdpSocket::bind(at)?;
    let mut buffer = [0; 65536];
    loop {
        let (length, from) = socket.recv_from(&mut buffer)?;
        buffer[8..HEAD].copy_from_slice(&now_ns().to_le_bytes());
        socket.send_to(&buffer[..length], from)?;
    }
}

fn serve_tcp(at: &str) -> Result<()> {
    let listener = TcpListener::bind(at)?;
    loop {
        let (mut stream, _) = listener.accept()?;
        stream.set_nodelay(true)?;
        let mut buffer = vec![0; HEAD];
        while stream.read_exact(&mut buffer[..HEAD]).is_ok() {
            buffer.resize(number(&buffer[8..HEAD]) as usize, 0);
            stream.read_exact(&mut buffer[HEAD..])?;
            buffer[8..HEAD].copy_from_slice(&now_ns().to_le_bytes());
            stream.write_all(&buffer)?;
        }
    }
}

/// Sends pings of `bytes` bytes and receives answers of the same length. A ping without an answer
/// within 2 s is lost. Each ping carries the time when it left, so several may be in transit.
fn ping(how: &str, to: SocketAddr, bytes: usize, hz: f64, count: u64) -> Result<()> {
    let length = bytes.max(HEAD);
    let mut message = vec![0; length];
    let socket = UdpSocket::bind("0.0.0.0:0")?;
    let stream = match how {
        "tcp" => Some(TcpStream::connect(to)?),
        _ => None,
    };
    match &stream {
        Some(stream) => {
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(Duration::from_secs(2)))?;
        }
        None => {
            socket.connect(to)?;
            socket.set_read_timeout(Some(Duration::from_secs(2)))?;
        }
    }
    let (mut back_ns, mut there_ns) = std::thread::scope(|scope| {
        let (stream, socket) = (&stream, &socket);
        let reads = scope.spawn(move || {
            let (mut buffer, mut back_ns, mut there_ns) = (vec![0; length], Vec::new(), Vec::new());
            while (back_ns.len() as u64) < count {
                let came = match stream {
                    Some(stream) => (&*stream).read_exact(&mut buffer).is_ok(),
                    None => socket.recv(&mut buffer).is_ok(),
                };
                if !came {
                    break;
                }
                let left_ns = number(&buffer);
                back_ns.push(now_ns() - left_ns);
                there_ns.push(number(&buffer[8..]).saturating_sub(left_ns));
            }
            (back_ns, there_ns)
        });
        let mut beat = Beat::new(hz);
        for _ in 0..count {
            beat.wait();
            message[..8].copy_from_slice(&now_ns().to_le_bytes());
            message[8..HEAD].copy_from_slice(&(length as u64).to_le_bytes());
            let sent = match stream {
                Some(stream) => (&*stream).write_all(&message),
                None => socket.send(&message).map(drop),
            };
            if sent.is_err() {
                break;
            }
        }
        reads.join().unwrap_or_default()
    });
    println!(
        "{{{}, \"there\": {{{}}}}}",
        figures(&mut back_ns),
        figures(&mut there_ns)
    );
    Ok(())
}

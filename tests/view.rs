//! `lariat view`: the page of a chain that runs, as a browser gets it: files, moments, status; who is refused; and what it leaves
//! alone. A browser itself looks at it in `tests/view/run`.

#[allow(dead_code, reason = "written for the chain's own tests")]
#[path = "chain/rig.rs"]
mod rig;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::Duration;

use lariat_record::{CompressedImageRecord, ImageRecord, Record};
use lariat_wire::{Centerlines, Descriptors};
use rig::{Bench, send};
use rustix::process::Signal;
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(30);
const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recordings/rope.mcap");
const PROTOCOL: &str = "lariat.view.v1";

/// A `lariat view` that runs.
struct Viewing {
    process: Child,
    /// `http://HOST:PORT/`, perhaps with a token.
    url: String,
}

impl Viewing {
    fn start(bench: &Bench, arguments: &[&str]) -> Self {
        let arguments = [&["view"], arguments, &["--port", "0"]].concat();
        let mut process = bench
            .command(&arguments)
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary runs");
        let url = url_in(&mut BufReader::new(process.stderr.take().expect("piped")));
        Self { process, url }
    }

    /// What stands between `http://` and the path.
    fn host(&self) -> &str {
        host(&self.url)
    }

    fn end(mut self) {
        send(self.process.id() as i32, Signal::TERM);
        assert!(self.process.wait().expect("waited for").success());
    }
}

/// Also of a test that fails.
impl Drop for Viewing {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn url_in(said: &mut impl BufRead) -> String {
    let mut line = String::new();
    while !line.contains("http://") {
        line.clear();
        assert!(
            said.read_line(&mut line).expect("readable") > 0,
            "no address was said"
        );
    }
    line[line.find("http://").expect("looked for")..]
        .trim()
        .to_owned()
}

fn host(url: &str) -> &str {
    let rest = url.strip_prefix("http://").expect("an address");
    rest.split('/').next().expect("a host")
}

/// A page's WebSocket, with what it is made to say of where it comes from.
struct Page(WebSocket<MaybeTlsStream<TcpStream>>);

impl Page {
    fn open(url: &str, origin: Option<&str>, protocol: &str) -> Result<Self, tungstenite::Error> {
        let address = format!("{}live", url.replacen("http", "ws", 1));
        let mut request = address.into_client_request().expect("an address");
        let headers = request.headers_mut();
        headers.insert("Sec-WebSocket-Protocol", protocol.parse().expect("plain"));
        if let Some(origin) = origin {
            headers.insert("Origin", origin.parse().expect("plain"));
        }
        let (mut socket, _) = tungstenite::connect(request)?;
        if let MaybeTlsStream::Plain(stream) = socket.get_mut() {
            stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        }
        Ok(Self(socket))
    }

    fn of(viewing: &Viewing) -> Self {
        Self::open(&viewing.url, None, PROTOCOL).expect("it is let in")
    }

    fn ask(&mut self) {
        let next = r#"{"type":"next","width":4000}"#;
        self.0.send(Message::text(next)).expect("sent");
    }

    /// The next moment: what was said of it, and its picture. Status is passed over.
    fn moment(&mut self) -> (Value, Vec<u8>) {
        loop {
            if let Message::Binary(bytes) = self.0.read().expect("a message in time") {
                let (said, jpeg, _) = parts(&bytes);
                return (said, jpeg);
            }
        }
    }

    /// The mask that the next moment comes with.
    fn mask(&mut self) -> Vec<u8> {
        loop {
            if let Message::Binary(bytes) = self.0.read().expect("a message in time") {
                return parts(&bytes).2;
            }
        }
    }

    /// What is said to a wish, or why it is refused. What else comes is passed over.
    fn wish(&mut self, wish: Value) -> Result<Value, String> {
        self.0
            .send(Message::text(asked(1, wish).to_string()))
            .expect("sent");
        loop {
            let Message::Text(text) = self.0.read().expect("a message in time") else {
                continue;
            };
            let mut said: Value = serde_json::from_str(&text).expect("JSON");
            if said["type"] == "answer" && said["id"] == 1 {
                return match said["refused"].as_str() {
                    Some(why) => Err(why.to_owned()),
                    None => Ok(said["said"].take()),
                };
            }
        }
    }

    /// The next status for which this holds. Moments are passed over.
    fn status(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().expect("a message in time") {
                let status: Value = serde_json::from_str(&text).expect("JSON");
                if status["type"] == "status" && holds(&status) {
                    return status;
                }
            }
        }
    }
}

/// A moment's message: what was said of it, its picture, and the mask in it.
fn parts(bytes: &[u8]) -> (Value, Vec<u8>, Vec<u8>) {
    let (said, rest) = bytes.split_first_chunk().expect("a length");
    let (jpeg, rest) = rest.split_first_chunk().expect("a length");
    let (said, rest) = rest.split_at(u32::from_le_bytes(*said) as usize);
    let (jpeg, mask) = rest.split_at(u32::from_le_bytes(*jpeg) as usize);
    let said = serde_json::from_slice(said).expect("JSON");
    (said, jpeg.to_vec(), mask.to_vec())
}

fn get(host: &str, path: &str, more: &str) -> String {
    let mut stream = TcpStream::connect(host).expect("it listens");
    let request = format!("GET {path} HTTP/1.1\r\n{more}\r\n");
    stream.write_all(request.as_bytes()).expect("sent");
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// How many readers the channels of a rig have: frames, centerlines, descriptors.
fn readers(bench: &Bench, rig: &str) -> Vec<u64> {
    let output = bench.run(&["topic", "list", "--json"]);
    let all: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let list = |of: &Value| of.as_array().expect("a list").clone();
    let of_rig = list(&all["rigs"])
        .into_iter()
        .find(|one| one["rig"] == rig)
        .expect("the rig");
    let of = |name: &str| {
        let channels = list(&of_rig["channels"]);
        let found = channels.iter().find(|one| one["channel"] == name);
        list(&found.expect(name)["readers"]).len() as u64
    };
    ["frames", "centerlines", "descriptors"].map(of).to_vec()
}

#[test]
fn a_page_gets_pictures_with_the_curve_on_the_rope() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell", "--seed", "3"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    let mut frames = Vec::new();
    for _ in 0..5 {
        page.ask();
        let (said, jpeg) = page.moment();
        let picture = image::load_from_memory(&jpeg).expect("a JPEG").into_rgb8();
        assert_eq!(
            (said["width"].as_u64(), said["height"].as_u64()),
            (Some(640), Some(480))
        );
        assert_eq!(picture.dimensions(), (640, 480));
        // The rendered rope is much bluer than its table.
        let blue = |point: &Value| {
            let at = |i: usize| point[i].as_f64().expect("a number").round().max(0.0) as u32;
            let [red, _, blue] = picture
                .get_pixel(at(0).min(639), at(1).min(479))
                .0
                .map(i32::from);
            blue - red > 30
        };
        for rope in said["ropes"].as_array().expect("ropes") {
            let curve = rope["curve"].as_array().expect("points");
            let on_rope = curve.iter().filter(|point| blue(point)).count();
            assert!(
                on_rope * 10 >= curve.len() * 9,
                "{on_rope} of {} points lie on the rope",
                curve.len()
            );
        }
        assert!(!said["ropes"].as_array().expect("ropes").is_empty());
        frames.push(said["frame"].as_u64().expect("a number"));
    }
    assert!(frames.is_sorted_by(|a, b| a < b), "{frames:?}");
    let status = page.status(|status| {
        status["steps"]
            .as_array()
            .is_some_and(|steps| !steps.is_empty())
    });
    assert_eq!(status["rig"], "cell");
    assert_eq!(status["stages"].as_array().expect("stages").len(), 4);
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

#[test]
fn without_a_page_nothing_is_read_and_a_page_that_asks_for_nothing_has_no_picture() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let alone = readers(&bench, "cell");
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    assert_eq!(readers(&bench, "cell"), alone);
    let mut page = Page::of(&viewing);
    page.status(|status| status["fps"].as_f64().is_some());
    // It is told how the rig is, and no frame is copied for it.
    assert_eq!(readers(&bench, "cell"), [alone[0], alone[1], alone[2] + 1]);
    page.ask();
    page.moment();
    let all: Vec<u64> = alone.iter().map(|count| count + 1).collect();
    assert_eq!(readers(&bench, "cell"), all);
    drop(page);
    let mut left = readers(&bench, "cell");
    let deadline = std::time::Instant::now() + PATIENCE;
    while left != alone && std::time::Instant::now() < deadline {
        left = readers(&bench, "cell");
    }
    assert_eq!(left, alone);
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn a_page_goes_on_when_its_chain_is_started_anew() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    let waits = |status: &Value| {
        status["obstacle"]
            .as_str()
            .is_some_and(|why| why.contains("lariat run --rig cell"))
    };
    page.status(waits);
    for _ in 0..2 {
        let chain = bench.start(&["--rig", "cell"]);
        page.ask();
        let (said, _) = page.moment();
        assert!(said["frame"].as_u64() >= Some(1));
        chain.signal_chain(Signal::INT);
        assert!(chain.end().status.success());
        page.status(waits);
    }
    viewing.end();
    bench.assert_nothing_is_left();
}

#[test]
fn a_lossless_chain_loses_nothing_to_a_page_that_asks_for_nothing_more() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    page.ask();
    let flags = [
        "--rig",
        "cell",
        "--lossless",
        "--fps",
        "max",
        "--frames",
        "400",
        "--out",
        "report",
    ];
    let ended = bench.start(&flags).end();
    assert!(ended.status.success(), "{}", ended.stderr);
    page.moment();
    assert_eq!(bench.summary("report")["frames"]["received"], 400);
    viewing.end();
}

#[test]
fn foxglove_gets_every_channel_as_a_recording_has_it() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    for protocol in ["foxglove.websocket.v1", "foxglove.sdk.v1"] {
        let mut client = Page::open(&viewing.url, None, protocol)
            .expect("it is let in")
            .0;
        let channels = loop {
            let Message::Text(text) = client.read().expect("a message in time") else {
                panic!("nothing was subscribed to");
            };
            let said: Value = serde_json::from_str(&text).expect("JSON");
            if said["op"] == "advertise" {
                break said["channels"].as_array().expect("channels").clone();
            }
            assert_eq!(said["op"], "serverInfo");
        };
        let subscriptions: Vec<Value> = (channels.iter().zip(100..))
            .map(|(channel, id)| json!({"id": id, "channelId": channel["id"]}))
            .collect();
        let wish = json!({"op": "subscribe", "subscriptions": subscriptions});
        client.send(Message::text(wish.to_string())).expect("sent");
        let mut seen = std::collections::BTreeMap::new();
        while seen.len() < channels.len() {
            let Message::Binary(bytes) = client.read().expect("a message in time") else {
                continue;
            };
            assert_eq!(bytes[0], 1);
            let id = u32::from_le_bytes(bytes[1..5].try_into().expect("four bytes"));
            let topic = channels[id as usize - 100]["topic"]
                .as_str()
                .expect("a topic");
            seen.entry(topic.to_owned()).or_insert(bytes.slice(13..));
        }
        let decoded = |topic: &str, message: &mut dyn FnMut(&[u8])| message(&seen[topic]);
        decoded("/cell/descriptors", &mut |cdr| {
            let mut shapes = Box::new(Descriptors::EMPTY);
            shapes.decode(cdr).expect("descriptors");
            assert!(!shapes.curves().is_empty());
        });
        decoded("/cell/centerlines", &mut |cdr| {
            let mut lines = Box::new(Centerlines::EMPTY);
            lines.decode(cdr).expect("centerlines");
            assert!(!lines.curves().is_empty());
        });
        decoded("/cell/image", &mut |cdr| {
            assert!(ImageRecord::decode(cdr).expect("an image").is_whole());
        });
        decoded("/cell/image/compressed", &mut |cdr| {
            let picture = CompressedImageRecord::decode(cdr).expect("a picture");
            let picture = image::load_from_memory(picture.data).expect("a JPEG");
            assert_eq!((picture.width(), picture.height()), (640, 480));
        });
        decoded("/cell/latency", &mut |json| {
            let latency: Value = serde_json::from_slice(json).expect("JSON");
            let ms = |step: &str| latency[format!("{step}_ms")].as_f64().expect("a number");
            let steps = [
                "capture",
                "wait_for_extract",
                "extract",
                "wait_for_fit",
                "fit",
            ];
            assert!((ms("total") - steps.map(ms).iter().sum::<f64>()).abs() < 1e-6);
        });
    }
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn of_a_recording_any_frame_is_had_as_it_was_recorded() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &[GOLDEN]);
    let mut page = Page::of(&viewing);
    let status = page.status(|_| true);
    assert_eq!(status["film"]["name"], "rope.mcap");
    let frames = status["film"]["frames"].as_u64().expect("a number");
    let export = bench.run(&["export", GOLDEN, "--format", "jsonl", "--out", "-"]);
    let text = String::from_utf8(export.stdout).expect("text");
    let recorded: Vec<Value> = (text.lines())
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(recorded.len() as u64, frames);
    // On, back, over some, and to the end.
    for place in [0, 1, 0, frames / 2, frames - 1] {
        let wish = format!(r#"{{"type":"frame","place":{place},"width":4000}}"#);
        page.0.send(Message::text(wish)).expect("sent");
        let (said, jpeg) = page.moment();
        assert_eq!(said["number"].as_u64(), Some(place + 1));
        let picture = image::load_from_memory(&jpeg).expect("a JPEG");
        assert_eq!(Some(u64::from(picture.width())), said["width"].as_u64());
        let whole = &recorded[place as usize];
        assert_eq!(said["frame"], whole["trace"]["sequence"], "{whole}");
    }
    for place in [frames, u64::MAX] {
        let wish = format!(r#"{{"type":"frame","place":{place},"width":4000}}"#);
        page.0.send(Message::text(wish)).expect("sent");
        let Message::Text(said) = page.0.read().expect("a message in time") else {
            panic!("there is no frame {place}");
        };
        assert!(said.contains("missing"), "{said}");
    }
    assert!(Page::open(&viewing.url, None, "foxglove.websocket.v1").is_err());
    viewing.end();
    let none = bench.run(&["view", "none.mcap"]);
    assert!(!none.status.success());
}

#[test]
fn a_page_picks_a_colour_and_changes_settings_that_can_be_kept() {
    let bench = Bench::new();
    std::fs::write(bench.path("lariat.toml"), "# mine\n[fit]\nfilter = true\n").expect("written");
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let own = viewing.url.trim_end_matches('/');
    let mut page = Page::open(&viewing.url, Some(own), PROTOCOL).expect("it is let in");
    page.ask();
    let (said, _) = page.moment();
    let on_rope = &said["ropes"][0]["points"][60];
    let pick = json!({"wish": "pick", "number": said["number"], "at": [on_rope]});
    page.0
        .send(Message::text(asked(2, pick).to_string()))
        .expect("sent");
    let mask = image::load_from_memory(&page.mask())
        .expect("a PNG")
        .into_luma8();
    let white = mask.pixels().filter(|pixel| pixel.0 == [255]).count();
    assert!((1_000..40_000).contains(&white), "{white} pixels are rope");
    let at = |i: usize| on_rope[i].as_f64().expect("a number").round() as u32;
    assert_eq!(mask.get_pixel(at(0), at(1)).0, [255]);
    // On the table there is none.
    let table = page.wish(json!({"wish": "pick", "number": said["number"], "at": [[2, 2]]}));
    assert!(table.is_err(), "{table:?}");
    let old = page.wish(json!({"wish": "pick", "number": 0, "at": []}));
    assert!(old.expect_err("no such frame").contains("too old"));

    let changes = json!(["extract.ropes=2", "extract.mask=network"]);
    let answer = page
        .wish(json!({"wish": "set", "changes": changes}))
        .expect("taken");
    assert!(
        answer
            .as_str()
            .is_some_and(|said| said.contains("extract.ropes")),
        "{answer}"
    );
    let settings = page.wish(json!({"wish": "settings"})).expect("settings");
    assert_eq!(
        (&settings["extract"]["ropes"], &settings["fit"]["filter"]),
        (&json!(2), &json!(true))
    );
    for wrong in [
        "extract.ropes=99",
        "extract.rpoes=1",
        "extract.ropes=1\nrestart fit",
    ] {
        let refused = page.wish(json!({"wish": "set", "changes": [wrong]}));
        assert!(refused.is_err(), "{wrong}: {refused:?}");
    }
    page.wish(json!({"wish": "keep", "changes": changes}))
        .expect("kept");
    let kept = std::fs::read_to_string(bench.path("lariat.toml")).expect("the file");
    assert_eq!(
        kept,
        "# mine\n[fit]\nfilter = true\n\n[extract]\nropes = 2\nmask = \"network\"\n"
    );

    // A picture file is traced; what is none is said to be none.
    let picture =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/rope.png")).expect("there");
    page.0.send(Message::binary(picture)).expect("sent");
    let (traced, _) = page.moment();
    assert_eq!(traced["number"], 0);
    assert_eq!(traced["ropes"].as_array().expect("ropes").len(), 1);
    page.0.send(Message::binary(vec![7; 100])).expect("sent");
    let why = loop {
        if let Message::Text(text) = page.0.read().expect("a message in time")
            && text.contains("undropped")
        {
            break text;
        }
    };
    assert!(why.contains("no picture"), "{why}");

    // One that does not say that it is our own page may look only.
    let mut other = Page::of(&viewing);
    other.ask();
    other.moment();
    for wish in ["set", "keep"] {
        let refused = other.wish(json!({"wish": wish, "changes": ["extract.ropes=3"]}));
        assert!(refused.expect_err("refused").contains("may not change"));
    }
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

/// A wish as the page says it.
fn asked(id: u64, mut wish: Value) -> Value {
    wish["type"] = "ask".into();
    wish["id"] = id.into();
    wish
}

#[test]
fn the_page_is_whole_and_needs_nothing_from_elsewhere() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &[]);
    let local = format!("Host: {}\r\n", viewing.host());
    let page = get(viewing.host(), "/", &local);
    assert!(page.starts_with("HTTP/1.1 200 "), "{page}");
    assert!(page.contains("Content-Security-Policy: default-src 'none'"));
    let mut waiting: Vec<String> = vec![page];
    let mut seen = std::collections::BTreeSet::new();
    while let Some(text) = waiting.pop() {
        let named = text.split('"').skip(1).step_by(2).filter(|word| {
            [".js", ".css", ".svg"]
                .iter()
                .any(|ending| word.ends_with(ending))
        });
        for name in named {
            assert!(!name.contains("//"), "{name} is elsewhere");
            let name = name.trim_start_matches("./").to_owned();
            if seen.insert(name.clone()) {
                let file = get(viewing.host(), &format!("/{name}"), &local);
                assert!(file.starts_with("HTTP/1.1 200 "), "{name}: {file}");
                waiting.push(file);
            }
        }
    }
    assert!(seen.len() > 5, "{seen:?}");
    assert!(get(viewing.host(), "/../Cargo.toml", &local).starts_with("HTTP/1.1 404 "));
    viewing.end();
}

#[test]
fn other_sites_and_other_names_are_refused_and_a_token_opens() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &[]);
    assert!(get(viewing.host(), "/", "Host: evil.example\r\n").starts_with("HTTP/1.1 403 "));
    for origin in ["https://evil.example", "null"] {
        assert!(
            Page::open(&viewing.url, Some(origin), PROTOCOL).is_err(),
            "{origin}"
        );
    }
    let own = viewing.url.trim_end_matches('/');
    assert!(Page::open(&viewing.url, Some(own), PROTOCOL).is_ok());
    assert!(Page::open(&viewing.url, None, "unknown.v1").is_err());
    viewing.end();

    let open = Viewing::start(&bench, &["--listen", "0.0.0.0"]);
    let port = open.host().rsplit(':').next().expect("a port");
    let token = open
        .url
        .trim_end_matches('/')
        .rsplit('/')
        .next()
        .expect("a token");
    assert_eq!(token.len(), 32);
    let here = format!("127.0.0.1:{port}");
    let local = format!("Host: {here}\r\n");
    assert!(get(&here, "/", &local).starts_with("HTTP/1.1 403 "));
    assert!(get(&here, &format!("/{token}/"), &local).starts_with("HTTP/1.1 200 "));
    assert!(Page::open(&format!("http://{here}/"), None, PROTOCOL).is_err());
    let address = format!("http://{here}/{token}/");
    assert!(Page::open(&address, Some("https://elsewhere.example"), PROTOCOL).is_ok());
    open.end();
}

#[test]
fn what_is_no_request_harms_nobody_else() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    // One that says nothing, one that stops in the middle, nonsense, and one that never reads.
    let silent = TcpStream::connect(viewing.host()).expect("it listens");
    let mut half = TcpStream::connect(viewing.host()).expect("it listens");
    half.write_all(b"GET / HT").expect("sent");
    let mut nonsense = TcpStream::connect(viewing.host()).expect("it listens");
    nonsense.write_all(&[0xff; 3000]).expect("sent");
    let mut deaf = Page::of(&viewing);
    (0..20).for_each(|_| deaf.ask());
    for _ in 0..3 {
        page.ask();
        page.moment();
    }
    // A flood ends the connection that makes it.
    let mut flood = Page::of(&viewing);
    let is_ended = (0..100_000).any(|_| flood.0.send(Message::text("{}")).is_err());
    assert!(is_ended);
    page.ask();
    page.moment();
    drop((silent, half, nonsense, deaf));
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn a_chain_with_a_page_beside_it_takes_it_along() {
    let bench = Bench::new();
    for signal in [Signal::INT, Signal::KILL] {
        let mut chain = bench.start(&["--rig", "cell", "--view"]);
        chain.wait_for_frames();
        let url = url_in(&mut chain.introduction.as_bytes());
        assert!(
            get(host(&url), "/", &format!("Host: {}\r\n", host(&url))).starts_with("HTTP/1.1 200 ")
        );
        chain.signal_chain(signal);
        chain.end();
        let deadline = std::time::Instant::now() + PATIENCE;
        while TcpStream::connect(host(&url)).is_ok() {
            assert!(
                std::time::Instant::now() < deadline,
                "the page is still served"
            );
        }
    }
}

#[test]
fn a_port_that_is_taken_is_said() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &[]);
    let port = viewing.host().rsplit(':').next().expect("a port");
    let output = bench.run(&["view", "--port", port]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && said.contains("in use"),
        "{said}"
    );
    let output = bench.run(&["view", "--listen", "203.0.113.9"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && said.contains("no address of this machine"),
        "{said}"
    );
    viewing.end();
}

//! What a client may send to the page's server: anything.

use std::io::{Read, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;

use super::input::Input;

/// Stands in an address that opens everything.
const TOKEN: &str = "0123456789abcdef";

/// A connection to the page's server: bytes as they are; or, after an opening that is let in, messages of the page or of Foxglove,
/// each in a frame of any kind and length. It is answered by HTTP or ended, and nothing is waited for once the client has ended.
///
/// # Panics
/// Something does not hold.
pub fn front(bytes: &[u8]) {
    let mut input = Input(bytes);
    let sent = match input.byte() {
        0..64 => input.rest().to_vec(),
        64..128 => opened("lariat.view.v1", &mut input),
        128..192 => opened("foxglove.websocket.v1", &mut input),
        _ => [
            opened("lariat.view.v1, foxglove.sdk.v1", &mut Input(&[])),
            input.rest().to_vec(),
        ]
        .concat(),
    };
    let (server, mut client) = UnixStream::pair().expect("two ends");
    server.set_nonblocking(true).expect("a socket");
    client
        .write_all(&sent)
        .expect("there is room for so few bytes");
    client.shutdown(Shutdown::Write).expect("a socket");
    lariat_view::serve(server, TOKEN);
    let mut answer = Vec::new();
    client.read_to_end(&mut answer).expect("readable");
    assert!(
        answer.starts_with(b"HTTP/1.1 "),
        "{}",
        answer.escape_ascii()
    );
}

/// A WebSocket's opening, and frames that the rest of the input makes.
fn opened(protocol: &str, input: &mut Input) -> Vec<u8> {
    let mut sent = format!(
        "GET /{TOKEN}/live HTTP/1.1\r\nHost: robot\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: {protocol}\r\n\r\n"
    )
    .into_bytes();
    while !input.is_empty() {
        let [kind, length] = input.bytes();
        let payload = input.take(length.into());
        // Half are whole texts; the others are what their first byte says: whole files, pings, what there is not.
        sent.push(if kind < 128 { 0x81 } else { kind });
        match payload.len() {
            short @ ..126 => sent.push(0x80 | short as u8),
            long => {
                sent.push(0x80 | 126);
                sent.extend((long as u16).to_be_bytes());
            }
        }
        // A client's bytes are masked: here by zeros, which change nothing.
        sent.extend([0; 4]);
        sent.extend(payload);
    }
    sent
}

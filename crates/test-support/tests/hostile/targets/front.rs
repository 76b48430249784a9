//! Arbitrary bytes that a client may send to the page's server.

use std::io::{Read, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;

use super::input::Input;

/// Token in an address that gives full access.
const TOKEN: &str = "0123456789abcdef";

/// Opens a connection to the page's server and sends raw bytes, or messages of the page or of
/// Foxglove after an accepted handshake. Each message is in a frame of any kind and length. The
/// server answers by HTTP or closes the connection, and waits for nothing once the client has
/// closed it.
///
/// # Panics
/// Panics if an invariant does not hold.
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

/// A WebSocket handshake, and frames made from the rest of the input.
fn opened(protocol: &str, input: &mut Input) -> Vec<u8> {
    let mut sent = format!(
        "GET /{TOKEN}/live HTTP/1.1\r\nHost: robot\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: {protocol}\r\n\r\n"
    )
    .into_bytes();
    while !input.is_empty() {
        let [kind, length] = input.bytes();
        let payload = input.take(length.into());
        // Half of the frames are complete texts. The first byte selects the kind of the others:
        // whole files, pings, or invalid kinds.
        sent.push(if kind < 128 { 0x81 } else { kind });
        match payload.len() {
            short @ ..126 => sent.push(0x80 | short as u8),
            long => {
                sent.push(0x80 | 126);
                sent.extend((long as u16).to_be_bytes());
            }
        }
        // A client must mask its bytes; zeros as a mask change nothing.
        sent.extend([0; 4]);
        sent.extend(payload);
    }
    sent
}

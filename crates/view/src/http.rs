//! The small part of HTTP/1.1 that a page and the opening of a WebSocket need. One request's head
//! comes in and one answer goes out. Then the connection ends, or becomes a WebSocket.

use std::fmt::Write as _;

use base64::prelude::{BASE64_STANDARD, Engine};
use sha1_smol::Sha1;

/// Maximum length of a request's head in bytes. Browsers send a few hundred.
pub(crate) const LARGEST_HEAD: usize = 16 << 10;
/// Maximum number of header lines.
const MOST_HEADERS: usize = 64;

/// The relevant parts of a request.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Request {
    /// Path that is requested, from the first `/` up to a `?`.
    pub(crate) path: String,
    pub(crate) host: Option<String>,
    pub(crate) origin: Option<String>,
    /// The WebSocket's key, if the request asks for one.
    pub(crate) key: Option<String>,
    /// Protocols that the client offers for the WebSocket, the preferred one first.
    pub(crate) protocols: Vec<String>,
    /// True if only the head of the answer is requested.
    pub(crate) is_head: bool,
}

/// Answer that refuses a request: a status and a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Refusal(pub(crate) u16, pub(crate) &'static str);

impl Request {
    /// Parses a head. Returns the request and the number of bytes; `None` if more is to come.
    ///
    /// # Errors
    /// Fails if this server does not answer such a request.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, Refusal> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut head = httparse::Request::new(&mut headers);
        let length = match head.parse(bytes) {
            Ok(httparse::Status::Complete(length)) => length,
            Ok(httparse::Status::Partial) if bytes.len() < LARGEST_HEAD => return Ok(None),
            Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
                return Err(Refusal(431, "The request's head is too large."));
            }
            Err(_) => return Err(Refusal(400, "This is no HTTP request.")),
        };
        let is_head = match head.method {
            Some("GET") => false,
            Some("HEAD") => true,
            _ => return Err(Refusal(405, "Only GET is answered here.")),
        };
        let target = head.path.unwrap_or_default();
        let path = target.split(['?', '#']).next().unwrap_or_default();
        let mut request = Self {
            path: path.to_owned(),
            is_head,
            ..Self::default()
        };
        let (mut upgrade, mut version, mut key) = (false, false, None);
        for header in head.headers {
            let Ok(value) = str::from_utf8(header.value) else {
                return Err(Refusal(400, "A line of the request's head is not text."));
            };
            let value = value.trim();
            let name = header.name.to_ascii_lowercase();
            match name.as_str() {
                "host" if request.host.is_some() => {
                    return Err(Refusal(400, "The request names two hosts."));
                }
                "host" => request.host = Some(value.to_owned()),
                "origin" => request.origin = Some(value.to_owned()),
                "upgrade" => upgrade = value.eq_ignore_ascii_case("websocket"),
                "sec-websocket-version" => version = value == "13",
                "sec-websocket-key" => key = Some(value.to_owned()),
                "sec-websocket-protocol" => {
                    let names = value.split(',').map(|name| name.trim().to_owned());
                    request.protocols.extend(names);
                }
                "content-length" if value != "0" => {
                    return Err(Refusal(413, "A request has no body here."));
                }
                "transfer-encoding" => {
                    return Err(Refusal(413, "A request has no body here."));
                }
                _ => {}
            }
        }
        if upgrade {
            if !version {
                return Err(Refusal(426, "WebSockets are spoken in version 13 here."));
            }
            request.key = key.filter(|key| key.len() == 24);
            if request.key.is_none() {
                return Err(Refusal(400, "The WebSocket's key is missing."));
            }
        }
        Ok(Some((request, length)))
    }
}

const fn reason(status: u16) -> &'static str {
    match status {
        101 => "Switching Protocols",
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        413 => "Content Too Large",
        426 => "Upgrade Required",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Error",
    }
}

/// Policy: the page loads nothing from elsewhere, and no other page may embed it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Returns an answer after which the connection ends.
pub(crate) fn answer(status: u16, kind: &str, body: &[u8], is_head: bool) -> Vec<u8> {
    let mut head = format!("HTTP/1.1 {status} {}\r\n", reason(status));
    let _ = write!(
        head,
        "Content-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nContent-Security-Policy: {POLICY}\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Connection: close\r\n\r\n",
        body.len()
    );
    let mut bytes = head.into_bytes();
    if !is_head {
        bytes.extend_from_slice(body);
    }
    bytes
}

impl Refusal {
    pub(crate) fn answer(&self) -> Vec<u8> {
        let Self(status, sentence) = self;
        answer(
            *status,
            "text/plain; charset=utf-8",
            format!("{sentence}\n").as_bytes(),
            false,
        )
    }
}

/// Returns the answer that opens a WebSocket.
pub(crate) fn switch(key: &str, protocol: &str) -> Vec<u8> {
    // RFC 6455, section 4.2.2.
    let digest = Sha1::from(format!("{key}258EAFA5-E914-47DA-95CA-C5AB0DC85B11")).digest();
    let accept = BASE64_STANDARD.encode(digest.bytes());
    format!(
        "HTTP/1.1 101 {}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n\
         Sec-WebSocket-Protocol: {protocol}\r\n\r\n",
        reason(101)
    )
    .into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Option<(Request, usize)>, u16> {
        Request::parse(text.as_bytes()).map_err(|refusal| refusal.0)
    }

    #[test]
    fn a_pages_request_is_read_and_what_follows_it_is_left() {
        let text = "GET /page.js?x=1 HTTP/1.1\r\nHost: localhost:8765\r\n\r\nmore";
        let (request, length) = parsed(text).unwrap().unwrap();
        assert_eq!(request.path, "/page.js");
        assert_eq!(request.host.as_deref(), Some("localhost:8765"));
        assert_eq!(&text[length..], "more");
        assert_eq!(parsed("GET / HTTP/1.1\r\nHost: a"), Ok(None));
    }

    #[test]
    fn a_websockets_opening_has_its_key_and_protocols() {
        let head =
            "GET /live HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n";
        let key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
        let (request, _) = parsed(&format!(
            "{head}{key}Sec-WebSocket-Protocol: a, b\r\nOrigin: http://a\r\n\r\n"
        ))
        .unwrap()
        .unwrap();
        assert_eq!(request.protocols, ["a", "b"]);
        assert_eq!(request.origin.as_deref(), Some("http://a"));
        // The example of RFC 6455.
        let answer = String::from_utf8(switch(&request.key.unwrap(), "a")).unwrap();
        assert!(answer.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{answer}");
        assert_eq!(parsed(&format!("{head}\r\n")), Err(400));
        let old = head.replace("13", "8");
        assert_eq!(parsed(&format!("{old}{key}\r\n")), Err(426));
    }

    #[test]
    fn what_is_no_request_for_this_server_is_refused() {
        for (text, status) in [
            ("\0\0\0", 400),
            ("POST / HTTP/1.1\r\n\r\n", 405),
            ("GET / HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc", 413),
            ("GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n", 413),
            ("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", 400),
        ] {
            assert_eq!(parsed(text), Err(status), "{text}");
        }
        let long = format!("GET /{} HTTP/1.1\r\n", "a".repeat(LARGEST_HEAD));
        assert_eq!(parsed(&long), Err(431));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "A: b\r\n".repeat(65));
        assert_eq!(parsed(&many), Err(431));
    }
}

//! Decides who may load the page, and who may change anything through it.
//!
//! A browser that shows another site's page can be made to connect to this machine. Then either
//! `Host` is a foreign name that was made to point here, or `Origin` is that of the foreign page.
//! Both must be our own. Whoever has the token may come from anywhere, as Foxglove's own page does.
//!
//! Every user of the machine can reach what listens on its loopback address. So without the token,
//! the other end must be a process of our own user (`peer`), as for joining the rig's domain.

use std::net::{IpAddr, SocketAddr};

use crate::http::{Refusal, Request};

/// Checks requests.
#[derive(Debug, Clone)]
pub(crate) struct Guard {
    /// Address that the server listens on.
    pub(crate) address: SocketAddr,
    /// First component of a path that opens everything.
    pub(crate) token: String,
}

/// Permissions of an admitted request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Admitted {
    /// Path after the token, without the first `/`.
    pub(crate) path: String,
    /// True if the request may change anything: it comes from our own page, or has the token.
    pub(crate) may_write: bool,
}

impl Guard {
    /// Checks a request. `is_of_this_user` returns whether it comes from the user that the server
    /// runs as.
    ///
    /// # Errors
    /// Fails if the request comes from elsewhere, or lacks a token that is required.
    pub(crate) fn admit(
        &self,
        request: &Request,
        is_of_this_user: impl FnOnce() -> bool,
    ) -> Result<Admitted, Refusal> {
        let path = request.path.strip_prefix('/').unwrap_or(&request.path);
        let (first, rest) = path.split_once('/').unwrap_or((path, ""));
        let has_token = is_same(first, &self.token);
        let path = if has_token { rest } else { path }.to_owned();
        if !has_token && !self.address.ip().is_loopback() {
            return Err(Refusal(
                403,
                "The token is missing: open the address as `lariat view` has printed it.",
            ));
        }
        let host = request.host.as_deref().unwrap_or_default();
        if !has_token && !self.is_ours(host) {
            return Err(Refusal(
                403,
                "This name is not the server's: open the address as `lariat view` has printed it.",
            ));
        }
        let own_origin = request.origin.as_deref().map(|origin| {
            origin
                .strip_prefix("http://")
                .is_some_and(|from| from.eq_ignore_ascii_case(host))
        });
        if own_origin == Some(false) && !has_token {
            return Err(Refusal(
                403,
                "Another site's page asks for this: add the token that `lariat view` has printed to the address.",
            ));
        }
        if !has_token && !is_of_this_user() {
            return Err(Refusal(
                403,
                "This page is another user's of this machine: it opens by the address with the token, which `lariat view -v` prints.",
            ));
        }
        Ok(Admitted {
            path,
            may_write: has_token || own_origin == Some(true),
        })
    }

    /// Returns whether a `Host` is this machine's own name for itself, with our port.
    fn is_ours(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.ends_with(']') => (name, port.parse().ok()),
            _ => (host, Some(80)),
        };
        let name = name.trim_start_matches('[').trim_end_matches(']');
        let is_here = name.eq_ignore_ascii_case("localhost")
            || name.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback());
        is_here && port == Some(self.address.port())
    }
}

/// Compares two texts, in a time that does not reveal how much of them is the same.
fn is_same(a: &str, b: &str) -> bool {
    a.len() == b.len()
        && !b.is_empty()
        && a.bytes()
            .zip(b.bytes())
            .fold(0, |all, (a, b)| all | (a ^ b))
            == 0
}

/// Returns 128 random bits, as a component of a path.
pub(crate) fn token() -> std::io::Result<String> {
    use std::io::Read as _;
    let mut bytes = [0; 16];
    std::fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn admit(listen: &str, path: &str, host: &str, origin: Option<&str>) -> Option<Admitted> {
        admit_user(true, listen, path, host, origin)
    }

    fn admit_user(
        is_ours: bool,
        listen: &str,
        path: &str,
        host: &str,
        origin: Option<&str>,
    ) -> Option<Admitted> {
        let guard = Guard {
            address: listen.parse().unwrap(),
            token: "0123".into(),
        };
        let request = Request {
            path: path.into(),
            host: Some(host.into()),
            origin: origin.map(Into::into),
            ..Request::default()
        };
        guard.admit(&request, || is_ours).ok()
    }

    #[test]
    fn this_machine_needs_no_token_and_writes_from_its_own_page_only() {
        let here = "127.0.0.1:8765";
        for host in [
            "127.0.0.1:8765",
            "localhost:8765",
            "LOCALHOST:8765",
            "[::1]:8765",
        ] {
            let admitted = admit(here, "/live", host, None).expect(host);
            assert_eq!(
                (admitted.path.as_str(), admitted.may_write),
                ("live", false)
            );
            let own = format!("http://{host}");
            assert!(
                admit(here, "/live", host, Some(&own))
                    .expect(host)
                    .may_write
            );
        }
    }

    #[test]
    fn another_user_needs_the_token() {
        let (here, host) = ("127.0.0.1:8765", "localhost:8765");
        let own = Some("http://localhost:8765");
        assert_eq!(admit_user(false, here, "/live", host, own), None);
        assert_eq!(admit_user(false, here, "/", host, None), None);
        let admitted = admit_user(false, here, "/0123/live", host, own).unwrap();
        assert!(admitted.may_write);
    }

    #[test]
    fn another_sites_page_and_another_name_are_refused() {
        let here = "127.0.0.1:8765";
        for host in [
            "evil.example:8765",
            "127.0.0.1.evil.example:8765",
            "192.168.0.5:8765",
            "127.0.0.1:80",
            "localhost",
            "",
        ] {
            assert_eq!(admit(here, "/", host, None), None, "{host}");
        }
        for origin in [
            "https://evil.example",
            "null",
            "http://localhost:1",
            "https://localhost:8765",
            "",
        ] {
            assert_eq!(
                admit(here, "/live", "localhost:8765", Some(origin)),
                None,
                "{origin}"
            );
        }
    }

    #[test]
    fn from_elsewhere_nothing_is_had_without_the_token_and_everything_with_it() {
        let open = "0.0.0.0:8765";
        assert_eq!(admit(open, "/", "192.168.0.5:8765", None), None);
        assert_eq!(admit(open, "/0124/", "192.168.0.5:8765", None), None);
        assert_eq!(admit(open, "//live", "192.168.0.5:8765", None), None);
        for listen in [open, "127.0.0.1:8765"] {
            let admitted = admit(
                listen,
                "/0123/live",
                "robot:8765",
                Some("https://app.example"),
            )
            .unwrap();
            assert_eq!((admitted.path.as_str(), admitted.may_write), ("live", true));
        }
    }
}

//! The command: its listening address, and the page next to a chain.

use std::net::TcpStream;

use rustix::process::Signal;

use crate::page::PATIENCE;
use crate::rig::Bench;
use crate::viewing::{Viewing, get, host, url_in};

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
        !output.status.success() && said.contains("not an address of this machine"),
        "{said}"
    );
    viewing.end();
}

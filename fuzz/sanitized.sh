#!/usr/bin/env bash
# The short run of the messages' fuzz targets under AddressSanitizer, by the stable compiler, whose standard library is not
# sanitized but links with what is. `LARIAT_HOSTILE_INPUTS=100000 fuzz/sanitized.sh` takes longer.
set -euo pipefail
cd "$(dirname "$0")/.."

export RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address
# What the transport keeps as long as its process lives is no leak.
export ASAN_OPTIONS=detect_leaks=0
# Only what is said to be for the target is sanitized: not what runs while it is built.
target=$(rustc -vV | sed -n 's/^host: //p')
cargo test --locked -p lariat-test-support --test hostile --target "$target" --target-dir target/sanitized "$@"

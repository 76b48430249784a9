#!/usr/bin/env bash
# Runs the fuzz targets of messages briefly under AddressSanitizer, with the stable compiler. Its
# standard library is not sanitized but links with sanitized code.
# `LARIAT_HOSTILE_INPUTS=100000 fuzz/sanitized.sh` runs longer.
set -euo pipefail
cd "$(dirname "$0")/.."

export RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address
# The transport keeps some memory for the life of its process, which is not a leak.
export ASAN_OPTIONS=detect_leaks=0
# With --target, only code for the target is sanitized, and not the code that runs during the build.
target=$(rustc -vV | sed -n 's/^host: //p')
cargo test --locked -p lariat-test-support --test hostile --target "$target" --target-dir target/sanitized "$@"

#!/usr/bin/env bash
# The Python package as a user has it: installed by pip into an environment of its own, its types checked, its tests and
# examples run beside the real chain. Rust is built unoptimized into cargo's own target folder.
set -euo pipefail
cd "$(dirname "$0")/.."

target=${CARGO_TARGET_DIR:-target}
python=$target/python/bin/python
[ -x "$python" ] || python3 -m venv "$target/python"

# In one call, as the workspace's tests build them: nothing is compiled twice.
cargo build --locked --workspace --bins --examples
MATURIN_PEP517_ARGS="--profile dev --locked" "$python" -m pip install --quiet --disable-pip-version-check \
    ./python pytest mypy matplotlib pillow

bin=$(realpath --no-symlinks "$target/python/bin")
cd python
"$bin/mypy" lariat tests bench ../examples/python
# What is said of the Rust half's types is what they are.
(cd / && "$bin/stubtest" lariat._native)
# Not `python -m pytest`, which would find the package's source here before what is installed.
"$bin/pytest" --quiet -p no:cacheprovider "$@"

#!/usr/bin/env bash
# Tests the Python package in its own environment: checks its types, and runs its tests and examples
# with the real chain. The Rust half comes from the workspace's unoptimized build, in cargo's target
# folder. With `--pip` as the first argument, the package is installed as a user installs it. This
# builds the Rust half again, and tests pyproject.toml too.
set -euo pipefail
cd "$(dirname "$0")/.."

target=${CARGO_TARGET_DIR:-target}
python=$target/python/bin/python
[ -x "$python" ] || python3 -m venv "$target/python"
install=("$python" -m pip install --quiet --disable-pip-version-check numpy pytest mypy matplotlib pillow)

# One call with the same packages as in the workspace's tests, so that nothing is compiled twice.
cargo build --locked --workspace --bins --examples --lib
if [ "${1:-}" = --pip ]; then
    shift
    MATURIN_PEP517_ARGS="--profile dev --locked" "${install[@]}" ./python
else
    "${install[@]}"
    package=$("$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/lariat
    rm -rf "$package" "$package"-*.dist-info
    cp -r python/lariat "$package"
    cp "$target/debug/lib_native.so" "$package/_native.abi3.so"
fi

bin=$(realpath --no-symlinks "$target/python/bin")
cd python
"$bin/mypy" lariat tests bench ../examples/python
# The stub's types must be those of the Rust half.
(cd / && "$bin/stubtest" lariat._native)
# Not `python -m pytest`, which would find the package's source here before the installed package.
"$bin/pytest" --quiet -p no:cacheprovider "$@"

#!/usr/bin/env bash
# The Python package in an environment of its own: its types checked, its tests and examples run beside the real chain.
# The Rust half is the one that the workspace's build makes, unoptimized, in cargo's own target folder. `--pip`, first,
# installs the package as a user does instead, which builds that half once more: what pyproject.toml says is tested then.
set -euo pipefail
cd "$(dirname "$0")/.."

target=${CARGO_TARGET_DIR:-target}
python=$target/python/bin/python
[ -x "$python" ] || python3 -m venv "$target/python"
install=("$python" -m pip install --quiet --disable-pip-version-check numpy pytest mypy matplotlib pillow)

# In one call, as the workspace's tests build them: nothing is compiled twice.
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
# What is said of the Rust half's types is what they are.
(cd / && "$bin/stubtest" lariat._native)
# Not `python -m pytest`, which would find the package's source here before what is installed.
"$bin/pytest" --quiet -p no:cacheprovider "$@"

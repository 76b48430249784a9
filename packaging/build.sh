#!/usr/bin/env bash
# Builds the distributed artifacts in target/packaging: two Debian packages and a wheel. Needs a
# Rust toolchain, python3 with venv, dpkg and strip; fetches cargo-deb, cargo-cyclonedx and maturin
# if they are missing. How to install the artifacts: docs/install.md.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$PWD/target/packaging
tools=$PWD/target/packaging-tools
rm -rf "$out"
mkdir -p "$out" "$tools"
export PATH=$tools/bin:$PATH
for tool in cargo-deb cargo-cyclonedx; do
    command -v "$tool" >/dev/null || cargo install --locked --root "$tools" "$tool"
done
if ! command -v maturin >/dev/null; then
    python3 -m venv "$tools/python"
    "$tools/python/bin/pip" install --quiet 'maturin>=1.9,<2'
    export PATH=$PATH:$tools/python/bin
fi

# Writes the bill of materials of a binary, as CycloneDX: sbom FOLDER OF THE MANIFEST FILE
sbom() {
    cargo cyclonedx --format json --all-features --manifest-path "$1/Cargo.toml" --override-filename sbom
    sed "s#file://$PWD#file://#g" "$1/sbom.json" >"$2"
    # cargo-cyclonedx writes one file for each crate of the workspace.
    find . -name sbom.json -not -path './target/*' -delete
}

# The product with every picture format and its terminal screen, and the program that measures it;
# they share compiled dependencies.
cargo build --release --locked --package lariat --package lariat-top --features lariat/tiff,lariat/webp
cargo build --release --locked --manifest-path bench/Cargo.toml
root=$out/root
share=$root/usr/share
lariat=$root/usr/bin/lariat
top=$root/usr/bin/lariat-top
bench=$root/usr/bin/lariat-bench
mkdir -p "${lariat%/*}" "$share"/{man/man1,bash-completion/completions,zsh/vendor-completions,fish/vendor_completions.d,doc/lariat}
strip -o "$lariat" target/release/lariat
strip -o "$top" target/release/lariat-top
strip -o "$bench" target/release/lariat-bench
"$lariat" man "$share/man/man1" --force
"$lariat" completions bash >"$share/bash-completion/completions/lariat"
"$lariat" completions zsh >"$share/zsh/vendor-completions/_lariat"
"$lariat" completions fish >"$share/fish/vendor_completions.d/lariat.fish"
"$lariat" service install --root "$root"
packaging/licences.py --notices lariat >"$share/doc/lariat/notices"
packaging/licences.py --notices lariat-top >"$share/doc/lariat/notices-top"
packaging/licences.py --notices lariat-bench --manifest-path bench/Cargo.toml >"$share/doc/lariat/notices-bench"
sbom . "$share/doc/lariat/sbom.json"
sbom crates/top "$share/doc/lariat/sbom-top.json"
sbom bench "$share/doc/lariat/sbom-bench.json"
cp CHANGELOG.md "$share/doc/lariat/NEWS"
gzip -9n "$share"/doc/lariat/*
cargo deb --locked --no-build --no-strip --output "$out"

# `lariat ros2`, for users with a ROS graph; nobody else installs its dependencies.
ros2=crates/ros2/Cargo.toml
cargo build --release --locked --manifest-path "$ros2" --target-dir target/ros2
root=$out/ros2
mkdir -p "$root"/usr/{bin,share/doc/lariat-ros2}
strip -o "$root/usr/bin/lariat-ros2" target/ros2/release/lariat-ros2
packaging/licences.py --notices lariat-ros2 --manifest-path "$ros2" >"$root/usr/share/doc/lariat-ros2/notices"
sbom crates/ros2 "$root/usr/share/doc/lariat-ros2/sbom.json"
gzip -9n "$root"/usr/share/doc/lariat-ros2/*
cargo deb --locked --no-build --no-strip --manifest-path "$ros2" --output "$out"

# The module and the commands: maturin puts the files of this folder into pip's folder of scripts.
# They are copied only here, so that a build of the module from source does not need the command.
scripts=python/lariat._native.data/scripts
trap 'rm -rf python/lariat._native.data' EXIT
mkdir -p "$scripts"
cp "$lariat" "$top" "$bench" "$scripts/"
# It runs with the glibc that the command needs; maturin checks that the module needs no newer one.
glibc=$(objdump -T "$lariat" | grep -o 'GLIBC_2\.[0-9]*' | sort --version-sort | tail -n 1)
maturin build --release --locked --strip --compatibility "manylinux_2_${glibc#*.}" --manifest-path python/Cargo.toml --out "$out"

ls -l "$out"/*.deb "$out"/*.whl

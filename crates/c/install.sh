#!/bin/sh
# Installs lariat for C and C++: the header, the shared and the static library, and their files for
# pkg-config and CMake.
#
#     crates/c/install.sh --prefix /usr/local       # or ~/.local; respects DESTDIR
#     crates/c/install.sh --prefix DIR --from DIR   # libraries that are already built, such as in target/release
set -eu

prefix=/usr/local
from=
while [ $# -gt 0 ]; do
    case "$1" in
        --prefix) prefix=${2:?--prefix takes a folder}; shift 2 ;;
        --from) from=${2:?--from takes a folder with liblariat.so and liblariat.a}; shift 2 ;;
        *) echo "install.sh: $1 is none of --prefix DIR, --from DIR" >&2; exit 2 ;;
    esac
done
case "$prefix" in /*) ;; *) prefix=$PWD/$prefix ;; esac
case "$from" in /* | '') ;; *) from=$PWD/$from ;; esac

cd "$(dirname "$0")"
if [ -z "$from" ]; then
    cargo build --release --locked -p lariat-c
    from=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/release
fi
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' ../../Cargo.toml)
abi=$(sed -n 's/^#define LARIAT_ABI \([0-9]*\).*/\1/p' include/lariat.h)

lib=${DESTDIR:-}$prefix/lib
mkdir -p "${DESTDIR:-}$prefix/include" "$lib/pkgconfig" "$lib/cmake/lariat"
install -m 644 include/lariat.h "${DESTDIR:-}$prefix/include/"
install -m 755 "$from/liblariat.so" "$lib/liblariat.so.$abi"
ln -sf "liblariat.so.$abi" "$lib/liblariat.so"
install -m 644 "$from/liblariat.a" "$lib/"
fill() { sed -e "s|@PREFIX@|$prefix|g" -e "s|@VERSION@|$version|g" -e "s|@ABI@|$abi|g" "$1"; }
fill lariat.pc.in > "$lib/pkgconfig/lariat.pc"
for file in lariat-config lariat-config-version; do
    fill "$file.cmake.in" > "$lib/cmake/lariat/$file.cmake"
done
echo "lariat $version is in $prefix. Where that is not searched: PKG_CONFIG_PATH=$prefix/lib/pkgconfig," \
    "LD_LIBRARY_PATH=$prefix/lib, CMAKE_PREFIX_PATH=$prefix"

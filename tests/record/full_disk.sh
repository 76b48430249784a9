#!/bin/sh
# Records onto a disk that fills up: a small tmpfs. The chain must continue, the file must be closed
# properly, and the fault must be reported.
#
#     tests/record/full_disk.sh [LARIAT [PYTHON]]
#
# Needs root, or the right to create a user namespace. LARIAT: the binary (default:
# target/release/lariat). PYTHON: if given, also reads the recordings (see read.py).
set -eu
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
lariat=$(realpath "${1:-${CARGO_TARGET_DIR:-$here/../../target}/release/lariat}")
python=${2:-}
if [ "${LARIAT_FULL_DISK:-}" != inside ]; then
    # A separate mount namespace, so that nothing is left whatever happens.
    if [ "$(id -u)" = 0 ]; then
        LARIAT_FULL_DISK=inside exec unshare -m "$0" "$lariat" "$python"
    fi
    LARIAT_FULL_DISK=inside exec unshare -rm "$0" "$lariat" "$python"
fi
export LARIAT_DOMAIN="full-$$"
disk=$(mktemp -d)
mount -t tmpfs -o size=24m tmpfs "$disk"
trap 'umount "$disk"; rmdir "$disk"' EXIT
fail() {
    echo "full_disk.sh: $1"
    cat "$disk/../$(basename "$disk").said" 2>/dev/null || true
    exit 1
}
said=/tmp/$(basename "$disk").said
for delivery in "" --lossless; do
    code=0
    # shellcheck disable=SC2086 # Nothing, or one flag.
    "$lariat" run --fps 60 --frames 240 $delivery --record "$disk/run.mcap" >/dev/null 2>"$said" || code=$?
    [ $code = 1 ] || fail "the exit code is $code"
    grep -q 'run.mcap ends here, and all before it is in it: the disk is full' "$said" || fail "the recorder did not say why"
    grep -q 'the recorder failed .*; the chain continues without it' "$said" || fail "the chain did not say so"
    # The magic number at the end: the file was closed.
    [ "$(tail -c 8 "$disk/run.mcap" | od -An -c | tr -d ' ')" = '211MCAP0\r\n' ] || fail "the file was not closed"
    size=$(stat -c %s "$disk/run.mcap")
    [ "$size" -gt 15000000 ] || fail "only $size bytes of the disk were used"
    [ -z "$python" ] || "$python" "$here/read.py" "$disk/run.mcap"
    echo "full disk, ${delivery:-newest wins}: $size bytes, closed well; the chain went on"
    rm "$disk/run.mcap"
done
# Other files fill the disk while the ring is written; the ring continues.
"$lariat" run --fps 60 --duration 6s >/dev/null 2>&1 &
chain=$!
"$lariat" record --out "$disk/last.mcap" --ring 2s 2>"$said" &
recorder=$!
sleep 4
"$lariat" record --flush 2>/dev/null
for _ in 1 2 3 4 5 6 7 8 9 10; do
    grep -q 'the disk is full' "$said" && break
    sleep 0.5
done
grep -q 'last-.* ends here.*the disk is full.*; recording goes on' "$said" || fail "the ring did not say so"
kill -TERM $recorder
wait $recorder || fail "the ring did not go on"
wait $chain || fail "the chain did not go on"
echo "full disk, ring: closed well; recording went on"
rm -f "$said"

#!/bin/sh
# Records the rendered rope in every way, and has each recording read by the Python packages `mcap` and `mcap-ros2-support`.
#
#     tests/record/read.sh [PYTHON]
#
# PYTHON: an interpreter that has what requirements.txt names (default: python3). Builds and runs the release binary.
set -eu
python=${1:-python3}
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
cd "$here/../.."
cargo build --release --quiet
lariat=${CARGO_TARGET_DIR:-$PWD/target}/release/lariat
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export LARIAT_DOMAIN="read-$$"
cd "$folder"
for images in raw png jpeg none; do
    for compression in none lz4 zstd; do
        file=$images-$compression.mcap
        "$lariat" run --lossless --fps max --frames 60 --record "$file" --images "$images" --compression "$compression" \
            >/dev/null 2>said || { cat said; exit 1; }
        "$python" "$here/read.py" "$file" 60
    done
done
# Live, with a rig whose name is no ROS name, and a recorder of its own.
"$lariat" record --rig left-arm --out live.mcap 2>said &
recorder=$!
"$lariat" run --rig left-arm --fps 60 --frames 90 >/dev/null 2>&1
kill -TERM $recorder
wait $recorder || { cat said; exit 1; }
"$python" "$here/read.py" live.mcap
echo "all recordings were read"

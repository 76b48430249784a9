#!/bin/sh
# Records the rendered rope in every mode, and reads each recording with the Python packages `mcap`
# and `mcap-ros2-support`.
#
#     tests/record/read.sh [PYTHON [LARIAT]]
#
# PYTHON: an interpreter with the packages in requirements.txt (default: python3). LARIAT: the
# binary (default: the release build, which is built first).
set -eu
python=${1:-python3}
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
if [ -n "${2:-}" ]; then
    lariat=$(realpath "$2")
else
    cd "$here/../.."
    cargo build --release --quiet
    lariat=${CARGO_TARGET_DIR:-$PWD/target}/release/lariat
fi
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
# A lifted rope in color and depth. Its grippers are not part of it.
"$lariat" run --source simulated --depth simulated --lossless --fps 30 --frames 60 --record depth.mcap \
    --mask '[{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.1, 1] }]' >/dev/null 2>said || { cat said; exit 1; }
"$python" "$here/read.py" depth.mcap 60
# Live, with a rig name that is not a valid ROS name, and a separate recorder.
"$lariat" record --rig left-arm --out live.mcap 2>said &
recorder=$!
# The file is created once all channels are open.
while [ ! -e live.mcap ]; do sleep 0.1; done
"$lariat" run --rig left-arm --fps 60 --frames 90 >/dev/null 2>&1
kill -TERM $recorder
wait $recorder || { cat said; exit 1; }
"$python" "$here/read.py" live.mcap
echo "all recordings were read"

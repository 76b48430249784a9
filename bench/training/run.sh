#!/usr/bin/env bash
# Makes what the network learns from, and trains it: see README.md. What follows goes to train.py.
set -euo pipefail
cd "$(dirname "$0")"
source ./prepare.sh
# Training begins with the first ones.
(draw_scenes 32 || kill $$) &
drawing=$!
trap 'kill $drawing 2>/dev/null || true' EXIT
"$python" train.py --scenes cache/scenes --out cache/trained "$@"

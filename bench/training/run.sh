#!/usr/bin/env bash
# Generates the training data and trains the network: see README.md. The arguments are passed to
# train.py.
set -euo pipefail
cd "$(dirname "$0")"
source ./prepare.sh
# Training starts with the first files.
(draw_scenes 32 || kill $$) &
drawing=$!
trap 'kill $drawing 2>/dev/null || true' EXIT
"$python" train.py --scenes cache/scenes --out cache/trained "$@"

#!/usr/bin/env bash
# Makes what the network learns from, and trains it: see README.md.
set -euo pipefail
cd "$(dirname "$0")"
source ./prepare.sh 16
"$python" train.py --scenes cache/scenes --out cache/trained "$@"

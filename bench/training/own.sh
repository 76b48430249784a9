#!/usr/bin/env bash
# Continues the training of the network on the user's pictures: own.sh FOLDER WEIGHTS, see
# README.md.
set -euo pipefail
[ $# = 2 ] || { echo "Usage: bench/training/own.sh FOLDER WEIGHTS (FOLDER has images/ and labels/)" >&2; exit 2; }
own=$(realpath "$1") weights=$(realpath "$2")
cd "$(dirname "$0")"
source ./prepare.sh
draw_scenes 2
rm -rf cache/own # What is left of a training on other pictures.
"$python" train.py --scenes cache/scenes --out cache/own --own "$own" --begin ../crates/network/ropes.weights --files 2 --steps 1500
cp cache/own/ropes.weights "$weights"

# An environment for Python, backgrounds, and so many thousands of scenes, each made once. Sourced by run.sh and own.sh.
python=cache/python/bin/python
if [ ! -x "$python" ]; then
    python3 -m venv cache/python
    "$python" -m pip install -q -r requirements.txt
fi
[ -e cache/backgrounds/sources.tsv ] || "$python" backgrounds.py --out cache/backgrounds
cargo build --release --locked -p lariat-training
target=$(cargo metadata --no-deps --format-version 1 | "$python" -c 'import json, sys; print(json.load(sys.stdin)["target_directory"])')
mkdir -p cache/scenes
for k in $(seq -w 0 $(($1 - 1))); do
    [ -e "cache/scenes/$k.npy" ] ||
        "$target/release/lariat-scenes" --photographs cache/backgrounds --seed $((10#$k * 1000)) --count 1000 --out "cache/scenes/$k.npy"
done

# Creates the Python environment, the backgrounds and the scene generator once. Sourced by run.sh
# and own.sh.
python=cache/python/bin/python
if [ ! -x "$python" ]; then
    python3 -m venv cache/python
    "$python" -m pip install -q -r requirements.txt
fi
[ -e cache/backgrounds/sources.tsv ] || "$python" backgrounds.py --out cache/backgrounds
cargo build --release --locked -p lariat-training
target=$(cargo metadata --no-deps --format-version 1 | "$python" -c 'import json, sys; print(json.load(sys.stdin)["target_directory"])')
mkdir -p cache/scenes

# Draws this many files of a thousand scenes each.
draw_scenes() {
    for k in $(seq 0 $(($1 - 1))); do
        file=cache/scenes/$(printf %02d "$k").npy
        [ -e "$file" ] || "$target/release/lariat-scenes" --photographs cache/backgrounds --seed $((k * 1000)) --count 1000 --out "$file"
    done
}

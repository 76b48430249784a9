#!/usr/bin/env python3
"""Measures the figures of README.md and docs/figures.md, and writes one table into both.

    bench/figures.py                      some ten minutes, on an idle machine
    bench/figures.py --mbest FOLDER       also on mBEST's photographs: sets S1 and S2 with images and labels

The table is between two comments in each file. Rows that were not measured keep their figures.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FILES = ["README.md", "docs/figures.md"]
BEGIN = "<!-- bench/figures.py writes this table -->"
END = "<!-- end of the table -->"


def output(*command):
    print("$", *command, file=sys.stderr)
    return subprocess.run(list(map(str, command)), cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def bench(*words):
    return output("target/release/lariat-bench", *words)


def cells(line):
    return re.split(r"\s{2,}", line.strip())


def row(text, first):
    """Returns the cells of the first line that starts with `first`."""
    return next(cells(line) for line in text.splitlines() if line.startswith(first + " "))


def drawn():
    table = bench("accuracy", "--rendered").split("\n\n")[0].splitlines()[2:]
    rows = [[float(cell.rstrip("!")) for cell in cells(line)[1:4]] for line in table]
    # A wrong number of curves counts as the largest possible distance.
    distances = [distance for _, wrong, distance in rows if not wrong]
    pictures, wrong = (int(sum(row[column] for row in rows)) for column in (0, 1))
    yield (
        f"drawn ropes of {len(rows)} classes: mean distance from the truth; pictures with a wrong count of ropes",
        f"{min(distances):.2f} to {max(distances):.2f} px; {wrong} of {pictures:,}",
        "lariat-bench accuracy --rendered",
    )
    places, exchanged, frames, wrong = 0, 0, 0, 0.0
    for first in range(1000, 1100, 20):
        words = ["--story", "two", "--frames", 6000, "--seeds", 20, "--first-seed", first]
        for line in bench("tracking", *words).split("\n\n")[0].splitlines()[1:]:
            # The last 14 columns are numbers: frames, followed, right, shown, … exchanged, and five
            # more.
            count, _, right, shown, *_, told = line.split()[-14:-5]
            frames, wrong = frames + int(count), wrong + int(count) * (1 - float(right.rstrip("%")) / 100)
            places, exchanged = places + int(shown), exchanged + int(told)
    yield (
        "two tangled ropes in motion, 100 films: frames wrong; places of ropes out of order",
        f"{100 * wrong / frames:.1f} %; one of {places / exchanged:.0f}",
        "lariat-bench tracking --story two --frames 6000 --seeds 20 --first-seed 1000 … 1080",
    )


def live():
    with tempfile.TemporaryDirectory() as folder:
        output("target/release/lariat", "run", "--duration", "20s", "--out", folder, "--force")
        latency = json.loads((Path(folder) / "summary.json").read_text())["latency_us"]["total"]
    yield (
        "exposed → in your loop's hands, 30 frames/s: p50, p99",
        f"{latency['p50'] / 1000:.2f}, {latency['p99'] / 1000:.2f} ms",
        "lariat run --duration 20s",
    )
    words = ["run", "--fps", "max", "--lossless", "--frames", "3000"]
    rate = re.search(r"([\d.]+) frames/s", output("target/release/lariat", *words))[1]
    yield "frames in a second, nothing lost", f"{float(rate):,.0f}", "lariat " + " ".join(words)


def extraction():
    command = ["cargo", "bench", "--manifest-path", "bench/Cargo.toml", "--locked", "--bench", "extract", "--", "--quick"]
    # The first table holds times. The row below each gives them as a number of passes over the
    # frame's bytes.
    lines = output(*command).splitlines()
    at = {name: next(i for i, line in enumerate(lines) if line.startswith(name)) for name in ["cold, µs", "tracked, µs"]}
    (cold, cold_passes), (tracked, tracked_passes) = (
        [cells(lines[i + below])[6].rstrip("×") for below in (0, 1)] for i in at.values()
    )
    yield (
        "extraction, 640×480: followed / whole; the same in passes that only read the frame",
        f"{float(tracked):.0f} / {float(cold):.0f} µs; {tracked_passes} / {cold_passes} ×",
        "cargo bench --manifest-path bench/Cargo.toml --bench extract -- --quick",
    )


def photographs(mbest):
    if not mbest:
        return
    text = bench("accuracy", "--dataset", mbest)
    dice = [row(text, name)[2] for name in ["S1", "S2"]]
    command = "lariat-bench accuracy --dataset path/to/mbest"
    yield "photographs of mBEST, one rope / two ropes: DICE", " / ".join(f"{float(d):.3f}" for d in dice), command


def renew(path, rows):
    """Writes the rows into a file's table and returns its previous figures."""
    text = (ROOT / path).read_text()
    head, rest = text.split(BEGIN)
    table, tail = rest.split(END)
    merged = {}
    for line in table.strip().splitlines()[2:]:
        label, *others = [cell.strip() for cell in line.strip("|").split("|")]
        merged[label] = others
    # A new row replaces the row whose label is the same apart from numbers.
    like = lambda label: re.sub(r"\d+", "", label)
    for label, *others in rows:
        merged = {name: cells for name, cells in merged.items() if name == label or like(name) != like(label)}
        merged[label] = [others[0], f"`{others[1]}`"]
    lines = ["| | | |", "|---|---|---|", *(f"| {label} | {' | '.join(others)} |" for label, others in merged.items())]
    (ROOT / path).write_text(head + BEGIN + "\n" + "\n".join(lines) + "\n" + END + tail)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mbest", type=Path, metavar="FOLDER")
    mbest = parser.parse_args().mbest
    mbest = mbest and mbest.resolve()
    output("cargo", "build", "--release", "--locked")
    output("cargo", "build", "--release", "--locked", "--manifest-path", "bench/Cargo.toml")
    rows = [*photographs(mbest), *drawn(), *live(), *extraction()]
    for path in FILES:
        renew(path, rows)
    print("\n".join(f"{label}: {figure}" for label, figure, _ in rows))


if __name__ == "__main__":
    main()

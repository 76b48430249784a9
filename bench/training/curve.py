"""Plots the log of a training run: `curve.py LOG SVG`. Shows means over 1000 steps, and marks where
the learning rate starts to fall and where rounding starts.
"""

import argparse
import json
from pathlib import Path

import numpy as np

WIDTH, HEIGHT, MARGIN = 640, 240, 40
PARTS = {"overlap": "#d95f02", "rope": "#1b9e77", "seam": "#7570b3"}
LINES_OF_LOG = 5  # per mean


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", type=Path)
    parser.add_argument("svg", type=Path)
    parser.add_argument("--marks", type=int, nargs="*", default=[], help="steps at which something changes")
    args = parser.parse_args()
    lines = [json.loads(line) for line in args.log.read_text().splitlines()]
    lines = lines[: len(lines) // LINES_OF_LOG * LINES_OF_LOG]
    steps = np.array([line["step"] for line in lines])
    x = lambda step: MARGIN + (WIDTH - 2 * MARGIN) * step / steps[-1]
    y = lambda loss: HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * np.minimum(loss, 1)
    mean = lambda values: np.asarray(values).reshape(-1, LINES_OF_LOG).mean(1)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="11" fill="#555">']
    for loss in np.arange(0, 1.1, 0.2):
        out.append(f'<path d="M{MARGIN} {y(loss):.1f}H{WIDTH - MARGIN}" stroke="#ddd"/><text x="12" y="{y(loss) + 4:.1f}">{loss:.1f}</text>')
    for mark in args.marks:
        out.append(f'<path d="M{x(mark):.1f} {MARGIN}V{HEIGHT - MARGIN}" stroke="#999" stroke-dasharray="4"/>')
    for step in range(0, steps[-1] + 1, 20000):
        out.append(f'<text x="{x(step):.1f}" y="{HEIGHT - MARGIN + 16}" text-anchor="middle">{step}</text>')
    for k, (part, color) in enumerate(PARTS.items()):
        places = zip(x(mean(steps)), y(mean([line[part] for line in lines])))
        points = " ".join(f"{px:.1f},{py:.1f}" for px, py in places)
        out.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.5"/>')
        out.append(f'<text x="{MARGIN + 90 * k}" y="24" fill="{color}">{part}</text>')
    args.svg.write_text("\n".join([*out, "</svg>\n"]))


if __name__ == "__main__":
    main()

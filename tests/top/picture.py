#!/usr/bin/env python3
"""Converts a terminal's screen to an SVG picture with its colors: the picture of `lariat top` in
the README.

    lariat run --fps 60 --rig arm --basis bspline --control-points 13 --realtime &
    tmux -u new-session -d -x 80 -y 27 'lariat top'; sleep 10
    tmux capture-pane -ep | tests/top/picture.py > docs/top.svg

Braille, blocks and frames are drawn as shapes, so that the picture is the same with any fonts.
"""

import re
import sys
from xml.sax.saxutils import escape

CELL = (8.4, 17.0)
MARGIN = 14.0
BACKGROUND, FOREGROUND = "#14161b", "#d0d4dc"
# The sixteen colors of a terminal; 8 to 15 are the bright ones.
PALETTE = [
    "#14161b", "#e06c75", "#8cc265", "#e5c07b", "#6ca4ef", "#c678dd", "#4fc1c9", "#d0d4dc",
    "#737b8c", "#f0858e", "#a5d97f", "#f0d399", "#86b8ff", "#d99af0", "#70d8df", "#ffffff",
]
# Share of the background that a bar covers.
BARS = {"█": 1, "░": 0.35}
# Directions in which a frame's line leaves its cell: right, down, left, up.
FRAME = {"─": "rl", "│": "du", "┌": "rd", "┐": "dl", "└": "ru", "┘": "lu"}
# Dots of U+2800 by their bits: column and row.
DOTS = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3)]


def cells(text):
    """Each row as a list of (character, color, bold)."""
    colour, bold = FOREGROUND, False
    rows = []
    for line in text.rstrip("\n").split("\n"):
        row = []
        for codes, character in re.findall(r"\x1b\[([0-9;]*)m|([^\x1b])", line):
            if character:
                row.append((character, colour, bold))
                continue
            # 38;5;n is color n; ratatui uses the first sixteen. Other codes are backgrounds, which
            # are all plain here.
            for indexed, code in re.findall(r"38;5;(\d+)|(\d+)", codes or "0"):
                if indexed:
                    colour = PALETTE[int(indexed) % 16]
                elif code == "0":
                    colour, bold = FOREGROUND, False
                elif code in ("1", "22"):
                    bold = code == "1"
                elif code == "39":
                    colour = FOREGROUND
                elif 30 <= int(code) <= 37:
                    colour = PALETTE[int(code) - 30]
                elif 90 <= int(code) <= 97:
                    colour = PALETTE[int(code) - 82]
        rows.append(row)
    return rows


def shape(character, colour, x, y):
    """SVG of a character that is drawn as a shape; None for any other."""
    width, height = CELL
    if "\u2800" <= character <= "\u28ff":
        bits = ord(character) - 0x2800
        dots = (DOTS[bit] for bit in range(8) if bits >> bit & 1)
        return "".join(
            f'<circle cx="{x + (column + 0.5) * width / 2:.2f}" cy="{y + (row + 0.5) * height / 4:.2f}" r="1.55" '
            f'fill="{colour}"/>'
            for column, row in dots
        )
    if character in FRAME:
        middle = (x + width / 2, y + height / 2)
        ends = {"r": (x + width, middle[1]), "l": (x, middle[1]), "d": (middle[0], y + height), "u": (middle[0], y)}
        path = "".join(
            f"M{middle[0]:.2f} {middle[1]:.2f}L{ends[side][0]:.2f} {ends[side][1]:.2f}" for side in FRAME[character]
        )
        return f'<path d="{path}" stroke="{colour}" stroke-width="1"/>'
    if character in "●○":
        fill = colour if character == "●" else BACKGROUND
        return (
            f'<circle cx="{x + width / 2:.2f}" cy="{y + height / 2:.2f}" r="3.6" fill="{fill}" stroke="{colour}" '
            f'stroke-width="1.4"/>'
        )
    return None


def drawn(row, y):
    """SVG of a row: shapes, and between them runs of bars and of text in one style."""
    parts, run = [], None

    def write():
        nonlocal run
        if run and run[1][0] in BARS:
            start, text, colour, _ = run
            parts.append(
                f'<rect x="{MARGIN + start * CELL[0]:.2f}" y="{y + 2:.2f}" width="{len(text) * CELL[0]:.2f}" '
                f'height="{CELL[1] - 4:.2f}" fill="{colour}" fill-opacity="{BARS[text[0]]}"/>'
            )
        elif run:
            start, text, colour, bold = run
            weight = ' font-weight="bold"' if bold else ""
            # Word by word, so that fonts of other widths keep each word near its column.
            for word in re.finditer(r"\S+(?: \S+)*", text):
                x = MARGIN + (start + word.start()) * CELL[0]
                width = len(word[0]) * CELL[0]
                parts.append(
                    f'<text x="{x:.2f}" y="{y + 12.6:.2f}" fill="{colour}"{weight} textLength="{width:.2f}" '
                    f'lengthAdjust="spacingAndGlyphs">{escape(word[0])}</text>'
                )
        run = None

    for column, (character, colour, bold) in enumerate(row):
        figure = shape(character, colour, MARGIN + column * CELL[0], y)
        if figure is not None:
            write()
            parts.append(figure)
        elif run and run[2:] == (colour, bold) and (run[1][0] in BARS) == (character in BARS):
            run = (run[0], run[1] + character, colour, bold)
        else:
            write()
            run = (column, character, colour, bold)
    write()
    return "".join(parts)


def main():
    rows = cells(sys.stdin.read())
    columns = max(len(row) for row in rows)
    width, height = (2 * MARGIN + columns * CELL[0], 2 * MARGIN + len(rows) * CELL[1])
    print(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" '
        f'height="{height:.0f}" font-family="ui-monospace, SFMono-Regular, Menlo, Consolas, DejaVu Sans Mono, monospace" '
        f'font-size="13.5">'
    )
    print(f'<rect width="100%" height="100%" rx="8" fill="{BACKGROUND}"/>')
    for number, row in enumerate(rows):
        print(drawn(row, MARGIN + number * CELL[1]))
    print("</svg>")


if __name__ == "__main__":
    main()

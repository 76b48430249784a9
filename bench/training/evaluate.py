"""Evaluates weights on pictures of ropes:
`evaluate.py --weights FILE --images FOLDER [--labels FOLDER] [--masks FOLDER]`, see README.md.

Labels are PNGs of the same names, 0 where there is no rope. Prints the overlap (DICE) of
each mask with its label, and their mean. Writes masks for `lariat trace --masks`.
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from PIL import Image

import network
import pictures


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weights", type=Path, required=True)
    parser.add_argument("--images", type=Path, required=True)
    parser.add_argument("--labels", type=Path)
    parser.add_argument("--masks", type=Path, help="folder for the masks, 255 where a rope is surest")
    return parser.parse_args()


def found(weights, rgb):
    """Returns maps of ropes and of their seams, 0 to 1 (height, width each)."""
    height, width, _ = rgb.shape
    # The padding is gray, as in the kernels.
    padded = np.pad(rgb, ((0, -height % 16), (0, -width % 16), (0, 0)), constant_values=128)
    with torch.no_grad():
        maps = torch.sigmoid(weights(torch.as_tensor(padded, dtype=torch.float32).permute(2, 0, 1)[None]))
    return maps[0, :, :height, :width].numpy()


def main():
    args = arguments()
    weights = network.unpacked(args.weights.read_bytes())
    overlaps = []
    for file in pictures.files(args.images):
        rope, seam = found(weights, pictures.read(file))
        if args.masks:
            args.masks.mkdir(parents=True, exist_ok=True)
            mask = rope * (seam < 0.5)
            Image.fromarray(np.round(255 * mask).astype(np.uint8)).save(args.masks / f"{file.stem}.png")
        if args.labels:
            label = pictures.label(file, args.labels)
            overlaps.append(2 * ((rope > 0.5) & label).sum() / max(1, (rope > 0.5).sum() + label.sum()))
            print(f"{file.stem}\t{overlaps[-1]:.3f}")
    if overlaps:
        print(f"mean of {len(overlaps)}\t{np.mean(overlaps):.4f}")


if __name__ == "__main__":
    main()

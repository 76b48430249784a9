"""Photographs and their labels: PNGs of the same names, 0 where there is no rope."""

import numpy as np
from PIL import Image

KINDS = (".png", ".jpg", ".jpeg")


def files(folder):
    found = sorted(file for file in folder.iterdir() if file.suffix.lower() in KINDS) if folder.is_dir() else []
    if not found:
        raise SystemExit(f"{folder} holds no pictures: {', '.join(KINDS)} are read")
    return found


def read(file):
    return np.asarray(Image.open(file).convert("RGB"))


def label(picture, folder):
    """Returns the mask of a picture's ropes, from its label in a folder."""
    file = folder / f"{picture.stem}.png"
    if not file.exists():
        raise SystemExit(f"{picture} has no label: {file} is missing")
    levels = np.asarray(Image.open(file))
    mask = levels.any(-1) if levels.ndim == 3 else levels > 0
    sizes = Image.open(picture).size, mask.shape[::-1]
    if sizes[0] != sizes[1]:
        raise SystemExit("{} is {}×{} pixels, its label {}×{}".format(picture, *sizes[0], *sizes[1]))
    return mask

#!/usr/bin/env python3
"""Collects the openly licensed pictures that ropes are drawn over for training.

    pip install numpy pillow opencv-python-headless
    bench/training/backgrounds.py [--out FOLDER] [--clones FOLDER]

`backgrounds.tsv` next to this file lists the pictures. SOURCES below gives their origin and
license. The pictures are written to FOLDER as JPEG with a longer side of 400 to 1200 pixels.
`sources.tsv` in FOLDER lists file, source with its commit, license and author. All pictures come
from public repositories on GitHub at a fixed commit. They are downloaded file by file over HTTPS
(374 MB), or read from clones in the folder that `--clones` names. A clone is called OWNER+NAME and
may be bare.

Licenses: CC0, public domain, CC-BY, CC-BY-SA and MIT only. A license or an author in the table is
the picture's own. Without one, the source's applies. The OpenStax books state in each caption who
made a picture, and often its license. Where they state no license, the book's applies, CC-BY-4.0.
Some of these books have been CC-BY-NC-SA since 2026; the commits used here are the last ones before
that. Excluded are pictures whose captions say NC, ND, "permission" or "courtesy", and those from
Pexels, Pixabay or Unsplash without an open license.

Everything here is labeled as background, so no rope may be visible. Each picture was inspected.
Excluded are those with ropes, cables, wires, hoses, cords, laces, lanyards, leashes, strings,
chains, power lines, rigging, suspension bridges or wire fences, real or drawn. Included on purpose,
because they mislead a rope detector: branches, lightning, smoke, rails, seams, cracks, veins of
stone, handwriting, rivers on maps.
"""

import argparse
import re
import subprocess
import urllib.parse
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from PIL import Image

LONGEST_PX = 1200


class Source(NamedTuple):
    repository: str
    commit: str
    licence: str
    author: str


def book(name, commit):
    return Source(f"openstax/osbooks-{name}", commit, "CC-BY-4.0", "OpenStax")


SOURCES = {
    # Individual photographs from textbooks. License: the file LICENSE of each commit.
    "chemistry-bundle": book("chemistry-bundle", "32c719622fbb7a0ca729cd645c1df4cf4e7d5b3a"),
    "college-physics-bundle": book("college-physics-bundle", "f98d7a792138a6133fe7267d17e70aa04e9ccbed"),
    "college-success-bundle": book("college-success-bundle", "4c04b87eb2753872c2d442fe9736859ddb27bb72"),
    "contemporary-mathematics": book("contemporary-mathematics", "fa7c1a151783958fd2c114da66831e3d57ce2321"),
    "entrepreneurship": book("entrepreneurship", "c1fa2c872ba07dc864c3aeb5a510b08b4f657288"),
    "introduction-anthropology": book("introduction-anthropology", "418eedd9bef21ec1a6fa1b472c0d82c084e35c70"),
    "introduction-business": book("introduction-business", "78c9e7ad4e581d4ff98e78ea30214840e1fa7e1e"),
    "introduction-intellectual-property": book("introduction-intellectual-property", "be76c2d982080df077b6f7f7f784d0bbbc37ee8b"),
    "introduction-python-programming": book("introduction-python-programming", "d6d069bb24677a375aa28a574bd506d4b893cfdf"),
    "introduction-sociology": book("introduction-sociology", "d35d5f3bdac40f93607d600134865d4f13ce1f9b"),
    "introductory-statistics-bundle": book("introductory-statistics-bundle", "50ec91749080bb040b57bb40c34337cacc994cba"),
    "microbiology": book("microbiology", "ecf34dad129d686703780e87ab5aa2e59c577a6a"),
    "physics": book("physics", "ff78c7a8150fdda5ed1f786ac59ac25cdd532ef0"),
    "prealgebra-bundle": book("prealgebra-bundle", "77a933c672e9c48c746eb802d588a9a7ddfd6e0d"),
    "principles-economics-bundle": book("principles-economics-bundle", "cd31beb103fffbc09cc81ebfe117d8c40cc12d1a"),
    "principles-marketing": book("principles-marketing", "40369d8ce3adb160cf8d2cc6528cd00be6a472eb"),
    "psychology": book("psychology", "e061043bf2f9e86ace51c4e8dc9555160f60a99d"),
    "university-physics-bundle": book("university-physics-bundle", "db44eb99e9aa1d918fd8cf182f82ccdece9c7b11"),
    "writing-guide": book("writing-guide", "a6c95528390e3a2936f5bf87c49ac1a4995a0a6e"),
    # Seamless textures, cut from the catalog's preview pages. LICENSE: CC0 1.0, as on
    # ambientcg.com.
    "ambientcg": Source("fabien-michel/sweethome3d-textures-ambientcg", "1a475099a89a9b979bbd15b6f59305d260795b80", "CC0-1.0", "ambientCG"),
    # Panoramas of Poly Haven, as stated in README.md. CC0 according to polyhaven.com/license.
    "polyhaven": Source("gkjohnson/3d-demo-data", "a79b5400ba8ed5bdeffebc10ce5adeecda7c3ebc", "CC0-1.0", "Poly Haven"),
    # The license of each picture is in src/_skimage2/data/_fetchers.py.
    "scikit-image": Source("scikit-image/scikit-image", "cd0a3d22b9f359f05618d75d5c7a29b91b4951ca", "CC0-1.0", "CC0Textures"),
    # Textures of games and simulators. Licenses: readme.txt, README.md, about/*.txt and LICENSE.
    "dziq": Source("red-eclipse/dziq", "f9a83d20fad7da280cc392d3129d7e61385d06f0", "CC-BY-SA-4.0", "Radek Jedrecki (Dziq)"),
    "jojo": Source("red-eclipse/jojo", "636262115c8a93f67f7b51580ae37c6250e1a362", "CC-BY-SA-4.0", "Red Eclipse Team"),
    "nieb": Source("red-eclipse/nieb", "1584312a0458e7884afc6dfe14f577528a7e81fb", "CC0-1.0", "Nieb"),
    "philipk": Source("red-eclipse/philipk", "410337c20693d662ac30c9f16e09917bcb9b9699", "CC-BY-3.0", "Philip Klevestav"),
    "torley": Source("red-eclipse/torley", "d62afcafbd6ff981005051052d3c92ad3c4e4636", "CC-BY-SA-3.0", "Torley"),
    "unnamed": Source("red-eclipse/unnamed", "ebb4b0e4ba86a808f65cc8fdc0aece51cd55123f", "CC-BY-SA-3.0", "Unnamed (Viktor Hahn)"),
    "tex-tech": Source("UnvanquishedAssets/tex-tech_src.dpkdir", "f6aa602541fc133c418f6919f3e1cd8e6cd84b75", "CC-BY-SA-3.0", "Scott 'Cr4zy' Coxhead"),
    "tex-trak5": Source("UnvanquishedAssets/tex-trak5_src.dpkdir", "6263e3bf9b907810e6ef996c9109706cb123e9d7", "MIT", "Georges 'TRaK' Grondin"),
    "gazebo_models": Source("osrf/gazebo_models", "8163eb4b5e7e21985c6591d1c0bfb56468c0093f", "CC-BY-3.0", "Nathan Koenig and contributors"),
}


class Picture(NamedTuple):
    source: str
    path: str
    part: str
    """What is cut out: `half0` and `half1` of a panorama, `tileCOLUMN,ROW` of a page of previews, or all of it."""
    licence: str
    author: str

    @property
    def file(self):
        """Returns a flat name that is the same in every run."""
        stem = re.sub(r"[^A-Za-z0-9_.-]+", "-", str(Path(self.path).with_suffix("")).removeprefix("media/"))
        return "--".join(filter(None, [self.source, stem, self.part.replace(",", "-")])) + ".jpg"


def listed():
    """Yields the rows of the table in order."""
    rows = Path(__file__).with_suffix(".tsv").read_text(encoding="utf-8").splitlines()[1:]
    for row in rows:
        source, path, licence, author = row.split("\t")
        path, _, part = path.partition("#")
        yield Picture(source, path, part, licence or SOURCES[source].licence, author or SOURCES[source].author)


def content(picture, clones):
    """Returns the file's bytes, from a clone or from GitHub."""
    source = SOURCES[picture.source]
    clone = clones and clones / source.repository.replace("/", "+")
    if clone and clone.exists():
        name = f"{source.commit}:{picture.path}"
        return subprocess.run(["git", "-C", clone, "cat-file", "blob", name], check=True, capture_output=True).stdout
    path = urllib.parse.quote(picture.path)
    with urllib.request.urlopen(f"https://raw.githubusercontent.com/{source.repository}/{source.commit}/{path}", timeout=60) as answer:
        return answer.read()


def half_of_panorama(data, half):
    """Returns half of the panorama, from 40° above the horizon almost to the feet, exposed for the
    part below the sky.
    """
    light = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)[:, :, ::-1]
    height, width = light.shape[:2]
    mean = np.exp(np.log(light[height // 4 :].mean(axis=2) + 1e-4).mean())
    exposed = light * (0.4 / mean)
    display = np.clip(1.15 * exposed / (1 + exposed), 0, 1) ** (1 / 2.2)
    part = display[int(0.28 * height) : int(0.94 * height), half * width // 2 : (half + 1) * width // 2]
    return Image.fromarray((255 * part).astype(np.uint8))


def tiled_preview(page, column, row):
    """Returns one preview of 128 pixels, tiled four by three. Its texture is seamless."""
    left, top = 16 + 144 * column, 16 + 176 * row
    tile = page.crop((left, top, left + 128, top + 128))
    picture = Image.new("RGB", (512, 384))
    for x in range(0, 512, 128):
        for y in range(0, 384, 128):
            picture.paste(tile, (x, y))
    return picture


def opened(data, part):
    """Returns the picture as it is saved. Transparent parts of a texture are shown, because they
    serve as background too.
    """
    if part.startswith("half"):
        return half_of_panorama(data, int(part.removeprefix("half")))
    picture = Image.open(BytesIO(data))
    picture.draft("RGB", (LONGEST_PX, LONGEST_PX))
    picture = picture.convert("RGB")
    if part.startswith("tile"):
        return tiled_preview(picture, *map(int, part.removeprefix("tile").split(",")))
    picture.thumbnail((LONGEST_PX, LONGEST_PX), Image.Resampling.LANCZOS)
    return picture


def gather(pictures, out, clones):
    """Writes the missing pictures of one source file. Returns an error message, if any."""
    missing = [picture for picture in pictures if not (out / picture.file).exists()]
    try:
        data = missing and content(missing[0], clones)
        for picture in missing:
            opened(data, picture.part).save(out / picture.file, quality=90)
    except (OSError, subprocess.CalledProcessError) as error:
        return f"{pictures[0].source} {pictures[0].path}: {error}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "cache" / "backgrounds")
    parser.add_argument("--clones", type=Path, help="folder of clones named OWNER+NAME, read instead of github.com")
    parser.add_argument("--jobs", type=int, default=4)
    arguments = parser.parse_args()

    arguments.out.mkdir(parents=True, exist_ok=True)
    files = [list(rows) for _, rows in groupby(listed(), lambda picture: (picture.source, picture.path))]
    with ThreadPoolExecutor(arguments.jobs) as jobs:
        failures = list(jobs.map(lambda pictures: gather(pictures, arguments.out, arguments.clones), files))

    gathered = [picture for pictures, failure in zip(files, failures) if failure is None for picture in pictures]
    with open(arguments.out / "sources.tsv", "w", encoding="utf-8") as table:
        print("file", "source", "licence", "author", sep="\t", file=table)
        for picture in gathered:
            source = SOURCES[picture.source]
            place = f"github.com/{source.repository}@{source.commit}:{picture.path}" + (picture.part and f"#{picture.part}")
            print(picture.file, place, picture.licence, picture.author, sep="\t", file=table)
    failed = [failure for failure in failures if failure]
    print(*failed, f"{len(gathered)} pictures in {arguments.out}", sep="\n")
    raise SystemExit(bool(failed))


if __name__ == "__main__":
    main()

"""The ropes in a picture, as an SVG: python trace_picture.py rope.png rope.svg

Reads what Pillow reads: pip install pillow
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

import lariat

if len(sys.argv) != 3:
    sys.exit(__doc__)
image = np.asarray(Image.open(sys.argv[1]).convert("RGB"))
scene = lariat.trace(image)
print(scene)
if scene.notice:
    print(scene.notice, file=sys.stderr)
for curve in scene.curves:
    fit = lariat.fit(curve)
    print(f"rope {curve.track}: {curve.length_px:.0f} px long, {curve.width_px:.1f} px wide, {fit!r}")
    print(f"  crossings {curve.crossing_sequence or 'none'}, middle {np.round(fit.point_at(0.5), 1)}")
Path(sys.argv[2]).write_text(scene._repr_html_().split("</svg>")[0] + "</svg>\n")

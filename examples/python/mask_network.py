"""A network that tells which pixels are rope.

Run a chain with `mask = "external"` under [extract] alongside.

python mask_network.py [--rig NAME]
"""

import sys

import numpy as np
from numpy.typing import NDArray

import lariat

rig = sys.argv[sys.argv.index("--rig") + 1] if "--rig" in sys.argv else "default"


def load() -> NDArray[np.float64]:
    """Your network goes here, for instance: return torch.jit.load("ropes.pt").eval().cuda()"""
    return np.array([-6.0, 0.0, 6.0])


def network(weights: NDArray[np.float64], image: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Probability of rope for each pixel, 0 to 1, as (height, width).

    Here, one layer of NumPy: the excess of blue over red.

    With torch: x = torch.from_numpy(image).cuda().permute(2, 0, 1)[None] / 255
                return torch.sigmoid(weights(x))[0, 0].cpu().numpy()
    """
    return np.asarray(1.0 / (1.0 + np.exp(1.0 - image / 255.0 @ weights)))


weights = load()
with lariat.Frames(rig) as frames, lariat.Writer("masks", rig) as masks:
    for frame in frames:  # the newest frame; others are skipped while the network works
        image = frame.array if frame.pixel_format == "rgb8" else frame.array[..., ::-1]
        masks.write(network(weights, image), frame)

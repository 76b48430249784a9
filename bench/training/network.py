"""The mask network: segments ropes, and the seams between ropes that lie side by side.

A U-Net (Ronneberger, Fischer and Brox, 2015) of 270,000 weights, designed for integer arithmetic.
All activations are 0 to 127 and represent 0 to 4. Weights are -127 to 127 with a scale for each
output channel. With `Whole` weights both are rounded as in the kernels of `crates/network`.
Gradients pass through the rounding (Bengio, Léonard and Courville, 2013), so the trained network is
the one that runs.

Training starts with batch normalization (Ioffe and Szegedy, 2015): `Normalized` has a gain and a
bias for the output of each layer, and `folded` turns it into plain weights.
"""

import struct
import zlib

import numpy as np
import torch
from torch.nn import functional

TOP = 4.0  # value of the activation 127
STEP = TOP / 127
LOGIT_STEPS = 16  # steps of the last layer's bytes per unit of the logit

# name: kernel size, channels in, channels out, stride, dilation
LAYERS = {
    "stem": (3, 3, 16, 2, 1),
    "d1": (3, 16, 32, 2, 1),
    "d2": (3, 32, 48, 2, 1),
    "e2a": (3, 48, 48, 1, 1),
    "e2b": (3, 48, 48, 1, 1),
    "d3": (3, 48, 64, 2, 1),
    "e3a": (3, 64, 64, 1, 2),
    "e3b": (3, 64, 64, 1, 1),
    "e3c": (3, 64, 64, 1, 4),
    "e3d": (3, 64, 64, 1, 1),
    "u2": (1, 64, 48, 1, 1),
    "f2": (3, 48, 48, 1, 1),
    "u1": (1, 48, 32, 1, 1),
    "f1": (3, 32, 32, 1, 1),
    "out": (1, 32, 32, 1, 1),
}


class Normalized:
    """Weights with batch normalization of each layer's sums. Each layer has a kernel (out, in,
    height, width), a bias and a gain.

    Convolutions use 16-bit floats (bfloat16), which takes two thirds of the time of 32-bit ones if
    the processor supports them.
    """

    def __init__(self, seed):
        """Initializes the weights (He et al., 2015)."""
        random, self.parts = np.random.default_rng(seed), {}
        for name, (side, inputs, outputs, _, _) in LAYERS.items():
            deviation = np.sqrt(2 / (side * side * inputs)) * (0.1 if name == "out" else 1)
            kernel = random.normal(0, deviation, (outputs, inputs, side, side))
            # A layer whose output is added to another's starts as the smaller part of the sum.
            gain = 0.5 if name in ("e2b", "e3b", "e3d", "u2", "u1") else 1.0
            self.parts[name] = parameters(kernel, np.zeros(outputs), np.full(outputs, gain))

    def sums(self, name, x):
        kernel, bias, gain = self.parts[name]
        y = convolved(name, x.bfloat16(), kernel.bfloat16())
        return y.float() + bias[:, None, None] if name == "out" else functional.batch_norm(y, None, None, gain, bias, training=True)

    def __call__(self, rgb):
        return through(self.sums, rgb)

    def folded(self, batches):
        """Returns equivalent plain weights, from the statistics of batches that these weights were
        not trained on.
        """
        means = {name: [] for name in LAYERS}

        def sums(name, x):
            y = convolved(name, x.float(), self.parts[name][0])
            means[name].append(torch.stack([y.mean((0, 2, 3)), y.var((0, 2, 3))]))
            return self.sums(name, x)

        with torch.no_grad():
            for rgb in batches:
                through(sums, rgb)
            plain = {}
            for name, (kernel, bias, gain) in self.parts.items():
                if name != "out":
                    mean, variance = torch.stack(means[name]).mean(0)
                    factor = gain / torch.sqrt(variance + 1e-5)
                    kernel, bias = kernel * factor[:, None, None, None], bias - mean * factor
                plain[name] = parameters(kernel, bias)
        return Whole(plain)


class Whole:
    """Rounded weights, as executed. Each layer has a kernel (out, in, height, width) and a bias."""

    def __init__(self, parts):
        self.parts = parts

    def sums(self, name, x):
        kernel, bias = self.parts[name]
        scale = scales(kernel.detach(), bias.detach())
        kernel = rounded(kernel, scale[:, None, None, None]).clamp(-127 * scale[:, None, None, None], 127 * scale[:, None, None, None])
        y = convolved(name, x, kernel) + rounded(bias, scale * STEP)[:, None, None]
        return y if name == "out" else rounded(y, STEP)

    def __call__(self, rgb):
        return through(self.sums, rgb)


def parameters(*parts):
    parts = (torch.as_tensor(part, dtype=torch.float32) for part in parts)
    # Convolutions are fastest with channels last.
    return [(part.contiguous(memory_format=torch.channels_last) if part.ndim == 4 else part).requires_grad_() for part in parts]


def rounded(x, step):
    """Returns x rounded to multiples of step, with the gradient of x."""
    return x + (torch.round(x.detach() / step) * step - x.detach())


def scales(kernel, bias):
    """Returns, for each output channel, the value of one step of its weights."""
    largest = kernel.abs().amax((1, 2, 3))
    # Sums including the bias stay below 2^24, where a 32-bit float is exact.
    return torch.maximum(largest / 127, bias.abs() / STEP / 2**22).clamp(min=1e-8)


def convolved(name, x, kernel):
    """Returns the sums of a layer."""
    side, _, _, stride, dilation = LAYERS[name]
    if stride == 2:
        # The window of output y starts at input 2 y.
        return functional.conv2d(functional.pad(x, (0, 1, 0, 1)), kernel, stride=2)
    return functional.conv2d(x, kernel, padding=dilation * (side // 2), dilation=dilation)


def through(sums, rgb):
    """Returns the logits of both maps (count, 2, height, width) for pictures (count, 3, height,
    width) with values from 0 to 255.

    `sums` computes a layer's sums. Sides are multiples of 16.
    """

    def active(x):
        return functional.hardtanh(x, 0.0, TOP)

    def layer(name, x):
        return active(sums(name, x))

    def added(name, x, to):
        return active(sums(name, x) + to)

    def lifted(name, x, to):
        low = functional.hardtanh(sums(name, x), -TOP, TOP)
        return active(to + functional.interpolate(low, scale_factor=2, mode="nearest"))

    x = (torch.floor(rgb / 2) - 64) * STEP
    fine = layer("d1", layer("stem", x))
    middle = layer("d2", fine)
    middle = added("e2b", layer("e2a", middle), middle)
    coarse = layer("d3", middle)
    coarse = added("e3b", layer("e3a", coarse), coarse)
    coarse = added("e3d", layer("e3c", coarse), coarse)
    middle = layer("f2", lifted("u2", coarse, middle))
    fine = layer("f1", lifted("u1", middle, fine))
    return functional.pixel_shuffle(sums("out", fine), 4)


def packed(weights):
    """Returns the bytes of the file that lariat reads. Its layout is documented at the head of
    `crates/network`.
    """
    parts = [b"LARIATN1", struct.pack("<II", 1, len(LAYERS))]
    for name, (side, inputs, outputs, stride, dilation) in LAYERS.items():
        kernel, bias = (part.detach() for part in weights.parts[name])
        scale = scales(kernel, bias).numpy()
        kernel, bias = (part.double().numpy() for part in (kernel.permute(2, 3, 1, 0), bias))
        whole = np.clip(np.rint(kernel / scale), -127, 127).astype(np.int8)
        sums = np.rint(bias / (scale * np.float64(STEP))).astype(np.int64)
        if name == "stem":
            # The zero point of the input is 64, which the kernels do not subtract.
            sums -= 64 * whole.astype(np.int64).sum((0, 1, 2))
        # An activation's step cancels out: the weights' scale alone converts sums to activations.
        out = scale * np.float32(STEP * LOGIT_STEPS) if name == "out" else scale
        parts.append(struct.pack("<HHBBBB", inputs, outputs, side, stride, dilation, 0))
        parts += [whole.tobytes(), sums.astype("<i4").tobytes(), out.astype("<f4").tobytes()]
    body = b"".join(parts)
    return body + struct.pack("<I", zlib.crc32(body))


def unpacked(file):
    """Returns the weights in such a file."""
    body, at, parts = file[:-4], 16, {}
    if body[:8] != b"LARIATN1" or struct.unpack("<I", file[-4:])[0] != zlib.crc32(body):
        raise SystemExit("these are no weights of lariat's network, or they are damaged")
    for name, (side, inputs, outputs, _, _) in LAYERS.items():
        at += 8
        count = side * side * inputs * outputs
        whole = np.frombuffer(body, np.int8, count, at).reshape(side, side, inputs, outputs)
        sums = np.frombuffer(body, "<i4", outputs, at + count).astype(np.float64)
        scale = np.frombuffer(body, "<f4", outputs, at + count + 4 * outputs)
        at += count + 8 * outputs
        if name == "stem":
            sums += 64 * whole.astype(np.int64).sum((0, 1, 2))
        if name == "out":
            scale = scale / np.float32(STEP * LOGIT_STEPS)
        parts[name] = parameters((whole * scale).transpose(3, 2, 0, 1), sums * scale * STEP)
    return Whole(parts)

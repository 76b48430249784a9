"""Trains the mask network on drawn pictures: `train.py --scenes FOLDER --out FOLDER`, see
README.md. Writes ropes.weights and a log.

Training is reproducible: the same scenes, seed, steps and machine give the same weights, bit for
bit, even after an interruption. A run that is restarted with the same arguments resumes. The number
of steps may be changed until the learning rate starts to fall.
"""

import argparse
import copy
import json
import math
import os
import time
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

import network
import pictures

SIDE = 256
SAVED = 1000  # steps between checkpoints
FIRST_FILES = 4  # files of scenes at the start
NEW_FILE = 2000  # steps per additional file of scenes


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=Path, required=True, help="folder of .npy files that lariat-scenes made")
    parser.add_argument("--out", type=Path, required=True, help="folder for the weights, the log and what is needed to go on")
    parser.add_argument("--files", type=int, default=32, help="files of scenes that there are, or will be")
    parser.add_argument("--steps", type=int, default=100000)
    parser.add_argument("--batch", type=int, default=6, help="pictures a step")
    parser.add_argument("--rate", type=float, default=2e-3, help="the highest learning rate")
    parser.add_argument("--falling", type=float, default=0.4, help="share of the steps, the last ones, in which the rate falls")
    parser.add_argument("--rounded", type=float, default=0.2, help="share of the steps, the last of those, in which numbers are rounded")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--begin", type=Path, help="a file of weights to train further, such as crates/network/ropes.weights")
    parser.add_argument("--own", type=Path, help="pictures of your own, every second one of a batch: a folder with images/ and labels/")
    return parser.parse_args()


def own_pictures(folder):
    """Returns pictures with their labels in the format of scenes. Their seams are unknown and left
    empty.
    """
    scenes = []
    for file in pictures.files(folder / "images"):
        label = pictures.label(file, folder / "labels")
        scene = np.dstack([pictures.read(file), 255 * label.astype(np.uint8), np.zeros(label.shape, np.uint8)])
        margins = [(0, max(0, SIDE - length)) for length in label.shape]
        scenes.append(np.pad(scene, (*margins, (0, 0)), mode="reflect"))
    return scenes


class Scenes:
    """Crops of drawn pictures, rotated and recolored. A batch depends only on the seed and its
    number.
    """

    def __init__(self, args):
        self.folder, self.files, self.most = args.scenes, [], args.files
        self.own = own_pictures(args.own) if args.own else []
        self.seed, self.count = args.seed, args.batch

    def files_at(self, number):
        """Returns the files used at a step. Waits for those that are still being drawn."""
        count = min(self.most, FIRST_FILES + number // NEW_FILE)
        while len(self.files) < count:
            file = self.folder / f"{len(self.files):02}.npy"
            while not file.exists():
                time.sleep(5)
            self.files.append(np.load(file, mmap_mode="r"))
        return self.files[:count]

    def batch(self, number):
        """Returns pictures (count, 3, side, side) of 0 to 255, and the maps of their ropes and
        seams (count, 2, side, side), 0 to 1.
        """
        random = np.random.default_rng([self.seed, number])
        crops, files = np.empty((self.count, SIDE, SIDE, 5), np.float32), self.files_at(number)
        for crop in crops:
            scenes = self.own if self.own and random.random() < 0.5 else files[random.integers(len(files))]
            picture = scenes[random.integers(len(scenes))]
            top, left = (random.integers(0, length - SIDE + 1) for length in picture.shape[:2])
            picture = picture[top : top + SIDE, left : left + SIDE]
            picture = np.rot90(picture, random.integers(4))
            if random.random() < 0.5:
                picture = picture[:, ::-1]
            crop[:] = picture
            if random.random() < 0.4:
                crop[..., :3] = crop[..., random.permutation(3)]
            crop[..., :3] = np.clip(crop[..., :3] * random.uniform(0.8, 1.2) + random.uniform(-15, 15), 0, 255)
        crops = torch.from_numpy(crops).permute(0, 3, 1, 2)
        return crops[:, :3].contiguous(memory_format=torch.channels_last), crops[:, 3:].contiguous() / 255


def entropy(logits, truth):
    """Returns the cross entropy of each pixel, in half the time of PyTorch's own function."""
    return functional.relu(logits) - logits * truth - torch.log(torch.sigmoid(logits.abs()))


def loss(logits, truth):
    """Returns the cross entropy of both maps, weighted towards ropes for the seams, plus one minus
    the overlap of the rope map (Milletari et al., 2016). Also returns the three parts.
    """
    (rope, seam), (rope_truth, seam_truth) = logits.unbind(1), truth.unbind(1)
    found = torch.sigmoid(rope)
    overlap = (2 * (found * rope_truth).sum((1, 2)) + 50) / (found.sum((1, 2)) + rope_truth.sum((1, 2)) + 50)
    seam_entropy = (0.1 + rope_truth) * entropy(seam, seam_truth)
    parts = torch.stack([entropy(rope, rope_truth).mean(), 1 - overlap.mean(), seam_entropy.mean()])
    return parts @ torch.tensor([1.0, 0.5, 0.5]), parts.detach()


class Learner:
    """AdamW (Loshchilov and Hutter, 2019) with the gradient's norm clipped to 2, and a moving
    average of the weights over some 1000 steps.
    """

    def __init__(self, weights):
        self.weights, self.mean, self.count = weights, copy.deepcopy(weights), 0
        self.parts = [part for layer in weights.parts.values() for part in layer]
        # Weight decay applies only to kernels.
        kernels, others = ([part for part in self.parts if (part.ndim == 4) == kernel] for kernel in (True, False))
        groups = [{"params": kernels, "weight_decay": 1e-2}, {"params": others, "weight_decay": 0.0}]
        self.optimizer = torch.optim.AdamW(groups, betas=(0.9, 0.98))

    def means(self):
        return [part for layer in self.mean.parts.values() for part in layer]

    def step(self, batch, rate):
        rgb, truth = batch
        for group in self.optimizer.param_groups:
            group["lr"] = rate
        self.optimizer.zero_grad()
        total, parts = loss(self.weights(rgb), truth)
        total.backward()
        torch.nn.utils.clip_grad_norm_(self.parts, 2.0)
        self.optimizer.step()
        self.count += 1
        with torch.no_grad():
            torch._foreach_lerp_(self.means(), self.parts, max(1e-3, 1 / self.count))
        return parts.numpy()


class Training:
    """The checkpointed state of a training run: the step, the learner, and the values for the log's
    next line.
    """

    def __init__(self, args):
        self.args, self.scenes, self.file, self.log = args, Scenes(args), args.out / "state.pt", args.out / "log.jsonl"
        self.normalized_steps = 0 if args.begin else int(args.steps * (1 - args.rounded))
        self.high_steps = 0 if args.begin else int(args.steps * (1 - args.falling))
        if self.file.exists():
            kept, self.number, self.learner, self.parts, self.seconds = torch.load(self.file, weights_only=False)
            if self.number <= min(self.high_steps, kept["steps"] * (1 - kept["falling"])):
                kept |= {name: getattr(args, name) for name in ("steps", "falling", "rounded")}
            if kept != vars(args):
                raise SystemExit(f"{self.file} is of a training with other arguments: remove it, or give another --out")
            lines = self.log.read_text().splitlines(keepends=True)
            self.log.write_text("".join(line for line in lines if json.loads(line)["step"] <= self.number))
            return
        self.number, self.parts, self.seconds = 0, [], 0.0
        begun = network.unpacked(args.begin.read_bytes()) if args.begin else network.Normalized(args.seed)
        self.learner = Learner(begun)
        self.log.unlink(missing_ok=True)

    def rate(self):
        """Returns the learning rate. It rises at first, then falls to a tenth by the end of the
        normalized steps, then from a tenth to almost zero.
        """
        number, high, normalized, args = self.number, self.high_steps, self.normalized_steps, self.args
        if number < high:
            return args.rate * min(1, (number + 1) / 300)
        fall = lambda share: 0.5 * (1 + math.cos(math.pi * share))
        if number < normalized:
            return args.rate * (0.1 + 0.9 * fall((number - high) / (normalized - high)))
        return 0.1 * args.rate * fall((number - normalized) / (args.steps - normalized)) + 1e-6

    def run(self):
        began = time.monotonic() - self.seconds
        while self.number < self.args.steps:
            if self.number == self.normalized_steps and not self.args.begin:
                unseen = (self.scenes.batch(self.args.steps + k)[0] for k in range(100))
                self.learner = Learner(self.learner.mean.folded(unseen))
            self.parts.append(self.learner.step(self.scenes.batch(self.number), self.rate()))
            self.number += 1
            self.seconds = time.monotonic() - began
            if self.number % 200 == 0:
                self.note()
            if self.number % SAVED == 0:
                self.save()
        (self.args.out / "ropes.weights").write_bytes(network.packed(self.learner.mean))

    def note(self):
        rope, overlap, seam = (float(value) for value in np.mean(self.parts, 0))
        self.parts = []
        line = {"step": self.number, "rope": rope, "overlap": overlap, "seam": seam, "seconds": self.seconds}
        with self.log.open("a") as log:
            print(json.dumps({name: round(value, 4) for name, value in line.items()}), file=log)

    def save(self):
        part = self.file.with_suffix(".part")
        torch.save((vars(self.args), self.number, self.learner, self.parts, self.seconds), part)
        os.replace(part, self.file)


def main():
    args = arguments()
    args.out.mkdir(parents=True, exist_ok=True)
    torch.use_deterministic_algorithms(True)
    torch.utils.deterministic.fill_uninitialized_memory = False
    Training(args).run()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Holds the two workspaces to what lets them share compiled crates: equal tables, locked versions and features.

    .ci/same_tables.py     prints a sentence for each difference, and fails if there is one

cargo compiles a crate once for both only if nothing of this differs. What is in one workspace alone is free.
"""

import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORKSPACES = [ROOT, ROOT / "bench"]


def read(name):
    return [tomllib.loads((workspace / name).read_text()) for workspace in WORKSPACES]


def differing(ours, theirs, names):
    return sorted(name for name in names if ours.get(name) != theirs.get(name))


def tables():
    """Tables that the product's crates inherit, and profiles."""
    root, bench = read("Cargo.toml")
    for table in ["package", "lints"]:
        if root["workspace"][table] != bench["workspace"][table]:
            yield f"[workspace.{table}] differs"
    ours, theirs = root["workspace"]["dependencies"], bench["workspace"]["dependencies"]
    for name in differing(ours, theirs, ours):
        yield f"{name} of [workspace.dependencies] differs"
    locked = [{package["name"] for package in lock["package"]} | {"*"} for lock in read("Cargo.lock")]
    for profile in root["profile"].keys() | bench["profile"].keys():
        ours, theirs = (manifest["profile"].get(profile, {}) for manifest in (root, bench))
        for key in differing(ours, theirs, (ours.keys() | theirs.keys()) - {"package"}):
            yield f"{key} of [profile.{profile}] differs"
        ours, theirs = ours.get("package", {}), theirs.get("package", {})
        for name in differing(ours, theirs, (ours.keys() | theirs.keys()) & locked[0] & locked[1]):
            yield f"{name} of [profile.{profile}.package] differs"


def versions():
    """Versions of the crates that both lock."""
    locks = []
    for lock in read("Cargo.lock"):
        versions = {}
        for package in lock["package"]:
            versions.setdefault(package["name"], set()).add((package["version"], package.get("checksum")))
        locks.append(versions)
    ours, theirs = locks
    for name in sorted(ours.keys() & theirs.keys()):
        # A workspace may need one more version.
        if not (ours[name] <= theirs[name] or theirs[name] <= ours[name]):
            mine, other = (", ".join(sorted(version for version, _ in side)) for side in (ours[name], theirs[name]))
            yield f"{name} is locked as {mine} by the product and as {other} by bench/: copy the version by `cargo update --precise`"


def features(workspace, package):
    """The crates of a package's build, each with its features."""
    command = ["cargo", "tree", "--locked", "--edges=normal,build", "--prefix=none", "--no-dedupe", "--format={p}|{f}"]
    command += ["--manifest-path", workspace / "Cargo.toml", "--package", package]
    lines = subprocess.check_output(command, text=True, cwd=ROOT).splitlines()
    all_features = {}
    for line in lines:
        name, _, features = line.removesuffix(" (*)").partition("|")
        # Name and version: a path and "(proc-macro)" may follow.
        all_features.setdefault(" ".join(name.split()[:2]), set()).add(features)
    return all_features


def same_features():
    ours, theirs = features(ROOT, "lariat"), features(ROOT / "bench", "lariat-bench")
    for name in sorted(ours.keys() & theirs.keys()):
        # A crate may be compiled once more, for a program that runs in the build.
        if not (ours[name] <= theirs[name] or theirs[name] <= ours[name]):
            mine, other = (" and ".join(sorted(f"[{features}]" for features in side)) for side in (ours[name], theirs[name]))
            yield f"{name} has the features {mine} in the product and {other} in bench/"


if __name__ == "__main__":
    found = [*tables(), *versions(), *same_features()]
    if found:
        sys.exit("Cargo.toml and bench/Cargo.toml (or their Cargo.lock) do not agree:\n" + "\n".join(f"- {line}" for line in found))

#!/usr/bin/env python3
"""Checks the licenses of the crates that lariat consists of.

    packaging/licences.py                     reports licenses that deny.toml does not allow (part of .ci/run)
    packaging/licences.py --notices PACKAGE   prints the license texts that must accompany its binary

Further arguments, such as --manifest-path, are passed to cargo.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# The allowed licenses are in deny.toml. tomllib is not in every Python that builds packages.
ALLOWED = set(re.findall(r'^ {4}"(.+)",$', (ROOT / "deny.toml").read_text().split("[licenses]")[1].split("[bans]")[0], re.MULTILINE))

TEXTS = re.compile(r"^(licen[cs]e|copying|notice|unlicense)", re.IGNORECASE)


def crates(words):
    """Output of `cargo metadata` for all packages, for the platforms that lariat runs on."""
    command = ["cargo", "metadata", "--locked", "--format-version=1"]
    for target in ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu"]:
        command += ["--filter-platform", target]
    return json.loads(subprocess.check_output(command + words))


def is_allowed(expression):
    """True if the allowed licenses satisfy an SPDX expression. AND binds more tightly than OR."""
    words = re.findall(r"\(|\)|[^\s()/]+|/", expression)
    position = 0

    def peek():
        return words[position] if position < len(words) else None

    def take():
        nonlocal position
        position += 1
        return words[position - 1]

    def either():
        value = both()
        while peek() in ("OR", "/"):  # old manifests write `/` for OR
            take()
            value = both() or value
        return value

    def both():
        value = one()
        while peek() == "AND":
            take()
            value = one() and value
        return value

    def one():
        word = take()
        if word == "(":
            value = either()
            take()
            return value
        if peek() == "WITH":
            take()
            word += " WITH " + take()
        return word in ALLOWED

    return either()


def check():
    # Each workspace has a lock file of its own.
    manifests = ["Cargo.toml", "bench/Cargo.toml", "crates/ros2/Cargo.toml"]
    locked = [crates(["--manifest-path", manifest])["packages"] for manifest in manifests]
    packages = {(package["name"], package["version"]): package for packages in locked for package in packages}.values()
    wrong = []
    for package in packages:
        name, licence = f"{package['name']} {package['version']}", package["license"]
        if licence is None:
            wrong.append(f"{name} names no licence: look at {package['manifest_path']}")
        elif not is_allowed(licence):
            wrong.append(f"{name} has {licence}, which is not on the list in deny.toml")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(packages)} crates, all of licences on the list")


def notices(product, words):
    """Texts in the packages that are linked into the binary, each different text once."""
    metadata = crates(words)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    linked, waiting = set(), [p["id"] for p in packages.values() if p["name"] == product]
    while waiting:
        node = waiting.pop()
        if node not in linked:
            linked.add(node)
            for dependency in nodes[node]["deps"]:
                if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                    waiting.append(dependency["pkg"])
    owners = {}
    for package in sorted((packages[node] for node in linked), key=lambda p: p["name"]):
        if package["source"] is None:
            continue
        name = f"{package['name']} {package['version']} ({package['license']})"
        folder = Path(package["manifest_path"]).parent
        texts = [path for path in sorted(folder.iterdir()) if TEXTS.match(path.name) and path.is_file()]
        for path in texts:
            owners.setdefault(path.read_text(errors="replace").strip(), []).append(name)
        if not texts:
            owners.setdefault("(Its package has no text of its own.)", []).append(name)
    print(f"{product} is made with these crates, each under its licence.")
    for text, names in sorted(owners.items(), key=lambda owner: owner[1]):
        print(f"\n{'=' * 80}\n{chr(10).join(dict.fromkeys(names))}\n{'-' * 80}\n{text}")


if __name__ == "__main__":
    match sys.argv[1:]:
        case []:
            check()
        case ["--notices", product, *words]:
            notices(product, words)
        case _:
            sys.exit(__doc__)

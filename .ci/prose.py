#!/usr/bin/env python3
"""Finds sentences in comments, messages and documents that an English-speaking engineer would have to read twice.

    .ci/prose.py             fails if there are more of them than .ci/records/prose.json allows (part of .ci/run)
    .ci/prose.py --list [PATH...]      prints each with its pattern
    .ci/prose.py --renew     writes the record; it should only fall

The patterns catch frequent mistakes. A sentence without a hit can still be poor.
"""

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RECORD = ROOT / ".ci/records/prose.json"
LONGEST = 32  # words
HEADLESS = (
    r"^(What|Who|Whose|Of|By (how|what|which)|From (what|which)|So (many|much|far)|And (from|by|of|so|how|what|where|the|that|one|no|for|which)"
    r"|How (far|many|much|often|long|sure|wide)|Where|Whether|As (far|long|many|much) as|That (which|of|is|it)|Times as)\b(?!.*\?)"
)
PATTERNS = {
    "a clause instead of a sentence": HEADLESS,
    "is no X: is not a X": r"\b(?<!there )(?<!There )(is|are|was|were|be) (no|none)\b(?! (longer|more|less|later|need|reason|way))",
    "anew: again": r"\b(anew|likewise|thereof|therein|therefor|lest|ere)\b",
    "beside: next to, alongside": r"\b[Bb]eside\b",
    "so many: N, this many": r"\bso (many|much|far|wide|long)\b(?! as)",
    "goes on, stands in: continues, is in": r"\b(goes on|go on|stands (in|by|at|on|there)|stand (in|there)|lies beside)\b",
    "is said, is told: is reported": r"\b(is|are|was|be) (had|said|told|asked for)\b",
    "of which, by which": r"\b(of which|by which|from which|of whom|to whom|of what|by what|for what)\b",
    "two negations": r"\b(not|no|none|never|nothing|nobody|nor)\b[^.,;:]{1,40}\b(not|no|none|never|nothing|nobody|nor|without)\b",
    "else": r"(, else\b|\belse, )",
}
MARKS = {"rs": ("///", "//!", "//"), "py": ("#",), "sh": ("#",), "h": ("*", "/*", "//"), "c": ("*", "/*", "//"), "js": ("//", "*")}


def paragraphs(path, lines):
    """The line, the kind and the text of each paragraph of prose."""
    block, start, is_code = [], 0, False
    ending = path.rsplit(".", 1)[-1]
    marks = MARKS.get(ending, ())
    for number, line in enumerate([*lines, ""], 1):
        text = line.strip()
        if ending == "md":
            is_code ^= text.startswith("```")
            is_prose = not is_code and not text.startswith(("```", "|", "#", "![", "<"))
        else:
            mark = next((mark for mark in marks if text.startswith(mark)), None)
            text = text[len(mark):].strip() if mark else ""
            is_prose = not text.startswith(("```", "|", "SAFETY", "!"))
        if text and is_prose:
            start = start if block else number
            block.append(text)
        elif block:
            yield start, "documents" if ending == "md" else "comments", " ".join(block)
            block = []
        if ending == "rs" and not line.strip().startswith("//"):
            for string in re.findall(r'"((?:[^"\\]|\\.){25,})"', line):
                if string.count(" ") >= 4:
                    yield number, "messages", string


def flaws(text):
    for sentence in re.split(r"(?<=[.!?:;])\s+", text):
        plain = re.sub(r"`[^`]*`|\[[^\]]*\]\([^)]*\)|\$[^$]*\$", "x", sentence).strip()
        words = len(re.findall(r"[A-Za-z][A-Za-z'’-]*", plain))
        if words >= 4:
            yield from ((name, plain) for name, pattern in PATTERNS.items() if re.search(pattern, plain))
            if words > LONGEST:
                yield f"more than {LONGEST} words", plain


def main(words):
    paths = words[1:] if words[:1] == ["--list"] else []
    files = subprocess.check_output(["git", "ls-files", *paths], cwd=ROOT, text=True).splitlines()
    counts = Counter({"comments": 0, "documents": 0, "messages": 0})
    for path in files:
        if path.rsplit(".", 1)[-1] in {"md", *MARKS}:
            for line, kind, text in paragraphs(path, (ROOT / path).read_text(errors="replace").split("\n")):
                for name, sentence in flaws(text):
                    counts[kind] += 1
                    if words[:1] == ["--list"]:
                        print(f"{path}:{line}: [{name}] {sentence[:160]}")
    print(", ".join(f"{count} in {kind}" for kind, count in sorted(counts.items())))
    if words == ["--renew"]:
        RECORD.write_text(json.dumps(counts, indent=2, sort_keys=True) + "\n")
    elif not words:
        record = json.loads(RECORD.read_text())
        risen = [kind for kind, count in counts.items() if count > record[kind]]
        if risen:
            sys.exit(f"more than recorded in {', '.join(risen)}: see `.ci/prose.py --list` for the files that you changed")


if __name__ == "__main__":
    main(sys.argv[1:])

"""The commands and code of README.md and docs/*.md, as a reader would type them, and their cheap forms."""

import re
import shlex
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
DOCUMENTS = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")])
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
SPAN = re.compile(r"(?<!`)`([^`]+)`(?!`)")


class Block(NamedTuple):
    """A fenced block: where it begins, its language and its text."""

    line: int
    language: str
    text: str


def blocks(document):
    """The fenced blocks of a document in order."""
    text = document.read_text(encoding="utf-8")
    return [Block(text[: m.start()].count("\n") + 1, m[1], m[2]) for m in FENCE.finditer(text)]


def commands(text):
    """Each command of a shell block, as words; comments are left out, lines that go on are joined."""
    for line in text.replace("\\\n", " ").splitlines():
        if words := shlex.split(line, comments=True):
            yield words


def spans(document):
    """The commands that stand in sentences, as words."""
    text = FENCE.sub("", document.read_text(encoding="utf-8"))
    for match in SPAN.finditer(text):
        span = " ".join(match[1].split())
        if re.match(r"(glcloth|python|make) ", span):
            yield shlex.split(span)


def replaced(words, **options):
    """A command with some options given anew, or added; names as in Python."""
    out = list(words)
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if flag in out:
            out[out.index(flag) + 1] = str(value)
        else:
            out += [flag, str(value)]
    return out


def cheap(words):
    """A command of glcloth on a small picture and few frames; None where running it is another test's work."""
    what = words[1]
    elsewhere = "view", "check", "bench", "drape", "fabrics", "tables", "export", "sweep"
    if what in elsewhere or {"--workers", "--cluster", "--resume"} & set(words):
        return None
    small = {}
    if what in ("render", "animate", "sweep"):
        small = {"size": "32x24", "spp": 1}
        if "curtain" in words:
            small |= {"frame": 1} if what == "render" and "--frame" not in words else {}
        else:
            small |= {"shadows": "off", "quality": "draft"}
            small |= {} if "--mesh" in words or not words[2].startswith("-") else {"mesh": "sphere"}
    if what == "animate":
        small["frames"] = 2
    if what == "samples":
        small["poses"] = 2
    return replaced(words, **small)

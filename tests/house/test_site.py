"""The documents hold together: links and pictures are there, the site lists every page, the guide shows every parameter."""

import re
from pathlib import Path

import pytest

from glcloth.fabric import Fabric, Transmission, Yarn
from glcloth.weave.model import Irregularity, Weave

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAPERS = sorted([*ROOT.glob("*.md"), *DOCS.glob("*.md")])
LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"^```.*?^```$|`[^`\n]*`", re.M | re.S)
# Fields that have no picture of their own: names for people, and those that the picture of another one explains.
EXPLAINED = {"name", "yarn", "transmission", "weave", "irregularity", "eta_1"}
EXPLAINED |= {"curve_angles_deg", "curve_lengths", "samples", "tangents_deg", "shares"}
EXPLAINED |= {"warp_stripes", "weft_stripes", "far"}


def anchors(path):
    """What a page's headings are called in links."""
    headings = re.findall(
        r"^#+ (.*)$", CODE.sub(lambda m: m[0] if m[0][:3] != "```" else "", path.read_text("utf-8")), re.M
    )
    words = (re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", h)).strip().lower() for h in headings)
    return {re.sub(r"[\s\-]+", "-", word) for word in words}


@pytest.mark.parametrize("paper", PAPERS, ids=lambda p: p.name)
def test_links_and_pictures_are_there(paper):
    for target in LINK.findall(CODE.sub("", paper.read_text("utf-8"))):
        if target.startswith(("http", "mailto")):
            continue
        name, _, anchor = target.partition("#")
        path = paper.parent / name if name else paper
        assert path.exists(), f"{paper.name} links {target}"
        assert not anchor or anchor in anchors(path), f"{paper.name} links {target}: no such heading"


def test_the_site_lists_every_page_once():
    listed = re.findall(r": (\w+\.md)$", (ROOT / "mkdocs.yml").read_text("utf-8"), re.M)
    assert len(listed) == len(set(listed))
    assert {page.name for page in DOCS.glob("*.md")} <= set(listed)
    for page in listed:
        assert (DOCS / page).exists() or (ROOT / page).exists(), page


def test_the_guide_shows_every_parameter_of_a_fabric():
    text = (DOCS / "parameters.md").read_text("utf-8")
    shown = set(re.findall(r"^### (\w+)$", text, re.M))
    fields = {name for model in (Fabric, Yarn, Weave, Irregularity, Transmission) for name in model.model_fields}
    assert fields - EXPLAINED <= shown
    assert shown - fields == {"tangents"}
    assert all(
        f"`{name}`" in text for name in EXPLAINED - {"name", "yarn", "irregularity", "weave", "transmission", "far"}
    )
    pictures = [DOCS / name for name in re.findall(r"\]\((parameters/\w+\.jpg)\)", text)]
    assert {p.stem for p in pictures} == shown == {p.stem for p in (DOCS / "parameters").iterdir()}
    assert sum(p.stat().st_size for p in pictures) < 1_000_000


def test_troubleshooting_quotes_messages_that_there_are():
    """Quoted messages stand in the source; `...` stands for what is put in there."""
    source = "\n".join(p.read_text("utf-8") for p in (ROOT / "glcloth").rglob("*.py"))
    source = re.sub(r"[\"']\s*\n\s*f?[\"']", "", source)
    quoted = re.findall(r"^\| `([^`]+)`", (DOCS / "troubleshooting.md").read_text("utf-8"), re.M)
    assert len(quoted) > 15
    for message in quoted:
        for part in (part.strip() for part in message.split("...")):
            assert part in source, f"no message says: {part}"

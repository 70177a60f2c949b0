"""The papers of the checkout's first folder become pages of the site, and links to them lead there; words of code that
fit on a line are not broken."""

import re
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = ("SYMBOLS.md", "ARCHITECTURE.md", "CHANGELOG.md")
INLINE = re.compile(r"(?<!</span>)<code>([^<]*)</code>")  # blocks have spans inside and before
WORD = re.compile(r"(?<!\S)\S{2,28}(?!\S)")


def on_files(files, config):
    """Add the pages that lie outside docs/."""
    for name in OUTSIDE:
        text = (ROOT / name).read_text(encoding="utf-8").replace("](docs/", "](")
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown, page, config, files):
    """Links that lead out of docs/ in a checkout lead to these pages."""
    for name in OUTSIDE:
        markdown = markdown.replace(f"](../{name}", f"]({name}")
    return markdown


def on_page_content(html, page, config, files):
    """Browsers would break options and names of fields behind their hyphens, and in tables anywhere."""
    return INLINE.sub(lambda code: f"<code>{WORD.sub(_whole, code[1])}</code>", html)


def _whole(word):
    return f'<span style="white-space: nowrap">{word[0]}</span>'

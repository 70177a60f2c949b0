"""The papers of the checkout's first folder become pages of the site, and links to them lead there."""

from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = ("SYMBOLS.md", "ARCHITECTURE.md", "CHANGELOG.md")


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

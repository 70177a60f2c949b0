"""Docstrings as Markdown: our lists of parameters, `name : what it is`, become bullets; types stand in the signature."""

import re

import griffe

SECTION = re.compile(r"^(Parameters|Attributes|Returns)\n-+\n", re.M)
ITEM = re.compile(r"^([\w][\w, *]*?) : ", re.M)


class Plain(griffe.Extension):
    """Rewrites every docstring as it is loaded."""

    def on_object(self, *, obj, **_):
        """Turn one docstring into Markdown."""
        if obj.docstring is not None and not obj.is_alias:
            obj.docstring.value = markdown(obj.docstring.value)


def markdown(text):
    """A docstring whose items are bullets."""
    text = SECTION.sub(r"**\1**\n\n", text)
    return ITEM.sub(lambda m: "- " + ", ".join(f"`{n.strip()}`" for n in m[1].split(",")) + ": ", text)

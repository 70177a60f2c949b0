"""What the examples share: the folder of an output is made, and a missing extra is said in one line before any work."""

import importlib.util
import sys
from pathlib import Path


def output(path):
    """The path of a file to write; its folder is made."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def needs(module, extra):
    """Leave with one line where a module of an optional extra is not installed."""
    if importlib.util.find_spec(module) is None:
        sys.exit(f"this example needs {module}: pip install 'glcloth[{extra}]'")

"""Woven cloth as it really looks, from Python, on OpenGL."""

__version__ = "0.1.0"

"""Fabrics for other renderers, each with a measured distance from the original."""

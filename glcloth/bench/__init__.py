"""Measures on the built-in scenes."""

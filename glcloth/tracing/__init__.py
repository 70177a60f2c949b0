"""Rays through a scene: the tracer of paper B, its layers and its view of the tree."""

"""Meshes, their files and built-in shapes, cameras, objects and the ground: plain values."""

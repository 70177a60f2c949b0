"""Meshes, their files and built-in shapes, cameras, and what stands about the cloth: plain values."""

"""Cloth that moves (XPBD on the GPU), and the built-in cloth that it drapes."""

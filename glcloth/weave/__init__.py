"""Woven structure as plain values: drafts, named weaves, yarn geometry, and the maps whose mean is the far cloth.

draft, named, wif, others, plain, loom: the draft, its files, and the loom that weaves it.
floats, tile: the yarns of one repeat. tangents, colors: the far field.
maps: what shows threads near by. model: the `[weave]` table. report, picture: what `glcloth weave` prints and draws.
"""

"""Woven structure as plain values: drafts, named weaves, yarn geometry, and the maps whose mean is the far cloth.

draft, named, wif, plain: the draft and its files. floats, tile: the yarns of one repeat. tangents, colors: the far field.
maps: what shows threads near by. model: the `[weave]` table. report, picture: what `glcloth weave` prints and draws.
"""

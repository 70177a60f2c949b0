"""Woven structure as plain values: drafts, named weaves, yarn geometry, and the maps whose mean is the far cloth."""

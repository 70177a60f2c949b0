"""Twin of glsl/trace/morton.glsl: Morton codes, and the prefixes of sorted ones."""

import numpy as np


def spread_bits(x):
    """Bit i of x [...], i < 10, at place 3 i.   [Karras 2012]"""
    x = np.asarray(x, np.int64)
    return sum(((x >> i) & 1) << (3 * i) for i in range(10))


def morton_code(p):
    """The 30-bit codes [...] of points p [..., 3] of the unit cube.   [Karras 2012]"""
    cell = np.clip(np.asarray(p, float) * 1024, 0, 1023).astype(np.int64)
    return 4 * spread_bits(cell[..., 0]) + 2 * spread_bits(cell[..., 1]) + spread_bits(cell[..., 2])


def common_prefix(code_1, code_2, place_1, place_2):
    """Leading bits that (code, place) of 64 bits have in common.   [Karras 2012]"""
    one = [f"{int(c):032b}{int(p):032b}" for c, p in zip(np.ravel(code_1), np.ravel(place_1), strict=True)]
    two = [f"{int(c):032b}{int(p):032b}" for c, p in zip(np.ravel(code_2), np.ravel(place_2), strict=True)]
    pairs = zip(one, two, strict=True)
    # Equal places have no bit that differs; findMSB(0) = -1 makes that 64.
    return np.array([next((i for i in range(64) if a[i] != b[i]), 64) for a, b in pairs])

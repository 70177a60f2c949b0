"""Cryptomatte: which share of a pixel belongs to which named thing, so that any of them can be cut out later.

Friedman and Jones, "Fully automatic ID mattes with support for motion blur and transparency" (SIGGRAPH Posters 2015), and
the Cryptomatte specification 1.2.0 (Psyop): MurmurHash3 of names as floats, in ranks by coverage, with a manifest.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

RANKS = 6  # (id, coverage) pairs of a pixel; two to a layer of four channels


def murmur3(data: bytes, seed: int = 0) -> int:
    """MurmurHash3_x86_32.   [Appleby 2011, smhasher]"""
    mask = 0xFFFFFFFF
    h = seed

    def mixed(k: int) -> int:
        k = k * 0xCC9E2D51 & mask
        return (k << 15 | k >> 17) * 0x1B873593 & mask

    whole = len(data) // 4 * 4
    for i in range(0, whole, 4):
        h ^= mixed(int.from_bytes(data[i : i + 4], "little"))
        h = ((h << 13 | h >> 19) & mask) * 5 + 0xE6546B64 & mask
    if len(data) > whole:
        h ^= mixed(int.from_bytes(data[whole:], "little"))
    h ^= len(data)
    h = (h ^ h >> 16) * 0x85EBCA6B & mask
    h = (h ^ h >> 13) * 0xC2B2AE35 & mask
    return h ^ h >> 16


def id_bits(name: str) -> int:
    """The 32 bits of a name's id, as the manifest has them: the hash, kept from exponents of subnormals, infinities and NaN."""
    bits = murmur3(name.encode("utf-8"))
    exponent = bits >> 23 & 255
    return bits ^ (1 << 23) if exponent in (0, 255) else bits


def id_float(name: str) -> np.float32:
    """The id of a name as its pixels have it: the same bits as a float."""
    return np.array(id_bits(name), np.uint32).view(np.float32)[()]


def ranked(coverage: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Pairs of id and coverage, the largest first: float32 [H, W, 2 RANKS].

    coverage : [H, W, N] of N names, each name once
    """
    ids = np.array([id_float(name) for name in names], np.float32)
    height, width, count = coverage.shape
    order = np.argsort(-coverage, axis=-1, kind="stable")[..., :RANKS]
    values = np.take_along_axis(coverage, order, -1)
    out = np.zeros((height, width, RANKS, 2), np.float32)
    out[..., : min(count, RANKS), 0] = np.where(values > 0.0, ids[order], np.float32(0.0))
    out[..., : min(count, RANKS), 1] = values
    return out.reshape(height, width, 2 * RANKS)


def metadata(layer: str, names: Sequence[str]) -> dict[str, str]:
    """The attributes of an EXR file that tell of a layer."""
    key = f"cryptomatte/{murmur3(layer.encode()):08x}"[: len("cryptomatte/") + 7]
    manifest = json.dumps({name: f"{id_bits(name):08x}" for name in names}, ensure_ascii=True, separators=(",", ":"))
    values = {"name": layer, "hash": "MurmurHash3_32", "conversion": "uint32_to_float32", "manifest": manifest}
    return {f"{key}/{name}": value for name, value in values.items()}


def channels(layer: str, pairs: np.ndarray) -> dict[str, np.ndarray]:
    """The channels of a layer by name, two ranks to each part: layer00.R, layer00.G ..."""
    return {f"{layer}{k // 4:02d}.{'RGBA'[k % 4]}": pairs[..., k] for k in range(pairs.shape[-1])}

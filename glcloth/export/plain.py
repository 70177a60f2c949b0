"""A fabric as plain numbers, as plugins of other renderers take it."""

from __future__ import annotations

import math

from ..fabric import Fabric


def numbers_of(fabric: Fabric) -> dict:
    """sigma, gap, and a row for each tangent: yarn, tilt, weight in the sum, in the normaliser, A, eta, k_d, gamma_s, gamma_v."""
    rows = []
    for (j, tilt, _), (weight, norm) in zip(fabric.tangents, fabric.weights.tolist(), strict=True):
        yarn = fabric.yarn[j]
        widths = math.radians(yarn.gamma_s_deg), math.radians(yarn.gamma_v_deg)
        rows.append([j, tilt, weight, norm, list(yarn.albedo), yarn.eta, yarn.k_d, *widths])
    return {"name": fabric.name, "sigma": fabric.sigma, "gap": fabric.gap, "tangents": rows}

"""Compiling ahead of edits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .frame import Frame
from .renderer import Renderer
from .ways import ways

# Numbers of tangents and widths of lobes that need a program each (methods/direct, VARIANTS). More than 8 tangents take
# seconds to compile and are rare: those wait for it. The first comes twice: llvmpipe compiles the very first one anew.
WARM_UP = ((4, 20.0), (4, 4.0), (5, 4.0), (8, 4.0), (4, 20.0))


def warm_up(renderer: Renderer, frame: Frame) -> Iterator[None]:
    """Compile programs that later edits of the weave may need, one way of packing tangents at each step, by drawing a
    frame's scene at 22x18 with other tangents. Without it the first frame of such an edit waits for its compiler. The
    lights stay, so that their visibility need not be traced again.
    """
    warp, weft = frame.fabric.yarn
    plain = {"curve_angles_deg": None, "curve_lengths": None, "samples": None, "shares": None}
    one = weft.changed(**plain, tangents_deg=(0.0,), gamma_s_deg=20.0, gamma_v_deg=20.0)
    for tangents, gamma in WARM_UP:
        tilts = np.linspace(-20.0, 20.0, tangents - 1)
        many = warp.changed(**plain, tangents_deg=tuple(tilts), gamma_s_deg=gamma, gamma_v_deg=2.0 * gamma)
        small = frame.with_cloth(fabric=frame.fabric.changed(yarn=(many, one), weave=None))
        for adaptive in (True, False):
            scene = frame.scene.changed(method="direct", quality="normal", spp=1, adaptive=adaptive, size=(22, 18))
            renderer.draw_aside(replace(small, scene=scene))
            yield
    scene = frame.scene.changed(method="direct", quality="normal", spp=1, adaptive=False, size=(320, 240))
    if ways(renderer.ctx).due(scene):  # in parts, as the window draws, nothing is measured
        renderer.draw_aside(replace(frame, scene=scene))
        yield

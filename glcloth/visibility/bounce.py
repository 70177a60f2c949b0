"""Bounces between surfaces: each vertex collects the radiance of those its rays met, twice; later bounces follow from these.
[own, docs/shadows.md]"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import TextureBuffer
from ..gpu.memo import same
from ..gpu.programs import programs
from ..gpu.scene_buffers import SceneBuffers
from .furnace import Given
from .hit_vertices import HitVertices
from .irradiance import irradiance_table
from .pixels import PixelVisibility
from .sheets import sight
from .vertices import FLAT

EVERYWHERE = 0.5  # flat share of weights that are the same for all directions


class Bounce:
    """Radiance that all vertices send back, and the bounced light that they get: `VertexVisibility.bounced`."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.hit_vertices = HitVertices(ctx)
        self._radiance, self._again = TextureBuffer(ctx, 16), TextureBuffer(ctx, 16)
        self._reflectances = TextureBuffer(ctx, 16)
        self._key: tuple | None = None

    def gather(
        self, surfaces: Sequence[tuple[PixelVisibility, np.ndarray, Given]], source: SceneBuffers
    ) -> Iterator[None]:
        """Find the bounced light at the vertices under the present lights, a part at a time; nothing when it is known.

        Parameters
        ----------
        surfaces : of each in `hit_vertices` its visibility, whose means are made under these lights, and how much it
            reflects: [3], or [V, 4] float32 of each vertex, the same array while nothing changes; and of what
            kind that is
        source : has the lights
        """
        key = tuple(
            (
                *(visibility, visibility.vertices.version, visibility.passed.evenly.tobytes()),
                share.tobytes() if share.ndim == 1 else share,
                given,
            )
            for visibility, share, given in surfaces
        )
        if same(self._key, (key, surfaces[0][0].structure)):
            return
        self._key = None
        for buffer in (self._radiance, self._again):
            buffer.reserve(32 * self.hit_vertices.vertex_count)
        for number, (visibility, share, given) in enumerate(surfaces):
            self._send_back(number, visibility, share, given, source)
        yield
        for visibility, _, given in surfaces:
            visibility.vertices.gather(self._radiance, given.flat_share)
            yield
        for later in (True, False):
            for number, (visibility, share, given) in enumerate(surfaces):
                self._send_again(number, visibility, share, given, later)
            if later:
                for visibility, _, given in surfaces:
                    visibility.vertices.gather(self._again, given.flat_share)
                    yield
        for visibility, _, _ in surfaces:
            # A pixel of cloth knows how its view weighs the directions; a Lambertian's is the cosine.
            visibility.vertices.gather(self._again, EVERYWHERE if visibility.vertices.steepness == FLAT else 0.0)
            yield
        self._key = key, surfaces[0][0].structure

    def _send_back(
        self, number: int, visibility: PixelVisibility, share: np.ndarray, given: Given, source: SceneBuffers
    ) -> None:
        """Make the radiance that the vertices of surface `number` send back."""
        hit, vertices = self.hit_vertices, visibility.vertices
        first, end = hit.first_vertex[number : number + 2]
        defines, virtual, rays = sight(visibility.structure, visibility.sheets)
        program = programs(self.ctx).compute("passes/visibility/bounce_radiance.comp", defines, virtual)
        inputs = rays | source.inputs() | hit.inputs()
        inputs |= irradiance_table(self.ctx, visibility.lights)
        inputs |= {"mean_data": vertices.means, "group_count": vertices.groups, **given._asdict()}
        items = {"first_item": first, "vertex_count": end - first, "offset": hit.offset}
        program.run(end - first, inputs, self._shares(visibility, share), items, Radiance=self._radiance)

    def _send_again(
        self, number: int, visibility: PixelVisibility, share: np.ndarray, given: Given, later: bool
    ) -> None:
        """Make the radiance that they send back with what they gathered in it; `later`: and a guess of later bounces."""
        first, end = self.hit_vertices.first_vertex[number : number + 2]
        inputs = {"radiance_data": self._radiance, "bounced_data": visibility.vertices.bounced}
        items = {"first_item": first, "vertex_count": end - first, "later": later, "upright": given.upright}
        program = programs(self.ctx).compute("passes/visibility/bounce_again.comp")
        program.run(end - first, inputs, self._shares(visibility, share), items, Radiance=self._again)

    def _shares(self, visibility: PixelVisibility, share: np.ndarray) -> dict[str, Any]:
        """What vertices send on of the light on their side and on the other, by the names in GLSL."""
        each = share.ndim > 1
        if each:
            self._reflectances.write(share)
        return {
            "reflectance_data": self._reflectances,
            "own_reflectance": each,
            "reflectance": np.zeros(3) if each else share,
            "passed": visibility.passed.evenly,
        }

"""One bounce between cloth and what stands about it: what the rays of the vertices met, times what that sends back.   [own]

Without anything about the cloth the bounce is that of inputs/visibility/seen_pixels.glsl, which needs none of this.
"""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np

from ..fabric import Fabric
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..gpu.gbuffer import GBuffer
from ..light.lights import Lights
from .hit_vertices import Places
from .pixels import TILE, Shadows, even_directions
from .solids import Around

BOUNCED_UNIT, VIEWS_UNIT = 15, 14
VIEWS = 24, 12  # azimuths and cosines of a viewer
LIGHTS = 1536  # directions of the furnace
REFLECTANCE_UNIT = 14
VERTICES_UNIT = 13


class Gather:
    """Radiance that comes back to cloth and objects: `gather` for their vertices, `fill` for the pixels of a G-buffer."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.places = Places(ctx)
        self._radiance = TextureBuffer(ctx, 16)
        self._sums = TextureBuffer(ctx, 16)
        self._reflectances = TextureBuffer(ctx, 16)
        self._means: dict[Shadows, TextureBuffer] = {}
        self._program = shader.Computes(ctx)
        self._pictures: dict[GBuffer, list] = {}  # texture, what it holds
        self._state: tuple | None = None
        self._views: list | None = None  # directions of light, texture, fabric
        self.version = 0

    def gather(
        self, cloth: Shadows, around: Around, structure, lights: Lights, shared, albedo: np.ndarray
    ) -> Iterator[None]:
        """Find what comes back to the vertices of both under the present lights, a part at a time; nothing when it is known.

        Parameters
        ----------
        cloth : whose vertices' means are made under these lights, as are those of `around`
        shared : SceneBuffers with the lights
        albedo : [3] of the cloth
        """
        versions = cloth.vertices.version, around.shadows.vertices.version
        state = cloth, around, around.objects, versions, albedo.tobytes(), structure
        if self._state == state:
            return
        places = self.places
        self._radiance.reserve(32 * places.vertex_count)
        program = self._program("passes/visibility/bounce_radiance.comp", {"accel.glsl": structure.source})
        structure.bind(program)
        shared.bind(program)
        around.bind_table(lights)
        places.bind(program, 10, VERTICES_UNIT)
        self._reflectances.write(around.vertex_reflectances())
        self._reflectances.bind(REFLECTANCE_UNIT)
        self._radiance.buffer.bind_to_storage_buffer(0)
        first = places.cloth_vertices
        for one, begin, count in ((cloth, 0, first), (around.shadows, first, places.vertex_count - first)):
            one.vertices.means.bind(10)
            shader.set_uniforms(
                program,
                first_item=begin,
                vertex_count=count,
                group_count=one.vertices.groups,
                offset=places.offset,
                own_reflectance=one is not cloth,
                reflectance=tuple(map(float, albedo)),
            )
            program.run(-(-count // 64))
        self.ctx.memory_barrier()
        yield
        self._means = {one: self._means.get(one) or TextureBuffer(self.ctx, 16) for one in (cloth, around.shadows)}
        for one, means in self._means.items():
            one.vertices.gather(self._program, self._radiance, self._sums, means)
            yield
        self._state = state
        self.version += 1

    def fill(self, shadows: Shadows, buffer: GBuffer) -> None:
        """Bring it to the pixels of a G-buffer as it is drawn now."""
        for key in [key for key in self._pictures if key.released]:
            self._pictures.pop(key)[0].release()
        if buffer not in self._pictures:
            texture = self.ctx.texture_array((*buffer.size, 2), 4, dtype="f2")
            texture.filter = moderngl.NEAREST, moderngl.NEAREST
            self._pictures[buffer] = [texture, None]
        texture, holds = self._pictures[buffer]
        state = buffer.drawn, self.version
        if holds == state:
            return
        program = self._program("passes/visibility/bounce_pixels.comp")
        buffer.bind(program)
        buffer.bind_points(program)
        self._means[shadows].bind(9)
        buffer.drawn[0].indices.bind(10)
        texture.bind_to_image(0, read=False, write=True)
        program.run(-(-buffer.size[0] // TILE), -(-buffer.size[1] // TILE))
        self.ctx.memory_barrier()
        self._pictures[buffer][1] = state

    def bind(self, buffer: GBuffer) -> None:
        """Bind what a G-buffer's pixels get back, for a program with `sampler2DArray bounced_light`."""
        self._pictures[buffer][0].use(BOUNCED_UNIT)

    def bind_views(self, fabric: Fabric, shared) -> None:
        """Bind what a fabric, which `shared` holds, gives back toward each viewer of light from everywhere, and how much that
        follows the light's direction; made when the fabric changes."""
        if self._views is None:
            points = np.zeros((LIGHTS, 4), "f4")
            points[:, :3] = even_directions(LIGHTS)
            texture = self.ctx.texture_array((*VIEWS, 2), 4, dtype="f2")
            texture.filter = moderngl.LINEAR, moderngl.LINEAR
            texture.repeat_x, texture.repeat_y = True, False
            self._views = [TextureBuffer(self.ctx, points), texture, None]
        points, texture, of = self._views
        if of is not fabric:
            program = self._program("passes/methods/furnace_views.comp")
            shared.bind(program)
            points.bind(9)
            texture.bind_to_image(0, read=False, write=True)
            shader.set_uniforms(program, light_count=LIGHTS)
            program.run(-(-VIEWS[0] // TILE), -(-VIEWS[1] // TILE))
            self.ctx.memory_barrier()
            self._views[2] = fabric
        texture.use(VIEWS_UNIT)

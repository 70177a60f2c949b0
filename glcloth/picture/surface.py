"""A surface is drawn, sees the lights and is shaded: the contract of cloth and of objects."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

import moderngl
import numpy as np

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..gpu.covered import Way
from ..gpu.gbuffer import GBuffer, MeshBuffers
from ..gpu.memo import Last
from ..gpu.programs import Draw, programs
from ..visibility.furnace import Given
from ..visibility.hit_vertices import HitSurface
from ..visibility.pixels import PixelView, PixelVisibility
from .frame import Frame
from .pace import Pace


class Surface(ABC):
    """One mesh of a frame on the GPU.

    A frame draws each of its surfaces (`buffers` into a G-buffer of its own), lets it see (`visibility`, and a view of it
    for the pixels), and shades it. To be another kind of surface is to say how it is shaded.
    """

    buffers: MeshBuffers  # as it is drawn
    original: Mesh  # as it hides light
    pass_count = 1  # additive passes over a picture
    sheer = False  # whether what is behind it is seen through it
    way: Way = "fragment"  # how its pixels are shaded
    adaptive = False  # whether it shades all its pixels by `shade_adaptively`, before the others

    def __init__(self, ctx: moderngl.Context, steepness: float):
        """`steepness`: see `VertexVisibility`."""
        self.ctx = ctx
        self.visibility = PixelVisibility(ctx, steepness)
        self._buffers: Last[MeshBuffers] = Last(frees=True)

    def _place(self, make: Callable[[], MeshBuffers], *key: Any) -> None:
        """Put another mesh on the GPU where the key changes; the one before is freed."""
        self.buffers = self._buffers.get(make, *key)

    @property
    def mesh(self) -> Mesh:
        """The mesh as it is drawn."""
        return self.buffers.mesh

    @property
    @abstractmethod
    def broad(self) -> np.ndarray | None:
        """How much [K] of each Gaussian is summed with others before its visibility is known; None: every one alone."""

    @property
    @abstractmethod
    def hit_surface(self) -> HitSurface:
        """The surface as rays from others meet it."""

    @property
    @abstractmethod
    def reflectance(self) -> np.ndarray:
        """How much of the light that comes evenly from everywhere goes back: [3], or [V, 4] of each vertex; the same
        array while nothing changes."""

    @property
    def given(self) -> Given:
        """How what goes back differs from a Lambertian's."""
        return Given()

    @property
    def catches(self) -> bool:
        """Whether a part of it shows its shadow alone."""
        return False

    @property
    def shown_triangles(self) -> int:
        """How many triangles, from the first, are things of the picture: not those of a ground that shows its shadow alone."""
        return len(self.mesh.triangles)

    def albedo_at(self, triangles: np.ndarray, uv: np.ndarray) -> np.ndarray:
        """The share of even light [3] or [N, 3] that goes back where triangles [N] are seen, at UVs [N, 2]."""
        return np.asarray(self.reflectance)[:3]

    def identities(self, frame: Frame, number: int) -> list[tuple[int, str, str]]:
        """The things that it shows: for each the last of its triangles + 1, its name and that of its material; `number`: its
        own among the surfaces of a frame."""
        cloth = frame.cloths[number]
        before = sum(other.mesh.name == cloth.mesh.name for other in frame.cloths[:number])
        name = f"{cloth.mesh.name}.{before + 1}" if before else cloth.mesh.name
        return [(len(self.mesh.triangles), name, cloth.fabric.name)]

    def depth_range(self, camera: Camera) -> tuple[float, float]:
        """Near and far distance of all that may be seen of it."""
        return camera.depth_range(self.buffers.low, self.buffers.high)

    def see(self, view: PixelView, sample: tuple[int, int], pace: Pace) -> Iterator[None]:
        """Find how far the pixels of a view see the lights; `sample`: its number, and how many there are."""
        view.visibility.integrate(self.broad)
        yield from pace.pause(self.ctx)
        view.resolve(self.broad, sample)
        yield from pace.pause(self.ctx)
        if not pace.preview:
            for _ in view.edges(pace.slice):
                yield from pace.pause(self.ctx)

    def straight_program(self, buffer: GBuffer) -> Draw:
        """Where it is `sheer`: the program that says how much of the light behind it is left."""
        return programs(self.ctx).screen("passes/picture/left.frag")

    def straight_inputs(self, buffer: GBuffer) -> dict[str, Any]:
        """Where it is `sheer`: what inputs/picture/straight.glsl reads."""
        raise NotImplementedError

    @abstractmethod
    def shade(
        self, buffer: GBuffer, view: PixelView, number: int, weight: float, add: bool, rows: tuple[int, int] | None
    ) -> None:
        """Shade the pixels that see it.

        Parameters
        ----------
        view : how far these pixels see the lights
        number : of the pass
        weight : of this sample in a pixel
        add : to the present picture
        rows : (first, count), counted from below: only these
        """

    def shade_adaptively(self, buffer: GBuffer, view: PixelView, pace: Pace) -> Iterator[None]:
        """Shade all pixels that see it in one go, at a rate of its own."""
        raise NotImplementedError

"""The view of a scene that a traced picture shows, how it is traced, and the costs of the last one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..errors import InputError
from ..fabric import Fabric, Transmission
from ..geometry.camera import Camera, lens_samples, sample_offsets
from ..light.environment import Environment
from .lamp import Lighting

DEEPEST = 8
MOST_FABRICS = 4
MOST_SPP = 4096


@dataclass(frozen=True)
class TraceSettings:
    """How a picture is traced.

    depth : generations of rays, 1 to 8 (the paper's level 4). spp : samples per pixel. spread : draw transmitted
    directions from the fabric's lobes, so that the view through the yarns blurs (needs many samples) instead of going
    straight on. cutoff : rays that count for less are not followed. accelerator : kdtree, kdtree_median, lbvh or brute.
    """

    depth: int = 4
    spp: int = 1
    spread: bool = False
    cutoff: float = 1e-3
    accelerator: str = "kdtree"

    def __post_init__(self) -> None:
        if not 1 <= self.depth <= DEEPEST:
            raise InputError(f"depth = {self.depth}, expected 1 to {DEEPEST} generations of rays")
        if not 1 <= self.spp <= MOST_SPP:
            raise InputError(f"spp = {self.spp}, expected 1 to {MOST_SPP} samples per pixel")
        if not 0 <= self.cutoff < 1:
            raise InputError(f"cutoff = {self.cutoff}, expected 0 or more and less than 1")


@dataclass(frozen=True)
class HangingGrid:
    """Where the cloth of a scene is a grid of vertices, which says how it lies on its weave.

    first : number of its first triangle; two to a quad, row by row. quads : a row. size : metres of flat cloth that a quad
    measures along a row and down a column. low, high : corners of a box in which the cloth hangs. count : triangles of a piece
    of cloth, of which several follow one another; 0: all are of one.
    """

    first: int
    quads: int
    size: tuple[float, float]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    count: int = 0


@dataclass(frozen=True)
class Shot:
    """A view of a scene, and how it is traced.

    size : width, height in pixels. environment : seen by rays that leave the scene, turned by `env_rotate` degrees.
    offsets : where in the pixel the samples lie, from its centre; default: the R2 sequence of `settings.spp` points.
    indirect : inputs of `indirect_source`, the light from around the room instead of the lighting's `ambient`.
    renewed : finds such inputs anew for each sample of the pixels, in steps, the last of which brings them.
    grid : of the cloth; with it the holes of a fabric's weave are seen, and the light that falls through them.
    others : more fabrics, each that of the cloth from a triangle on, in their order; `fabric` is that of the cloth before.
    other_grids : of the cloth of each of these, as `grid`; missing: it shows no threads and no holes.
    parted : keep the kinds of light of the pixels apart, for `Tracer.parts`.
    """

    camera: Camera
    size: tuple[int, int]
    fabric: Fabric
    lighting: Lighting = field(default_factory=Lighting)
    environment: Environment | None = None
    settings: TraceSettings = TraceSettings()
    env_rotate: float = 0.0
    offsets: tuple[tuple[float, float], ...] | None = None
    indirect: Mapping[str, Any] | None = None
    indirect_source: str = "inputs/tracing/indirect.glsl"
    renewed: Callable[[int], Iterator[Mapping[str, Any]]] | None = None
    grid: HangingGrid | None = None
    others: tuple[tuple[int, Fabric], ...] = ()
    other_grids: tuple[HangingGrid, ...] = ()
    parted: bool = False

    def __post_init__(self) -> None:
        for fabric in self.fabrics:
            if fabric.transmission is None:
                raise InputError(
                    f"fabric {fabric.name}: has no [transmission], which the ray tracer needs; add the block, or take "
                    "sheer_voile"
                )
        if len(self.fabrics) > MOST_FABRICS:
            raise InputError(
                f"{len(self.fabrics)} fabrics in one picture, expected at most {MOST_FABRICS}; leave some out"
            )

    @property
    def fabrics(self) -> tuple[Fabric, ...]:
        """All of them, in the order of their triangles."""
        return self.fabric, *(fabric for _, fabric in self.others)

    @property
    def grids(self) -> tuple[HangingGrid | None, ...]:
        """Of the cloth of each of them; None: where it lies on its weave is not known."""
        missing = len(self.others) - len(self.other_grids)
        return self.grid, *self.other_grids, *[None] * missing

    @property
    def samples(self) -> Sequence[tuple[float, float]]:
        """Where in the pixel the samples lie."""
        return self.offsets or sample_offsets(self.settings.spp)

    @property
    def cameras(self) -> Sequence[Camera]:
        """The camera of each sample: the point of the lens that it goes through."""
        return lens_samples(self.camera, len(self.samples))

    @property
    def transmission(self) -> Transmission:
        """How light passes through the fabric."""
        assert self.fabric.transmission is not None
        return self.fabric.transmission


@dataclass
class TraceStatistics:
    """Costs of the last picture: rays and shadow rays per generation, how many rays were heads of a straight way and so
    were cast, ms of each stage per generation (`build` by the structure's stages), ms in all."""

    rays: list[int] = field(default_factory=list)
    heads: list[int] = field(default_factory=list)
    shadow_rays: list[int] = field(default_factory=list)
    trace_ms: list[float] = field(default_factory=list)
    shade_ms: list[float] = field(default_factory=list)
    shadow_ms: list[float] = field(default_factory=list)
    build_ms: dict[str, float] = field(default_factory=dict)
    total_ms: float = 0.0

    def add(self, level: int, rays: int, heads: int, shadow_rays: int, stages_ms: Sequence[float]) -> None:
        """Add one generation of one tile; `stages_ms`: trace, shade, shadow."""
        columns: tuple[list, ...] = (
            self.rays,
            self.heads,
            self.shadow_rays,
            self.trace_ms,
            self.shade_ms,
            self.shadow_ms,
        )
        for column, value in zip(columns, (rays, heads, shadow_rays, *stages_ms), strict=True):
            column.extend([0] * (level + 1 - len(column)))
            column[level] += value

"""What paths meet: cloths, objects, a ground; and the pictures on them, on the GPU."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..fabric import Fabric
from ..geometry.mesh import Mesh
from ..gpu.buffers import TextureBuffer
from ..gpu.memo import Last
from ..gpu.pictures import even_size, picture_array, resampled

MOST_TEXELS = 1 << 24  # of all pictures together, 128 MiB


class Map(NamedTuple):
    """A picture [H, W, 3 or 1] over the UVs, linear, the first row at v = 0, and how often it repeats in a UV unit."""

    texels: np.ndarray
    repeats: tuple[float, float] = (1.0, 1.0)


class Maps(NamedTuple):
    """What the colours of a cloth's yarns are multiplied by, and how much of a place is closed."""

    print: Map | None = None
    opacity: Map | None = None


class Mask(NamedTuple):
    """Which of several fabrics a place of a cloth has: numbers [H, W] uint8 over the UVs, the first row at v = 0, how often
    it repeats in a UV unit, and the fabrics of the numbers from 1 on; 0 is the cloth's own."""

    numbers: np.ndarray
    repeats: tuple[float, float]
    fabrics: tuple[Fabric, ...]


class Painted(NamedTuple):
    """Pictures of an object, and the number of each triangle's [T], -1: none. They multiply what it reflects."""

    pictures: tuple[np.ndarray, ...]
    picture_of: np.ndarray


class Catcher(NamedTuple):
    """Where the shadow on a ground is seen that shows nothing else: x and z of a middle, and from which distance on to which
    one it fades out, m."""

    middle: tuple[float, float]
    fade: tuple[float, float]


@dataclass(frozen=True, eq=False)
class PathWorld:
    """What paths meet.

    Parameters
    ----------
    cloths : meshes with their fabrics, at least one
    solids : other meshes with what each triangle reflects, [T, 3], all matt
    ground : height and reflectance [3] of a plane without end; None: there is none
    catcher : of the ground the eye sees its shadow alone; None: the ground itself
    maps : of the cloths; (): none has any
    painted : the objects' pictures; (): none has any
    masks : of the cloths; (): none has any
    """

    cloths: tuple[tuple[Mesh, Fabric], ...]
    solids: tuple[tuple[Mesh, np.ndarray], ...] = ()
    ground: tuple[float, tuple[float, float, float]] | None = None
    catcher: Catcher | None = None
    maps: tuple[Maps, ...] = ()
    painted: tuple[Painted | None, ...] = ()
    masks: tuple[Mask | None, ...] = ()

    @property
    def key(self) -> tuple:
        """What its buffers are made of."""
        return self.cloths, self.solids, self.ground, self.catcher, self.maps, self.painted, self.masks

    @property
    def worn(self) -> list[tuple[int, Fabric]]:
        """All fabrics, each with the number of its cloth: its own, then those of its mask."""
        masks = self.masks or (None,) * len(self.cloths)
        return [
            (k, fabric)
            for k, ((_, own), mask) in enumerate(zip(self.cloths, masks, strict=True))
            for fabric in (own, *(mask.fabrics if mask is not None else ()))
        ]

    @property
    def passing(self) -> tuple[bool, ...]:
        """Whether light may pass each cloth."""
        passing = [maps.opacity is not None for maps in self.maps] or [False] * len(self.cloths)
        for k, fabric in self.worn:
            passing[k] |= fabric.transmission is not None
        return tuple(passing)


class Numbers(NamedTuple):
    """Numbers of pictures: of each cloth's print and opacity [C, 2] with their repeats [C, 4], the first row of each one's mask
    [C], its width, height and repeats [C, 4], of each triangle of the objects and of the ground [T + 1]; -1: none."""

    of_cloths: np.ndarray
    repeats: np.ndarray
    mask_rows: np.ndarray
    masks: np.ndarray
    of_solids: np.ndarray


class PathPictureArray:
    """The pictures of a world in one array, and the UVs of its vertices."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.any = False
        self._uv = TextureBuffer(ctx, 16)
        self._words = TextureBuffer(ctx, 4, "r32ui")
        self._stride = 1
        self._array: moderngl.TextureArray | None = None
        self._placed: Last[None] = Last()

    def take(self, world: PathWorld) -> Numbers:
        """Upload them."""
        layers: list[np.ndarray] = []
        of_cloths, repeats = np.full((len(world.cloths), 2), -1.0), np.ones((len(world.cloths), 4))
        for k, maps in enumerate(world.maps):
            for which, one in enumerate(maps):
                if one is not None:
                    of_cloths[k, which], repeats[k, 2 * which : 2 * which + 2] = len(layers), one.repeats
                    layers.append(np.broadcast_to(one.texels, (*one.texels.shape[:2], 3)))
        of_solids = [np.full(len(mesh.triangles), -1.0) for mesh, _ in world.solids]
        for numbers, painted in zip(of_solids, world.painted, strict=False):
            if painted is not None:
                numbers[:] = np.where(painted.picture_of < 0, -1.0, painted.picture_of + len(layers))
                layers += painted.pictures
        mask_rows, masks = self._take_masks(world)
        self.any = bool(layers) or bool((mask_rows >= 0.0).any())
        if self.any:
            white = np.ones((1, 1, 3), np.float32)
            self._put(layers or [white])
            self.uv_inputs(world)
        return Numbers(of_cloths, repeats, mask_rows, masks, np.concatenate([*of_solids, [-1.0]]))

    def _take_masks(self, world: PathWorld) -> tuple[np.ndarray, np.ndarray]:
        """Upload the masks, each once, one below the other: their first rows and their sizes and repeats."""
        rows, looks = np.full(len(world.cloths), -1.0), np.ones((len(world.cloths), 4))
        numbers = {id(mask.numbers): mask.numbers for mask in world.masks if mask is not None}
        words = -(-max((one.shape[1] for one in numbers.values()), default=1) // 4)
        first = dict(zip(numbers, np.cumsum([0, *(len(one) for one in numbers.values())]).tolist(), strict=False))
        texels = np.zeros((sum(map(len, numbers.values())), 4 * words), np.uint8)
        for key, one in numbers.items():
            texels[first[key] : first[key] + len(one), : one.shape[1]] = one
        for k, mask in enumerate(world.masks):
            if mask is not None:
                height, width = mask.numbers.shape
                rows[k], looks[k] = first[id(mask.numbers)], (width, height, *mask.repeats)
        self._stride = words
        self._words.write(texels.view("<u4"))
        return rows, looks

    def uv_inputs(self, world: PathWorld) -> dict[str, Any]:
        """The UVs of all vertices of a world, by their name in GLSL."""
        meshes = tuple(mesh for mesh, _ in (*world.cloths, *world.solids))
        self._placed.get(lambda: self._place(meshes), meshes)
        return {"surface_uv": self._uv}

    def _place(self, meshes: tuple[Mesh, ...]) -> None:
        uv = [np.zeros((len(mesh.positions), 2)) if mesh.uv is None else np.nan_to_num(mesh.uv) for mesh in meshes]
        self._uv.write(np.pad(np.concatenate(uv), ((0, 0), (0, 2))).astype("f4"))

    def _put(self, layers: list[np.ndarray]) -> None:
        self._release_array()
        height, width = (max(layer.shape[k] for layer in layers) for k in (0, 1))
        size = even_size(height, width, MOST_TEXELS // len(layers))
        self._array = picture_array(self.ctx, np.stack([resampled(layer, size) for layer in layers]))

    def inputs(self) -> dict[str, Any]:
        """By their names in GLSL."""
        if not self.any:
            return {}
        masks = {"mask_words": self._words, "mask_stride": self._stride}
        return {"surface_pictures": self._array, "surface_uv": self._uv, **masks}

    def _release_array(self) -> None:
        if self._array is not None:
            self._array.release()
        self._array = None

    def release(self) -> None:
        """Free the GPU's memory."""
        self._release_array()
        self._uv.release()
        self._words.release()

"""Layers for compositing: what pixels see, and the parts of their light, beside the picture itself."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..cryptomatte import channels, metadata, ranked
from ..errors import InputError, meant
from ..geometry.camera import Camera
from ..gpu.buffers import read_texture
from ..gpu.gbuffer import GBuffer

if TYPE_CHECKING:
    from .frame import Frame
    from .surface import Surface
    from .target import Target

FAR = 1e10  # depth where nothing is
# The channels of each layer in an EXR file; cryptomatte has its own.
CHANNELS = {
    "depth": ("Z",),
    "normal": ("N.X", "N.Y", "N.Z"),
    "position": ("P.X", "P.Y", "P.Z"),
    "uv": ("uv.U", "uv.V"),
    "albedo": ("albedo.R", "albedo.G", "albedo.B"),
    "direct": ("direct.R", "direct.G", "direct.B"),
    "bounce": ("bounce.R", "bounce.G", "bounce.B"),
    "transmission": ("transmission.R", "transmission.G", "transmission.B"),
    "background": ("background.R", "background.G", "background.B"),
    "mask": ("mask.A",),
}
LIGHT = ("direct", "bounce", "transmission", "background")  # their sum is the picture
PATH_SAMPLES = 16  # that layers of geometry have by method path, whose own samples may be a million
CRYPTOMATTE = ("CryptoObject", "CryptoMaterial")
AOVS = (*CHANNELS, "cryptomatte")


def chosen(names: str | Iterable[str], method: str = "") -> tuple[str, ...]:
    """The names of layers, each once; a text has them with commas between, `all` is all that the method has.

    Raises InputError for unknown ones, and for layers of light by method path, whose paths are one sum.
    """
    names = names.split(",") if isinstance(names, str) else list(names)
    names = [str(name).strip() for name in names]
    if "all" in names:
        return tuple(name for name in AOVS if method != "path" or name not in LIGHT)
    for name in names:
        if name not in AOVS:
            raise InputError(f"aov {name!r}: unknown; {meant(name, AOVS)}expected some of {','.join(AOVS)}, or all")
        if method == "path" and name in LIGHT:
            raise InputError(
                f"aov {name}: method path keeps kinds of light in one sum; take another method, or leave it out"
            )
    return tuple(dict.fromkeys(names))


class Layers(dict):
    """Arrays by name: "beauty" [H, W, 3 or 4] and those that were asked for, float32, top row first.

    A layer of one value is [H, W]; of cryptomatte there are "CryptoObject" and "CryptoMaterial" [H, W, 12], pairs of id
    and coverage. `names` are those of their ids.
    """

    def __init__(self) -> None:
        super().__init__()
        self.names: dict[str, list[str]] = {}

    def _repr_png_(self) -> bytes | None:
        """The picture itself, in a notebook."""
        return self["beauty"]._repr_png_()

    def channels(self) -> dict[str, np.ndarray]:
        """All but the beauty by the names of channels in an EXR file, [H, W] each."""
        out: dict[str, np.ndarray] = {}
        for name, array in self.items():
            if name in CRYPTOMATTE:
                out |= channels(name, array)
            elif name != "beauty":
                out |= dict(zip(CHANNELS[name], np.moveaxis(np.atleast_3d(array), -1, 0), strict=True))
        return out

    def attributes(self) -> dict[str, str]:
        """Attributes of an EXR file that tell of these layers."""
        return {key: value for layer, names in self.names.items() for key, value in metadata(layer, names).items()}


class Gathering:
    """Adds up layers while a frame is drawn, sample by sample.

    A sample weighs its share of the pixel; what it does not cover counts as 0, as in premultiplied colours. Depth is that of
    the first sample, which goes through the pixel's centre: distances of two things have no mean.
    """

    def __init__(self, names: Sequence[str], frame: Frame):
        self.frame, self.names = frame, names
        width, height = frame.scene.size
        self._samples = frame.scene.spp
        self._sums = {
            name: np.zeros((height, width, len(CHANNELS[name])))
            for name in names
            if name in CHANNELS and name not in (*LIGHT, "depth")
        }
        self._depth = np.full((height, width), FAR, np.float32)
        self._coverage: dict[str, dict[str, np.ndarray]] = {layer: {} for layer in CRYPTOMATTE}
        self._lit: dict[str, np.ndarray] = {}

    # -- while it is drawn -------------------------------------------------------------------------------------------

    def see(self, target: Target, surfaces: Sequence[Surface], camera: Camera, number: int) -> None:
        """Take sample `number` of all pixels."""
        cloths = len(self.frame.cloths)
        for place, surface in enumerate(surfaces):
            seen = _seen(target.part(surface).buffer, surface.shown_triangles)
            if not len(seen.rows):
                continue
            x = _interpolated(surface.mesh.positions, surface.mesh.triangles[seen.triangles], seen.weights)
            if number == 0 and "depth" in self.names:
                self._depth[seen.rows, seen.columns] = (x - camera.eye) @ camera.axes[2]
            for name, total in self._sums.items():
                value = x if name == "position" else _value(name, surface, seen, place < cloths)
                total[seen.rows, seen.columns] += np.reshape(value, (-1, total.shape[-1])) / self._samples
            if "cryptomatte" in self.names:
                self._cover(seen, surface.identities(self.frame, place))

    def _cover(self, seen: _Seen, identities: Sequence[tuple[int, str, str]]) -> None:
        """Count which thing of a surface covers which pixels; `identities`: last triangle + 1, object, material of each."""
        ends = np.array([end for end, _, _ in identities])
        which = np.searchsorted(ends, seen.triangles, side="right")
        for thing in np.unique(which):
            mine = which == thing
            for layer, name in zip(CRYPTOMATTE, identities[thing][1:], strict=True):
                height, width = self._depth.shape
                total = self._coverage[layer].setdefault(name, np.zeros((height, width)))
                total[seen.rows[mine], seen.columns[mine]] += 1.0 / self._samples

    def shaded(self, target: Target) -> None:
        """Take the light, before anything is drawn behind it."""
        whole = target.read()[..., :3].astype(float)
        parts = {name: target.read(name)[..., :3].astype(float) for name in ("bounce", "transmission")}
        self._lit = {"direct": whole - parts["bounce"] - parts["transmission"], **parts, "whole": whole}

    def result(self, picture: np.ndarray) -> Layers:
        """All layers, of this picture."""
        out = Layers()
        out["beauty"] = picture
        lit = {**self._lit, "background": picture[..., :3] - self._lit["whole"]} if self._lit else {}
        for name in self.names:
            if name == "cryptomatte":
                for layer, coverage in self._coverage.items():
                    things = sorted(coverage)
                    empty = np.zeros((*self._depth.shape, 0))
                    out[layer] = ranked(np.stack([coverage[n] for n in things], -1) if things else empty, things)
                    out.names[layer] = things
            elif name == "depth":
                out[name] = self._depth
            else:
                array = lit[name] if name in LIGHT else self._sums[name]
                out[name] = (
                    np.squeeze(array.astype(np.float32), -1) if array.shape[-1] == 1 else array.astype(np.float32)
                )
        return out


class _Seen:
    """The pixels [N] that see a surface, top row first, and what each sees: normal, triangle, weights of its corners."""

    def __init__(self, N: np.ndarray, p: np.ndarray, b: np.ndarray):
        self.rows, self.columns = np.nonzero(N[..., 3])
        self.normals = N[self.rows, self.columns, :3]
        self.triangles = p[self.rows, self.columns, 3].astype(int)
        b = b[self.rows, self.columns].astype(float)
        self.weights = np.concatenate([1.0 - b.sum(1, keepdims=True), b], 1)


def _seen(buffer: GBuffer, triangles: int) -> _Seen:
    """The pixels that see one of the first `triangles`."""
    width, height = buffer.size

    def read(name: str) -> np.ndarray:
        texture = buffer.frame(name)
        return np.frombuffer(read_texture(texture), "f4").reshape(height, width, texture.components)[::-1]

    N, p = read("frame_N"), read("frame_p")
    if (p[..., 3] >= triangles).any():
        N = np.where(p[..., 3:] < triangles, N, 0.0)
    return _Seen(N, p, read("frame_b"))


def _value(name: str, surface: Surface, seen: _Seen, is_cloth: bool) -> np.ndarray:
    """A layer where the pixels see a surface: [N, n], or one for all."""
    if name == "normal":
        return seen.normals
    if name == "mask":
        return np.array(float(is_cloth))
    mesh = surface.mesh
    uv = _interpolated(mesh.uv, mesh.triangles[seen.triangles], seen.weights)
    return uv if name == "uv" else surface.albedo_at(seen.triangles, uv)


def _interpolated(values: np.ndarray | None, corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """A value of the vertices where the pixels see them; 0 where the mesh has none."""
    if values is None:
        return np.zeros((len(corners), 2))
    return (np.asarray(values, float)[corners] * weights[..., None]).sum(1)

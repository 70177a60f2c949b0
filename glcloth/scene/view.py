"""The camera of a scene, and cameras under names."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from pydantic import ConfigDict, field_validator

from ..fields import Value, about
from .kinds import Vec3, option

if TYPE_CHECKING:
    from ..geometry.camera import Camera


class View(Value):
    """The camera of a scene; missing values follow from the mesh, or are those of the curtain's room."""

    model_config = ConfigDict(title="camera")

    # fmt: off
    view: str | None = option(
        "", "framed by the size of the cloth: front, three-quarter, side, back, close; or a camera of the mesh's .glb or "
        ".gltf file by its name, or file for its only one", default=None)
    eye: Vec3 | None = option("m", "where the camera is, X,Y,Z", default=None)
    target: Vec3 | None = option("m", "what it looks at, X,Y,Z", default=None)
    up: Vec3 | None = option("", "direction that is up in the picture, X,Y,Z; none: +Y, or as the view has it", default=None)
    fov_deg: float | None = about(
        "degrees", "angle of view, from top to bottom", default=None, option="--fov", ge=1, le=170)
    ortho: float | None = option(
        "m", "parallel rays instead of an angle of view: height of the picture", default=None, gt=0, le=1e6)
    aperture: float = option(
        "m", "diameter of the lens, which blurs what is not at the focus; by the samples per pixel", default=0.0, ge=0, le=10)
    focus: float | None = option(
        "m", "distance along the view of what is sharp; none: that of the target", default=None, gt=0, le=1e6)
    # fmt: on

    @classmethod
    def of(cls, camera: Camera) -> View:
        """A camera as a scene keeps it."""
        angle = {"fov_deg": camera.fov_deg} if camera.ortho is None else {"ortho": camera.ortho}
        lens = {"aperture": camera.aperture} if camera.aperture else {}
        focus = {} if camera.focus is None else {"focus": camera.focus}
        return cls(eye=camera.eye, target=camera.target, up=camera.up, **angle, **lens, **focus)

    def over(self, base: Camera) -> Camera:
        """The camera, its missing values taken from another. Raises InputError where they do not go together."""
        from ..geometry.camera import Camera

        ortho = self.ortho or (base.ortho if self.fov_deg is None else None)
        place = self.eye or base.eye, self.target or base.target, self.up or base.up
        return Camera(*place, self.fov_deg or base.fov_deg, ortho, self.aperture, self.focus)

    @field_validator("eye", "target", "up", mode="before")
    @classmethod
    def _numbers(cls, value):
        if not isinstance(value, str):
            return value
        try:
            numbers = tuple(float(v) for v in value.split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
            raise ValueError(f"expected X,Y,Z such as 0,1.5,3, not {value!r}")
        return numbers


class Bookmark(Value):
    """A camera under a name."""

    model_config = ConfigDict(title="bookmark")

    name: str = about("", "of the bookmark", min_length=1)
    camera: View = about("", "the camera, a table")

"""Sequences: the pictures of a scene one after the other, while cloth, camera or light moves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh, relative_to
from ..geometry.props import Objects
from ..light.environment import rotation_y
from ..progress import drain
from ..scene import Scene
from .frame import Frame
from .renderer import Renderer

POSES = 4  # until every direction of a vertex that follows is looked into again


@dataclass(frozen=True)
class Motion:
    """What moves in a sequence of cloth under an environment; the curtain moves in its wind.

    Parameters
    ----------
    frames : of the whole sequence
    poses : the mesh of each frame, asked for in ascending order; its shadows follow it (`Renderer.follow_poses`); None: the
        cloth rests
    first : the first pose that there is
    turntable : one turn of the camera around the cloth
    turn_env : degrees by which the environment turns; frame number `frames` would have turned by all of them
    """

    frames: int
    poses: Callable[[int], Mesh] | None = None
    first: int = 0
    turntable: bool = False
    turn_env: float = 0.0

    def at(self, renderer: Renderer, still: Frame, number: int) -> Frame:
        """A frame of the sequence; `still` holds all that does not change."""
        scene = still.scene
        if self.turn_env:
            scene = scene.model_copy(update={"env_rotate": scene.env_rotate + self.turn_env * number / self.frames})
        return renderer.prepare(
            scene,
            mesh=None if self.poses is None else relative_to(self.poses(number), still.mesh.origin),
            cloths=still.cloths if self.poses is None else (),
            environment=still.environment,
            lights=None if self.turn_env else still.lights,
            camera=orbit(still.camera, 360.0 * number / self.frames) if self.turntable else still.camera,
            objects=still.objects or Objects(),
        )


def orbit(camera: Camera, degrees: float) -> Camera:
    """The camera turned about the vertical through its target; positive is counter-clockwise seen from above."""
    turned = np.array(camera.target) + rotation_y(degrees) @ np.subtract(camera.eye, camera.target)
    return replace(camera, eye=tuple(turned))


def pictures(
    renderer: Renderer, scene: Scene, motion: Motion, start: int = 0, aovs: Sequence[str] = ()
) -> Iterator[Any]:
    """Yield the pictures of a sequence from frame `start` on; with `aovs` their layers, as `Renderer.render` has them.

    Vertices keep visibility from four poses: a sequence that begins at `start` traces the poses before it, too. The
    bits are as in the whole sequence but for where rays start, which the first traced pose decides.
    """
    # Rounds of four poses: each traces directions of its own.
    traced = max(motion.first, (start // POSES - 1) * POSES)
    yield from _pictures(renderer, scene, motion, range(start, motion.frames), traced, aovs)


def chosen(
    renderer: Renderer, scene: Scene, motion: Motion, numbers: Iterable[int], aovs: Sequence[str] = ()
) -> Iterator[Any]:
    """As `pictures`, of some frames, their numbers ascending, with the bits of the whole sequence: of cloth that moves, all
    poses before a frame are traced."""
    yield from _pictures(renderer, scene, motion, numbers, motion.first, aovs)


def _pictures(
    renderer: Renderer, scene: Scene, motion: Motion, numbers: Iterable[int], traced: int, aovs: Sequence[str]
) -> Iterator[Any]:
    """`traced`: the first pose whose shadows are traced, though it may not be shown."""
    if scene.curtain is not None:
        for number in numbers:
            yield renderer.render(scene.changed(frame=number), aovs=aovs)
        return
    still = renderer.prepare(scene)
    renderer.follow_poses(motion.poses is not None)
    for number in numbers:
        for before in range(traced, number) if motion.poses is not None else ():
            drain(renderer.trace_visibility(motion.at(renderer, still, before)))
        traced = number + 1
        frame = motion.at(renderer, still, number)
        yield renderer.render_layers(frame, aovs) if aovs else renderer.render_frame(frame)

"""A sequence of pictures as one plain value, of which any process renders any frame."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..geometry.mesh import Mesh
from ..picture import sequence, sequence_files
from ..picture.cloths import load_meshes
from ..picture.renderer import Renderer
from ..scene import Scene, header
from ..simulation.drape import Swaying


@dataclass(frozen=True)
class Film:
    """A sequence, with all that determines its frames.

    scene : for all frames; a mesh such as poses/%04d.ply gives each frame its own
    output : pattern of the frames' files, such as frames/%04d.png
    frames, rate : how many in all, and per second
    wind : m/s, of the built-in cloth; None: it rests
    turntable : one turn of the camera around the cloth; None: where nothing else moves
    turn_env : degrees by which the environment turns over the sequence
    since : the first frame that is wanted; poses before it need not be there
    aovs : layers of each frame
    """

    scene: Scene
    output: str
    frames: int
    rate: int = 24
    wind: float | None = None
    turntable: bool | None = None
    turn_env: float = 0.0
    device: int | str | None = None
    since: int = 0
    aovs: tuple[str, ...] = ()

    @functools.cached_property
    def files(self) -> dict[int, Path] | None:
        """The poses' files, if the cloth has such. Raises InputError for one that is missing."""
        return sequence_files.pose_files(self.scene.mesh, self.frames, self.since) if "%" in self.scene.mesh else None

    @property
    def first(self) -> int:
        """The first pose that there is."""
        return min(self.files or (0,))

    @functools.cached_property
    def start(self) -> Scene:
        """The scene as it is prepared: with the first pose, and with the rate of a curtain."""
        if self.files:
            first = str(self.files[self.first])
            return self.scene.changed(mesh=first, units=load_meshes([first], self.scene.units)[1])  # of all poses
        return self.scene if self.scene.curtain is None else self.scene.changed(rate=self.rate)

    @property
    def around(self) -> bool:
        """Whether the camera goes round the cloth."""
        moves = self.files is not None or self.wind is not None or self.scene.curtain is not None
        return not (moves or self.turn_env) if self.turntable is None else self.turntable

    def motion(self, renderer: Renderer, stack: ExitStack) -> sequence.Motion:
        """What moves in it; `stack` ends a simulation."""
        return sequence.Motion(self.frames, self._poses(renderer, stack), self.first, self.around, self.turn_env)

    def _poses(self, renderer: Renderer, stack: ExitStack) -> Callable[[int], Mesh] | None:
        if (files := self.files) is not None:
            return lambda number: load_meshes([str(files[number])], self.start.units)[0][0]
        if self.wind is None:
            return None
        swaying = Swaying(renderer.ctx, self.wind)
        stack.callback(swaying.release)
        return functools.partial(_swayed, swaying, self.rate)

    def header(self, number: int) -> dict:
        """The scene as the picture of a frame keeps it."""
        changes: dict[str, Any] = {"mesh": str(self.files[number])} if self.files else {}
        if self.turn_env:
            changes["env_rotate"] = self.scene.env_rotate + self.turn_env / self.frames * number
        if self.scene.curtain is not None:
            changes["frame"] = number
        return {**header(self.start.changed(**changes)), "frame": number, "film": self._about()}

    def _about(self) -> dict[str, Any]:
        """What of the film, beside the scene, decides how a frame looks. Its length does where something turns by shares of
        it, so that a film of poses or of a curtain may grow."""
        turns = self.around or self.turn_env
        about = {"turntable": self.around, "turn_env": self.turn_env, "wind": self.wind, "rate": self.rate}
        return (
            about
            | ({"frames": self.frames} if turns else {})
            | ({"first": self.first} if self.files else {})
            | self._layers()
        )

    def _layers(self) -> dict[str, Any]:
        return {"aovs": list(self.aovs)} if self.aovs else {}

    # -- a job of many processes -------------------------------------------------------------------------------------

    def file(self, number: int) -> Path:
        """Where a frame is written."""
        return sequence_files.frame_name(self.output, number)

    def pictures(self, numbers: Iterable[int]) -> Iterator[Any]:
        """Yield the pictures of some frames, their numbers ascending: to the bit those of the whole sequence."""
        with ExitStack() as stack:
            renderer = stack.enter_context(Renderer(self.device))
            yield from sequence.chosen(renderer, self.start, self.motion(renderer, stack), numbers, self.aovs)

    def write(self, number: int, picture: Any) -> dict:
        """Write a frame, whole or not at all."""
        look = self.scene.exposure, self.scene.transform
        sequence_files.write_picture(self.file(number), picture, self.header(number), *look)
        return {"number": number, "file": str(self.file(number))}


def _swayed(swaying: Swaying, rate: int, number: int) -> Mesh:
    """The pose of a frame, asked for in ascending order."""
    while swaying.frame < number:
        swaying.step(1.0 / rate)
    return swaying.mesh()


def encode(film: Film, video: Path) -> Iterator[Path]:
    """Write the frames of a film, which are there as .exr, as a video; yields after each."""
    from ..image import read_image

    pictures = (read_image(film.file(number)) for number in range(film.frames))
    yield from sequence_files.write_video(pictures, video, film.rate, film.scene.exposure, film.scene.transform)


def in_frames(film: Film, folder: Path) -> Film:
    """The same film as .exr frames in a folder."""
    return replace(film, output=str(folder / "%06d.exr"))


def numbers_of(text: str | None, count: int) -> list[int]:
    """The frames of a list such as 5, 0-9 or 3,7,12-20, ascending; all where there is none. Raises InputError."""
    if text is None:
        return list(range(count))
    out: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdigit() or (dash and not last.isdigit()):
            raise InputError(f"--only {text}: expected numbers such as 5, 0-9 or 3,7,12-20")
        out |= set(range(int(first), int(last if dash else first) + 1))
        if max(out, default=count) >= count:
            raise InputError(f"--only {text}: expected 0 to {count - 1}, of {count}")
    return sorted(out)

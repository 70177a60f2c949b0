"""Options by which many processes or machines share pictures, and how a film is made by them."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..errors import InputError
from ..progress import track
from .common import tell, whole

if TYPE_CHECKING:
    from ..farm.film import Film
    from ..farm.pool import Job
    from ..scene import Scene


@Parameter(name="*")
@dataclass
class Many:
    """Who makes the pictures, and which."""

    workers: Annotated[
        int | None, Parameter(converter=whole, help="Processes on this machine that share the pictures.")
    ] = None
    cluster: Annotated[str | None, Parameter(help="Address of a Dask scheduler whose workers share them.")] = None
    only: Annotated[str | None, Parameter(help="Numbers of those to render, such as 5, 0-9 or 3,7,12-20.")] = None
    resume: Annotated[bool, Parameter(negative="", help="Keep the pictures that are there; render the others.")] = False
    openjd: Annotated[
        Path | None, Parameter(help="Write an Open Job Description template for a render farm, and render nothing.")
    ] = None

    @property
    def asked(self) -> bool:
        """Whether anything was asked of it."""
        return self != Many()

    def check(self) -> None:
        """Raise InputError for options that contradict each other."""
        if self.workers is not None and not 1 <= self.workers <= 1024:
            raise InputError(f"--workers {self.workers}: expected 1 to 1024")
        if self.workers is not None and self.cluster is not None:
            raise InputError("--workers, --cluster: expected one of them; the cluster knows its workers")
        if self.openjd is not None:
            from ..farm.openjd import check_template

            names = ("workers", "cluster", "only", "resume")
            if (given := next((name for name in names if getattr(self, name)), None)) is not None:
                raise InputError(f"--openjd, --{given}: a farm hands out the pictures itself; leave --{given} out")
            check_template(self.openjd)


def shared(job: Job, numbers: list[int], many: Many, what: str) -> Iterator[dict]:
    """The results of a job by the processes or the cluster that were asked for, with progress."""
    results: Iterable[dict]
    if many.cluster is not None:
        from ..farm import cluster

        results = cluster.share(job, numbers, many.cluster)
    else:
        from ..farm import pool

        results = pool.share(job, numbers, many.workers or 1)
    yield from track(results, what, len(numbers))


def missing(job: Any, numbers: list[int]) -> list[int]:
    """Numbers whose picture is not there, is damaged, or is of another scene or film."""
    from ..image import read_image, read_settings

    def is_there(number: int) -> bool:
        file = job.file(number)
        try:
            if not file.is_file() or read_settings(file) != json.loads(json.dumps(job.header(number))):
                return False
            read_image(file)
        except InputError:
            return False
        return True

    return [number for number in numbers if not is_there(number)]


def template(path: Path, template: dict, scene: Scene, folder: Path, pictures: int, as_json: bool) -> None:
    """Write a template for a render farm, and say so."""
    from ..farm.openjd import save_template

    file = save_template(path, template, scene, folder)
    result = {"template": str(path), "scene": str(file), "pictures": pictures}
    tell(as_json, result, f"{path}: a template, a task for each of {pictures} pictures; its scene is {file}")


def animate(film: Film, many: Many, start: int, video: bool) -> int:
    """Render a film; how many frames were rendered. Raises InputError."""
    from ..farm.film import encode, in_frames, numbers_of

    if video and (many.only is not None or many.resume):
        raise InputError(f"{film.output}: --only and --resume are for frames; choose frames/%04d.png or .exr")
    numbers = [n for n in numbers_of(many.only, film.frames) if n >= start]
    film.start, film.files  # noqa: B018  faults are said before processes start
    if many.resume:
        numbers = missing(film, numbers)
    if not video:
        for _ in shared(film, numbers, many, f"{film.output}: frames"):
            pass
        return len(numbers)
    path = Path(film.output)
    with tempfile.TemporaryDirectory(prefix=f".{path.stem}.", dir=path.parent) as folder:
        parts = in_frames(film, Path(folder))
        for _ in shared(parts, numbers, many, f"{path}: frames"):
            pass
        for _ in track(encode(parts, path), f"{path}: video", film.frames):
            pass
    return len(numbers)

"""Exports by the suffix of their file, each with its distance from the original.   [own]"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from ..fabric import Fabric, load_fabric
from ..files import check_writable
from .gltf import write_glb
from .maps_file import write_zip
from .materialx import write_mtlx
from .mitsuba_files import write_mitsuba_py, write_mitsuba_xml
from .mitsuba_response import MissingMitsubaError
from .original import Errors, Response, errors
from .u3m import write_u3m, write_u3ma


@dataclass(frozen=True)
class Exported:
    """What was written: its files, its errors or why they were not measured, and the response that it stands for."""

    files: list[Path]
    errors: Errors | str
    model: Response | None

    def as_dict(self) -> dict:
        """Plain values."""
        said = {"not_measured": self.errors} if isinstance(self.errors, str) else self.errors.as_dict()
        return {"files": [str(f) for f in self.files], **said}


def export(fabric: Fabric | str, path: Path) -> Exported:
    """Write a fabric in the form that the file's suffix says. Raises InputError for a suffix that is none of `WRITERS`."""
    fabric = load_fabric(fabric)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        said = path.suffix or "a file without suffix"
        raise InputError(f"{path}: cannot export {said}, expected a name that ends in {', '.join(WRITERS)}")
    check_writable(path)
    files, model = writer(fabric, path)
    try:
        return Exported(files, errors(model, fabric), model)
    except MissingMitsubaError as error:
        return Exported(files, str(error), None)


WRITERS: dict[str, Callable[[Fabric, Path], tuple[list[Path], Response]]] = {
    ".zip": write_zip,
    ".glb": write_glb,
    ".mtlx": write_mtlx,
    ".u3m": write_u3m,
    ".u3ma": write_u3ma,
    ".py": write_mitsuba_py,
    ".xml": write_mitsuba_xml,
}

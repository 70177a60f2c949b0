"""`glcloth export`: a fabric for another renderer, and how far it is from the original."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..progress import note
from .common import Json, output_option, tell


def export(
    fabric: str,
    /,
    *,
    output: Annotated[
        Path,
        output_option(
            "File: .zip (maps), .glb (glTF), .mtlx (OpenPBR), .u3m or .u3ma (U3M 1.1), .py or .xml (Mitsuba 3's plugin)."
        ),
    ],
    picture: Annotated[
        Path | None, Parameter(help="Picture to write, .png or .exr: a ball of the original, and of the export.")
    ] = None,
    json: Json = False,
) -> None:
    """Write a fabric for another renderer and say how far it is from the original, in % of the mean brightness.

    Parameters
    ----------
    fabric
        Built-in fabric, a .toml file or a draft (.wif).
    """
    from ..fabric import load_fabric
    from ..image import check_output, write_image

    if picture is not None:
        check_output(picture)
    chosen = load_fabric(fabric)

    from ..export.files import export as write
    from ..export.original import sphere_pictures

    done = write(chosen, output)
    result = {"fabric": chosen.name, **done.as_dict()}
    if picture is not None and done.model is None:
        note(f"glcloth: warning: {picture}: is not written, for want of Mitsuba, which draws the export")
    elif picture is not None:
        write_image(picture, sphere_pictures(done.model, chosen))
        result["picture"] = str(picture)
    tell(json, result, f"{output}: {chosen.name}, {done.errors}")

"""`glcloth sweep`: a picture for each combination of parameters, a contact sheet and a table."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..errors import InputError
from .common import Device, Json, output_option, tell
from .many import Many, missing, shared, template
from .options import SceneOptions, scene_of
from .samples import make_folder


def sweep(
    scene: str | None = None,
    /,
    *,
    vary: Annotated[
        list[str],
        Parameter(
            negative="",
            help="An option of render and its values: fabric=linen,silk_shot, env-rotate=0:180:30 or eye='0,1,3;2,1,2'; also "
            "of a yarn: warp.gamma_s_deg=3:9:3. Repeatable: all combinations.",
        ),
    ],
    output: Annotated[
        Path, output_option("Folder for pictures, sheet.png, table.csv and table.json; made if missing.")
    ],
    suffix: Annotated[Literal[".png", ".exr"], Parameter(help="Of the pictures.")] = ".png",
    many: Many | None = None,
    options: SceneOptions | None = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """Render all combinations of some parameters, and put them on a sheet and into a table.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    many = many or Many()
    many.check()
    chosen = scene_of(scene, options)

    from ..fabric import load_fabric
    from ..farm.film import numbers_of
    from ..farm.sweep import Sweep, parse_vary, write_tables

    job = Sweep(chosen, output, *parse_vary(vary), suffix, device)
    scenes = [job.scene_at(number) for number in range(len(job.rows))]
    # Faults are said before anything is rendered.
    for fabric in {fabric for scene in scenes for fabric in (scene.fabric, *scene.fabrics.values())}:
        load_fabric(fabric)
    numbers = numbers_of(many.only, len(job.rows))
    if many.openjd is not None:
        from ..farm.openjd import sweep_template

        template(many.openjd, sweep_template(job), chosen, output, len(job.rows), json)
        return
    if output.is_file():
        raise InputError(f"{output}: is a file, expected a folder; choose another name")
    make_folder(output)
    if many.resume:
        numbers = missing(job, numbers)
    begin = time.perf_counter()
    for _ in shared(job, numbers, many, f"{output}: pictures"):
        pass
    seconds = time.perf_counter() - begin
    result = {"folder": str(output), "pictures": len(numbers), "seconds": round(seconds, 3)}
    if all(job.file(number).is_file() for number in range(len(job.rows))):
        result["files"] = [str(path) for path in write_tables(job)]
    made = ", ".join(result.get("files", []))
    tell(json, result, f"{output}: {len(numbers)} pictures, {seconds:.1f} s{made and '; '}{made}")

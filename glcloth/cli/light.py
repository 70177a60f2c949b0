"""`glcloth env`: lights of an environment; `glcloth tables`: the tables of the paper's method."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import InputError
from ..files import check_writable
from .common import Json, output_option, tell, whole


def env(
    file: str,
    /,
    *,
    lobes: Annotated[str, Parameter(help="1 to 64, or auto.")] = "10",
    layer: Annotated[str, Parameter(help="Of an OpenEXR file with several.")] = "",
    env_layout: Annotated[str, Parameter(help="auto, equirect, cross, strip, angular or mirror.")] = "auto",
    measure: Annotated[
        bool, Parameter(negative="", help="Also measure the error of the shading in random frames (about 15 s).")
    ] = False,
    output: Annotated[Path | None, output_option("Fit to write (.json); the picture goes beside it as .png.")] = None,
    json: Json = False,
) -> None:
    """Fit spherical Gaussians and suns to an environment; report the error; write the fit and map | fit | difference.

    Parameters
    ----------
    file
        Built-in environment or a .hdr or .exr file.
    """
    from ..image import write_image
    from ..light.environment import load_environment
    from ..light.fit_report import fit_picture, fit_report
    from ..light.judge import measured_errors
    from ..light.lights_file import save_lights
    from ..scene import Scene

    count = Scene().changed(lobes=lobes).lobes
    target = output or Path(f"{Path(file).stem}_fit.json")
    if target.suffix != ".json":
        raise InputError(f"{target}: expected a name that ends in .json; the picture is written beside it as .png")
    check_writable(target)
    environment = load_environment(file, layer, env_layout)
    report = fit_report(environment, count)
    save_lights(target, report.lights)
    picture = target.with_suffix(".png")
    write_image(picture, fit_picture(environment, report.lights))
    result = {"file": str(target), "picture": str(picture), **report.as_dict()}
    lines = str(report).splitlines()
    if measure:
        result["measured_error"] = errors = measured_errors(environment, report.lights)
        said = ", ".join(f"{name} {e['median']:.1%} and {e['95 %']:.1%}" for name, e in errors.items())
        lines.append(f"measured in random frames, median and 95 %: {said}")
    tell(json, result, *lines, f"{target}, {picture}")


def tables(
    *fabrics: str,
    grid: Annotated[int, Parameter(converter=whole, help="Directions per axis.")] = 48,
    contribution: Annotated[float, Parameter(help="Share of the sum of singular values to keep.")] = 0.9,
    output: Annotated[Path | None, output_option("Folder for the tables; default: the cache.")] = None,
    json: Json = False,
) -> None:
    """Make the tables of the paper method: T (equation 9) and T_l (equation 14) of paper A.

    Parameters
    ----------
    fabrics
        Built-in fabrics or .toml files.
    """
    from ..methods.paper.tables import main as make

    make(fabrics, grid, contribution, output, json)

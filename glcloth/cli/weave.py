"""`glcloth weave`: a fabric of a weaver's draft; `glcloth fabrics`: those that are built in."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..errors import InputError
from ..files import check_writable
from ..progress import note, show
from .common import Device, Json, output_option, tell

if TYPE_CHECKING:
    from ..fabric import Fabric


def weave(
    draft: Path,
    /,
    *,
    output: Annotated[Path | None, output_option("Fabric file to write (.toml).")] = None,
    picture: Annotated[
        Path | None, Parameter(help="Picture to write, .png or .exr: the drawdown, and the cloth in its flat colours.")
    ] = None,
    ends: Annotated[float | None, Parameter(help="Ends a cm; default: what the draft says.")] = None,
    picks: Annotated[float | None, Parameter(help="Picks a cm; default: what the draft says.")] = None,
    flip: Annotated[
        bool, Parameter(negative="", help="Read the picks from the bottom, as handweavers often do.")
    ] = False,
    json: Json = False,
) -> None:
    """Make a fabric of a weaver's draft; report sett, repeat, floats, cover and tilts; draw drawdown and cloth.

    Parameters
    ----------
    draft
        Draft (.wif .dtx .wpo .twa), or a fabric that has a weave (to report and draw it).
    """
    from ..fabric import save_fabric
    from ..image import check_output
    from ..weave.report import lines_of, weave_report

    if output is not None:
        if output.suffix.lower() != ".toml":
            raise InputError(f"{output}: expected a name that ends in .toml")
        check_writable(output)
    if picture is not None:
        check_output(picture)
    fabric, warnings = _woven(draft, flip)
    changes = {"ends_per_cm": ends, "picks_per_cm": picks}
    if changes := {name: value for name, value in changes.items() if value is not None}:
        fabric = fabric.changed(weave=fabric.weave.changed(**changes))
    facts = weave_report(fabric.weave, fabric.yarn) | {"fabric": fabric.name, "warnings": warnings}
    if output is not None:
        save_fabric(output, fabric)
        facts["file"] = str(output)
    if picture is not None:
        _draw(picture, fabric)
        facts["picture"] = str(picture)
    if json:
        tell(True, facts, "")
    else:
        show([fabric.name, *lines_of(facts)])
        note(", ".join(facts[key] for key in ("file", "picture") if key in facts))


def _woven(path: Path, flip: bool) -> tuple[Fabric, list[str]]:
    """The fabric of a draft or of a fabric file, and what was odd about the draft."""
    from ..fabric import draft_fabric, load_fabric
    from ..weave.others import is_draft
    from ..weave.wif import load_draft

    if is_draft(str(path)):
        read = load_draft(path)
        return draft_fabric(read.flipped() if flip else read), list(read.warnings)
    fabric = load_fabric(str(path))
    if fabric.weave is None:
        raise InputError(f"{path}: {fabric.name} has no [weave], expected a draft (.wif) or a fabric with one")
    return fabric, []


def _draw(path: Path, fabric: Fabric) -> None:
    import numpy as np

    from ..image import write_image
    from ..weave.picture import weave_picture

    colors = fabric.weave.thread_colors or tuple(np.array([yarn.albedo]) for yarn in fabric.yarn)
    write_image(path, weave_picture(fabric.weave, colors))


def fabrics(
    *,
    output: Annotated[Path | None, output_option("Sheet of pictures to write, .png or .exr.")] = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """List the built-in fabrics with weave, sett and holes; -o draws each on the built-in cloth."""
    from ..fabric import builtin_fabrics, load_fabric
    from ..image import check_output

    if output is not None:
        check_output(output)
    rows = []
    for name in builtin_fabrics():
        fabric = load_fabric(name)
        row = {"name": name, "title": fabric.name, "gap": round(fabric.gap, 4), "tangents": len(fabric.tangents)}
        if (w := fabric.weave) is not None:
            row |= {"weave": w.drafted.title, "ends_per_cm": w.ends_per_cm, "picks_per_cm": w.picks_per_cm}
        rows.append(row)
    result: dict[str, Any] = {"fabrics": rows}
    if output is not None:
        from ..picture.sheet import fabric_sheet

        result["file"] = str(output)
        fabric_sheet(output, [row["name"] for row in rows], device)
    if json:
        tell(True, result, "")
        return
    for row in rows:
        sett = f"{row['ends_per_cm']:5.4g} x {row['picks_per_cm']:<5.4g}" if "weave" in row else " " * 13
        show([f"{row['name']:24} {row.get('weave', ''):14} {sett} {row['gap']:6.1%}  {row['title']}"])
    if output is not None:
        note(str(output))

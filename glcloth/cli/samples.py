"""`glcloth samples`: files to begin with, of every kind that the documents name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import InputError
from ..progress import note, track
from .common import Device, Json, tell, whole

FABRIC, DRAFT, MESH, MAP, PRINT, MASK = "mine.toml", "denim.wif", "dress.glb", "studio.exr", "roses.png", "dots.png"
POSES = "poses/%04d.ply"


def samples(
    folder: Path = Path("."),
    /,
    *,
    poses: Annotated[int, Parameter(converter=whole, help="Poses of a cloth in the wind, 24 a second; 0: none.")] = 12,
    wind: Annotated[float, Parameter(help="Wind of the poses, m/s.")] = 1.5,
    device: Device = None,
    json: Json = False,
) -> None:
    """Write files to begin with: a fabric, a draft, a mesh with UVs, a light map, a print, a mask of fabrics, poses of cloth.

    They are what the documents' commands name, and show the form of your own. Files that exist are kept.

    Parameters
    ----------
    folder
        Folder to write to; made if missing.
    """
    if not 0 <= poses <= 10_000:
        raise InputError(f"--poses {poses}: expected 0 to 10000")
    if not abs(wind) <= 20:
        raise InputError(f"--wind {wind}: expected -20 to 20 m/s")
    make_folder(folder)
    written, kept = [], []
    makers = {FABRIC: _fabric, DRAFT: _draft, MESH: _mesh, MAP: _map, PRINT: _print, MASK: _mask}
    for name, make in makers.items():
        _keep_or_make(folder / name, make, written, kept)
    if poses:
        make_folder(folder / Path(POSES).parent)
        for path, make in track(_poses(folder, poses, wind, device), f"{folder / POSES}: poses", poses):
            _keep_or_make(path, make, written, kept)
    line = f"{folder}: wrote {', '.join(_short(written, folder)) or 'nothing'}"
    if kept:
        line += f"; kept what was there: {', '.join(_short(kept, folder))}"
    tell(json, {"files": [str(p) for p in written], "kept": [str(p) for p in kept]}, line)
    if not json:
        note(f"try: glcloth render -o mine.png --fabric {folder / FABRIC} --mesh {folder / MESH} --env {folder / MAP}")


def make_folder(folder: Path) -> None:
    """Make a folder and those above it. Raises InputError if it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another folder") from None


def _keep_or_make(path: Path, make: Callable[[Path], None], written: list[Path], kept: list[Path]) -> None:
    if path.exists():
        kept.append(path)
    else:
        make(path)
        written.append(path)


def _short(paths: list[Path], folder: Path) -> list[str]:
    """Names in the folder, the poses as one."""
    names = [str(path.relative_to(folder)) for path in paths]
    poses = [name for name in names if name.endswith(".ply")]
    others = [name for name in names if not name.endswith(".ply")]
    return [*others, f"{POSES} ({len(poses)})"] if poses else others


def _fabric(path: Path) -> None:
    """Linen as its file has it, with a name to change."""
    from ..fabric import FABRICS
    from ..files import atomic_write

    text = (FABRICS / "linen.toml").read_text(encoding="utf-8").replace('name = "', 'name = "My ', 1)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _draft(path: Path) -> None:
    """A blue warp and a white weft, 26 ends and 17.3 picks a cm, three up and one down."""
    import numpy as np

    from ..fabric import load_fabric
    from ..weave.draft import Draft
    from ..weave.wif import save_draft

    denim = load_fabric("denim_raw")
    drawn = denim.weave.drafted
    picks, ends = drawn.drawdown.shape
    sides = {}
    for system, count, yarn, a_cm in (
        ("warp", ends, denim.yarn[0], denim.weave.ends_per_cm),
        ("weft", picks, denim.yarn[1], denim.weave.picks_per_cm),
    ):
        sides[f"{system}_colors"] = np.tile(np.array(yarn.albedo), (count, 1))
        sides[f"{system}_spacing"] = np.full(count, 1.0 / a_cm)
    save_draft(path, Draft(title="denim", drawdown=drawn.drawdown, **sides))


def _mesh(path: Path) -> None:
    from ..geometry.mesh_files import load_mesh, save_mesh

    save_mesh(path, load_mesh("drape"))


def _map(path: Path) -> None:
    from ..image import write_image
    from ..light.environment import load_environment

    write_image(path, load_environment("studio").radiance, half=True)


def _print(path: Path) -> None:
    """Roses of five petals, cos(5 phi / 2)^2, with leaves, on cream; the tile repeats, every second row half a tile on."""
    import numpy as np
    from PIL import Image

    from ..files import atomic_write

    y, x = (np.mgrid[0:512, 0:512] + 0.5) / 512
    tile = np.full((512, 512, 3), (246, 238, 222), np.uint8)
    places = [(0.25, 0.25, 0.3), (0.75, 0.75, 1.1)]  # x, y, turn
    for petals, reach, color in ((2, 0.23, (92, 120, 84)), (5, 0.17, (186, 44, 62)), (5, 0.10, (222, 104, 112))):
        for u, v, turn in places:
            dx, dy = (x - u + 0.5) % 1 - 0.5, (y - v + 0.5) % 1 - 0.5
            rim = reach * (0.45 + 0.55 * np.cos(petals * (np.arctan2(dy, dx) - turn) / 2) ** 2)
            tile[np.hypot(dx, dy) < rim] = color
    with atomic_write(path) as temporary:
        Image.fromarray(tile).save(temporary)


def _mask(path: Path) -> None:
    """Red dots on white, every second row half a step on."""
    import numpy as np
    from PIL import Image

    from ..files import atomic_write

    y, x = 8 * (np.mgrid[0:512, 0:512] + 0.5) / 512
    x = x + 0.5 * (np.floor(y) % 2)
    dots = np.full((512, 512, 3), 255, np.uint8)
    dots[np.hypot(x % 1 - 0.5, y % 1 - 0.5) < 0.3] = 200, 40, 60  # #c8283c
    with atomic_write(path) as temporary:
        Image.fromarray(dots).save(temporary)


def _poses(
    folder: Path, count: int, wind: float, device: int | str | None
) -> Iterator[tuple[Path, Callable[[Path], None]]]:
    """Each pose's file and what writes it; the cloth is moved where a file is missing only."""
    from ..geometry.mesh_files import save_mesh
    from ..gpu.context import create_context
    from ..picture.sequence_files import frame_name
    from ..simulation.drape import Swaying

    files = [frame_name(str(folder / POSES), number) for number in range(count)]
    if all(file.exists() for file in files):
        yield from ((file, lambda path: None) for file in files)
        return
    ctx = create_context(device)
    swaying = Swaying(ctx, wind)
    try:
        for number, file in enumerate(files):
            if number:
                swaying.step(1.0 / 24.0)
            yield file, lambda path: save_mesh(path, swaying.mesh())
    finally:
        swaying.release()
        ctx.release()

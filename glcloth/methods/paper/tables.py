"""The paper method's tables as files and as texels: the cache, what is uploaded, and what is reported."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict
from json import dumps
from math import prod
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...fabric import Fabric, builtin_fabrics, load_fabric
from ...files import atomic_write, cache_dir
from ...progress import show, warn
from .azimuth import azimuth_axes, azimuth_table
from .precompute import LEVELS, Tables, compute_tables, sharpness_levels
from .shapes import Shape, shapes_of

FORMAT = 3  # raise it whenever the numbers or their layout change: older files are then made anew
SINGLE_LIMIT = 64 << 20  # bytes of factors above which they are stored as 16-bit floats


def check_parameters(grid: int, contribution: float) -> None:
    """Raise InputError unless 8 <= grid <= 96 and 0.1 <= contribution <= 0.9999."""
    if not 8 <= grid <= 96:
        raise InputError(f"grid {grid}: expected 8 to 96 directions per angle (the paper: 48)")
    if not 0.1 <= contribution <= 0.9999:
        raise InputError(f"contribution {contribution:g}: expected 0.1 to 0.9999 (the paper: 0.9)")


def tables_for(fabric: Fabric | str, grid: int = 48, contribution: float = 0.9) -> Tables:
    """Return the tables of a fabric from the cache, or compute and cache them.

    Only the weave counts: tilts, areas, normalisation and the width of shadowing; colours and lobes do not. A file of
    the cache that is damaged or of another format is made anew. Raises InputError for parameters out of range.
    """
    check_parameters(grid, contribution)
    fabric = load_fabric(fabric)
    shapes, placements = shapes_of(fabric)
    path = cache_path(shapes, grid, contribution)
    found = _load(path, len(shapes))
    if found is not None:
        xi, o, values = found
        return Tables(grid, contribution, placements, xi, o, values)
    tables = compute_tables(fabric, grid, contribution)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_tables(path, tables)
    except (OSError, InputError) as error:
        warn(f"tables cannot be kept for the next time: {error}")
    return tables


def cache_path(shapes: tuple[Shape, ...], grid: int, contribution: float) -> Path:
    """Where the tables of these shapes are kept: the name is a digest of all that they depend on."""
    content = [FORMAT, grid, round(contribution, 9), [asdict(shape) for shape in shapes]]
    digest = hashlib.sha256(dumps(content).encode()).hexdigest()[:32]
    return cache_dir() / "tables" / f"{digest}.npz"


def save_tables(path: str | Path, tables: Tables) -> None:
    """Write tables to a .npz file, whole or not at all. Raises InputError if it cannot be written."""

    def joined(side):
        return np.concatenate([level for shape in side for level in shape])

    values = np.stack([np.stack(shape) for shape in tables.values])
    arrays = {"ranks": tables.ranks, "xi": joined(tables.xi), "o": joined(tables.o), "values": values}
    with atomic_write(path) as temporary, open(temporary, "wb") as file:
        np.savez(file, format=FORMAT, digest=_digest(arrays), **arrays)


def _digest(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """16 bytes that tell whether arrays are those that were written: a zip archive's own sums are not always checked."""
    total = hashlib.blake2b(digest_size=16)
    for name, array in arrays.items():
        total.update(f"{name} {array.dtype.str} {array.shape}".encode())
        total.update(np.ascontiguousarray(array).tobytes())
    return np.frombuffer(total.digest(), np.uint8)


def _load(path: Path, shape_count: int):
    """(xi, o, values) of a file, or None when it is missing, damaged or of another format."""
    try:
        with np.load(path, allow_pickle=False) as file:
            if int(file["format"]) != FORMAT:
                return None
            arrays = {name: file[name] for name in ("ranks", "xi", "o", "values")}
            ranks, xi, o, values = arrays.values()
            whole = np.array_equal(file["digest"], _digest(arrays)) and ranks.shape == (shape_count, LEVELS)
    except FileNotFoundError:
        return None
    except Exception:  # a damaged archive raises almost anything; all of it means the same
        whole = False
    if not whole:
        warn(f"{path}: damaged or cut short; the tables are made anew")
        return None

    def split(joined):
        levels = iter(np.split(joined, np.cumsum(ranks.ravel())[:-1]))
        return tuple(tuple(next(levels) for _ in range(LEVELS)) for _ in range(shape_count))

    return split(xi), split(o), tuple(tuple(shape) for shape in values)


# -- texels ----------------------------------------------------------------------------------------------------------


def slices(side) -> np.ndarray:
    """Factors [shape][level][rank, theta, phi] as slices [S, theta, phi, 4]: four ranks a texel, levels in order."""
    out = []
    for shape in side:
        for level in shape:
            rank, height, width = level.shape
            padded = np.zeros((-(-rank // 4) * 4, height, width), np.float32)
            padded[:rank] = level
            out.append(padded.reshape(-1, 4, height, width).transpose(0, 2, 3, 1))
    return np.concatenate(out)


def slice_index(tables: Tables) -> np.ndarray:
    """First slice of each level of each shape [shapes, LEVELS + 1]; the last entry is the end."""
    counts = -(-tables.ranks // 4)
    ends = np.cumsum(counts.ravel()).reshape(counts.shape)
    first = ends - counts
    return np.concatenate([first, ends[:, -1:]], axis=1)


def tiled(texels: np.ndarray, limit: int) -> tuple[np.ndarray, int, int]:
    """Slices [S, theta, phi, 4] as a volume no deeper than `limit`: ([depth, columns * theta, phi, 4], depth, columns).

    Slice s is at depth s mod depth in column s div depth, stacked along theta.
    """
    count, height, width, _ = texels.shape
    columns = -(-count // limit)
    depth = -(-count // columns)
    padded = np.zeros((columns * depth, *texels.shape[1:]), texels.dtype)
    padded[:count] = texels
    volume = padded.reshape(columns, depth, height, width, 4).swapaxes(0, 1)
    return np.ascontiguousarray(volume).reshape(depth, columns * height, width, 4), depth, columns


def texel_type(tables: Tables) -> str:
    """ "f4", or "f2" when single precision would take more than 64 MB; its rounding is far below the truncation."""
    return "f4" if 2 * 16 * slice_index(tables)[-1, -1] * tables.grid**2 <= SINGLE_LIMIT else "f2"


def azimuth_texels() -> np.ndarray:
    """T_l's table as a volume [3 * kappa_prime, phi_k, phi_o, 4]: powers 1-4, then 5-8, then 9-10."""
    table = azimuth_table()
    padded = np.zeros((*table.shape[:-1], 12), np.float32)
    padded[..., : table.shape[-1]] = table
    groups = padded.reshape(*table.shape[:-1], 3, 4)
    return np.ascontiguousarray(np.moveaxis(groups, -2, 0)).reshape(-1, *table.shape[1:-1], 4)


# -- reports ---------------------------------------------------------------------------------------------------------


def tables_report(fabric: Fabric | str, tables: Tables) -> dict:
    """What the tables of a fabric cost and hold, as plain values for JSON.

    seconds to make (0 if they came from the cache), bytes on the GPU (T's, and T_l's beside it), the sharpness of the
    levels, and for each tangent its yarn, tilt in degrees and ranks per level.
    """
    fabric = load_fabric(fabric)
    texel = 16 if texel_type(tables) == "f4" else 8
    return {
        "fabric": fabric.name,
        "seconds": round(tables.seconds, 3),
        "bytes": int(2 * texel * slice_index(tables)[-1, -1] * tables.grid**2),
        "azimuth_bytes": 3 * 16 * prod(len(axis) for axis in azimuth_axes()),
        "grid": tables.grid,
        "contribution": tables.contribution,
        "distinct_tables": len(tables.ranks),
        "sharpness": [round(float(s), 4) for s in sharpness_levels()],
        "tangents": [
            {
                "yarn": t.yarn + 1,
                "tilt_deg": round(float(np.degrees(t.tilt)), 6),
                "ranks": tables.ranks[p.shape].tolist(),
            }
            for t, p in zip(fabric.tangents, tables.placements, strict=True)
        ],
    }


def lines_of(facts: dict) -> list[str]:
    """A report as lines of text: one for the fabric, one for each tangent."""
    made = f"{facts['seconds']:.1f} s" if facts["seconds"] else "from the cache"
    size = f"{facts['bytes'] / 1e6:.1f} MB and {facts['azimuth_bytes'] / 1e6:.1f} MB for T_l"
    out = [f"{facts['fabric']}: {made}, {size}, {facts['distinct_tables']} distinct tables"]
    out.append("  ranks at sharpness   " + " ".join(f"{s:5.3g}" for s in facts["sharpness"]))
    for t in facts["tangents"]:
        name = f"yarn {t['yarn']}, {t['tilt_deg']:.4g} degrees"
        out.append(f"  {name:<20} " + " ".join(f"{r:5d}" for r in t["ranks"]))
    return out


def main(
    fabrics: Sequence[str],
    grid: int = 48,
    contribution: float = 0.9,
    output: str | Path | None = None,
    json: bool = False,
) -> None:
    """Make the tables of some fabrics, print what they cost and hold, and with `output` copy them to that folder.

    Raises InputError for an unknown fabric, parameters out of range or a folder that cannot be written.
    """
    if not fabrics:
        raise InputError(f"no fabric given, expected one or more of {', '.join(builtin_fabrics())}, or .toml files")
    check_parameters(grid, contribution)
    loaded = [load_fabric(name) for name in fabrics]
    folder = None if output is None else Path(output)
    if folder is not None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made as a folder ({error.strerror}); choose another -o") from None
    results = {}
    for name, fabric in zip(fabrics, loaded, strict=True):
        tables = tables_for(fabric, grid, contribution)
        results[str(name)] = tables_report(fabric, tables)
        if folder is not None:
            path = folder / f"{Path(name).stem}.npz"
            save_tables(path, tables)
            results[str(name)]["file"] = str(path)
        if not json:
            show(lines_of(results[str(name)]))
    if json:
        print(dumps(results))


def bench(fabrics: Sequence[str] = (), grid: int = 48, contribution: float = 0.9) -> tuple[dict, str]:
    """({fabric: {seconds, bytes, ranks}}, the same as text) of tables made afresh; no names: all built-in fabrics.

    ranks: {"yarn 1, -25 degrees": [rank per level], ...}. Raises InputError as `main` does.
    """
    check_parameters(grid, contribution)
    out, lines = {}, []
    for name in fabrics or builtin_fabrics():
        fabric = load_fabric(name)
        facts = tables_report(fabric, compute_tables(fabric, grid, contribution))
        ranks = {f"yarn {t['yarn']}, {t['tilt_deg']:.4g} degrees": t["ranks"] for t in facts["tangents"]}
        out[str(name)] = {"seconds": facts["seconds"], "bytes": facts["bytes"], "ranks": ranks}
        lines += lines_of(facts)
    return out, "\n".join(lines)

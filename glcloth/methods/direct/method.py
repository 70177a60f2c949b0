"""Method `direct`: quadrature per pixel at shared nodes; fabric, lights and sharpness are all live.   [own, docs/direct.md]"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ...fabric import Fabric
from ...gpu.buffers import TextureBuffer
from ...gpu.layout import shared
from ...gpu.memo import Last
from ...light.lights import SUN_RADIUS, WIDEST_SUN, Lights
from ...scene import Quality
from ...twins.node import angle_at_column, column_width
from ...twins.slots import ANGLE_SERIES
from ...visibility.vertices import sun_number
from ..method import Method
from ..settings import Settings
from ..weave_maps import packed
from . import broad_nodes
from . import schedule as plan
from .gaussian_nodes import COLUMNS, MOST_CUT, SKY_SHARPNESS, SUN, gaussian_table, node_count, warm
from .light_map import LightMap
from .lobe_nodes import COLUMNS as LOBE_COLUMNS
from .lobe_nodes import Lobes, ends, lobe_table
from .view_table import Levels, ViewTable

ENTRY_TEXELS = int(shared("inputs/methods/direct.glsl")[0]["ENTRY_TEXELS"])
MAX_PHI_PAIRS = int(shared("inputs/methods/direct_lobes.glsl")[0]["MAX_PHI_PAIRS"])
BROAD_BLEND = 1.1  # sharpness, from one number of directions for broad light to the next
NO_LIGHT = 1e-5  # share of a Gaussian's mass above the horizon that is none
# What programs are compiled for: (groups, tangents a group, with pooled nodes). The first that a fabric fits serves it.
VARIANTS = (
    (1, 4, False),
    (1, 4, True),
    (2, 3, True),
    (2, 4, True),
    (3, 4, True),
    (4, 4, True),
    (5, 4, True),
    (6, 4, True),
    (8, 4, True),
)


class Entry(NamedTuple):
    """What `L_shared` of inputs/methods/direct.glsl sums over: one Gaussian, or a share of it, by one rule; or a sun."""

    axis: np.ndarray
    radiance: np.ndarray
    sharpness: float
    pooled: float  # share of it that the pooled nodes carry, in the lobes that are pooled
    level: int
    number: int  # of its visibility


class Rules(NamedTuple):
    """Where the rules of Gaussians (sharpness, level) lie in the node data."""

    first: dict[tuple[float, int], int]  # row
    least: dict[tuple[float, int], float]  # cosine between axis and N from which on there is light
    broad_nodes: np.ndarray  # the first of the directions at which broad light is looked up, and their number


class Direct(Method):
    """The quadrature of glsl/inputs/methods/direct.glsl, and what it needs from the host.

    Everything that a user edits goes into buffers and uniforms. Only how the tangents are
    packed into vec4s is compiled in; `variants` lists the ways, so that a window can compile them before any edit.
    """

    source = "inputs/methods/direct.glsl"

    def __init__(self, ctx: moderngl.Context):
        super().__init__(ctx)
        self._node_data = TextureBuffer(ctx, 1 << 18)
        self._entry_data = TextureBuffer(ctx, 16 * ENTRY_TEXELS * 64)
        self._lobe_data = TextureBuffer(ctx, 1 << 16)
        self._pooled_light, self._broad_light = LightMap(ctx), LightMap(ctx)
        self._view, self._woven_view = ViewTable(ctx), ViewTable(ctx)
        self._prepared: Last[None] = Last()
        self._rules: Last[Rules] = Last()
        self._lobes: Last[None] = Last()
        self._view_made: Last[None] = Last()
        self._woven_made: Last[None] = Last()
        self._uniforms: dict[str, Any] = {}
        self._of_view: dict[str, Any] = {}  # those that the table over omega_o has of its own
        self._pixel_counts: tuple[int, ...] = (1, 1, 1)
        self._variant = VARIANTS[0]
        self._evaluations = 0

    def prepare(self, fabric: Fabric, lights: Lights, settings: Settings, part: int | None = None) -> None:
        """Compute and upload what differs from the last call."""
        quality = settings.quality
        self._prepared.get(lambda: self._prepare(fabric, lights, quality, part), fabric, lights, quality, part)

    def _prepare(self, fabric: Fabric, lights: Lights, quality: Quality, part: int | None) -> None:
        _warm_up(quality)
        schedule = plan.SCHEDULES[quality]
        lobes = plan.pooled_lobes(fabric)
        sharpness = lights.gaussians.sharpness
        broad = plan.broad_share(sharpness)
        pooled = plan.pooled_share(schedule, sharpness, lobes)  # of what is left over
        self.broad = broad + (1.0 - broad) * pooled
        looked_up = sharpness[broad > 0.0]
        levels = tuple(broad_nodes.levels(float(looked_up.max()), BROAD_BLEND)) if len(looked_up) else ()
        nodes = self._write_entries(_entries(lights, schedule, lobes, pooled, broad), levels, lobes, fabric)
        pool = self._write_lobes(fabric, schedule, lobes, part)
        any_pooled = bool(((broad < 1.0) & (pooled > 0.0)).any())
        self._pixel_counts = self._uniforms["pool_counts"] if any_pooled else (1, 1, 1)
        self._pooled_light.draw(lights.gaussians, (1.0 - broad) * pooled)
        self._broad_light.draw(lights.gaussians, broad)
        self._set_fabric(fabric, pool > 0, part)
        self._view_of = fabric, lobes, schedule, levels
        self._view_key = fabric, part, schedule, levels
        self._view_made.get(lambda: self._draw_view_table(self._view), *self._view_key)
        self._evaluations = nodes * len(fabric.tangents) + pool * any_pooled + int(self._uniforms["broad_nodes"][1])

    # -- light -----------------------------------------------------------------------------------------------------

    def _write_entries(self, entries: list[Entry], levels: Levels, lobes: tuple[Lobes, Lobes], fabric: Fabric) -> int:
        """Upload the entries and the rules that they use; returns the number of nodes."""
        pairs = tuple((entry.sharpness, entry.level) for entry in entries)
        rules = self._rules.get(lambda: self._write_rules(pairs, levels), pairs, levels)
        self._uniforms["broad_nodes"] = rules.broad_nodes
        records = np.zeros((len(entries), ENTRY_TEXELS, 4), "f4")
        records[:, 0, :3] = [entry.axis for entry in entries]
        records[:, 1, :3] = [entry.radiance for entry in entries]
        rows = [
            entry.number << 24 | rules.first[pair] << 8 | node_count(pair[1])
            for entry, pair in zip(entries, pairs, strict=True)
        ]
        records[:, 1, 3] = np.array(rows, "i4").view("f4")
        records[:-1, 0, 3] = [rules.least[pair] for pair in pairs[:-1]]
        records[-1, 0, 3] = -2.0
        sharpness = np.array([entry.sharpness for entry in entries])
        pooled = np.array([entry.pooled for entry in entries])
        level = np.array([entry.level for entry in entries])
        for one in np.unique(level):
            mine = level == one
            found = _lobe_records(int(one), sharpness[mine], pooled[mine], lobes, fabric)
            records[mine, 2:5], records[mine, 6:8] = found[:, :3], found[:, 3:]
        records[:, 5, 0] = column_width(sharpness)
        self._entry_data.write(records)
        several = int((level[:-1] > 0).sum())
        self._uniforms["entry_counts"] = several, len(entries) - 1
        return int(sum(node_count(int(one)) for one in level[:-1]))

    def _write_rules(self, pairs: tuple[tuple[float, int], ...], levels: Levels) -> Rules:
        """Upload the rules of Gaussians (sharpness, level), and the directions at which broad light is looked up."""
        row, tables, first, least = 0, [], {}, {}
        for pair in dict.fromkeys(pairs):
            table = gaussian_table(*pair)
            first[pair], least[pair] = row, _least_cosine(table, pair[0])
            row += len(table)
            tables.append(table)
        # Where nothing is looked up, one direction keeps the shader's loop whole.
        omega = np.concatenate([broad_nodes.directions(one) for one, _ in levels] or [np.array([[0.0, 0.0, 1.0]])])
        texels = np.concatenate([*(table.reshape(-1, 4) for table in tables), np.pad(omega, ((0, 0), (0, 1)))])
        self._node_data.write(texels.astype("f4"))
        return Rules(first, least, np.array([len(texels) - len(omega), len(omega)], "i4"))

    # -- fabric ----------------------------------------------------------------------------------------------------

    def _write_lobes(
        self,
        fabric: Fabric,
        schedule: plan.Schedule,
        lobes: tuple[Lobes, Lobes],
        part: int | None,
    ) -> int:
        """Upload the nodes of the narrow lobes; returns how often a pixel evaluates them."""
        tangents = tuple(
            (*tangent, weight, number)
            for number, (tangent, weight) in enumerate(zip(fabric.tangents, fabric.numerators(part), strict=True))
            if max(lobes[tangent.yarn].share_s, lobes[tangent.yarn].share_v) > 0.0 and (weight > 0.0 or part is None)
        )
        count, pairs = (schedule.theta_count, schedule.phi_pairs) if tangents else (1, 1)
        k_d = fabric.yarn[0].k_d, fabric.yarn[1].k_d
        seen = tuple((lobe.gamma_s, lobe.gamma_v, lobe.share_s, lobe.share_v) for lobe in lobes)
        self._lobes.get(
            lambda: self._lobe_data.write(_lobe_texels(tangents, lobes, k_d, count)), tangents, seen, k_d, count
        )
        self._uniforms["phi_rule"] = _phi_rule(pairs)
        self._uniforms["pool_counts"] = max(len(tangents), 1), count, pairs
        self._uniforms["view_rim"] = plan.view_rim(fabric)
        view_pairs = schedule.view_pairs if tangents else 1
        self._of_view = {
            "phi_rule": _phi_rule(view_pairs),
            "pool_counts": (max(len(tangents), 1), count, view_pairs),
        }
        return len(tangents) * count * pairs * 2

    def _draw_view_table(
        self, table: ViewTable, defines: Mapping[str, Any] | None = None, sets: Sequence[dict[str, Any]] = ({},)
    ) -> None:
        """Draw a table of what was prepared; `defines` beside those of the tangents; `sets`: as for `ViewTable.make`."""
        fabric, lobes, schedule, levels = self._view_of
        groups, lanes, _ = self._variant
        record = _lobe_records(broad_nodes.FIXED_LEVEL, np.array([SKY_SHARPNESS]), np.ones(1), lobes, fabric)[0]
        inputs = {"lobe_data": self._lobe_data, **self._uniforms, **self._of_view}
        defines = {**_defines(groups, lanes, True), **(defines or {})}
        table.make(plan.view_size(schedule, fabric), levels, defines, inputs, record, sets)

    def _draw_woven_table(self) -> None:
        """As the view table, without colours: a table each of tangents of negative, small and positive tilts, of the mean
        over those weighed by how near their tilts are."""
        fabric, (groups, lanes, _) = self._view_of[0], self._variant
        yarn = np.array([tangent.yarn for tangent in fabric.tangents])
        sets = []
        for near in _bins(fabric):
            total = np.array([(fabric.weights[:, 1] * near)[yarn == j].sum() for j in (0, 1)])
            sets.append({"table_rel": packed(near / np.where(total > 0.0, total, 1.0)[yarn], groups, lanes)})
        self._draw_view_table(self._woven_view, {"WEAVE": 1, "LANE_COUNT": lanes}, sets)

    def _set_fabric(self, fabric: Fabric, pooled: bool, part: int | None) -> None:
        tangents = fabric.tangents
        self._variant = next(v for v in VARIANTS if v[0] * v[1] >= len(tangents) and v[2] >= pooled)
        groups, lanes, _ = self._variant
        tilt, yarn = np.array([t.tilt for t in tangents]), np.array([t.yarn for t in tangents])
        share = fabric.weights[:, 1]
        ratio = fabric.numerators(part) / np.where(share > 0.0, share, 1.0)
        eta = np.array([y.eta for y in fabric.yarn])
        F_0 = ((1 - eta) / (1 + eta)) ** 2
        values = {
            "cos_tilt": np.cos(tilt),
            "sin_tilt": np.sin(tilt),
            "share": share,
            "yarn": yarn,
            "F_0": F_0[yarn],
            "k_d": np.array([y.k_d for y in fabric.yarn])[yarn],
            "surface": 8.0 * ratio,
            "volume_0": 4.0 * ratio * (yarn == 0),
            "volume_1": 4.0 * ratio * (yarn == 1),
        }
        slots = np.zeros((len(values), groups * lanes), "f4")
        slots[:, : len(tangents)] = list(values.values())
        slots = np.pad(slots.reshape(-1, groups, lanes), ((0, 0), (0, 0), (0, 4 - lanes)))
        self._uniforms |= {
            **{f"slot_{name}": np.ascontiguousarray(value) for name, value in zip(values, slots, strict=True)},
            "mask_series": (ANGLE_SERIES * -(fabric.sigma**-2) / np.log(2)).astype("f4"),
            "gap": fabric.gap,
            "yarn_F_0": F_0.astype("f4"),
            "yarn_A": np.array([y.albedo for y in fabric.yarn], "f4"),
        }

    # -- the contract of a method ----------------------------------------------------------------------------------

    def defines(self) -> dict[str, Any]:
        """How the tangents are packed (see `variants`)."""
        return _defines(*self._variant)

    def woven_packing(self) -> tuple[int, int]:
        """As `defines` says."""
        return self._variant[:2]

    def woven_defines(self) -> dict[str, Any]:
        """Of the last vec4 only what is in use: most woven fabrics have 14 tangents. Other programs round otherwise, so cloth
        from afar has none of them."""
        groups, lanes, _ = self._variant
        left = len(self._view_of[0].tangents) - (groups - 1) * lanes
        if lanes < 4 or groups == 1 or not 0 < left <= 2:
            return {}
        return {"LANES(g)": f"((g) < {groups - 1} ? {_used(4)} : {_used(2)})"}

    def woven_inputs(self) -> dict[str, Any]:
        """The tables of broad light, and which tangent counts how much in them."""
        self._woven_made.get(self._draw_woven_table, *self._view_key)
        low, _, high = (packed(near, *self._variant[:2]) for near in _bins(self._view_of[0]))
        return {"view_table": self._woven_view.texture, "slot_low": low, "slot_high": high}

    @staticmethod
    def variants() -> list[dict[str, Any]]:
        """All values that `defines` can take."""
        return [_defines(*variant) for variant in VARIANTS]

    def inputs(self) -> dict[str, Any]:
        """What inputs/methods/direct.glsl and what it includes declare."""
        return {
            "node_data": self._node_data,
            "entry_data": self._entry_data,
            "lobe_data": self._lobe_data,
            "pooled_light": self._pooled_light.texture,
            "broad_light": self._broad_light.texture,
            "view_table": self._view.texture,
            **self._uniforms,
            "pool_counts": self._pixel_counts,
        }

    def evaluations_per_pixel(self) -> int:
        """Evaluations of one tangent at one node in each pixel."""
        return self._evaluations

    def release(self) -> None:
        """Free the GPU's memory."""
        for one in (self._node_data, self._entry_data, self._lobe_data):
            one.release()
        for map in (self._pooled_light, self._broad_light, self._view, self._woven_view):
            map.release()


@cache
def _warm_up(quality: Quality) -> None:
    """Compute the rules of a quality for all sharpnesses, once: no later edit computes one."""
    schedule = plan.SCHEDULES[quality]
    edges = [1e-2, *sorted(schedule.sharper), 1e6]
    top = len(schedule.sharper)
    for i in range(top + 1):  # between edges i and i + 1 lies level top - i, whatever factor 0.15..4 a fabric has
        level = min(top - i + schedule.shift, len(plan.LADDER) - 1)
        warm(level, max(edges[i] * 0.13, 1e-2), min(edges[i + 1] * 4.5, 1e6))
    warm(0, SUN, SUN)
    warm(0, 4.0 / WIDEST_SUN**2, 4.0 / SUN_RADIUS**2)


def _entries(lights: Lights, schedule: plan.Schedule, lobes, pooled: np.ndarray, broad: np.ndarray) -> list[Entry]:
    """The entries of all lights; long rules first, behind them one that ends every search."""
    gaussians, suns = lights.gaussians, lights.suns
    entries = []
    for k in range(len(gaussians)):
        if broad[k] == 1.0 or not gaussians.amplitude[k].any():
            continue
        sharpness = max(float(gaussians.sharpness[k]), 1e-2)
        for level, share in plan.levels(schedule, gaussians.sharpness[k], pooled[k], lobes):
            radiance = gaussians.amplitude[k] * (1.0 - broad[k]) * share
            entries.append(Entry(gaussians.axis[k], radiance, sharpness, pooled[k], level, 1 + k))
    radius = np.asarray(suns.radius)
    for s in range(len(suns)):
        # A disc varies as the Gaussian of this sharpness: so much wider are highlights, and so the horizon cuts it.
        sharpness = min(4.0 / max(float(radius[s]), 1e-6) ** 2, SUN)
        radiance = suns.irradiance[s] * sharpness / (2.0 * np.pi)
        entries.append(Entry(suns.direction[s], radiance, sharpness, 0.0, 0, sun_number(len(gaussians)) + s))
    # Pixels side by side spend as many nodes when the long rules come first.
    entries.sort(key=lambda entry: -node_count(entry.level))
    return [*entries, Entry(np.array([0.0, 0.0, 1.0]), np.zeros(3), SUN, 0.0, 0, 0)]


def _lobe_records(level: int, sharpness: np.ndarray, pooled: np.ndarray, lobes, fabric: Fabric) -> np.ndarray:
    """How nodes of one level see the lobes, [K, 5, 4] float32: the share kept, 1 / sharp^2 and amplitude / sharp of the
    widened lobe, and what the first two change by for each unit of variance that the horizon takes. A rule of one node
    has sharp and the amplitude themselves.

    Components: surface of yarn 0 and 1, volume of yarn 0 and 1.
    """
    gammas = np.array([lobes[0].gamma_s, lobes[1].gamma_s, lobes[0].gamma_v, lobes[1].gamma_v])
    own = np.array([lobes[0].share_s, lobes[1].share_s, lobes[0].share_v, lobes[1].share_v])
    k_d = np.array([0.0, 0.0, fabric.yarn[0].k_d, fabric.yarn[1].k_d])

    def seen(left):
        kept = plan.kept_share(level, sharpness[:, None], gammas, left)
        variance = left / (sharpness + plan.CUT_SHARPNESS)
        # Of theta_i + theta_o = 2 theta_h; the little Gaussian of a node widens the lobe.
        return kept, np.log(2) * (4.0 * gammas**2 + (1.0 - kept**2) * 2.0 * variance[:, None])

    (kept, spread), (kept_cut, spread_cut) = seen(1.0), seen(1.0 - MOST_CUT)
    amplitude = (1.0 - pooled[:, None] * own) * (1.0 - k_d) * 2.0 * np.sqrt(np.log(2) / np.pi)
    if level == 0:
        spread = 1.0 / np.sqrt(spread)
        amplitude = amplitude * spread
    return np.stack(
        [kept, spread, amplitude, (kept_cut - kept) / MOST_CUT, (spread_cut - spread) / MOST_CUT], 1
    ).astype("f4")


def _phi_rule(pairs: int) -> np.ndarray:
    """The positive nodes of a Gauss-Legendre rule on -1..1 and their weights, [MAX_PHI_PAIRS, 2] float32."""
    x, w = np.polynomial.legendre.leggauss(2 * pairs)
    rule = np.zeros((MAX_PHI_PAIRS, 2), "f4")
    rule[:pairs] = np.stack([x[pairs:], w[pairs:]], -1)
    return rule


def _lobe_texels(tangents: tuple, lobes: tuple[Lobes, Lobes], k_d: tuple[float, float], count: int) -> np.ndarray:
    """Nodes [tangents, 2 + count * LOBE_COLUMNS, 4] on the lobes of tangents (yarn, tilt, multiplicity, weight,
    number)."""
    data = np.zeros((max(len(tangents), 1), 2 + count * LOBE_COLUMNS, 4), "f4")
    for yarn in (0, 1):
        mine = [i for i, tangent in enumerate(tangents) if tangent[0] == yarn]
        if not mine:
            continue
        tilts = np.array([tangents[i][1] for i in mine])
        table = lobe_table(tilts, lobes[yarn], count)
        table[..., 2] *= 1.0 - k_d[yarn]
        for i, tilt, rows in zip(mine, tilts, table, strict=True):
            data[i, 0] = np.cos(tilt), np.sin(tilt), tangents[i][3], yarn
            data[i, 1] = *ends(tilt), lobes[yarn].width, tangents[i][4]
            data[i, 2:] = rows.reshape(-1, 4)
    if not tangents:
        data[0, 0], data[0, 1, :3] = (1.0, 0.0, 0.0, 0.0), (-np.pi / 2, np.pi / 2, 1.0)
    return data


def _bins(fabric: Fabric) -> np.ndarray:
    """[3, tangents]: how near each tilt is to the yarn's most negative one, to 0 and to the most positive; they add up to 1."""
    tilt, yarn = np.array([t.tilt for t in fabric.tangents]), np.array([t.yarn for t in fabric.tangents])
    top = np.array([np.abs(tilt[yarn == j]).max(initial=1e-9) for j in (0, 1)])
    x = tilt / np.maximum(top, 1e-9)[yarn]
    low, high = np.maximum(-x, 0.0), np.maximum(x, 0.0)
    return np.stack([low, 1.0 - low - high, high])


def _least_cosine(table: np.ndarray, sharpness: float) -> float:
    """The cosine between axis and N below which less than NO_LIGHT of a Gaussian is above the horizon."""
    mass = table[-1, :, 3]
    lit = np.flatnonzero(mass > mass.max() + np.log(NO_LIGHT))[-1]
    if lit == COLUMNS - 1:
        return -2.0
    return float(np.cos(angle_at_column((lit + 1) / (COLUMNS - 1), column_width(sharpness))))


def _defines(groups: int, lanes: int, pooled: bool) -> dict[str, Any]:
    return {
        "GROUPS": groups,
        "EACH_GROUP(F)": " ".join(f"F({g});" for g in range(groups)),
        "LANES(g)": _used(lanes),
        "POOLED(L)": "L" if pooled else "",
    }


def _used(lanes: int) -> str:
    """A vec4 in GLSL: 1 for each component in use."""
    return f"vec4({', '.join('1.0' if i < lanes else '0.0' for i in range(4))})"

"""Method `direct`: quadrature per pixel at shared nodes; fabric, lights and sharpness are all live.   [own, docs/direct.md]"""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np

from ...fabric import Fabric
from ...gpu import shader
from ...gpu.buffers import TextureBuffer
from ...light.lights import Lights
from ...settings import Settings
from ...twins.node import angle_at_column, column_width
from ...twins.slots import ANGLE_SERIES
from ...visibility.vertices import sun_number
from . import broad_nodes
from . import schedule as plan
from .gaussian_nodes import COLUMNS, SKY_SHARPNESS, SUN, gaussian_table, node_count, warm
from .lobe_nodes import ends, lobe_table
from .view_table import ViewTable

NODE_UNIT, ENTRY_UNIT, LOBE_UNIT, POOL_UNIT, BROAD_UNIT, VIEW_UNIT = 8, 9, 10, 11, 12, 13
ENTRY_TEXELS = 6
BROAD_BLEND = 1.1  # sharpness, from one number of directions for broad light to the next
NO_LIGHT = 1e-5  # share of a Gaussian's mass above the horizon that is none
MAX_PHI_PAIRS = 8
MAP_SIZE = 160  # of the octahedral maps of light: sharpness 30 needs a texel of a degree
# What programs are compiled for: (groups, tangents a group, with pooled nodes). The first that a fabric fits serves it.
VARIANTS = ((1, 4, False), (1, 4, True), (2, 3, True), (2, 4, True), (8, 4, True))


class Direct:
    """The quadrature of glsl/inputs/methods/direct.glsl, and what it needs from the host.

    Everything that a user edits goes into buffers and uniforms. Only how the tangents are
    packed into vec4s is compiled in; `variants` lists the five ways, so that a window can compile them before any edit.
    """

    source = "inputs/methods/direct.glsl"

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._node_data = TextureBuffer(ctx, 1 << 18)
        self._entry_data = TextureBuffer(ctx, 16 * ENTRY_TEXELS * 64)
        self._lobe_data = TextureBuffer(ctx, 1 << 16)
        self._map_data = TextureBuffer(ctx, 32 * 64)
        self._maps = {unit: self._empty_map() for unit in (POOL_UNIT, BROAD_UNIT)}
        self._map_program = None
        self._view = ViewTable(ctx)
        self._keys: dict[str, object] = {}
        self._uniforms: dict[str, np.ndarray] = {}
        self._variant = VARIANTS[0]
        self._evaluations = 0
        self._pixel_counts = (1, 1, 1)
        self._warm: set[str] = set()
        self.broad = np.zeros(0)  # how much [K] of each Gaussian the maps carry

    def _empty_map(self) -> moderngl.Texture:
        size = MAP_SIZE, MAP_SIZE
        texture = self.ctx.texture(size, 4, np.zeros((*size, 4), "f4").tobytes(), dtype="f4")
        texture.filter = moderngl.LINEAR, moderngl.LINEAR
        texture.repeat_x = texture.repeat_y = False
        return texture

    # -- what changed ----------------------------------------------------------------------------------------------

    def prepare(self, fabric: Fabric, lights: Lights, settings: Settings) -> None:
        """Compute and upload what differs from the last call."""
        schedule = plan.SCHEDULES[settings.quality]
        self._warm_up(settings.quality)
        key = (fabric, lights, settings.quality)
        last = self._keys.get("all")
        # Fabrics and lights are frozen: the same object is the same content.
        if last is not None and last[0] is fabric and last[1] is lights and last[2] == settings.quality:
            return
        self._keys["all"] = key
        lobes = plan.pooled_lobes(fabric)
        sharpness = lights.gaussians.sharpness
        broad = plan.broad_share(sharpness)
        pooled = plan.pooled_share(schedule, sharpness, lobes)  # of what is left over
        self.broad = broad + (1.0 - broad) * pooled
        nodes = self._write_entries(lights, schedule, lobes, pooled, broad, fabric)
        pool = self._write_lobes(fabric, schedule, lobes)
        any_pooled = bool(((broad < 1.0) & (pooled > 0.0)).any())
        self._pixel_counts = tuple(map(int, self._uniforms["pool_counts"])) if any_pooled else (1, 1, 1)
        self._write_map(POOL_UNIT, lights, (1.0 - broad) * pooled)
        self._write_map(BROAD_UNIT, lights, broad)
        self._set_fabric(fabric, pool > 0)
        self._write_view_table(fabric, lobes, schedule)
        directions = int(self._uniforms["broad_nodes"][1])
        self._evaluations = nodes * len(fabric.tangents) + pool * any_pooled + directions

    def _warm_up(self, quality: str) -> None:
        """Compute the rules of a quality for all sharpnesses, once: no later edit computes one."""
        if quality in self._warm:
            return
        schedule = plan.SCHEDULES[quality]
        edges = [1e-2, *sorted(schedule.sharper), 1e6]
        top = len(schedule.sharper)
        for i in range(top + 1):  # between edges i and i + 1 lies level top - i, whatever factor 0.15..4 a fabric has
            level = min(top - i + schedule.shift, len(plan.LADDER) - 1)
            warm(level, max(edges[i] * 0.13, 1e-2), min(edges[i + 1] * 4.5, 1e6))
        warm(0, SUN, SUN)
        self._warm.add(quality)

    def _write_entries(self, lights: Lights, schedule, lobes, pooled, broad, fabric) -> int:
        """Upload the rules and the Gaussians that use them; returns the number of nodes."""
        gaussians = lights.gaussians
        axis, amplitude, sharp, share, level, number = [], [], [], [], [], []
        for k in range(len(gaussians)):
            if broad[k] == 1.0 or not gaussians.amplitude[k].any():
                continue
            for one, part in plan.levels(schedule, gaussians.sharpness[k], pooled[k], lobes):
                axis.append(gaussians.axis[k])
                amplitude.append(gaussians.amplitude[k] * (1.0 - broad[k]) * part)
                sharp.append(max(float(gaussians.sharpness[k]), 1e-2))
                share.append(pooled[k])
                level.append(one)
                number.append(1 + k)
        for s, (direction, irradiance) in enumerate(zip(lights.suns.direction, lights.suns.irradiance, strict=True)):
            number.append(sun_number(len(gaussians)) + s)
            axis.append(direction)
            amplitude.append(irradiance * SUN / (2.0 * np.pi))
            sharp.append(SUN)
            share.append(0.0)
            level.append(0)
        # Behind them one that ends every search. Pixels side by side spend as many nodes when the long rules come first.
        order = sorted(range(len(axis)), key=lambda i: -node_count(level[i]))
        axis, amplitude, sharp, share, level, number = (
            [*(column[i] for i in order), last]
            for column, last in zip(
                (axis, amplitude, sharp, share, level, number),
                ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), SUN, 0.0, 0, 0),
                strict=True,
            )
        )
        key = tuple(zip(sharp, level, strict=True))
        looked_up = gaussians.sharpness[broad > 0.0]
        self._broad_levels = broad_nodes.levels(float(looked_up.max()), BROAD_BLEND) if len(looked_up) else []
        if self._keys.get("nodes") != (key, self._broad_levels):
            self._keys["nodes"] = key, self._broad_levels
            first, tables, starts, least = 0, [], {}, {}
            for pair in dict.fromkeys(key):
                table = gaussian_table(*pair)
                starts[pair], least[pair] = first, _least_cosine(table, pair[0])
                first += len(table)
                tables.append(table)
            self._starts, self._least = starts, least
            # Where nothing is looked up, one direction keeps the shader's loop whole.
            omega = [broad_nodes.directions(one) for one, _ in self._broad_levels] or [np.array([[0.0, 0.0, 1.0]])]
            omega = np.concatenate(omega)
            texels = np.concatenate([*(table.reshape(-1, 4) for table in tables), np.pad(omega, ((0, 0), (0, 1)))])
            self._uniforms["broad_nodes"] = np.array([len(texels) - len(omega), len(omega)], "i4")
            texels = texels.astype("f4")
            self._node_data.write(texels)
        records = np.zeros((len(axis), ENTRY_TEXELS, 4), "f4")
        records[:, 0, :3], records[:, 1, :3] = axis, amplitude
        starts = [
            at << 24 | self._starts[pair] << 8 | node_count(pair[1]) for at, pair in zip(number, key, strict=True)
        ]
        records[:, 1, 3] = np.array(starts, "i4").view("f4")
        records[:-1, 0, 3] = [self._least[pair] for pair in key[:-1]]
        records[-1, 0, 3] = -2.0
        records[:, 5, 0] = column_width(sharp)
        sharp, share, level = np.array(sharp), np.array(share), np.array(level)
        for one in np.unique(level):
            mine = level == one
            records[mine, 2:5] = self._lobe_records(int(one), sharp[mine], share[mine], lobes, fabric)
        self._entry_data.write(records)
        several = int((level[:-1] > 0).sum())
        self._uniforms["entry_counts"] = np.array([several, len(axis) - 1], "i4")
        return int(sum(node_count(int(one)) for one in level[:-1]))

    @staticmethod
    def _lobe_records(level: int, sharpness, pooled, lobes, fabric) -> np.ndarray:
        """How nodes of one level see the lobes: (kept share, sharpness, log2 of the amplitude) [K, 3, 4] float32.

        Components: surface of yarn 0 and 1, volume of yarn 0 and 1.
        """
        gammas = np.array([lobes[0].gamma_s, lobes[1].gamma_s, lobes[0].gamma_v, lobes[1].gamma_v])
        own = np.array([lobes[0].share_s, lobes[1].share_s, lobes[0].share_v, lobes[1].share_v])
        k_d = np.array([0.0, 0.0, fabric.yarn[0].k_d, fabric.yarn[1].k_d])
        kept = plan.kept_share(level, sharpness[:, None], gammas)
        variance = 1.0 / (sharpness + plan.CUT_SHARPNESS)
        # Of theta_i + theta_o = 2 theta_h; the little Gaussian of a node widens the lobe.
        width2 = 4.0 * gammas**2 + (1.0 - kept**2) * 2.0 * variance[:, None]
        amplitude = (1.0 - pooled[:, None] * own) * (1.0 - k_d) * 2.0 / np.sqrt(np.pi * width2)
        height = np.log2(np.maximum(amplitude, 1e-30))
        return np.stack([kept, np.sqrt(1.0 / (width2 * np.log(2))), height], 1).astype("f4")

    def _write_lobes(self, fabric: Fabric, schedule, lobes) -> int:
        """Upload the nodes of the narrow lobes; returns how often a pixel evaluates them."""
        tangents = [
            (tangent, weight)
            for tangent, weight in zip(fabric.tangents, fabric.weights[:, 0], strict=True)
            if max(lobes[tangent.yarn].share_s, lobes[tangent.yarn].share_v) > 0.0
        ]
        count, pairs = (schedule.theta_count, schedule.phi_pairs) if tangents else (1, 1)
        key = (
            tuple((*tangent, weight) for tangent, weight in tangents),
            lobes,
            count,
            fabric.yarn[0].k_d,
            fabric.yarn[1].k_d,
        )
        if self._keys.get("lobes") != key:
            self._keys["lobes"] = key
            data = np.zeros((max(len(tangents), 1), 2 + count * 64, 4), "f4")
            for yarn in (0, 1):
                mine = [i for i, (tangent, _) in enumerate(tangents) if tangent.yarn == yarn]
                if not mine:
                    continue
                tilts = np.array([tangents[i][0].tilt for i in mine])
                table = lobe_table(tilts, lobes[yarn], count)
                table[..., 2] *= 1.0 - fabric.yarn[yarn].k_d
                for i, tilt, rows in zip(mine, tilts, table, strict=True):
                    data[i, 0] = np.cos(tilt), np.sin(tilt), tangents[i][1], yarn
                    data[i, 1, :3] = *ends(tilt), lobes[yarn].width
                    data[i, 2:] = rows.reshape(-1, 4)
            if not tangents:
                data[0, 0], data[0, 1, :3] = (1.0, 0.0, 0.0, 0.0), (-np.pi / 2, np.pi / 2, 1.0)
            self._lobe_data.write(data)
        x, w = np.polynomial.legendre.leggauss(2 * pairs)
        rule = np.zeros((MAX_PHI_PAIRS, 2), "f4")
        rule[:pairs] = np.stack([x[pairs:], w[pairs:]], -1)
        self._uniforms["phi_rule"] = rule
        self._uniforms["pool_counts"] = np.array([max(len(tangents), 1), count, pairs], "i4")
        return len(tangents) * count * pairs * 2

    def _write_map(self, unit: int, lights: Lights, share: np.ndarray) -> None:
        """Draw the radiance of the given shares of the Gaussians into one of the maps."""
        mine = share > 0.0
        gaussians = lights.gaussians
        records = np.zeros((int(mine.sum()), 2, 4), "f4")
        records[:, 0, :3], records[:, 0, 3] = gaussians.axis[mine], gaussians.sharpness[mine]
        records[:, 1, :3] = gaussians.amplitude[mine] * share[mine, None]
        key = records.tobytes()
        if self._keys.get(unit) == key:
            return
        self._keys[unit] = key
        if self._map_program is None:
            self._map_program = shader.compute(self.ctx, "passes/methods/light_map.comp")
        self._map_data.write(records)
        self._map_data.bind(ENTRY_UNIT)
        self._maps[unit].bind_to_image(0, read=False, write=True)
        self._map_program["gaussian_count"].value = len(records)
        groups = -(-MAP_SIZE // 8)
        self._map_program.run(groups, groups)
        self.ctx.memory_barrier(moderngl.TEXTURE_FETCH_BARRIER_BIT)

    def _write_view_table(self, fabric: Fabric, lobes, schedule) -> None:
        """Have the table of the fabric made; nothing while neither it nor the directions of broad light change."""
        before, key = self._keys.get("view"), (schedule, self._broad_levels)
        if before is not None and before[0] is fabric and before[1] == key:
            return
        self._keys["view"] = fabric, key
        groups, lanes, _ = self._variant
        record = self._lobe_records(broad_nodes.FIXED_LEVEL, np.array([SKY_SHARPNESS]), np.ones(1), lobes, fabric)[0]
        self._view.make(
            schedule.view_size, self._broad_levels, _defines(groups, lanes, True), self._bind_fabric, record
        )

    def _set_fabric(self, fabric: Fabric, pooled: bool) -> None:
        tangents = fabric.tangents
        self._variant = next(v for v in VARIANTS if v[0] * v[1] >= len(tangents) and v[2] >= pooled)
        groups, lanes, _ = self._variant
        tilt, yarn = np.array([t.tilt for t in tangents]), np.array([t.yarn for t in tangents])
        weight, share = fabric.weights.T
        ratio = weight / np.where(share > 0.0, share, 1.0)
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
            **{f"slot_{name}": value for name, value in zip(values, slots, strict=True)},
            "mask_series": (ANGLE_SERIES * -(fabric.sigma**-2) / np.log(2)).astype("f4"),
            "gap": np.array([fabric.gap], "f4"),
            "yarn_F_0": F_0.astype("f4"),
            "yarn_A": np.array([y.albedo for y in fabric.yarn], "f4"),
        }

    # -- the contract of a method ----------------------------------------------------------------------------------

    def defines(self) -> dict:
        """How the tangents are packed (see `variants`)."""
        return _defines(*self._variant)

    @staticmethod
    def variants() -> list[dict]:
        """All values that `defines` can take."""
        return [_defines(*variant) for variant in VARIANTS]

    def bind(self, program) -> None:
        """Bind the buffers and set the uniforms of a program."""
        self._node_data.bind(NODE_UNIT)
        self._entry_data.bind(ENTRY_UNIT)
        for unit, texture in self._maps.items():
            texture.use(unit)
        self._view.use(VIEW_UNIT)
        self._bind_fabric(program)
        shader.set_uniforms(program, pool_counts=self._pixel_counts)

    def _bind_fabric(self, program) -> None:
        self._lobe_data.bind(LOBE_UNIT)
        for name, value in self._uniforms.items():
            if name in program:
                uniform = program[name]
                # An array of which the driver kept fewer elements takes only those.
                value = value[: uniform.array_length] if uniform.array_length > 1 else value
                uniform.write(np.ascontiguousarray(value).tobytes()[: 4 * uniform.dimension * uniform.array_length])

    def passes(self) -> Iterator[dict]:
        """One pass does it all."""
        yield {}

    def evaluations_per_pixel(self) -> int:
        """Evaluations of one tangent at one node in each pixel."""
        return self._evaluations


def _least_cosine(table: np.ndarray, sharpness: float) -> float:
    """The cosine between axis and N below which less than NO_LIGHT of a Gaussian is above the horizon."""
    mass = table[-1, :, 3]
    lit = np.flatnonzero(mass > mass.max() + np.log(NO_LIGHT))[-1]
    if lit == COLUMNS - 1:
        return -2.0
    return float(np.cos(angle_at_column((lit + 1) / (COLUMNS - 1), column_width(sharpness))))


def _defines(groups: int, lanes: int, pooled: bool) -> dict:
    return {
        "GROUPS": groups,
        "EACH_GROUP(F)": " ".join(f"F({g});" for g in range(groups)),
        "LANES": f"vec4({', '.join('1.0' if i < lanes else '0.0' for i in range(4))})",
        "POOLED(L)": "L" if pooled else "",
    }

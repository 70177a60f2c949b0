"""Light around the room: radiosity of a room that stands still with a curtain that moves, anew every frame.

Fine elements receive, coarse patches send (substructuring, Cohen 1986). The lamp itself stays with the tracer, point by
point; here is what is smooth: the sky through the openings, what the curtain scatters, and all bounces. Nothing depends
on earlier frames. Each column of the curtain leans by itself: factors are known for four leans, and interpolated.
[Goral 1984; Cohen, Greenberg, Immel, Brock 1986, "An efficient radiosity approach"]

    B = S + K B,  S = what senders send of the lamp and the sky,  E = E_sky + F B

Senders are the room's patches and the cells of the curtain as a sheet with two sides, which send what `folds` found.
K is one bounce; (1 - K)^-1 is found once for a fabric, so that a frame needs one product.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import moderngl
import numpy as np
from scipy import sparse

from ..accel.queries import RayQueries
from ..accel.structure import Structure, make_structure
from ..accel.triangles import Triangles
from ..color import luminance
from ..gpu.buffers import TextureBuffer
from ..gpu.layout import shared
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..light import equirect
from ..light.environment import Environment, rotation_y
from ..light.suns import split_suns
from ..tracing.shot import Shot
from .charts import OPEN
from .folds import Folds, HangingCloth, attenuate
from .form_factors import AZIMUTHS_DEG, CELLS, LEANS, PROXIES, UP, FormFactors, Sheet, factor_steps
from .layer_light import CurtainLayers, HangingPiece
from .room import Room

LAMP_POINTS = np.array([[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]])  # of an element, in its sides
CLOTH_SAMPLES = 22  # triangles of a cell of the curtain to which the lamp's rays are cast
GRID = shared("inputs/tracing/indirect.glsl")[0]["SHEET_GRID"]  # borders of cells lie at so manieth parts of the sheet
LEAST_CROSSING = 3e-4  # of a factor: less that crosses the curtain only as it leans makes no difference
SKY_SIZE = (32, 64)  # the map that the sky is read from: texels as wide as a cell of an opening at least


class Radiosity:
    """The light around one room with one curtain."""

    def __init__(
        self,
        ctx: moderngl.Context,
        room: Room,
        sheet: Sheet,
        hung: Triangles,
        pieces: Sequence[HangingPiece],
        each: Sequence[Triangles] = (),
    ):
        """
        hung : the curtains alone as they hang without wind; it is released with this. pieces : of them, one behind the other.
        each : of two curtains each alone, released as well
        """
        self.ctx, self.room = ctx, room
        self.cloth = HangingCloth(ctx, hung, sheet)
        self._factors: FormFactors | None = None
        self._structure: Structure | None = None
        self._triangles = Triangles.of(ctx, room.positions, 1)
        self._cell_triangles = _cells_of(pieces, sheet)
        self._layers = CurtainLayers(ctx, sheet, each, pieces) if each else None
        self._buffers: dict[str, TextureBuffer] = {}
        self._lamp: Last[int] = Last()
        self._folds: Last[Folds] = Last()
        self._sky: Last[np.ndarray] = Last()
        self._system: Last[None] = Last()
        self._small_map: Last[np.ndarray] = Last()

    # -- once for a room -----------------------------------------------------------------------------------------

    def prepare(self) -> Iterator[None]:
        """Find the form factors, if they are not known yet, in steps."""
        if self._factors is None:
            room, sheet = self.room, self.cloth.sheet
            for made in factor_steps(self.ctx, room.positions, self._room_structure, sheet, material=room.material):
                if isinstance(made, FormFactors):
                    self._factors = made
                    self._upload_static()
                else:
                    yield

    @property
    def factors(self) -> FormFactors:
        """Of the room; `prepare` finds them."""
        assert self._factors is not None, "call prepare first"
        return self._factors

    @property
    def _room_structure(self) -> Structure:
        if self._structure is None:
            self._structure = make_structure(self.ctx, "kdtree")
            self._structure.build(self._triangles)
        return self._structure

    @cached_property
    def _mean(self) -> sparse.csr_array:
        """[senders, receivers]: the irradiance of patches, by their open elements, and of the curtain's cells."""
        charts = self.factors.charts
        N, P = len(charts.positions), len(charts.patches)
        area = charts.area * np.where(self.factors.openness() >= OPEN, 1.0, 1e-6)
        weight = area / np.bincount(charts.patch_of, area, P)[charts.patch_of]
        middle = N + 3 * np.arange(2 * CELLS) + 1
        rows = np.concatenate([charts.patch_of, P + np.arange(2 * CELLS)])
        columns = np.concatenate([np.arange(N), middle])
        values = np.concatenate([weight, np.ones(2 * CELLS)])
        return sparse.csr_array((values, (rows, columns)), shape=(P + 2 * CELLS, N + 6 * CELLS))

    def _past(self, folds: Folds) -> np.ndarray:
        """The factors [S, R] of all that sends light, without wind: negative where the curtain attenuates them, and the curtain's
        cells as they send in each direction."""
        f = self.factors
        P, N, factors = len(f.charts.patches), len(f.charts.positions), f.factors[: f.light_senders].copy()
        share = f.crossing()[:P]
        # A pass takes a factor as clear or as attenuated: those of which a part crosses the curtain are attenuated here.
        some = (share > 0) & (share < 1)
        room = factors[:P, :N]
        room[some] *= 1.0 - (1.0 - float(luminance(folds.passes))) * share[some]
        room[share == 1] *= -1.0
        factors[P:] *= self._profile(folds, f.receivers[0], 0.0)
        return factors

    def _profile(self, folds: Folds, x: np.ndarray, lean: float) -> np.ndarray:
        """How much more than on average the curtain's cells send to places x [R, 3] as it leans: [2 cells, R]."""
        turn = np.array([[np.hypot(1.0, lean), 0.0, 0.0], [0.0, 1.0, -lean], [0.0, lean, 1.0]]) / np.hypot(1.0, lean)
        out = []
        for k, middle in enumerate(self.factors.sheet.cells(lean).mean(1)):
            d = (x - middle) @ turn.T
            d /= np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-9)
            out.append(folds.profile(int(k >= CELLS), d))
        return np.array(out)

    def _leaning(self, folds: Folds) -> np.ndarray:
        """The factors of the curtain's cells for the room's elements at the known leans, [4, 2 cells, N]."""
        f = self.factors
        P, x = len(f.charts.patches), f.charts.positions
        known = np.concatenate([f.factors[None, P : P + 2 * CELLS, : len(x)], f.leaning])
        return np.stack([F * self._profile(folds, x, lean) for F, lean in zip(known, LEANS, strict=True)])

    def _upload_leaning(self, folds: Folds) -> None:
        """What the passes of the leaning curtain read."""
        f = self.factors
        P, N = len(f.charts.patches), len(f.charts.positions)
        known = self._leaning(folds)
        # An element sees the front of a cell or its back.
        signed = known[:, :CELLS] - known[:, CELLS:]
        self._put("leaning_cells", np.ascontiguousarray(np.moveaxis(signed, 0, -1), np.float32))
        mean = self._mean[:P, :N]
        changes = np.stack([(mean @ (F - known[0]).T).T for F in known], -1)
        self._put("leaning_changes", np.ascontiguousarray(changes, np.float32))

    def _upload_crossings(self) -> None:
        """What more of factors crosses the curtain as it leans, element by element."""
        f = self.factors
        P, N = len(f.charts.patches), len(f.charts.positions)
        F, rest = f.factors[:P, :N], f.crossing()[:P]
        more = np.stack([F * (f.crossing(k)[:P] - rest) for k in (1, 2, 3)])
        element, sender = np.nonzero((np.abs(more).max(0) > LEAST_CROSSING).T)
        entries = np.zeros((len(element), 4), np.float32)
        entries[:, :3] = more[:, sender, element].T
        column = np.minimum(f.columns[sender, element], PROXIES[0] - 1)
        entries[:, 3] = 16 * sender + column  # exact; bits of a whole number would be a float that GPUs may flush to 0
        number = np.bincount(element, minlength=N)
        self._put("crossing_lists", np.stack([np.cumsum(number) - number, number], 1).astype(np.uint32), "rg32ui")
        self._put("crossing_entries", entries if len(entries) else np.zeros((1, 4), np.float32))

    def _upload_hanging(self) -> None:
        """The samples of each column of the curtain, how they hang without wind, and what they weigh in its lean."""
        chosen, sheet = np.concatenate(self._cell_triangles), self.factors.sheet
        middle = self.cloth.triangles.positions()[chosen].astype(float).mean(1)
        column = np.repeat(np.arange(CELLS) % PROXIES[0], [len(cell) for cell in self._cell_triangles])
        order = np.argsort(column, kind="stable")
        below = np.maximum(sheet.y_1 - middle[:, 1], 0.0)
        square = np.bincount(column, below**2, PROXIES[0])
        weight = below / np.maximum(square[column], 1e-9)
        number = np.bincount(column, minlength=PROXIES[0])
        self._hung_order = order
        self._put("hanging", np.stack([middle[order, 2], weight[order]], 1).astype(np.float32), "rg32f")
        self._put("hung_columns", np.stack([np.cumsum(number) - number, number], 1).astype(np.uint32), "rg32ui")

    def _upload_static(self) -> None:
        f = self.factors
        self._upload_crossings()
        self._upload_hanging()
        source, weight = f.charts.texels(f.openness())
        self._put("chart_data", f.charts.records())
        self._put("chart_of", f.charts.chart_of.astype(np.uint32), "r32ui")
        self._put("texel_sources", source.astype(np.uint32), "rgba32ui")
        self._put("texel_weights", weight.astype(np.float32))
        # In cells, at every fortieth of the sheet across, then up.
        grid = [
            np.interp(np.arange(GRID + 1) / GRID, borders, np.arange(len(borders))) for borders in (f.sheet.across, UP)
        ]
        self._put("sheet_grid", np.stack(grid, 1).astype(np.float32), "rg32f")
        self._chart_texels = len(source)
        for name in ("lights", "arrived", "received", "sent", "sources", "leans", "leaning"):
            self._put(name, 64)
        most = 6 * CELLS * (1 if self._layers is None else 2)
        self._buffers["light_texels"] = TextureBuffer(self.ctx, 16 * (len(source) + most))

    def _put(self, name: str, data: Any, format: str = "rgba32f") -> None:
        if isinstance(data, np.ndarray) and format == "rgba32f" and data.shape[-1] == 3:
            data = np.concatenate([data, np.zeros((*data.shape[:-1], 1))], -1)
        if isinstance(data, np.ndarray) and data.dtype == float:
            data = data.astype(np.float32)
        if name in self._buffers:
            self._buffers[name].write(data)
        else:
            self._buffers[name] = TextureBuffer(self.ctx, data, format)

    # -- once for a fabric, a lamp, a sky ------------------------------------------------------------------------

    def _lamp_samples(self, shot: Shot) -> int:
        """Points of elements that the lamp can light past the room, with their light, and the lists of all senders; returns
        how many points there are. The curtain's samples come behind them."""
        f, charts = self.factors, self.factors.charts
        lamp, intensity = np.array(shot.lighting.lamp.position), np.array(shot.lighting.lamp.intensity)
        points = charts.positions[:, None] + np.einsum(
            "pk,nkc->npc", LAMP_POINTS, np.stack([charts.sides_u, charts.sides_v], 1)
        )
        element = np.repeat(np.arange(len(charts.positions)), len(LAMP_POINTS))
        normals = charts.normals[element]
        points = points.reshape(-1, 3) + 1e-3 * normals
        d = lamp - points
        r = np.linalg.norm(d, axis=1)
        cos = (d * normals).sum(1) / np.maximum(r, 1e-9)
        lit = np.flatnonzero((cos > 0) & (r > 1e-6))
        queries = RayQueries(self.ctx)
        lit = lit[~queries.any_hit(self._room_structure, points[lit], d[lit] / r[lit, None], 0.0, r[lit] - 1e-3)]
        queries.release()
        light = intensity * (cos[lit] / r[lit] ** 2)[:, None]
        weights = self._mean.tocoo()
        share = np.zeros(len(charts.positions))
        in_patch = weights.col < len(share)
        share[weights.col[in_patch]] = weights.data[in_patch]
        patch = charts.patch_of[element[lit]]
        order = np.argsort(patch, kind="stable")
        number = np.bincount(patch, minlength=len(charts.patches))
        cloth = np.array([len(c) for c in self._cell_triangles])
        cloth_first = len(lit) + np.concatenate([[0], np.cumsum(cloth)])
        listed = np.zeros((len(lit) + int(cloth.sum()), 2), np.uint32)
        listed[: len(lit), 0] = order
        listed[: len(lit), 1] = (share[element[lit]][order] / len(LAMP_POINTS)).astype(np.float32).view(np.uint32)
        listed[len(lit) :, 0] = np.arange(len(lit), len(listed))
        listed[len(lit) :, 1] = np.repeat(1.0 / np.maximum(cloth, 1), cloth).astype(np.float32).view(np.uint32)
        lists = np.zeros((f.light_senders, 2), np.uint32)
        lists[: len(number), 0], lists[: len(number), 1] = np.cumsum(number) - number, number
        lists[len(number) :, 0], lists[len(number) :, 1] = np.tile(cloth_first[:-1], 2), np.tile(cloth, 2)
        grown = np.zeros((len(listed), 3))
        grown[: len(lit)] = points[lit]
        self._put("points", grown)
        grown[: len(lit)] = light
        self._put("lights", grown)
        self._buffers["arrived"].reserve(16 * len(listed))
        if self._layers is not None:
            more, entries = self._layers.samples(self._cell_triangles, len(lit), len(listed))
            lists, listed = np.concatenate([lists, more]), np.concatenate([listed, entries])
        self._put("lists", lists, "rg32ui")
        self._put("listed", listed, "rg32ui")
        self._put("chosen", np.zeros(1, np.uint32), "r32ui")
        self._put("hung", (len(lit) + self._hung_order).astype(np.uint32), "r32ui")
        return len(lit)

    def _sky_light(self, shot: Shot, folds: Folds) -> np.ndarray:
        """Irradiance of the receivers by the sky, as the curtain leans by the known leans, [R, 4, 3]. Suns are left out: the lamp
        stands for them."""
        f = self.factors
        x, _ = f.receivers
        out = np.zeros((len(x), 4, 3))
        if not len(f.openings):
            return out
        P, N = len(f.charts.patches), len(f.charts.positions)
        seen = f.factors[f.light_senders :]
        crossing = np.zeros((4, len(seen), len(x)), np.float32)
        for k in range(4):
            crossing[k, :, :N] = f.crossing(k)[P:]
        turn = rotation_y(-shot.env_rotate)
        environment = shot.environment
        small = None if environment is None else self._small_map.get(lambda: without_suns(environment), environment)
        for w, (corners, F) in enumerate(zip(f.openings, seen, strict=True)):
            sees = np.flatnonzero(F)
            radiance = np.zeros((len(sees), 4, 3))
            through = crossing[:, w, sees].T[:, :, None]
            for u, v in ((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)):
                point = corners[0] + u * (corners[1] - corners[0]) + v * (corners[3] - corners[0])
                d = point - x[sees]
                d /= np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-12)
                L = np.array(shot.lighting.background) if small is None else equirect.lookup(small, d @ turn.T)
                radiance += 0.25 * (L[..., None, :] * (1.0 - through) + (L * folds.along(d))[:, None] * through)
            out[sees] += np.pi * F[sees, None, None] * radiance
        return out

    def _solve_system(self, folds: Folds, sky: np.ndarray) -> None:
        """(1 - K)^-1, what is sent of the sky, and the shares of the lamp's light that are sent."""
        f = self.factors
        P, S = len(f.charts.patches), f.light_senders
        rho = self.room.reflectances[self.room.material[f.charts.patch_triangle]].astype(float)
        front, back = P + np.arange(CELLS), P + CELLS + np.arange(CELLS)
        factors = self._past(folds)
        self._upload_leaning(folds)
        # Four senders a texel, receiver by receiver, so that neighbours read neighbours.
        four = np.zeros((-(-P // 4) * 4, factors.shape[1]), np.float32)
        four[:P] = factors[:P]
        self._put("factors", np.ascontiguousarray(four.reshape(-1, 4, factors.shape[1]).transpose(0, 2, 1)))
        # [senders, senders]: irradiance of each by unit exitance of each, past the curtain and through it.
        clear, crossing = (self._mean @ np.maximum(sign * factors, 0).T for sign in (1, -1))
        sky_mean = self._mean @ sky[:, 0]
        bounces, sky_sent, shares = np.zeros((S, S, 4), np.float32), np.zeros((S, 3)), np.zeros((S, 3))
        for c in range(3):
            G = clear + folds.passes[c] * crossing
            K, sent = np.zeros((S, S)), np.zeros(S)
            for target, light in ((K, G), (sent, sky_mean[:, c])):
                target[:P] = (rho[:, c] * light[:P].T).T
                for k, (own, other) in enumerate(((front, back), (back, front))):
                    target[own] = folds.reflected[k, c] * light[own] + folds.transmitted[k, c] * light[other]
            # Column by column for the pass.
            bounces[..., c] = np.linalg.inv(np.eye(S) - K).T
            sky_sent[:, c] = sent
            shares[:P, c], shares[front, c], shares[back, c] = rho[:, c], folds.lamp[0, c], folds.lamp[1, c]
        self._put("bounces", bounces)
        if self._layers is not None:
            lamp = self._layers.lamp_shares()
            sky_sent, shares = np.concatenate([sky_sent, np.zeros_like(lamp)]), np.concatenate([shares, lamp])
        self._put("sky", sky_sent)
        self._put("shares", shares)
        self._put("sky_light", sky.reshape(-1, 3))

    # -- each frame ----------------------------------------------------------------------------------------------

    def light(self, shot: Shot, inputs: dict[str, Any], structure: Structure, first: int) -> dict[str, Any]:
        """Find the light of a frame: the inputs of inputs/tracing/indirect.glsl.

        inputs : of inputs/tracing/local_light.glsl for this shot, with `beyond` and `offset`. structure : of the room and the
        curtain as it hangs now. first : the curtain's first triangle there
        """
        f, lamp = self.factors, shot.lighting.lamp
        lit = self._lamp.get(lambda: self._lamp_samples(shot), lamp.position, lamp.intensity)
        chosen = np.concatenate(self._cell_triangles)
        fabric = "".join(one.model_dump_json() for one in shot.fabrics)
        hung = inputs | ({"fabric_from": [k - first for k in inputs["fabric_from"]]} if shot.others else {})
        folds = self._folds.get(lambda: self.cloth.folds(hung, chosen), fabric, lamp.position, lamp.intensity)
        if self._layers is not None:
            self._layers.find(hung, shot, fabric)
        sky = self._sky.get(
            lambda: self._sky_light(shot, folds), folds, shot.environment, shot.env_rotate, shot.lighting.background
        )
        self._system.get(lambda: self._solve_system(folds, sky), folds, sky)
        self._put("chosen", (first + chosen).astype(np.uint32), "r32ui")
        b, passes = self._buffers, programs(self.ctx)
        passes.compute("passes/curtain/lit_cloth.comp").run(
            len(chosen),
            inputs,
            chosen=b["chosen"],
            Points=b["points"],
            Lights=b["lights"],
            chosen_count=len(chosen),
            first=lit,
        )
        attenuate(self.ctx, structure, inputs, b["points"], b["lights"], b["arrived"], lit + len(chosen))
        S, R = f.light_senders, f.factors.shape[1]
        N, P = len(f.charts.positions), len(f.charts.patches)
        senders = S + (0 if self._layers is None else 4 * CELLS)
        for name, count in (("sources", senders), ("sent", S), ("received", R), ("leaning", S)):
            b[name].reserve(16 * count)
        passes.compute("passes/curtain/sources.comp").run(
            senders, lights=b["arrived"], sky=b["sky"], shares=b["shares"], lists=b["lists"], listed=b["listed"],
            Sources=b["sources"], sender_count=senders,
        )  # fmt: skip
        passes.compute("passes/curtain/bounces.comp").run(
            S, bounces=b["bounces"], sources=b["sources"], Sent=b["sent"], sender_count=S
        )
        self._gather(folds)
        texels = self._chart_texels + 6 * CELLS
        passes.compute("passes/curtain/light_texels.comp").run(
            texels, folds.seen(), received=b["received"], sources=b["sources"], sky=b["sky"], texel_sources=b["texel_sources"],
            texel_weights=b["texel_weights"], Texels=b["light_texels"], chart_texels=self._chart_texels, texel_count=texels,
            first_receiver=N, first_cell=P, cell_count=CELLS,
        )  # fmt: skip
        if self._layers is not None:
            self._layers.light(b, self._chart_texels, N, S)
        return self.inputs()

    def _gather(self, folds: Folds) -> None:
        """What all receivers get, as the curtain leans now."""
        f, b, passes = self.factors, self._buffers, programs(self.ctx)
        S, R, N, P = f.light_senders, f.factors.shape[1], len(f.charts.positions), len(f.charts.patches)
        b["leans"].reserve(16 * (PROXIES[0] + 1))
        passes.compute("passes/curtain/lean.comp").run(
            PROXIES[0] + 1, points=b["points"], hanging=b["hanging"], hung=b["hung"], columns=b["hung_columns"], Leans=b["leans"],
            column_count=PROXIES[0],
        )  # fmt: skip
        passes.compute("passes/curtain/leaning_sent.comp").run(
            S, sent=b["sent"], changes=b["leaning_changes"], leans=b["leans"], shares=b["shares"], Leaning=b["leaning"],
            patch_count=P, cell_count=2 * CELLS, across=PROXIES[0], sender_count=S,
        )  # fmt: skip
        through = tuple(map(float, folds.passes))
        passes.compute("passes/curtain/gather_light.comp").run(
            -(-R // 4), factors=b["factors"], sent=b["leaning"], sky_light=b["sky_light"], leans=b["leans"],
            Received=b["received"], receiver_count=R, sender_count=P, passes=through, mean_lean=PROXIES[0],
        )  # fmt: skip
        passes.compute("passes/curtain/leaning_light.comp").run(
            -(-N // 4), cells=b["leaning_cells"], leans=b["leans"], sent=b["leaning"], lists=b["crossing_lists"],
            crossing=b["crossing_entries"], Received=b["received"], element_count=N, patch_count=P, cell_count=CELLS,
            across=PROXIES[0], passes=through,
        )  # fmt: skip

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/tracing/indirect.glsl, as the last frame left them."""
        s = self.cloth.sheet
        return {
            **{name: self._buffers[name] for name in ("chart_of", "chart_data", "light_texels")},
            "sheet_texels": self._chart_texels,
            "sheet_place": (s.x_0, s.y_0, 1 / (s.x_1 - s.x_0), 1 / (s.y_1 - s.y_0)),
            "sheet_cells": PROXIES,
            "sheet_grid": self._buffers["sheet_grid"],
            "sheet_azimuth": float(np.sin(np.radians(AZIMUTHS_DEG[-1]))),
        }

    def irradiance(self) -> np.ndarray:
        """Read back what the receivers got in the last frame, but for the lamp's own light: [R, 3]."""
        R = self.factors.factors.shape[1]
        return np.frombuffer(self._buffers["received"].read(16 * R), np.float32).reshape(-1, 4)[:, :3].copy()

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer in self._buffers.values():
            buffer.release()
        self.cloth.release()
        self._triangles.release()
        if self._layers is not None:
            self._layers.release()
        if self._structure is not None:
            self._structure.release()


def without_suns(environment: Environment) -> np.ndarray:
    """A small map [32, 64, 3] of an environment without its suns."""
    height, width = environment.radiance.shape[:2]
    rest = split_suns(environment.radiance)[1]
    return equirect.downsample(rest, *SKY_SIZE) if height > SKY_SIZE[0] and width > SKY_SIZE[1] else rest


def _cells_of(pieces: Sequence[HangingPiece], sheet: Sheet) -> list[np.ndarray]:
    """For each cell of the sheet, row by row from below, triangles of the pieces (of each quads row by row from the top) that lie
    in it, at most `CLOTH_SAMPLES`, evenly spread."""
    nx, ny = PROXIES
    cells = []
    for piece in pieces:
        quad = np.arange(piece.rows * piece.columns)
        x = 0.5 + piece.shift + piece.width * (quad % piece.columns / piece.columns - 0.5)
        across = np.clip(np.searchsorted(sheet.across, x + 1e-9) - 1, 0, nx - 1)
        up = np.clip(np.searchsorted(UP, 1 - (quad // piece.columns + 0.5) / piece.rows) - 1, 0, ny - 1)
        cells.append(np.repeat(up * nx + across, 2))
    cell = np.concatenate(cells)
    out = []
    for k in range(nx * ny):
        of_cell = np.flatnonzero(cell == k)
        pick = np.unique(np.linspace(0, len(of_cell) - 1, min(CLOTH_SAMPLES, len(of_cell))).astype(int))
        out.append(of_cell[pick] if len(of_cell) else of_cell)
    return out

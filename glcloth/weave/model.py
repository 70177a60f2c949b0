"""The weave of a fabric as a frozen value: the `[weave]` table of a fabric file, and what follows from it."""

from __future__ import annotations

import copy
import math
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, ConfigDict, Field, PrivateAttr, field_serializer, field_validator, model_validator

from ..errors import InputError, short
from ..fields import Value, about

if TYPE_CHECKING:
    # Imported where they are used, as NumPy is: the command line starts without them.
    import numpy as np
    from numpy.typing import DTypeLike

    from .draft import Draft
    from .maps import Maps
    from .tile import Shape, Tile

COLOR_TO_ALBEDO = 0.42  # of white: a closed white cloth then reflects 0.8 of the light, as white cotton does


def _both(value: Any) -> Any:
    """One number stands for warp and weft alike."""
    return (value, value) if isinstance(value, int | float) and not isinstance(value, bool) else value


def _pair(low: float, high: float, exclusive: bool = False):
    number = Annotated[float, Field(gt=low, le=high) if exclusive else Field(ge=low, le=high)]
    return Annotated[tuple[number, number], BeforeValidator(_both)]


Albedo = Annotated[float, Field(ge=0.0, le=1.0)]
Width = _pair(0.05, 1.5)
Flat = _pair(0.1, 1.5)
Share = _pair(0.0, 1.0)
Pinch = _pair(0.0, 0.6)
Twist = _pair(-45.0, 45.0)
Steepest = _pair(0.0, 80.0)


class Stripe(Value):
    """Some neighbouring threads of one colour."""

    count: int = about("threads", "how many threads", ge=1, le=4096)
    albedo: tuple[Albedo, Albedo, Albedo] = about("linear Rec. 709", "their colour of the volume term, A")


class Irregularity(Value):
    """How far a real cloth is from a regular one. Standard deviations; the mean of each is 0, so the far cloth stays."""

    shift: float = about("yarns", "how far yarns wander sideways", default=0.12, ge=0.0, le=0.5)
    length: float = about("yarns", "how long a stretch they wander together", default=8.0, ge=1.0, le=64.0)
    yarn: float = about("", "how much lighter or darker single yarns are", default=0.1, ge=0.0, le=0.5)
    fibre: float = about("", "how much lighter or darker strands within a yarn are", default=0.2, ge=0.0, le=1.0)


class Derived(NamedTuple):
    """What a weave makes of its two yarns.

    areas : (a_1, a_2). tilts_deg, shares : for warp and weft the tangents and what share of the yarn each has.
    albedos : the yarns' colours from afar where threads have colours of their own, else None.
    """

    areas: tuple[float, float]
    tilts_deg: tuple[tuple[float, ...], tuple[float, ...]]
    shares: tuple[tuple[float, ...], tuple[float, ...]]
    albedos: tuple[tuple[float, float, float], tuple[float, float, float]] | None


class Weave(Value):
    """How a cloth is woven: a draft, the sett, and the shape of its yarns. Pairs are (warp, weft); one number is both.

    From it come the fabric's areas, tangents and weights (`derived`), the geometry of one repeat (`tile`) and the maps
    that show threads near by (`maps`, `color_map`).
    """

    model_config = ConfigDict(arbitrary_types_allowed=True)

    _side: int | None = PrivateAttr(None)  # texels a side that maps have at most; None: no other limit than the tile's

    draft: Any = about("", "a named weave, a WIF file, or a table with the drawdown")
    ends_per_cm: float = about("1/cm", "warp ends in a centimetre of width", ge=0.5, le=400.0)
    picks_per_cm: float = about("1/cm", "weft picks in a centimetre of length", ge=0.5, le=400.0)
    width: Width = about("of the spacing", "width of the yarns as they lie in the cloth", default=(0.95, 0.95))
    flat: Flat = about("", "height over width of the yarns' sections", default=(0.5, 0.5))
    crimp: float = about(
        "", "the warp's share of the waviness: 0 a straight warp, 1 a straight weft", default=0.5, ge=0, le=1
    )
    bow: Share = about("", "0 floats lie flat, 1 they are one arc", default=(0.3, 0.3))
    tilt_deg: Steepest | None = about(
        "degrees", "largest tilt of the yarns; default: what crimp and sett give", default=None
    )
    twist_deg: Twist = about("degrees", "fibres' angle to the yarn at its sides, + Z, - S", default=(0.0, 0.0))
    pinch: Pinch = about("", "how much narrower a yarn is where it dives", default=(0.12, 0.12))
    occlusion: float = about("", "how much darker the depths between yarns are", default=0.6, ge=0.0, le=0.95)
    roll: float = about("", "how far yarns look round across their width", default=1.0, ge=0.0, le=1.0)
    relief: float = about(
        "", "how far yarns hide each other from the side: 1 as they are high", default=1.0, ge=0.0, le=1.0
    )
    fuzz: float = about(
        "1/mm^2", "hairs that stand out from the cloth; they show beyond its outline", default=0.0, ge=0.0, le=60.0
    )
    fuzz_length: float = about("mm", "how long these hairs are", default=1.0, ge=0.1, le=6.0)
    irregularity: Irregularity = Irregularity()
    colors: Literal["yarn", "draft", "stripes"] = about(
        "", "whose colours the threads have: the yarn's albedo, the draft's, or the stripes'", default="yarn"
    )
    warp_stripes: tuple[Stripe, ...] | None = about("", "colours of the ends in order, repeated", default=None)
    weft_stripes: tuple[Stripe, ...] | None = about("", "colours of the picks in order, repeated", default=None)
    far: Literal["weave", "yarns"] = about(
        "", "where areas and tangents come from: this weave, or the yarns' own numbers", default="weave"
    )

    @model_validator(mode="before")
    @classmethod
    def _sett_of_the_draft(cls, data):
        """A draft that is no named weave knows its sett."""
        if isinstance(data, dict) and "draft" in data:
            import numpy as np

            from .draft import Draft

            draft = _draft(data["draft"])
            data = {**data, "draft": draft}
            if isinstance(draft, Draft):
                data.setdefault("ends_per_cm", float(np.clip(1.0 / draft.warp_spacing.mean(), 0.5, 400.0)))
                data.setdefault("picks_per_cm", float(np.clip(1.0 / draft.weft_spacing.mean(), 0.5, 400.0)))
        return data

    @field_validator("draft")
    @classmethod
    def _one_repeat(cls, value):
        return value if isinstance(value, str) else value.reduced()

    @model_validator(mode="after")
    def _colors_from_somewhere(self):
        stripes = self.warp_stripes, self.weft_stripes
        if self.colors == "stripes" and None in stripes:
            raise ValueError('colors = "stripes" needs warp_stripes and weft_stripes; add them')
        if self.colors != "stripes" and any(s is not None for s in stripes):
            raise ValueError(f'has stripes but colors = "{self.colors}", expected "stripes"; change it')
        if any(s is not None and (not s or sum(stripe.count for stripe in s) > 4096) for s in stripes):
            raise ValueError("warp_stripes and weft_stripes need 1 to 4096 threads each; change the counts")
        if self.colors == "draft" and not self.drafted.has_colors:
            raise ValueError('colors = "draft", but the draft says no colours; use "yarn" or "stripes"')
        return self

    @field_serializer("draft")
    def _plainly(self, value):
        from .plain import plain_draft

        return value if isinstance(value, str) else plain_draft(value)

    @cached_property
    def drafted(self) -> Draft:
        """The draft itself, one repeat."""
        from .named import named_draft

        return named_draft(self.draft) if isinstance(self.draft, str) else self.draft

    @property
    def shape(self) -> Shape:
        """The measures on which the geometry depends."""
        from .tile import Shape

        return Shape(
            draft=self.drafted,
            ends_per_cm=self.ends_per_cm,
            picks_per_cm=self.picks_per_cm,
            width=self.width,
            flat=self.flat,
            crimp=self.crimp,
            bow=self.bow,
            twist=tuple(map(math.radians, self.twist_deg)),
            pinch=self.pinch,
            steepest=None if self.tilt_deg is None else tuple(map(math.radians, self.tilt_deg)),
        )

    @property
    def thread_colors(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Albedos of the ends and of the picks in order, [n, 3] each, to be repeated; None where yarns have one colour."""
        if self.colors == "stripes":
            import numpy as np

            warp, weft = (
                np.repeat([s.albedo for s in stripes], [s.count for s in stripes], 0)
                for stripes in (self.warp_stripes, self.weft_stripes)
            )
            return warp, weft
        if self.colors == "draft":
            return COLOR_TO_ALBEDO * self.drafted.warp_colors, COLOR_TO_ALBEDO * self.drafted.weft_colors
        return None

    def sketch(self, side: int) -> Weave:
        """An equal weave whose maps have at most `side` texels a side, for a first answer to an edit."""
        out = copy.copy(self)
        out._side = side
        return out

    def tile(self, size: tuple[int, int] | None = None) -> Tile:
        """The geometry of one repeat of the structure; `size` = (H, W) texels, about 32 a yarn by default."""
        from .tile import make_tile

        return make_tile(self.shape, size)

    def derived(self, gamma_s_deg: tuple[float, float]) -> Derived:
        """Areas, tangents and colours of the two yarns; `gamma_s_deg` are the widths of their surface lobes."""
        return _derived(self.shape, self._colors_key(), gamma_s_deg)

    def maps(self, tilts_deg, weights, size: tuple[int, int] | None = None, dtype: DTypeLike = float) -> Maps:
        """The maps of one repeat for a fabric's tangents.

        tilts_deg, weights : for warp and weft [n_j], ascending, and w_t, the share of the whole cloth.
        """
        import numpy as np

        from .maps import make_maps
        from .tile import tile_size

        if self._side is not None:
            size = tuple(min(n, self._side) for n in size or tile_size(*self.drafted.structure))
        tilts = [np.radians(t) for t in tilts_deg]
        return make_maps(self.tile(size), tilts, weights, self.flat, self.occlusion, dtype)

    def color_map(self, maps: Maps) -> tuple[np.ndarray, tuple[float, float]] | None:
        """The map of the threads' colours beside `maps` (see colors.color_map); None where yarns have one colour."""
        from .colors import LARGEST, color_map

        colors = self.thread_colors
        largest = LARGEST if self._side is None else min(2 * self._side, LARGEST)
        return None if colors is None else color_map(self.tile(maps.hole.shape), colors, maps.share, largest)

    @property
    def is_sketch(self) -> bool:
        """Whether it is one of `sketch`."""
        return self._side is not None

    def as_draft(self, albedos) -> Draft:
        """The weave as a draft to save: at its sett, with its yarns' widths, and in the colours of its threads.

        albedos : [2, 3] of warp and weft, which count where threads have no colours of their own.
        """
        import numpy as np

        from .draft import Draft

        draft = self.drafted
        colors = self.thread_colors or tuple(np.array(albedos, float)[:, None])
        counts = [int(np.lcm(n, len(c))) for n, c in zip((draft.ends, draft.picks), colors, strict=True)]
        threads: dict[str, Any] = {}
        for j, (system, pitch) in enumerate(zip(("warp", "weft"), self.shape.pitch, strict=True)):
            for what, mean in (("spacing", pitch), ("thickness", self.width[j] * pitch)):
                own = getattr(draft, f"{system}_{what}")
                threads[f"{system}_{what}"] = np.resize(own * (mean / own.mean()), counts[j])
            own = np.clip(colors[j] / COLOR_TO_ALBEDO, 0.0, 1.0)
            threads[f"{system}_colors"] = own[np.arange(counts[j]) % len(own)]
        rows, columns = np.arange(counts[1]) % draft.picks, np.arange(counts[0]) % draft.ends
        return Draft(draft.drawdown[np.ix_(rows, columns)], **threads, title=draft.title)

    def _colors_key(self) -> tuple | None:
        colors = self.thread_colors
        return None if colors is None else tuple(tuple(map(tuple, c.tolist())) for c in colors)


@lru_cache(maxsize=16)
def _derived(shape: Shape, colors: tuple | None, gamma_s_deg: tuple[float, float]) -> Derived:
    import numpy as np

    from .colors import mean_color
    from .tangents import tile_tangents
    from .tile import make_tile

    tile = make_tile(shape)
    both = [tile_tangents(tile, j, float(np.radians(gamma_s_deg[j]))) for j in (0, 1)]
    areas = tuple(min(float(t.weights.sum()), 1.0) for t in both)
    tilts = tuple(tuple((np.round(np.degrees(t.tilts), 9) + 0.0).tolist()) for t in both)
    shares = tuple(tuple((t.weights / (a or 1.0)).tolist()) if a else (1.0,) for t, a in zip(both, areas, strict=True))
    albedos = None
    if colors is not None:
        albedos = tuple(tuple(mean_color(tile, j, np.array(colors[j])).tolist()) for j in (0, 1))
    return Derived(areas, tilts, shares, albedos)


def _draft(value: Any) -> str | Draft:
    """A draft as a file or a program gives it. Raises ValueError, which says what was expected."""
    from .draft import Draft
    from .named import named_draft
    from .others import is_draft
    from .plain import draft_of
    from .wif import load_draft

    if isinstance(value, Draft):
        return value
    if isinstance(value, Path) or (isinstance(value, str) and is_draft(value)):
        return load_draft(value)
    if isinstance(value, str):
        named_draft(value)
        return value
    if isinstance(value, dict):
        return draft_of(value)
    raise InputError(f"{short(value)}, expected a named weave, a WIF file or a table with the drawdown")

"""glcloth's fabrics in Mitsuba 3: set a variant, import this, and use the BSDF plugin `microcylinder`.

    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    import glcloth.mitsuba
    bsdf = mi.load_dict(glcloth.mitsuba.bsdf("silk_shot"))

After another `mi.set_variant` call `register()` again. Raises InputError where Mitsuba is not installed.
"""

from __future__ import annotations

import json
from pathlib import Path

from .errors import InputError
from .export.plain import numbers_of
from .fabric import Fabric, load_fabric

try:
    import mitsuba as mi
except ImportError:
    raise InputError("glcloth.mitsuba: needs Mitsuba 3: pip install 'glcloth[mitsuba]'") from None
if mi.variant() is None:
    raise InputError('glcloth.mitsuba: needs a variant first: mitsuba.set_variant("llvm_ad_rgb")')

from .export.mitsuba_bsdf import register

__all__ = ["bsdf", "register"]
register()


def bsdf(fabric: Fabric | str | Path, two_sided: bool = True) -> dict:
    """A fabric as Mitsuba's dictionary of a BSDF. Raises InputError as `load_fabric`."""
    one = {"type": "microcylinder", "numbers": json.dumps(numbers_of(load_fabric(fabric)))}
    return {"type": "twosided", "nested": one} if two_sided else one

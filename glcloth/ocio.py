"""View transforms of an OpenColorIO config, by the package opencolorio (`pip install 'glcloth[ocio]'`).

A config is a file (.ocio, .ocioz) or one that is built into OpenColorIO (ocio://default); $OCIO names one for all programs.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from .errors import InputError, meant
from .progress import warn

# What configs call linear Rec. 709, the ACES ones by their aliases.
LINEAR = (
    "Linear Rec.709 (sRGB)",
    "lin_rec709_srgb",
    "lin_rec709",
    "Utility - Linear - sRGB",
    "Linear Rec.709",
    "lin_srgb",
)
LUT_STOPS = (-14.0, 10.0)  # of `lut`: from 2^-14 to 2^10
LUT_EDGE = 65


@dataclass(frozen=True)
class OcioView:
    """One view of one display of a config: called with linear Rec. 709 [..., 3] it returns code values 0..1.

    config, display, view : as `ocio_view` has checked them
    """

    config: str
    display: str
    view: str

    @cached_property
    def _processor(self) -> Any:
        import PyOpenColorIO

        config, _ = _loaded(self.config, _changed_at(self.config))
        space = next((name for name in map(config.getCanonicalName, LINEAR) if config.getColorSpace(name)), None)
        try:
            if space is None:
                # The config's own space of scenes, reached from ours by the space that configs interchange.
                space = PyOpenColorIO.ROLE_SCENE_LINEAR
                first = PyOpenColorIO.Config.GetProcessorFromBuiltinColorSpace(
                    LINEAR[0], config, space
                ).getDefaultCPUProcessor()
            else:
                first = None
            transform = PyOpenColorIO.DisplayViewTransform(src=space, display=self.display, view=self.view)
            return first, config.getProcessor(transform).getDefaultCPUProcessor()
        except PyOpenColorIO.Exception as error:
            raise _wrong(self.config, error) from None

    def __call__(self, rgb: np.ndarray) -> np.ndarray:
        pixels = np.ascontiguousarray(np.reshape(rgb, (-1, 3)), np.float32)
        for processor in self._processor:
            if processor is not None:
                pixels = np.array(pixels)  # it works in place
                processor.applyRGB(pixels)
        return np.clip(np.nan_to_num(pixels.astype(np.float64)), 0.0, 1.0).reshape(np.shape(rgb))

    @cached_property
    def lut(self) -> np.ndarray:
        """Codes of a grid of colours, float32 [blue, green, red, 3], evenly spaced in stops over LUT_STOPS: for the window."""
        stops = np.exp2(np.linspace(*LUT_STOPS, LUT_EDGE))
        stops[0] = 0.0
        blue, green, red = np.meshgrid(stops, stops, stops, indexing="ij")
        return self(np.stack([red, green, blue], -1)).astype(np.float32)

    @property
    def srgb(self) -> bool:
        """Whether its codes are for an sRGB display, as far as the display's name tells."""
        return "srgb" in self.display.lower()


def ocio_view(config: str = "", display: str = "", view: str = "") -> OcioView | None:
    """A view of a config, its default display and view where none is named; None where no config is named, nor by $OCIO.

    Raises InputError for a config that cannot be read, for a display or view that it does not have, and where the package
    opencolorio is missing; where it is missing and $OCIO alone asks for it, None with a warning.
    """
    asked = bool(config or display or view)
    name = config or os.environ.get("OCIO", "")
    if not name:
        if asked:
            raise InputError("display, ocio_view: of an OpenColorIO config; name one by --ocio CONFIG or $OCIO")
        return None
    try:
        import PyOpenColorIO  # noqa: F401
    except ImportError:
        if asked:
            raise InputError(f"ocio {name}: needs opencolorio: pip install 'glcloth[ocio]'") from None
        _warn_once(
            f"OCIO={name} is set: needs opencolorio (pip install 'glcloth[ocio]'); our own view transforms serve"
        )
        return None
    _, displays = _loaded(name, _changed_at(name))
    display = _named("display", display, displays, name) if display else next(iter(displays))
    views = displays[display]
    return OcioView(name, display, _named("ocio_view", view, views, f"{name}, display {display}") if view else views[0])


def _named(what: str, name: str, known: Iterable[str], where: str) -> str:
    if name in known:
        return name
    hint = meant(name, known)
    raise InputError(f"{what} {name!r}: {where} has none of this name; {hint}it has {', '.join(known)}")


def _changed_at(name: str) -> int:
    return os.stat(name).st_mtime_ns if os.path.isfile(name) else 0


@lru_cache(maxsize=4)
def _loaded(name: str, _changed: int) -> tuple[Any, dict[str, list[str]]]:
    """A config, and the views of its displays, the default ones first. Raises InputError."""
    import PyOpenColorIO

    if not name.startswith("ocio://") and not os.path.isfile(name):
        raise InputError(
            f"ocio {name}: no such file; give a config (.ocio, .ocioz) or a built-in one such as ocio://default"
        )
    PyOpenColorIO.SetLoggingLevel(PyOpenColorIO.LOGGING_LEVEL_NONE)
    try:
        config = PyOpenColorIO.Config.CreateFromFile(name)
        config.validate()
    except PyOpenColorIO.Exception as error:
        raise _wrong(name, error) from None
    displays = {}
    for display in sorted(config.getDisplays(), key=lambda d: d != config.getDefaultDisplay()):
        default = config.getDefaultView(display)
        displays[display] = sorted(config.getViews(display), key=lambda v, default=default: v != default)
    if not any(displays.values()):
        raise InputError(f"ocio {name}: has no displays; give another config")
    return config, displays


def _wrong(name: str, error: Exception) -> InputError:
    reason = " ".join(str(error).split())[:160]
    return InputError(f"ocio {name}: cannot be used ({reason}); give another config, such as ocio://default")


@lru_cache(maxsize=1)
def _warn_once(text: str) -> None:
    warn(text)

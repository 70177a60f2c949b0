"""A scene or a picture before one's eyes: in a notebook, or in the desktop's viewer."""

from __future__ import annotations

import io
import os
import sys
from typing import Any

import numpy as np

from ..errors import InputError
from ..image import Picture
from ..scene import Scene
from .renderer import Renderer


def show(scene: Scene | str | np.ndarray | None = None, **changes: Any) -> None:
    """Show a picture: in a notebook under the cell, else by the desktop's viewer of pictures.

    Parameters
    ----------
    scene : an array [H, W, 3 or 4], linear Rec. 709, or what `Renderer.render` takes, with the same keywords

    Raises InputError as `Renderer.render`, for an array of another shape, and where there is nothing to show it on.
    """
    if isinstance(scene, np.ndarray):
        if changes:
            raise InputError(
                f"show: {next(iter(changes))}: an array is shown as it is; give a scene, or leave this out"
            )
        picture = scene.view(Picture) if not isinstance(scene, Picture) else scene
    else:
        with Renderer() as renderer:
            picture = renderer.render(scene, **changes)
    png = picture._repr_png_()
    if png is None:
        raise InputError(f"show: an array of shape {picture.shape}, expected floats [H, W, 3] or [H, W, 4]")
    if (display := _notebook()) is not None:
        display(picture)
        return
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError(
            "show: no notebook and no display here; write a file: glcloth.write_image('picture.png', picture)"
        )
    from PIL import Image

    Image.open(io.BytesIO(png)).show()


def _notebook() -> Any:
    """IPython's `display` where a notebook runs; else None."""
    if "IPython" not in sys.modules:
        return None
    from IPython import get_ipython
    from IPython.display import display

    return display if getattr(get_ipython(), "kernel", None) is not None else None

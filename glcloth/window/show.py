"""A scene or a picture before one's eyes: in a notebook, or in the desktop's viewer."""

from __future__ import annotations

import atexit
import io
import os
import sys
from typing import Any

import numpy as np

from ..errors import InputError
from ..image import Picture
from ..picture.renderer import Renderer
from ..scene import Scene, load_scene
from .browser import LiveView


def show(scene: Scene | str | np.ndarray | None = None, *, live: bool = True, **changes: Any) -> LiveView | None:
    """Show a scene live under a notebook's cell, where mouse and sliders change it, or a still picture.

    Parameters
    ----------
    scene : an array [H, W, 3 or 4], linear Rec. 709, or what `Renderer.render` takes, with the same keywords
    live : False: a still picture also in a notebook; it stays in the saved notebook

    Returns what is live, with its present `scene` and `fabric`, and `close()`; None for a picture. An array, the curtain,
    and scenes with objects made in Python (meshes, environments, lights) are pictures. Without a notebook a picture is
    shown by the desktop's viewer of pictures.

    Raises InputError as `Renderer.render`, for an array of another shape, and where there is nothing to show it on.
    """
    if live and not isinstance(scene, np.ndarray) and (display := _notebook()) is not None:
        chosen = _alone(scene, changes)
        if chosen is not None:
            return _live(chosen, display)
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


def _alone(scene: Scene | str | None, changes: dict[str, Any]) -> Scene | None:
    """A scene that fields alone describe, as the live view needs it; None for others, and for the curtain."""
    if not set(changes) <= set(Scene.model_fields):
        return None
    if not all(isinstance(changes.get(name, ""), str | tuple | list) for name in ("mesh", "env", "objects")):
        return None
    chosen = (Scene() if scene is None else load_scene(scene)).changed(**changes)
    return chosen if chosen.curtain is None else None


def _live(scene: Scene, display: Any) -> LiveView:
    """A live view under the cell."""
    view = LiveView(scene)
    try:
        view.wait()
    except BaseException:
        view.close()
        raise
    atexit.register(view.close)
    display(_frame(view.address, max(scene.size[1] + 60, 460)))
    return view


def _frame(address: str, height: int) -> Any:
    """A page as a cell shows it."""
    from IPython.display import IFrame

    return IFrame(address, "100%", height)


def _notebook() -> Any:
    """IPython's `display` where a notebook runs; else None."""
    if "IPython" not in sys.modules:
        return None
    from IPython import get_ipython
    from IPython.display import display

    return display if getattr(get_ipython(), "kernel", None) is not None else None

"""The window: edit a fabric while it renders, or a curtain while it moves in the wind."""

from __future__ import annotations

from ..scene import Scene


def view(scene: Scene, watch: bool = False, source: str | None = None, device: int | str | None = None) -> None:
    """Open the window on a scene and stay until it is closed.

    Parameters
    ----------
    watch : reload shaders, fabric, mesh, environment and scene files when they change
    source : the file the scene came from, if any
    device : number or name of the one that shall draw; None: the display's own

    Raises NoOpenGLError without a display or OpenGL 4.3, InputError when the scene's files cannot be read, and
    ShaderError.
    """
    from .app import App

    App(scene, watch, source, device).run()

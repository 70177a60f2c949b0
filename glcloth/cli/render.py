"""`glcloth render`: one picture; `glcloth view`: the window."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..errors import InputError
from .common import Device, Json, output_option, tell, whole
from .options import SceneOptions, scene_of

if TYPE_CHECKING:
    import numpy as np

    from ..curtain.show import CurtainShow
    from ..scene import Scene


def render(
    scene: str | None = None,
    /,
    *,
    output: Annotated[Path, output_option("Picture to write, .png or .exr.")],
    options: SceneOptions | None = None,
    frame: Annotated[
        int | None,
        Parameter(
            converter=whole, help="Frame of the moving curtain; default: that of the picture given as scene, or 48."
        ),
    ] = None,
    show_tree: Annotated[
        str | None,
        Parameter(help="Curtain: the tree beside the picture, with --gi photons theirs: leaves, or a level."),
    ] = None,
    layers: Annotated[
        bool, Parameter(negative="", help="Curtain: blended layers without shadows instead, to compare.")
    ] = False,
    aov: Annotated[
        str | None,
        Parameter(
            help="Layers for compositing, in the .exr: some of depth,normal,position,uv,albedo,direct,bounce,transmission,"
            "background,mask,cryptomatte, or all."
        ),
    ] = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """Render one picture of a scene.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    chosen = scene_of(scene, options, frame=frame)
    _check_views(chosen, show_tree, layers)
    if aov is not None and output.suffix.lower() != ".exr":
        raise InputError(f"{output}: --aov writes layers, expected a name that ends in .exr")
    if aov is not None and (layers or show_tree is not None):
        raise InputError(
            f"--aov, {'--layers' if layers else '--show-tree'}: expected one of them; the latter is a picture alone"
        )

    from ..image import check_output, write_image
    from ..picture.renderer import Renderer
    from ..scene import header

    check_output(output)
    transform = chosen.transform
    begin = time.perf_counter()
    with Renderer(device) as renderer:
        if layers or show_tree is not None:
            picture = _views(renderer.show(chosen), show_tree, layers)
        else:
            picture = renderer.render(chosen, aovs=aov or ())
        facts, gl = renderer.facts(), renderer.ctx.info["GL_RENDERER"]
    look: dict[str, Any] = {"exposure": chosen.exposure, "view_transform": transform}
    if aov:
        look["layers"], picture = picture, picture["beauty"]
    write_image(output, picture, header(chosen), **look)
    seconds = time.perf_counter() - begin
    result: dict[str, Any] = {"file": str(output), "width": picture.shape[1], "height": picture.shape[0]}
    result |= facts | {"seconds": round(seconds, 3), "gl_renderer": gl}
    tell(json, result, f"{output}: {facts['fabric']}, method {facts['method']}, {seconds:.1f} s on {gl}")


def _check_views(scene: Scene, show_tree: str | None, layers: bool) -> None:
    """Raise InputError for views of the curtain that cannot be."""
    if scene.curtain is None and (layers or show_tree is not None):
        option = "--layers" if layers else "--show-tree"
        raise InputError(f"{option}: belongs to the curtain; give its scene: glcloth render curtain")
    if show_tree is not None and show_tree != "leaves" and not show_tree.isdigit():
        raise InputError(f"--show-tree {show_tree}: expected leaves, or a level such as 8")
    if show_tree is not None and scene.accelerator == "brute" and scene.gi != "photons":
        raise InputError("--show-tree: brute force has no tree; use --accelerator kdtree or lbvh")
    if layers and scene.method == "path":
        raise InputError("--layers: blended layers trace no paths; leave out --method path, or --layers")


def _views(show: CurtainShow, show_tree: str | None, layers: bool) -> np.ndarray:
    """The curtain, and its tree beside it."""
    import numpy as np

    picture = show.layers() if layers else show.picture()
    if show_tree is None:
        return picture
    tree = show.tree(None if show_tree == "leaves" else int(show_tree))
    return np.hstack([picture[..., :3], tree[..., :3]])


def view(
    scene: str | None = None,
    /,
    *,
    watch: Annotated[
        bool,
        Parameter(negative="", help="Reload shaders, fabric, mesh, environment and scene when their files change."),
    ] = False,
    http: Annotated[
        int | None,
        Parameter(
            converter=whole, help="Serve it to a browser on this port instead, 0: a free one; the address is printed."
        ),
    ] = None,
    host: Annotated[
        str | None,
        Parameter(help="With --http: the address to listen on, 127.0.0.1 if none is given; others let others in."),
    ] = None,
    options: SceneOptions | None = None,
    device: Device = None,
) -> None:
    """Open the window, or with --http a page in a browser: edit a fabric while it renders.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    chosen = scene_of(scene, options)
    if http is not None:
        if watch:
            raise InputError("--watch: belongs to the window; leave it or --http out")
        from ..window.browser import LOOPBACK, serve

        serve(chosen, http, host or LOOPBACK, device)
        return
    if host is not None:
        raise InputError(f"--host {host}: is where --http listens; give --http PORT too, or leave it out")

    from ..window import view as open_window

    open_window(chosen, watch, scene, device)

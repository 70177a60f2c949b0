"""The Renderer in Python: pictures in notebooks, moving vertices, and use where it cannot work."""

import gc
import io
import os
import pickle
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest
from PIL import Image

import glcloth
from glcloth.color import view
from glcloth.errors import InputError
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh
from glcloth.gpu.gbuffer import GBuffer

FAST = {"size": (16, 12), "mesh": "plane", "env": "studio", "lobes": 4, "shadows": "off", "quality": "draft"}


def test_a_picture_is_an_array_that_notebooks_show(renderer):
    picture = renderer.render(**FAST, exposure=1.0, view_transform="agx")
    assert isinstance(picture, np.ndarray) and picture.dtype == np.float32 and picture.shape == (12, 16, 3)
    shown = np.asarray(Image.open(io.BytesIO(picture._repr_png_())))
    np.testing.assert_array_equal(shown, np.round(255 * view(np.asarray(picture), "agx", 1.0)).astype(np.uint8))
    assert (picture[2:5] * 0.5)._repr_png_() and picture[..., 0]._repr_png_() is None
    assert (picture > 0)._repr_png_() is None and (pickle.loads(pickle.dumps(picture)) == picture).all()
    layers = renderer.render(**FAST, aovs="mask", exposure=1.0, view_transform="agx")
    assert layers._repr_png_() == picture._repr_png_()


def test_show(renderer, monkeypatch):
    shown = []
    monkeypatch.setattr("glcloth.window.show._notebook", lambda: shown.append)
    picture = renderer.render(**FAST)
    glcloth.show(picture)
    assert shown[0] is picture
    with pytest.raises(InputError, match=r"array of shape \(3, 3\)"):
        glcloth.show(np.zeros((3, 3)))
    with pytest.raises(InputError, match="an array is shown as it is"):
        glcloth.show(picture, spp=2)
    monkeypatch.setattr("glcloth.window.show._notebook", lambda: None)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if sys.platform.startswith("linux"):
        with pytest.raises(InputError, match="no notebook and no display"):
            glcloth.show(picture)


@pytest.mark.parametrize("inverted", [False, True])
def test_moved_vertices_make_the_mesh_that_a_file_of_them_would(inverted):
    plane = load_mesh("plane")
    uv = plane.uv.copy()
    uv[:, 0] = np.abs(uv[:, 0] - uv[:, 0].mean())  # mirrored in the middle: vertices are split there
    normals = -plane.normals if inverted else None  # the winding follows it
    mesh = build_mesh("m", plane.positions, plane.triangles, uv, normals)
    bent = mesh.positions.astype(float)
    bent[:, 2] += 0.2 * np.sin(3 * bent[:, 0]) + 0.1 * bent[:, 1] ** 2
    moved = mesh.moved(bent)
    smooth = build_mesh("m", bent, mesh.triangles)
    assert moved.triangles is mesh.triangles and moved.uv is mesh.uv
    np.testing.assert_allclose(moved.normals, smooth.normals, atol=1e-5)
    expected = build_mesh("m", bent, mesh.triangles, mesh.uv, moved.normals)
    assert len(expected.positions) == len(moved.positions)
    np.testing.assert_allclose(moved.tangents, expected.tangents, atol=1e-5)
    np.testing.assert_allclose(mesh.moved(mesh.positions).tangents, mesh.tangents, atol=1e-5)
    for wrong, said in ((bent[:-1], "positions, expected"), (bent * np.nan, "expected finite numbers")):
        with pytest.raises(InputError, match=said):
            mesh.moved(wrong)


def test_a_prepared_frame_moves(renderer):
    frame = renderer.prepare(**FAST)
    still = renderer.render_frame(frame)
    up = frame.moved(frame.mesh.positions + np.float32([0.0, 0.2, 0.0]))
    there = renderer.render_frame(up)
    assert up.camera == frame.camera and up.lights is frame.lights
    assert (there != still).any() and (renderer.render_frame(frame) == still).all()
    again = renderer.render(**FAST | {"mesh": up.mesh}, camera=frame.camera)
    np.testing.assert_allclose(there, again, atol=1e-6)
    with pytest.raises(InputError, match="cloth 1: this frame has 1"):
        frame.moved(frame.mesh.positions, 1)


def test_use_where_it_cannot_work_is_one_line(ctx):
    renderer = glcloth.Renderer(ctx=ctx)
    said = []

    def elsewhere():
        for use in (lambda: renderer.render(**FAST), lambda: renderer.prepare(**FAST), renderer.close):
            with pytest.raises(InputError, match="belongs to another thread") as error:
                use()
            said.append(str(error.value))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert len(said) == 3 and "\n" not in said[0]
    renderer.close()
    renderer.close()
    uses = (
        lambda: renderer.render(**FAST),
        lambda: renderer.show("curtain"),
        lambda: renderer.radiance("linen", [[0, 0, 1]], None),
    )
    for use in uses:
        with pytest.raises(InputError, match="this Renderer is closed"):
            use()


FORK = """
import os, signal, sys
import glcloth
from glcloth.gpu.context import create_context
ctx = create_context()
kept = glcloth.Renderer(ctx=ctx)
pid = os.fork()
if pid == 0:
    signal.alarm(60)
    for use in (glcloth.Renderer, kept.prepare):
        try:
            use()
        except glcloth.InputError as error:
            print(error, flush=True)
    os._exit(7)
print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="another rasteriser")
def test_a_forked_process_says_so_at_once():
    done = subprocess.run([sys.executable, "-c", FORK], capture_output=True, text=True, check=True)
    *lines, status = done.stdout.splitlines()
    assert len(lines) == 2 and all("forked from one that had used OpenGL" in line and "spawn" in line for line in lines)
    assert status == "7", done.stderr


def test_pictures_of_many_sizes_leave_no_buffers_behind(renderer):
    """Not those of the sizes before, with shadows neither."""

    def kept(*widths):
        for width in widths:
            renderer.render(**{**FAST, "size": (width, 12), "shadows": "full"})
        gc.collect()
        return sum(isinstance(one, GBuffer) for one in gc.get_objects())

    few = kept(16, 18, 20)
    assert few and kept(*range(22, 32, 2)) <= few


def test_one_that_is_dropped_frees_its_context():
    renderer = glcloth.Renderer()
    renderer.render(**FAST)
    context = weakref.ref(renderer.ctx)
    held = weakref.ref(renderer.stage)
    del renderer
    assert context() is None and held() is None, "nothing holds it"
    renderer = glcloth.Renderer()
    context, kept = weakref.ref(renderer.ctx), renderer.ctx
    del renderer
    gc.collect()
    assert context() is kept and kept.error == "GL_NO_ERROR", "who holds the context can go on with it"
    kept.release()

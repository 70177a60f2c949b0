"""The ground: shared structs, includes and their errors, texture buffers, camera rays, the G-buffer's frames."""

import numpy as np
import pytest

from glcloth.errors import InputError, ShaderError
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh
from glcloth.gpu import layout, shader
from glcloth.gpu.buffers import Buffer, TextureBuffer
from glcloth.gpu.gbuffer import Drawn, GBuffer, MeshBuffers
from glcloth.gpu.programs import Programs

STRUCTS = layout.shared()[1]


@pytest.mark.parametrize("name", sorted(STRUCTS))
def test_structs_mean_the_same_on_both_sides(ctx, name):
    """Echo: random integers through the dtype, each member copied out by a kernel, must come back exactly."""
    dtype = STRUCTS[name]
    rng = np.random.default_rng(1)
    data = np.zeros(5, dtype)
    for field in dtype.names:
        data[field] = rng.integers(1, 1000, data[field].shape)
    for field in dtype.names:
        base, shape = dtype[field].base, dtype[field].shape
        width = int(np.prod(shape)) if shape else 1
        parts = [f"items[i].{field}" + (f"[{c}]" if shape else "") for c in range(width)]
        kind = {"f": "float", "i": "int", "u": "uint"}[base.kind]
        kernel = "\n".join(
            [
                "#version 430",
                "layout(local_size_x = 1) in;",
                '#include "core/shared.glsl"',
                f"layout(std430) readonly buffer In {{ {name} items[]; }};",
                f"layout(std430) writeonly buffer Out {{ {kind} results[]; }};",
                "void main() { uint i = gl_GlobalInvocationID.x;",
                *[f"results[i * {width}u + {c}u] = {part};" for c, part in enumerate(parts)],
                "}",
            ]
        )
        program = Programs(ctx).compute("<echo>", None, {"<echo>": kernel})
        result = Buffer(ctx, 4 * 5 * width)
        program.run(5, In=Buffer(ctx, data), Out=result)
        got = np.frombuffer(result.read(), base).reshape(5, width)
        assert np.array_equal(got, data[field].reshape(5, width)), field


def test_includes_come_once_and_in_order():
    virtual = {
        "a": '#version 430\n#include "b"\n#include "c"\nvoid main() {}',
        "b": '#include "c"\nint b;',
        "c": "int c;",
    }
    text, where = shader.flatten("a", {"N": 3}, virtual)
    assert text.splitlines() == ["#version 430", "#define N 3", "int c;", "int b;", "void main() {}"]
    assert where == [("a", 1), ("<defines>", 0), ("c", 1), ("b", 2), ("a", 4)]


def test_an_include_cycle_and_a_missing_file_are_named():
    with pytest.raises(ShaderError, match="a -> b -> a"):
        shader.flatten("a", virtual={"a": '#include "b"', "b": '#include "a"'})
    with pytest.raises(ShaderError, match='a: no such file "core/nothere'):
        shader.flatten("a", virtual={"a": '#include "core/nothere.x"'})


def test_compile_errors_name_the_file_and_line(ctx):
    kernel = '#version 430\nlayout(local_size_x = 1) in;\n#include "lib"\nvoid main() {}'
    with pytest.raises(ShaderError, match=r"glsl/lib:2: .*oops"):
        Programs(ctx).compute("k", None, {"k": kernel, "lib": "float f() {\nreturn oops;\n}"})


@pytest.mark.parametrize("log", ["0:3(5): error: bad", "0(3) : error C1: bad", "ERROR: 0:3: bad"])
def test_logs_of_all_vendors_are_mapped(log):
    where = [("a.glsl", 1), ("a.glsl", 2), ("b.glsl", 1)]
    assert shader.explain(log, where).startswith("glsl/b.glsl:1: ")


def test_texture_buffers_read_what_was_written_and_grow(ctx):
    kernel = """#version 430
layout(local_size_x = 1) in;
uniform samplerBuffer data;
layout(std430) writeonly buffer Out { vec4 result[]; };
void main() { result[gl_GlobalInvocationID.x] = texelFetch(data, int(gl_GlobalInvocationID.x)); }"""
    program = Programs(ctx).compute("k", None, {"k": kernel})
    buffer = TextureBuffer(ctx, 16)
    for count in (1, 50, 7):
        values = np.random.default_rng(count).random((count, 4)).astype("f4")
        buffer.write(values)
        result = Buffer(ctx, 16 * count)
        program.run(count, data=buffer, Out=result)
        assert np.array_equal(np.frombuffer(result.read(), "f4").reshape(-1, 4), values)
    buffer.release()


CAMERA = Camera((1.0, 2.0, 5.0), (0.2, 0.1, -0.3), (0.1, 1.0, 0.0), 40.0)


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.3, -0.2)])
def test_a_pixels_ray_goes_through_what_the_matrix_projects_there(offset):
    size = (200, 120)
    rays = CAMERA.ray_from_pixel(size, offset)
    clip = CAMERA.clip_from_world(size, 0.1, 50.0, offset)
    for x, y in ((0.5, 0.5), (100.5, 60.5), (199.5, 3.5)):
        point = np.array(CAMERA.eye) + 3.0 * (rays @ [x, y, 1.0])
        c = clip @ [*point, 1.0]
        assert (c[:2] / c[3] + 1) / 2 * size == pytest.approx([x, y], abs=1e-6)


def test_wrong_cameras_are_input_errors():
    with pytest.raises(InputError, match="move one"):
        Camera((0, 0, 0), (0, 0, 0))
    with pytest.raises(InputError, match="along the view"):
        Camera((0, 5, 0), (0, 0, 0), (0, 1, 0))
    with pytest.raises(InputError, match="fov"):
        Camera(fov_deg=190)


def frames(ctx, mesh, camera, size=(64, 48)):
    buffer, buffers = GBuffer(ctx, size), MeshBuffers(ctx, mesh)
    buffer.draw(buffers, camera)
    read = [
        np.frombuffer(t.read(), "f4").reshape(size[1], size[0], 4) for t in map(buffer.frame, ("frame_N", "frame_x"))
    ]
    rays = np.array([[buffer.ray_from_pixel @ [x + 0.5, y + 0.5, 1] for x in range(size[0])] for y in range(size[1])])
    buffer.release()
    buffers.release()
    return (*read, rays)


def test_frames_face_the_viewer_and_are_orthonormal(ctx):
    N, x, rays = frames(ctx, load_mesh("sphere"), Camera((0, 0.4, 2.2), (0, 0, 0)))
    seen = N[..., 3] != 0
    assert 0.2 < seen.mean() < 0.9
    assert np.allclose(np.linalg.norm(N[seen][:, :3], axis=1), 1, atol=1e-5)
    assert np.abs(np.sum(N[seen][:, :3] * x[seen][:, :3], 1)).max() < 1e-5
    omega_o = -rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    assert np.sum(N[..., :3] * omega_o, -1)[seen].min() > 0.015


def test_bands_lose_no_triangle(ctx):
    """However small it is or wherever it begins: splinters less than a pixel high, and a floor that runs behind the eye."""
    rng = np.random.default_rng(3)
    corners = rng.uniform((-1.0, -0.7, 0.0), (1.0, 0.7, 0.3), (150, 1, 3)) + rng.normal(0.0, 1.0, (150, 3, 3)) * (
        0.1,
        0.006,
        0,
    )
    floor = np.array([[[-9, -0.5, -9], [9, -0.5, -9], [0, -0.5, 30]]], float)
    positions = np.concatenate([corners, floor]).reshape(-1, 3)
    mesh = build_mesh("splinters", positions, np.arange(len(positions)).reshape(-1, 3))
    camera, size = Camera((0.0, 0.1, 3.0), (0.0, 0.0, 0.0)), (40, 48)
    buffer, buffers, found = GBuffer(ctx, size), MeshBuffers(ctx, mesh), []
    wanted = Drawn(buffers, camera, (0.0, 0.0), (0.05, 60.0))
    for rows in (48, 7, 1):
        buffer.forget()
        for _ in buffer.draw_bands(wanted, rows):
            pass
        found.append(buffer.frame("frame_p").read())
    assert found[0] == found[1] == found[2]
    covered = buffer.covered()[::-1]
    assert 0.3 < covered.mean() < 0.9
    hit, missed = (tuple(map(int, np.argwhere(covered == seen)[0][::-1])) for seen in (True, False))
    assert buffer.triangle_at(*missed) is None and 0 <= buffer.triangle_at(*hit) <= 150
    buffer.release()
    buffers.release()


def test_the_back_of_a_sheet_keeps_its_yarns(ctx):
    """Seen from behind, N turns to the viewer while yarn 1 and yarn 2 keep their directions in space."""
    quad = build_mesh(
        "quad",
        np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float),
        np.array([[0, 1, 2], [0, 2, 3]]),
        np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float),
        None,
    )
    yarn_2 = {}
    for side, z in ((1, 3.0), (-1, -3.0)):
        N, x, _ = frames(ctx, quad, Camera((0.1, 0.1, z), (0, 0, 0)))
        seen = N[..., 3] != 0
        assert np.allclose(N[seen][:, :3], [0, 0, side], atol=1e-5)
        assert np.allclose(x[seen][:, :3], [1, 0, 0], atol=1e-5) and np.all(x[seen][:, 3] == side)
        yarn_2[side] = (N[seen][:, 3:] * np.cross(N[seen][:, :3], x[seen][:, :3]))[0]
    assert np.allclose(yarn_2[1], [0, 1, 0], atol=1e-5) and np.allclose(yarn_2[-1], [0, 1, 0], atol=1e-5)

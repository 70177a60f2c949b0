"""Programs: what GLSL declares is bound by its name; the last value is kept; the CPU reads through a copy."""

import re

import moderngl
import numpy as np
import pytest

from glcloth.errors import ShaderError
from glcloth.files import GLSL
from glcloth.gpu.buffers import Buffer, TextureBuffer
from glcloth.gpu.memo import Last, same
from glcloth.gpu.programs import Slot, number, programs, uniforms
from glcloth.gpu.screen import draw_screen
from glcloth.gpu.shader import flatten
from glcloth.gpu.tally import counting

ADD = """#version 430
layout(local_size_x = 64) in;
uniform samplerBuffer source;
layout(std430) writeonly buffer Target { float target[]; };
uniform mat2 turn; uniform int item_count;
uniform int unread;
uniform vec2 pair[2];
void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= item_count) return;
    target[i] = (turn * texelFetch(source, i).xy).x + pair[1].y;
}
"""


@pytest.fixture
def add(ctx, monkeypatch):
    """The program above, as if it were a file."""
    monkeypatch.setattr(
        "glcloth.gpu.programs.flatten", lambda path, defines, virtual: flatten(path, defines, {path: ADD})
    )
    return programs(ctx).compute("<add>")


def test_numbers_are_given_out_by_kind_and_name():
    slots: dict[str, Slot] = {}
    text = number(
        "uniform sampler2D a;\nlayout(binding = 9) uniform usamplerBuffer b;\nlayout(std430, binding = 7) readonly buffer "
        "C { int c[]; };\nlayout(rgba8) writeonly uniform image2D d;\n#if 0\nuniform sampler2D a;\n#endif\n",
        slots,
    )
    assert slots == {
        "a": Slot("texture", 0),
        "b": Slot("texture", 1),
        "C": Slot("block", 0, True, False),
        "d": Slot("image", 0, False, True),
    }
    assert text.count("layout(binding = 0) uniform sampler2D a;") == 2
    assert "layout(std430, binding = 0) readonly buffer C {" in text
    assert "layout(rgba8, binding = 0) writeonly uniform image2D d;" in text


def test_uniforms_are_read_with_their_types():
    text = "uniform vec4 a[3], b; // uniform int no\nuniform int c = 1;\n  uniform mat3 d;\nuniform sampler2D e;\n"
    assert uniforms(text) == {"a": "vec4", "b": "vec4", "c": "int", "d": "mat3"}


def test_every_resource_of_every_shader_is_found():
    """A declaration that `number` does not understand would be bound at random."""
    for path in sorted(p for p in GLSL.rglob("*") if p.is_file()):
        text = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
        slots: dict[str, Slot] = {}
        number(text, slots)
        declared = re.findall(r"\buniform\b[^;]*?[iu]?(?:sampler|image)\w+\s+(\w+)\s*;|\bbuffer\s+(\w+)", text)
        assert set(slots) == {a or b for a, b in declared}, path


def test_names_are_bound(ctx, add):
    source = TextureBuffer(ctx, np.float32([[1, 2, 0, 0], [3, 4, 0, 0], [5, 6, 0, 0]]))
    target = Buffer(ctx, np.full(3, -1, "f4"))
    turn = np.array([[0.0, 1.0], [1.0, 0.0]])
    pair = np.array([[0, 0], [0, 10]])
    add.run(3, {"item_count": 2, "somebody_elses": 1}, source=source, Target=target, turn=turn, pair=pair, unread=1)
    assert np.frombuffer(target.read(), "f4").tolist() == [12.0, 14.0, -1.0]
    with pytest.raises(ShaderError, match="declares no `sauce`"):
        add.run(3, sauce=source)
    source.release(), target.release()


def test_matrices_are_given_by_rows(ctx, add):
    source, target = TextureBuffer(ctx, np.float32([[1, 2, 0, 0]])), Buffer(ctx, 4)
    add.run(1, source=source, Target=target, turn=np.array([[1.0, 10.0], [0, 0]]), pair=np.zeros((2, 2)), item_count=1)
    assert np.frombuffer(target.read(), "f4")[0] == 21.0
    source.release(), target.release()


def test_groups_are_rounded_up_and_none_do_nothing(ctx, add):
    assert add.group_size == (64, 1, 1)
    source, target = TextureBuffer(ctx, np.ones((65, 4), "f4")), Buffer(ctx, bytes(4 * 65))
    values = {"turn": np.eye(2), "pair": np.zeros((2, 2)), "item_count": 65}
    add.run(0, values, source=source, Target=target)
    assert not np.frombuffer(target.read(), "f4").any()
    add.run(65, values, source=source, Target=target)
    assert np.frombuffer(target.read(), "f4").all()
    source.release(), target.release()


def test_more_groups_than_the_device_takes_need_a_pass_that_knows_of_rows(ctx, add, monkeypatch):
    source, target = TextureBuffer(ctx, np.ones((200, 4), "f4")), Buffer(ctx, bytes(4 * 200))
    values = {"turn": np.eye(2), "pair": np.zeros((2, 2)), "item_count": 200}
    monkeypatch.setattr(programs(ctx), "most_groups", 3)
    with pytest.raises(ShaderError, match="4 work groups, more than 3"):
        add.run(200, values, source=source, Target=target)
    text = ADD.replace("in;", 'in;\n#include "inputs/gpu/item.glsl"').replace("int(gl_GlobalInvocationID.x)", "item()")
    monkeypatch.setattr(
        "glcloth.gpu.programs.flatten", lambda path, defines, virtual: flatten(path, defines, {path: text})
    )
    programs(ctx).compute("<rows>").run(200, values, source=source, Target=target)
    assert np.frombuffer(target.read(), "f4").all()
    source.release(), target.release()


def test_a_program_is_compiled_once(ctx):
    one = programs(ctx).compute("passes/accel/lbvh_codes.comp")
    assert programs(ctx).compute("passes/accel/lbvh_codes.comp") is one
    assert programs(ctx).compute("passes/accel/lbvh_codes.comp", {"X": 1}) is not one


def test_reads_go_through_a_copy(ctx):
    data = np.arange(1000, dtype="f4")
    buffer = Buffer(ctx, data)
    with counting(ctx) as counted:
        assert buffer.read() == data.tobytes()
        assert buffer.read(8, offset=40) == data[10:12].tobytes()
    buffer.read()
    assert (counted.reads, counted.read_bytes) == (2, 4008)
    buffer.release()


def test_the_last_value_is_kept():
    made = []
    last = Last()
    array = np.zeros(2)

    def get(*key):
        return last.get(lambda: made.append(key) or len(made), *key)

    assert [get(array, 1), get(array, 1), get(array, 1.0), get(array.copy(), 1), get(array, (1, "a")), get(array, (1, "a"))] == [
        1, 1, 1, 2, 3, 3,
    ]  # fmt: skip
    last.forget()
    assert get(array, (1, "a")) == 4
    assert not same(array, array.copy()) and same((array, 2), (array, 2)) and not same((1,), (1, 2))


def test_a_value_that_could_not_be_made_is_asked_for_again():
    last = Last()

    def fail():
        raise ValueError

    with pytest.raises(ValueError):
        last.get(fail, 1)
    assert last.get(lambda: 5, 1) == 5


@pytest.mark.parametrize(("blend", "expected"), [("replace", 0.25), ("add", 0.75), ("behind", 0.5 + 0.5 * 0.25)])
def test_the_screen_is_filled(ctx, monkeypatch, blend, expected):
    text = "#version 430\nout vec4 color;\nuniform float value;\nvoid main() { color = vec4(value); }\n"
    monkeypatch.setattr(
        "glcloth.gpu.programs.flatten", lambda path, defines, virtual: flatten(path, defines, {"<fill>": text})
    )
    picture = ctx.texture((4, 4), 4, dtype="f4")
    target = ctx.framebuffer([picture])
    target.use()
    target.clear(0.5, 0.5, 0.5, 0.5)
    draw_screen(programs(ctx).screen("<fill>"), target, blend=blend, rows=(1, 2), value=0.25)
    data = np.frombuffer(picture.read(), "f4").reshape(4, 4, 4)
    assert np.allclose(data[1:3], expected) and np.allclose(data[[0, 3]], 0.5)
    ctx.detect_framebuffer(0).use()
    target.release(), picture.release()


def test_only_covered_pixels_are_shaded(ctx, monkeypatch):
    text = "#version 430\nout vec4 color;\nvoid main() { color = vec4(1); }\n"
    monkeypatch.setattr(
        "glcloth.gpu.programs.flatten", lambda path, defines, virtual: flatten(path, defines, {"<one>": text})
    )
    picture, depth = ctx.texture((2, 1), 4, dtype="f4"), ctx.depth_texture((2, 1), np.float32([0.5, 1.0]).tobytes())
    target = ctx.framebuffer([picture], depth)
    target.use()
    target.color_mask = True, True, True, True
    ctx.enable_only(moderngl.NOTHING)
    draw_screen(programs(ctx).screen("<one>"), target, depth="covered")
    assert np.frombuffer(picture.read(), "f4").reshape(2, 4)[:, 0].tolist() == [1.0, 0.0]
    ctx.detect_framebuffer(0).use()
    target.release(), picture.release(), depth.release()

"""`glcloth check`: the pictures are as they are kept, what differs is noticed and named, devices go by name."""

import json
import os

import numpy as np
import pytest

from glcloth import cli
from glcloth.bench import check
from glcloth.errors import DriverError, InputError
from glcloth.gpu import context
from glcloth.gpu.context import create_context


def test_this_driver_can_be_trusted(renderer):
    """Where a picture is meant to change, `python tests/measure/check_values.py` writes the new values."""
    verdicts = check.check(renderer)
    assert len(verdicts) == 10
    assert {name: v.fault for name, v in verdicts.items() if v.fault} == {}


def planted(picture):
    """Copies of a picture with one fault each, and a word of what is to be said of it."""
    brighter = picture * 1.006
    cell = picture.copy()
    cell[24:48, 48:72, 1] *= 1.025
    turned, hole = picture[::-1], picture.copy()
    hole[5, 7] = np.nan
    return [(brighter, "mean"), (cell, "column 3 of 4, row 2 of 3"), (turned, "off"), (hole, "1 pixels"),
            (picture[..., :1], "channels")]  # fmt: skip


def test_planted_faults_are_noticed():
    across, down = np.meshgrid(np.linspace(0.2, 1, 96), np.linspace(0.5, 1, 72))
    picture = np.stack([across, across * down, down], -1)
    kept = check.cell_means(picture)
    assert kept.shape == (3, 4, 3) and np.allclose(kept[0, 1], picture[:24, 24:48].mean((0, 1)))
    assert check.judge(picture * 1.004, kept).fault == ""
    for wrong, word in planted(picture):
        assert word in check.judge(wrong, kept).fault


@pytest.fixture
def one_picture(renderer, tmp_path, monkeypatch):
    """The command with one picture, on the session's renderer; `plant` writes its kept values."""
    kept = check.kept_values()["direct"]
    monkeypatch.setattr(check, "PICTURES", {"direct": check.PICTURES["direct"]})
    monkeypatch.setattr(check, "VALUES", tmp_path / "check.json")
    monkeypatch.setattr("glcloth.picture.renderer.create_context", lambda device: renderer.ctx)
    monkeypatch.setattr("glcloth.picture.renderer.Renderer.close", lambda self: None)

    def plant(factor):
        check.VALUES.write_text(json.dumps({"direct": (kept * factor).tolist()}))

    return plant


def ended(*arguments):
    """The exit code of a command."""
    try:
        cli.main(list(arguments))
    except SystemExit as stop:
        return stop.code
    return 0


def test_the_command_says_whether_and_which_picture_fails(one_picture, capsys):
    one_picture(1.0)
    assert ended("check") == 0
    assert "can be trusted; 1 pictures" in capsys.readouterr().out
    one_picture(1.02)
    assert ended("check", "--json") == 3
    out, err = capsys.readouterr()
    result = json.loads(out)
    assert not result["trusted"] and "mean" in result["pictures"]["direct"]["fault"]
    assert err.count("\n") == 1 and "not to be trusted, 1 of 1 pictures fail: direct: its mean is" in err


def test_what_a_driver_refuses_is_a_fault_of_the_picture(one_picture, renderer, monkeypatch):
    one_picture(1.0)

    def refuse(self, **changes):
        raise DriverError("method direct: OpenGL reports GL_INVALID_ENUM")

    monkeypatch.setattr(type(renderer), "render", refuse)
    assert "GL_INVALID_ENUM" in check.check(renderer)["direct"].fault


def test_devices_go_by_number_and_by_name(session_ctx):
    name = session_ctx.info["GL_RENDERER"]
    for device in (name, name[1:5].upper(), 0, "0"):
        ctx = create_context(device)
        assert ctx.info["GL_RENDERER"] == name
        ctx.release()
    session_ctx.__enter__()
    for device in ("no such thing", "", 99, -1):
        with pytest.raises(InputError) as error:
            create_context(device)
        assert f"0 {name}" in str(error.value)


def test_a_window_asks_for_its_device(session_ctx, monkeypatch):
    """What the display then does, the window compares with the name."""
    monkeypatch.setattr(os, "environ", dict(os.environ))
    os.environ.pop("LIBGL_ALWAYS_SOFTWARE", None)
    name = session_ctx.info["GL_RENDERER"]
    assert context.ask_display_for(name) == name
    assert (os.environ.get("LIBGL_ALWAYS_SOFTWARE") == "1") == context.is_software(session_ctx)
    monkeypatch.setattr(context, "list_devices", lambda: [context.Device(2, "NVIDIA H200/PCIe/SSE2", "4.6")])
    assert context.ask_display_for("nvidia") == context.ask_display_for(2) == "NVIDIA H200/PCIe/SSE2"
    assert os.environ["__GLX_VENDOR_LIBRARY_NAME"] == "nvidia"
    with pytest.raises(InputError, match="2 NVIDIA"):
        context.ask_display_for("llvmpipe")

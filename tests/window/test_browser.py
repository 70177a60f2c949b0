"""The view in a browser, by its requests: token, picture, edits, moves of the eye; and the view under a notebook's cell."""

import io
import json
import re
import threading
import urllib.error
import urllib.request

import numpy as np
import pytest
from PIL import Image

import glcloth
from glcloth.cli import main
from glcloth.color import view
from glcloth.errors import InputError, NoOpenGLError
from glcloth.fabric import load_fabric
from glcloth.scene import Scene
from glcloth.window import browser, live, show

SMALL = {"mesh": "sphere", "fabric": "linen", "size": (48, 36), "shadows": "off", "exposure": 0.5}


class Client:
    """A browser without a face."""

    def __init__(self, address):
        self.root, self.token = address.split("?token=")

    def get(self, path, token=None, data=None):
        """(status, body, headers)."""
        mark = "&" if "?" in path else "?"
        request = urllib.request.Request(f"{self.root}{path}{mark}token={self.token if token is None else token}", data)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, answer.read(), answer.headers
        except urllib.error.HTTPError as error:
            return error.code, error.read(), error.headers

    def post(self, path, **wish):
        code, body, _ = self.get(path, data=json.dumps(wish).encode())
        return code, json.loads(body)

    def complete(self, after=0):
        """(picture [H, W, 3], its number), once it is complete."""
        for _ in range(60):  # a second each at most, while something is drawn
            code, body, headers = self.get(f"picture?after={after}")
            about = json.loads(headers["X-About"])
            after = about["version"]
            if code == 200 and about["complete"]:
                return np.asarray(Image.open(io.BytesIO(body))).astype(float), after
        raise AssertionError(f"never complete: {about}")


def fields(state, group):
    (found,) = (g for g in state["groups"] if g["name"] == group)
    return {field["name"]: field for field in found["fields"]}


@pytest.fixture(scope="module")
def open_view():
    view = browser.LiveView(Scene(**SMALL))
    view.wait()
    yield view
    view.close()


@pytest.fixture
def client(open_view):
    return Client(open_view.address)


def test_only_who_has_the_token_is_let_in_and_only_from_here(client, open_view):
    assert open_view._server.server_address[0] == "127.0.0.1"
    for path in ("", "state", "picture", "fabric.toml", "elsewhere"):
        for token in ("", "x" * len(client.token), "é"):
            assert client.get(path, urllib.request.quote(token))[0] == 403
    assert client.get("edit", "", b"{}")[0] == 403
    code, page, headers = client.get("")
    assert code == 200 and "default-src 'self'" in headers["Content-Security-Policy"]
    assert not re.search(rb"https?://", page)
    assert client.get("../live.py")[0] == client.get("elsewhere")[0] == 404


def test_the_picture_is_that_of_render(client, renderer):
    picture, _ = client.complete()
    with renderer.ctx:
        light = renderer.render(**SMALL)
    assert np.abs(picture - 255 * view(np.asarray(light), "standard", 0.5)).mean() < 1.5
    state = json.loads(client.get("state")[1])
    assert fields(state, "warp")["gamma_s_deg"]["low"] == 0.5
    assert "area" in fields(state, "warp") and state["size"] == [48, 36]


def test_edits_change_the_picture_and_can_be_undone(client, open_view):
    before, version = client.complete()
    code, state = client.post("edit", group="warp", name="albedo", value=[0.4, 0.0, 0.0])
    assert code == 200 and state["undo"] and fields(state, "warp")["albedo"]["value"] == [0.4, 0.0, 0.0]
    red, version = client.complete(version)
    assert (red - before)[..., 0].mean() > 3 > (red - before)[..., 2].mean()
    file = client.get("fabric.toml")[1].decode()
    assert "0.4" in file and open_view.fabric.yarn[0].albedo == (0.4, 0.0, 0.0)
    assert client.post("undo")[0] == 200
    again, _ = client.complete(version)
    assert np.array_equal(again, before) and open_view.fabric == load_fabric("linen")


def test_the_eye_and_the_light_move(client, open_view):
    before, version = client.complete()
    assert client.post("look", how="zoom", x=0, y=4)[0] == 200
    near, version = client.complete(version)
    assert near.mean() != before.mean() and open_view.scene.camera.eye is not None
    assert client.post("look", how="turn", x=0.5, y=0)[0] == 200
    _, version = client.complete(version)
    assert open_view.scene.env_rotate == -90
    assert client.post("undo")[0] == 200
    turned_back, version = client.complete(version)
    assert np.array_equal(turned_back, near)
    assert client.post("look", how="home")[0] == 200
    home, _ = client.complete(version)
    assert np.array_equal(home, before)


def test_a_picture_is_told_to_be_complete_however_slow_the_machine_is(client, monkeypatch):
    """With one slice a step the last slice of all shows nothing new."""
    monkeypatch.setattr(live, "BUDGET", 0.0)
    _, version = client.complete()
    for exposure in (0.25, 0.5):
        client.post("edit", group="warp", name="gamma_s_deg", value=10 + exposure)
        _, version = client.complete(version)
    assert client.post("reset")[0] == 200


@pytest.mark.parametrize(
    ("path", "wish", "said"),
    [
        ("edit", {"group": "warp", "name": "gamma_s_deg", "value": 400}, "gamma_s_deg = 400"),
        ("edit", {"group": "warp", "name": "gamma_s_deg", "value": "wide"}, "gamma_s_deg"),
        ("edit", {"group": "scene", "name": "mesh", "value": "/etc/passwd"}, "no such field"),
        ("edit", {"group": "scene", "name": "env", "value": "/etc/passwd"}, "expected studio or sky"),
        ("edit", {"group": "weave", "name": "draft", "value": "/etc/passwd"}, "no such field"),
        ("edit", {"group": "warp"}, "missing"),
        ("choose", {"fabric": "/etc/passwd"}, "built-in"),
        ("look", {"how": "orbit", "x": "far", "y": 0}, "another kind"),
        ("look", {"how": "orbit", "x": float("nan"), "y": 0}, "another kind"),
    ],
)
def test_wrong_wishes_are_one_line_and_change_nothing(client, open_view, path, wish, said):
    scene = open_view.scene
    code, answer = client.post(path, **wish)
    assert code == 400 and said in answer["error"] and "\n" not in answer["error"]
    assert open_view.scene == scene


def test_bodies_that_are_no_wishes(client):
    assert client.get("edit", data=b"[" * 5000)[0] == client.get("edit", data=b"[]")[0] == 400
    assert client.get("edit", data=b" " * (browser.MOST + 1))[0] == 413


def test_show_is_live_in_a_notebook(monkeypatch):
    shown = []
    monkeypatch.setattr(show, "_notebook", lambda: shown.append)
    monkeypatch.setattr(show, "_frame", lambda address, height: (address, height))
    view = glcloth.show(**SMALL)
    try:
        assert shown == [(view.address, 460)]
        assert view.scene.mesh == "sphere" and Client(view.address).complete()[0].shape == (36, 48, 3)
    finally:
        view.close()
    with pytest.raises(InputError, match="closed"):
        _ = view.scene
    with pytest.raises(InputError, match="no such file"):
        glcloth.show(mesh="absent.obj")


def test_a_view_that_ends_says_why(monkeypatch, capsys):
    """At once without OpenGL, and later by whatever goes wrong in its thread."""

    def broken(*_):
        raise NoOpenGLError("no OpenGL\nhere")

    with monkeypatch.context() as patch:
        patch.setattr(live, "create_context", broken)
        view = browser.LiveView(Scene(**SMALL))
        with pytest.raises(NoOpenGLError, match="here"):
            view.wait()
    code, answer, _ = Client(view.address).get("picture")
    assert code == 410 and json.loads(answer)["error"] == "no OpenGL here"
    view.close()
    assert not capsys.readouterr().err

    def step(self):  # a picture, and then a fault
        if self._shown.version:
            raise ZeroDivisionError("a fault")
        self._shown = live.Shown(1, b"", False, "")

    monkeypatch.setattr(live.Live, "_step", step)
    view = browser.LiveView(Scene(**SMALL))
    view._thread.join(30)
    code, answer, _ = Client(view.address).get("picture")
    assert code == 410 and json.loads(answer)["error"] == "a fault"
    assert "the view has ended: a fault" in capsys.readouterr().err
    with pytest.raises(InputError, match="a fault"):
        _ = view.scene
    view.close()


def test_the_first_fabric_can_be_chosen_again():
    for first in (load_fabric("linen").changed(sigma_deg=17.0), load_fabric("linen").changed(name="velvet"), "linen"):
        view = live.Live(Scene(**SMALL | {"fabric": first}))
        name = view.state()["fabric"]
        view.choose("velvet")
        assert view.state()["fabric"] == "velvet" and view.session.fabric == load_fabric("velvet")
        view.choose(name)
        assert view.session.scene.fabric == first and name in view.state()["fabrics"]


def test_the_command_says_what_is_wrong(capsys):
    with pytest.raises(InputError, match="free one"):
        browser.Server(browser.Live(Scene(**SMALL)), 70000)
    taken = browser.Server(browser.Live(Scene(**SMALL)))
    threading.Thread(target=taken.serve_forever, daemon=True).start()
    for words, said in (
        (["--http", str(taken.server_port)], "another port"),
        (["curtain", "--http", "0"], "glcloth animate curtain"),
        (["--host", "0.0.0.0"], "give --http PORT too"),
        (["--http", "0", "--watch"], "belongs to the window"),
        (["--http", "0", "--device", "77"], "--device 77"),
    ):
        with pytest.raises(SystemExit) as stop:
            main(["view", *words])
        assert stop.value.code == 2 and said in capsys.readouterr().err
    taken.shutdown()
    taken.server_close()

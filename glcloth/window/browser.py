"""The window's picture and sliders in a browser: a small HTTP server, on this machine alone unless told otherwise.

Every request needs the token, which is a part of the address that is printed.
"""

from __future__ import annotations

import hmac
import json
import secrets
import tempfile
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ..errors import InputError
from ..fabric import save_fabric
from ..progress import say, warn
from ..scene import Scene
from .live import Live

PAGE = Path(__file__).with_name("browser.html")
LOOPBACK = "127.0.0.1"
MOST = 1 << 16  # bytes of a request's body
POLICY = "default-src 'self'; img-src 'self' blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


class Server(ThreadingHTTPServer):
    """Serves one Live. `address` has the token in it.

    Parameters
    ----------
    port : 0 takes a free one
    host : the address that it listens on

    Raises InputError where it cannot listen.
    """

    daemon_threads = True

    def __init__(self, live: Live, port: int = 0, host: str = LOOPBACK):
        if not 0 <= port <= 65535:
            raise InputError(f"--http {port}: expected a port from 0 to 65535; 0 takes a free one")
        self.live, self.token = live, secrets.token_urlsafe(16)
        try:
            super().__init__((host, port), Handler)
        except OSError as error:
            raise InputError(
                f"--http {port}: cannot listen on {host} ({error.strerror}); take another port, or 0 for a free one"
            ) from None

    @property
    def address(self) -> str:
        """What to open in a browser."""
        host, port = self.server_address[:2]
        return f"http://{host}:{port}/?token={self.token}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that went away is no error."""


class Handler(BaseHTTPRequestHandler):
    """Answers one browser."""

    server: Server
    protocol_version = "HTTP/1.1"
    timeout = 60

    def do_GET(self) -> None:
        """The page, its state, a picture newer than `after`, and the fabric as a file."""
        path, query = self._asked()
        live = self.server.live
        if path is None:
            return
        if path == "/":
            self._answer(200, PAGE.read_bytes(), "text/html; charset=utf-8")
        elif path == "/state":
            self._do(live.state)
        elif path == "/picture":
            said = query.get("after", ["0"])[0][:15]
            after = int(said) if said.isascii() and said.isdigit() else 0
            shown = live.picture(after)
            if live.closed:
                self._refuse(410, live.ending)
                return
            about = {"version": shown.version, "status": live.status, "complete": shown.complete}
            more = {"X-About": json.dumps(about | {"message": shown.message})}
            new = shown.version > after
            self._answer(200 if new else 204, shown.jpeg if new else b"", "image/jpeg", more)
        elif path == "/fabric.toml":
            try:
                with tempfile.TemporaryDirectory() as folder:
                    file = Path(folder) / "fabric.toml"
                    save_fabric(file, live.ask(lambda: live.session.fabric))
                    data = file.read_bytes()
            except InputError as error:
                self._refuse(400, str(error))
                return
            self._answer(200, data, "application/toml", {"Content-Disposition": 'attachment; filename="fabric.toml"'})
        else:
            self._refuse(404, f"{path}: no such page")

    def do_POST(self) -> None:
        """An edit, or a move of the eye; the answer is the new state."""
        path, _ = self._asked()
        if path is None:
            return
        live, session, wish = self.server.live, self.server.live.session, self._body()
        if wish is None:
            return
        try:
            if path == "/edit":
                do = lambda: live.edit(str(wish["group"]), str(wish["name"]), wish["value"])  # noqa: E731
            elif path == "/look":
                x, y = float(wish.get("x", 0)), float(wish.get("y", 0))
                if not abs(x) + abs(y) < 100:
                    raise ValueError
                do = lambda: live.look(str(wish["how"]), x, y)  # noqa: E731
            elif path == "/choose":
                do = lambda: live.choose(str(wish["fabric"]))  # noqa: E731
            elif path in ("/undo", "/redo", "/reset", "/end"):
                do = {
                    "/undo": session.undo,
                    "/redo": session.redo,
                    "/reset": session.reset_fabric,
                    "/end": session.end_gesture,
                }[path]  # type: ignore[assignment]
            else:
                self._refuse(404, f"{path}: no such page")
                return
            live.ask(do)
        except InputError as error:
            self._refuse(400, str(error))
        except (KeyError, TypeError, ValueError):
            self._refuse(400, f"{path}: a field is missing, or of another kind")
        else:
            self._do(live.state) if path != "/look" else self._answer(200, b"{}", "application/json")

    def log_message(self, *_: Any) -> None:
        """Requests are not printed."""

    # -- parts -------------------------------------------------------------------------------------------------------

    def _asked(self) -> tuple[str | None, dict[str, list[str]]]:
        """Path and query of a request that may be answered; None where it was refused."""
        parts = urlsplit(self.path)
        query = parse_qs(parts.query)
        token = query.get("token", [self.headers.get("X-Token", "")])[0]
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.close_connection = True
            self._refuse(403, "the token is missing or wrong; open the whole address that glcloth printed")
            return None, query
        return parts.path, query

    def _body(self) -> dict | None:
        """The JSON object of a request; None where it was refused."""
        length = self.headers.get("Content-Length", "0")
        if not length.isdigit() or int(length) > MOST:
            self.close_connection = True
            self._refuse(413, "the request is too long")
            return None
        try:
            found = json.loads(self.rfile.read(int(length)) or b"{}")
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, dict):
            self._refuse(400, "expected a JSON object")
            return None
        return found

    def _do(self, wish: Any) -> None:
        try:
            data = json.dumps(self.server.live.ask(wish))
        except InputError as error:
            self._refuse(400, str(error))
        else:
            self._answer(200, data.encode(), "application/json")

    def _refuse(self, code: int, message: str) -> None:
        self._answer(code, json.dumps({"error": message}).encode(), "application/json")

    def _answer(self, code: int, data: bytes, kind: str, more: dict[str, str] | None = None) -> None:
        self.send_response(code)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Content-Security-Policy", POLICY)
        for name, value in (more or {}).items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(data)


def serve(scene: Scene, port: int, host: str = LOOPBACK, device: int | str | None = None) -> None:
    """Show a scene in browsers until Ctrl-C; the address is printed.

    Raises InputError for a curtain, a scene that cannot be shown and a port that is taken, and NoOpenGLError.
    """
    live = Live(scene, device)
    server = Server(live, port, host)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    if host not in (LOOPBACK, "localhost"):
        say(
            f"glcloth: warning: who has the address can use this view from other machines; it is not encrypted ({host})"
        )
    say(f"open {server.address}   (Ctrl-C ends it)")
    try:
        live.run()
    finally:
        live.close()
        server.shutdown()
        server.server_close()


class LiveView:
    """A live picture that `glcloth.show` opened in a notebook. `close` ends it; so does the end of the kernel."""

    def __init__(self, scene: Scene, port: int = 0):
        self._live = Live(scene)
        self._server = Server(self._live, port)
        self._error: BaseException | None = None
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        self._thread = threading.Thread(target=self._draw, daemon=True)
        self._thread.start()

    def _draw(self) -> None:
        try:
            self._live.run()
        except Exception as error:  # nobody else hears of it in this thread
            self._error = error
            if self._live.picture(0, 0.0).version:
                warn(f"the view has ended: {self._live.fault}")

    @property
    def address(self) -> str:
        """What to open in a browser."""
        return self._server.address

    @property
    def scene(self) -> Scene:
        """The scene as it is now, edits included. Raises InputError once closed."""
        return self._live.ask(lambda: self._live.session.scene)

    @property
    def fabric(self):
        """The fabric as it is now, edits included. Raises InputError once closed."""
        return self._live.ask(lambda: self._live.session.fabric)

    def wait(self, seconds: float = 60.0) -> None:
        """Until there is a picture. Raises what the drawing raised."""
        self._live.picture(0, seconds)
        if self._live.closed:
            self._thread.join(10)
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        """End the drawing and the server."""
        self._live.close()
        self._thread.join(10)
        self._server.shutdown()
        self._server.server_close()

    def __repr__(self) -> str:
        return f"<LiveView {self.address}>"

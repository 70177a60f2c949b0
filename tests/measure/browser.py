"""The view in a real browser: Chromium, driven through chromedriver; pictures of the page at two widths, and times.

python tests/measure/browser.py [out/browser]   (Debian: apt-get install chromium chromium-driver)
"""

import base64
import contextlib
import json
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

from glcloth.scene import Scene
from glcloth.window.browser import LiveView

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
COMPLETE = "return document.body.dataset.complete === 'true'"
SLIDER = """
const [group, name] = arguments
const part = [...document.querySelectorAll('details')].find(d => d.querySelector('summary').textContent === group)
part.open = true
const slider = [...part.querySelectorAll('label')].find(l => l.textContent === name).querySelector('input')
slider.value = slider.max
document.body.dataset.complete = false
slider.dispatchEvent(new Event('input')); slider.dispatchEvent(new Event('change', {bubbles: true}))
"""


class Browser:
    """Speaks WebDriver with Chromium."""

    def __init__(self, port=9515):
        self.process = subprocess.Popen(["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL)
        self.root = f"http://127.0.0.1:{port}/session"
        wanted = {"capabilities": {"alwaysMatch": {"goog:chromeOptions": {"args": FLAGS}}}}
        for _ in range(50):
            try:
                self.root += "/" + self("", wanted)["sessionId"]
                return
            except OSError:
                time.sleep(0.2)
        raise SystemExit("chromedriver does not answer")

    def __call__(self, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.root + path, data, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.loads(answer.read())["value"]

    def run(self, script, *arguments):
        return self("/execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, script, seconds=300):
        begin = time.perf_counter()
        while not self.run(script):
            assert time.perf_counter() - begin < seconds, script
            time.sleep(0.1)
        return time.perf_counter() - begin

    def shot(self, path):
        path.write_bytes(base64.b64decode(self("/screenshot")))

    def drag(self, x, y, dx, dy):
        moves = [{"type": "pointerMove", "duration": 0, "x": x, "y": y}, {"type": "pointerDown", "button": 0}]
        moves += [
            {"type": "pointerMove", "duration": 100, "x": x + dx * k // 4, "y": y + dy * k // 4} for k in range(1, 5)
        ]
        moves.append({"type": "pointerUp", "button": 0})
        self("/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": moves}]})

    def close(self):
        """End Chromium with its session, and the driver."""
        with contextlib.suppress(OSError):
            urllib.request.urlopen(urllib.request.Request(self.root, method="DELETE"), timeout=30).read()
        self.process.terminate()
        self.process.wait(10)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    live, browser = LiveView(Scene(fabric="denim_raw", size=(640, 480))), Browser()
    try:
        browser("/window/rect", {"width": 1200, "height": 800})
        browser("/url", {"url": live.address})
        browser.wait("return document.getElementById('picture').naturalWidth > 0")
        print(f"first picture {time.perf_counter() - begin:.1f} s after the start")
        browser.wait(COMPLETE)
        print(f"complete {time.perf_counter() - begin:.1f} s after the start")
        browser.shot(folder / "wide.png")
        eye = live.scene.camera.eye
        browser.run("document.body.dataset.complete = false")
        browser.drag(400, 400, 160, 40)
        browser.wait(COMPLETE)
        assert live.scene.camera.eye != eye
        browser.shot(folder / "turned.png")
        browser.run(SLIDER, "warp", "gamma_s")
        print(f"a slider's picture complete after {browser.wait(COMPLETE):.1f} s")
        assert live.fabric.yarn[0].gamma_s_deg == 60
        browser.shot(folder / "slider.png")
        browser("/window/rect", {"width": 500, "height": 1000})
        time.sleep(0.5)
        browser.shot(folder / "narrow.png")
    finally:
        browser.close()
        live.close()
    print(folder)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/browser"))

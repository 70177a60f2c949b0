"""The installed product: a wheel in a clean environment finds its shaders and fabrics and renders from any folder."""

import os
import subprocess
import sys
import venv
from pathlib import Path

from glcloth.image import read_image

ROOT = Path(__file__).resolve().parents[2]


def test_the_wheel_renders_from_any_folder(tmp_path):
    """Only glcloth itself is installed afresh; its dependencies come from this environment by a .pth file.

    That keeps the test quick and off the network, and still catches every file that the wheel lacks.
    """
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path / "dist")]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    venv.create(tmp_path / "clean", with_pip=True)
    python = tmp_path / "clean/bin/python"
    install = [python, "-m", "pip", "install", "-q", "--no-deps", "--no-index", str(wheel)]
    subprocess.run(install, check=True, capture_output=True)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    site = tmp_path / "clean/lib" / version / "site-packages"
    ours = next(p for p in sys.path if p.endswith("site-packages"))
    # addsitedir would also run this environment's .pth files, among them the one of the editable checkout.
    (site / "dependencies.pth").write_text(ours + "\n")
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    where = subprocess.run(
        [python, "-c", "import glcloth; print(glcloth.__file__)"],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert str(tmp_path / "clean") in where.stdout
    command = [tmp_path / "clean/bin/glcloth", "render", "-o", "a.exr", "--mesh", "sphere", "--size", "48x36"]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    picture = read_image(folder / "a.exr")
    assert picture.shape == (36, 48, 3) and picture.max() > 0.05

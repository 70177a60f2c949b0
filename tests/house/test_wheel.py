"""The product: a wheel in a clean environment finds its shaders and fabrics and renders from any folder; its papers."""

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

from glcloth.image import read_image
from glcloth.light.fit import SHIPPED

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """(wheel, sdist) of this tree."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", folder], cwd=ROOT, check=True, capture_output=True
    )
    return next(folder.glob("*.whl")), next(folder.glob("*.tar.gz"))


def test_an_index_would_take_the_packages(packages, tmp_path):
    """twine finds no fault; the licence and the mark of types are inside; the sdist makes the same wheel."""
    wheel, sdist = packages
    done = subprocess.run(
        [sys.executable, "-m", "twine", "check", "--strict", *packages], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout
    inside = zipfile.ZipFile(wheel).namelist()
    assert "glcloth/py.typed" in inside and any(name.endswith("licenses/LICENSE") for name in inside)
    fits = {f"glcloth/light/fits/{path.name}" for path in SHIPPED.iterdir()}
    assert fits and fits <= set(inside)
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (tree,) = tmp_path.iterdir()
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", tmp_path / "again"]
    subprocess.run(build, cwd=tree, check=True, capture_output=True)
    assert zipfile.ZipFile(tmp_path / "again" / wheel.name).namelist() == inside


def test_papers_agree_with_the_project():
    """Version and licence in CITATION.cff and the conda recipe; the recipe has every dependency, with its bound."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert (ROOT / "LICENSE").read_text().split()[:4] == ["Apache", "License", "Version", "2.0,"]
    for name in ("CITATION.cff", "docs/conda/recipe.yaml"):
        text = (ROOT / name).read_text()
        assert re.search(rf'\bversion: "?{re.escape(project["version"])}"?\n', text), name
        assert f"license: {project['license']}\n" in text, name
    names = {"openexr": "openexr-python", "openimageio": "py-openimageio", "glfw": "pyglfw"}
    needed = {re.sub(r"^[\w-]+", lambda m: names.get(m[0].lower(), m[0].lower()), d) for d in project["dependencies"]}
    run = (ROOT / "docs/conda/recipe.yaml").read_text().split("  run:\n")[1].split("\n\n")[0]
    assert {line.strip("- ").replace(" ", "") for line in run.splitlines()} == needed | {"python>=3.11"}


def test_the_wheel_renders_from_any_folder(packages, tmp_path):
    """Only glcloth itself is installed afresh; its dependencies come from this environment by a .pth file.

    That keeps the test quick and off the network, and still catches every file that the wheel lacks.
    """
    wheel, _ = packages
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

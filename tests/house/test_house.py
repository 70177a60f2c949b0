"""The house rules, as tests: who may import whom, what a GLSL library may contain, that twins pair up and cite."""

import ast
import importlib
import inspect
import re
import tomllib
from pathlib import Path

import pytest
import twin

ROOT = Path(__file__).resolve().parents[2]
PACKAGE, SHADERS = ROOT / "glcloth", ROOT / "glsl"
LIBRARIES = ("core", "fibre", "sg", "direct", "woven", "trace", "simulate")
# Files of glsl/trace that declare storage buffers, because GLSL cannot pass a buffer as an argument.
BUFFERED = ("trace/accel", "trace/scene")


def rows():
    """{module: row} as ARCHITECTURE.md's table says; a folder stands for all its files."""
    table = {}
    for line in (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").splitlines():
        if match := re.match(r"\|\s*(\d+)[^|]*\|([^|]*)\|", line):
            for name in re.findall(r"`([a-z_]+)/?`", match[2]):
                table[name] = int(match[1])
    return table


ROWS = rows()
MODULES = sorted(p for p in PACKAGE.rglob("*.py") if "_data" not in p.parts)


def module_name(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path):
    """Top-level names inside glcloth that a file imports, at module level and inside functions."""
    depth = len(path.relative_to(PACKAGE).parts) - 1
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom):
            continue
        if node.level == 0 and (node.module or "").split(".")[0] == "glcloth":
            module = (node.module or "").split(".")[1:]
        elif node.level == depth + 1:
            module = (node.module or "").split(".") if node.module else []
        else:
            continue
        yield from [module[0]] if module else [a.name for a in node.names]


@pytest.mark.parametrize("path", MODULES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_imports_point_down(path):
    name = module_name(path)
    if name == "__init__":
        return
    assert name in ROWS, f"{name} has no row in ARCHITECTURE.md"
    for other in imports(path):
        if other in ROWS and other != name:
            assert ROWS[other] < ROWS[name], f"{name} (row {ROWS[name]}) imports {other} (row {ROWS[other]})"


def neighbours(path):
    """Names of the files of its own folder that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            yield from [node.module.split(".")[0]] if node.module else [alias.name for alias in node.names]


@pytest.mark.parametrize("room", sorted({p.parent for p in MODULES}), ids=lambda p: p.name)
def test_no_circle_of_imports_in_a_room(room):
    imported = {p.stem: set(neighbours(p)) for p in room.glob("*.py") if p.stem != "__init__"}
    while free := [name for name, others in imported.items() if not others & imported.keys()]:
        for name in free:
            del imported[name]
    assert not imported, f"these import each other, or what does: {imported}"


def test_nothing_imports_the_window_itself():
    """App composes; whoever needs something of it is to be handed that."""
    for path in MODULES:
        if path.relative_to(PACKAGE).as_posix() == "window/__init__.py":
            continue
        assert path.parent.name != "window" or "app" not in set(neighbours(path)), path
        assert not re.search(r"window(\.app\b| import .*\bapp\b)", path.read_text(encoding="utf-8")), path


@pytest.mark.parametrize("path", sorted((PACKAGE / "twins").glob("*.py")), ids=lambda p: p.stem)
def test_twins_import_only_numpy(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert all(a.name in ("numpy", "math") for a in node.names)
        if isinstance(node, ast.ImportFrom):
            assert node.level == 1 or node.module in ("__future__", "math", "numpy"), node.module


def library_files():
    return [p for folder in LIBRARIES for p in sorted((SHADERS / folder).rglob("*.glsl"))]


def is_pure(path):
    return not path.relative_to(SHADERS).as_posix().startswith(BUFFERED)


@pytest.mark.parametrize(
    "path", [p for p in library_files() if is_pure(p)], ids=lambda p: p.relative_to(SHADERS).as_posix()
)
def test_library_glsl_is_pure(path):
    code = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
    bad = re.search(r"\b(uniform|buffer|layout|main|sampler\w*|image\w*D|gl_\w+)\b|#version|#if|#ifdef", code)
    assert not bad, f"{path.name}: `{bad[0]}` belongs in glsl/inputs or glsl/passes"


@pytest.mark.parametrize(
    "path", [p for p in library_files() if is_pure(p)], ids=lambda p: p.relative_to(SHADERS).as_posix()
)
def test_every_function_has_a_twin_and_a_source(path):
    found = twin.functions(path.relative_to(SHADERS))
    if not found:
        return
    python = importlib.import_module(f"glcloth.twins.{path.stem}")
    text = path.read_text(encoding="utf-8")
    for name, (_, parameters) in found.items():
        assert hasattr(python, name), f"twins/{path.stem}.py has no {name}"
        assert list(inspect.signature(getattr(python, name)).parameters) == [p for _, p in parameters], name
        above = re.split(rf"^\w+\s+{name}\s*\(", text, flags=re.M)[0].rsplit("\n}", 1)[-1]
        assert re.search(r"\[(Miz|Mat|own|[A-Z]\w+ (et al\. )?\d{4})", above), f"{path.name}: {name} cites no source"


def test_include_arrows_point_down():
    order = {
        "core": 0,
        "fibre": 1,
        "woven": 1,
        "simulate": 1,
        "sg": 2,
        "direct": 2,
        "trace": 2,
        "inputs": 3,
        "passes": 4,
    }
    apart = {("sg", "direct"), ("direct", "sg"), ("fibre", "woven"), ("woven", "fibre")}
    for path in SHADERS.rglob("*"):
        if path.is_dir():
            continue
        folder = path.relative_to(SHADERS).parts[0]
        for other in re.findall(r'^#include "(\w+)/', path.read_text(encoding="utf-8"), re.M):
            assert order[other] <= order[folder] and (folder, other) not in apart, f"{path.name} includes {other}/"


def test_only_one_glsl_version():
    for path in SHADERS.rglob("*"):
        if path.suffix in (".vert", ".frag", ".comp"):
            assert path.read_text(encoding="utf-8").startswith("#version 430\n"), path
        elif path.suffix == ".glsl":
            assert "#version" not in path.read_text(encoding="utf-8"), path


def test_only_their_owners_touch_contexts_and_windows():
    for path in MODULES:
        text = path.read_text(encoding="utf-8")
        if path.stem != "context" and module_name(path) != "window":
            assert "create_standalone_context" not in text and "moderngl.create_context" not in text, path
        if module_name(path) != "window":
            assert not re.search(r"^\s*(import|from) (glfw|imgui)", text, re.M), path


def test_documents_name_files_that_exist():
    for document in ("README.md", "ARCHITECTURE.md", "SYMBOLS.md", "docs/recipes.md"):
        text = (ROOT / document).read_text(encoding="utf-8")
        for name in re.findall(r"`((?:glcloth|glsl|tests|tables|examples|docs)/[\w/.\-]+\.\w+)`", text):
            assert (ROOT / name).exists(), f"{document} names {name}"
        for name in re.findall(r"\]\(((?!http)[\w/.\-]+)\)", text):
            assert (ROOT / document).parent.joinpath(name).exists(), f"{document} links {name}"


def test_symbols_lists_the_parameters_of_the_library():
    """Every parameter name of a pure GLSL function of the cloth model stands in SYMBOLS.md."""
    text = (ROOT / "SYMBOLS.md").read_text(encoding="utf-8")
    known = set(re.findall(r"`(\w+)`", text))
    for path in library_files():
        if path.parent.name in ("fibre", "sg", "direct", "woven"):
            for name, (_, parameters) in twin.functions(path.relative_to(SHADERS)).items():
                for _, parameter in parameters:
                    assert parameter in known, f"SYMBOLS.md lacks `{parameter}` ({path.name}: {name})"


def test_dependencies_are_imported():
    """No dependency that nothing uses."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    text = "\n".join(p.read_text(encoding="utf-8") for p in MODULES)
    modules = {"pillow": "PIL", "pyopengl": "OpenGL", "flip-evaluator": "flip_evaluator", "tomli-w": "tomli_w"}
    modules |= {"imgui-bundle": "imgui_bundle", "mapbox-earcut": "mapbox_earcut"}
    for dependency in project["dependencies"]:
        name = re.match(r"[\w\-]+", dependency)[0]
        module = modules.get(name.lower(), name)
        assert re.search(rf"^\s*(import|from) {module}\b", text, re.M), f"{name} is never imported"


def test_no_binding_number_stands_anywhere():
    """Names are bound (glcloth/gpu/programs.py); numbers are given out there."""
    for path in SHADERS.rglob("*"):
        if path.is_file():
            assert not re.search(r"\bbinding\s*=", path.read_text(encoding="utf-8")), path
    for path in MODULES:
        text = path.read_text(encoding="utf-8")
        if path.relative_to(PACKAGE).parts[0] != "gpu":
            assert not re.search(r"bind_to_storage_buffer|bind_to_image|\.use\(\d|location=\d", text), path


def test_the_cpu_reads_buffers_through_a_copy():
    """A buffer that the CPU reads itself moves into the CPU's memory on NVIDIA (glcloth/gpu/buffers.py)."""
    for path in MODULES:
        if path.relative_to(PACKAGE).as_posix() != "gpu/buffers.py":
            assert not re.search(r"\.buffer\.read\(|ctx\.buffer\(", path.read_text(encoding="utf-8")), path


def test_one_function_prints():
    """`say` and `show` make lines printable; else only results as JSON are printed."""
    for path in MODULES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            called = ast.unparse(node.func) if isinstance(node, ast.Call) else ""
            if called in ("print", "sys.stderr.write", "sys.stdout.write"):
                said = ast.unparse(node.args[0])
                assert path.name == "progress.py" or said.startswith(("dumps(", "json.dumps(")), f"{path}: {said}"

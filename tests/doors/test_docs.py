"""What the documents print runs: every command in a small form, every code block, with files that the text makes."""

import contextlib
import re
import sys
import tomllib
from pathlib import Path

import documents
import pytest

import glcloth
from glcloth import cli
from glcloth.cli.samples import POSES
from glcloth.fabric import Fabric
from glcloth.geometry.mesh_files import load_mesh, save_mesh
from glcloth.picture.sequence_files import frame_name
from glcloth.scene import Scene

MAKEFILE = (documents.ROOT / "Makefile").read_text(encoding="utf-8")
# Named, and run by tests/measure/docs.py.
OTHER_PROGRAMS = {"pip", "apt-get", "dask", "openjd", "rattler-build", ".venv/bin/pip"}
FILE = re.compile(r"\w\.(toml|wif|glb|ply|obj|exr|hdr|png|json|mp4)$")
NAMES = [path.name for path in documents.DOCUMENTS]


def parsed(words):
    """What the command line makes of a command; raises for unknown options and missing arguments."""
    return cli.app.parse_args(cli._with_heights(words[1:]), exit_on_error=False, print_error=False)


def known(words, where):
    """Assert that a command names a program, script or target that is there."""
    if words[0] == "make":
        assert re.search(rf"^{words[1]}:", MAKEFILE, re.M), f"{where}: no target {words[1]}"
    elif words[0] == "python" and words[1].endswith(".py"):
        assert (documents.ROOT / words[1]).is_file(), f"{where}: no {words[1]}"
    elif words[0] not in ("python", "glcloth"):
        assert words[0] in OTHER_PROGRAMS, f"{where}: what is {words[0]}?"


@pytest.fixture
def one_renderer(renderer):
    """Whoever makes a Renderer gets the session's; modules that are first imported meanwhile get the class again after it."""
    from glcloth.picture.renderer import Renderer

    def stands_in(*_, **__):
        return contextlib.nullcontext(renderer)

    def put(one, other):
        for name, module in list(sys.modules.items()):
            if name.split(".")[0] == "glcloth" and vars(module).get("Renderer") is one:
                module.Renderer = other

    glcloth.Renderer = Renderer  # which is found at its first use
    put(Renderer, stands_in)
    yield renderer
    put(stands_in, Renderer)


@pytest.mark.parametrize("document", documents.DOCUMENTS, ids=NAMES)
def test_commands_and_code_run(document, tmp_path, monkeypatch, one_renderer):
    """In the order of the text and in one folder, so that a file that nothing makes is missing here as well."""
    monkeypatch.chdir(tmp_path)
    renderer = one_renderer
    for block in documents.blocks(document):
        where = f"{document.name}:{block.line}"
        if block.language == "sh":
            for words in documents.commands(block.text):
                known(words, where)
                if words[0] == "glcloth":
                    with renderer.ctx:  # a command may have made one of its own
                        run_cheaply(words, where)
        elif block.language == "python":
            code = re.sub(r"size=\(\d+, \d+\)", 'size=(32, 24), shadows="off"', block.text)
            with renderer.ctx:
                exec(compile(code, where, "exec"), {})
        elif block.language == "toml":
            table = tomllib.loads(block.text)
            (Fabric if "yarn" in table else Scene).parse(table, where)
        else:
            assert block.language == "text", f"{where}: a block needs its language: sh, python, toml or text"
    renderer.follow_poses(False)


def run_cheaply(words, where):
    parsed(words)
    command = documents.cheap(words)
    if command is None:
        made = [word for word in words[2:] if FILE.search(word) and not word.startswith("-")]
        for name in made:
            output = words[words.index(name) - 1] in ("-o", "--output", "--openjd", "--picture")
            assert output or (documents.ROOT / name).exists() or Path(name).exists(), f"{where}: {name} is not there"
        return
    if words[1] == "samples":  # to let the cloth hang before the wind takes 5 s: two poses stand in, and are kept
        for number in range(2):
            pose = frame_name(POSES, number)
            pose.parent.mkdir(exist_ok=True)
            save_mesh(pose, load_mesh("plane"))
    try:
        cli.main(command[1:])
    except SystemExit as stop:
        assert not stop.code, f"{where}: {' '.join(command)}: exit {stop.code}"


@pytest.mark.parametrize("document", documents.DOCUMENTS, ids=NAMES)
def test_commands_in_sentences_have_real_options(document):
    for words in documents.spans(document):
        where = f"{document.name}: {' '.join(words)}"
        known(words, where)
        if words[0] != "glcloth" or words[1].startswith("-") or words[1].isupper():
            continue
        command = cli.app[words[1]]
        command = command[words[2]] if words[1] == "bench" else command
        names = {name for argument in command.assemble_argument_collection() for name in argument.names}
        for option in (word.strip("[]").split("=")[0] for word in words[2:]):
            assert not option.startswith("--") or option in names | {"--help"}, f"{where}: {option}"

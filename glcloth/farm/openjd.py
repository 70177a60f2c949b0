"""Open Job Description templates (2023-09): a render farm runs `glcloth` for each picture, as a task.

The farm's machines need glcloth and what the scene reads. A task that fails or is lost is run again by the farm; pictures
are written whole or not at all.
"""

from __future__ import annotations

import json
import os
import shlex
from pathlib import Path
from typing import Any

from ..errors import InputError, printable
from ..files import atomic_write, is_file
from ..place import split_place
from ..scene import Scene, save_scene
from .film import Film
from .sweep import Sweep

VERSION = "jobtemplate-2023-09"
SUFFIXES = (".json", ".yaml", ".yml")  # JSON is YAML too
MARK = "# The scene of a job, written by glcloth --openjd\n"


def film_template(film: Film) -> dict:
    """A template whose tasks are the frames of a film. The scene is a file beside the template."""
    words = ["--frames", film.frames, "--start", film.since, "--rate", film.rate, "--turn-env", film.turn_env]
    words += [] if film.wind is None else ["--wind", film.wind]
    words += ["--turntable" if film.around else "--no-turntable", *_device(film.device)]
    words += ["--aov", ",".join(film.aovs)] if film.aovs else []
    pattern = Path(film.output)
    command = f'animate "$1" {_shell(words)} --only "$3" -o "$2"/{_shell([pattern.name])}'
    tasks = _tasks("Frames", f"{film.since}-{film.frames - 1}", command)
    return _template(pattern.parent, "film", _output("OUT", "Where the frames are written."), tasks)


def sweep_template(sweep: Sweep) -> dict:
    """A template whose tasks are the pictures of a sweep, and a last one that makes the sheet and the table."""
    words = [word for text in varied(sweep) for word in ("--vary", text)]
    words += ["--suffix", sweep.suffix, *_device(sweep.device)]
    command = f'sweep "$1" {_shell(words)} -o "$2"'
    tasks = _tasks("Pictures", f"0-{len(sweep.rows) - 1}", f'{command} --only "$3"')
    sheet = {"name": "Sheet", "dependencies": [{"dependsOn": "Pictures"}], "script": _script(f"{command} --resume")}
    return _template(sweep.folder, "sweep", _output("INOUT", "Where the pictures are written."), tasks, sheet)


def varied(sweep: Sweep) -> list[str]:
    """The parameters and values of a sweep as options say them; files by their whole path, wherever a task runs."""
    said = ((name, map(_whole, values)) for name, values in zip(sweep.names, sweep.values, strict=True))
    return [f"{name}={';'.join(map(str, values))};" for name, values in said]


def _whole(value: Any) -> Any:
    """A value with its file, if it names one, by the whole path."""
    head, equals, text = value.rpartition("=") if isinstance(value, str) else ("", "", "")
    name, place = split_place(text)
    if not is_file(name):
        return value
    return f"{head}{equals}{Path(name).resolve()}" + (f"@{place}" if place else "")


def _template(folder: Path, what: str, output: dict, *steps: dict) -> dict:
    name = printable(folder.name or what).replace("{", "(").replace("}", ")")
    scene = {"name": "Scene", "type": "PATH", "objectType": "FILE", "dataFlow": "IN", "description": "The scene file."}
    return {
        "specificationVersion": VERSION,
        "name": f"glcloth {name}"[:60],
        "parameterDefinitions": [scene, output],
        "steps": list(steps),
    }


def _output(flow: str, text: str) -> dict:
    return {"name": "Output", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": flow, "description": text}


def _tasks(name: str, numbers: str, command: str) -> dict:
    """A step with a task for each number, which its command knows as $3."""
    return {
        "name": name,
        "parameterSpace": {"taskParameterDefinitions": [{"name": "Number", "type": "INT", "range": numbers}]},
        "script": _script(command, "{{Task.Param.Number}}"),
    }


def _script(command: str, *more: str) -> dict:
    """What a task runs. Paths reach the shell as arguments, $1 the scene and $2 the output: no name is code."""
    arguments = ["{{Task.File.Run}}", "{{Param.Scene}}", "{{Param.Output}}", *more]
    return {
        "actions": {"onRun": {"command": "bash", "args": arguments}},
        "embeddedFiles": [{"name": "Run", "type": "TEXT", "data": f"set -euo pipefail\nglcloth {command}\n"}],
    }


def _device(device: int | str | None) -> list[Any]:
    return [] if device is None else ["--device", device]


def _shell(words: list[Any]) -> str:
    """Words of a shell's line. Raises InputError for what a template would replace."""
    line = shlex.join(map(str, words))
    if "{{" in line:
        raise InputError(f"--openjd: {{{{ in {line}: templates replace what stands there; choose another name")
    return line


def check_template(path: Path) -> None:
    """Raise InputError for a template's name that would overwrite another kind of file, or whose scene would."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"--openjd {path}: expected a name that ends in {', '.join(SUFFIXES)}")
    scene = _scene_file(path)
    if scene.exists() and not (scene.is_file() and scene.read_bytes().startswith(MARK.encode())):
        raise InputError(f"--openjd {path}: its scene would overwrite {scene}; choose another name")


def _scene_file(path: Path) -> Path:
    return path.with_name(f"{path.name}.toml")


def save_template(path: Path, template: dict, scene: Scene, folder: Path) -> Path:
    """Write a template as JSON, and its scene beside it (.toml behind the same name); the scene's path. Raises InputError."""
    check_template(path)
    file = _scene_file(path)
    save_scene(file, scene, MARK)
    template["parameterDefinitions"][0]["default"] = file.name
    template["parameterDefinitions"][1]["default"] = os.path.relpath(folder, path.parent)  # as paths in templates are
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(template, indent=2) + "\n", encoding="utf-8")
    return file

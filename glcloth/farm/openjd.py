"""Open Job Description templates (2023-09): a render farm runs `glcloth` for each picture, as a task.

The farm's machines need glcloth and what the scene reads. A task that fails or is lost is run again by the farm; pictures
are written whole or not at all.
"""

from __future__ import annotations

import json
import shlex
from pathlib import Path

from ..files import atomic_write
from ..scene import Scene, save_scene
from .film import Film
from .sweep import Sweep

VERSION = "jobtemplate-2023-09"


def film_template(film: Film) -> dict:
    """A template whose tasks are the frames of a film. The scene is a file beside the template."""
    words = ["--frames", film.frames, "--rate", film.rate, "--turn-env", film.turn_env]
    words += [] if film.wind is None else ["--wind", film.wind]
    words += ["--turntable" if film.around else "--no-turntable"]
    return {
        "specificationVersion": VERSION,
        "name": f"glcloth {Path(film.output).parent.name or 'film'}",
        "parameterDefinitions": [
            _path("Scene", "IN", "FILE", "The scene file."),
            _path("Frames", "OUT", "DIRECTORY", "Where the frames are written."),
        ],
        "steps": [
            {
                "name": "Frames",
                "parameterSpace": {
                    "taskParameterDefinitions": [{"name": "Frame", "type": "INT", "range": f"0-{film.frames - 1}"}]
                },
                "script": _script(
                    "animate {{Param.Scene}} "
                    + shlex.join(map(str, words))
                    + f" --only {{{{Task.Param.Frame}}}} -o {{{{Param.Frames}}}}/{shlex.quote(Path(film.output).name)}"
                ),
            }
        ],
    }


def sweep_template(sweep: Sweep) -> dict:
    """A template whose tasks are the pictures of a sweep, and a last one that makes the sheet and the table."""
    vary = shlex.join(word for text in varied(sweep) for word in ("--vary", text))
    command = f"sweep {{{{Param.Scene}}}} {vary} --suffix {sweep.suffix} -o {{{{Param.Pictures}}}}"
    return {
        "specificationVersion": VERSION,
        "name": f"glcloth {sweep.folder.name or 'sweep'}",
        "parameterDefinitions": [
            _path("Scene", "IN", "FILE", "The scene file."),
            _path("Pictures", "INOUT", "DIRECTORY", "Where the pictures are written."),
        ],
        "steps": [
            {
                "name": "Pictures",
                "parameterSpace": {
                    "taskParameterDefinitions": [{"name": "Number", "type": "INT", "range": f"0-{len(sweep.rows) - 1}"}]
                },
                "script": _script(f"{command} --only {{{{Task.Param.Number}}}}"),
            },
            {"name": "Sheet", "dependencies": [{"dependsOn": "Pictures"}], "script": _script(f"{command} --resume")},
        ],
    }


def varied(sweep: Sweep) -> list[str]:
    """The parameters and values of a sweep as options say them."""
    return [f"{n}={';'.join(map(str, v))};" for n, v in zip(sweep.names, sweep.values, strict=True)]


def _path(name: str, flow: str, kind: str, text: str) -> dict:
    return {"name": name, "type": "PATH", "objectType": kind, "dataFlow": flow, "description": text}


def _script(command: str) -> dict:
    text = f"set -euo pipefail\nglcloth {command}\n"
    return {
        "actions": {"onRun": {"command": "bash", "args": ["{{Task.File.Run}}"]}},
        "embeddedFiles": [{"name": "Run", "type": "TEXT", "data": text}],
    }


def save_template(path: Path, template: dict, scene: Scene, folder: Path) -> Path:
    """Write a template as JSON, and its scene beside it (the same name, .toml); the scene's path. Raises InputError."""
    file = path.with_suffix(".toml")
    save_scene(file, scene)
    template["parameterDefinitions"][0]["default"] = file.name
    template["parameterDefinitions"][1]["default"] = str(folder)
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(template, indent=2) + "\n", encoding="utf-8")
    return file

"""Every built-in fabric as .glb, and the samples' dress, before Khronos' own glTF validator.

npm install --prefix FOLDER gltf-validator
python tests/measure/gltf.py --validator FOLDER [--fabrics linen,...] [--pairs 250]

It needs Node. The fits are over few pairs of directions: what is checked is the form of the files. Printed: errors, warnings,
infos and hints of each file, and what they say; exit 1 if there are errors or warnings.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import common

from glcloth.cli.samples import MESH, _mesh
from glcloth.export import models
from glcloth.export.files import WRITERS
from glcloth.fabric import builtin_fabrics, load_fabric

PROGRAM = """
const validator = require("gltf-validator"), fs = require("fs")
const all = process.argv.slice(1).map(async name => {
  const said = await validator.validateBytes(new Uint8Array(fs.readFileSync(name)), { uri: name })
  return [name, said.issues]
})
Promise.all(all).then(found => console.log(JSON.stringify({ version: validator.version(), found })))
"""


def main():
    options = common.options(__doc__, validator="", fabrics=builtin_fabrics(), pairs=250)
    models.PAIRS = options.pairs
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{name}.glb" for name in options.fabrics]
        for path in paths:
            WRITERS[".glb"](load_fabric(path.stem), path)
        _mesh(Path(folder) / MESH)
        command = ["node", "-e", PROGRAM, *paths, Path(folder) / MESH]
        environment = os.environ | {"NODE_PATH": str(Path(options.validator) / "node_modules")}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    said = json.loads(done.stdout)
    print(f"gltf-validator {said['version']}\n")
    common.head("file", "errors", "warnings", "infos", "hints")
    for name, issues in said["found"]:
        common.row(Path(name).name, *(issues[f"num{kind}"] for kind in ("Errors", "Warnings", "Infos", "Hints")))
    for line in sorted(
        {f"{one['code']}: {one['message']}" for _, issues in said["found"] for one in issues["messages"]}
    ):
        print(line)
    sys.exit(any(issues["numErrors"] or issues["numWarnings"] for _, issues in said["found"]))


main()

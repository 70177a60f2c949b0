"""Files that once broke glcloth, through its doors: python tests/measure/attack.py [--tree FOLDER] [--folder FOLDER].

Each must be one printable line and exit code 2 (or a picture, and not a word too many), within 1.5 GB and 10 s of CPU.
--tree runs another checkout's package, such as an old one, on the same files. Memory is limited to --gigabytes, so that this
machine survives what once took 17.
"""

import common  # noqa: I001
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from glcloth.errors import MAX_LINE

QUICK = ["--size", "32x24", "--mesh", "sphere", "--lobes", "2", "--shadows", "off"]
# How a file is given, where its suffix does not say it.
GIVEN = {
    "fabric_curve_inf.toml": [["render", "--fabric", "{}", *QUICK]],
    "mtl0.obj": [["render", "curtain", "--room", "{}", "--size", "32x24"]],
    "i_bomb.glb": [["render", "--object", "{}", *QUICK]],
    "ply_tex.ply": [["render", "--mesh", "{}", *QUICK[:2], *QUICK[4:]]],
    "png_16x4194312_1bit_90bytes.png": [["render", "--env", "{}", *QUICK], ["render", "--fabric-mask", "{}", *QUICK]],
}
BY_SUFFIX = {
    ".toml": [["render", "{}"]],
    ".png": [["render", "{}"]],
    ".json": [["render", "--lights", "{}", *QUICK]],
    ".exr": [["render", "--env", "{}", *QUICK]],
    ".obj": [["render", "--mesh", "{}", *QUICK[:2], *QUICK[4:]]],
    ".gltf": [["render", "--mesh", "{}", *QUICK[:2], *QUICK[4:]]],
}
# What the scripts among the files do, through today's modules: the values, where there once were zeros or millions.
SCRIPTS = {
    "radiance_zero.py": """
import numpy as np
from glcloth import Renderer
from glcloth.light.lights import Lights, SphericalGaussians
light = Lights(SphericalGaussians([[0, 0, 1]], [5.0], [[1, 1, 1]]))
with Renderer() as r:
    x = r.radiance("velvet", np.tile([[0.0, 0.0, 1.0]], (4194241, 1)), light, quality="draft")
print("radiance of the first and last of 4,194,241 directions", x[0].round(4).tolist(), x[-1].round(4).tolist())
""",
    "lb.py": """
import numpy as np
from glcloth.gpu.context import create_context
from glcloth.accel.queries import RayQueries
from glcloth.accel.structure import make_structure
from glcloth.accel.triangles import Triangles
n, ctx = 4250000, create_context()
k = int(np.ceil(np.sqrt(n)))
i = np.arange(n)
corner = np.zeros((n, 3, 3), "f4")
corner[:, 0] = np.stack([i % k / k * 2 - 1, i // k / k * 2 - 1, 0 * i], 1)
corner[:, 1], corner[:, 2] = corner[:, 0] + [2.2 / k, 0, 0], corner[:, 0] + [0, 2.2 / k, 0]
structure = make_structure(ctx, "lbvh")
structure.build(Triangles.of(ctx, corner))
at = np.concatenate([np.random.default_rng(0).uniform(-.9, .9, (2000, 2)), np.ones((2000, 1))], 1)
hit = RayQueries(ctx).any_hit(structure, at, np.tile([0, 0, -1.0], (2000, 1)))
print(f"{100 * hit.mean():.1f} % of rays meet an lbvh of 4,250,000 triangles")
""",
    "sub.py": """
import numpy as np
from glcloth.geometry.mesh import build_mesh
from glcloth.visibility.probes import subdivided
mesh = build_mesh("c", np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.tile([[0, 1, 2]], (1000, 1)))
print("1,000 copies of a triangle become", len(subdivided(mesh).triangles))
""",
}


def tried(command, tree, env, gigabytes):
    """(exit code, what was printed, MB, seconds of CPU) of a command."""

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (int(gigabytes * 2**30),) * 2)
        resource.setrlimit(resource.RLIMIT_CPU, (120, 120))

    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, cwd=tree, env=env, stdout=said, stderr=said, preexec_fn=limit)
        _, status, used = os.wait4(process.pid, 0)
        said.seek(0)
        text = said.read().decode(errors="replace")
    return os.waitstatus_to_exitcode(status), text, used.ru_maxrss / 1024, used.ru_utime + used.ru_stime


def judged(code, text, megabytes, seconds):
    """What is wrong, in words; "" where nothing is."""
    lines = text.rstrip("\n").split("\n")
    wrong = [] if code in (0, 2) else [f"exit {code}"]
    wrong += ["raw exception"] * ("Traceback" in text or "a fault of glcloth" in text)
    wrong += ["control characters"] * any(not line.isprintable() for line in lines)
    wrong += ["long line"] * any(len(line) > MAX_LINE for line in lines)
    wrong += ["several lines"] * (code == 2 and len([one for one in lines if "warning" not in one]) > 1)
    return ", ".join(wrong + ["memory"] * (megabytes > 1536) + ["slow"] * (seconds > 10))


def main():
    """Print a row for each file and way."""
    args = common.options(
        __doc__, None, tree=Path(__file__).parents[2], folder=common.SHARED / "cases/attack", gigabytes=8.0
    )
    env = {**os.environ, "PYTHONPATH": str(args.tree), "LP_NUM_THREADS": "1", "GLCLOTH_CACHE": tempfile.mkdtemp()}
    common.head("file", "exit", "MB", "s of CPU", "wrong", "said")
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted(args.folder.iterdir()):
            script = SCRIPTS.get(path.name)
            ways = [["-c", script]] if script else GIVEN.get(path.name) or BY_SUFFIX.get(path.suffix, [])
            for number, way in enumerate(ways):
                out = [] if script else ["-o", f"{folder}/{path.name}{number}.png"]
                words = way if script else ["-m", "glcloth", *(word.format(path) for word in way)]
                found = tried([sys.executable, *words, *out], args.tree, env, args.gigabytes)
                wrong = judged(*found) if not script or found[0] else ""
                bad += bool(wrong)
                said = "".join(c if c.isprintable() else "?" for c in found[1].strip().replace(str(path), path.name))
                common.row(path.name, found[0], int(found[2]), found[3], wrong, said[:150].replace("|", "/"))
    print(f"{bad} wrong")


if __name__ == "__main__":
    main()

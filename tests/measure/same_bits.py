"""Do two trees of glcloth make the same pictures to the bit? Small pictures by every method, compared.

python tests/measure/same_bits.py write FILE.npz [--tree DIR] [--only WORD] [--golden FOLDER]
python tests/measure/same_bits.py compare A.npz B.npz [--only WORD]

Only the public names of `import glcloth` and the command line are used, so that a tree may be rebuilt inside.
`write` renders in a process of its own with the package of DIR (default: this tree) and an empty cache.
`compare` prints a line a case, with relative differences over all its numbers; it exits 1 if a bit differs or
a case is missing. --golden names the folder of the brute-force samples; without it those cases are left out.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
GOLDEN = Path(os.environ.get("GLCLOTH_SHARED") or ROOT.parent / "shared") / "golden"
SIZE = (96, 72)
WAYS = {
    "draft": {"quality": "draft"},
    "normal": {},
    "high": {"quality": "high"},
    "adaptive": {"adaptive": True},
    "paper": {"method": "paper", "grid": 12},
    "reference": {"method": "reference", "cube": 8},
}
SUNNY = {"env": "sky", "env_rotate": 105.0}  # has a sun; the studio has none
LINEN, SILK = {"fabric": "linen"}, {"fabric": "silk_crepe_de_chine"}
CURTAIN = ["render", "curtain", "--frame", "3", "--gi", "off", "--exposure", "0"]
POSES = 3


def environment(tree, cache):
    """Variables of a process that uses the package of a tree; run it in a folder that holds no `glcloth`."""
    path = os.pathsep.join([str(Path(tree).resolve()), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": path, "GLCLOTH_CACHE": str(cache)}


def pictures():
    """Yield (name, scene, what is changed in it) of each picture by `Renderer.render`."""
    for fabric in ("linen", "silk_crepe_de_chine", "satin_charmeuse_front", "velvet"):
        for way, changes in WAYS.items():
            yield f"drape {fabric} {way}", "drape", {"fabric": fabric, **changes}
    for fabric in (LINEN, SILK):
        for way in ("normal", "reference"):
            yield f"draped {fabric['fabric']} {way}", "draped", {**fabric, **WAYS[way]}
    for way in ("normal", "paper", "reference"):
        for shadows in ("off", "sun", "full"):
            changes = {**LINEN, **SUNNY, **WAYS[way], "shadows": shadows}
            yield f"shadows {shadows} {way}", "drape", changes
        yield f"bounce off {way}", "drape", {**SILK, **WAYS[way], "bounce": False}
        yield f"ground {way}", "drape", {**SILK, **WAYS[way], "ground": "auto"}
        yield f"turned {way}", "drape", {**LINEN, **WAYS[way], "env_rotate": 70.0}
    for way in ("normal", "paper"):
        yield f"spp 4 {way}", "drape", {**SILK, **WAYS[way], "spp": 4}
    yield "spp 4 draped", "draped", {"spp": 4}
    yield "bounce off draped", "draped", {"bounce": False}
    yield "adaptive draped", "draped", {"adaptive": True}
    yield "light map", "drape", {**LINEN, **WAYS["reference"], "light": "map"}
    yield "light map turned", "drape", {**LINEN, **WAYS["reference"], "light": "map", "env_rotate": 70.0}
    yield "light map shadows off", "drape", {**SILK, **WAYS["reference"], "light": "map", "shadows": "off"}
    yield "background off", "drape", {**SILK, "background": False}
    yield "lobes auto", "drape", {**LINEN, **SUNNY, "lobes": "auto"}


def commands(folder):
    """Yield (name, arguments) of each picture, or sequence of pictures, by the command line."""
    yield "command drape", ["render", "drape"]
    for accelerator in ("kdtree", "lbvh", "brute"):
        yield f"curtain {accelerator}", [*CURTAIN, "--accelerator", accelerator]
    yield "curtain spp 4 lace", [*CURTAIN, "--spp", "4", "--fabric", "lace"]
    yield "curtain layers", [*CURTAIN, "--layers"]
    for accelerator in ("kdtree", "lbvh"):
        yield f"curtain tree {accelerator}", [*CURTAIN, "--show-tree", "leaves", "--accelerator", accelerator]
    yield "animate curtain", ["animate", "curtain", "--frames", "3", "--gi", "off", "--exposure", "0"]
    poses = str(folder / "pose%04d.obj")
    yield "animate poses", ["animate", "drape", "--mesh", poses, "--frames", str(POSES)]
    yield "animate wind", ["animate", "drape", "--wind", "3", "--frames", "3"]
    yield "animate turntable", ["animate", "draped", "--turntable", "--turn-env", "90", "--frames", "3"]


def write_poses(folder, n=25):
    """Write the poses of a wavy sheet, pose0000.obj and on."""
    u, v = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n)))
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel() + 1
    corners = np.concatenate([first[:, None] + [0, 1, n + 1], first[:, None] + [0, n + 1, n]])
    for pose in range(POSES):
        z = 0.1 * np.sin(9 * u + 0.2 * pose) + 0.06 * np.cos(7 * v)
        lines = [f"v {x:.6f} {y:.6f} {h:.6f}" for x, y, h in zip(u, v, z, strict=True)]
        lines += [f"vt {x:.6f} {y:.6f}" for x, y in zip(u, v, strict=True)]
        lines += ["f " + " ".join(f"{i}/{i}" for i in row) for row in corners]
        (folder / f"pose{pose:04d}.obj").write_text("\n".join(lines) + "\n")


def golden_fabric(data, f, normalization):
    """Fabric number f of the golden file."""
    import glcloth

    yarns = []
    for j in (0, 1):
        tilts = []
        for t in range(int(data["n_tan"][f])):
            if data["tan_yarn"][f, t] == j:
                tilts += [float(np.degrees(data["tan_tilt"][f, t]))] * int(data["tan_mult"][f, t])
        yarns.append(
            glcloth.Yarn(
                albedo=tuple(data["yarn_A"][f, j].tolist()),
                eta=float(data["yarn_eta"][f, j]),
                k_d=float(data["yarn_kd"][f, j]),
                gamma_s_deg=float(np.degrees(data["yarn_gs"][f, j])),
                gamma_v_deg=float(np.degrees(data["yarn_gv"][f, j])),
                area=float(data["yarn_a"][f, j]),
                tangents_deg=tuple(tilts),
            )
        )
    sigma = float(np.degrees(data["sigma_MP"]))
    return glcloth.Fabric(name=f"golden {f}", yarn=yarns, sigma_deg=sigma, normalization=normalization)


def radiances(renderer, data, normalization, way):
    """Radiance of each sample of the golden file, [samples, 3]."""
    import glcloth

    fabrics = [golden_fabric(data, f, normalization) for f in range(len(data["n_tan"]))]
    rows = []
    for s in np.argsort(data["fabric"], kind="stable"):
        lights = glcloth.SphericalGaussians(data["xi"][s], data["kappa"][s], data["L_k"][s])
        rows.append(renderer.radiance(fabrics[data["fabric"][s]], data["wo"][s][None], lights, **way))
    return np.concatenate(rows)


def fit_of(name):
    """The lights of an environment, a row a Gaussian."""
    import glcloth

    fit = glcloth.fit_lights(glcloth.load_environment(name), 10).gaussians
    return np.column_stack([fit.axis, fit.sharpness, fit.amplitude])


def command(arguments, name):
    """Run `glcloth` with the arguments and return the pictures that it wrote."""
    import glcloth

    output = Path(name.replace(" ", "-"))
    output.mkdir()
    file = str(output / ("%04d.exr" if arguments[0] == "animate" else "0.exr"))
    line = [sys.executable, "-m", "glcloth", *arguments, "--size", "{}x{}".format(*SIZE), "-o", file]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    return np.array([glcloth.read_image(picture) for picture in sorted(output.iterdir())])


def cases(renderer, golden):
    """Yield (name, what makes its numbers) of every case."""
    import glcloth

    for name in ("studio", "sky"):
        yield f"fit {name}", lambda n=name: fit_of(n)
    for name, scene, changes in pictures():
        yield name, lambda s=scene, c=changes: renderer.render(s, size=SIZE, **c)
    axes, radiance = [[0.6, 0.64, 0.48], [-1.0, 0.0, 0.0]], [[5.0, 4.0, 3.0], [0.2, 0.3, 0.4]]
    given = glcloth.SphericalGaussians(axes, [40.0, 2.0], radiance)
    yield "given lights", lambda: renderer.render("drape", size=SIZE, lights=given)
    if golden.is_dir():
        data = dict(np.load(golden / "microcylinder.npz"))
        for normalization in ("sadeghi", "paper"):
            for way in ("draft", "normal", "high", "paper", "reference"):
                name = f"golden {normalization} {way}"
                yield name, lambda n=normalization, w=way: radiances(renderer, data, n, WAYS[w])
    else:
        print(f"{golden} is not there: the golden cases are left out", flush=True)
    write_poses(Path.cwd())
    for name, arguments in commands(Path.cwd()):
        yield name, lambda a=arguments, n=name: command(a, n)


def work(file, tree, only, golden):
    """In the process of a tree: make and keep the numbers of all cases. Returns how many cases failed."""
    import glcloth

    assert Path(glcloth.__file__).is_relative_to(tree), f"{glcloth.__file__} is not of {tree}"
    made, failed, begin = {}, 0, time.perf_counter()
    with glcloth.Renderer() as renderer:
        for name, make in cases(renderer, golden):
            if only not in name:
                continue
            start = time.perf_counter()
            try:
                made[name] = np.ascontiguousarray(make())
                said = f"{time.perf_counter() - start:.1f} s"
            except Exception as error:
                failed += 1
                said = f"failed: {type(error).__name__}: {error}"
            print(f"{name:40}{said}", flush=True)
    np.savez_compressed(file, **made)
    print(f"{file}: {len(made)} cases of {tree}, {failed} failed, {time.perf_counter() - begin:.0f} s")
    return failed


def write(options):
    """Start the process of a tree. Returns its exit code."""
    tree, file, golden = (Path(path).resolve() for path in (options.tree, options.file, options.golden))
    with tempfile.TemporaryDirectory() as folder:
        line = [sys.executable, Path(__file__).resolve(), "work", file, tree, golden, "--only", options.only]
        return subprocess.run(line, cwd=folder, env=environment(tree, Path(folder) / "cache")).returncode


def difference(a, b):
    """How two arrays differ, in words; empty when they are the same bits."""
    if (a.shape, a.dtype) != (b.shape, b.dtype):
        return f"{a.dtype} {a.shape} and {b.dtype} {b.shape}"
    bits = f"u{a.itemsize}"
    other = a.view(bits) != b.view(bits)
    if not other.any():
        return ""
    with np.errstate(all="ignore"):
        relative = np.abs(a.astype(float) - b) / np.maximum(np.abs(a), np.abs(b))
    # 0 and -0 are other bits of the same number; nan against a number is as far as can be.
    relative = np.where(other, np.nan_to_num(np.where(a == b, 0.0, relative), nan=np.inf), 0.0)
    pixels = other.any(-1)
    how = f"relative max {relative.max():.3g}, mean {relative.mean():.3g}"
    return f"{pixels.sum()} of {pixels.size} pixels differ, {how}"


def compare(options):
    """Print how the cases of two files differ. Returns 1 if they do, else 0."""
    with np.load(options.a) as a, np.load(options.b) as b:
        names = [name for name in dict.fromkeys([*a.files, *b.files]) if options.only in name]
        bad = 0
        for name in names:
            missing = [str(file) for file, kept in ((options.a, a), (options.b, b)) if name not in kept.files]
            said = f"missing in {missing[0]}" if missing else difference(a[name], b[name])
            bad += bool(said)
            print(f"{name:40}{said or 'same bits'}")
    print(f"{len(names)} cases, {bad} not the same" if bad else f"{len(names)} cases, all the same bits")
    return int(bad > 0 or not names)


def main():
    parser = argparse.ArgumentParser()
    parts = parser.add_subparsers(dest="action", required=True)
    part = parts.add_parser("write")
    part.add_argument("file", type=Path)
    part.add_argument("--tree", default=ROOT)
    part.add_argument("--golden", default=GOLDEN)
    part.add_argument("--only", default="")
    part = parts.add_parser("compare")
    part.add_argument("a", type=Path)
    part.add_argument("b", type=Path)
    part.add_argument("--only", default="")
    part = parts.add_parser("work")  # what `write` starts
    for name in ("file", "tree", "golden"):
        part.add_argument(name, type=Path)
    part.add_argument("--only", default="")
    options = parser.parse_args()
    if options.action == "work":
        return int(work(options.file, options.tree, options.only, options.golden) > 0)
    return write(options) if options.action == "write" else compare(options)


if __name__ == "__main__":
    sys.exit(main())

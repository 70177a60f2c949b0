"""Parameters of a fabric at three values, from afar and 2 cm of it: the pictures of docs/parameters.md.

python examples/14_parameters.py [out/parameters] [NAME ... | all]  (draft; all take half an hour on two cores)
"""

import io
import sys
from pathlib import Path

import numpy as np
from common import output
from PIL import Image

import glcloth
from glcloth.color import view
from glcloth.geometry.mesh import build_mesh
from glcloth.progress import track

SIZE = (184, 132)
WIDTH = 0.02  # metres of cloth across a near picture
GAP = 4  # pixels


def fabric(name):
    """Three fabrics that differ in one field of the fabric."""
    return lambda base, value: base.changed(**{name: value})


def yarns(name):
    """... of both yarns."""
    return lambda base, value: base.changed(yarn=tuple(yarn.changed(**{name: value}) for yarn in base.yarn))


def warp(**fixed):
    """... of the warp, whose other fields are as given."""
    return lambda base, value: base.changed(yarn=(base.yarn[0].changed(**fixed, **value), base.yarn[1]))


def weave(name):
    """... of the weave."""
    return lambda base, value: base.changed(weave=base.weave.changed(**{name: value}))


def uneven(name):
    """... of the weave's irregularity."""
    return lambda base, value: base.changed(
        weave=base.weave.changed(irregularity=base.weave.irregularity.changed(**{name: value}))
    )


def through(name):
    """... of the light through it."""
    return lambda base, value: base.changed(transmission=base.transmission.changed(**{name: value}))


BLUE, GREY, RED = (0.02, 0.05, 0.25), (0.2, 0.2, 0.2), (0.3, 0.03, 0.03)
STRIPES = [{"count": n, "albedo": c} for n, c in ((12, (0.3, 0.29, 0.26)), (4, BLUE))]
# name: fabric to begin with, what changes, three values
PARAMETERS = {
    "albedo": ("linen_heavy", yarns("albedo"), (BLUE, GREY, RED)),
    "eta": ("sateen", yarns("eta"), (1.2, 1.45, 1.9)),
    "k_d": ("charmeuse", yarns("k_d"), (0.0, 0.3, 1.0)),
    "gamma_s_deg": ("charmeuse", yarns("gamma_s_deg"), (3, 8, 24)),
    "gamma_v_deg": ("charmeuse", yarns("gamma_v_deg"), (6, 16, 48)),
    "area": ("silk_shot", warp(), ({"area": 0.2}, {"area": 0.5}, {"area": 0.86})),
    "tangents": (
        "silk_crepe_de_chine",
        warp(curve_lengths=(1,), samples=9),
        tuple({"curve_angles_deg": (-a, a)} for a in (5, 30, 60)),
    ),
    "sigma_deg": ("charmeuse", fabric("sigma_deg"), (5, 20, 60)),
    "normalization": ("linen", fabric("normalization"), ("sadeghi", "paper")),
    "energy": ("duchesse_satin", fabric("energy"), ("given", "limit")),
    "draft": ("canvas", weave("draft"), ("plain", "twill_2_2", "satin_5")),
    "ends_per_cm": ("linen_heavy", weave("ends_per_cm"), (8, 14, 24)),
    "picks_per_cm": ("linen_heavy", weave("picks_per_cm"), (8, 14, 24)),
    "width": ("linen_heavy", weave("width"), (0.5, 0.8, 1.05)),
    "flat": ("linen_heavy", weave("flat"), (0.2, 0.5, 1.0)),
    "crimp": ("canvas", weave("crimp"), (0.1, 0.5, 0.9)),
    "bow": ("duchesse_satin", weave("bow"), (0.0, 0.4, 1.0)),
    "tilt_deg": ("canvas", weave("tilt_deg"), (8, 25, 50)),
    "twist_deg": ("canvas", weave("twist_deg"), (-35, 0, 35)),
    "pinch": ("linen_heavy", weave("pinch"), (0.0, 0.2, 0.5)),
    "occlusion": ("linen_heavy", weave("occlusion"), (0.0, 0.5, 0.95)),
    "roll": ("linen_heavy", weave("roll"), (0.0, 0.5, 1.0)),
    "relief": ("linen_heavy", weave("relief"), (0.0, 0.5, 1.0)),
    "fuzz": ("flannel", weave("fuzz"), (0.0, 6.0, 24.0)),
    "fuzz_length": ("flannel", weave("fuzz_length"), (0.5, 1.5, 4.0)),
    "shift": ("linen_heavy", uneven("shift"), (0.0, 0.15, 0.4)),
    "length": ("linen_heavy", uneven("length"), (1.0, 8.0, 48.0)),
    "yarn": ("linen_heavy", uneven("yarn"), (0.0, 0.15, 0.5)),
    "fibre": ("linen_heavy", uneven("fibre"), (0.0, 0.4, 1.0)),
    "colors": (
        "canvas",
        lambda base, value: base.changed(weave=base.weave.changed(**value)),
        (
            {"colors": "yarn"},
            {"colors": "stripes", "warp_stripes": STRIPES, "weft_stripes": STRIPES[:1]},
            {"colors": "stripes", "warp_stripes": STRIPES, "weft_stripes": STRIPES},
        ),
    ),
    "rho": ("sheer_voile", through("rho"), (0.3, 0.65, 0.95)),
    "k_a": ("sheer_voile", through("k_a"), (0.0, 0.5, 1.0)),
    "k_t": ("sheer_voile", through("k_t"), (0.0, 0.5, 1.0)),
    "tau": ("sheer_voile", through("tau"), ((0.0,) * 3, (0.8, 0.8, 0.8), (0.1, 1.5, 2.5))),
    "diffuse": ("sheer_voile", through("diffuse"), (0.0, 0.5, 1.0)),
    "roughness": ("sheer_voile", through("roughness"), (0.1, 0.4, 1.0)),
    "eta_2": ("sheer_voile", through("eta_2"), (1.1, 1.54, 2.2)),
    "roughness_p": ("sheer_voile", through("roughness_p"), (0.02, 0.2, 0.8)),
}


def near_scene(side=0.5):
    """A flat piece of cloth, its UVs in metres, and the camera that sees WIDTH of it."""
    corners = np.array([[-side, 0, side], [side, 0, side], [side, 0, -side], [-side, 0, -side]])
    uv = side * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    away, height = 0.95 * WIDTH * np.array([np.cos(1.0), np.sin(1.0)])
    camera = glcloth.Camera((0.0, height, away), (0.0, 0.0, 0.0), fov_deg=40.0)
    return {"mesh": build_mesh("flat", corners, np.array([[0, 1, 2], [0, 2, 3]]), uv, None), "camera": camera}


def scenes(base, name):
    """How a fabric is shown: from afar and near, before a lit background where light comes through; hairs at its edge."""
    if base.transmission is not None:
        hung = {"mesh": "folds", "env": "sky", "env_rotate": 150, "size": SIZE}
        return {**hung, "spp": 2}, {**hung, "camera": glcloth.View(view="close"), "spp": 2}
    lit = {"env": "studio", "size": SIZE, "exposure": 0.3}
    near = near_scene(0.25 * WIDTH) if name.startswith("fuzz") else near_scene()
    return {**lit, "mesh": "drape", "spp": 2}, {**lit, **near, "shadows": "off", "spp": 4}


def strip(renderer, name):
    """Afar above, near below, the values beside each other; 8 bits."""
    start, change, values = PARAMETERS[name]
    base = glcloth.load_fabric(start)
    fabrics = [change(base, value) for value in values]
    rows = []
    for scene in scenes(base, name):
        pictures = [view(renderer.render(fabric=f, **scene), "filmic", 0.3) for f in fabrics]
        rows.append(np.concatenate([np.pad(p, ((0, GAP), (0, GAP), (0, 0)), constant_values=1.0) for p in pictures], 1))
    return np.round(255 * np.concatenate(rows)[:-GAP, :-GAP]).astype(np.uint8)


if __name__ == "__main__":
    names = sys.argv[2:] or ["draft"]
    names = list(PARAMETERS) if names == ["all"] else names
    if unknown := set(names) - set(PARAMETERS):
        sys.exit(f"{unknown.pop()}: no such parameter; known: {', '.join(PARAMETERS)}")
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/parameters")
    with glcloth.Renderer() as renderer:
        for name in track(names, "parameters"):
            buffer = io.BytesIO()
            Image.fromarray(strip(renderer, name)).save(buffer, "jpeg", quality=80, optimize=True)
            output(folder / f"{name}.jpg").write_bytes(buffer.getvalue())
    print(folder)

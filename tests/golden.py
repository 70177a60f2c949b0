"""The brute-force samples of ../shared/golden as fabrics, directions and lights; errors of luminance."""

import numpy as np

from glcloth.color import luminance
from glcloth.fabric import Fabric, Yarn
from glcloth.light.lights import SphericalGaussians


def golden_fabrics(data, normalization):
    """The three fabrics of the golden file, exactly as its tables describe them."""
    fabrics = []
    for f in range(len(data["n_tan"])):
        yarns = []
        for j in (0, 1):
            mine = [t for t in range(int(data["n_tan"][f])) if data["tan_yarn"][f, t] == j]
            tilts = [
                round(float(np.degrees(data["tan_tilt"][f, t])), 9)
                for t in mine
                for _ in range(int(data["tan_mult"][f, t]))
            ]
            yarns.append(
                Yarn(
                    albedo=tuple(float(v) for v in data["yarn_A"][f, j]),
                    eta=float(data["yarn_eta"][f, j]),
                    k_d=float(data["yarn_kd"][f, j]),
                    gamma_s_deg=float(np.degrees(data["yarn_gs"][f, j])),
                    gamma_v_deg=float(np.degrees(data["yarn_gv"][f, j])),
                    area=float(data["yarn_a"][f, j]),
                    tangents_deg=tuple(tilts),
                )
            )
        sigma_deg = float(np.degrees(data["sigma_MP"]))
        fabrics.append(
            Fabric(name=str(data["fabric_names"][f]), normalization=normalization, sigma_deg=sigma_deg, yarn=yarns)
        )
    return fabrics


def golden_samples(shared, normalization, key=None):
    """Yield (fabric, omega_o [1, 3], lights, expected [1, 3]) for each sample; `key` names another array of the file."""
    data = np.load(shared / "golden" / "microcylinder.npz")
    fabrics = golden_fabrics(data, normalization)
    expected = data[key or {"sadeghi": "L_ref_sadeghi", "paper": "L_ref"}[normalization]]
    for s in range(len(data["wo"])):
        lights = SphericalGaussians(data["xi"][s], data["kappa"][s], data["L_k"][s])
        yield fabrics[int(data["fabric"][s])], data["wo"][s][None], lights, expected[s][None]


def luminance_errors(got, expected):
    """Relative error of luminance per sample."""
    return np.abs(luminance(np.asarray(got, float)) / luminance(expected) - 1)

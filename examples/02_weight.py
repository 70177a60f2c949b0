"""Figure 2 of paper A: the weight W over the hemisphere of light directions, for three tangents and three views.

python examples/02_weight.py [out/02_weight.png]
"""

import sys

from common import needs, output

needs("matplotlib", "plots")
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import glcloth
from glcloth.twins.cloth import terms
from glcloth.twins.frame import tangent_axes

path = output(sys.argv[1] if len(sys.argv) > 1 else "out/02_weight.png")
fabric = glcloth.load_fabric("linen")
yarns = [
    dict(eta=y.eta, k_d=y.k_d, gamma_s=np.radians(y.gamma_s_deg), gamma_v=np.radians(y.gamma_v_deg))
    for y in fabric.yarn
]
x, y = np.meshgrid(np.linspace(-1, 1, 400), np.linspace(1, -1, 400))
z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
omega_i = np.stack([x, y, z], -1)

figure, axes = plt.subplots(3, 3, figsize=(7.5, 7.8), layout="constrained")
for row, tilt_deg in enumerate((0.0, 25.0, -25.0)):
    # The plain weave with its first tangent turned to the tilt of the row; equation 6 as printed.
    tangents = [(0, np.radians(tilt_deg), 1), *((t.yarn, t.tilt, t.count) for t in fabric.tangents)]
    weights = np.ones((len(tangents), 2))
    t, b, n = tangent_axes(np.array(0), np.cos(np.radians(tilt_deg)), np.sin(np.radians(tilt_deg)))
    for column, phi_o in enumerate((-np.pi / 3, 0.0, np.pi / 3)):
        theta_o = -np.pi / 4
        omega_o = np.sin(theta_o) * t + np.cos(theta_o) * (np.sin(phi_o) * b + np.cos(phi_o) * n)
        R, _, _ = terms(omega_i, omega_o, yarns, tangents, weights, 0.0, fabric.sigma)
        W = np.where(x * x + y * y < 1, R[..., 0], np.nan)
        axis = axes[row, column]
        shown = axis.imshow(W, extent=(-1, 1, -1, 1), vmin=0, vmax=0.4, cmap="viridis")
        axis.plot(*omega_o[:2], "w+")
        axis.set_title(f"tilt {tilt_deg:g}°, $\\phi_o$ = {np.degrees(phi_o):.0f}°", fontsize=9)
        axis.set_axis_off()
figure.colorbar(shown, ax=axes, shrink=0.6, label="W")
figure.savefig(path, dpi=100)
print(path)

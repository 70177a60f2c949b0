"""Two figures of docs/glossary.md: the frame of one yarn, and the weights of a weave's tangents.

python examples/12_yarn_frame.py [out/yarn_frame.png] [out/weave_weights.png]
"""

import sys

from common import needs, output

needs("matplotlib", "plots")
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Arc, Rectangle

import glcloth
from glcloth.twins.frame import tangent_axes, tangent_from_surface
from glcloth.twins.weight import P

TILT = np.radians(25)
YARN_1, YARN_2, LIGHT = "#1f77b4", "#d95f02", "#8c6d00"


def arrow(axis, start, vector, label, color, offset):
    """An arrow with its name beside the head."""
    axis.annotate("", np.add(start, vector), start, arrowprops=dict(arrowstyle="-|>", color=color, lw=1.8))
    axis.text(*np.add(np.add(start, vector), offset), label, color=color, ha="center", va="center", fontsize=11)


def angle(axis, centre, size, low, high, label, place):
    """An arc of an angle with its name."""
    axis.add_patch(Arc(centre, size, size, theta1=low, theta2=high, color="black", lw=0.9))
    axis.text(*place, label, ha="center", va="center", fontsize=11)


def draw_side(axis):
    """The yarn cut along its length: the surface frame, and the tangent frame at a point where the yarn goes down."""
    t, _, n = tangent_axes(np.array(0), np.cos(TILT), np.sin(TILT))
    x = np.linspace(-2.6, 2.6, 300)
    wave = np.tan(TILT) * 1.3 / (np.pi / 2) * np.cos(np.pi * x / 2.6)
    centre = np.array([1.3, 0.0])
    axis.plot(x, wave, color=YARN_1, lw=16, alpha=0.3, solid_capstyle="butt")
    axis.plot(x, wave, color=YARN_1, lw=1, ls="--")
    for place, height in ((0, -0.25), (-2.6, 0.25), (2.6, 0.25)):
        axis.add_patch(plt.Circle((place, height), 0.3, color=YARN_2, alpha=0.4))
    axis.text(0, -0.72, "yarn 2, cut across", color=YARN_2, ha="center", fontsize=9)
    axis.text(-1.45, -0.55, "yarn 1", color=YARN_1, ha="center", fontsize=9)
    axis.plot([1.3, 2.9], [0, 0], color="grey", lw=0.8, ls=":")
    arrow(axis, centre, 1.3 * t[[0, 2]], "t", YARN_1, (0.12, -0.08))
    arrow(axis, centre, 1.3 * n[[0, 2]], "n", YARN_1, (0.12, 0.1))
    angle(axis, centre, 1.8, -np.degrees(TILT), 0, "a", (2.36, -0.22))
    arrow(axis, (-2.3, 1.0), (0.9, 0), "x = yarn 1", "black", (0.1, -0.2))
    arrow(axis, (-2.3, 1.0), (0, 0.9), "z = N", "black", (0.0, 0.15))
    axis.set_title("surface frame, and a tangent t with tilt a", fontsize=10)
    axis.set(xlim=(-2.9, 3.2), ylim=(-1.0, 2.2), aspect="equal")


def draw_cylinder(axis):
    """The tangent frame as a picture: t to the right, n up, b = n x t away from the viewer."""
    project = np.array([[1.0, 0.0], [0.6, 0.22], [0.0, 1.0]])  # of t, b, n
    turn = np.linspace(0, 2 * np.pi, 200)
    circle = np.stack([np.zeros_like(turn), np.sin(turn), np.cos(turn)], -1)
    for along in (-1.5, 1.5):
        axis.plot(*(([along, 0, 0] + 0.32 * circle) @ project).T, color=YARN_1, lw=1.2)
    for side in (np.arctan(0.22), np.arctan(0.22) + np.pi):
        edge = 0.32 * np.array([0, np.sin(side), np.cos(side)])
        axis.plot(*(np.array([[-1.5, 0, 0], [1.5, 0, 0]]) + edge @ np.eye(3)).dot(project).T, color=YARN_1, lw=1.2)
    axis.fill(*(1.25 * circle @ project).T, color="grey", alpha=0.15)
    axis.text(1.1, -1.2, "normal plane of t\n(theta = 0)", fontsize=9, color="dimgrey", ha="center")
    theta, phi = np.radians(40), np.radians(-50)
    flat = np.array([0, np.sin(phi), np.cos(phi)])
    omega = np.sin(theta) * np.array([1, 0, 0]) + np.cos(theta) * flat
    for vector, label, color, offset in (
        ((2.1, 0, 0), "t", YARN_1, (0.12, 0.0)),
        ((0, 1.75, 0), "b", YARN_1, (0.12, 0.08)),
        ((0, 0, 1.75), "n", YARN_1, (0.0, 0.13)),
        (1.9 * omega, r"$\omega$", LIGHT, (0.12, 0.08)),
    ):
        arrow(axis, (0, 0), np.asarray(vector) @ project, label, color, offset)
    axis.plot(*np.array([[0, 0], 1.25 * flat @ project]).T, color=LIGHT, ls=":", lw=1.5)
    for label, along, place in (
        (r"$\theta$", [np.sin(a) * np.array([1, 0, 0]) + np.cos(a) * flat for a in np.linspace(0, theta, 40)], 20),
        (r"$\phi$", [np.array([0, np.sin(a), np.cos(a)]) for a in np.linspace(0, phi, 40)], 22),
    ):
        points = 0.8 * np.array(along) @ project
        axis.plot(*points.T, color="black", lw=0.9)
        axis.text(*(1.22 * points[place]), label, ha="center", va="center", fontsize=11)
    axis.set_title("tangent frame: theta from the normal plane, phi about t (here < 0)", fontsize=10)
    axis.set(xlim=(-2.2, 2.6), ylim=(-1.6, 2.2), aspect="equal")


def draw_weights(areas, shares, fabric, light_deg):
    """The weave's area by tangents, and the shares w_t P_t / Q over the view."""
    colors = ["#1f4e79", "#6baed6", "#b34700", "#fdae6b"]
    names = [f"yarn {t.yarn + 1}, tilt {np.degrees(t.tilt):+.0f}°" for t in fabric.tangents]
    weights = [*fabric.weights[:, 1], fabric.gap]
    left = 0.0
    for weight, color, name in zip(weights, [*colors, "white"], [*names, "gap"], strict=True):
        areas.add_patch(Rectangle((left, 0), weight, 1, facecolor=color, edgecolor="black", lw=0.8))
        color = "black" if color in ("white", "#6baed6", "#fdae6b") else "white"
        text = f"{name}:  {weight:g}" if name != "gap" else f"1 - a$_1$ - a$_2$:  {weight:.2f}"
        areas.text(left + weight / 2, 0.5, text, rotation=90, ha="center", va="center", fontsize=9, color=color)
        left += weight
    areas.set(xlim=(0, 1), ylim=(0, 1), xlabel="share of the area", yticks=[])
    areas.set_title(r"w$_t$ = a$_j$ mult$_t$ / N$_j$ of linen, and the gap", fontsize=10)

    view = np.radians(np.linspace(-89, 89, 357))
    omega_o = np.stack([np.sin(view), 0 * view, np.cos(view)], -1)
    light = np.radians(light_deg)
    omega_i = np.array([np.sin(light), 0.0, np.cos(light)])
    seen = []
    for (yarn, tilt, _), weight in zip(fabric.tangents, fabric.weights[:, 1], strict=True):
        frames = [tangent_from_surface(o, yarn, np.cos(tilt), np.sin(tilt)) for o in (omega_i, omega_o)]
        seen.append(weight * P(*frames, fabric.sigma))
    seen = np.array([*seen, fabric.gap * np.maximum(omega_o[:, 2], 0)])
    shares.stackplot(np.degrees(view), seen / seen.sum(0), colors=[*colors, "white"], labels=[*names, "gap"])
    shares.axvline(light_deg, color=LIGHT, ls="--", lw=1)
    shares.text(light_deg + 1.5, 0.94, "light", color=LIGHT, fontsize=9)
    shares.set(xlim=(-89, 89), ylim=(0, 1), xlabel="view: degrees from N toward yarn 1")
    shares.set_title(r"w$_t$ P$_t$ / Q: together 1 at every view", fontsize=10)


def main():
    first = output(sys.argv[1] if len(sys.argv) > 1 else "out/yarn_frame.png")
    second = output(sys.argv[2] if len(sys.argv) > 2 else "out/weave_weights.png")
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    draw_side(axes[0])
    draw_cylinder(axes[1])
    for axis in axes:
        axis.set_axis_off()
    figure.savefig(first, dpi=100)
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    draw_weights(*axes, glcloth.load_fabric("linen"), light_deg=-30)
    figure.savefig(second, dpi=100)
    print(first, second)


main()

"""Garments of several materials, a body and pictures to print on them, as files; and the commands that show them.

python tests/measure/garments.py FOLDER      # writes the files, prints a command for each garment

The garments are drawn with formulas, in centimetres, as CLO writes its files: a dress of five materials, and a coat of six. They
lie about the dress form, which stands in metres at the same place.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.interpolate import PchipInterpolator

# Radii of the body (x, z) at heights, cm, a little outside the dress form.
HEIGHTS = np.array([60.0, 75.0, 90.0, 100.0, 107.0, 115.0, 127.0, 135.0, 139.0, 142.5, 145.0, 149.0])
ACROSS = np.array([17.0, 18.6, 18.9, 16.4, 13.6, 13.2, 15.6, 16.6, 17.2, 15.0, 9.0, 6.0])
DEEP = np.array([12.6, 14.0, 14.3, 12.6, 11.6, 11.6, 13.6, 11.6, 9.0, 7.4, 6.6, 5.8])


def body(height):
    """Half axes (x, z) of a ring about the body at heights, cm."""
    return PchipInterpolator(HEIGHTS, ACROSS)(height), PchipInterpolator(HEIGHTS, DEEP)(height)


def tube(low, high, ease=0.0, flare=0.0, folds=(0, 0.0), open_front=0.0, rows=40, columns=240, part=(0.0, 1.0)):
    """A ring of cloth from a height to another: (points, UVs), [rows, columns, 3] and [..., 2].

    `ease`: cm off the body; `flare`: cm more at the lower edge; `folds`: how many, and cm deep there; `open_front`: radians;
    `part`: from where to where of its length it is there.
    """
    t = np.linspace(*part, rows)[:, None]  # from above
    angle = np.linspace(0.5 * open_front, 2.0 * np.pi - 0.5 * open_front, columns)[None]
    height = high + (low - high) * t
    x, z = body(height)
    wave = folds[1] * t * np.sin(folds[0] * angle + 0.6 * np.sin(3.0 * angle))
    out = ease + flare * t**1.3 + wave
    points = np.stack([(x + out) * np.sin(angle), height + 0 * angle, (z + out) * np.cos(angle)], -1)
    around = np.linalg.norm(np.diff(points, axis=1), axis=-1).mean() * np.arange(columns)
    uv = np.stack(np.broadcast_arrays(0.01 * around[None], 0.01 * (high - low) * (1.0 - t)), -1)
    return points, uv


def arm(side, length, radius=5.2, ease=0.0, begin=0.0, rows=40, columns=90):
    """A sleeve from the shoulder down, slightly away from the body, with crumples."""
    t = np.linspace(begin, 1.0, rows)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, columns)[None]
    r = radius + ease + 0.35 * np.sin(22.0 * t + 1.5 * np.sin(angle)) * np.sin(np.pi * t) + 1.5 * (1.0 - t) ** 4
    r = r * np.sqrt(1.0 - np.clip(1.0 - t / 0.13, 0.0, 1.0) ** 2)  # a round head at the shoulder
    along = np.array([0.30 * side, -0.955, 0.0])
    x_axis, z_axis = np.array([0.955, 0.30 * side, 0.0]), np.array([0.0, 0.0, 1.0])
    start = np.array([14.5 * side, 144.5, -1.0])
    points = start + length * t[..., None] * along
    points = points + (r * np.cos(angle))[..., None] * x_axis + (r * np.sin(angle))[..., None] * z_axis
    around = np.broadcast_to(0.01 * radius * angle, (rows, columns))
    return points, np.stack([around, np.broadcast_to(0.01 * length * (1.0 - t), (rows, columns))], -1)


def write(path, parts):
    """An OBJ file of parts {material: [surfaces]}, quads, one object."""
    lines, first = ["mtllib none.mtl", "o garment"], 1
    for material, surfaces in parts.items():
        lines.append(f"g {material}\nusemtl {material}")
        for points, uv in surfaces:
            rows, columns = points.shape[:2]
            lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in points.reshape(-1, 3)]
            lines += [f"vt {u:.5f} {v:.5f}" for u, v in uv.reshape(-1, 2)]
            n = first + np.arange(rows * columns).reshape(rows, columns)
            for a, b, c, d in np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], -1).reshape(-1, 4):
                lines.append(f"f {a}/{a} {b}/{b} {c}/{c} {d}/{d}")
            first += rows * columns
    path.write_text("\n".join(lines) + "\n")


def dress():
    """Bodice, belt, skirt, hem and straps."""
    angle = np.linspace(-0.5, 0.5, 12)[:, None]
    straps = []
    for side in (-1, 1):
        t = np.linspace(0.0, np.pi, 40)[None]
        x = 8.5 * side + 2.0 * angle * np.cos(0 * t)
        points = np.stack(np.broadcast_arrays(x, 139.0 + 4.2 * np.sin(t), 8.8 * np.cos(t)), -1)
        straps.append((points, 0.02 * np.stack(np.broadcast_arrays(t * 6.0, angle), -1)))
    return {
        "Bodice": [tube(109.0, 138.0, 0.7)],
        "Belt": [tube(104.6, 109.4, 1.6, rows=12)],
        "Skirt": [tube(58.0, 106.0, 1.0, 17.0, (11, 2.4), rows=70, columns=420)],
        "Hem": [tube(58.0, 106.0, 0.2, 17.0, (11, 2.4), rows=22, columns=420, part=(0.9, 1.14))],  # under the skirt
        "Straps": straps,
    }


def coat():
    """Body, sleeves, cuffs, collar, lining and belt."""
    front = 0.5
    x, z = (
        tube(62.0, 146.0, 2.6, 7.0, (5, 1.3), front, 110, 320),
        tube(62.5, 145.5, 1.9, 6.8, (5, 1.3), front, 110, 320),
    )
    return {
        "Shell": [x],
        "Lining": [z],
        "Sleeves": [arm(side, 56.0, 5.9, rows=70) for side in (-1, 1)],
        "Cuffs": [arm(side, 56.0, 5.9, 0.6, 0.86, 12) for side in (-1, 1)],
        "Collar": [tube(142.5, 149.0, 3.4, 1.6, (0, 0.0), front, 16)],
        "Belt": [tube(103.5, 108.5, 6.6, 0.0, (0, 0.0), 0.0, 10)],
    }


def prints(folder):
    """A print of dots and one of leaves, and a lattice of holes."""
    y, x = np.mgrid[0:256, 0:256] / 256.0
    dots = np.hypot((x % 0.5) - 0.25, (y % 0.5) - 0.25) < 0.12
    rose = np.where(dots[..., None], (200, 40, 60), (250, 246, 238)).astype(np.uint8)
    Image.fromarray(rose).save(folder / "dots.png")
    holes = np.hypot((x % 0.25) - 0.125, (y % 0.25) - 0.125) < 0.07
    Image.fromarray(np.where(holes, 0, 255).astype(np.uint8)).save(folder / "lace.png")


COMMANDS = (
    "dress.obj --fabric poplin --fabric Bodice=linen --fabric Belt=velvet_ruby --fabric Hem=lace --fabric Straps=taffeta"
    " --print Skirt=dots.png --print-repeat 0.12 --print-unit m --opacity Hem=lace.png --opacity-repeat 0.04 --opacity-unit m",
    "coat.obj --fabric herringbone_tweed --fabric Lining=silk_shot --fabric Cuffs=velvet_midnight --fabric Collar=velvet_midnight"
    " --fabric Belt=satin_charmeuse_front",
)


# Framed whole, with smooth edges; before a photographed environment (--env FILE, a bright one with --exposure -1) the ground
# shows its shadow alone.
QUALITY = "--spp 4 --size 480x640 --view-transform neutral"
LOOK = f"--object form --ground catcher --eye 1.3,1.25,3.1 --target 0,0.81,0 --fov 30 {QUALITY}"
STUDIO = "--object backdrop@0,0,0,1,21 --ground 0 --ground-color 0.38,0.39,0.41 --env-rotate 25"
SKIRT = f"--object form@0,-0.876,0.01 --ground catcher --eye 1.3,0.4,3.1 --target 0,-0.07,0 --fov 30 {QUALITY}"


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / "dress.obj", dress())
    write(folder / "coat.obj", coat())
    prints(folder)
    for command in COMMANDS:
        name = command.split(".")[0]
        print(f"glcloth render -o {name}.png --mesh {command} --units cm {LOOK}")
        print(f"glcloth render -o {name}_studio.png --mesh {command} --units cm {LOOK} {STUDIO}")
    print(f"glcloth render -o skirt_mh.png --mesh skirt_mh.obj --units dm --subdivide 2 --fabric tartan {SKIRT}")


if __name__ == "__main__":
    main(sys.argv[1])

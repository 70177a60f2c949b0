"""What threads near by do to the picture: does the mean stay that of the far cloth, from every side and at every distance?

python tests/measure/weave.py [means zoom cost pictures edges] [--fabrics denim_raw,tartan] [--rounds 9] [--sheet threads.jpg]

means: whole repeats under the studio, near over far - 1 in %, by angle of view: with weights and occlusion alone, with roll,
with relief; so at 0.28, 0.5 and 1 yarn a pixel; and with irregular yarns over 300 of them. zoom: a plane seen at 35 degrees, a
width of 1 cm to 3 m in steps of 3 %: the largest step of the mean, its largest deviation, and the deviation of means of 16 x 16
pixels (moire). cost: CPU time of a frame 4 cm wide, with threads over without, and by the adaptive rate. pictures: a sheet of
the built-in cloth, 30 cm, 4 cm and 1.2 cm of each, two fabrics a row. edges: a sheet of the built-in cloth's outline, 4 cm and
1.2 cm of each, and what hairs cost.
"""

import statistics

import common
import numpy as np
from PIL import Image

import glcloth
from glcloth.color import luminance, srgb_encode
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.methods.weave_maps import repeat_of
from glcloth.picture.sheet import FAR_EVENED, NEAR_EVENED, evened, white_balance

FABRICS = ["linen_heavy", "denim_raw", "duchesse_satin", "charmeuse", "silk_shot", "houndstooth", "poplin", "tartan"]
THETAS = (5, 25, 40, 60, 70, 82)
EVEN = {"shift": 0.0, "yarn": 0.0, "fibre": 0.0}
STEP = 1.03
BRIGHTEST = 0.35  # mean of a picture of an outline: a satin may mirror the lamp
GROUND = 0.06  # linear, behind the built-in cloth


def woven(fabric, even=True, **changes):
    loose = fabric.weave.irregularity
    return fabric.changed(
        weave=fabric.weave.changed(irregularity=loose.changed(**EVEN) if even else loose, fuzz=0.0, **changes)
    )


def sheet(width, height):
    corners = np.array([[-width, -height, 0], [width, -height, 0], [width, height, 0], [-width, height, 0]]) / 2
    return build_mesh("sheet", corners, np.array([[0, 1, 2], [0, 2, 3]]), corners[:, :2], None)


def view(theta_deg, phi_deg, width, aspect=1.0, away=20.0):
    """A camera that sees `width` metres of the plane z = 0 across the picture, nearly in parallel."""
    theta, phi = np.radians([theta_deg, phi_deg])
    toward = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    fov = float(np.degrees(2 * np.arctan(0.5 / away / aspect)))
    return Camera(tuple(away * width * toward), (0.0, 0.0, 0.0), (0.0, 1.0, 0.1), fov)


def ratio(renderer, fabric, **look):
    """Mean of the picture with threads over that of the picture without, - 1 in %."""
    look = {"fabric": fabric, "shadows": "off", "background": False, **look}
    near, far = (luminance(renderer.render(threads=t, **look)[..., :3].astype(float)).mean() for t in (True, False))
    return 100 * (near / far - 1)


def means(renderer, names):
    common.head("fabric", "", *(f"{theta}" for theta in THETAS))
    for name in names:
        fabric = glcloth.load_fabric(name)
        repeat, yarn = repeat_of(fabric), 0.01 / max(fabric.weave.ends_per_cm, fabric.weave.picks_per_cm)

        def over(fabric, side, pixels, repeat=repeat):
            w, h = (r * max(round(side / r), 1) for r in repeat)
            mesh, wide = sheet(w, h), 1.5 * max(w, h)
            size = (min(round(1.5 * max(w, h) / pixels), 400),) * 2
            return [
                ratio(renderer, fabric, mesh=mesh, camera=view(t, 20 + 50 * i, wide), size=size)
                for i, t in enumerate(THETAS)
            ]

        flat = woven(fabric, relief=0.0)
        common.row(name, "weights, occlusion", *over(woven(flat, roll=0.0), 40 * yarn, yarn / 8))
        common.row("", "and roll", *over(flat, 40 * yarn, yarn / 8))
        common.row("", "and relief", *over(woven(fabric), 40 * yarn, yarn / 8))
        for share in (0.28, 0.5, 1.0):
            common.row("", f"{share} yarns a pixel", *over(woven(fabric), 300 * share * yarn, share * yarn))
        common.row("", "irregular yarns", *over(fabric, 300 * yarn, yarn / 2))


def zoom(renderer, names):
    window = np.outer(*(np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in (144, 192)))
    common.head("fabric", "largest step", "deviation above 4 cm", "below 4 cm", "moire, mean", "moire, most")
    for name in names:
        fabric = woven(glcloth.load_fabric(name))
        width, mesh, found = 0.01, sheet(30.0, 30.0), []
        look = {"fabric": fabric, "mesh": mesh, "size": (192, 144), "shadows": "off", "background": False}
        while width < 3.0:
            camera = view(35, 70, width, 4 / 3)
            near, far = (luminance(renderer.render(threads=t, camera=camera, **look)[..., :3]) for t in (True, False))
            blocks = (near / far).reshape(9, 16, 12, 16).mean((1, 3))
            found.append(
                (width, (near * window).sum() / (far * window).sum() - 1, 0.0 if width < 0.08 else blocks.std())
            )
            width *= STEP
        widths, mean, moire = 100 * np.array(found).T
        steps, close = np.abs(np.diff(mean)), widths < 4
        common.row(
            name, float(steps[~close[1:]].max()), float(np.abs(mean[~close]).max()), float(np.abs(mean[close]).max()),
            float(moire[moire > 0].mean()) if moire.any() else 0.0, float(moire.max()),
        )  # fmt: skip


def cost(renderer, names, rounds):
    common.head("fabric", "threads / none", "with threads: full / adaptive rate")
    ways = {"far": (False, False), "near": (True, False), "adaptive": (True, True)}
    for name in names:
        look = {"fabric": name, "mesh": sheet(0.2, 0.2), "camera": view(25, 60, 0.02, 4 / 3), "size": (320, 240)}
        frames = {
            way: renderer.prepare(threads=threads, adaptive=adaptive, shadows="off", **look)
            for way, (threads, adaptive) in ways.items()
        }
        times = {way: [] for way in ways}
        for number in range(rounds + 1):
            for way, frame in frames.items():
                renderer.draw(frame)
                spent = common.spent(renderer, lambda frame=frame: renderer.draw(frame))[1]
                if number:
                    times[way].append(spent)
        # The machine's other work makes some rounds slow, and none fast.
        far, near, adaptive = (statistics.mean(sorted(t)[: max(len(t) // 3, 1)]) for t in times.values())
        common.row(name, near / far, near / adaptive)


def pictures(renderer, names, path):
    white = white_balance(glcloth.load_environment("studio"), (0.0, 0.0, 1.0))
    cells = []
    for name in names:
        look = {"fabric": name, "size": (320, 240), "spp": 4, "background": False}
        worn = np.asarray(renderer.render(mesh="drape", **look))
        cover, cloth = worn[..., 3:], worn[..., :3] * white
        mean = float(luminance(cloth).sum() / cover.sum())
        cells.append(evened(cloth, mean, FAR_EVENED) + (1.0 - cover) * GROUND)
        for width in (0.3, 0.04, 0.012):
            flat = {"mesh": sheet(1.0, 1.0), "camera": view(38, 65, width, 4 / 3), "shadows": "off"}
            near = np.asarray(renderer.render(**flat, **look))[..., :3] * white
            cells.append(evened(near, float(luminance(near).mean()), NEAR_EVENED))
    lines = [np.concatenate(cells[i : i + 8], 1) for i in range(0, len(cells) // 8 * 8, 8)]
    codes = np.round(255 * srgb_encode(np.concatenate(lines).clip(0.0, 1.0))).astype("u1")
    Image.fromarray(codes).resize((codes.shape[1] * 5 // 8, codes.shape[0] * 5 // 8)).save(path, quality=78)


def edge_view(width, aspect):
    """A camera that sees the outline of a fold of the built-in cloth."""
    p = glcloth.load_mesh("drape").positions
    target = p[np.argmax(p[:, 1] - 0.3 * np.abs(p[:, 0]))]
    fov = float(np.degrees(2 * np.arctan(0.5 * width / aspect / 0.5)))
    return Camera(tuple(np.add(target, (0.0, 0.01, 0.5))), tuple(target), (0.0, 1.0, 0.0), max(fov, 1.0))


def edges(renderer, names, path, rounds):
    common.head("fabric", "hairs", "frame with / without, 4 cm", "1.2 cm")
    columns = []
    for name in names:
        cells, times, count = [], [], 0
        for width in (0.04, 0.012):
            look = {"fabric": name, "mesh": "drape", "camera": edge_view(width, 4 / 3), "exposure": 0.3}
            picture = np.asarray(renderer.render(size=(320, 240), spp=4, **look))[..., :3]
            cells.append(picture * min(1.0, BRIGHTEST / float(picture.mean())))
            bald = glcloth.load_fabric(name)
            bald = bald.changed(weave=bald.weave.changed(fuzz=0.0))
            frames = [renderer.prepare(size=(640, 480), **{**look, "fabric": f}) for f in (name, bald)]
            spent = [[], []]
            for _ in range(rounds):
                for frame, own in zip(frames, spent, strict=True):
                    renderer.draw(frame)
                    own.append(common.spent(renderer, lambda frame=frame: renderer.draw(frame))[1])
            times.append(min(spent[0]) / min(spent[1]))
            count = count or len(renderer.stage.cloths[0].fuzz.last or ())
        columns.append(np.concatenate(cells))
        common.row(name, str(count), *times)
    codes = np.round(255 * srgb_encode(np.concatenate(columns, 1).clip(0.0, 1.0))).astype("u1")
    Image.fromarray(codes).save(path, quality=85)


def main():
    options = common.options(__doc__, ["means", "zoom", "cost"], fabrics=FABRICS, rounds=9, sheet="threads.jpg")
    with glcloth.Renderer() as renderer:
        for what in options.environments:
            {
                "means": means, "zoom": zoom, "cost": lambda r, n: cost(r, n, options.rounds),
                "pictures": lambda r, n: pictures(r, n, options.sheet),
                "edges": lambda r, n: edges(r, n, options.sheet, options.rounds),
            }[what](renderer, options.fabrics)  # fmt: skip


if __name__ == "__main__":
    main()

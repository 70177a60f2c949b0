"""Fabrics for other renderers: files that others read, models that are what they say, errors that are measured."""

import ast
import io
import json
import os
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.optimize import least_squares
from test_doors import ROOT, fails, run

from glcloth.color import srgb_decode
from glcloth.export import files, mitsuba_files, models, original
from glcloth.export.maps import make_textures
from glcloth.export.mitsuba_bsdf import register
from glcloth.export.mitsuba_response import MissingMitsubaError
from glcloth.export.plain import numbers_of
from glcloth.fabric import load_fabric


@pytest.fixture
def few(monkeypatch):
    """Fits and errors over few pairs: what is tested is that they are right, not how good the fit is."""
    monkeypatch.setattr(models, "PAIRS", 250)
    monkeypatch.setattr(original.errors, "__defaults__", (300, 4))


@pytest.fixture
def rough(few, monkeypatch):
    """Fits that stop early: what is tested is what is made of them."""
    monkeypatch.setattr(models, "least_squares", lambda *a, **k: least_squares(*a, **(k | {"max_nfev": 3})))


def picture(data):
    return np.asarray(Image.open(io.BytesIO(data)))


def test_a_picture_shows_the_original_beside_the_export_on_a_ball(monkeypatch):
    """The left half is the cloth, the right one what is given: here half of it; corners are black, the ball goes to its rim."""
    monkeypatch.setattr(original, "NODES", 24)
    linen, side = load_fabric("linen"), 64
    cloth = original.response(linen)
    picture = original.sphere_pictures(lambda i, o: 0.5 * cloth(i, o), linen, side)
    left, right = picture[:, :side], picture[:, side:]
    assert picture.shape == (side, 2 * side, 3) and np.allclose(right, 0.5 * left)
    assert (left[side // 2, 2:-2] > 0).all() and not left[:8, :8].any()


def test_maps_are_one_repeat_whose_mean_is_the_far_cloth(rough, tmp_path, capsys):
    assert run("export", "houndstooth", "-o", tmp_path / "a.zip", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert 0 < said["studio_mean"] < said["studio_p95"]
    archive = zipfile.ZipFile(tmp_path / "a.zip")
    about = json.loads(archive.read("about.json"))
    maps = {name[:-4]: picture(archive.read(name)) for name in archive.namelist() if name.endswith(".png")}
    assert sorted(maps) == ["albedo", "height", "normal", "opacity", "roughness", "weights"]
    base = [about["material"][f"base_{c}"] for c in "rgb"]
    assert np.allclose(srgb_decode(maps["albedo"] / 255.0).mean((0, 1)), base, rtol=0.05, atol=2e-3)
    # Four dark and four light threads each way, in a 2/2 twill: both colours, and the same again at the other edge.
    assert len({tuple(c // 16) for c in maps["albedo"].reshape(-1, 3)}) > 3
    assert about["size_m"] == pytest.approx([8 * 0.01 / load_fabric("houndstooth").weave.picks_per_cm] * 2, rel=0.3)
    tangents = np.load(io.BytesIO(archive.read("tangents.npz")))
    assert np.allclose(tangents["rel"].astype(float).mean((1, 2)), 1.0, atol=2e-3)
    normal = maps["normal"].astype(float) / 127.5 - 1.0
    assert np.allclose(np.linalg.norm(normal, axis=-1), 1.0, atol=0.02)


def test_normals_lean_where_the_yarns_go():
    """A weft that dives toward +v leans to +v at its upper end (the top rows are large v), the warp to +u at its right."""
    fabric = load_fabric("denim_raw")
    t = make_textures(fabric, (0.1, 0.1, 0.1), 0.5)
    v = np.linspace(1, 0, len(t.height))[:, None] * np.ones(t.height.shape)
    up = np.gradient(t.height, axis=0) < 0  # rows go down, so height falls toward smaller v: rises toward +v
    weft, smooth = t.share[..., 1] > t.share[..., 0], np.abs(np.gradient(t.height, axis=0)) > 1e-7
    leaning = np.where(up, -t.normal[..., 1], t.normal[..., 1])[weft & smooth]
    assert (leaning > 0).mean() > 0.8 and v.shape == t.height.shape


def test_glb_is_read_by_others(rough, tmp_path):
    assert run("export", "lace", "-o", tmp_path / "a.glb") == 0
    data = (tmp_path / "a.glb").read_bytes()
    magic, version, total, length, kind = struct.unpack("<4sIII4s", data[:20])
    assert (magic, version, total, kind) == (b"glTF", 2, len(data), b"JSON") and length % 4 == 0
    document = json.loads(data[20 : 20 + length])
    material = document["materials"][0]
    assert set(material["extensions"]) == set(document["extensionsUsed"]) and material["alphaMode"] == "MASK"
    stretched, through = (
        material["extensions"][f"KHR_materials_{name}"] for name in ("anisotropy", "diffuse_transmission")
    )
    assert 0 <= stretched["anisotropyStrength"] <= 1 and through["diffuseTransmissionFactor"] <= 1
    assert max(through["diffuseTransmissionColorFactor"]) == pytest.approx(1)
    # Blender takes the UVs' tangent only where there is such a texture; without one the cloth is black there.
    image = document["images"][document["textures"][stretched["anisotropyTexture"]["index"]]["source"]]
    view = document["bufferViews"][image["bufferView"]]
    direction = picture(data[28 + length + view["byteOffset"] :][: view["byteLength"]])
    assert (direction == (255, 128, 255)).all()
    assert all(view["byteOffset"] % 4 == 0 for view in document["bufferViews"])
    (mesh,) = trimesh.load(tmp_path / "a.glb").geometry.values()
    assert np.allclose(mesh.extents, [0.2, 0.2, 0.0]) and mesh.visual.material.baseColorTexture.mode == "RGBA"
    # A repeat of the texture is a repeat of the cloth.
    size = make_textures(load_fabric("lace"), (0.1,) * 3, 0.5).size
    assert np.allclose(np.ptp(mesh.visual.uv, 0), 0.2 / np.array(size), rtol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["silk_shot", "houndstooth"])
def test_blender_opens_and_renders_a_glb(name, tmp_path):
    """Under a white sky it is as bright as the fit. BLENDER_PYTHON names a Python that has bpy, if this one has not."""
    python = os.environ.get("BLENDER_PYTHON", sys.executable)
    if subprocess.run([python, "-c", "import bpy"], capture_output=True).returncode:
        pytest.skip("needs Blender: pip install 'glcloth[blender]'")
    fabric = load_fabric(name)
    files.export(fabric, tmp_path / "a.glb")
    command = [python, Path(__file__).with_name("blender_render.py"), tmp_path / "a.glb"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout.splitlines()[-1])
    assert np.allclose(sorted(found["size"]), [0, 0.2, 0.2]) and {"Normal", "Tangent", "Anisotropic"} <= {
        *found["linked"]
    }
    lights = original.hemisphere(20_000, 3)
    fit = models.fit_gltf(fabric)
    share = 2 * np.pi * (1 - original.LOWEST)
    mean = fit.model(lights, np.broadcast_to([0.0, 0.0, 1.0], lights.shape)).mean(0) * share
    held = make_textures(fabric, fit.color("base"), fit.values["roughness"]).opacity.mean()
    assert np.allclose(found["mean"], held * mean + 1 - held, rtol=0.2)


def test_materialx_finds_no_fault(rough, tmp_path):
    import MaterialX as mx  # noqa: N813

    assert run("export", "denim_raw", "-o", tmp_path / "a.mtlx") == 0
    document, library = mx.createDocument(), mx.createDocument()
    mx.readFromXmlFile(document, str(tmp_path / "a.mtlx"))
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    document.importLibrary(library)
    assert document.validate() == (True, "")
    for image in document.getNodes("image"):
        assert (tmp_path / image.getInputValue("file")).is_file()


def u3m_images(node):
    """Every image in a U3M document."""
    if isinstance(node, dict):
        if {"path", "dpi"} <= set(node):
            yield node
        for value in node.values():
            yield from u3m_images(value)


U3M_FRONT = (
    "alpha anisotropy_value anisotropy_rotation clearcoat_value clearcoat_normal clearcoat_roughness ior metalness normal "
    "displacement roughness sheen_value sheen_tint specular_value specular_tint subsurface_radius subsurface_value "
    "transmission basecolor subsurface_color shader preview"
)


def test_u3m_says_sizes_and_means_of_its_maps(rough, tmp_path):
    assert run("export", "denim_raw", "-o", tmp_path / "my $ jeans.u3m") == 0
    document = json.loads((tmp_path / "my $ jeans.u3m").read_text())
    material = document["material"]
    assert document["schema"] == "1.1" and material["id"][14] == "4" and material["id"][19] in "89ab"
    assert sorted(material["front"]) == sorted(U3M_FRONT.split())
    assert material["physics"]["construction"] == {"type": "Twill", "name": None}
    images = list(u3m_images(document))
    assert len(images) == 5
    for image in images:
        assert "$" not in image["path"] and " " not in image["path"]
        map_ = Image.open(tmp_path / image["path"])
        assert map_.mode == "RGB"
        assert image["width"] / 25.4 * image["dpi"]["x"] == pytest.approx(map_.width)
        assert image["height"] / 25.4 * image["dpi"]["y"] == pytest.approx(map_.height)
    front = material["front"]
    for name in ("roughness", "alpha", "displacement"):
        part = front[name]
        mean = picture((tmp_path / part["texture"]["image"]["path"]).read_bytes()).mean() / 255
        mean = part["texture"]["offset"] + part["texture"]["factor"] * mean
        assert mean == pytest.approx(part["constant"], abs=0.01)
    color = picture((tmp_path / front["basecolor"]["texture"]["image"]["path"]).read_bytes()) / 255
    constant = [front["basecolor"]["constant"][c] for c in "rgb"]
    assert np.allclose(srgb_decode(color).mean((0, 1)), srgb_decode(np.array(constant)), rtol=0.05, atol=2e-3)
    # A repeat of a 3/1 twill: four picks along u, which follows the warp, and four ends along v, as their setts say.
    size = images[0]["width"], images[0]["height"]
    assert size == pytest.approx((40 / 17.3, 40 / 26), rel=1e-3)


def test_u3ma_is_the_archive_that_the_format_wants(rough, tmp_path):
    bare = tmp_path / "bare.toml"  # shows no threads, so it has no maps
    bare.write_text((ROOT / "glcloth/fabrics/velvet.toml").read_text().split("[weave]")[0])
    assert run("export", "lace", "-o", tmp_path / "a.u3ma") == run("export", bare, "-o", tmp_path / "b.u3ma") == 0
    for name, maps in (("a", 5), ("b", 0)):
        archive = zipfile.ZipFile(tmp_path / f"{name}.u3ma")
        assert archive.testzip() is None and len(archive.infolist()) == maps + 1
        for item in archive.infolist():
            assert (item.create_system, item.flag_bits, item.external_attr, item.extra) == (0, 1 << 11, 0, b"")
            assert item.extract_version == 0x14
        images = list(u3m_images(json.loads(archive.read(f"{name}.u3m"))))
        assert len(images) == maps and {i["path"] for i in images} < set(archive.namelist())


def test_the_principled_model_is_reciprocal():
    p = np.array([0.4, 0.2, 0.1, 0.7, 0.5, 0.3, 0.8, 0.6, 0.4])
    i, o = original.hemisphere(400, 1), original.hemisphere(400, 2)
    assert np.allclose(models.principled(p, i, o) / i[:, 2:], models.principled(p, o, i) / o[:, 2:])
    # Without lobe and sheen, seen and lit from above, it is Lambertian but for the retroreflection: f_90 = 0.5 + 2 r.
    up = np.array([[0.0, 0.0, 1.0]])
    p[3] = p[7] = 0.0
    assert np.allclose(models.principled(p, up, up), p[:3] / np.pi)


def test_errors_are_measured(few):
    fabric = load_fabric("linen")
    truth = original.response(fabric)
    none, tenth = original.errors(truth, fabric), original.errors(lambda i, o: 1.1 * truth(i, o), fabric)
    assert none.sun == none.studio == (0.0, 0.0)
    assert tenth.sun[0] == pytest.approx(10.0) and tenth.studio[0] == pytest.approx(10.0)
    satin = load_fabric("satin_charmeuse_front")
    mean = original.response(satin)(original.hemisphere(300, 1), original.hemisphere(300, 2)).mean()
    grey = original.errors(lambda i, o: 2 * mean * i[..., 2:] + 0 * i, satin)
    for fit in (models.fit_gltf, models.fit_openpbr, models.fit_principled):
        assert original.errors(fit(satin).model, satin).sun[0] < 0.9 * grey.sun[0]


@pytest.mark.parametrize(("model", "count"), [(models.gltf, 12), (models.openpbr, 9)])
def test_models_are_reciprocal_and_keep_energy(model, count):
    p = np.array([0.0] * 3 + [25.0 if count == 12 else 1.0] * 3 + [0.3, 0.3] + [0.0] * 3 + [0.5])[:count]
    if count == 9:
        p[8] = 3.0
    i, o = original.hemisphere(400, 1), original.hemisphere(400, 2)
    assert np.allclose(model(p, i, o) / i[:, 2:], model(p, o, i) / o[:, 2:])
    view = np.array([0.3, 0.2, np.sqrt(0.87)])
    lights = original.hemisphere(40_000, 3)
    albedo = model(p, lights, np.broadcast_to(view, lights.shape)).mean(0) * 2 * np.pi * (1 - original.LOWEST)
    assert np.all(albedo < 1.01) and albedo[0] > (0.9 if count == 12 else 0.2)


@pytest.mark.parametrize("name", ["silk_shot", "linen", "velvet"])
def test_mitsubas_plugin_is_the_same_cloth(name):
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    register()
    fabric = load_fabric(name)
    plugin = mi.load_dict({"type": "microcylinder", "numbers": json.dumps(numbers_of(fabric))})
    i, o = original.hemisphere(25, 5), original.hemisphere(25, 6)
    truth = original.response(fabric)(i, o)
    ctx, si = mi.BSDFContext(), mi.SurfaceInteraction3f()
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    u = np.random.default_rng(7).random((25, 3))
    for k in range(25):
        si.wi = mi.Vector3f(o[k])
        assert np.allclose(plugin.eval(ctx, si, mi.Vector3f(i[k])), truth[k], rtol=1e-3, atol=1e-4 * truth.mean())
        sample, weight = plugin.sample(ctx, si, float(u[k, 0]), mi.Point2f(u[k, 1:]))
        if sample.pdf > 0:
            assert sample.pdf == pytest.approx(plugin.pdf(ctx, si, sample.wo), rel=1e-3)
            assert np.allclose(np.array(weight) * sample.pdf, plugin.eval(ctx, si, sample.wo), rtol=1e-3)
    # The density's integral is the share of samples that fall there.
    si.wi = mi.Vector3f(0, 0, 1)
    z = original.hemisphere(600, 8)
    total = np.mean([plugin.pdf(ctx, si, mi.Vector3f(w)) for w in z]) * 2 * np.pi * (1 - original.LOWEST)
    u = np.random.default_rng(9).random((600, 3))
    drawn = [plugin.sample(ctx, si, float(a), mi.Point2f(b, c))[0] for a, b, c in u]
    counted = [one.wo.z > original.LOWEST and one.pdf > 0 for one in drawn]
    assert total == pytest.approx(np.mean(counted), abs=0.06)
    # No sample counts where the cloth is black: upright fibres seen from the side show nothing to the other one.
    si.wi = mi.Vector3f(0.8 * np.sin(1.22), 0.6 * np.sin(1.22), np.cos(1.22))
    for w in [*z[:200], *(np.array(one.wo) for one in drawn[:200])]:
        assert (plugin.pdf(ctx, si, mi.Vector3f(w)) > 0) == np.any(np.array(plugin.eval(ctx, si, mi.Vector3f(w))) > 0)


def test_exports_for_mitsuba_and_wrong_names(few, tmp_path, capsys, monkeypatch):
    def nobody(*_):
        raise MissingMitsubaError("not measured here")

    monkeypatch.setattr(mitsuba_files, "by_mitsuba", nobody)  # its process takes seconds to start
    assert run("export", "linen", "-o", tmp_path / "linen.py", "--picture", tmp_path / "pair.png", "--json") == 0
    said = capsys.readouterr()
    assert "pair.png: is not written" in said.err and "not measured" in json.loads(said.out)["not_measured"]
    compile((tmp_path / "linen.py").read_text(), "linen.py", "exec")
    assert "glcloth" not in [
        line.split()[1] for line in (tmp_path / "linen.py").read_text().splitlines() if line[:7] == "import "
    ]
    assert "expected a name that ends in" in fails(capsys, "export", "linen", "-o", tmp_path / "a.obj")
    assert "linen" in fails(capsys, "export", "linnen", "-o", tmp_path / "a.zip")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["linen.py"]


@pytest.mark.parametrize("end", ["\n", "\r"])
def test_a_fabrics_name_is_no_code(tmp_path, end):
    fabric = load_fabric("linen").changed(name=f"linen{end}raise SystemExit{end}# x")
    mitsuba_files.write_mitsuba_py(fabric, tmp_path / "a.py")
    tree = ast.parse((tmp_path / "a.py").read_bytes())
    assert not any(isinstance(node, ast.Raise) for node in tree.body)

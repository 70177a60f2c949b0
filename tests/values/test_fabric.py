"""Fabrics: sampling of tangent curves, the weights of both normalisations, files, edits."""

import re

import numpy as np
import pytest

from glcloth.errors import InputError
from glcloth.fabric import FABRICS, Yarn, builtin_fabrics, load_fabric, save_fabric
from glcloth.twins.cloth import f_cloth
from glcloth.twins.sheet import absorption

SIX = ("linen", "silk_crepe_de_chine", "satin_charmeuse_front", "satin_charmeuse_back", "silk_shot", "velvet")


def yarn(**changes):
    values = dict(albedo=(0.1, 0.1, 0.1), eta=1.4, k_d=0.2, gamma_s_deg=5, gamma_v_deg=10, area=0.5)
    return Yarn(**{**values, **changes})


def test_the_six_of_the_table_are_built_in():
    assert set(SIX) <= set(builtin_fabrics())


@pytest.mark.parametrize("name", builtin_fabrics())
def test_files_round_trip(name, tmp_path):
    fabric = load_fabric(name)
    save_fabric(tmp_path / "copy.toml", fabric)
    assert load_fabric(tmp_path / "copy.toml") == fabric


def test_curves_are_sampled_equally_ends_included():
    """Silk's first yarn: -35, -35, 0, 35, 35, the five tangents of paper A's figure 8."""
    assert load_fabric("silk_crepe_de_chine").yarn[0].tilts_deg == (-35, -35, 0, 35, 35)
    line = yarn(curve_angles_deg=(-30, 30), curve_lengths=(2,), samples=4)
    assert line.tilts_deg == pytest.approx((-30, -10, 10, 30))
    assert yarn(curve_angles_deg=(-30, 10), curve_lengths=(2,), samples=1).tilts_deg == pytest.approx((-10,))


def test_a_length_of_zero_is_a_jump():
    jump = yarn(curve_angles_deg=(-90, -60, 60, 90), curve_lengths=(1, 0, 1), samples=5)
    assert jump.tilts_deg == pytest.approx((-90, -75, -60, 75, 90))


def test_equal_tangents_are_merged_with_their_count():
    tangents = load_fabric("silk_crepe_de_chine").tangents
    assert [(t.yarn, round(np.degrees(t.tilt)), t.count) for t in tangents] == [
        (0, -35, 2),
        (0, 0, 1),
        (0, 35, 2),
        (1, 0, 1),
    ]


@pytest.mark.parametrize("name", SIX)
def test_weights_of_both_normalisations(name):
    fabric = load_fabric(name)
    areas = [y.area for y in fabric.yarn]
    assert fabric.weights[:, 0].sum() == pytest.approx(sum(areas)) and fabric.gap == pytest.approx(1 - sum(areas))
    assert np.array_equal(fabric.weights[:, 0], fabric.weights[:, 1])
    paper = fabric.changed(normalization="paper")
    counts = [t.count for t in fabric.tangents]
    assert paper.gap == 0 and np.allclose(paper.weights[:, 1], counts)
    assert np.allclose(paper.weights[:, 0], [areas[t.yarn] * t.count for t in fabric.tangents])


def test_an_edit_derives_everything_anew():
    """What was computed for the old fabric must not live on in the new one."""
    fabric = load_fabric("linen")
    before = fabric.tangents, fabric.weights
    first, second = fabric.yarn
    edited = fabric.changed(yarn=(first.changed(curve_angles_deg=(-40, 40)), second))
    assert {round(np.degrees(t.tilt)) for t in edited.tangents} == {-40, 40, -25, 25}
    assert fabric.model_copy(update={"normalization": "paper"}).gap == 0
    assert (fabric.tangents, fabric.weights.tolist()) == (before[0], before[1].tolist())
    with pytest.raises(InputError, match="eta"):
        first.changed(eta=0.5)


def test_more_light_than_there_is_is_told_and_can_be_limited(tmp_path, capsys):
    """Against a Monte Carlo furnace in other directions."""
    text = (FABRICS / "satin_charmeuse_front.toml").read_text()
    white = re.sub(r"albedo = \[[^]]*\]", "albedo = [1, 1, 1]", text)
    (tmp_path / "white.toml").write_text(white)
    (tmp_path / "limited.toml").write_text('energy = "limit"\n' + white)
    given = load_fabric(tmp_path / "white.toml")
    said = capsys.readouterr().err
    assert f"gives back {given.largest_albedo:.2f} times" in said and said.count("\n") == 1
    limited = load_fabric(tmp_path / "limited.toml")
    assert not capsys.readouterr().err
    r = np.random.default_rng(7).normal(size=(6_000, 3))
    omega_i = r / np.linalg.norm(r, axis=1, keepdims=True)
    omega_i[:, 2] = np.abs(omega_i[:, 2])
    turns = np.radians([2, 47, 93, 133])
    views = [
        (np.sqrt(1 - z * z) * np.cos(a), np.sqrt(1 - z * z) * np.sin(a), z) for z in (0.1, 0.4, 1.0) for a in turns
    ]
    most = [
        max(2 * np.pi * f_cloth(omega_i, np.array(o), *f.arrays()).mean(0).max() for o in views)
        for f in (given, limited)
    ]
    assert most[0] == pytest.approx(given.largest_albedo, rel=0.08) and 0.9 < most[1] < 1.08
    built_in = load_fabric("satin_charmeuse_front")
    assert built_in.weights.tolist() == built_in._weights.tolist()


def test_a_colour_dyes_what_shines_through():
    """Reflection and light straight through are coloured alike, in place of the fabric's own colour, deeper at a slant."""
    linen = load_fabric("linen_curtain")
    color = np.array([0.8, 0.3, 0.05])
    white, dyed = linen.colored((1, 1, 1)), linen.colored(color)
    for before, after in zip(white.yarn, dyed.yarn, strict=True):
        assert np.ptp(before.albedo) == 0.0
        np.testing.assert_allclose(np.array(after.albedo) / before.albedo, color)
    t_0, t = white.transmission, dyed.transmission
    assert set(t_0.tau) == {min(linen.transmission.tau)} and t.rho == linen.transmission.rho
    for cos, power in ((1.0, 1.0), (0.5, 2.0)):
        out = np.array([0.0, np.sqrt(1 - cos**2), cos])
        ratio = absorption(out, out, np.array(t.tau)) / absorption(out, out, np.array(t_0.tau))
        np.testing.assert_allclose(ratio, color**power, rtol=1e-6)
    assert dyed.colored((0, 0, 0)).transmission.tau[0] < 8
    assert load_fabric("linen").colored((0.5, 0.5, 0.5)).transmission is None

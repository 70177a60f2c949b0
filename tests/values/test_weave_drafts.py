"""Drafts: what WIF files mean, 200 generated ones with planted errors, files that are no drafts, named weaves."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from glcloth.color import srgb_decode
from glcloth.errors import InputError
from glcloth.weave.draft import MAX_REPEAT, Draft, period
from glcloth.weave.named import WEAVES, named_draft, satin, twill
from glcloth.weave.plain import draft_of, plain_draft
from glcloth.weave.wif import MAX_BYTES, draft_text, load_draft, parse_draft, save_draft

# Beside the checkout, or beside the folder of its worktrees; the tests pass without them.
FILES = sorted(f for up in Path(__file__).resolve().parents[3:5] for f in up.glob("shared/assets/weaves/*.wif"))

TWILL = """[WIF]
Version=1.1
[WEAVING]
Shafts=4
Treadles=4
Rising Shed=true
[WARP]
Threads=8
Color=1
Spacing=0.05
Units=centimeters
[WEFT]
Threads=4
Color=2
Spacing=0.06
Units=centimeters
[COLOR PALETTE]
Range=0,255
[COLOR TABLE]
1=25,35,80
2=230,230,225
[THREADING]
1=1
2=2
3=3
4=4
5=1
6=2
7=3
8=4
[TIEUP]
1=1,2
2=2,3
3=3,4
4=4,1
[TREADLING]
1=1
2=2
3=3
4=4
"""
UP = np.array([[1, 1, 0, 0], [0, 1, 1, 0], [0, 0, 1, 1], [1, 0, 0, 1]], bool)


def one_line(error) -> bool:
    text = str(error.value)
    return 0 < len(text) <= 300 and text.isprintable()


def with_lines(section: str, *lines: str) -> str:
    """TWILL with more lines in a section; a key that is there already is said again, and the last one counts."""
    return TWILL + f"\n[{section}]\n" + "\n".join(lines) + "\n"


def without(section: str) -> str:
    blocks = TWILL.split("[")
    return "[".join(b for b in blocks if not b.startswith(f"{section}]"))


# -- meaning -------------------------------------------------------------------------------------------------------------


def test_a_twill_is_read():
    draft = parse_draft(TWILL)
    assert np.array_equal(draft.drawdown, np.tile(UP, (1, 2)))
    assert draft.structure == (4, 4) and draft.repeat == (4, 4) and draft.reduced().drawdown.shape == (4, 4)
    assert np.allclose(draft.warp_spacing, 0.05) and np.allclose(draft.weft_thickness, 0.06)
    assert np.allclose(draft.warp_colors, srgb_decode(np.array([25, 35, 80]) / 255))
    assert not draft.warnings and not draft.drawdown.flags.writeable


def test_a_lift_plan_says_the_same_as_tie_up_and_treadling():
    lift = "\n[LIFTPLAN]\n" + "\n".join(
        f"{y + 1}={','.join(str(s + 1) for s in np.flatnonzero(UP[y]))}" for y in range(4)
    )
    only = without("TIEUP").split("[TREADLING]")[0] + lift
    assert np.array_equal(parse_draft(only).drawdown, parse_draft(TWILL).drawdown)
    # Where a file holds both, tie-up and treadling count; half of them is none.
    both = TWILL + "\n[LIFTPLAN]\n1=1\n2=1\n3=1\n4=1\n"
    assert np.array_equal(parse_draft(both).drawdown, parse_draft(TWILL).drawdown)
    half = without("TIEUP") + "\n[LIFTPLAN]\n1=1\n2=1\n3=1\n4=1\n"
    assert parse_draft(half).drawdown[:, 0].all() and not parse_draft(half).drawdown[:, 1].any()


def test_sinking_sheds_are_the_complement():
    sinking = parse_draft(with_lines("WEAVING", "Rising Shed=off"))
    assert np.array_equal(sinking.drawdown, ~parse_draft(TWILL).drawdown)


@pytest.mark.parametrize("word, up", [("yes", 1), ("ON", 1), ("1", 1), ("No", 0), ("0 ; comment", 0), ("", 1)])
def test_words_for_true(word, up):
    drawdown = parse_draft(with_lines("WEAVING", f"Rising Shed={word}")).drawdown
    assert np.array_equal(drawdown, parse_draft(TWILL).drawdown) == bool(up)


def test_several_treadles_and_several_shafts_are_joined():
    draft = parse_draft(with_lines("TREADLING", "1=1,3"))
    assert draft.drawdown[0].all()
    draft = parse_draft(with_lines("THREADING", "1=1,3"))
    assert draft.drawdown[:, 0].tolist() == (UP[:, 0] | UP[:, 2]).tolist()


def test_a_treadle_without_tie_up_is_said():
    draft = parse_draft(with_lines("TREADLING", "2=77"))
    assert "treadle 77" in draft.warnings[0] and not draft.drawdown[1].any()


def test_spelling_is_free():
    text = (
        TWILL.replace("[THREADING]", "[Threading]  ; on the shafts")
        .replace("=", " = ")
        .replace("2 = 2,3", "2 = 2, 3 ;x")
    )
    text = text.replace("\n", "\r\n").replace("[WARP]", "[PRIVATE Somebody]\r\nx=100%\r\n[WARP]")
    assert parse_draft(text) == parse_draft(TWILL)


def test_what_is_beyond_the_draft_is_dropped():
    wide = parse_draft(with_lines("WARP", "Threads=1200"))
    assert wide.ends == 8 and "1192 ends" in wide.warnings[0]
    tall = parse_draft(with_lines("WEFT", "Threads=1200"))
    assert tall.picks == 4 and "1196 picks" in tall.warnings[0]


def test_an_end_on_no_shaft_stays_down_and_empty_means_none():
    draft = parse_draft(with_lines("THREADING", "3=0", "4="))
    assert not draft.drawdown[:, 2:4].any()
    assert not parse_draft(with_lines("TREADLING", "2=0")).drawdown[1].any()


def test_colours_scale_by_their_range():
    table = "1=99,139,317\n2=999,999,999"
    draft = parse_draft(TWILL.replace("Range=0,255", "Range=0,999").replace("1=25,35,80\n2=230,230,225", table))
    assert np.allclose(draft.warp_colors[0], srgb_decode(np.array([25, 35, 81]) / 255), atol=0.002)
    assert parse_draft(TWILL.replace("Range=0,255", "Range=255")).warp_colors == pytest.approx(
        parse_draft(TWILL).warp_colors
    )
    beyond = parse_draft(TWILL.replace("Range=0,255", "Range=0,99"))
    assert "beyond Range" in beyond.warnings[0] and beyond.weft_colors.max() == 1.0
    lost = parse_draft(with_lines("WARP COLORS", "2=7", "3=2,230,230,225"))
    assert "colour 7" in lost.warnings[0] and np.allclose(lost.warp_colors[2], lost.weft_colors[0])
    assert np.allclose(lost.warp_colors[1], lost.warp_colors[0])
    grey = parse_draft(with_lines("WARP", "Color=9"))
    assert "Color = 9" in grey.warnings[0] and np.allclose(grey.warp_colors, srgb_decode(np.array(204 / 255)))
    assert not parse_draft(without("COLOR TABLE")).has_colors


@pytest.mark.parametrize("unit, cm", [("inches", 2.54), ("Decipoints", 2.54 / 720), ("centimeters", 1.0), ("mm", 0.1)])
def test_lengths_have_units(unit, cm):
    draft = parse_draft(with_lines("WARP", f"Units={unit}", "Spacing=0.5"))
    assert draft.warp_spacing == pytest.approx(0.5 * cm) and draft.warp_thickness == pytest.approx(0.5 * cm)


def test_single_threads_have_their_own_lengths():
    draft = parse_draft(with_lines("WARP SPACING", "2=0.1", "3=") + "[WARP THICKNESS]\n4=0.02\n")
    assert draft.warp_spacing.tolist() == [0.05, 0.1, *[0.05] * 6] and draft.warp_thickness[3] == 0.02
    assert draft.structure == (4, 8)
    assert any("no cloth" in w for w in parse_draft(with_lines("WARP", "Spacing=9")).warnings)
    none = parse_draft(TWILL.replace("Spacing=0.05\n", "").replace("Spacing=0.06\n", ""))
    assert none.warp_spacing == pytest.approx(0.05) and "no spacing" in none.warnings[0]


def test_structure_and_colours_repeat_apart():
    colors = np.repeat([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], 3, 0)
    draft = Draft(np.tile(twill(2, 2), (3, 3)), warp_colors=np.tile(colors, (2, 1)), weft_colors=np.zeros((12, 3)))
    assert (draft.structure, draft.colors_repeat, draft.repeat) == ((4, 4), (1, 6), (4, 12))
    assert draft.reduced().drawdown.shape == (4, 12) and draft.reduced().repeat == (4, 12)


def test_periods():
    assert period(np.array([1, 2, 1, 2, 1])) == 5 and period(np.array([1, 2, 1, 2])) == 2 and period(np.zeros(7)) == 1


def test_flipped_reads_from_the_bottom():
    draft = parse_draft(TWILL)
    assert np.array_equal(draft.flipped().drawdown, draft.drawdown[::-1]) and draft.flipped().flipped() == draft


# -- errors ----------------------------------------------------------------------------------------------------------------

ERRORS = {
    "no WIF": (lambda rng: TWILL.replace("[WIF]", "[WOF]"), "no [WIF]"),
    "no threading": (lambda rng: without("THREADING"), "THREADING"),
    "empty threading": (lambda rng: without("THREADING") + "[THREADING]\n1=0\n", "THREADING"),
    "no sheds": (lambda rng: without("TREADLING"), "LIFTPLAN"),
    "shaft too high": (lambda rng: with_lines("THREADING", f"{rng.integers(1, 9)}={rng.integers(5, 99)}"), "expected 1 to 4"),
    "lift too high": (lambda rng: with_lines("TIEUP", f"2={rng.integers(5, 99)}"), "expected 1 to 4"),
    "word for shaft": (lambda rng: with_lines("THREADING", f"{rng.integers(1, 9)}=two"), "whole numbers"),
    "negative treadle": (lambda rng: with_lines("TREADLING", f"2=-{rng.integers(1, 9)}"), "whole numbers"),
    "half a shaft": (lambda rng: with_lines("TIEUP", "2=1.5"), "whole numbers"),
    "huge number": (lambda rng: with_lines("TIEUP", "2=" + "9" * int(rng.integers(10, 4000))), "whole numbers"),
    "line 0": (lambda rng: with_lines("THREADING", "0=1"), "numbered from 1"),
    "line number without end": (lambda rng: with_lines("THREADING", "1" * int(rng.integers(10, 900)) + "=1"), "numbered"),
    "spacing": (lambda rng: with_lines("WARP", f"Spacing={rng.choice(['wide', '-1', 'nan', 'inf', '1e999'])}"), "length"),
    "thickness": (lambda rng: with_lines("WEFT THICKNESS", "2=thin"), "length"),
    "colour": (lambda rng: with_lines("COLOR TABLE", f"1={rng.choice(['1,2', 'red', '-1,2,3', '1,2,nan'])}"), "3 numbers"),
    "range": (lambda rng: with_lines("COLOR PALETTE", f"Range={rng.choice(['5,5', '9,1', 'x', '0'])}"), "Range"),
    "threads": (lambda rng: with_lines("WARP", "Threads=many"), "whole numbers"),
    "shed": (lambda rng: with_lines("WEAVING", "Rising Shed=maybe"), "true or false"),
    "far end": (lambda rng: with_lines("THREADING", f"{rng.integers(16385, 999_999_999)}=1"), "at most"),
    "colour index": (lambda rng: with_lines("WEFT COLORS", "3=blue"), "whole numbers"),
    "control characters": (lambda rng: with_lines("THREADING", "2=\x1b[31m\x07\u202e\x85" + "x" * 500), "whole numbers"),
    "not text": (lambda rng: TWILL + "\0", "no text"),
}  # fmt: skip


def generated(rng) -> tuple[str, np.ndarray]:
    """The text of a legal draft in some legal spelling, and its drawdown."""
    ends, picks, shafts = (int(n) for n in (rng.integers(1, 40), rng.integers(1, 40), rng.integers(1, 9)))
    shaft, rising = rng.integers(1, shafts + 1, ends), bool(rng.integers(2))
    treadles = int(rng.integers(1, 9))
    tieup = rng.random((treadles, shafts)) < 0.5
    pressed = [rng.choice(treadles, int(rng.integers(1, 3))) for _ in range(picks)]
    raised = np.array([tieup[p].any(0) for p in pressed])
    drawdown = raised[:, shaft - 1] == rising
    nl, eq = str(rng.choice(["\n", "\r\n"])), str(rng.choice(["=", " = ", "= "]))
    case = [str.upper, str.lower, str.title][rng.integers(3)]
    tail = str(rng.choice(["", " ; a comment", "  "]))

    def section(name, lines):
        return nl.join([f"[{case(name)}]", *(f"{k}{eq}{v}{tail}" for k, v in lines)]) + nl

    def numbers(values):
        return str(rng.choice([",", ", "])).join(str(int(v)) for v in values) or "0"

    parts = [
        section("weaving", [("Rising Shed", str(rising)), ("Shafts", shafts), ("Treadles", treadles)]),
        section("warp", [("Threads", ends), ("Spacing", f"{rng.uniform(0.01, 0.2):.4f}"), ("Units", "centimeters")]),
        section("weft", [("Threads", picks), ("Color", int(rng.integers(1, 4)))]),
        section("color palette", [("Range", str(rng.choice(["0,255", "0,999", "255"])))]),
        section("color table", [(i, ",".join(map(str, rng.integers(0, 256, 3)))) for i in (1, 2, 3)]),
        section("warp colors", [(i + 1, int(rng.integers(1, 4))) for i in range(ends) if rng.random() < 0.5]),
        section("threading", [(i + 1, int(s)) for i, s in enumerate(shaft)]),
        section("private other", [("x", "%(y)s 100%"), ("1", "anything")]),
    ]
    if rng.integers(2):
        parts.append(section("tieup", [(t + 1, numbers(np.flatnonzero(tieup[t]) + 1)) for t in range(treadles)]))
        parts.append(section("treadling", [(y + 1, numbers(p + 1)) for y, p in enumerate(pressed)]))
    else:
        parts.append(section("liftplan", [(y + 1, numbers(np.flatnonzero(r) + 1)) for y, r in enumerate(raised)]))
    order = rng.permutation(len(parts))
    return section("wif", [("Version", "1.1")]) + nl.join(parts[i] for i in order), drawdown


@pytest.mark.parametrize("seed", range(200))
def test_two_hundred_drafts(seed, tmp_path):
    """Every legal file gives its drawdown, every other one InputError of one printable line."""
    rng = np.random.default_rng(seed)
    path = tmp_path / "a draft.wif"
    if seed % 2:
        text, drawdown = generated(rng)
        path.write_text(text, encoding="utf-8-sig" if rng.integers(2) else "cp1252", newline="")
        draft = load_draft(path)
        assert np.array_equal(draft.drawdown, drawdown)
        save_draft(tmp_path / "copy.wif", draft)
        again = load_draft(tmp_path / "copy.wif")
        assert again.drawdown.shape == draft.drawdown.shape and np.array_equal(again.drawdown, draft.drawdown)
        assert draft_of(plain_draft(draft)) == draft
    else:
        make, expected = list(ERRORS.values())[seed // 2 % len(ERRORS)]
        path.write_text(make(rng), encoding="utf-8", newline="")
        with pytest.raises(InputError) as error:
            load_draft(path)
        assert one_line(error) and str(path)[:8] in str(error.value) and expected in str(error.value)


@pytest.mark.parametrize("seed", range(40))
def test_damaged_bytes_give_a_draft_or_one_line(seed, tmp_path):
    rng = np.random.default_rng(seed)
    data = bytearray(TWILL.encode())
    for _ in range(int(rng.integers(1, 30))):
        data[rng.integers(len(data))] = rng.integers(256)
    path = tmp_path / "damaged.wif"
    path.write_bytes(bytes(data[: rng.integers(1, len(data))] if seed % 3 == 0 else data))
    try:
        assert load_draft(path).drawdown.dtype == bool
    except InputError as error:
        assert len(str(error)) <= 300 and str(error).isprintable()


def test_files_that_are_no_drafts(tmp_path):
    big = tmp_path / "big.wif"
    big.write_bytes(b"[WIF]\n" + b";" * MAX_BYTES)
    (tmp_path / "empty.wif").touch()
    long = tmp_path / ("x" * 200) / ("y" * 200 + ".wif")
    for path in (big, tmp_path, tmp_path / "empty.wif", tmp_path / "missing.wif", long, tmp_path / "a\nb\x07.wif"):
        with pytest.raises(InputError) as error:
            load_draft(path)
        assert one_line(error)


def test_sizes_are_bounded_before_memory_is_taken():
    rng = np.random.default_rng(0)
    with pytest.raises(InputError, match="repeat"):
        Draft(rng.random((1200, 1200)) < 0.5)
    assert 1200 * 1200 > MAX_REPEAT
    assert Draft(np.tile(UP, (300, 300))).structure == (4, 4)
    shafts = "\n".join(f"{i}={i}" for i in range(1, 2000))
    with pytest.raises(InputError, match="1999 shafts"):
        parse_draft(f"[WIF]\n[THREADING]\n{shafts}\n[LIFTPLAN]\n1=1\n")


@pytest.mark.parametrize(
    "changes",
    [
        {"drawdown": np.zeros((0, 2), bool)},
        {"drawdown": np.zeros((2, 2))},
        {"warp_spacing": [1.0]},
        {"weft_thickness": [1.0, -1.0]},
        {"warp_colors": np.zeros((2, 3))},
        {"warp_colors": np.zeros((2, 3)), "weft_colors": np.full((2, 3), 2.0)},
    ],
)
def test_a_draft_is_checked(changes):
    with pytest.raises(InputError) as error:
        Draft(**{"drawdown": np.eye(2, dtype=bool), **changes})
    assert one_line(error)


# -- files and names ---------------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not FILES, reason="the shared drafts are not here")
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_the_shared_drafts(path, tmp_path):
    draft = load_draft(path)
    name = {"denim_twill_3_1": "twill_3_1", "shot_silk_plain": "plain"}.get(path.stem, path.stem)
    n = len(WEAVES[name]())
    assert draft.structure == (n, n) and not draft.warnings
    # The same weave may begin at another thread, or lean the other way.
    same = [
        np.roll(np.roll(w, i, 0), j, 1)
        for w in (WEAVES[name](), WEAVES[name]()[::-1])
        for i in range(n)
        for j in range(n)
    ]
    assert any(np.array_equal(draft.drawdown, w) for w in same)
    save_draft(tmp_path / "copy.wif", draft)
    assert load_draft(tmp_path / "copy.wif") == draft


@pytest.mark.parametrize("name", WEAVES)
def test_named_weaves_interlace_and_survive_their_file(name, tmp_path):
    draft = named_draft(name)
    # Every thread goes under and over.
    for up in (draft.drawdown, draft.drawdown.T):
        assert (up.any(0) & ~up.all(0)).all()
    assert draft.repeat == draft.drawdown.shape or name == "houndstooth"
    assert draft_of(plain_draft(draft)) == draft
    draft = replace(draft, cut=None, pile=False)  # a WIF cannot say what is cut out, nor that it is pile
    save_draft(tmp_path / "a.wif", draft)
    assert load_draft(tmp_path / "a.wif") == draft
    assert parse_draft(draft_text(draft)).drawdown.tolist() == draft.drawdown.tolist()


def test_twill_lines_climb_to_the_right():
    assert np.array_equal(np.roll(twill(3, 1), (1, -1), (0, 1)), twill(3, 1))


@pytest.mark.parametrize("n, step", [(5, 2), (8, 3)])
def test_satin_binds_each_thread_once_and_no_two_neighbours_touch(n, step):
    under = ~satin(n, step)
    assert (under.sum(0) == 1).all() and (under.sum(1) == 1).all()
    where = np.argmax(under, 0)
    assert (np.abs(np.diff(where)) > 1).all()


def test_an_unknown_weave_is_answered_with_the_nearest():
    with pytest.raises(InputError, match='did you mean "satin_5"') as error:
        named_draft("satin5")
    assert one_line(error)

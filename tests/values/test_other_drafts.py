"""Drafts of Fiberworks, WeavePoint and TempoWeave, made here by their formats; each damaged one is one line."""

import struct
import zipfile

import numpy as np
import pytest

from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.weave.named import named_draft
from glcloth.weave.wif import draft_text, load_draft

TWILL = named_draft("twill_2_2").drawdown

DTX = """@@StartDTX
@@Imprint
Fiberworks 4.2
@@Description
A twill
@@Info
%%ends 8
%%picks 8
%%shafts 4
%%treadles 4
@@Threading
1 2 3 4
1 2 3 4
@@Tieup
{tieup}
@@Treadling
1 2 3 4 1 2 3 4
@@Color Palet
200,10,10
20,20,20
@@Warp Colors
0 0 0 0 0 0 0 0
@@Weft Colors
1 1 1 1 1 1 1 1
@@EndDTX
"""


def dtx() -> bytes:
    """Rows of the tie-up are shafts, the first at the bottom; columns are treadles."""
    rows = ["".join(str(int(TWILL[treadle, shaft])) for treadle in range(4)) for shaft in range(4)]
    return DTX.format(tieup="\n".join(reversed(rows))).encode()


def wpo() -> bytes:
    """WeavePoint 7 with a tie-up and one treadle a pick; shaft 1 is bit 1 of a mask."""
    numbers = lambda *values: struct.pack(">H", len(values)) + bytes(values)  # noqa: E731
    head = bytes([123, 7, 101, 10, 4, 4, 0, 0, 0, 40, 20, 0, 0]) + struct.pack(">HH", 4, 4) + bytes(7)
    body = numbers(1, 2, 3, 4) + numbers(0, 0, 0, 0) + numbers(1, 1, 1, 1)
    body += bytes(sum(1 << shaft for shaft in range(4) if TWILL[treadle, shaft]) for treadle in range(4))
    body += numbers(1, 2, 3, 4)
    return head + body + bytes(66) + bytes([2, 255, 0, 0, 0, 0, 255])


def twa(path) -> bytes:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("twamain.waf", draft_text(named_draft("twill_2_2")))
    return path.read_bytes()


def test_a_fiberworks_draft_is_read(tmp_path):
    pytest.importorskip("dtx_to_wif")
    (tmp_path / "a.dtx").write_bytes(dtx())
    draft = load_draft(tmp_path / "a.dtx")
    assert draft.title == "A twill" and draft.drawdown.shape == (8, 8)
    assert np.array_equal(draft.drawdown, np.tile(TWILL, (2, 2)))
    assert draft.warp_colors[0, 0] > 0.4 > draft.weft_colors.max(), "red ends, dark picks"
    fabric = load_fabric(tmp_path / "a.dtx")
    assert fabric.weave.drafted.drawdown.shape == (4, 4) and fabric.yarn[0].albedo[0] > fabric.yarn[1].albedo[0]


def test_a_weavepoint_draft_is_read(tmp_path):
    pytest.importorskip("dtx_to_wif")
    (tmp_path / "a.wpo").write_bytes(wpo())
    draft = load_draft(tmp_path / "a.wpo")
    assert np.array_equal(draft.drawdown, TWILL)
    assert draft.warp_spacing[0] == pytest.approx(2.54 / 40) and draft.weft_spacing[0] == pytest.approx(2.54 / 20)
    assert draft.warp_colors[0].tolist() == [1.0, 0.0, 0.0] and draft.weft_colors[0].tolist() == [0.0, 0.0, 1.0]


def test_a_tempoweave_draft_is_its_wif(tmp_path):
    twa(tmp_path / "a.twa")
    assert np.array_equal(load_draft(tmp_path / "a.twa").drawdown, TWILL)


@pytest.mark.parametrize("suffix", [".dtx", ".wpo", ".twa"])
def test_damaged_drafts_are_one_line(tmp_path, suffix):
    pytest.importorskip("dtx_to_wif")
    whole = {".dtx": dtx(), ".wpo": wpo(), ".twa": twa(tmp_path / "whole.twa")}[suffix]
    rng = np.random.default_rng(5)
    read = 0
    for number in range(24):
        data = bytearray(whole)
        for at in rng.integers(len(data), size=1 + number % 4):
            data[at] = rng.integers(256)
        path = tmp_path / f"{number}{suffix}"
        path.write_bytes(bytes(data[: rng.integers(len(data))] if number % 2 else data))
        try:
            load_draft(path)
            read += 1
        except InputError as error:
            text = str(error)
            assert "\n" not in text and path.name in text and len(text) < 300
    assert read < 24


def test_without_the_library_the_line_says_how_to_get_it(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "dtx_to_wif.dtx_reader", None)
    (tmp_path / "a.dtx").write_bytes(dtx())
    with pytest.raises(InputError, match=r"a\.dtx: a draft of Fiberworks.*glcloth\[drafts\].*WIF"):
        load_draft(tmp_path / "a.dtx")

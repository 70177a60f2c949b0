"""Arrays in the cache folder."""

import os

import numpy as np
import pytest

from glcloth import kept
from glcloth.kept import keep, kept_path, read_kept


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))


def test_a_key_holds_all_that_it_is_made_of():
    x = np.arange(6.0)
    same = kept_path("a", (1, "b"), x)
    assert same == kept_path("a", (1, "b"), x.copy())
    others = [
        kept_path("c", (1, "b"), x), kept_path("a", (2, "b"), x), kept_path("a", (1, "b"), x.reshape(2, 3)),
        kept_path("a", (1, "b"), x.astype("f4")), kept_path("a", (1, "b"), np.where(x == 5, 5.0000001, x)),
        kept_path("a", (1, "b"), x[:, None][::-1, 0]),
    ]  # fmt: skip
    assert len({same, *others}) == 7


def test_only_a_whole_and_fitting_array_is_read():
    path, x = kept_path("a", 1), np.float32([[1.0, -2.0], [0.5, 0.0]])
    assert read_kept(path, x.shape, 2.0) is None
    keep(path, x)
    np.testing.assert_array_equal(read_kept(path, x.shape, 2.0), x)
    assert read_kept(path, (4,), 2.0) is None and read_kept(path, x.shape, 1.9) is None
    whole = path.read_bytes()
    for damaged in (whole[:-30], b"", b"no archive", whole.replace(x.tobytes(), x[::-1].tobytes())):
        path.write_bytes(damaged)
        assert read_kept(path, x.shape, 2.0) is None
    keep(path, np.float32([np.nan]))
    assert read_kept(path, (1,), np.inf) is None


def test_the_oldest_files_go_and_a_folder_that_cannot_be_written_is_none(tmp_path, monkeypatch):
    paths = [kept_path("a", k) for k in range(4)]
    for k, path in enumerate(paths):
        keep(path, np.zeros(1, "f4"), most=2)
        os.utime(path, (k, k))
    assert [path.exists() for path in paths] == [False, False, True, True]
    # Large ones go earlier, the largest are not kept, and what another process is writing stays.
    monkeypatch.setattr(kept, "MOST_BYTES", 5000)
    (tmp_path / "a" / ".other.glcloth-x.npz").write_bytes(b"half")
    os.utime(tmp_path / "a" / ".other.glcloth-x.npz", (0, 0))
    for k, count in ((4, 500), (5, 500), (6, 700)):
        keep(kept_path("a", k), np.zeros(count, "f4"), most=2)
        if count == 500:
            os.utime(kept_path("a", k), (k, k))
    found = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert found == sorted([".other.glcloth-x.npz", *(kept_path("a", k).name for k in (4, 5))])
    monkeypatch.setattr(kept, "MOST_BYTES", 4100)
    keep(kept_path("a", 7), np.zeros(500, "f4"), most=2)
    assert [kept_path("a", k).exists() for k in (4, 5, 7)] == [False, False, True]
    (tmp_path / "b").write_text("a file in its place")
    keep(kept_path("b", 1), np.zeros(1, "f4"))
    assert (tmp_path / "b").read_text() == "a file in its place"

"""Damaged files of every format: each is read, or refused by one line. `python tests/measure/fuzz.py 20000` does it at
length, with limits of time and memory."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import FORMATS, KINDS, corpus, damaged
from test_strength import is_a_line

from glcloth.errors import InputError

EDITS = st.lists(st.tuples(st.sampled_from(KINDS), st.floats(0, 1), st.integers(0, 1 << 16)), min_size=1, max_size=4)
THRIFTY = settings(deadline=None, database=None, derandomize=True, suppress_health_check=list(HealthCheck))
AGAIN = (
    "new scene",
    "weave",
    "map png",
    "map jpg",
    "map exr",
)  # other files, or other readers, of formats that are there


@pytest.mark.parametrize("name", FORMATS)
def test_a_damaged_file_is_read_or_refused_by_one_line(name, tmp_path_factory, capfd):
    folder = tmp_path_factory.mktemp(name.replace(" ", "_"))
    sound, format = corpus(name, folder), FORMATS[name]

    @settings(THRIFTY, max_examples=50 if name in AGAIN else 200)
    @given(st.integers(0, len(sound) - 1), EDITS, st.booleans())
    def check(number, edits, mend):
        path = folder / sound[number].name
        path.write_bytes(damaged(sound[number].read_bytes(), edits, format.mend if mend else None))
        try:
            format.read(path)
        except InputError as error:
            assert is_a_line(str(error)) and path.stem in str(error)
        out, err = capfd.readouterr()
        assert not out and all(is_a_line(line) and "warning" in line for line in err.splitlines())

    for path in sound:
        format.read(folder / path.name)  # undamaged
    capfd.readouterr()
    check()

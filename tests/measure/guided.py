"""Damaged files that look for new paths through a reader: python tests/measure/guided.py FORMAT [--runs 20000] [--seed 1].

Needs atheris (pip install 'glcloth[fuzz]'). libFuzzer changes the sound files of tests/mutations.py, and keeps what
reaches lines of glcloth that nothing had reached. It ends at the first exception that is not an InputError, at 10 s for
one file, or above 1.5 GB, and writes that file. What libraries of C do inside is not seen; tests/measure/fuzz.py tries
the same formats without a guide, and all of them.
"""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["glcloth"]):
    import common  # first: it finds the helpers of the tests
    from mutations import FORMATS, corpus

    from glcloth.cli import _quiet_libraries
    from glcloth.errors import MAX_LINE, InputError


def main():
    """Hand a reader over to libFuzzer."""
    args = common.options(__doc__, [], runs=20000, seed=1)
    (name,) = args.environments
    folder, format = Path(tempfile.mkdtemp()), FORMATS[name]
    sound = corpus(name, folder)
    seeds = folder / "seeds"
    seeds.mkdir()
    for path in sound:
        (seeds / path.name).write_bytes(path.read_bytes())

    def once(data):
        path = folder / sound[0].name
        path.write_bytes(data if format.mend is None else format.mend(data))
        try:
            with _quiet_libraries():
                format.read(path)
        except InputError as error:
            line = str(error)
            assert line.isprintable() and len(line) <= MAX_LINE, line[:400]

    limits = [f"-runs={args.runs}", f"-seed={args.seed}", "-timeout=10", "-rss_limit_mb=1536", "-max_len=65536"]
    atheris.Setup([sys.argv[0], *limits, str(seeds)], once)
    atheris.Fuzz()


if __name__ == "__main__":
    main()

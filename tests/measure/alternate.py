"""One command of glcloth by two trees in turns, so that a machine whose speed drifts is alike to both.

python tests/measure/alternate.py OLD_TREE NEW_TREE [--rounds 5] -- bench cloth --methods direct --json
python tests/measure/alternate.py OLD_TREE NEW_TREE -- render drape --size 64x48 -o picture.png

Prints the median of both and new / old for CPU time (user and system) and wall time of the process, and for
each number of the JSON that it prints, if any. A first run of each tree is not counted: it fills its cache.
Outputs with relative names go to a folder that is deleted at the end.
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from same_bits import environment


def numbers(value, name=""):
    """Yield (name, number) of each number of a JSON value; parts of names are joined by dots."""
    if isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from numbers(part, f"{name}.{key}" if name else str(key))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield name, value


def run(tree, arguments, folder, cache):
    """Run the command once with the package of a tree; returns {name: number}."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    line = [sys.executable, "-m", "glcloth", *arguments]
    done = subprocess.run(line, cwd=folder, env=environment(tree, cache), capture_output=True, text=True)
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{tree}: exit {done.returncode}: {done.stderr.strip()}")
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    try:
        printed = json.loads(done.stdout)
    except ValueError:
        printed = {}
    return {"process cpu s": cpu, "process wall s": wall, **dict(numbers(printed))}


def main():
    usage = "alternate.py OLD_TREE NEW_TREE [--rounds 5] -- ARGUMENTS OF GLCLOTH"
    parser = argparse.ArgumentParser(usage=usage)
    parser.add_argument("trees", nargs=2, type=Path)
    parser.add_argument("--rounds", type=int, default=5)
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    options, arguments = parser.parse_args(sys.argv[1:split]), sys.argv[split + 1 :]
    if not arguments:
        parser.error("expected -- and a command of glcloth")
    trees = [tree.resolve() for tree in options.trees]
    spent = [[], []]
    with tempfile.TemporaryDirectory() as folder:
        for number in range(options.rounds + 1):
            # Each tree comes first in every other round.
            for which in (0, 1) if number % 2 else (1, 0):
                result = run(trees[which], arguments, folder, Path(folder) / f"cache{which}")
                if number:
                    spent[which].append(result)
            print(f"round {number} of {options.rounds}", file=sys.stderr, flush=True)
    print(f"{'median of ' + str(options.rounds):56}{'old':>12}{'new':>12}{'new / old':>12}")
    for name in dict.fromkeys(name for results in spent for result in results for name in result):
        found = [[result[name] for result in results if name in result] for results in spent]
        old, new = (statistics.median(values) if values else None for values in found)
        ratio = f"{new / old:.3f}" if old and new is not None else "-"
        columns = "".join(f"{'-' if value is None else f'{value:.5g}':>12}" for value in (old, new))
        print(f"{name:56}{columns}{ratio:>12}")


if __name__ == "__main__":
    main()

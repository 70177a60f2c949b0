"""Do the tests notice a fault? One small text change after the other, and the tests of the room that it is in:
python tests/measure/mutants.py OUT.jsonl [--each 14] [--seed 20] [--rooms cameras,images] [--seconds 200].

The changes are OPERATORS, at places that the seed chooses among all places of a room's files outside comments; a place is
chosen by its own text, so that changes elsewhere in the project do not choose others. The work goes on where OUT.jsonl
ends, until each room has so many; lines in it are {room, file, line, was, now, result, by}. At the end the score and the
survivors are printed. A copy of the project in a temporary folder is changed, never the project; tests that fail without
a change would count as catches, so begin with none. `--seconds` are of CPU, for all tests of one stage.
"""

import common  # noqa: I001
import hashlib
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Room: its files, and the tests that know it beside those of NEAREST.
TRACER = "tests/pictures/test_tracer.py tests/pictures/test_path.py tests/pictures/test_path_curtain.py"
ROOMS = {
    "fibre": ("glsl/core/*.glsl glsl/fibre/*.glsl", "tests/twins/test_truth.py"),
    "gaussians": ("glsl/sg/*.glsl", "tests/twins/test_sg_truth.py tests/pictures/test_paper_method.py"),
    "direct": (
        "glsl/direct/*.glsl glsl/inputs/methods/direct*.glsl glcloth/methods/direct/*.py",
        "tests/pictures/test_parts.py tests/pictures/test_direct.py",
    ),
    "woven": ("glsl/woven/*.glsl", "tests/twins/test_woven.py"),
    "accel": (
        "glsl/trace/*.glsl glsl/inputs/accel/*.glsl glsl/passes/accel/*.comp",
        "tests/structures/test_accel.py tests/structures/test_structures.py tests/pictures/test_photons.py "
        "tests/structures/test_races.py tests/pictures/test_tracer.py",
    ),
    "tracing": (
        "glsl/passes/tracing/*.comp glsl/inputs/tracing/*.glsl glcloth/tracing/*.py",
        f"{TRACER} tests/pictures/test_curtain_views.py tests/structures/test_races.py tests/structures/test_counts.py",
    ),
    "simulation": (
        "glsl/simulate/*.glsl glsl/passes/simulation/*.comp glcloth/simulation/cloth.py",
        "tests/structures/test_simulation.py tests/structures/test_curtain_cloth.py",
    ),
    "images": ("glcloth/image.py glcloth/color.py glcloth/metrics.py", "tests/values/test_image.py"),
    "cameras": (
        "glcloth/geometry/camera.py glcloth/picture/sequence.py",
        "tests/values/test_camera.py tests/pictures/test_check.py tests/pictures/test_planted.py",
    ),
    "light": (
        "glcloth/light/equirect.py glcloth/light/suns.py glcloth/light/harmonics.py glcloth/light/fit.py "
        "glcloth/light/lights.py",
        "tests/values/test_environment.py tests/values/test_harmonics.py tests/values/test_fit.py "
        "tests/pictures/test_planted.py",
    ),
    "visibility": (
        "glsl/passes/visibility/*.comp glsl/inputs/visibility/*.glsl glcloth/visibility/*.py",
        "tests/pictures/test_planted.py tests/pictures/test_shadows.py tests/pictures/test_solids.py "
        "tests/pictures/test_through.py tests/pictures/test_reference_shadows.py",
    ),
}
# The tests that are nearest to a file (a pattern of its name), tried before all of its room.
NEAREST = {
    "glsl/inputs/methods/direct|glsl/direct/": "tests/pictures/test_check.py",
    "glcloth/methods/direct/": "tests/pictures/test_check.py tests/pictures/test_planted.py",
    "passes/tracing/(path|picture)|tracing/(path|sky|energy)": "tests/pictures/test_path.py",
    "tracing/(denoise|threads|path_)": "tests/pictures/test_path_curtain.py tests/pictures/test_traced_holes.py",
    "passes/tracing/|glcloth/tracing/|inputs/tracing/": "tests/pictures/test_check.py",
    "tracing/(layers|plain|tree_view)": "tests/pictures/test_curtain_views.py",
    "tracing/(indirect|local_light)": "tests/pictures/test_radiosity.py tests/pictures/test_photons.py",
    "(sheer|sheet|behind|straight)": "tests/pictures/test_through.py",
    "visibility/(sun|finer|coarse)": "tests/pictures/test_soft_suns.py",
    "visibility/(bounce|furnace|hit|lit|irradiance|reflectance|ground)": "tests/pictures/test_solids.py",
    "visibility/": "tests/pictures/test_check.py",
    "geometry/camera": "tests/values/test_camera.py",
    "picture/sequence": "tests/doors/test_farm.py tests/doors/test_doors.py::test_animate_follows_poses_from_files_and_resumes",
}  # fmt: skip
# What is found, and what stands there instead.
OPERATORS = [
    (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" < ", " > "), (r" > ", " < "), (r" <= ", " < "), (r" >= ", " > "),
    (r" == ", " != "), (r" \+= ", " -= "), (r"\bmax\(", "min("), (r"\bmin\(", "max("), (r"\bsin\(", "cos("), (r"\bcos\(", "sin("),
    (r"\b0\.5\b", "0.6"), (r"\b1\.0\b", "1.1"), (r"\b2\.0\b", "2.2"), (r"\b3e38\b", "1.0"), (r"\bdot\((\w+), ", r"-dot(\1, "),
    (r"\.x\b", ".y"), (r"\.z\b", ".x"), (r"\b1e-4\b", "1e-1"), (r" && ", " || "), (r" and ", " or "), (r"\bnot ", ""),
    (r"\bbarrier\(\);", ""), (r"\[::-1\]", ""), (r"\babs\(", "("), (r"\bnormalize\(", "("), (r"\bsqrt\(", "("),
]  # fmt: skip


# One process imports all that the twins' tests want, and tries each change of a library in a fork of itself: a start of pytest
# costs more than the tests.
TWINS = """
import os, resource, sys
sys.path[:0] = [f"{sys.argv[1]}/tests/twins", f"{sys.argv[1]}/tests"]
import test_twins
from glcloth.gpu.context import create_context
for line in sys.stdin:
    file, seconds = line.split()
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
        said = "ok"
        try:
            with create_context() as ctx:
                for case in test_twins.CASES:
                    if case.values[0] == file:
                        said = f"tests/twins/test_twins.py::test_twin[{case.id}]"
                        test_twins.test_twin(ctx, *case.values)
                        said = "ok"
        except BaseException:
            pass
        print(said, flush=True)
        os._exit(0)
    if os.waitpid(child, 0)[1]:
        print("took more CPU than it may", flush=True)
"""


def places(path):
    """(line, start, end, now) of every change that a file takes: outside comments, strings and docstrings of Python."""
    text = path.read_text(encoding="utf-8")
    python, inside = path.suffix == ".py", False
    for number, line in enumerate(text.splitlines()):
        quotes = line.count('"""')
        skip, inside = inside or quotes > 0, inside ^ (quotes % 2 == 1)
        code = line.split("#" if python else "//")[0]
        if (python and (skip or '"' in code or "import" in code)) or code.lstrip().startswith(
            ("#", "layout", "uniform")
        ):
            continue
        if python and not line.startswith(" "):
            continue
        for pattern, now in OPERATORS:
            for match in re.finditer(pattern, code):
                yield number, match.start(), match.end(), match.expand(now)


def chosen(room, count, seed, known):
    """Changes of a room, [(file, line, start, end, now)]: so many, no two on one line, none of those known."""
    found, taken = [], set()
    for pattern in ROOMS[room][0].split():
        for path in sorted(ROOT.glob(pattern)):
            file, lines = path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8").splitlines()
            for line, start, end, now in places(path):
                was = lines[line]
                text = was.strip(), (was[:start] + now + was[end:]).strip()
                order = hashlib.sha256(repr((seed, file, *text)).encode()).digest()
                found.append((order, (file, *text), (file, line, start, end, now)))
    out = []
    for _, key, change in sorted(found):
        if len(out) < count and key not in known and key[:2] not in taken:
            taken.add(key[:2])
            out.append(change)
    return out


def selections(file, room):
    """Arguments of pytest, the nearest tests first: those of NEAREST, and then all of the room."""
    nearest = [test for pattern, tests in NEAREST.items() if re.search(pattern, file) for test in tests.split()]
    if nearest:
        yield ["-m", "not slow", *nearest]
    yield ["-m", "not slow", *(test for test in ROOMS[room][1].split() if test not in nearest)]


def of_twins(twins, file, seconds):
    """Which of a library's twins notices: its test, or nothing."""
    if not (file.startswith("glsl/") and len(file.split("/")) == 3):
        return ""
    twins.stdin.write(f"{file.removeprefix('glsl/')} {seconds}\n")
    twins.stdin.flush()
    said = twins.stdout.readline().strip()
    return "" if said == "ok" else said


def tried(folder, twins, room, change, seconds):
    """What the tests of a room say of a change: (result, by, was, now)."""
    file, line, start, end, now = change
    path = folder / file
    before = path.read_text(encoding="utf-8")
    lines = before.split("\n")
    was = lines[line]
    lines[line] = was[:start] + now + was[end:]
    path.write_text("\n".join(lines), encoding="utf-8")
    by = of_twins(twins, file, seconds)
    result = "caught" if by else "survived"
    for which in () if by else selections(file, room):
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *which]
        env = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "LP_NUM_THREADS": "1"}
        limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))  # noqa: E731
        try:
            done = subprocess.run(
                command, cwd=folder, env=env, capture_output=True, text=True, timeout=20 * seconds, preexec_fn=limit
            )
        except subprocess.TimeoutExpired:
            result, by = "undecided", "waited too long"
            break
        if done.returncode in (-signal.SIGKILL, -signal.SIGXCPU):
            result, by = "caught", f"took more than {seconds} s of CPU"
            break
        if done.returncode == 4:
            raise SystemExit(f"these tests do not exist any more: {which}")
        if done.returncode not in (0, 5):  # 5: none of that name
            failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.M)
            result, by = "caught", failed[1] if failed else f"exit code {done.returncode}"
            break
    path.write_text(before, encoding="utf-8")
    return result, by, was.strip(), lines[line].strip()


def report(rows):
    """Print the score of each room, and the survivors."""
    common.row("room", "caught", "survived", "undecided")
    common.row("---", "---", "---", "---")
    for room in [*ROOMS, "all"]:
        count = Counter(row["result"] for row in rows if room in (row["room"], "all"))
        common.row(room, count["caught"], count["survived"], count["undecided"])
    for row in rows:
        if row["result"] == "survived":
            print(f"\n{row['file']}:{row['line']}\n  - {row['was']}\n  + {row['now']}")


def main():
    """Try all changes that OUT.jsonl does not hold yet, room by turn."""
    args = common.options(__doc__, [], each=14, seed=20, rooms=list(ROOMS), seconds=200)
    out = Path(args.environments[0] if args.environments else "mutants.jsonl")
    rows = [json.loads(line) for line in out.read_text().splitlines()] if out.is_file() else []
    known = {(row["file"], row["was"], row["now"]) for row in rows}
    done = Counter(row["room"] for row in rows)
    jobs = [[(room, job) for job in chosen(room, args.each - done[room], args.seed, known)] for room in args.rooms]
    turns = [job for turn in range(args.each) for room in jobs for job in room[turn : turn + 1]]
    with tempfile.TemporaryDirectory() as folder:
        files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout.split(b"\0")
        for name in filter(None, files):
            target = Path(folder) / os.fsdecode(name)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes((ROOT / os.fsdecode(name)).read_bytes())
        env = {**os.environ, "PYTHONPATH": folder, "PYTHONDONTWRITEBYTECODE": "1", "LP_NUM_THREADS": "1"}
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        twins = subprocess.Popen([sys.executable, "-c", TWINS, folder], cwd=folder, env=env, **pipes)
        for room, change in turns:
            result, by, was, now = tried(Path(folder), twins, room, change, args.seconds)
            row = {"room": room, "file": change[0], "line": change[1] + 1, "was": was, "now": now}
            rows.append(row | {"result": result, "by": by})
            with out.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
            print(result, room, f"{change[0]}:{change[1] + 1}", now, "|", by, flush=True)
        twins.stdin.close()
        twins.wait()
    report(rows)


if __name__ == "__main__":
    main()

"""Every command and code block of README.md and docs/*.md as printed, and every example, in a fresh clone after `make demo`.

python tests/measure/docs.py [--documents README.md,...] [--examples] [--keep]

Each document has a folder of its own, and its commands run there in order with .venv/bin on the path; examples run in
a folder that is not the checkout. Commands that open a window get a virtual display (make tools) and are closed after
eight seconds. `make test` and what needs a rented service is named and left out. A table says seconds and exit codes;
exit 1 if anything failed or an example took more than 60 s.
"""

import argparse
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import documents

SHOWN = 8.0  # seconds that a window is open
LEFT_OUT = (["make", "test"], ["make", "lint"], ["make", "docs"])
LONGEST = 60.0  # seconds of an example


def run(words, folder, environment):
    """(exit code, seconds, last line) of a command; a window is closed by Ctrl-C."""
    window = words[:2] == ["glcloth", "view"]
    if window:
        words = ["xvfb-run", "-a", *words]
    begin = time.perf_counter()
    process = subprocess.Popen(
        words, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        output, _ = process.communicate(timeout=SHOWN if window else 3600)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGINT)
        output, _ = process.communicate(timeout=30)
        if window and "Traceback" not in output:
            process.returncode = 0
    lines = output.strip().splitlines() or [""]
    return process.returncode, time.perf_counter() - begin, lines[-1]


def jobs(document):
    """The commands of a document, as words; code blocks as a Python program."""
    for block in documents.blocks(document):
        if block.language == "sh":
            yield from documents.commands(block.text)
        elif block.language == "python":
            yield ["python", "-c", block.text]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--documents", type=lambda text: text.split(","))
    parser.add_argument("--examples", action="store_true", help="only the examples")
    parser.add_argument("--keep", action="store_true", help="keep the clone")
    options = parser.parse_args()
    home = Path(tempfile.mkdtemp(prefix="glcloth-docs-"))
    clone = home / "glcloth"
    subprocess.run(["git", "clone", "-q", documents.ROOT, clone], check=True)
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    environment |= {"GLCLOTH_CACHE": str(home / "cache"), "PATH": f"{clone}/.venv/bin:{os.environ['PATH']}"}
    failures = 0

    def told(words, folder, limit=None):
        nonlocal failures
        code, seconds, line = run(words, folder, environment)
        bad = code != 0 or (limit is not None and seconds > limit)
        failures += bad
        said = " ".join(shlex.join(words).split())[:100]
        print(f"| {seconds:7.1f} s | {code} | `{said}` | {line[:160] if bad else ''} |", flush=True)

    told(["make", "demo"], clone)
    folder = home / "elsewhere"
    folder.mkdir()
    if not options.examples:
        for document in documents.DOCUMENTS:
            if options.documents and document.name not in options.documents:
                continue
            own = home / document.stem
            own.mkdir()
            for words in jobs(clone / document.relative_to(documents.ROOT)):
                if words in LEFT_OUT or words[0] not in ("make", "glcloth", "python"):
                    print(f"| left out | | `{shlex.join(words)}` | |")
                else:
                    told(words, clone if words[0] == "make" else own)
    for example in sorted((clone / "examples").glob("*.py")):
        told(["python", str(example)], folder, LONGEST)
    if not options.keep:
        shutil.rmtree(home)
    sys.exit(1 if failures else 0)


main()

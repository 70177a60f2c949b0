"""Every command and code block of README.md and docs/*.md as printed, and every example, in a fresh clone after `make demo`.

python tests/measure/docs.py [--documents README.md,...] [--examples] [--keep] [--clone FOLDER]

Each document has a folder of its own, and its commands run there in order with .venv/bin on the path; examples run in
a folder that is not the checkout. Commands that open a window get a virtual display (make tools) and are closed after
eight seconds. `pip install 'glcloth[EXTRA]'` installs that extra of the clone, also where an example asks for it; `dask`
runs in the background until its document ends. `make test` and what needs a rented service is named and left out. A table
says seconds, seconds of CPU and exit codes; exit 1 if anything failed or an example took more than 60 s. Other work on
the machine makes seconds longer, so the limit is on the CPU's, which two cores halve at best. The CPU of `--workers` and of
servers is not among it: they outlive their command.
"""

import argparse
import os
import re
import resource
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
LONGEST = 60.0  # seconds of CPU of an example
EXTRA = re.compile(r"pip install '?glcloth\[(\w+)\]")
STARTING = 20.0  # seconds until a program in the background answers


def spent():
    """Seconds of CPU of all processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(words, folder, environment):
    """(exit code, seconds, CPU seconds, last line) of a command; a window is closed by Ctrl-C."""
    window = words[:2] == ["glcloth", "view"]
    if window:
        words = ["xvfb-run", "-a", *words]
    begin, before = time.perf_counter(), spent()
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
    return process.returncode, time.perf_counter() - begin, spent() - before, lines[-1]


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
    parser.add_argument("--clone", type=Path, help="one that was kept, instead of a fresh one")
    options = parser.parse_args()
    home = Path(tempfile.mkdtemp(prefix="glcloth-docs-"))
    clone = options.clone or home / "glcloth"
    if options.clone is None:
        subprocess.run(["git", "clone", "-q", documents.ROOT, clone], check=True)
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    environment |= {"GLCLOTH_CACHE": str(home / "cache"), "PATH": f"{clone}/.venv/bin:{os.environ['PATH']}"}
    failures = 0

    def told(words, folder, limit=None):
        nonlocal failures
        code, seconds, cpu, line = run(words, folder, environment)
        bad = code != 0 or (limit is not None and cpu > limit)
        failures += bad
        said = " ".join(shlex.join(words).split())[:100]
        print(f"| {seconds:7.1f} s | {cpu:6.1f} | {code} | `{said}` | {line[:160] if bad else ''} |", flush=True)

    def installed(extra):
        told(["python", "-m", "pip", "install", "-q", "-e", f"{clone}[{extra}]"], home)

    def typed(document, own):
        """Run what a document prints."""
        behind = []
        for words in jobs(clone / document.relative_to(documents.ROOT)):
            said = shlex.join(words)
            if extra := EXTRA.match(said.replace("'", "")):
                installed(extra[1])
            elif words[0] == "dask":
                behind.append(subprocess.Popen(words, cwd=own, env=environment, stderr=subprocess.DEVNULL))
                time.sleep(STARTING)
            elif words in LEFT_OUT or words[0] not in ("make", "glcloth", "python"):
                print(f"| left out | | `{said}` | |", flush=True)
            else:
                told(words, clone if words[0] == "make" else own)
        for process in behind:
            process.terminate()
            process.wait()

    if options.clone is None:
        told(["make", "demo"], clone)
    folder = home / "elsewhere"
    folder.mkdir()
    if not options.examples:
        for document in documents.DOCUMENTS:
            if options.documents and document.name not in options.documents:
                continue
            own = home / document.stem
            own.mkdir()
            typed(document, own)
    for example in [] if options.documents else sorted((clone / "examples").glob("*.py")):
        for extra in set(re.findall(r'^needs\("\w+", "(\w+)"\)', example.read_text(encoding="utf-8"), re.M)):
            code, _, _, line = run(["python", str(example)], folder, environment)
            if code and EXTRA.search(line):
                installed(extra)
        told(["python", str(example)], folder, LONGEST)
    if not options.keep:
        shutil.rmtree(home)
    sys.exit(1 if failures else 0)


main()

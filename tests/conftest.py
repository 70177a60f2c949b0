"""One context for the whole session; GL errors fail the test that made them; the shared folder is optional."""

import os
from collections import Counter
from pathlib import Path

import pytest

from glcloth import progress
from glcloth.gpu.context import create_context

ROOT = Path(__file__).resolve().parent.parent
SHARED = Path(os.environ.get("GLCLOTH_SHARED") or ROOT.parent / "shared")

# Every reason to skip: words of it, what would change it, and whether CI lets it pass.
SKIPS = (
    ("needs Xvfb", "make tools", False),
    ("shared", "GLCLOTH_SHARED=FOLDER make test, with the folder of golden values and real maps", True),
    ("another rasteriser", "LIBGL_ALWAYS_SOFTWARE=1 make test", True),
    ("one node is for narrow Gaussians", "nothing: that case does not exist", True),
)

LONG = ("test_window.py", "test_direct.py")


def skipped(config) -> Counter:
    """{(reason, remedy, allowed in CI): how many} of the tests that were skipped."""
    reports = config.pluginmanager.get_plugin("terminalreporter").stats.get("skipped", [])
    reasons = [report.longrepr[2].removeprefix("Skipped: ") for report in reports]
    known = [next((skip for skip in SKIPS if skip[0] in reason), ("", "unknown", False)) for reason in reasons]
    return Counter((reason, skip[1], skip[2]) for reason, skip in zip(reasons, known, strict=True))


def pytest_collection_modifyitems(items):
    """Several processes share the tests by files (`--dist loadfile`), whose tests share programs and windows. The longest
    begin, so that no process ends long after the others."""
    items.sort(key=lambda item: (item.path.name not in LONG, item.path.parent.name != "window"))


def pytest_sessionfinish(session):
    """In CI a test that is skipped is a test that fails, but for reasons on the list."""
    if hasattr(session.config, "workerinput"):
        return  # the process that shares the tests out counts
    if os.environ.get("CI") == "true" and any(not allowed for _, _, allowed in skipped(session.config)):
        session.exitstatus = session.exitstatus or pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter, config):
    """Say what was skipped, why, and what would change that."""
    for (reason, remedy, allowed), count in sorted(skipped(config).items()):
        line = f"skipped {count}: {reason}; to run: {remedy}"
        in_ci = os.environ.get("CI") == "true" and not allowed
        terminalreporter.write_line(line + ("; not allowed in CI" if in_ci else ""), red=in_ci, yellow=not in_ci)


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Tables and fits of the tests go to a folder of their own, so that no earlier run can help a test."""
    os.environ["GLCLOTH_CACHE"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session", autouse=True)
def no_progress():
    """On a slow machine work takes long enough to tell of its progress between the lines that tests count."""
    progress.BAR_AFTER = progress.SAY_EVERY = float("inf")


@pytest.fixture(scope="session")
def session_ctx():
    ctx = create_context()
    yield ctx
    ctx.release()


@pytest.fixture
def ctx(session_ctx):
    """The session's context, current; the test fails if it leaves a GL error behind."""
    with session_ctx:
        assert session_ctx.error == "GL_NO_ERROR", "an earlier test left a GL error"
        yield session_ctx
        assert session_ctx.error == "GL_NO_ERROR"


@pytest.fixture(scope="session")
def session_renderer(session_ctx):
    from glcloth.picture.renderer import Renderer

    with session_ctx:
        renderer = Renderer(ctx=session_ctx)
        renderer._passes.ways.due = lambda scene: False  # which way is faster here decides about no test
        yield renderer


@pytest.fixture
def renderer(ctx, session_renderer):
    """A renderer on the session's context; its methods and programs are kept between tests."""
    return session_renderer


@pytest.fixture(scope="session")
def shared():
    """The folder with golden values and real HDRIs beside the project; tests that need it skip without it."""
    if not SHARED.is_dir():
        pytest.skip(f"no shared folder at {SHARED}")
    return SHARED

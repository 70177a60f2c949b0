"""One context for the whole session; GL errors fail the test that made them; the shared folder is optional."""

import os
from pathlib import Path

import pytest

from glcloth import progress
from glcloth.gpu.context import create_context

ROOT = Path(__file__).resolve().parent.parent
SHARED = Path(os.environ.get("GLCLOTH_SHARED") or ROOT.parent / "shared")


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
        yield Renderer(ctx=session_ctx)


@pytest.fixture
def renderer(ctx, session_renderer):
    """A renderer on the session's context; its methods and programs are kept between tests."""
    return session_renderer


@pytest.fixture(scope="session")
def shared():
    """The folder with golden values and real HDRIs beside the project; tests that need it skip without it."""
    if not SHARED.is_dir():
        pytest.skip(f"{SHARED} is not there")
    return SHARED

# make demo   a skirt of shot silk on a dress form, from a bare checkout
# make test   the tests; says what it skipped and what would change that
# make docs   the site of the documents, in out/site/index.html
# make tools  what the window's tests are driven with
# make lint   style
SHELL := /bin/bash
VENV := .venv
RUN := $(VENV)/bin/
SYSTEM := libegl1 libgl1 libgl1-mesa-dri
TOOLS := xvfb xdotool

.PHONY: demo test docs tools lint equations clean

demo: $(VENV)/.installed
	$(RUN)glcloth render skirt -o demo.png
	@echo "The picture is $(CURDIR)/demo.png. More: $(RUN)glcloth --help"

test: $(VENV)/.tests
	$(RUN)ruff check .
	$(RUN)ruff format --check .
	$(RUN)mypy
	LP_NUM_THREADS=1 $(RUN)pytest -m "not slow" -n logical --dist loadfile

tools:
	@if ! { command -v Xvfb && command -v xdotool; } >/dev/null; then \
	  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	    apt-get -o Acquire::Retries=3 update -qq && \
	    DEBIAN_FRONTEND=noninteractive apt-get -o Acquire::Retries=3 install -y -qq --no-install-recommends $(TOOLS); \
	  else echo "The window's tests need an X server and a hand. Install them: sudo apt-get install $(TOOLS)" >&2; exit 3; fi; fi

lint: $(VENV)/.tests
	$(RUN)ruff check --fix .
	$(RUN)ruff format .

docs: $(VENV)/.docs # warnings, such as a broken link, are errors
	NO_MKDOCS_2_WARNING=1 $(RUN)mkdocs build --strict -q
	@echo "The site is $(CURDIR)/out/site/index.html"

equations: # equation -> GLSL -> twin
	@grep -rnoE "\[(Miz|Mat)[^]]*\]" glsl glcloth --include=*.glsl --include=*.py --include=*.comp --include=*.frag | sort -t'[' -k2,2V

clean:
	rm -rf $(VENV) out demo.png

# The first Python >= 3.11 that can make virtual environments (a version manager's shim may exist and not run).
$(VENV)/bin/python:
	@for p in python3 python3.13 python3.12 python3.11 python3.14; do \
	  if $$p -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then found=$$p; break; fi; done; \
	if [ -z "$$found" ]; then \
	  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	    apt-get update -qq && apt-get install -y -qq python3-venv && found=python3; \
	  else echo "glcloth needs Python 3.11 or newer with venv. Install it: sudo apt-get install python3-venv" >&2; exit 2; fi; fi; \
	$$found -m venv $(VENV)

$(VENV)/.system: $(VENV)/bin/python
	@if ! $(RUN)python -c 'import ctypes as c; c.CDLL("libEGL.so.1"); c.CDLL("libGL.so.1")' 2>/dev/null; then \
	  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	    apt-get update -qq && apt-get install -y -qq $(SYSTEM); \
	  else echo "glcloth needs OpenGL by EGL. Install it: sudo apt-get install $(SYSTEM)" >&2; exit 3; fi; fi
	@touch $@

$(VENV)/.installed: pyproject.toml $(VENV)/.system
	$(RUN)python -m pip install -q --disable-pip-version-check -e .
	@touch $@

$(VENV)/.tests: pyproject.toml $(VENV)/.installed
	$(RUN)python -m pip install -q --disable-pip-version-check -e '.[test]'
	@touch $@

$(VENV)/.docs: pyproject.toml $(VENV)/.installed
	$(RUN)python -m pip install -q --disable-pip-version-check -e '.[docs]'
	@touch $@

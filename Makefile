# Set-up and jobs of psp3. On a machine with Python 3.11 or newer, make and pip:
#
#   make view        install, and show a machine that moves in the browser
#   make reproduce   install, and run the main job
#   make test        install what the tests need, and run them
#   make test-quick  run those that take no time: for working
#   make fuzz        try 50 000 changed files on all readers: a quarter of an hour of a core
#   make endings     end studies, benchmarks and saves at 400 moments by chance: ten minutes
#   make memory      look for leaks in ten million calls and a thousand loads: hours
#   make export-states  compare robots, controllers and systems in C with Python more often: in 10,000 states each
#   make misuse      call everything public with every wrong argument
#   make lint        check style and types
#   make bench       measure speed
#   make release-check  build wheel and source distribution, and try them on every Python there is
#   make docs        build the documentation: results/docs/index.html
#   make pictures    draw the pictures of the README and the documentation anew
#   make lock        choose the versions of everything anew: requirements/
#   make clean       remove what these commands made, but not results/
#
# Properties are tested on random examples, of which the cases of one property share a number; with
# HYPOTHESIS_PROFILE=thorough each case gets all of them.
#
# Everything is installed into .venv. Each step leaves a stamp there, and runs again only when what it depends on has changed.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Not the user's, which may name other versions or hold an older psp3.
unexport PYTHONPATH PYTHONHOME
# Tests start hundreds of processes: without byte code each of them would translate all modules.
unexport PYTHONDONTWRITEBYTECODE
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
# Whatever is downloaded has a hash in requirements/, and no script of its own is run.
LOCKED := $(PIP) --require-hashes --only-binary :all: --requirement
LOCK := $(BIN)/python -m uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --only-binary :all: --no-strip-extras --no-emit-index-url --no-annotate --no-header

# What tests of one file share is made once, and all that a process has loaded serves the file.
# The longest files come first, see tests/conftest.py.
DISTRIBUTED := --numprocesses=logical --dist=loadfile --no-loadscope-reorder

# Every module with compiled functions, and what compiles them.
KERNELS := $(shell grep -rl --include='*.py' 'support\.compiled' psp3 fuzzy2) $(wildcard fuzzy2/support/*.py)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.SUFFIXES:
.PHONY: help view reproduce test test-quick fuzz endings memory export-states misuse lint bench release-check docs pictures lock clean

help:
	@sed -n 's/^#   make/  make/p' Makefile

# What is shown is compiled when it is first needed; all kernels together would take minutes.
view: $(VENV)/.run
	@$(BIN)/psp3 view

reproduce: $(VENV)/.compiled
	@echo "Running the main job: psp3 reproduce"
	@$(BIN)/psp3 reproduce

test: $(VENV)/.compiled $(VENV)/.dev
	@echo "Running the tests"
	@$(BIN)/python -m pytest $(DISTRIBUTED)

test-quick: $(VENV)/.compiled $(VENV)/.dev
	@echo "Running the quick tests"
	@$(BIN)/python -m pytest $(DISTRIBUTED) -m "not slow"

fuzz: $(VENV)/.compiled $(VENV)/.dev
	@echo "Trying changed files on all readers; faults go into results/hostile"
	@$(BIN)/python -m tests.hostile 50000

# The tests take three of each kind with each signal.
endings: $(VENV)/.compiled $(VENV)/.dev
	@echo "Ending studies, benchmarks and saves, 200 times with SIGKILL and 200 times with SIGINT"
	@$(BIN)/python -m tests.hostile.endings 200 0

# The tests count what is in use after hundreds of calls; this looks at all that the system has given.
memory: $(VENV)/.compiled $(VENV)/.dev
	@echo "Calling ten million times, and loading a thousand times (hours)"
	@$(BIN)/python -m tests.endurance.memory

# The tests that 'make test' runs with 500 states, with the sanitizers in double precision alone, and, of code of which the like is
# there already, without optimization and without cppcheck.
export-states: $(VENV)/.compiled $(VENV)/.dev
	@echo "Comparing robots, controllers and systems in C with Python in 10,000 states (half an hour)"
	@EXPORT_STATES=10000 $(BIN)/python -m pytest --numprocesses=logical --dist=load \
		-k "test_every or sanitizers or test_systems or single" \
		$(addprefix tests/psp3/export/test_,robots.py closed_form.py controllers.py) tests/fuzzy2/export/test_systems.py

# The tests that 'make test' runs with one of eight wrong arguments.
misuse: $(VENV)/.compiled $(VENV)/.dev
	@echo "Calling everything public with every wrong argument (some minutes)"
	@MISUSE=all $(BIN)/python -m pytest --numprocesses=logical --dist=loadfile tests/cross/test_misuse_of_*.py

lint: $(VENV)/.dev
	@echo "Checking style (ruff), types (mypy) and the order of imports (import-linter)"
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy
	@$(BIN)/lint-imports --no-logo

bench: $(VENV)/.compiled $(VENV)/.dev
	@echo "Measuring speed"
	@set -e; for benchmark in benchmarks/bench_*.py; do $(BIN)/python "$$benchmark"; done

# UNRELEASED=1 while the changelog has no section for the version yet.
release-check: $(VENV)/.dev
	@echo "Building wheel and source distribution, and trying them"
	@$(BIN)/python -m tests.release $(if $(UNRELEASED),--unreleased)

docs: $(VENV)/.dev
	@echo "Building the documentation"
	@$(BIN)/sphinx-build -W --keep-going --quiet -b html -d build/doctrees docs results/docs
	@echo "Done: results/docs/index.html"

pictures: $(VENV)/.compiled $(VENV)/.dev
	@echo "Drawing the pictures"
	@set -e; for script in docs/pictures/make_*.py docs/play/make_*.py; do $(BIN)/python "$$script"; done

# The tests' versions are those of what psp3 runs on, where both have a package.
lock: $(VENV)/.dev
	@echo "Choosing versions"
	@$(LOCK) --upgrade --extra dev pyproject.toml requirements/build.in --output-file requirements/dev.txt
	@$(LOCK) --constraint requirements/dev.txt pyproject.toml requirements/build.in --output-file requirements/run.txt
	@echo "Now run: make test"

clean:
	@echo "Removing the virtual environment, caches and builds (results/ stays)"
	@rm -rf $(VENV) build dist docs/api docs/notebooks htmlcov .coverage .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(VENV)/.made:
	@command -v $(PYTHON) >/dev/null || { echo "$(PYTHON) is not installed; name a Python 3.11 or newer: make PYTHON=..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("psp3 needs Python 3.11 or newer, and $(PYTHON) is %d.%d; name another: make PYTHON=..." % sys.version_info[:2])'
	@echo "Making the virtual environment $(VENV)"
	@if $(PYTHON) -c 'import ensurepip' 2>/dev/null; then $(PYTHON) -m venv $(VENV); else \
		$(PYTHON) -m venv --without-pip $(VENV) && $(PYTHON) -m pip --python $(BIN)/python install --quiet --disable-pip-version-check pip; fi
	@touch $@

# The installations follow one another, so that make -j never runs two at once.
$(VENV)/.run: $(VENV)/.made pyproject.toml requirements/run.txt
	@echo "Installing psp3 and what it runs on (a minute or two, 1 GiB)"
	@$(LOCKED) requirements/run.txt
	@$(PIP) --no-deps --no-build-isolation --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.run requirements/dev.txt
	@echo "Installing what the tests, the checks and the documentation need"
	@$(LOCKED) requirements/dev.txt
	@touch $@

# Into the cache folder of the user (fuzzy2/support/code_folder.py); code of before is removed there.
$(VENV)/.compiled: $(VENV)/.run $(KERNELS)
	@echo "Compiling the numerical kernels"
	@$(BIN)/python -m psp3.warm_up
	@touch $@

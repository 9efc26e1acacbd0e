# make demo    run the example and say where its report lies
# make test    style, types, and the tests that are not long: five minutes once kernels are compiled
# make check   what make test leaves out: with it, everything the continuous integration checks
# make lint    style, types, import walls      make bench   the measured speeds      make docs   the pages as HTML
# make stress  the search, the checkpoints and the readers attacked in full: an hour or more
# KERNELS=file or folder: the demo takes the compiled kernels of a wheel (docs/install.md).
# VENV=folder chooses the virtual environment, PYTHON=interpreter what it is made from.

VENV ?= .venv
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11 python; do \
  if $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; \
  then echo $$p; break; fi; done)
BIN := $(VENV)/bin
DEMO := out/demo
GENERATED := examples/generated
ONE_THREAD := tests/unit/triangles tests/cases/test_faceted_search.py \
  tests/unit/search/track/test_project.py tests/unit/search/track/test_track.py \
  tests/unit/search/sweep/test_hit.py tests/unit/search/closest/test_global.py
PYTEST := $(BIN)/python -m pytest -q -p no:cacheprovider
TWO := -n 2 --dist loadfile --no-loadscope-reorder
# Without files of bytecode each process of the tests would compile all modules again: half a minute.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo kernels run test check lint bench stress docs clean oldest newest installed
.DEFAULT_GOAL := demo

demo: $(if $(KERNELS),kernels) $(BIN)/.run-stamp $(GENERATED)/headform.step $(GENERATED)/pad.vtu $(GENERATED)/foam_block.vtu
	@test -d $(DEMO) || test -n "$(KERNELS)" || echo "The first run compiles the kernels: a minute and a half of processor time, once."
	$(BIN)/contiga run examples/01_headform.toml -o $(DEMO)
	@echo "Open in a browser: $(abspath $(DEMO)/report.html)"
	@echo "Try next: make run CASE=06_headform_foam (the pad of foam elements), docs/tutorial.md (your own part), make test"

kernels: $(BIN)/.run-stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-index --no-deps --force-reinstall \
	  $(if $(wildcard $(KERNELS)/.),--find-links $(KERNELS) contiga_kernels,$(KERNELS))
	@$(BIN)/contiga --version

test: lint
	NUMBA_NUM_THREADS=2 $(PYTEST) $(TWO) -m "not long"

check: $(BIN)/.check-stamp $(BIN)/.docs-stamp
	NUMBA_NUM_THREADS=2 $(PYTEST) $(TWO) -m long
	NUMBA_DISABLE_JIT=1 $(PYTEST) $(TWO) -m interpreted
	NUMBA_NUM_THREADS=1 $(PYTEST) $(TWO) $(ONE_THREAD)
	$(MAKE) -j 2 newest docs oldest installed

# The least version of numba, the newest Python of this machine, the wheel; each takes one core.
oldest newest installed: $(BIN)/.test-stamp
	$(BIN)/python -m tests.$@

lint: $(BIN)/.test-stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(BIN)/.bench-stamp
	$(BIN)/python -m benchmarks

stress: $(BIN)/.test-stamp
	$(BIN)/python -m tests.stress --full
	CONTIGA_FULL=1 $(PYTEST) $(TWO)
	$(BIN)/python -m tests.fuzz --count 100000 --jobs 2

docs: $(BIN)/.docs-stamp
	$(BIN)/python docs/check_links.py
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs out/docs
	@echo "The pages: $(abspath out/docs/index.html)"

clean:
	rm -rf out $(GENERATED) $(VENV)

# CASE=07_tyre: an example with what it reads.
run: $(if $(CASE),$(addprefix $(GENERATED)/,$(shell sed -n 's|.*"generated/\([a-z_]*\.[a-z]*\)".*|\1|p' examples/$(CASE).toml)))
	$(BIN)/contiga run examples/$(CASE).toml -o out/$(CASE)

$(GENERATED)/%.step: examples/make_%.py $(BIN)/.run-stamp
	$(BIN)/python $< $@

$(GENERATED)/%.csv: examples/make_%.py $(BIN)/.run-stamp
	$(BIN)/python $< $@

$(GENERATED)/%.vtu: examples/make_%.py $(BIN)/.run-stamp
	$(BIN)/python $< $@

# A stamp is newer than pyproject.toml once its packages are installed: a second call does nothing.
$(BIN)/.venv-stamp:
	@test -n "$(PYTHON)" || { echo "contiga needs Python 3.11 or newer; install one or say which: make PYTHON=/path/to/python3.12" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo "$(PYTHON) cannot make a virtual environment; on Debian and Ubuntu install python3-venv" >&2; rm -rf $(VENV); exit 1; }
	@touch $@

$(BIN)/.run-stamp: pyproject.toml $(BIN)/.venv-stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[all]"
	@touch $@

$(BIN)/.test-stamp: pyproject.toml $(BIN)/.venv-stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[all,test]"
	@touch $@ $(BIN)/.run-stamp

$(BIN)/.docs-stamp: pyproject.toml $(BIN)/.venv-stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[all,docs]"
	@touch $@ $(BIN)/.run-stamp

$(BIN)/.check-stamp: $(BIN)/.test-stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[all,test,check]"
	@touch $@

$(BIN)/.bench-stamp: pyproject.toml $(BIN)/.venv-stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[all,bench]"
	@touch $@ $(BIN)/.run-stamp

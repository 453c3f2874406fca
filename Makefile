# What a newcomer needs: `make demo` and `make test`.  Everything is installed into .venv, once.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
INSTALLED := $(VENV)/.installed
LINTERS := $(VENV)/.installed-lint
SPHINX := $(VENV)/.installed-docs
BUILDERS := $(VENV)/.installed-release
LOOPS := $(shell grep -rl --include='*.py' '^\# cython:' src) $(shell find src -name '*.pxd')

# The matrices are small: threads of BLAS would wait for each other.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: help demo reproduce test test-slow lint lint-page lint-workflows release-check bench docs clean
.DELETE_ON_ERROR:

help:
	@echo 'make demo       embed the (3, 2, 1) ellipsoid from its edge lengths; the results are in demo/'
	@echo 'make reproduce  make the figures and numbers of the paper again, in build/reproduction/'
	@echo 'make test       run the tests, but for the slow ones'
	@echo 'make test-slow  run the slow ones: pages of the documentation, whole studies'
	@echo 'make lint       check style, types, the order of the modules and spelling; make lint-page the script of a page, with npm'
	@echo 'make lint-workflows  check .github/workflows, with npm'
	@echo 'make release-check  build what is released, install it elsewhere and run the pages with it'
	@echo 'make bench      measure cost against size'
	@echo 'make docs       build the documentation in site/, the tutorials executed'
	@echo 'make clean      remove .venv, demo/, build/, site/ and caches'

demo: $(INSTALLED)
	$(BIN)/python docs/examples/demo.py

reproduce: $(INSTALLED)
	$(BIN)/python -m reproduction --output build/reproduction

# Files of tests are rewritten once, not by every worker of every run.
test test-slow: export PYTHONDONTWRITEBYTECODE =

test: $(INSTALLED)
	$(BIN)/python -m pytest -q --numprocesses auto --dist loadfile -m "not slow"

test-slow: $(INSTALLED)
	$(BIN)/python -m pytest -q --numprocesses auto --dist worksteal -m slow

lint: $(LINTERS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/codespell .ci benchmarks building docs examples paper reproduction src tests *.md Makefile

lint-page:
	@cd page-lint && npm install --silent --no-audit --no-fund --no-package-lock && npm run --silent lint

lint-workflows:
	@cd workflow-lint && npm install --silent --no-audit --no-fund --no-package-lock && npm run --silent lint

release-check: $(BUILDERS)
	$(BIN)/python release/check.py

bench: $(INSTALLED)
	@for script in benchmarks/*.py; do echo "$$script"; $(BIN)/python "$$script" || exit 1; done

# Warnings are errors, and a page that is gone is gone: nothing is taken from an earlier build.
docs: $(SPHINX)
	@rm -rf build/site
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going --fresh-env -d build/doctrees docs build/site
	@rm -rf site && mv build/site site
	@echo 'the documentation is in site/index.html'

clean:
	rm -rf $(VENV) page-lint/node_modules workflow-lint/node_modules demo site build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find src tests benchmarks reproduction -name __pycache__ -prune -exec rm -rf {} +
	find src -name '*.so' -delete

# The loops are compiled, those that were not before.  Python's files of what is editable pip does not compile to
# bytecode, nor does Python where it is told to write none: .3 s a command.
$(INSTALLED): pyproject.toml setup.py $(LOOPS) | $(BIN)/python
	@echo 'installing into $(VENV), and compiling: one to three minutes, once'
	$(PIP) install --editable '.[test,plot]'
	$(BIN)/python -m compileall -q src
	@touch $@

$(LINTERS): $(INSTALLED)
	$(PIP) install --editable '.[lint]'
	@touch $@

$(SPHINX): $(INSTALLED)
	$(PIP) install --editable '.[docs]'
	@touch $@

$(BUILDERS): $(INSTALLED)
	$(PIP) install --editable '.[release]'
	@touch $@

# The first Python that is new enough and can make a virtual environment with pip.
$(BIN)/python:
	@for python in '$(PYTHON)' python3 python3.14 python3.13 python3.12 python3.11; do \
	    if "$$python" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
	        echo "$$python -m venv $(VENV)"; \
	        "$$python" -m venv $(VENV) && exit 0; \
	        rm -rf $(VENV); exit 1; \
	    fi; \
	done; \
	echo 'isoembed needs Python 3.11 or newer with its venv module, and found none' >&2; \
	echo '($(PYTHON) is '"$$('$(PYTHON)' --version 2>&1 | head -n 1)"'); name one: make PYTHON=python3.x' >&2; \
	exit 1

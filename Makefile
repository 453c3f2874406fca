# What a newcomer needs: `make demo` and `make test`.  Everything is installed into .venv, once.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
INSTALLED := $(VENV)/.installed
LINTERS := $(VENV)/.installed-lint

.PHONY: help demo test lint bench clean
.DELETE_ON_ERROR:

help:
	@echo 'make demo   embed the (3, 2, 1) ellipsoid from its edge lengths; the results are in demo/'
	@echo 'make test   run the tests'
	@echo 'make lint   check style and types'
	@echo 'make bench  measure cost against size'
	@echo 'make clean  remove .venv, demo/ and caches'

demo: $(INSTALLED)
	$(BIN)/python docs/examples/demo.py

test: $(INSTALLED)
	$(BIN)/python -m pytest -q

lint: $(LINTERS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(INSTALLED)
	@for script in benchmarks/*.py; do echo "$$script"; $(BIN)/python "$$script" || exit 1; done

clean:
	rm -rf $(VENV) demo build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find src tests benchmarks -name __pycache__ -prune -exec rm -rf {} +

$(INSTALLED): pyproject.toml | $(BIN)/python
	$(PIP) install --editable '.[test,plot]'
	@touch $@

$(LINTERS): $(INSTALLED)
	$(PIP) install --editable '.[lint]'
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

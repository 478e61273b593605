# SPDX-License-Identifier: Apache-2.0
# make fly    set up, build, fly scenario `ordinary` through lodestar-fc over LCM, write the report
# make test   set up, build, lint, and run the whole test suite
# make build | bench | lint | format | clean

SHELL := /bin/bash
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
BUILD := build/python
SCENARIO ?= ordinary
PIP := $(BIN)/pip --disable-pip-version-check -qq
CPP_FILES = $(shell git ls-files '*.h' '*.cpp' | grep -v generated)

.DEFAULT_GOAL := help
.PHONY: help fly test build build-tests build-asan packages bench lint format clean

help:
	@sed -n '2,4s/^# //p' Makefile

packages:
	@.ci/install-packages

# The build backend first (from pyproject.toml's own list), because the project is built without
# isolation: the C++ library inside LCM's wheel has to be the one that is used at run time.
$(VENV)/.installed: pyproject.toml | packages
	@echo "Setting up $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) install $$($(PYTHON) -c 'import tomllib; c = tomllib.load(open("pyproject.toml", "rb")); \
	  print(*c["build-system"]["requires"], *c["project"]["dependencies"], \
	        *c["project"]["optional-dependencies"]["dev"])')
	@touch $@

# An editable install, so that a change in Python needs no build and one in C++ builds only itself.
define install
	@echo "Building ($(1))"
	@$(PIP) install --no-build-isolation --no-deps -e . -Cbuild-dir=$(BUILD) $(2)
endef

build: $(VENV)/.installed
	$(call install,lodestar-fc and the Python package,)

build-tests: $(VENV)/.installed
	$(call install,with tests and benchmarks,-Ccmake.define.LODESTAR_TESTS=ON -Ccmake.define.LODESTAR_BENCH=ON)

build-asan: $(VENV)/.installed
	@echo "Building (decoder under address and undefined-behaviour sanitizers)"
	@cmake --preset asan >build-asan.log 2>&1 || { cat build-asan.log; rm build-asan.log; exit 1; }
	@rm -f build-asan.log
	@cmake --build --preset asan --target fuzz_codec | tail -n 1

fly: build
	@$(BIN)/lodestar fly $(SCENARIO)

test: build-tests build-asan lint
	@$(BIN)/pytest tests $(BUILD)/tests

lint: $(VENV)/.installed
	@$(BIN)/ruff check . && $(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/clang-format --dry-run --Werror $(CPP_FILES)

format: $(VENV)/.installed
	@$(BIN)/ruff check --fix . && $(BIN)/ruff format .
	@$(BIN)/clang-format -i $(CPP_FILES)

bench: build-tests
	@$(BIN)/python -m lodestar.studies.bench --out out/bench.json

clean:
	@rm -rf build out $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis

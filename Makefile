# Everything starts here; each target does its own set-up in a fresh checkout.

FOUND = $(firstword $(foreach name,python3 python3.11 python3.12 python3.13 python3.14 python,\
	$(shell command -v $(name) 2>/dev/null)))
PYTHON ?= $(FOUND)
BIN := .venv/bin
WORKERS ?= auto
PYTEST = $(BIN)/python -m pytest --numprocesses $(WORKERS) --maxprocesses 8 --dist loadgroup
LANE_CACHE := build/boundscheck
READY :=  # what else has to be there before tests begin

.DEFAULT_GOAL := help
.PHONY: help setup check test long demo docs bench wheel clean

help: ## this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1|\2/p' Makefile | awk -F'|' '{printf "%-14s %s\n", $$1, $$2}'

setup: ## make .venv, or bring it up to date; nothing to do takes no time
	@$(if $(PYTHON),,echo "setup: no Python found; install Python 3.11 or newer" && exit 1;) $(PYTHON) scripts/setup.py

check: setup ## format, lint, layer rule, types, spelling
	@$(BIN)/python scripts/check.py

docs: setup ## build the pages strictly into site/
	@$(BIN)/python scripts/check.py docs

test: setup ## checks, pages, then the fast lane of tests
	@$(BIN)/python scripts/check.py all
	@$(READY)
	@$(PYTEST) $(if $(CI),--durations=25 --durations-min=2)

long: setup ## all that takes minutes: oracles, fuzz, soaks, kernels without JIT and with bounds checks
	@echo "lane: kernels as plain Python"
	@NUMBA_DISABLE_JIT=1 $(PYTEST) -m "kernels and not long"
	@echo "lane: kernels with bounds checks"
	@rm -rf $(LANE_CACHE)
	@NUMBA_BOUNDSCHECK=1 ROVERNAV_CACHE_DIR=$(LANE_CACHE) $(PYTEST) -m "kernels and not long"
	@echo "lane: long tests and oracles"
	@$(PYTEST) --hypothesis-profile=long -m "long or oracle"

demo: setup ## a whole drive, from an elevation model to pictures in demo/
	@$(BIN)/rovernav demo --out demo $(if $(wildcard ../shared/data/dem),--data ../shared/data)

bench: setup ## speed beside peers; ARGS=--setup installs the peers first
	@$(BIN)/python benchmarks/run.py $(ARGS)

wheel: setup ## an installable file in dist/
	@$(BIN)/python -m build --wheel --no-isolation --outdir dist .

clean: ## remove all that make has made
	rm -rf .venv build demo dist site .hypothesis .import_linter_cache .pytest_cache .ruff_cache
	find src tests scripts -name __pycache__ -type d -prune -exec rm -rf {} +

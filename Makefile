# Two doors: `make course` builds, releases and grades; `make test` passes all tests.
# Both set everything up on a bare machine with python3 (3.11 or newer), git and make.

SHELL := /bin/bash
.SHELLFLAGS := -o pipefail -ec
MAKEFLAGS += --no-print-directory
.DEFAULT_GOAL := help
.PHONY: help course test setup lab book release class grade feedback data bench soak format check lock clean

PYTHON ?= python3
VENV := .venv
BIN := $(CURDIR)/$(VENV)/bin
SUBMITTED ?= build/submitted
STRICT ?=

# The environment's scripts come first: nbgrader calls some of its own by name.
export PATH := $(BIN):$(PATH)
# One thread a process: the work is many small problems, and results stay the same everywhere.
export OPENBLAS_NUM_THREADS := 1

files = $(shell find $(1) -type f -not -path '*/__pycache__/*' -not -path '*/.ipynb_checkpoints/*' 2>/dev/null)
READY := $(VENV)/.ready
BOOK := build/.book
RELEASED := build/.release
CLASS := build/.class

help: ## say what there is
	@awk -F':.*## ' '/^[a-z]+:.*## /{printf "  make %-8s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

course: ## set up, build the book, make the release, grade the sample class
	@$(call step,1/4,the environment,$(READY),$(VENV))
	@$(call step,2/4,the book,$(BOOK),build/html/index.html)
	@$(call step,3/4,the student release,$(RELEASED),build/release)
	@$(call step,4/4,the sample class,$(CLASS),build/submitted)
	@$(MAKE) grade-class
	@printf '\n%s\n' 'Where each thing is:'
	@printf '  %-18s %s\n' 'the book' build/html/index.html 'student release' build/release \
		'sample class' build/submitted 'marks, gradebook' build/graded \
		'feedback' build/feedback

# A step of `make course`: it says when nothing has changed, and then does nothing.
define step
if $(MAKE) -q $(3) 2>/dev/null; then echo "[$(1)] $(2): unchanged, reused ($(4))"; \
else echo "[$(1)] $(2) …"; $(MAKE) $(3); fi
endef

setup: $(READY) ## make the environment in .venv from the lock file

$(READY): requirements.lock lib/pyproject.toml autograder/pyproject.toml
	@$(PYTHON) -c 'import sys, venv; sys.exit(sys.version_info < (3, 11))' || \
		{ echo 'python3 3.11 or newer is needed, with venv (Debian: apt install python3-venv);' \
		'name another one with make PYTHON=python3.12 …'; exit 1; }
	@$(PYTHON) -m venv $(VENV)
	@total=$$(grep -c '^[a-zA-Z0-9].*==' requirements.lock); \
	$(BIN)/pip install --progress-bar off --require-hashes -r requirements.lock 2>&1 | \
		awk -v total=$$total '/^(Collecting|Processing|Ignoring) / {printf "\r  %d of about %d packages", ++n, total; fflush()} \
		/^Installing collected/ {printf "\n  installing them, about a minute\n"; fflush()} \
		/ERROR|error:/ {print}'
	@$(BIN)/pip install --quiet --no-deps --no-build-isolation -e lib -e autograder
	@touch $@

lab: setup ## open JupyterLab
	$(BIN)/jupyter lab

book: $(BOOK) ## build the site, build/html

$(BOOK): $(call files,chapters lib/robust_slam) _config.yml _toc.yml $(READY)
	@mkdir -p build
	$(BIN)/jupyter-book build . --path-output build -W -n --keep-going
	@rm -rf build/html && cp -R build/_build/html build/html
	@touch $@

release: $(RELEASED) ## make the student release, build/release

$(RELEASED): $(call files,solutions autograder/robust_slam_autograder) $(READY)
	$(BIN)/autograder release
	@touch $@

class: $(CLASS)

$(CLASS): $(call files,solutions tests/assignments) tests/sample_class.py $(RELEASED)
	$(BIN)/python -m tests.sample_class build/release build/submitted
	@touch $@

grade: setup ## grade SUBMITTED (default build/submitted): <student>/<assignment>/
	$(BIN)/autograder grade $(SUBMITTED)/*/*

feedback: setup ## write a page for each submission, build/feedback
	$(BIN)/autograder feedback --site ../../html

# Only this class, which the course made itself, may be graded without a sandbox.
.PHONY: grade-class
grade-class:
	@$(BIN)/autograder doctor > /dev/null || { flag=--unsandboxed; \
		echo 'No sandbox works here (see `autograder doctor`): the sample class, which is our own,' \
		'is graded without one. Mend that before you grade anything else.'; }; \
	$(BIN)/autograder grade build/submitted/*/* $$flag; \
	$(BIN)/autograder feedback --site ../../html

data: setup ## download the public pose graphs; nothing else ever downloads them
	$(BIN)/python -m robust_slam.datasets

bench: setup ## compare the estimators with GTSAM's, and the grader with nbgrader
	$(BIN)/python -m benchmarks.wrong_closures
	$(BIN)/python -m benchmarks.grading

soak: setup ## the long tests: every wall and user, long fuzzing, our attacks on plain nbgrader
	@sh tests/system-packages.sh
	$(BIN)/python -m tests.autograder.hostile.soak
	$(BIN)/pytest -q --soak tests/autograder
	$(BIN)/python -m benchmarks.attacks

test: setup ## set up and pass all tests; STRICT=1 fails where one would be left out
	@sh tests/system-packages.sh
	@$(MAKE) check
	@$(MAKE) book
	ROBUST_SLAM_STRICT=$(filter-out 0,$(STRICT)) $(BIN)/pytest -q -n 2 --dist loadfile

format: setup ## format code and notebooks
	$(BIN)/ruff check --fix-only -q .
	$(BIN)/ruff format .

check: setup ## lint, format and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

lock: ## pin every dependency again (wants uv)
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
		--no-header --group book --group lab --group test --group check --group compare --group build \
		--extra sdp --extra data lib/pyproject.toml autograder/pyproject.toml -o requirements.lock

clean: ## remove all that was generated, the environment too
	rm -rf build _build $(VENV) .mypy_cache .pytest_cache .ruff_cache .hypothesis

# Every target does all of its own set-up on a machine that has Python 3.10 to 3.13, make and git.
SHELL := /bin/bash
PYTHON ?= python3
VENV := $(CURDIR)/.venv
REQUIREMENTS ?= requirements-dev.txt
BIN := $(VENV)/bin
SHARED := $(wildcard config/* examples/* launch/* urdf/*)
# Nodes of tests and demonstrations find each other on this machine only, on a domain of this run's own. They are started
# often, so their bytecode is kept. The threads of linear algebra would compete for the cores with our own.
ROS := export OPENBLAS_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE= HOME="$${HOME:-/tmp}" ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST ROS_DOMAIN_ID=$$(( $$$$ % 100 + 1 )) \
       VIRTUAL_ENV="$(VENV)" PATH="$(BIN):$$PATH" AMENT_PREFIX_PATH="$(VENV)"; . install/setup.bash;

# Two processes more than there are cores: tests of nodes often wait.
ALL_CORES := --numprocesses=$$(( $$(nproc) + 2 ))
# A file's tests share what they stand on; but the campaigns of one file may take longer than everything else.
BY_FILE := $(ALL_CORES) --dist=loadfile --no-loadscope-reorder
ONE_BY_ONE := $(ALL_CORES) --dist=worksteal

.PHONY: demo test test-all ubuntu check format bench docs fuzz build clean

demo: build  ## the data's whole way, from an emulated rig to served parameters, in some minutes
	@$(ROS) $(BIN)/python -m cdp_ident demo

test: build  ## every behaviour, nodes included, shared out over the cores
	@$(ROS) $(BIN)/python -m pytest $(BY_FILE)

test-all: build  ## the same with many more truths, seeds, kills and examples: before a release, and each night
	@$(ROS) $(BIN)/python -m pytest $(ONE_BY_ONE) -m "" --hypothesis-profile=campaign

# ROS's own linters. Methods say by their names what the magic ones do; a formula is no signature, a file's key no section.
# The dashes end the codes that are ignored: without them every file is looked at.
LINTED := -- cdp_ident launch examples setup.py
PEP257 := --convention google --add-ignore D105 D107 D214 D402 D405 D411

check: $(VENV)/.ready  ## format, lint, types and which subpackage imports which
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/ament_flake8 --config setup.cfg $(LINTED)
	$(BIN)/ament_pep257 $(PEP257) $(LINTED)
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

format: $(VENV)/.ready  ## what `check` asks for, as far as a tool can do it
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: build $(VENV)/.bench  ## how fast, beside what a user would use instead: docs/benchmarks.md, anew
	@$(ROS) $(BIN)/python -m benchmarks

docs: $(VENV)/.docs  ## the documents as a site, in build/site; a warning is an error
	$(BIN)/python -m sphinx -q -W --keep-going -d build/doctrees docs build/site
	@echo "build/site/index.html"

ubuntu: build  ## on Ubuntu 24.04's own versions: build with REQUIREMENTS=requirements-ubuntu-24.04.txt
	@$(ROS) $(BIN)/python -m cdp_ident identify --bag bags/swing_wide bags/swing_folded --once --figures --force --out build/found
	@$(ROS) $(BIN)/python -m pytest $(ONE_BY_ONE) test/nodes test/report/figures/test_for_paper.py \
	    --deselect test/report/figures/test_for_paper.py::test_the_same_figure_gives_the_same_bytes  # not so with matplotlib 3.6

fuzz: $(VENV)/.ready  ## damaged and hostile input for a minute; the seed is printed
	$(BIN)/python -m fuzz --seconds 60

build: install/.ready  ## the ROS 2 package, with colcon

install/.ready: $(VENV)/.ready setup.py setup.cfg package.xml cdp_ident/executables.py $(SHARED)
	@echo "building and compiling, once: about a minute on two cores"
	export VIRTUAL_ENV="$(VENV)" PATH="$(BIN):$$PATH" AMENT_PREFIX_PATH="$(VENV)"; \
	colcon --log-base log build --symlink-install --event-handlers console_cohesion- console_stderr-
	@touch $@

$(VENV)/.ready: $(wildcard requirements*.txt)
	@echo "setting up $(VENV), once: some minutes"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --disable-pip-version-check --quiet -r $(REQUIREMENTS)
	@touch $(VENV)/COLCON_IGNORE $@

$(VENV)/.docs: $(VENV)/.ready requirements-docs.txt
	$(BIN)/pip install --disable-pip-version-check --quiet -r requirements-docs.txt
	@touch $@

$(VENV)/.bench: $(VENV)/.ready requirements-bench.txt
	$(BIN)/pip install --disable-pip-version-check --quiet -r requirements-bench.txt
	@touch $@

clean:
	rm -rf $(VENV) build install log .mypy_cache .ruff_cache .pytest_cache .hypothesis

# Two commands for a new user: make demo, make test. `make help` lists the rest.
# Needs python3 (3.10 - 3.13, with venv), make and git; everything else goes into .venv.

PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
OUT    ?= out
PYTHONS ?= python3.10 python3.11 python3.12 python3.13
STAMP  := $(VENV)/.ready
export ROS_PYTHON_CHECK_FIELDS := 1

.DEFAULT_GOAL := help
.PHONY: help setup demo test lint compiled pythons bench accuracy figures fuzz clean

help:            ## this list
	@awk -F':.*## ' '/^[a-z]+:.*## /{printf "  make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

$(STAMP): setup.py pyproject.toml .ci/setup_venv.py
	@$(PYTHON) .ci/setup_venv.py $(VENV)
	@touch $@

setup: $(STAMP)  ## a virtual environment with everything (uses a sourced ROS 2 Jazzy if there is one)

demo: $(STAMP)   ## drive a simulated base over ROS 2 topics; odometry and slip against the truth
	@$(BIN)/mecanum demo --out $(OUT)/demo $(DEMO_ARGS)

test: $(STAMP)   ## static checks and the whole test suite
	@$(MAKE) --no-print-directory lint
	@$(BIN)/python -m pytest -q $(TEST_ARGS)

lint: $(STAMP)   ## ruff, mypy, import contracts
	@$(BIN)/ruff check src tests setup.py .ci
	@$(BIN)/mypy
	@$(BIN)/lint-imports --no-cache | tail -n 12

compiled: $(STAMP)  ## the compiled kernels (extra fast) against plain numpy; compiling takes minutes
	@COMPILED_TESTS=1 $(BIN)/python -m pytest -q tests/core/estimation/test_acceleration.py \
	  tests/bag/test_machine_code.py

pythons: $(STAMP)  ## the simulator gives the same readings with every Python 3.10 - 3.13 found
	@for p in $(PYTHONS); do $$p -m venv $(OUT)/pythons/$${p##*/} \
	  && $(OUT)/pythons/$${p##*/}/bin/pip install -q numpy PyYAML \
	  && found="$$found:$(OUT)/pythons/$${p##*/}/bin/python" || echo "$$p is left out"; done; \
	OTHER_PYTHONS=$$found $(BIN)/python -m pytest -q tests/sim/test_python_versions.py

bench: $(STAMP)  ## speed: estimator, replay, nodes, simulator
	@for b in tests/bench/bench_*.py; do echo "== $$b"; $(BIN)/python $$b || exit 1; done

accuracy: $(STAMP)  ## Monte Carlo accuracy over the scenarios (long)
	@$(BIN)/python -m mecanum_base.accuracy --out $(OUT)/accuracy $(ACCURACY_ARGS)

SLIP_AND_NONE := square,circle_spin,figure8,strafe,slope,carpet_tile,uneven,hard_accel,oil,ice_lane,wheel_lift,wheel_jam,pushed,collision
figures: $(STAMP)  ## every figure and table of docs/estimator.md and docs/accuracy.md (long)
	@$(BIN)/python tests/bench/estimator_picture.py
	@$(BIN)/python tests/bench/smoothed_table.py --doc docs/estimator.md
	@$(BIN)/python tests/bench/bench_estimator.py
	@$(BIN)/python -m mecanum_base.accuracy --out $(OUT)/accuracy --told --seeds 20 --first-seed 39000 \
	  --scenarios $(SLIP_AND_NONE)
	@$(BIN)/python -m mecanum_base.accuracy --out $(OUT)/uneven --seeds 100 --first-seed 37000 --scenarios uneven

fuzz: $(STAMP)   ## 10 000 mutated bags (long)
	@$(BIN)/python tests/fuzz/fuzz_bags.py $(FUZZ_ARGS)

clean:           ## remove everything that was made
	rm -rf $(VENV) $(OUT) build install log .pytest_cache .mypy_cache .ruff_cache .hypothesis

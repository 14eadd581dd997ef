# navtwin: `make run` and `make test` need Python 3.11+ and nothing else installed.
PYTHON ?= $(shell for p in python3.11 python3.12 python3.13 python3; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed

STEPS  := 10000

.DEFAULT_GOAL := help
.PHONY: help setup run test lint types arrows unit soak bench firmware pil clean

help:  ## show this list
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-8s %s\n", $$1, $$2}'

setup: $(STAMP)  ## make .venv with the command navtwin in it
	@$(BIN)/python -m hal.engine_build

$(STAMP): pyproject.toml
	@test -n "$(PYTHON)" || { echo "navtwin needs Python 3.11 or newer; give one: make PYTHON=/path/to/python3"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --upgrade pip
	$(BIN)/pip install --quiet --disable-pip-version-check --no-compile --editable '.[dev]'
	$(BIN)/python -m compileall -q -j 0 boards firmware hal host
	@touch $(STAMP)

run: setup  ## the main job: the car_mems board on a simulated drive through town
	$(BIN)/navtwin run car_mems --scenario town

test: lint arrows  ## lint, types, import arrows and tests
	@$(MAKE) --no-print-directory -j 2 types unit

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: setup
	$(BIN)/mypy

arrows: setup
	$(BIN)/lint-imports

unit: setup
	$(BIN)/pytest -q -n 2 -m 'not soak'

soak: setup  ## slow statistical runs: many seeds, long drives
	$(BIN)/pytest -q -n 2 -m soak

bench: setup  ## where the microseconds go, as x real time
	$(BIN)/python -m host.bench

firmware: setup  ## images of the navigation kernels for an STM32F405, in build/ (needs gcc-arm-none-eabi)
	$(BIN)/navtwin build car_mems --target stm32f405
	$(BIN)/navtwin build uav_ahrs --profile float32 --target stm32f405
	$(BIN)/navtwin build uav_ahrs --profile fixed --target stm32f405

pil: setup  ## the same kernels on an emulated STM32F405, compared bit by bit (needs qemu-system-arm)
	$(BIN)/navtwin pil car_mems --scenario static --steps $(STEPS)
	$(BIN)/navtwin pil uav_ahrs --profile float32 --steps $(STEPS)
	$(BIN)/navtwin pil uav_ahrs --profile fixed --steps $(STEPS)

clean:  ## remove the virtual environment and all caches
	rm -rf $(VENV) build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

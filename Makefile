# navtwin: `make run` and `make test` need Python 3.11+ and nothing else installed.
PYTHON ?= $(shell for p in python3.11 python3.12 python3.13 python3; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
VENV   := .venv
BIN    := $(VENV)/bin
TOOLS  := $(VENV)/.translator
STAMP  := $(VENV)/.installed

# Byte code is kept whatever the environment says: the tests begin hundreds of processes with the same imports.
unexport PYTHONDONTWRITEBYTECODE

PIP_INSTALL = $(BIN)/pip install --quiet --disable-pip-version-check --no-compile

STEPS  := 10000
PIL_PARTS := pil-gate pil-tests pil-full-rate pil-thesis pil-float32 pil-fixed pil-gfsins pil-alone
PIL_PACKAGES := gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm

.DEFAULT_GOAL := help
.PHONY: help setup engine run test lint types arrows unit soak bench firmware pil clean \
	pil-gate pil-full-rate pil-thesis pil-float32 pil-fixed pil-gfsins pil-alone pil-tests

help:  ## show this list
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-8s %s\n", $$1, $$2}'

setup: $(STAMP) engine  ## make .venv with the command navtwin in it

engine: $(TOOLS)
	@$(BIN)/python -m hal.engine_build

# What translates the engine comes first: `make -j 2 setup` translates it while all the rest is fetched.
$(TOOLS): pyproject.toml
	@test -n "$(PYTHON)" || { echo "navtwin needs Python 3.11 or newer; give one: make PYTHON=/path/to/python3"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	grep -oE '"(mypy|setuptools)[<>=][^"]*"' pyproject.toml | sort -u | xargs $(PIP_INSTALL)
	@touch $(TOOLS)

$(STAMP): $(TOOLS)
	$(PIP_INSTALL) --editable '.[dev]'
	$(BIN)/python -m compileall -q -j 0 boards firmware hal host
	@touch $(STAMP)

run:  ## the main job: the car_mems board on a simulated drive through town
	@$(MAKE) --no-print-directory -j 2 setup
	$(BIN)/navtwin run car_mems --scenario town

test:  ## lint, types, import arrows and tests
	@$(MAKE) --no-print-directory -j 2 setup
	@$(MAKE) --no-print-directory lint arrows
	@$(MAKE) --no-print-directory -j 2 types unit

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/mypy

arrows: $(STAMP)
	$(BIN)/lint-imports

unit: setup
	$(BIN)/pytest -q -n 2 -m 'not soak'

soak: setup  ## slow statistical runs: many seeds, long drives
	$(BIN)/pytest -q -n 2 -m soak

bench: setup  ## where the microseconds go, as x real time
	$(BIN)/python -m host.bench

firmware: setup  ## images of the navigation kernels for an STM32F405, in build/ (needs gcc-arm-none-eabi)
	$(BIN)/navtwin build car_mems --target stm32f405
	$(BIN)/navtwin build car_mems --profile thesis --target stm32f405
	$(BIN)/navtwin build uav_ahrs --profile float32 --target stm32f405
	$(BIN)/navtwin build uav_ahrs --profile fixed --target stm32f405
	$(BIN)/navtwin build gfsins --target stm32f405

pil:  ## the same kernels on an emulated STM32F405, compared bit by bit; says what it needs where that is missing
	@missing=$$(for tool in arm-none-eabi-gcc qemu-system-arm; do \
		command -v $$tool > /dev/null || printf ' %s' $$tool; done); \
	if [ -n "$$missing" ]; then \
		echo "make pil: SKIPPED, not installed:$$missing; on Debian and Ubuntu: apt install $(PIL_PACKAGES)"; \
	else $(MAKE) --no-print-directory -j 2 $(PIL_PARTS); fi

pil-full-rate: setup
	$(BIN)/navtwin pil car_mems --profile full-rate --scenario static --steps $(STEPS) -q
pil-thesis: setup
	$(BIN)/navtwin pil car_mems --profile thesis --scenario static --steps $(STEPS) -q
pil-float32: setup
	$(BIN)/navtwin pil uav_ahrs --profile float32 --steps $(STEPS) -q
pil-fixed: setup
	$(BIN)/navtwin pil uav_ahrs --profile fixed --steps $(STEPS) -q
pil-gfsins: setup
	$(BIN)/navtwin pil gfsins --steps $(STEPS) -q
pil-alone: setup
	$(BIN)/navtwin pil car_mems --stand-alone --scenario town-open --set duration_s=100 -q
pil-gate: setup
	$(BIN)/pytest -q -m soak tests/dialect
pil-tests: setup
	$(BIN)/pytest -q -m soak tests/pil

clean:  ## remove the virtual environment and all caches
	rm -rf $(VENV) build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Everything Carom's development needs; each target sets up what it lacks in .venv.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test serve bench study lint clean

demo: $(READY)  ## render the demo score to demo.wav and draw demo.png
	$(BIN)/carom render presets/scores/demo.txt demo.wav --plot demo.png
	@echo "demo.wav and demo.png are here"

test: $(READY) lint  ## linters, types and tests
	$(BIN)/python -m pytest

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	rm -rf build $(VENV)/wheel
	$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir $(VENV)/wheel .
	$(BIN)/python -m zipfile -e $(VENV)/wheel/*.whl $(VENV)/wheel
	PYTHONPATH=$(VENV)/wheel $(BIN)/lint-imports
	$(BIN)/mypy

serve: $(READY)  ## listen for OSC and play on the default device, or on none where there is no PortAudio
	@if $(BIN)/carom devices 2>/dev/null | grep -q .; then $(BIN)/carom serve; else \
	  echo "no PortAudio, or no device: playing on none (Debian: apt install libportaudio2)" >&2; \
	  $(BIN)/carom serve --device none; fi

bench: $(READY)  ## measure speed; figures go to bench.json
	$(BIN)/python -m tests.bench.bench --json bench.json

study: $(READY)  ## what takes an hour: extreme contacts, a long evening, threads that hog, a million packets
	$(BIN)/python -m tests.bench.extremes
	$(BIN)/python -m tests.bench.soak --minutes 10
	$(BIN)/python -m tests.bench.overload
	$(BIN)/python -m tests.bench.gil --seconds 60
	$(BIN)/python -m tests.bench.fuzz --count 1000000

$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "Python 3.10 or newer is needed; found $$($(PYTHON) --version). Try make PYTHON=python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null || \
	  { echo "Python lacks venv (Debian: apt install python3-venv)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@

clean:
	rm -rf $(VENV) build *.egg-info demo.wav demo.png bench.json

# Everything Carom's development needs; each target sets up what it lacks in .venv.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
DEV := $(VENV)/.dev

# uv installs in a tenth of the time that pip takes.
UV := $(shell command -v uv 2>/dev/null)
INSTALL := $(if $(UV),$(UV) pip install --quiet --python $(BIN)/python,\
  $(BIN)/python -m pip install -qq --disable-pip-version-check)

CHECK := $(BIN)/check-jsonschema --quiet --builtin-schema
LAST := $(VENV)/.test-time

.PHONY: help demo quick test portable checked attack coverage serve bench chart levels sounds picture documents site study lint clean

help:  ## list the targets
	@sed -n 's/^\([a-z]*\):.*## /  \1\t/p' Makefile

demo: $(READY)  ## render the demo score to demo.wav and draw demo.png
	@echo "rendering presets/scores/demo.txt"
	@$(BIN)/carom render presets/scores/demo.txt demo.wav --plot demo.png
	@echo "demo.wav and demo.png are here"

quick: $(DEV)  ## the tests that are fast: about two minutes on two cores, once the engine is compiled
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -m "not slow" -n 2 --dist worksteal

test: $(DEV) lint  ## linters, types and all tests: some twenty minutes on two cores
	@echo "all tests: $$(cat $(LAST) 2>/dev/null || echo 'some twenty minutes on two cores'); make quick runs the fast ones"
	@begun=$$(date +%s); OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist worksteal || exit; \
	  echo "$$((($$(date +%s) - begun + 59) / 60)) minutes the last time" >$(LAST)

portable: $(DEV)  ## all tests under each BLAS kernel and level of this processor, and as another user: hours
	@$(BIN)/python .ci/passes --all


MINUTES ?= 10
SEED ?= 0
checked: $(DEV)  ## engine tests and MINUTES=10 of random scores from SEED=0 on, by kernels that check their indices
	@CAROM_CHECKED=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -m "not slow" -n 2 --dist worksteal \
	  $(addprefix tests/dsp/,contact engine friction karman resonator rolling runtime space spectral swarm) tests/server/scene
	@$(BIN)/python -m tests.bench.checked --minutes $(MINUTES) --seed $(SEED)

coverage: $(DEV)  ## all tests, and which lines of the Python side they run (kernels are compiled, and not seen)
	@$(BIN)/coverage erase
	@$(BIN)/coverage run -m pytest
	@$(BIN)/coverage combine --quiet
	@$(BIN)/coverage report

lint: $(DEV)  ## linters, import contracts and types
	@$(BIN)/ruff check --quiet .
	@$(BIN)/ruff format --quiet --check .
	@$(CHECK) vendor.github-workflows .github/workflows/*.yml
	@$(CHECK) custom.github-workflows-require-timeout .github/workflows/*.yml
	@$(CHECK) vendor.github-issue-forms .github/ISSUE_TEMPLATE/bug.yml .github/ISSUE_TEMPLATE/idea.yml
	@$(CHECK) vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	@$(CHECK) vendor.dependabot .github/dependabot.yml
	@$(CHECK) vendor.citation-file-format CITATION.cff
	@rm -rf build $(VENV)/wheel
	@CAROM_WHEEL=source $(BIN)/python -m pip wheel -qq --no-deps --no-build-isolation --wheel-dir $(VENV)/wheel .
	@$(BIN)/python -m zipfile -e $(VENV)/wheel/*.whl $(VENV)/wheel
	@PYTHONPATH=$(VENV)/wheel $(BIN)/lint-imports --no-logo
	@$(BIN)/mypy

serve: $(READY)  ## listen for OSC and play on the default device, or on none where there is no PortAudio
	@if $(BIN)/carom devices >/dev/null; then $(BIN)/carom serve; else $(BIN)/carom serve --device none; fi

bench: $(DEV)  ## measure speed; figures go to tests/measured, and from there into tests/speed.md
	$(BIN)/python -m tests.bench.bench --json tests/measured/bench.json
	@$(BIN)/python -m tests.documents.pages

chart: $(DEV)  ## measure speed against accuracy; figures go to tests/measured, and from there into tests/methods.md
	$(BIN)/carom chart build/chart
	@$(BIN)/python -m tests.documents.study build/chart
	@$(BIN)/python -m tests.documents.pages

levels: $(DEV)  ## make the built-in objects equally loud when struck, and measure their gestures
	$(BIN)/python -m tests.bench.loudness
	@$(BIN)/python -m tests.documents.pages

sounds: $(DEV)  ## render the sounds and draw the pictures of the documents
	@$(BIN)/python -m tests.documents.sounds

picture: $(DEV)  ## take the picture of the page, in Chromium
	@$(BIN)/python -m tests.documents.screenshot

documents: $(DEV)  ## write the tables of all pages
	@$(BIN)/python -m tests.documents.pages

site: $(DEV)  ## build a web site from the pages, with sounds and the demo, in build/site
	@$(BIN)/python -m tests.documents.site

attack: $(DEV)  ## try to break what SECURITY.md promises, for 15 minutes, with a seed of its own
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.bench.attack

study: $(DEV)  ## the hour-long stress tests: recordings, gongs, data sets, simulators, meshes, files of other packages, extreme contacts, a long evening, threads that hog, a million packets
	$(BIN)/python -m tests.bench.recordings
	$(BIN)/python -m tests.bench.decays
	$(BIN)/python -m tests.bench.harmonics
	$(BIN)/python -m tests.bench.held --json tests/measured/held.json
	$(BIN)/python -m tests.bench.listening build/listening.html
	$(BIN)/python -m tests.bench.gongs
	$(BIN)/python -m tests.bench.fits
	$(BIN)/python -m tests.bench.elsewhere
	$(BIN)/python -m tests.bench.worlds
	$(BIN)/python -m tests.bench.simulators
	$(BIN)/python -m tests.bench.datasets
	$(BIN)/python -m tests.bench.meshes --json tests/measured/meshes.json
	$(BIN)/python -m tests.bench.meshes --only accuracy --fine --json tests/measured/meshes.json
	$(BIN)/python -m tests.bench.corpus --models
	$(BIN)/python -m tests.bench.chances
	$(BIN)/python -m tests.bench.extremes
	$(BIN)/python -m tests.bench.extreme_groups
	$(BIN)/python -m tests.bench.rests
	$(BIN)/python -m tests.bench.piles
	$(BIN)/python -m tests.bench.rest_errors
	$(BIN)/python -m tests.bench.waveforms
	$(BIN)/python -m tests.bench.friction
	$(BIN)/python -m tests.bench.exactness
	$(BIN)/python -m tests.bench.soak --minutes 10
	$(BIN)/python -m tests.bench.hours
	$(BIN)/python -m tests.bench.overload
	$(BIN)/python -m tests.bench.bursts
	$(BIN)/python -m tests.bench.gil --seconds 60
	$(BIN)/python -m tests.bench.fuzz --count 1000000
	$(BIN)/python -m tests.bench.crowd --count 20000
	$(BIN)/python -m tests.bench.logs --runs 30
	$(BIN)/python -m tests.bench.ends
	$(BIN)/python -m tests.bench.queries
	$(BIN)/python -m tests.bench.page
	$(BIN)/python -m tests.bench.web
	$(BIN)/python -m tests.bench.library
	$(BIN)/python -m tests.bench.starts
	$(BIN)/python -m tests.bench.installs
	$(BIN)/python -m tests.bench.compiling --json tests/measured/compiling.json
	$(BIN)/python -m tests.bench.memory --minutes 30

# What plays. What compiles the engine comes first: the rest is installed meanwhile.
$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "Python 3.10 or newer is needed; found $$($(PYTHON) --version). Try make PYTHON=python3.11" >&2; exit 1; }
	@test -n "$(UV)" || $(PYTHON) -c 'import ensurepip' 2>/dev/null || \
	  { echo "Python lacks venv (Debian: apt install python3-venv)" >&2; exit 1; }
	@echo "setting up $(VENV) with $(if $(UV),uv,pip), and compiling the engine: a minute or two, some 600 MB"
	@test -x $(BIN)/python || $(if $(UV),$(UV) venv --quiet --seed --python $(PYTHON),$(PYTHON) -m venv) $(VENV)
	@$(BIN)/python -c 'import ast; said = next(line for line in open("pyproject.toml") if line.startswith("requires = ")); \
	  print(*ast.literal_eval(said[11:]), sep="\n")' >$(VENV)/compiler.txt
	@$(INSTALL) -r $(VENV)/compiler.txt
	@$(INSTALL) --no-deps --no-build-isolation --editable .
	@$(BIN)/python -c 'from carom.dsp.runtime.engine import prepare; prepare()' & compiling=$$!; \
	  trap 'kill $$compiling; exit 130' INT TERM; \
	  $(INSTALL) --no-build-isolation $(if $(UV),-r pyproject.toml --extra compile --extra plot,'carom[compile,plot]'); installed=$$?; \
	  wait $$compiling && exit $$installed
	@touch $@

# What tests, checks and measures.
$(DEV): $(READY)
	@echo "installing what tests, checks and measures: some 500 MB more"
	@$(INSTALL) --no-build-isolation $(if $(UV),-r pyproject.toml --extra dev,'carom[dev]')
	@touch $@

clean:
	rm -rf $(VENV) build dist *.egg-info demo.wav demo.png .coverage .coverage.*

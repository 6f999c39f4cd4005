# make run       first use: installs, runs the default scene, prints where tables and pictures are
# make test      the quick tests;  make test-all  the slow ones too;  make lint  style, types, import contracts

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
SCENE := out/caisson.toml
RESULT := out/caisson

.PHONY: run test test-slow test-all verification lint docs accuracy bench reference clean

run: $(STAMP)
	@test -f $(SCENE) || $(BIN)/pysprings init $(SCENE)
	$(BIN)/pysprings run $(SCENE) --out $(RESULT) --force

test: $(STAMP)
	$(BIN)/python -m pytest

test-slow: $(STAMP)
	$(BIN)/python -m pytest -m slow -n 2 || test $$? -eq 5  # 5: there are none

test-all: $(STAMP)
	$(BIN)/python -m pytest -m "slow or not slow"

verification: $(STAMP)
	$(BIN)/python -m tests.verification.table

# the paper's figures and tables in docs/: runs what has not run yet (8 minutes on `medium`, then the sensitivities)
MESH ?= medium
docs: $(STAMP)
	$(BIN)/pysprings paper --mesh $(MESH) --sensitivity --out out/paper-$(MESH)
	$(BIN)/python -m benchmarks.paper_docs out/paper-$(MESH) --mesh $(MESH)

# the study behind --target-error and docs/accuracy.md: runs what has not run yet
accuracy: $(STAMP)
	$(BIN)/pysprings accuracy data/scenes/service-load.toml --out out/accuracy --write-presets pysprings/accuracy/presets.json
	cp out/accuracy/accuracy.md out/accuracy/accuracy.png docs/

# what the solver costs, as ratios of one run (about half an hour; SECTION=units for one of them)
bench: $(STAMP)
	$(BIN)/python -m benchmarks.bench $(SECTION)

# the small results that the regression test compares with
reference: $(STAMP)
	$(BIN)/pysprings paper --mesh coarse --out out/paper-coarse --force
	$(BIN)/python -m benchmarks.paper_reference out/paper-coarse

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || \
		{ echo "Python 3.11 to 3.13 is needed; give one: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[dev]"
	@touch $(STAMP)

clean:
	rm -rf $(VENV) out build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis

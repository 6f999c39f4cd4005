# make run       first use: installs the package alone, runs the default scene, prints where tables and pictures are
# make test      the quick tests, seconds each;  make test-slow  about a minute each;  make test-long  many minutes each;
# make test-all  all of them;  make lint  style, types, import contracts
# make site      the documentation site in out/site;  make gallery  the same with all examples run
#                (these install what development needs, too: open packages alone)
# make extras    also Intel's MKL (1 GB) and openseespy, without which the tests of both are skipped (THIRD-PARTY.md: licences)
# make test-lowest  a few tests with the oldest dependencies that pyproject.toml allows

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DEV := $(VENV)/.installed-dev
DOCS := $(VENV)/.installed-docs
LOWEST := .venv-lowest
SCENE := out/caisson.toml
# compiled modules are kept, whatever the caller's environment asks for
export PYTHONDONTWRITEBYTECODE :=
RESULT := out/caisson

# quick ones that touch every dependency; a run of the engine among them
LOWEST_TOOLS := "pytest>=8.3" "pytest-timeout>=2.3" "hypothesis>=6.120" "cf-xarray>=0.10"
LOWEST_TESTS := $(addprefix tests/pysprings/,scene/test_load.py core/test_units.py core/test_storage.py \
	$(addprefix results/test_,tables.py exporters.py plots.py report.py))

# uv takes a quarter of pip's time; pip where uv is not to be had
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
UV := $(BIN)/uv pip install --quiet --python $(BIN)/python
install = get() { { $(PIP) "uv>=0.8" && $(UV) -e "$$1"; } || $(PIP) -e "$$1"; }; get

# pages of an earlier run of the gallery stay as they are; GALLERY=1 runs the examples whose text has changed
SPHINX = $(BIN)/python -m sphinx -b html -q -W --keep-going docs out/site

.PHONY: extras site gallery screenshots build wheel-check release run test test-lowest test-slow test-long test-all mutation audit verification verification-data lint pages figure paper paper-evidence accuracy stability bench bench-peers turbine reference clean

run: $(STAMP)
	@test -f $(SCENE) || $(BIN)/pysprings init $(SCENE)
	$(BIN)/pysprings run $(SCENE) --out $(RESULT) --force

# what is not open software, for tests that compare with it; without them these are skipped
extras: $(DEV)
	$(install) ".[dev,mkl,opensees]"

site: $(DOCS)
	rm -rf docs/reference/api
	$(SPHINX)
	@echo "the site is in out/site: open out/site/index.html"

gallery: $(DOCS)
	GALLERY=1 $(SPHINX)

# pictures of the site, and of the report and workbook of a run, for docs/evidence, by Chromium and LibreOffice
screenshots: $(DOCS)
	$(BIN)/python -m tools.pictures screenshots $(RESULT)

test: $(DEV)
	$(BIN)/python -m pytest -n 2 --dist worksteal

# what users of old packages get: every lower bound at once. Compiled code of another Numba goes to another place
test-lowest: $(DEV)
	$(BIN)/uv venv --quiet --clear --python $(BIN)/python $(LOWEST)
	$(BIN)/uv pip install --quiet --python $(LOWEST)/bin/python --resolution lowest-direct --only-binary :all: \
		-r pyproject.toml $(LOWEST_TOOLS)
	$(BIN)/uv pip install --quiet --python $(LOWEST)/bin/python --no-deps -e .
	NUMBA_CACHE_DIR=$(CURDIR)/$(LOWEST)/numba $(LOWEST)/bin/python -m pytest -q -p no:cacheprovider $(LOWEST_TESTS)

# wheel and sdist in dist/; the wheel in fresh environments of every Python that is there; a release (DRY=1 shows it)
build: $(DEV)
	rm -rf dist
	$(BIN)/uv build --quiet --out-dir dist

wheel-check: $(DEV)
	$(BIN)/python -m tools.wheel_check

release: $(DEV)
	$(BIN)/python -m tools.release $(VERSION) $(if $(DRY),--dry-run)

test-slow: $(DEV)
	$(BIN)/python -m pytest -m "slow and not long" -n 2 --dist worksteal

test-long: $(DEV)
	$(BIN)/python -m pytest -m long

test-all: test test-slow test-long

# how many small changes of the code the tests notice: about a minute a mutant; survivors alone when called again
SAMPLE ?= 40
SEED ?= 1
mutation: $(DEV)
	$(BIN)/python -m tools.mutation --sample $(SAMPLE) --seed $(SEED)

verification: $(DEV)
	$(BIN)/python -m tests.verification.table

# the table behind docs/evidence/verification.md (35 CPU minutes, 9 GB)
verification-data: $(DEV)
	mkdir -p out
	$(BIN)/python -m tests.verification.table --out out/verification.csv
	$(BIN)/python -m tools.evidence_store verification out/verification.csv --command "make verification-data"

# the generated pages of docs/reference, from the program; runs nothing
pages: $(DEV)
	$(BIN)/python -m tools.reference_pages

# advisories on the installed packages; pip-audit runs in an environment of its own, and asks PyPI
audit: $(DEV)
	mkdir -p out
	$(BIN)/uv pip freeze --quiet --exclude-editable --python $(BIN)/python > out/installed.txt
	$(BIN)/uv tool run pip-audit --no-deps --disable-pip --requirement out/installed.txt

# the picture of the README, and the errors of the fan on `coarse` (18 paths: a few minutes)
figure: $(DEV)
	$(BIN)/pysprings init out/fan.toml --template fan --force
	$(BIN)/pysprings run out/fan.toml --mesh coarse --out out/fan --force
	$(BIN)/python -m tools.pictures figure out/fan

# the study of the paper behind the model: its runs, figures, claims beside ours, in out/paper-MESH; runs what has not
# run yet (8 minutes on `medium`; SENSITIVITY=1 also varies what the paper leaves open). Its tables and pictures as evidence
MESH ?= medium
paper: $(DEV)
	$(BIN)/python -m validation.paper --mesh $(MESH) $(if $(SENSITIVITY),--sensitivity) --out out/paper-$(MESH)

paper-evidence: $(DEV)
	$(BIN)/python -m validation.paper --mesh $(MESH) --sensitivity --out out/paper-$(MESH)
	$(BIN)/python -m validation.paper.evidence out/paper-$(MESH) --mesh $(MESH)

# the study behind docs/evidence/accuracy.md: runs what has not run yet
STUDY := pysprings accuracy data/scenes/service-load.toml
accuracy: $(DEV)
	$(BIN)/$(STUDY) --out out/accuracy
	$(BIN)/python -m tools.evidence_store accuracy out/accuracy/accuracy.md --command "$(STUDY)"
	cp out/accuracy/accuracy.png docs/evidence/

# the catalogue of docs/evidence/stability.md (two minutes)
CATALOGUE := pysprings stability --refinement 0.6
stability: $(DEV)
	$(BIN)/$(CATALOGUE) --out out/stability
	$(BIN)/python -m tools.evidence_store stability-small out/stability/stability.md --command "$(CATALOGUE)"
	cp out/stability/stability.png docs/evidence/

# what the solver costs, as ratios of one run (about half an hour; SECTION=units for one of them)
bench: $(DEV)
	$(BIN)/python -m benchmarks.bench $(SECTION)

# an elastic caisson, and pushes with contact, in OpenSees and CalculiX, where they are there
bench-peers: $(DEV)
	$(BIN)/python -m benchmarks.peers

# OpenFAST's NREL 5 MW turbine on one bucket, into out/turbine: OpenFAST 5.x in the search path, RTEST=its folder r-test
turbine: $(DEV)
	test -f out/bucket/springs.nc || { $(BIN)/pysprings init out/bucket.toml --template monobucket --force && \
		$(BIN)/pysprings run out/bucket.toml --set springs.memory=true --no-estimate-error --out out/bucket --force; }
	$(BIN)/python -m benchmarks.openfast_turbine out/bucket/springs.nc out/turbine --rtest $(RTEST)

# the small results that the regression test compares with
reference: $(DEV)
	$(BIN)/python -m validation.paper --mesh coarse --out out/paper-coarse --force
	$(BIN)/python -m validation.paper.reference out/paper-coarse

lint: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m tools.ratchet

$(VENV)/pyvenv.cfg:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or newer is needed; give one: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(STAMP): pyproject.toml | $(VENV)/pyvenv.cfg
	$(install) .
	@touch $(STAMP)

$(DEV): pyproject.toml | $(VENV)/pyvenv.cfg
	$(install) ".[dev]"
	@touch $(STAMP) $(DEV)

$(DOCS): pyproject.toml | $(VENV)/pyvenv.cfg
	$(install) ".[docs]"
	@touch $(STAMP) $(DOCS)

clean:
	rm -rf $(VENV) $(LOWEST) out build dist docs/reference/api docs/gallery .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis

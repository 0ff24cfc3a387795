# Everything a newcomer needs: make demo, make test.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready

.PHONY: demo test suite test-all test-hostile lint fmus bench pictures docs clean

demo: $(READY)
	$(BIN)/feeddrive demo

test: lint suite

suite: $(READY)
	$(BIN)/pytest -n auto --dist worksteal

test-all: lint
	$(BIN)/pytest -n auto --dist worksteal --every-form

# FMUs that break, files that lie, calls that fail; draws and order change with the commit.
test-hostile: $(READY)
	$(BIN)/pytest -n auto tests/hostile --hostile --minutes 20

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

fmus: $(READY)
	$(BIN)/feeddrive build --all --platform all -o dist/fmus

$(READY): pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -qq --upgrade "pip>=25.1"
	$(BIN)/python -m pip install -qq --editable . --group dev
	touch $@

bench: $(READY)
	$(BIN)/python tests/benchmarks/bench.py

clean:
	rm -rf .venv dist runs

pictures: $(READY)
	$(BIN)/python docs/make_pictures.py
	$(BIN)/python docs/make_loop_pictures.py

docs: $(READY)
	$(BIN)/python docs/site/make.py

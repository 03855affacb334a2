# Every command sets up what it needs: Python >= 3.11, git and make are enough.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# System libraries that Qt loads, even to draw without a display (Debian's and Ubuntu's names).
QT_LIBRARIES := libegl1 libgl1 libxkbcommon0 libdbus-1-3 libfontconfig1 libglib2.0-0
QT_CHECK := QT_QPA_PLATFORM=offscreen $(BIN)/python -c \
  "from PySide6 import QtSvg, QtWidgets; QtWidgets.QApplication([])"

.PHONY: figure5 test test-slow bench lint lock clean qt

## Produce the comparison table and picture of figure 5's first scene, in out/.
figure5: $(STAMP)
	$(BIN)/flatland compare fig5-one-light --bands 2,4,8 -o out/fig5-one-light.png

## Style, types, import contracts and the whole fast test suite.
test: $(STAMP) qt lint
	$(BIN)/python -m pytest -n 2

## The deep checks that take minutes.
test-slow: $(STAMP) qt
	$(BIN)/python -m pytest -n 2 -m slow

## Speed, as ratios to limits measured in the same run.
bench: $(STAMP)
	$(BIN)/python -m pytest benchmarks -q -s -p no:xdist

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

## See that Qt loads; where it does not and this is root on Debian or Ubuntu, install what it needs.
qt: $(STAMP)
	@$(QT_CHECK) 2> /dev/null || { \
	  echo "Qt misses system libraries: $(QT_LIBRARIES)"; \
	  if [ "$$(id -u)" = 0 ] && command -v apt-get > /dev/null; then \
	    apt-get update -qq && apt-get install -y -qq --no-install-recommends $(QT_LIBRARIES); \
	  else \
	    echo "Install them: sudo apt-get install $(QT_LIBRARIES)"; exit 1; \
	  fi; $(QT_CHECK); }

## Refresh the lock: exact versions and hashes of everything that is installed.
lock: $(STAMP)
	$(BIN)/python -m pip install -q uv
	$(BIN)/uv pip compile pyproject.toml --group dev --universal --python-version 3.11 \
	  --generate-hashes --no-emit-index-url --no-emit-find-links -q -o requirements.lock

$(STAMP): requirements.lock pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("flatland needs Python 3.11 or newer, this is " + sys.version.split()[0]) if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

clean:
	rm -rf $(VENV) out .pytest_cache .mypy_cache .ruff_cache .hypothesis

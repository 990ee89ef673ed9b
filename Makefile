# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Every goal works from a fresh clone: the environment is made when it is missing or older than pyproject.toml.

SHELL := /bin/bash
VENV  := .venv
READY := $(VENV)/.ready

# What the caller may set, besides VENV; these reach recipes through the environment, where spaces are safe.
export PYTHON :=
export BPY    := bpy
export SCENE  := sample_blends/cornell.blend
export OUT    := out
export DIST   := dist
PYTHONS       := 3.11 3.13
ARGS          :=

.PHONY: help bake test bench references lint extension samples environment clean

help:
	@echo 'make bake       bake SCENE (sample_blends/cornell.blend) with all techniques, compare with Cycles, into OUT/'
	@echo 'make test       run the tests; ARGS="-k name" goes to pytest'
	@echo 'make bench      measure everything, into OUT/bench/; QUICK=1 for 4 minutes, PREVIOUS=bench.json to compare,'
	@echo '                README=1 to put the tables into tests/benchmarks/README.md'
	@echo 'make references render with Cycles what tests compare pictures with, after a change of sample_blends/'
	@echo 'make lint       look for mistakes with ruff'
	@echo 'make extension  build and validate the zips of the extension, into DIST; PYTHONS="$(PYTHONS)"'
	@echo 'make samples    build sample_blends/*.blend again, with Blender 4.5'
	@echo 'make clean      remove the environments and everything built or baked here'
	@echo 'The environment is made once, in VENV=$(VENV) with PYTHON (found where not given) and BPY="$(BPY)".'

bake: $(READY)
	@$(VENV)/bin/gi-bake compare "$$SCENE" --method rsm,lpv,ssgi --curves --reference-samples 512 \
	  --output "$$OUT/$$(basename "$$SCENE" .blend)" --save

test: $(READY)
	@$(VENV)/bin/python -m pytest $(ARGS)

bench: $(READY)
	@$(VENV)/bin/python tests/benchmarks/suite.py --output "$$OUT/bench" $(if $(QUICK),--quick) \
	  $(if $(PREVIOUS),--previous '$(PREVIOUS)') $(if $(README),--readme tests/benchmarks/README.md) $(ARGS)

references: $(READY)
	@$(VENV)/bin/python tests/references/build.py $(ARGS)

lint: $(READY)
	@$(VENV)/bin/ruff check

extension: $(READY)
	@$(VENV)/bin/python .ci/extension.py --pythons $(PYTHONS) --output "$$DIST"

# Saved by Blender 4.5, whose files every later Blender opens.
samples:
	@python="$${PYTHON:-$$(.ci/find-python 3.11)}" \
	  && $(MAKE) --no-print-directory environment VENV=.venv45 PYTHON="$$python" BPY='bpy==4.5.*'
	@.venv45/bin/python sample_blends/build.py

environment: $(READY)

# bpy has wheels for two Pythons: 3.13 has the newest Blender, 3.11 the line of 4.5.
$(READY): pyproject.toml
	@python="$${PYTHON:-$$(.ci/find-python 3.13 3.11)}" && version="$$("$$python" --version)" \
	  && echo "Making $(VENV) with $$version and Blender as a module (half a gigabyte)" >&2 \
	  && { $(VENV)/bin/python -c '' 2>/dev/null || "$$python" -m venv $(VENV); } \
	  && $(VENV)/bin/python -m pip install -qq --disable-pip-version-check -e '.[dev]' "$$BPY" \
	  && touch $@

clean:
	rm -rf .venv .venv45 build dist out *.egg-info .pytest_cache .ruff_cache
	find addon gi_core tests sample_blends .ci -name __pycache__ -prune -exec rm -rf {} +
	rm -rf __pycache__

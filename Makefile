PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin/python -m
INSTALL := $(RUN) pip install --quiet --disable-pip-version-check --no-compile --constraint constraints.txt --editable
# Where Python may write no bytecode, every process would compile all that it imports: a second, each time. It imports
# neither all of Blender nor the tests of libraries.
COMPILE := $(RUN) compileall -q -j 0 -x '/(bpy|tests)/' $(VENV)/lib hairpipe nodes graphs

.PHONY: menu demo test quick campaigns cases mutate check film pictures extension docs wheel release clean

menu:
	@echo "make demo    simulate hair on our bust and draw it: results in out/demo; FRAMES=1001-1010 for its first pictures"
	@echo "make quick   run the tests that compile no kernels and take no seconds each: three minutes on two cores"
	@echo "make test    run the tests; PYTEST='-p tests.seconds' says where their time goes"
	@echo "make campaigns  run the tests that it leaves out: more of browsers, clusters and killed runs"
	@echo "make cases   run the inputs in ../shared/cases, where they are"
	@echo "make mutate  share of mutations of the engine that its tests find: an hour"
	@echo "make check   lint, format and types"
	@echo "make film    compute and record the films of the gallery, GRAPH=demo for one of them"
	@echo "make pictures   make the pictures of the tutorials and of the front page, in a browser and in Blender"
	@echo "make extension  write the extension for Blender: out/hairpipe-blender.zip"
	@echo "make docs    build the documentation: out/docs/index.html"
	@echo "make wheel   build the wheel, and run the demo from it in an empty folder"
	@echo "make release check the figures of the README, the tests, the wheel and the documentation of a version"
	@echo "make clean   remove the environment and the results, not the cache"

demo: $(VENV)/installed
	$(VENV)/bin/hairpipe run graphs/demo.toml $(if $(FRAMES),--frames $(FRAMES))

quick: $(VENV)/tested
	$(RUN) pytest -n auto --dist worksteal -p tests.quick

# Each process begins with a stretch of files that follow one another: tests of a file need the same kernels. Those that
# wait, for a browser, a cluster or what they interrupt, run in a process next to these.
test: $(VENV)/tested
	@waiting=$$(mktemp); code=0; \
	$(RUN) pytest $(PYTEST) -m 'waits and not campaign' tests/app/page $$(find tests -name 'test_dask*.py') \
		$$(grep -rlE 'def test.*(interrupt|ctrl_c)' tests) >$$waiting 2>&1 & \
	$(RUN) pytest $(PYTEST) -n auto --dist worksteal -m 'not waits and not campaign' || code=$$?; \
	wait $$! || code=$$?; \
	cat $$waiting; rm $$waiting; exit $$code

campaigns: $(VENV)/tested
	$(RUN) pytest $(PYTEST) -m campaign

cases: $(VENV)/tested
	$(RUN) pytest tests/test_cases.py

mutate: $(VENV)/tested
	$(INSTALL) '.[mutation]'
	$(RUN) hairpipe.graphs.experiments.bench mutate

check: $(VENV)/tested
	$(RUN) ruff check
	$(RUN) ruff format --check
	$(RUN) pyright

film: $(VENV)/tested
	$(VENV)/bin/python docs/film.py $(GRAPH)

pictures: $(VENV)/tested
	$(VENV)/bin/hairpipe run graphs/demo.toml --frames 1001-1024 --to usd
	PAGE_PICTURES=$(CURDIR)/docs/tutorials/pictures $(RUN) pytest -n 0 tests/app/page/test_fringe.py tests/app/page/test_front.py
	$(VENV)/bin/hairpipe blender out/demo/shot.usd --picture docs/tutorials/pictures/blender.webp
	$(VENV)/bin/python docs/blender_pictures.py docs/tutorials/pictures

extension: $(VENV)/installed
	$(VENV)/bin/hairpipe blender --extension -o out/hairpipe-blender.zip

docs: $(VENV)/tested
	$(RUN) sphinx -q -W --keep-going -E -j auto docs out/docs

wheel: $(VENV)/bin/python
	.ci/wheel

# The records that the README's figures are from must be of this code: other figures name the commit that they are from.
FIGURES := graphs/experiments/results/accuracy.json graphs/experiments/results/validate_rub.json \
	graphs/experiments/results/interpolation.json graphs/paper/results/paper.json graphs/paper/results/hundred_thousand.json
release: $(VENV)/tested
	$(RUN) pytest -q -n 0 tests/test_release.py tests/test_readme.py
	$(VENV)/bin/hairpipe results $(FIGURES)
	$(MAKE) check test docs wheel
	$(RUN) pip wheel --quiet --no-deps --wheel-dir out .
	@ls out/hairpipe-*.whl

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' || { echo "hairpipe needs Python 3.11, 3.12 or 3.13; set PYTHON=..." >&2; exit 2; }
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); echo "Python's venv module is incomplete; on Debian: apt install python3-venv" >&2; exit 2; }

# What a run needs; charts of experiments need '.[experiments]' as well.
$(VENV)/installed: pyproject.toml constraints.txt | $(VENV)/bin/python
	@begin=$$(date +%s); $(INSTALL) . && $(COMPILE) && \
	echo "installed in $$(($$(date +%s) - begin)) s: $$(du -sm $(VENV) | cut -f1) MB in $(VENV)"
	@touch $@

$(VENV)/tested: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(INSTALL) '.[dev]'
	@$(COMPILE)
	@touch $(VENV)/installed $@

clean:
	rm -rf $(VENV) out

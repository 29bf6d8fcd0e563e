# VolVis. Two commands begin everything: make run, make test. `make help` lists the rest.
#
# JOBS=N      compile and test with N processes (2)
# MESON="..." more options for the build folder, for example MESON=-Dwerror=true
# SETUP=no    never install packages; what is missing is then an error of the build

JOBS ?= 2
MESON ?=
BENCH ?= quick
PROGRAM = build/volvis
NINJA = ninja -j $(JOBS)

.PHONY: help run build test setup debug bench format lint fuzz docs install clean
.DEFAULT_GOAL := help

help:
	@echo 'VolVis, volume visualization. What make can do:'
	@echo
	@echo '  make run       install what is missing, build build/volvis, render a tour of its modes into out/'
	@echo '  make test      the same set-up, then every test; the last line counts them'
	@echo
	@echo '  make build     the optimised program and library, in build/'
	@echo '  make debug     a build with the address and undefined-behaviour sanitizers, in build-debug/, and its tests'
	@echo '  make bench     speed beside the machine'"'"'s limits and beside VTK, into out/bench/; BENCH=full for every case'
	@echo '  make format    clang-format over all C sources'
	@echo '  make lint      formatting, white space, types of the page, clang-tidy'
	@echo '  make fuzz      every fuzz target for FUZZ_SECONDS (20) each'
	@echo '  make docs      generated reference pages into out/docs/, and a check of all links'
	@echo '  make install   into PREFIX (/usr/local); DESTDIR is honoured'
	@echo '  make clean     remove all build folders and out/'
	@echo
	@echo 'JOBS=N sets how many processes compile (2). SETUP=no keeps apt out of it.'

setup:
	@tools/setup base
	@tools/setup-web

build: setup
	@tools/configure build -Dbuildtype=release $(if $(PREFIX),--prefix=$(PREFIX)) $(MESON)
	@$(NINJA) -C build --quiet

run: build
	@tools/tour $(PROGRAM) out
	@echo 'Now turn it yourself:  $(PROGRAM) view /usr/share/mricron/templates/ch2.nii.gz'

test: build
	@tools/run-tests build $(JOBS)

debug:
	@tools/setup base tools
	@CC=clang tools/configure build-debug -Dbuildtype=debugoptimized -Db_ndebug=false -Db_lundef=false \
		-Db_sanitize=address,undefined $(MESON)
	@$(NINJA) -C build-debug --quiet
	@tools/run-tests build-debug $(JOBS)

bench: build
	@tools/setup bench
	@bench/run --program $(PROGRAM) --out out/bench --cases $(BENCH)
	@bench/surfaces --program $(PROGRAM) --out out/bench
	@bench/filters --program $(PROGRAM) --out out/bench --sizes $(if $(filter full,$(BENCH)),256,128)

format:
	@tools/setup base tools
	@tools/format --write

lint:
	@tools/setup base tools
	@tools/format
	@tools/whitespace
	@if [ -x web/node_modules/.bin/tsc ]; then web/node_modules/.bin/tsc -p web; else echo 'lint: no web/node_modules: types of the page are not checked'; fi
	@tools/tidy $(JOBS)

fuzz:
	@tools/setup base tools
	@tools/fuzz $(FUZZ_SECONDS)

docs: build
	@tools/docs $(PROGRAM) out/docs

install: build
	@meson install -C build --no-rebuild

clean:
	rm -rf build build-* out

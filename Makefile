# make            build/bin/{smaltid,smalti-worker,smalti}
# make demo       install what is missing, render an example on a farm of processes here
# make check      install what the tests need, build, run every test     (README: "Tests")
# make check-long the same under ASan/UBSan and TSan, with gcc and clang
# make gallery    the pictures of docs/gallery.md, and that page (ARGS=names of some)
# make mutants    do the tests find planted bugs? (ARGS=words of their names)
# make bench      measurements, each beside a peer or oracle, in one run
# make bench-rays                    the ray kernel beside Embree's (ARGS=--quick: half a minute)
# make bench-accel                   the textbooks' structures beside ours: docs/accel.{csv,svg}
# make bench-render [BASE=commit]    whole images against a former commit
# make bench-examples [BASE=commit]  the scenes of scenes/ against a former commit
# make bench-planner               does the planner choose well? (ARGS=--quick: a third of the work)
# make bench-adaptive              samples where they are needed against samples everywhere (ARGS=--quick)
# make bench-cycles                  whole images against Blender's Cycles
# make charts                        error against work, each method: docs/charts/ (CHARTS=scenes, ARGS=flags)
# MODE=release|debug|asan|tsan|coverage|fuzz    CC=gcc|clang    WERROR=1    J=jobs at once

MODE   ?= release
J      ?= $(shell nproc)
PROVE   = prove -j$(J)
CC      = gcc
PREFIX ?= /usr/local
O      := build/$(MODE)$(if $(filter clang%,$(notdir $(CC))),-clang)
B      := $(if $(filter build/release,$(O)),build/bin,$(O)/bin)

WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wdouble-promotion \
	-Wswitch-enum -Wcast-qual -Wwrite-strings -Wundef -Wvla -Wformat=2 -Wstrict-prototypes \
	-Wmissing-prototypes $(if $(WERROR),-Werror)
# Same pixels: strict floating point, one fixed instruction set for the core (docs/design.md).
FLOAT := -ffp-contract=off -fno-math-errno -fno-trapping-math -fno-fast-math
HARDEN := -fstack-protector-strong -fPIE

CFLAGS_release  := -O3 -D_FORTIFY_SOURCE=2
CFLAGS_debug    := -O0 -DSMALTI_SLOW_CHECKS
CFLAGS_asan     := -O1 -DSMALTI_SLOW_CHECKS -fsanitize=address,undefined -fno-sanitize-recover=all
CFLAGS_tsan     := -O1 -DSMALTI_SLOW_CHECKS -fsanitize=thread
CFLAGS_coverage := -O0 --coverage
CFLAGS_fuzz     := -O1 -DSMALTI_SLOW_CHECKS -fsanitize=address,undefined,fuzzer-no-link
LDFLAGS_asan     := -fsanitize=address,undefined
LDFLAGS_tsan     := -fsanitize=thread
LDFLAGS_coverage := --coverage
LDFLAGS_fuzz     := -fsanitize=address,undefined

ALL_CFLAGS = -std=c17 -D_POSIX_C_SOURCE=200809L -g -I. $(WARN) $(FLOAT) $(HARDEN) $(CFLAGS_$(MODE)) \
	-isystem /usr/include/OpenEXR -isystem /usr/include/Imath -pthread $(CFLAGS)
ALL_LDFLAGS = -pthread -pie -Wl,-z,relro,-z,now $(LDFLAGS_$(MODE)) $(LDFLAGS)

LIBS_COMMON := -ljansson -lz -lcrypto -lm
LIBS_HTTP   := -lcurl
LIBS_IMAGE  := -lOpenEXRCore -lpng
LIBS_ASSET  := $(LIBS_IMAGE) -ljpeg
LIBS_SERVER := -lmicrohttpd -lsqlite3
LIBS_WORKER := -lxxhash
# Only bench_rays has Embree, and only where its header is; else it says so.
EMBREE      := $(wildcard /usr/include/embree3/rtcore.h)
BENCH_PARTS := $(filter-out bench/bench_% bench/embree%,$(wildcard bench/*.c)) bench/embree$(if $(EMBREE),,_none).c

obj    = $(patsubst %.c,$(O)/%.o,$(1))
COMMON := $(wildcard common/*.c)
TRACE  := $(wildcard common/trace/*.c)
SERVER := $(filter-out server/main.c,$(wildcard server/*.c))
WORKER := $(filter-out worker/main.c,$(wildcard worker/*.c))
CLIENT := $(filter-out client/main.c,$(wildcard client/*.c))
ACCEL  := $(filter-out bench/accel/main.c,$(wildcard bench/accel/*.c))
TESTS  := $(patsubst tests/%.c,$(B)/%,$(wildcard tests/test_*.c))
BENCH  := $(patsubst bench/%.c,$(B)/%,$(wildcard bench/bench_*.c))
TOOLS  := $(patsubst tests/%.c,$(B)/%,$(wildcard tests/tool_*.c))
FUZZ   := $(patsubst tests/%.c,$(B)/%,$(wildcard tests/fuzz_*.c))

.PHONY: all tests demo pictures gallery check check-unit check-rules check-e2e check-long mutants bench bench-rays bench-accel bench-render \
	bench-examples bench-cycles bench-planner bench-adaptive charts fuzz fuzz-run install clean
.SECONDARY:
.DELETE_ON_ERROR:

all: $(B)/smaltid $(B)/smalti-worker $(B)/smalti

$(O)/libcommon.a: $(call obj,$(COMMON))
$(O)/libtrace.a:  $(call obj,$(TRACE))
$(O)/libserver.a: $(call obj,$(SERVER))
$(O)/libworker.a: $(call obj,$(WORKER))
$(O)/libclient.a: $(call obj,$(CLIENT))
$(O)/libaccel.a:  $(call obj,$(ACCEL))
$(O)/libtest.a:   $(call obj,$(filter-out tests/test_%.c tests/tool_%.c tests/fuzz_%.c,$(wildcard tests/*.c tests/stat/*.c tests/stability/*.c)))
$(O)/libbench.a:  $(call obj,$(BENCH_PARTS))
$(O)/%.a:
	@rm -f $@
	$(AR) rcs $@ $^

$(B)/smaltid: $(O)/server/main.o $(O)/libserver.a $(O)/libcommon.a
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_SERVER) $(LIBS_IMAGE) $(LIBS_COMMON)
$(B)/smalti-worker: $(O)/worker/main.o $(O)/libworker.a $(O)/libtrace.a $(O)/libcommon.a
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_WORKER) $(LIBS_HTTP) $(LIBS_ASSET) $(LIBS_COMMON)
$(B)/smalti: $(O)/client/main.o $(O)/libclient.a $(O)/libtrace.a $(O)/libcommon.a
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_HTTP) $(LIBS_ASSET) $(LIBS_COMMON)

# Tests, tools and benchmarks may use every part of every program but its main.c.
PARTS = $(O)/libaccel.a $(O)/libbench.a $(O)/libtest.a $(O)/libserver.a $(O)/libworker.a $(O)/libclient.a \
	$(O)/libtrace.a $(O)/libcommon.a
LIBS_ALL = $(LIBS_SERVER) $(LIBS_WORKER) $(LIBS_HTTP) $(LIBS_ASSET) $(LIBS_COMMON)
$(B)/test_%: $(O)/tests/test_%.o $(PARTS)
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_ALL)
$(B)/tool_%: $(O)/tests/tool_%.o $(PARTS)
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_ALL)
$(B)/bench_%: $(O)/bench/bench_%.o $(PARTS)
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_ALL)
$(B)/bench_rays: LIBS_ALL += $(if $(EMBREE),-lembree3)
$(B)/bench-accel: $(O)/bench/accel/main.o $(PARTS)
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -o $@ $^ $(LIBS_ALL)
$(B)/fuzz_%: $(O)/tests/fuzz_%.o $(PARTS)
	@mkdir -p $(@D)
	$(CC) $(ALL_LDFLAGS) -fsanitize=fuzzer -o $@ $^ $(LIBS_ALL)

$(O)/common/trace/%.o $(O)/tests/%.o $(O)/bench/%.o: ALL_CFLAGS += -march=x86-64-v3
# What a prepared scene depends on; a change of it gives its cache files other names (worker/stagefile.c).
RECIPE := $(wildcard common/*.[ch] common/trace/*.[ch])
$(O)/worker/stagefile.o: ALL_CFLAGS += -DSTAGEFILE_RECIPE='"$(shell cat $(sort $(RECIPE)) | sha256sum | cut -c1-64)"'
$(O)/worker/stagefile.o: $(RECIPE)
$(O)/server/static.o: $(wildcard web/*) docs/scene.schema.json
$(O)/%.o: %.c Makefile
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<
-include $(shell find $(O) -name '*.d' 2>/dev/null)

tests: $(TESTS) $(TOOLS) $(B)/bench-accel

demo:
	deploy/install-deps build
	$(MAKE) -j$(J) all
	deploy/demo

pictures: demo # the picture of the README
	cp demo/cornell-box.png docs/

gallery: all
	BIN=$(B) python3 docs/gallery/make.py $(ARGS)

check:
	deploy/install-deps build test
	$(MAKE) -j$(J) WERROR=1 all tests
	$(MAKE) check-rules check-unit check-e2e

check-rules:
	tests/check_includes.sh --self-test
	tests/check_includes.sh
	tests/check_symbols.sh --self-test
	tests/check_symbols.sh $(O)
	tests/check_rows.sh
check-unit: tests
	$(PROVE) --exec '' $(TESTS)
check-e2e: all tests
	BIN=$(B) prove --exec python3 $(wildcard tests/e2e_*.py)

check-long:
	deploy/install-deps build test
	$(MAKE) -j$(J) WERROR=1 all tests
	TEST_LONG=1 $(MAKE) PROVE='prove -v --timer -j$(J)' WERROR=1 check-unit # all that stat_tries names
	$(MAKE) -j$(J) CC=clang WERROR=1 all tests
	$(MAKE) CC=clang WERROR=1 check-unit check-e2e
	$(MAKE) -j$(J) MODE=asan WERROR=1 all tests
	$(MAKE) MODE=asan WERROR=1 check-unit check-e2e
	$(MAKE) -j$(J) MODE=tsan WERROR=1 all tests
	$(MAKE) MODE=tsan WERROR=1 check-unit check-e2e

mutants:
	python3 tests/mutants.py $(ARGS)

bench: all $(BENCH) $(TOOLS)
	@for b in $(BENCH); do echo "== $$b"; $$b || exit 1; done
	@for b in $(wildcard bench/bench_*.py); do echo "== $$b"; BIN=$(B) python3 $$b || exit 1; done

bench-rays:
	deploy/install-deps build
	-deploy/install-deps bench # without Embree it says so
	$(MAKE) -j$(J) $(B)/bench_rays
	$(B)/bench_rays $(ARGS)
bench-accel: $(B)/bench-accel
	$< >$(O)/accel.csv
	mv $(O)/accel.csv docs/
	python3 bench/accel/chart.py docs/accel.csv docs/accel.svg
bench-render: all $(B)/tool_local
	BIN=$(B) BASE=$(BASE) python3 bench/bench_render.py
bench-examples: all $(B)/tool_local
	BIN=$(B) BASE=$(BASE) python3 bench/bench_examples.py
bench-planner: $(B)/bench_planner
	$< $(ARGS)
bench-adaptive: $(B)/bench_adaptive
	$< $(ARGS)
bench-cycles: all $(B)/tool_local
	BIN=$(B) python3 bench/bench_cycles.py
CHARTS ?= cornell-box glass-and-metal many-lights materials
charts: $(B)/smalti # what docs/charts.md shows
	@for s in $(CHARTS); do $(B)/smalti chart scenes/$$s.json -o docs/charts --size 16 --spp 512 $(ARGS) || exit 1; done

fuzz:
	$(MAKE) MODE=fuzz CC=clang fuzz-run
fuzz-run: $(FUZZ)
	for f in $(FUZZ); do $$f -max_total_time=$${SECONDS_EACH:-60} -print_final_stats=1 || exit 1; done

install: all
	install -D -t $(DESTDIR)$(PREFIX)/bin $(B)/smaltid $(B)/smalti-worker $(B)/smalti
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/smalti/scenes scenes/*.json
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/doc/smalti README.md LICENSE docs/*.*
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/doc/smalti/charts docs/charts/*
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/doc/smalti/gallery docs/gallery/*.*

clean:
	rm -rf build

# talus. `make` builds, `make check` proves, `make demo` shows; `make help` lists the rest.
#
#   build/bin/talus-*           programs
#   build/lib/libtalus.{a,so}   the library
#   build/python/               what tools/talus (the Python side) reads
#   build/obj/<hash>/           objects, one folder for each set of compiler flags,
#                               so that sanitizer and release objects never mix
#
# Sources are found by wildcard: a new lib/*.c or apps/NAME/*.c
# is built without an edit here. CC, CFLAGS, LDFLAGS, PREFIX, DESTDIR, BUILD and
# PYTHON can be given on the command line; V=1 shows the commands.

CC ?= cc
CFLAGS ?= -O3 -g
BUILD ?= build
# By its absolute path, too, a folder of this tree is the same build: the path is among the flags.
override BUILD := $(BUILD:$(CURDIR)/%=%)
PREFIX ?= /usr/local
JOBS ?= $(shell nproc 2>/dev/null || echo 1)
VENV ?= .venv
PYTHON ?= $(VENV)/bin/python

ifeq ($(origin CC),default)
  CC := cc
endif
ifeq ($(V),1)
  Q :=
  say := @:
else
  Q := @
  say := @printf '  %-5s %s\n'
endif
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.SUFFIXES:
.SECONDARY:

# The one place that holds the version is include/talus/version.h.
version_part = $(shell sed -n 's/^.define TL_VERSION_$(1) *\([0-9]*\).*/\1/p' include/talus/version.h)
VERSION_MAJOR := $(call version_part,MAJOR)
VERSION := $(VERSION_MAJOR).$(call version_part,MINOR).$(call version_part,PATCH)
SONAME := libtalus.so.$(VERSION_MAJOR)

# ---- flags ------------------------------------------------------------------

WARNINGS := -pedantic -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion \
  -Wstrict-prototypes -Wmissing-prototypes -Wvla -Wundef

# The same bits on every machine: no contraction to fma, no fast-math, no
# -march=native. errno and floating traps are nobody's business here, and without
# them sqrt is one instruction and loops over arrays vectorise.
EXACT := -ffp-contract=off -fno-math-errno -fno-trapping-math
# 32-bit x86 would otherwise compute in 80-bit registers.
TARGET_I386 := $(shell echo __i386__ | $(CC) $(CPPFLAGS) $(CFLAGS) -E -P - 2>/dev/null | grep -cx 1)
ifeq ($(TARGET_I386),1)
  EXACT += -msse2 -mfpmath=sse
endif

ifeq ($(SANITIZE),1)
  SANITIZERS := -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
endif
ifeq ($(SANITIZE),thread)
  SANITIZERS := -fsanitize=thread -fno-omit-frame-pointer
endif

# The library stands alone: no stack protector, no checked memcpy.
LIB_FLAGS := -std=c99 $(WARNINGS) $(EXACT) -fPIC -fno-stack-protector -U_FORTIFY_SOURCE \
  -Iinclude -I$(BUILD)/generated $(SANITIZERS)

APP_PACKAGES := yaml-0.1 jansson zlib
PKG_CONFIG ?= pkg-config
APP_MISSING := $(strip $(foreach p,$(APP_PACKAGES),$(shell $(PKG_CONFIG) --exists $(p) 2>/dev/null || echo $(p))))
ifeq ($(APP_MISSING),)
  APP_PACKAGE_FLAGS := $(shell $(PKG_CONFIG) --cflags $(APP_PACKAGES))
  APP_PACKAGE_LIBS := $(shell $(PKG_CONFIG) --libs $(APP_PACKAGES))
endif
APP_FLAGS := -std=c99 -D_POSIX_C_SOURCE=200809L -D_FILE_OFFSET_BITS=64 $(WARNINGS) $(EXACT) -pthread -fPIC \
  -Iinclude -Iapps -I$(BUILD)/assets $(APP_PACKAGE_FLAGS) $(SANITIZERS)
APP_LIBS := $(APP_PACKAGE_LIBS) -lm -pthread

# talus-acquire reaches GPIO lines through the kernel; libgpiod, of either generation, is one more way where it is
# there. GPIOD= builds without it.
GPIOD ?= $(filter 1 2,$(shell $(PKG_CONFIG) --modversion libgpiod 2>/dev/null | cut -d . -f 1))
ifneq ($(GPIOD),)
  GPIOD_FLAGS := -DTALUS_GPIOD=$(GPIOD) $(shell $(PKG_CONFIG) --cflags libgpiod)
  GPIOD_LIBS := $(shell $(PKG_CONFIG) --libs libgpiod)
endif

# talus-track reads videos through OpenCV: C++, in one file, and the program is left out where it is missing.
CXX ?= g++
OPENCV_INCLUDE ?= /usr/include/opencv4
OPENCV_MODULES := calib3d videoio imgcodecs imgproc core
OPENCV_MISSING := $(strip $(foreach m,$(OPENCV_MODULES),$(if $(wildcard $(OPENCV_INCLUDE)/opencv2/$(m).hpp),,opencv_$(m))))
CXX_FLAGS := -std=c++17 -D_FILE_OFFSET_BITS=64 -Wall -Wextra -Wshadow -ffp-contract=off -Iapps -isystem $(OPENCV_INCLUDE) $(SANITIZERS)
OPENCV_LIBS := $(OPENCV_MODULES:%=-lopencv_%) -lstdc++

FLAGS_ID := $(shell printf '%s' '$(CC) $(CPPFLAGS) $(CFLAGS) $(LDFLAGS) $(LIB_FLAGS) $(APP_FLAGS) $(APP_LIBS) $(GPIOD_FLAGS) $(GPIOD_LIBS) $(CXX) $(CXX_FLAGS)' \
  | cksum | cut -d ' ' -f 1)
OBJ := $(BUILD)/obj/$(FLAGS_ID)

# ---- sources ----------------------------------------------------------------

HEADERS := $(sort $(wildcard include/talus/*.h include/talus/*/*.h))
LIB_SOURCES := $(sort $(wildcard lib/*.c lib/*/*.c))
# A program is a folder of apps/ that has a main.c; apps/NAME becomes talus-NAME. What stands in the other folders is
# for all programs.
APP_DIRS := $(patsubst %/main.c,%,$(sort $(wildcard apps/*/main.c)))
SHARED_DIRS := $(filter-out $(APP_DIRS),$(patsubst %/,%,$(sort $(wildcard apps/*/))))
COMMON_SOURCES := $(sort $(foreach d,$(SHARED_DIRS),$(wildcard $(d)/*.c $(d)/*/*.c)))
program_sources = $(sort $(wildcard $(1)/*.c $(1)/*/*.c))
app_name = talus-$(patsubst talus-%,%,$(notdir $(1)))
ASSET_CHART := $(firstword $(wildcard /usr/share/javascript/chart.js/chart.min.js \
  /usr/share/javascript/chart.js/Chart.min.js))
ASSETS := $(sort $(wildcard apps/page/assets/*))

objects = $(patsubst %.c,$(OBJ)/%.o,$(1))
LIB_OBJECTS := $(call objects,$(LIB_SOURCES))
PROGRAMS := $(foreach d,$(if $(OPENCV_MISSING),$(filter-out apps/track,$(APP_DIRS)),$(APP_DIRS)),$(BUILD)/bin/$(call app_name,$(d)))
LIBRARIES := $(BUILD)/lib/libtalus.a $(BUILD)/lib/libtalus.so
FILES_LIBRARY := $(BUILD)/lib/libtalus_files.so
PYTHON_SIDE := $(BUILD)/python/talus_cdef.h $(BUILD)/python/talus_macros.h

# ---- build ------------------------------------------------------------------

.PHONY: all library programs python-side test-programs FORCE
# What is asked for by its absolute path: the rules have the path within the tree.
$(CURDIR)/$(BUILD)/%: $(BUILD)/% ;

library: $(LIBRARIES)
python-side: $(PYTHON_SIDE) $(if $(APP_MISSING),,$(FILES_LIBRARY))
ifeq ($(APP_MISSING),)
programs: $(PROGRAMS)
ifneq ($(OPENCV_MISSING),)
	@echo 'not built: talus-track (missing: $(OPENCV_MISSING)); `make deps` installs what it needs'
endif
else
programs:
	@echo 'not built: the programs (missing: $(APP_MISSING)); `make deps` installs what they need'
endif
PYTHON_PROGRAMS := talus-gap talus-import talus-acquire-export talus-export-simulator talus-fleet
PYTHON_PACKAGES := talus
module_of_talus-gap := talus.diagnosis
needs_of_talus-gap := cffi, numpy, scipy, yaml
module_of_talus-import := talus.importing
needs_of_talus-import := cffi, numpy, pint, yaml
module_of_talus-acquire-export := talus.acquire_export
needs_of_talus-acquire-export := cantools, cffi, numpy, yaml
module_of_talus-export-simulator := talus.exporting
needs_of_talus-export-simulator := cffi, numpy, scipy, yaml
module_of_talus-fleet := talus.fleet
needs_of_talus-fleet := cffi, numpy, scipy, yaml
all: library python-side programs $(PYTHON_PROGRAMS:%=$(BUILD)/bin/%) $(BUILD)/python/compiled

# talus-gap (tools/talus/diagnosis), talus-import (importing), talus-acquire-export (acquire_export), talus-fleet (fleet) and the files of
# talus-export for simulators (exporting) are Python: what stands in bin/ finds an interpreter for it.
# (program, where tools/ stands, where what was built stands) -> its text
start_script = sed -e 's|@ROOT@|$(2)|' -e 's|@BUILD@|$(3)|' -e 's|@NAME@|$(1)|' \
	-e 's|@MODULE@|$(module_of_$(1))|' -e 's|@NEEDS@|$(needs_of_$(1))|' tools/start.sh
$(PYTHON_PROGRAMS:%=$(BUILD)/bin/%): tools/start.sh Makefile
	$(say) GEN $@
	@mkdir -p $(@D)
	$(Q)$(call start_script,$(@F),$(CURDIR),$(abspath $(BUILD))) >$@.new
	$(Q)chmod +x $@.new && mv $@.new $@

# Compiled once: programs leave nothing beside their sources, and each start would compile them again.
$(BUILD)/python/compiled: $(shell find tools/talus -name '*.py') $(wildcard $(VENV)/pyvenv.cfg)
	@mkdir -p $(@D)
	$(Q)test ! -x '$(PYTHON)' || '$(PYTHON)' -m compileall -q tools/talus
	@touch $@

# Holds the flags' hash and is touched only when it changes: whatever is linked
# depends on it, so a change of flags links again from the right objects.
$(BUILD)/flags: FORCE
	@mkdir -p $(@D)
	@echo '$(FLAGS_ID)' | cmp -s - $@ || echo '$(FLAGS_ID)' >$@

$(OBJ)/lib/%.o: lib/%.c
	$(say) CC $<
	@mkdir -p $(@D)
	$(Q)$(CC) $(CPPFLAGS) $(LIB_FLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<

# The table of effects: a line for each file of lib/effects/, by the `.order` that it names, those without one last.
EFFECT_TABLE := $(BUILD)/generated/effect_table.h
$(EFFECT_TABLE): FORCE
	@mkdir -p $(@D)
	@for f in lib/effects/*.c; do \
	  n=$$(sed -n 's/^ *\.order = \([0-9]*\),.*/\1/p' $$f); \
	  echo "$${n:-999999} TL_EFFECT_KIND($$(basename $$f .c))"; done | LC_ALL=C sort -n | cut -d ' ' -f 2 >$@.$$PPID
	@cmp -s $@.$$PPID $@ && rm $@.$$PPID || mv $@.$$PPID $@

$(OBJ)/lib/effect.o $(BUILD)/lint/lib/effect.c.ok: $(EFFECT_TABLE)

$(OBJ)/apps/%.o: apps/%.c | $(BUILD)/assets/assets.h
	$(say) CC $<
	@mkdir -p $(@D)
	$(Q)$(CC) $(CPPFLAGS) $(APP_FLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<

# The list of members is part of what an archive is made of: without it, a source
# that was removed would stay linked.
$(BUILD)/lib/libtalus.list: FORCE
	@mkdir -p $(@D)
	@echo '$(LIB_OBJECTS)' | cmp -s - $@ || echo '$(LIB_OBJECTS)' >$@

$(BUILD)/lib/libtalus.a: $(LIB_OBJECTS) $(BUILD)/flags $(BUILD)/lib/libtalus.list
	$(say) AR $@
	@rm -f $@
	$(Q)$(AR) rcs $@ $(LIB_OBJECTS)

$(BUILD)/lib/libtalus.so: $(LIB_OBJECTS) $(BUILD)/flags $(BUILD)/lib/libtalus.list
	$(say) LINK $@
	$(Q)$(CC) $(CFLAGS) $(SANITIZERS) $(LDFLAGS) -shared -Wl,-soname,$(SONAME) -o $@ $(LIB_OBJECTS) -lm
	@ln -sf libtalus.so $(BUILD)/lib/$(SONAME)

# Assets: each file becomes asset_NAME[] and asset_NAME_size, every character of
# its name that is no letter or digit replaced by `_`; assets.h declares them all.
asset_symbol = $(shell printf 'asset_%s' '$(notdir $(1))' | tr -c 'A-Za-z0-9' '_')
ASSET_LIST := chart_js=$(ASSET_CHART) $(foreach a,$(ASSETS),$(patsubst asset_%,%,$(call asset_symbol,$(a)))=$(a))
ASSET_NAMES := $(foreach a,$(ASSET_LIST),$(firstword $(subst =, ,$(a))))
ASSET_OBJECTS := $(foreach n,$(ASSET_NAMES),$(OBJ)/assets/asset_$(n).o)

$(BUILD)/assets/assets.h: tools/embed $(BUILD)/assets/list
	$(say) GEN $@
	$(Q)tools/embed --header $(ASSET_NAMES) >$@

$(BUILD)/assets/list: FORCE
	@mkdir -p $(@D)
	@echo '$(ASSET_LIST)' | cmp -s - $@ || echo '$(ASSET_LIST)' >$@

define asset_rule
$$(BUILD)/assets/asset_$(1).c: $(2) tools/embed $$(BUILD)/assets/list
	$$(say) GEN $$@
	$$(Q)tools/embed $(1) $(2) >$$@
endef
$(foreach a,$(ASSET_LIST),$(eval $(call asset_rule,$(firstword $(subst =, ,$(a))),$(word 2,$(subst =, ,$(a))))))

$(OBJ)/assets/%.o: $(BUILD)/assets/%.c $(BUILD)/assets/assets.h
	@mkdir -p $(@D)
	$(Q)$(CC) $(CPPFLAGS) $(APP_FLAGS) $(CFLAGS) -c -o $@ $<

# What the programs share is linked as a private archive: each takes what it uses.
COMMON_ARCHIVE := $(OBJ)/libcommon.a
$(COMMON_ARCHIVE): $(call objects,$(COMMON_SOURCES)) $(ASSET_OBJECTS) $(OBJ)/libcommon.list
	@rm -f $@
	$(Q)$(AR) rcs $@ $(filter %.o,$^)

$(OBJ)/libcommon.list: FORCE
	@mkdir -p $(@D)
	@echo '$(COMMON_SOURCES) $(ASSET_NAMES)' | cmp -s - $@ || echo '$(COMMON_SOURCES) $(ASSET_NAMES)' >$@

# The programs' own readers of models and recordings, for Python: one reader for all.
$(FILES_LIBRARY): $(COMMON_ARCHIVE) $(BUILD)/lib/libtalus.so
	$(say) LINK $@
	$(Q)$(CC) $(CFLAGS) $(SANITIZERS) $(LDFLAGS) -shared -Wl,-soname,$(@F) -Wl,-rpath,'$$ORIGIN' -o $@ \
	  -Wl,--whole-archive $(COMMON_ARCHIVE) -Wl,--no-whole-archive -L$(BUILD)/lib -ltalus $(APP_LIBS)

# A sanitized program carries its options in itself (see the file).
ifeq ($(SANITIZE),1)
  SANITIZER_OPTIONS := $(OBJ)/sanitizer_options.o
  $(SANITIZER_OPTIONS): tests/sanitizer_options.c
	@mkdir -p $(@D)
	$(Q)$(CC) -std=c99 -c -o $@ $<
endif

# talus-feedforward records as talus-acquire does, with its parts.
parts_feedforward := apps/acquire
parts_of = $(filter-out %/main.c,$(foreach p,$(parts_$(notdir $(1))),$(call program_sources,$(p))))
define program_rule
$$(BUILD)/bin/$(call app_name,$(1)): $$(call objects,$$(call program_sources,$(1)) $$(call parts_of,$(1))) $$(COMMON_ARCHIVE) \
    $$(SANITIZER_OPTIONS) $$(BUILD)/lib/libtalus.a $$(BUILD)/flags
	$$(say) LINK $$@
	@mkdir -p $$(@D)
	$$(Q)$$(CC) $$(CFLAGS) $$(SANITIZERS) $$(LDFLAGS) -o $$@ $$(filter %.o,$$^) $$(COMMON_ARCHIVE) \
	  $$(BUILD)/lib/libtalus.a $$(APP_LIBS)
endef
$(foreach d,$(APP_DIRS),$(eval $(call program_rule,$(d))))

$(OBJ)/apps/acquire/source/gpio.o $(OBJ)/apps/acquire/source/gpio_%.o: CPPFLAGS += $(GPIOD_FLAGS)
$(BUILD)/bin/talus-acquire $(BUILD)/bin/talus-feedforward: APP_LIBS += $(GPIOD_LIBS)

$(BUILD)/bin/talus-track: APP_LIBS += $(OPENCV_LIBS)
$(BUILD)/bin/talus-track: $(OBJ)/apps/track/opencv_face.o
$(OBJ)/apps/%.o: apps/%.cpp
	$(say) CXX $<
	@mkdir -p $(@D)
	$(Q)$(CXX) $(CPPFLAGS) $(CXX_FLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<

# Each tests/programs/NAME.c is a small program that shows what programs share to
# the tests; NAME goes to build/tests/. Each tools/bench/NAME.c serves `make bench` and
# goes to build/bench/. Whatever runs tests builds them all.
TEST_SOURCES := $(sort $(wildcard tests/programs/*.c))
TEST_PROGRAMS := $(if $(APP_MISSING),,$(TEST_SOURCES:tests/programs/%.c=$(BUILD)/tests/%))
BENCH_SOURCES := $(sort $(wildcard tools/bench/*.c))
BENCH_PROGRAMS := $(if $(APP_MISSING),,$(BENCH_SOURCES:tools/bench/%.c=$(BUILD)/bench/%))
test-programs: $(TEST_PROGRAMS) $(BENCH_PROGRAMS)

$(OBJ)/tests/%.o: tests/%.c | $(BUILD)/assets/assets.h
	$(say) CC $<
	@mkdir -p $(@D)
	$(Q)$(CC) $(CPPFLAGS) $(APP_FLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/tests/%: $(OBJ)/tests/programs/%.o $(COMMON_ARCHIVE) $(SANITIZER_OPTIONS) $(BUILD)/lib/libtalus.a \
    $(BUILD)/flags
	$(say) LINK $@
	@mkdir -p $(@D)
	$(Q)$(CC) $(CFLAGS) $(SANITIZERS) $(LDFLAGS) -o $@ $(filter %.o,$^) $(COMMON_ARCHIVE) \
	  $(BUILD)/lib/libtalus.a $(APP_LIBS)

$(OBJ)/tools/%.o: tools/%.c | $(BUILD)/assets/assets.h
	$(say) CC $<
	@mkdir -p $(@D)
	$(Q)$(CC) $(CPPFLAGS) $(APP_FLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/bench/%: $(OBJ)/tools/bench/%.o $(COMMON_ARCHIVE) $(SANITIZER_OPTIONS) $(BUILD)/lib/libtalus.a \
    $(BUILD)/flags
	$(say) LINK $@
	@mkdir -p $(@D)
	$(Q)$(CC) $(CFLAGS) $(SANITIZERS) $(LDFLAGS) -o $@ $(filter %.o,$^) $(COMMON_ARCHIVE) \
	  $(BUILD)/lib/libtalus.a $(APP_LIBS)

# The Python side is made from the public headers themselves: declarations as the
# preprocessor leaves them, and the macros beside them.
FILES_HEADERS := apps/candump/candump_lines.h apps/clock/clock_step.h apps/common/error.h apps/recording/number_rows.h apps/model/model_file.h apps/recording/recording.h
CDEF_CPP = $(CC) -std=c99 -E -P -nostdinc -DTL_NO_ATTRIBUTES -Itools/talus/stubs -Iinclude -Iapps \
  $(foreach h,$(HEADERS) $(FILES_HEADERS),-include $(h)) -x c /dev/null

$(BUILD)/python/headers.list: FORCE
	@mkdir -p $(@D)
	@echo '$(HEADERS) $(FILES_HEADERS)' | cmp -s - $@ || echo '$(HEADERS) $(FILES_HEADERS)' >$@

$(BUILD)/python/talus_cdef.h: $(HEADERS) $(FILES_HEADERS) $(wildcard tools/talus/stubs/*.h) $(BUILD)/python/headers.list
	$(say) GEN $@
	$(Q)$(CDEF_CPP) >$@

$(BUILD)/python/talus_macros.h: $(BUILD)/python/talus_cdef.h
	$(Q)$(CDEF_CPP) -dM | grep '^.define TL_' | sort >$@

-include $(shell find $(OBJ) -name '*.d' 2>/dev/null)

# ---- check, show, measure ---------------------------------------------------

.PHONY: deps check check-san check-long check-coverage cover check-arch test test-san test-long fuzz rig test-rig tsan lint analyse demo paper blind nulls spike across camera gate fleet bench
# What a goal needs is installed first; then make starts anew, because what this
# run found out about compilers and packages may no longer be true.
again = +$(Q)$(MAKE) --no-print-directory $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(JOBS))
run_env = PYTHONPATH='$(CURDIR)/tools' TALUS_BUILD='$(abspath $(BUILD))' PYTHONDONTWRITEBYTECODE=1 \
  OPENBLAS_NUM_THREADS=1 PATH='$(abspath $(dir $(PYTHON))):'"$$PATH"
TESTS ?= tests
PYTEST_FLAGS ?=
MARKED ?=

deps:
	@tools/setup check

check:
	@tools/setup check
	$(again) all test-programs lint
	$(again) test MARKED='not builds' PYTEST_FLAGS='-n $(JOBS) --dist loadgroup --no-loadscope-reorder $(PYTEST_FLAGS)'
	$(again) test MARKED=builds $(if $(filter tests,$(TESTS)),TESTS='$(shell grep -l mark.builds tests/test_*.py)')

test: all test-programs
	$(Q)$(run_env) $(PYTHON) -m pytest -m 'not long and not rig$(if $(MARKED), and $(MARKED))' $(PYTEST_FLAGS) $(TESTS)

check-long:
	@tools/setup long
	$(again) test-long MARKED='not builds and not alone' PYTEST_FLAGS='-n $(JOBS) --dist loadgroup --no-loadscope-reorder $(PYTEST_FLAGS)'
	$(again) test-long MARKED='builds or alone'
	$(again) analyse
	$(again) test-rig

test-long: all test-programs
	$(Q)$(run_env) $(PYTHON) -m pytest -m 'long and not rig$(if $(MARKED), and ($(MARKED)))' $(PYTEST_FLAGS) $(TESTS)

# Mutated records, events files and DBCs for the export (tests/test_export_fuzz.py). 100,000 take about 45 minutes.
fuzz: SEED := 1
fuzz: COUNT := 100000
fuzz: all
	@echo 'SEED=$(SEED) COUNT=$(COUNT)'
	$(Q)$(run_env) TALUS_FUZZ=$(COUNT) TALUS_FUZZ_SEED=$(SEED) $(PYTHON) -m pytest -q -m long tests/test_export_fuzz.py

# What needs a kernel with CAN and GPIO: in guests, where this machine has none (docs/rig.md).
rig:
	@tools/setup rig
	$(again) test-rig

# talus-acquire under the thread sanitizer, for the rig's tests of it
tsan:
	$(again) BUILD=$(BUILD)/tsan SANITIZE=thread CFLAGS='-O1 -g' $(BUILD)/tsan/bin/talus-acquire

test-rig: all test-programs tsan
	$(Q)PYTHON='$(PYTHON)' TALUS_BUILD='$(abspath $(BUILD))' tools/rig/run can $(PYTEST_FLAGS)
	$(Q)PYTHON='$(PYTHON)' TALUS_BUILD='$(abspath $(BUILD))' tools/rig/run gpio $(PYTEST_FLAGS)

# Which branches of the controller and of the fixed-point routines its tests take.
CONTROLLER_TESTS := tests/test_controller.py tests/test_controller_prepare.py tests/test_fixed.py tests/test_curve.py tests/test_drive_table.py
check-coverage:
	@tools/setup check
	$(again) BUILD=$(BUILD)/coverage CFLAGS='-O0 -g --coverage' cover

cover: library python-side programs test-programs
	$(Q)find $(BUILD) -name '*.gcda' -delete
	$(Q)$(run_env) $(PYTHON) -m pytest -q -m 'not long and not rig' $(CONTROLLER_TESTS)
	$(Q)tools/coverage $(BUILD)

# One hash over the library's results on other machines, compilers and C libraries.
check-arch:
	@tools/setup long
	$(again) library
	$(Q)tools/check-arch $(BUILD)

# Everything again under the address and undefined-behaviour sanitizers, in a
# build folder of its own. Python is not built with them, so it gets their
# run-time libraries (and libstdc++, whose exceptions they intercept) preloaded.
check-san:
	@tools/setup check
	$(again) BUILD=$(BUILD)/san SANITIZE=1 CFLAGS='-O1 -g' test-san

san_library = $(shell $(CC) -print-file-name=$(1))
test-san: all test-programs $(BUILD)/lib/libsanitizer_options.so
	$(Q)$(run_env) PYTHONMALLOC=malloc \
	  LD_PRELOAD='$(abspath $(BUILD)/lib/libsanitizer_options.so) $(call san_library,libasan.so) $(call san_library,libubsan.so) $(call san_library,libstdc++.so.6)' \
	  $(PYTHON) -m pytest -m 'not long and not release and not rig' $(PYTEST_FLAGS) $(TESTS)

$(BUILD)/lib/libsanitizer_options.so: tests/sanitizer_options.c
	@mkdir -p $(@D)
	$(Q)$(CC) -std=c99 -DTALUS_PRELOAD -shared -fPIC -o $@ $<

# The one static analyser that gates: zero findings. A stamp for each source, so
# that only what changed is read again. `make lint` leaves out its path-sensitive
# checks, which take seven times as long: `make analyse` has them.
CLANG_TIDY ?= clang-tidy
LINT_SOURCES := $(LIB_SOURCES) $(if $(APP_MISSING),,$(COMMON_SOURCES) $(TEST_SOURCES) $(BENCH_SOURCES) \
  $(foreach d,$(APP_DIRS),$(call program_sources,$(d))))
LINT_HEADERS := $(HEADERS) $(wildcard lib/*.h lib/*/*.h apps/*/*.h apps/*/*/*.h)
lint_flags = $(if $(filter lib/%,$(1)),$(LIB_FLAGS),$(APP_FLAGS) $(GPIOD_FLAGS))

lint: $(LINT_SOURCES:%=$(BUILD)/lint/%.ok)
analyse: $(LINT_SOURCES:%=$(BUILD)/analyse/%.ok)
# One rule each: a pattern rule of two targets counts as having made both.
define tidy
	$(say) TIDY $<
	@mkdir -p $(@D)
	$(Q)$(CLANG_TIDY) $(1) --quiet --warnings-as-errors='*' $< -- $(call lint_flags,$<) >$@.out 2>&1 \
	  || { grep -v ' warnings generated\.$$' $@.out; exit 1; }
	@mv $@.out $@
endef
$(BUILD)/lint/%.ok: % .clang-tidy $(LINT_HEADERS) | $(BUILD)/assets/assets.h
	$(call tidy,--checks=-clang-analyzer-*)
$(BUILD)/analyse/%.ok: % .clang-tidy $(LINT_HEADERS) | $(BUILD)/assets/assets.h
	$(call tidy)

# DEMO_SEED draws what is hidden; tools/picture then takes the README's picture (tools/setup browser).
DEMO_SEED ?= 1
demo:
	@tools/setup check
	$(again) all
	$(Q)$(run_env) tools/demo --seed $(DEMO_SEED)

paper:
	@tools/setup check
	$(again) all
	$(Q)$(run_env) tools/paper/run

# Cases stay in their folders: an interrupted check goes on where it was. The checksums of the labels are printed
# before the diagnosis begins.
SEED ?= 208 209
COUNT ?= 220
BLIND ?= $(BUILD)/blind$(if $(WIDE),-wide)
blind_folders = $(foreach s,$(SEED),$(BLIND)/seed$(s)-$(COUNT))
blind:
	@tools/setup check
	$(again) all
	$(Q)$(foreach s,$(SEED),test -e $(BLIND)/seed$(s)-$(COUNT)/seal.sha256 || $(run_env) $(PYTHON) -m talus.blind draw \
	  --seed $(s) --count $(COUNT) --jobs $(JOBS) $(if $(WIDE),--wide) --out $(BLIND)/seed$(s)-$(COUNT) || exit 1;)
	$(Q)$(run_env) $(PYTHON) -m talus.blind run --jobs $(JOBS) $(blind_folders)
	$(Q)$(if $(WIDE),,$(run_env) $(PYTHON) -m talus.blind next $(blind_folders))
	$(Q)$(run_env) $(PYTHON) -m talus.blind open --out $(BLIND) $(blind_folders)

# Where it is known what there is to find: reports that are there already stay, as long as talus-gap is the same.
KNOWN = $(PYTHON) -m talus.known $@ --seed $(SEED) --count $(COUNT) --jobs $(JOBS) --out $(BUILD)/$@
nulls: SEED := 1
nulls: COUNT := 60
nulls: ONLY ?=
nulls:
	@tools/setup check
	$(again) all
	$(Q)$(run_env) $(KNOWN) --only '$(ONLY)'

spike: SEED := 1
spike: COUNT := 60
camera: SEED := 1
camera: COUNT := 28
gate: SEED := 1
gate: COUNT := 40
fleet: SEED := 1
fleet: COUNT := 1000
spike camera gate fleet:
	@tools/setup check
	$(again) all
	$(Q)$(run_env) $(KNOWN)

across:
	@tools/setup check
	$(again) all
	$(Q)$(run_env) $(PYTHON) -m talus.known across --jobs $(JOBS) --out $(BUILD)/across

bench:
	@tools/setup bench
	$(again) all test-programs
	$(Q)$(run_env) tools/bench/run $(BENCH)

# ---- docs site --------------------------------------------------------------

.PHONY: docs docs-site docs-links docs-links-checked
docs:
	@tools/setup docs
	$(again) docs-site
	@ls $(BUILD)/docs/index.html

sphinx = $(run_env) $(PYTHON) -m sphinx -q --keep-going -j auto -c tools/docs -d $(BUILD)/docs-work
# A link within the site that leads nowhere is an error.
docs-site: library python-side
	$(say) GEN '$(BUILD)/docs'
	$(Q)rm -rf $(BUILD)/docs
	$(Q)$(sphinx) -W -b html . $(BUILD)/docs

# Links to other sites. It needs the network, so that no test runs it.
docs-links:
	@tools/setup docs
	$(again) docs-links-checked

docs-links-checked: library python-side
	$(Q)rm -rf $(BUILD)/docs-links
	$(Q)$(sphinx) -b linkcheck . $(BUILD)/docs-links

# ---- wheel ------------------------------------------------------------------

.PHONY: wheel wheel-file
# For any Python 3 on this processor and a glibc as new as the one here needs; docs/python.md says what is in it.
wheel:
	@tools/setup package
	$(again) wheel-file
	@ls $(BUILD)/wheel/*.whl

# libtalus.so.0 lies in the wheel already; the other libraries that ours are linked with are copied into it.
wheel-file:
	$(say) GEN '$(BUILD)/wheel'
	$(Q)rm -rf $(BUILD)/wheel
	$(Q)$(PYTHON) -m pip wheel --quiet --no-build-isolation --no-deps --wheel-dir $(BUILD)/wheel/plain .
	$(Q)PATH='$(abspath $(dir $(PYTHON)))':"$$PATH" $(PYTHON) -m auditwheel repair --strip --exclude $(SONAME) \
	  --wheel-dir $(BUILD)/wheel $(BUILD)/wheel/plain/*.whl 2>$(BUILD)/wheel/log || { cat $(BUILD)/wheel/log; exit 1; }
	$(Q)rm -rf $(BUILD)/wheel/plain

# ---- install ----------------------------------------------------------------

.PHONY: install uninstall
BINDIR ?= $(PREFIX)/bin
LIBDIR ?= $(PREFIX)/lib
# where the commands that are Python find their packages, what was built, and the page's parts
HOMEDIR = $(LIBDIR)/talus
PYTHON_FOLDERS := $(patsubst %/,%,$(sort $(dir $(foreach p,$(PYTHON_PACKAGES),$(shell find tools/$(p) -name '*.py' -not -path '*/blind/*' -not -path '*/known/*')))))
INSTALLED_PYTHON := python apps/page/assets $(PYTHON_FOLDERS)
INCLUDEDIR ?= $(PREFIX)/include
INSTALL ?= install

# A manual page is what its program says of itself.
MANDIR ?= $(PREFIX)/share/man
SHAREDIR = $(PREFIX)/share/talus
DOCDIR ?= $(PREFIX)/share/doc/talus
MAN_NAMES := $(PYTHON_PROGRAMS) $(if $(APP_MISSING),,$(notdir $(PROGRAMS)))
MAN_PAGES := $(MAN_NAMES:%=$(BUILD)/man/%.1)
$(PYTHON_PROGRAMS:%=$(BUILD)/man/%.1): $(shell find tools/talus -name '*.py')
$(BUILD)/man/%.1: $(BUILD)/bin/% tools/man_page | library python-side
	$(say) GEN $@
	@mkdir -p $(@D)
	$(Q)if tools/man_page $< $(VERSION) >$@.new 2>/dev/null; then mv $@.new $@; \
	  else rm -f $@.new; echo 'not made: $@, because $(<F) --help does not run; `make deps` installs what it needs'; fi

install: all $(BUILD)/talus.pc $(MAN_PAGES)
	$(say) COPY '$(DESTDIR)$(PREFIX)'
	$(Q)$(INSTALL) -d '$(DESTDIR)$(BINDIR)' '$(DESTDIR)$(LIBDIR)/pkgconfig' '$(DESTDIR)$(INCLUDEDIR)/talus'
	$(Q)$(foreach h,$(HEADERS),$(INSTALL) -D -m 644 $(h) '$(DESTDIR)$(INCLUDEDIR)/$(h:include/%=%)' &&) true
	$(Q)$(INSTALL) -m 644 $(BUILD)/lib/libtalus.a '$(DESTDIR)$(LIBDIR)'
	$(Q)$(INSTALL) -m 755 $(BUILD)/lib/libtalus.so '$(DESTDIR)$(LIBDIR)/libtalus.so.$(VERSION)'
	$(Q)ln -sf libtalus.so.$(VERSION) '$(DESTDIR)$(LIBDIR)/$(SONAME)'
	$(Q)$(if $(wildcard $(FILES_LIBRARY)),$(INSTALL) -m 755 $(FILES_LIBRARY) '$(DESTDIR)$(LIBDIR)')
	$(Q)ln -sf $(SONAME) '$(DESTDIR)$(LIBDIR)/libtalus.so'
	$(Q)$(INSTALL) -m 644 $(BUILD)/talus.pc '$(DESTDIR)$(LIBDIR)/pkgconfig'
	$(Q)$(if $(wildcard $(PROGRAMS)),$(INSTALL) -m 755 $(wildcard $(PROGRAMS)) '$(DESTDIR)$(BINDIR)')
	$(Q)$(INSTALL) -d '$(DESTDIR)$(MANDIR)/man1' '$(DESTDIR)$(SHAREDIR)/models' '$(DESTDIR)$(DOCDIR)/docs/images'
	$(Q)for page in $(MAN_PAGES); do [ ! -e $$page ] || $(INSTALL) -m 644 $$page '$(DESTDIR)$(MANDIR)/man1'; done
	$(Q)$(INSTALL) -m 644 models/* '$(DESTDIR)$(SHAREDIR)/models'
	$(Q)$(INSTALL) -m 644 README.md README.zh.md CHANGELOG.md LICENSE '$(DESTDIR)$(DOCDIR)'
	$(Q)$(INSTALL) -m 644 docs/*.md '$(DESTDIR)$(DOCDIR)/docs'
	$(Q)$(INSTALL) -m 644 docs/images/* '$(DESTDIR)$(DOCDIR)/docs/images'
	$(Q)$(INSTALL) -d $(INSTALLED_PYTHON:%='$(DESTDIR)$(HOMEDIR)/%')
	$(Q)for d in $(PYTHON_FOLDERS) apps/page/assets; do \
	  $(INSTALL) -m 644 $$(find "$$d" -maxdepth 1 -type f) '$(DESTDIR)$(HOMEDIR)'/"$$d"; done
	$(Q)$(INSTALL) -m 644 $(BUILD)/python/talus_cdef.h $(BUILD)/python/talus_macros.h '$(DESTDIR)$(HOMEDIR)/python'
	$(Q)ln -sfn ../../$(notdir $(BINDIR)) '$(DESTDIR)$(HOMEDIR)/bin'
	$(Q)ln -sfn .. '$(DESTDIR)$(HOMEDIR)/lib'
	$(Q)$(foreach p,$(PYTHON_PROGRAMS),$(call start_script,$(p),$(HOMEDIR),$(HOMEDIR)) >'$(DESTDIR)$(BINDIR)/$(p)' && \
	  chmod 755 '$(DESTDIR)$(BINDIR)/$(p)' &&) true

uninstall:
	$(Q)rm -rf '$(DESTDIR)$(INCLUDEDIR)/talus' '$(DESTDIR)$(HOMEDIR)' '$(DESTDIR)$(SHAREDIR)' '$(DESTDIR)$(DOCDIR)'
	$(Q)rm -f $(MAN_NAMES:%='$(DESTDIR)$(MANDIR)/man1/%.1')
	$(Q)rm -f $(PYTHON_PROGRAMS:%='$(DESTDIR)$(BINDIR)/%')
	$(Q)rm -f '$(DESTDIR)$(LIBDIR)'/libtalus.a '$(DESTDIR)$(LIBDIR)'/libtalus.so* '$(DESTDIR)$(LIBDIR)'/libtalus_files.so \
	  '$(DESTDIR)$(LIBDIR)/pkgconfig/talus.pc' $(PROGRAMS:$(BUILD)/bin/%='$(DESTDIR)$(BINDIR)/%')

$(BUILD)/talus.pc: FORCE
	@mkdir -p $(@D)
	@printf '%s\n' 'prefix=$(PREFIX)' 'libdir=$(LIBDIR)' 'includedir=$(INCLUDEDIR)' '' \
	  'Name: talus' 'Description: Dynamics of powered joints, identified from motor currents' \
	  'Version: $(VERSION)' 'Cflags: -I$${includedir}' 'Libs: -L$${libdir} -ltalus' 'Libs.private: -lm' >$@

# ---- housekeeping -----------------------------------------------------------

.PHONY: clean format help
CLANG_FORMAT ?= clang-format
clean:
	rm -rf $(BUILD) compile_commands.json
	find tools/talus -name __pycache__ -prune -exec rm -rf {} +

format:
	$(Q)$(CLANG_FORMAT) -i $(HEADERS) $(LIB_SOURCES) $(filter-out apps/leg_bus/generated/%,$(wildcard apps/*/*.[ch] apps/*/*/*.[ch])) $(wildcard lib/*.h lib/*/*.h tests/*.[ch] tests/*/*.[ch])

compile_commands.json: FORCE | $(BUILD)/assets/assets.h $(EFFECT_TABLE)
	$(say) GEN $@
	@{ sep='['; \
	for f in $(LIB_SOURCES); do \
	  printf '%s\n{"directory": "%s", "file": "%s", "command": "%s"}' "$$sep" '$(CURDIR)' $$f \
	    '$(CC) $(CPPFLAGS) $(LIB_FLAGS) $(CFLAGS) -c '$$f; sep=','; done; \
	for f in $(COMMON_SOURCES) $(foreach d,$(APP_DIRS),$(call program_sources,$(d))); do \
	  printf '%s\n{"directory": "%s", "file": "%s", "command": "%s"}' "$$sep" '$(CURDIR)' $$f \
	    '$(CC) $(CPPFLAGS) $(APP_FLAGS) $(CFLAGS) -c '$$f; sep=','; done; \
	printf '\n]\n'; } >$@

# `make print-LIB_FLAGS` shows a variable; the tests compile with the same flags.
print-%:
	@echo '$($*)'

help:
	@echo 'make               build everything into $(BUILD)/ (bin, lib)'
	@echo 'make demo          hide an effect in a simulated bench, record, identify, diagnose, open the seal; DEMO_SEED'
	@echo 'make check         lint and tests (installs what is missing)'
	@echo 'make check-arch    one hash over results on other machines, compilers and C libraries'
	@echo 'make check-coverage branches of the controller that its tests take'
	@echo 'make check-san     tests under the address and undefined-behaviour sanitizers'
	@echo 'make check-long    the long tests, make analyse (path-sensitive checks) and make rig'
	@echo 'make fuzz          mutated inputs for the export: COUNT of them, from SEED on'
	@echo 'make rig           tests on a real kernel with CAN and GPIO, in guests where this one has none'
	@echo 'make paper         reproduce the source paper on one page'
	@echo 'make blind         how often talus-gap is right on withheld effects; SEED, COUNT, JOBS, WIDE=1'
	@echo 'make nulls         how often talus-gap says none where nothing is hidden; SEED, COUNT, JOBS, ONLY'
	@echo 'make spike         how often it names an effect added to a real recording; SEED, COUNT, JOBS, TALUS_DATA='
	@echo 'make across        whether effects found on one recording lower the error on the machine'"'"'s others; JOBS, TALUS_DATA='
	@echo 'make fleet         talus-fleet on simulated arms, two processes killed; SEED, COUNT, JOBS'
	@echo 'make camera        what a camera tells it of pairs of causes that are alike; SEED, COUNT, JOBS'
	@echo 'make gate          whether spoiled recordings are named before any cause is, and sound ones left alone; SEED, COUNT, JOBS, TALUS_DATA='
	@echo 'make bench         compare speed with peers (installs them); BENCH=signals: one of them'
	@echo 'make deps          install what is missing: apt packages, .venv'
	@echo 'make docs          these pages as a site, with the reference of C and Python, in $(BUILD)/docs/'
	@echo 'make docs-links    do the links to other sites still lead somewhere? needs the network'
	@echo 'make wheel         the Python package as a file for pip, with its libraries, in $(BUILD)/wheel/'
	@echo 'make install       DESTDIR, PREFIX ($(PREFIX)); make uninstall'
	@echo 'make lint analyse format compile_commands.json clean'
	@echo 'variables: V=1 CC CFLAGS LDFLAGS BUILD TESTS=tests/test_x.py PYTEST_FLAGS'

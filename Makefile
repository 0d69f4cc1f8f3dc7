# `make run` serves, `make check` tests, `make help` lists the rest.
#
# MODE is how the code is built: release (default), debug, asan (address and undefined sanitizers) or tsan (threads).
# Each has its own directory, build/MODE. CC, CXX, CPPFLAGS, CFLAGS, CXXFLAGS, LDFLAGS and PKG_CONFIG
# are obeyed; WERROR= lets warnings pass.
# ENGINE=yes: the page has the engine for browsers, or the build fails; no: it has none; auto: it has it if the tools are installed.
# SETS=all: kernels for every instruction set; here: for this machine's widest one only, as the first `make run` compiles them.
MODE ?= release
ENGINE ?= $(if $(filter install site,$(MAKECMDGOALS)),yes,auto)
$(if $(filter yes no auto,$(ENGINE)),,$(error ENGINE is one of yes no auto, not $(ENGINE)))
SETS ?= all
$(if $(filter all here,$(SETS)),,$(error SETS is one of all here, not $(SETS)))
B := build/$(MODE)
# of what the compiler makes, which may be a cross compiler; before one is installed, this machine
ARCH ?= $(firstword $(subst -, ,$(shell $(CC) -dumpmachine 2>/dev/null || uname -m)))
# tests, and who tries the server by make, may be root in a container; an installed server may not (server/sandbox_setup)
export PENDULUMD_ALLOW_ROOT ?= on
JOBS ?= $(shell nproc 2>/dev/null || echo 2)

# $(call lazy,NAME,command): runs the command when NAME is first used, once; before that a package may be missing
lazy = $(eval $(1) = $$(eval $(1) := $$$$(shell $(2)))$$($(1)))
ifeq ($(origin CC),default)
CC := gcc
endif
ifeq ($(origin CXX),default)
CXX := g++
endif
# warnings are errors with the compilers that we try: gcc and clang of Debian 12 and 13; others may see what these do not
$(call lazy,COMPILER,$(CC) -dumpversion 2>/dev/null)
WERROR ?= $(if $(filter 12 14 14.% 19.%,$(COMPILER)),-Werror)
PKG := libmicrohttpd libcjson gsl nettle libdeflate libpng zlib libisal libzstd sqlite3 libpq libseccomp
WARN = -Wall -Wextra -Wshadow -Wpointer-arith -Wvla -Wformat=2 $(WERROR)
# gcc's warning of unset variables is often mistaken about instrumented code; valgrind looks for these
SANITIZED := $(if $(findstring clang,$(CC)),,-Wno-maybe-uninitialized)
# -g1 names functions and lines, which reports need; variables would take longer to note than all else to compile
FLAGS.release := -O3 -g1 -DNDEBUG
FLAGS.debug := -O1 -g $(SANITIZED)
FLAGS.asan := -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer $(SANITIZED)
FLAGS.tsan := -O1 -g1 -fsanitize=thread $(SANITIZED)
$(if $(FLAGS.$(MODE)),,$(error MODE is one of release debug asan tsan, not $(MODE)))
PKG_CONFIG ?= pkg-config
$(call lazy,PKG_CFLAGS,$(PKG_CONFIG) --cflags $(PKG))
$(call lazy,PKG_LIBS,$(PKG_CONFIG) --libs $(PKG))
# What OpenSSF's guide for hardened C asks of a program that is in use. Sanitizers have checks of their own instead.
# tests/rules/hardened.sh looks for each in the objects and in the daemon. nodlopen is for libraries; the linker drops it.
# The same objects make programs and the shared library. Kernels, which name no data of libraries, need less for it.
PIC := -fPIC -fno-semantic-interposition
HARD.release = $(HARD_CODE) $(HARD_NEWER) $(HARD.$(ARCH))
HARD_CODE := $(PIC) -fstack-protector-strong -fstack-clash-protection -fno-delete-null-pointer-checks \
  -fno-strict-overflow -fno-strict-aliasing -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3
HARD.x86_64 := -fcf-protection=full
HARD.aarch64 := -mbranch-protection=standard
HARD_LINK.release := -pie -Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack
# Debian's start objects lack the note of checked branches: what the kernel and the loader call is the daemon's own (server/main.c)
HARD_ENTRY.release.x86_64 := -Wl,-e,srv_main_entry -Wl,-init=srv_main_nothing -Wl,-fini=srv_main_nothing -Wl,-z,ibt -Wl,-z,shstk
# What not every compiler knows: clang 14 none of these, gcc 14 two. gcc 12 knows the first, and it makes wrong code of it: in a
# struct that begins as a copy it clears what would be padding of one array in another (tests/api saw names lost).
knows = $(if $(shell echo 'int i;' | $(CC) -Werror $(1) -S -o /dev/null -x c - 2>/dev/null && echo yes),$(1))
HARD_NEWER = $(eval HARD_NEWER := $$(foreach flag,$(HARD_ASKED),$$(call knows,$$(flag))))$(HARD_NEWER)
HARD_ASKED = $(if $(filter 12 12.% 13 13.%,$(COMPILER)),,-ftrivial-auto-var-init=zero) -fstrict-flex-arrays=3 -fzero-init-padding-bits=all
# The core is spared what its loops cannot bear. With gcc 12, in instructions: variables set to zero cost 8 % of a step of a
# large tree, 6 % of eight lanes, and 5 % of the time of the paper's example; overflow that wraps, 7 % of the lanes and 5 %
# of a step of a small tree; pointers that may be the same, 8 % of a step of a large tree, and both 5 % of the time of modes.
# What it keeps costs less than 0.5 %.
CORE_SPARED := -ftrivial-auto-var-init=zero -fno-strict-overflow -fno-strict-aliasing
$(B)/core/%.o: private SPARED := $(CORE_SPARED)
# undefined behaviour is looked for in what is tested: tests without it are compiled in a fifth less time
LIGHT.asan := -fno-sanitize=undefined
$(B)/tests/%.o: private LIGHT = $(LIGHT.$(MODE))
# the same bits from every compiler: no fused multiply-add that the source does not write
COMMON = -I. $(FLAGS.$(MODE)) $(LIGHT) -ffp-contract=off $(WARN) -MMD -MP -pthread $(PKG_CFLAGS) $(SAME) $(CPPFLAGS) $(filter-out $(SPARED),$(HARD.$(MODE)))
# wherever the sources lie, the same bytes: what is noted for debuggers is told from here
SAME = "-ffile-prefix-map=$(CURDIR)=."
CFLAGS_ALL = -std=c17 -D_GNU_SOURCE -fexceptions -Wstrict-prototypes -Wmissing-prototypes $(COMMON) $(CFLAGS)
CXXFLAGS_ALL = -std=c++17 -fno-exceptions -fno-rtti $(COMMON) $(addprefix -isystem ,$(wildcard /usr/include/dragonbox-*)) $(CXXFLAGS)
LINK = $(CC) $(FLAGS.$(MODE)) -pthread $(HARD_LINK.$(MODE)) $(LDFLAGS)
LIBS = $(PKG_LIBS) -lm

# One binary for every processor: each core/FOLDER/kernel_X.c is compiled once for every instruction set below, as
# kernel_X.base.o, kernel_X.avx2.o and so on, with -DPEND_ISA=base, avx2 or avx512. Such a file gives its functions
# names that end in PEND_ISA (pend_X_base, pend_X_avx2, ...); a plain file beside it chooses at run time
# (__builtin_cpu_supports) and may name avx2 and avx512 only #ifdef __x86_64__. The widths in doubles are 2, 4 and 8.
ISAS := base $(if $(filter x86_64,$(ARCH)),avx2 avx512)
ISA_FLAGS.base :=
ISA_FLAGS.avx2 := -march=x86-64-v3
ISA_FLAGS.avx512 := -march=x86-64-v4 -mprefer-vector-width=512
# sums that wait for each other stay in registers of their own: packed into vectors, they wait for the packing too
KERNEL_FLAGS.core/dynamics/kernel_dynamics := -fno-tree-slp-vectorize
KERNELS := $(wildcard core/*/kernel_*.c core/*/*/kernel_*.c)
# Of undefined behaviour, loops of vectors are not asked at every access whether an address is null, aligned or past the end of
# memory: it was half of the time of compiling them. The address sanitizer sees the same, and the processor what is not aligned.
KERNEL_SPARED.asan := -fno-sanitize=null,object-size,alignment,pointer-overflow
# gcc 14 moves frames to where variables that have left are noticed, and aligns them there to 32 bytes; vectors of 64 need more.
KERNEL_SPARED.asan += $(if $(findstring clang,$(CC)),,--param=asan-use-after-return=0)
# What a sanitizer's build has for an instruction set that this processor lacks is linked and never run: it is the code of the widest
# set that it has, under the other's names. To compile it took a minute of the tests' twenty, even without optimization and checks.
ISA_ASKS.avx2 := avx2 fma bmi2
ISA_ASKS.avx512 := avx512f avx512dq avx512bw avx512vl avx512cd
# SETS=here does the same: the program then runs on this machine and those that have its instruction set.
ISA_IDLE := $(if $(filter asan tsan,$(MODE))$(filter here,$(SETS)),$(strip $(foreach isa,$(filter-out base,$(ISAS)), \
	$(if $(filter-out $(shell grep -m 1 '^flags' /proc/cpuinfo),$(ISA_ASKS.$(isa))),$(isa)))))
# Under the thread sanitizer servers alone run, which take the best of the sets that are here. Under the address sanitizer the
# widest and the base alone are compiled: avx2 between them, the same source of another width, is what valgrind runs.
ISA_RUNS := $(lastword $(filter-out $(ISA_IDLE),$(ISAS)))
ISA_IDLE := $(if $(filter asan tsan,$(MODE))$(filter here,$(SETS)),$(filter-out $(if $(filter asan,$(MODE)),base) $(ISA_RUNS),$(ISAS)))

objects = $(patsubst %,$(B)/%.o,$(basename $(filter-out $(KERNELS),$(wildcard $(addprefix $(1)/,*.c *.cpp */*.c */*.cpp)) \
  $(filter-out api/clients/%,$(wildcard $(1)/*/*/*.c $(1)/*/*/*.cpp)))))
CORE := $(call objects,core) $(foreach isa,$(ISAS),$(KERNELS:%.c=$(B)/%.$(isa).o))
API := $(call objects,api) $(B)/api/call/openapi_json.o $(B)/api/base/engine.o $(B)/api/base/version.o
SERVER := $(filter-out $(B)/server/main.o,$(call objects,server)) $(B)/server/classes/nickname_table.o build/web/assets.o
HARNESS := $(call objects,tests/harness)

# one test program a room: build/MODE/tests/core/run and so on
WRAP := -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=aligned_alloc
WRAP += -Wl,--wrap=pwrite64,--wrap=fsync,--wrap=fdatasync,--wrap=ftruncate64
# a test is told to be one of several threads, which alone the thread sanitizer is asked about
WRAP += -Wl,--wrap=pthread_create
# how often a request is read is counted
WRAP.server := -Wl,--wrap=api_request_read,--wrap=srv_store_claim
QUADMATH := $(if $(filter x86_64 i%86,$(ARCH)),-lquadmath)
PARTS.core := $(B)/libpendulum.a
PARTS.laws := $(B)/libpendulum.a
PARTS.api := $(API) $(B)/libpendulum.a
PARTS.server := $(SERVER) $(API) $(B)/libpendulum.a
PARTS.wire := $(API) $(B)/libpendulum.a
PARTS.fuzz := $(SERVER) $(API) $(B)/libpendulum.a
ROOMS := core laws api server wire fuzz

help: ## lists these targets; the default
	@printf 'pendulumd: a server for planar pendulum trees.  Targets:\n'
	@awk -F ': .*## ' '/^[a-z-]+:.*## / { printf "  make %-18s %s\n", $$1, $$2 } /^#@/ { printf "\n%s\n", substr($$0, 4) }' Makefile

NEEDED = docker/install.sh build

#@ The two commands that a newcomer needs; both install missing Debian packages
run: ## builds and serves on http://127.0.0.1:8080 (LISTEN=address:port, ARGS="more options")
	@$(NEEDED)
	@$(MAKE) --no-print-directory $(PARALLEL) SETS=$(SETS_FIRST) build
	@exec $(B)/pendulumd --listen $(LISTEN) $(ARGS)
# what was compiled for every instruction set stays so
SETS_FIRST = $(if $(filter file,$(origin SETS)),$(if $(wildcard $(B)/pendulumd),$(if $(shell cat $(B)/set.* 2>/dev/null),here,all),here),$(SETS))
LISTEN ?= 127.0.0.1:8080

check: ## builds and runs every test; the last line counts them
	@$(NEEDED) client test engine
	@$(CHECK); $(COUNT)
quick: ## while you work: the tests of core and api, and the rules that read text, within two minutes
	@$(NEEDED) test
	@$(CHECK) ROOMS='core api' ONLY='build-release release-core release-api layers layout measures mirror words docs'; $(COUNT)
# three jobs more than there are processors: half of the time tests of the live server wait
CHECK = rm -rf build/check; $(MAKE) --no-print-directory $(if $(PARALLEL),-j$(shell expr $(JOBS) + 3)) -f tests/harness/check.mk
# all processors, unless whoever called make has said how many
PARALLEL = $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(JOBS))
COUNT = tests/harness/job.sh --sum

#@ Build (MODE=release|debug|asan|tsan, into build/MODE)
build: $(B)/pendulumd ## the server (ENGINE=yes|no|auto: the engine for browsers, auto: if its tools are installed)
	@api/clients/browser/engine.sh --state build/web/engine.wasm $(ENGINE)

debug: ## the server with assertions, in build/debug
	@$(MAKE) --no-print-directory MODE=debug build

install: build $(B)/pendulum $(B)/pendulumd.8 ## into DESTDIR PREFIX (/usr/local) LIBDIR: server, command line, library with headers for C and C++, systemd unit
	docker/library.sh "$(B)" "$(DESTDIR)" "$(PREFIX)" "$(LIBDIR)" $(PUBLIC)
	install -D -m 755 $(B)/pendulumd "$(DESTDIR)$(PREFIX)/bin/pendulumd"
	install -D -m 755 $(B)/pendulum "$(DESTDIR)$(PREFIX)/bin/pendulum"
	install -D -m 644 api/clients/cli/pendulum.1 "$(DESTDIR)$(PREFIX)/share/man/man1/pendulum.1"
	install -D -m 644 $(B)/pendulumd.8 "$(DESTDIR)$(PREFIX)/share/man/man8/pendulumd.8"
	install -D -m 644 api/clients/cli/pendulum.bash "$(DESTDIR)$(PREFIX)/share/bash-completion/completions/pendulum"
	install -d "$(DESTDIR)$(PREFIX)/lib/systemd/system"
	sed 's|@PREFIX@|$(PREFIX)|' docker/pendulumd.service > "$(DESTDIR)$(PREFIX)/lib/systemd/system/pendulumd.service"
PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
PUBLIC := base/status tree/tree tree/terms tree/loads dynamics/dynamics dynamics/kinematics modes/modes_store modes/modes base/checkpoint integrate/methods/method integrate/run/samples integrate/run/run derivatives/parameter derivatives/derived_rows derivatives/derivatives fit/fit_problem fit/fit orbits/orbit_problem orbits/orbits integrate/events/section integrate/events/event base/isa ensemble/member ensemble/ensemble extended/extended extended/trust ensemble/lyapunov

uninstall: ## takes away what install put there
	rm -f "$(DESTDIR)$(PREFIX)/bin/pendulum" "$(DESTDIR)$(PREFIX)/share/man/man1/pendulum.1" "$(DESTDIR)$(PREFIX)/share/bash-completion/completions/pendulum"
	rm -f "$(DESTDIR)$(PREFIX)/share/man/man8/pendulumd.8" "$(DESTDIR)$(PREFIX)/bin/pendulumd" "$(DESTDIR)$(LIBDIR)/libpendulum.a" "$(DESTDIR)$(LIBDIR)/pkgconfig/pendulum.pc"
	rm -f "$(DESTDIR)$(PREFIX)/lib/systemd/system/pendulumd.service"
	rm -rf "$(DESTDIR)$(PREFIX)/include/pendulum"

$(B)/pendulumd.8: $(B)/pendulumd docker/manual.py
	@docker/manual.py $< > $@

deb: ## Debian packages of the server, the command line and the library, and what they are made of (SBOM), in build/deb
	@$(NEEDED) client engine deb
	@docker/deb.sh build/deb

release: ## checks, tags vX.Y.Z and makes build/dist (KEY= as dist), where CHANGELOG.md and the tree are ready for it
	@docker/release.sh --ready
	@docker/install.sh release
	@$(MAKE) --no-print-directory check
	@docker/release.sh --tag "$(or $(KEY),-)"
	@$(MAKE) --no-print-directory deb
	@$(MAKE) --no-print-directory dist

dist: ## what a release consists of, in build/dist: sources, packages, digests; KEY=a private key of ssh-keygen signs them
	@rm -rf build/dist
	@docker/dist.sh build/dist "$(or $(KEY),-)"

clean: ## removes build/
	rm -rf build

site: build ## the page as a folder for any web host, without a server: build/site; what needs a server is greyed out
	@rm -rf build/site && /usr/bin/python3 -B api/call/openapi_embed.py --json api/call/openapi.yaml > $(B)/openapi.json
	@/usr/bin/python3 -B server/http/assets_embed.py server/web build/web/bundles build/web/engine.wasm api/guide build/site $(B)/openapi.json
	@echo 'build/site is ready: copy it to a web host, or look at it by  python3 -m http.server -d build/site'

#@ Test (T=part-of-a-name picks tests; TOL=0 lists every residual)
test: $(ROOMS:%=test-%) ## the test programs of all rooms, in MODE
test-core: ## one room; also test-laws, test-api, test-server, test-wire, test-fuzz
test-%: $(B)/tests/%/run
	$< $(T)
test-wire: $(B)/pendulumd

test-number-long: $(B)/tests/api/run ## 1e8 random doubles written and read back, 2e6 rounded as printf does: a minute
	PEND_NUMBERS=100000000 $< number_

asan: ## all test programs and the server under the address and undefined sanitizers
	@$(CHECK) ONLY='build-asan asan-%'; $(COUNT)

tsan: ## the server's tests under the thread sanitizer
	@$(CHECK) ONLY='build-tsan tsan-%'; $(COUNT)

bench: ## everything below but load: ours, the peer's, ratio; seven minutes (installs the peers; T=part-of-a-line)
	@docker/install.sh bench
	@$(MAKE) --no-print-directory bench-dynamics bench-trajectories bench-modes bench-precision bench-horizon bench-parts

bench-parts: $(B)/tests/bench/parts/run ## ensembles, numbers, requests, in a minute
	$< $(T)

bench-beside: build ## users' tasks beside an older program, OLD=its pendulumd or a commit, which is built once: a ratio a line, in three minutes (T=part-of-a-name)
	@$(if $(OLD),,echo 'bench-beside takes OLD=build/of/an/older/pendulumd or OLD=commit'; exit 1)
	@/usr/bin/python3 -B tests/bench/beside/beside.py $(B) "$(OLD)" $(T)

bench-page: build ## the page in a browser: first paint and motion, frames of fifty arms, thirty students at once, in half a minute
	@tests/rules/web.sh $(B) --bench

drill: build $(B)/tests/drill/clock.so ## kills, stops, cuts, full disks and wrong clocks, ROUNDS (50) of each on both stores, in half an hour (T=part-of-a-name)
	@docker/install.sh test
	@/usr/bin/python3 -B tests/drill/drill.py $(B) --rounds $(ROUNDS) $(T)
ROUNDS ?= 50

histories: build ## jobs under failover of PostgreSQL, FAILOVERS (10) with synchronous and with asynchronous replication: what clients saw is checked
	@docker/install.sh test
	@/usr/bin/python3 -B tests/drill/histories.py $(B) --rounds $(FAILOVERS)
FAILOVERS ?= 10

school: build ## thirty pupils, batch clients, an attacker and restarts, for SECONDS (300); classes against classes: errors, times, what the attacker got
	@/usr/bin/python3 -B tests/drill/school.py $(B) --seconds $(SECONDS)
SECONDS ?= 300

soak: build ## everything mixed for SECONDS (300): memory, descriptors, threads and files stay as they were
	@/usr/bin/python3 -B tests/drill/soak.py $(B) --seconds $(SECONDS)

slurm: build ## docker/slurm.sbatch and docker/parts.sbatch under a real Slurm on this machine, in a minute, as root (installs it)
	@docker/install.sh test slurm
	@/usr/bin/python3 -B tests/drill/slurm.py $(B)

pictures: build ## the pictures of README.md and the guides, from the real page (installs webp)
	@command -v img2webp >/dev/null || docker/install.sh pictures
	@tests/rules/web.sh $(B) --pictures

lesson: build ## a lesson of a class on both stores, 45 minutes in 45 s: a teacher's mistakes, restarts, and then the account
	@/usr/bin/python3 -B tests/drill/lesson.py $(B)

hostile: build ## classes against classes, and a pupil who means no good beside two at work, in five minutes: what abuses get, what the others notice
	@/usr/bin/python3 -B tests/drill/hostile.py $(B)

pages: build ## a lesson in PUPILS (4) real pages behind nginx on each store: sleep, dead Wi-Fi, restarts; thirty take minutes
	@tests/rules/web.sh $(B) --lesson $(PUPILS) sqlite
	@tests/rules/web.sh $(B) --lesson $(PUPILS) postgres
PUPILS ?= 4

load: build $(B)/tests/bench/service/service $(B)/tests/bench/jobs/engine $(B)/tests/load/client ## the daemon under load beside its peers, in ten minutes (T=part-of-a-line; installs wrk, nginx, Node.js)
	@docker/install.sh load
	@/usr/bin/python3 -B tests/load/load.py $(B) $(T)

bench-modes: $(B)/tests/bench/modes/run ## modes against LAPACK, ARPACK and GSL where these are installed, in a minute
	$< $(T)

bench-trajectories: $(B)/tests/bench/trajectories/run ## trajectories against GSL, and SUNDIALS and Octave where these are installed, in three minutes
	$< $(T)

bench-precision: $(B)/tests/bench/precision/run ## the true error of every method over its tolerance, in a minute (T=part-of-a-method)
	$< $(T)

bench-horizon: $(B)/tests/bench/horizon/run ## horizons that are told over the truth, and what they cost: 504 motions of every kind (T=kinds: these alone), 200 motions, 500 members, 50 sections, in four minutes
	$< $(T)

bench-fits: $(B)/tests/laws/run ## how often the truth is within the standard errors of ten models of fits, 200 draws each, and the profile of the likelihood, in half a minute
	COVERAGE=200 $< law_of_errors

bench-orbits: build ## periodic orbits beside a shooting with SciPy, in a minute
	@docker/install.sh test
	@/usr/bin/python3 -B tests/bench/orbits/bench_orbits.py $(B)

bench-stiff: build ## stiff pendulums by radau and taylor beside SciPy's Radau, in a minute
	@docker/install.sh test
	@/usr/bin/python3 -B tests/bench/stiff/bench_stiff.py $(B)

bench-bifurcations: build ## bifurcations of 36 random branches of orbits, false and missed ones, with multipliers by SciPy, in two minutes
	@docker/install.sh test
	@/usr/bin/python3 -B tests/bench/orbits/bench_bifurcations.py $(B)

bench-dynamics: $(B)/tests/bench/dynamics/run ## accelerations against MuJoCo and LAPACK where these are installed, in half a minute
	$< $(T)

tour: build ## the way of one request through the rooms: files and functions in order, seen in a running server (ALL=1: every visit)
	@/usr/bin/python3 -B tests/rules/tour.py $(B) $(if $(ALL),--all)

fuzz: ## bytes that nobody would send, by libFuzzer, FUZZ_SECONDS (10) for each reader (READER=name for one; MODE=release: quicker, without sanitizers): tells executions and edges; needs clang and libclang-rt-*-dev
	@$(MAKE) --no-print-directory $(PARALLEL) MODE=$(FUZZ_MODE) CC=clang CXX=clang++ B=build/fuzz-$(FUZZ_MODE) ISA_IDLE='avx2 avx512' \
	  CFLAGS='-fsanitize=fuzzer-no-link -DFUZZER$(if $(filter release,$(FUZZ_MODE)), -UNDEBUG)' CXXFLAGS=-fsanitize=fuzzer-no-link $(FUZZERS:%=build/fuzz-$(FUZZ_MODE)/%)
	@tests/fuzz/run.sh build/fuzz-$(FUZZ_MODE) $(FUZZ_SECONDS) $(READER)
FUZZ_MODE = $(if $(filter command line,$(origin MODE)),$(MODE),asan)
FUZZERS := $(basename $(notdir $(wildcard tests/fuzz/fuzz_*.c)))
FUZZ_SECONDS ?= 10

arm: ## tests of a room (ROOM=core; T=part-of-a-name) compiled for 64-bit ARM and run by qemu; installs a cross compiler and qemu
	@docker/install.sh build arm64
	@docker/arm64.sh build/arm64 $(ROOM) $(T)
ROOM ?= core

valgrind: ## the quick tests, and the server, under valgrind
	@$(CHECK) ONLY='valgrind-%'; $(COUNT)

rules: ## the rooms' include rules, documents compared with code, replies with the OpenAPI document, instructions counted
	@$(CHECK) ONLY='layers docs replies readback equations nginx deploy restart layout measures mirror openapi instructions hardened'; $(COUNT)

lint: ## clang's warnings, layout and spectral; installs clang and clang-format
	@$(NEEDED) lint
	@$(MAKE) --no-print-directory CC=clang CXX=clang++ B=build/clang build/clang/pendulumd $(ROOMS:%=build/clang/tests/%/run)
	@$(CHECK) ONLY='layout openapi'; $(COUNT)

#@ Source
format: ## lays out the C with clang-format 14, as rules/layout checks it, and the page's scripts with prettier, as rules/types does
	@tests/rules/layout.sh --write
	@tests/rules/types.sh --format

format-check: ## fails where format would change something
	@tests/rules/layout.sh

# what clang says of the sources without making anything of them (tests/rules/clang.sh)
clang-flags:
	@echo $(filter-out -MMD -MP,$(CFLAGS_ALL)) -Wno-psabi -DPEND_ISA=base
clang-flags-c++:
	@echo $(filter-out -MMD -MP,$(CXXFLAGS_ALL))

# the rules proper; V=1 shows the commands whole
Q := $(if $(V),,@)
say = $(if $(V),,@printf '  %-8s %-5s %s%s\n' '$(MODE)' '$(1)' '$(2)' '$(3)')
# the same of a compilation, with its number and how many there will be
say_counted = $(eval SAID += +)$(call say,$(1),$(2),$(if $(filter $(words $(SAID)),$(wordlist 1,$(TOTAL),$(NUMBERS))), [$(words $(SAID))/$(TOTAL)]))
# objects that the goals want and that are not there, or older than the flags; what was edited since is not known before
OBJECTS = $(sort $(filter-out %.a %/engine.o %/version.o %/openapi_json.o %/nickname_table.o build/web/%,$(foreach goal,$(or $(MAKECMDGOALS),help),\
  $(if $(filter build install $(B)/pendulumd,$(goal)),$(B)/server/main.o $(SERVER) $(API) $(CORE)) \
  $(foreach room,$(ROOMS),$(if $(filter test test-$(room) $(B)/tests/$(room)/run,$(goal)),\
    $(call objects,tests/$(room)) $(HARNESS) $(PARTS.$(room)) $(CORE))))))
# find complains once of each that is not there
TOTAL = $(eval TOTAL := $$(if $$(OBJECTS),$$(shell find $$(OBJECTS) ! -newer $$(B)/flags 2>&1 | wc -l),0))$(TOTAL)
NUMBERS = $(eval NUMBERS := $$(shell seq $$(TOTAL)))$(NUMBERS)

$(B)/%.o: %.c $(B)/flags
	@mkdir -p $(@D)
	$(call say_counted,cc,$<)
	$(Q)$(CC) $(CFLAGS_ALL) -c $< -o $@

$(B)/%.o: %.cpp $(B)/flags
	@mkdir -p $(@D)
	$(call say_counted,c++,$<)
	$(Q)$(CXX) $(CXXFLAGS_ALL) -c $< -o $@

define kernel_rule
$(B)/%.$(1).o: %.c $(B)/flags $(B)/set.$(1)
	@mkdir -p $$(@D)
	$$(call say_counted,cc,$$< for $(1))
	$(Q)$$(CC) $$(subst $$(PIC),-fPIE,$$(CFLAGS_ALL)) -Wno-psabi $(ISA_FLAGS.$(1)) $$(KERNEL_FLAGS.$$*) $(KERNEL_SPARED.$(MODE)) -DPEND_ISA=$(1) -c $$< -o $$@
endef
$(foreach isa,$(filter-out $(ISA_IDLE),$(ISAS)),$(eval $(call kernel_rule,$(isa))))

define kernel_idle_rule
$(B)/%.$(1).o: $(B)/%.$(ISA_RUNS).o $(B)/set.$(1)
	$$(call say,name,$$< for $(1))
	$(Q)nm $$< | sed -nE 's/.* ([^ ]*_)$(ISA_RUNS)$$$$/\1$(ISA_RUNS) \1$(1)/p' | sort -u > $$@.names && objcopy --redefine-syms=$$@.names $$< $$@
endef
$(foreach isa,$(ISA_IDLE),$(eval $(call kernel_idle_rule,$(isa))))

$(B)/api/call/openapi_json.c: api/call/openapi.yaml api/call/openapi_embed.py
	@mkdir -p $(@D)
	$(call say,embed,$<)
	$(Q)/usr/bin/python3 api/call/openapi_embed.py $< > $@.new && mv $@.new $@

$(B)/api/call/openapi_json.o: $(B)/api/call/openapi_json.c $(B)/flags
	$(Q)$(CC) $(CFLAGS_ALL) -c $< -o $@

$(B)/server/classes/nickname_table.c: server/classes/nickname_alike.txt server/classes/nickname_table.py
	@mkdir -p $(@D)
	$(call say,table,$<)
	$(Q)/usr/bin/python3 -B server/classes/nickname_table.py $< > $@.new && mv $@.new $@

$(B)/server/classes/nickname_table.o: $(B)/server/classes/nickname_table.c server/classes/nickname_table.h $(B)/flags
	$(Q)$(CC) $(CFLAGS_ALL) -c $< -o $@

# the digest of all sources that decide an answer's bytes
ENGINE_SOURCES := $(sort $(filter-out api/call/openapi%,$(wildcard core/*/*.[ch] core/*/*/*.[ch] api/*/*.[ch] api/op/*/*.[ch] api/op/*.txt api/op/*/*.txt api/*/*.cpp api/op/*/*.cpp)))

# the page: its own files and the libraries that a browser loads, in one object that every MODE shares. Builds that
# run side by side may make it at once: each file is moved into its place whole.
WEB := $(shell find server/web -type f 2>/dev/null)
build/web/bundled: $(WEB) server/http/assets_bundle.sh build/web/files
	$(if $(V),,@printf '  %-8s %-5s %s\n' web pack server/web)
	$(Q)server/http/assets_bundle.sh $(@D)/bundles && touch $@

# the engine for browsers, where the tools for WebAssembly are here; an empty file where they are not
build/web/engine.wasm: $(ENGINE_SOURCES) $(wildcard api/clients/browser/*) build/web/tools | $(B)/api/base/engine.c
	$(if $(V),,@printf '  %-8s %-5s %s\n' web clang $@)
	+$(Q)api/clients/browser/engine.sh $@ $(B)/api/base/engine.c $(ENGINE)

build/web/assets.c: build/web/bundled $(wildcard api/guide/*.md) server/http/assets_embed.py build/web/engine.wasm
	$(if $(V),,@printf '  %-8s %-5s %s\n' web embed server/web)
	$(Q)/usr/bin/python3 -B server/http/assets_embed.py server/web $(@D)/bundles $(@D)/engine.wasm api/guide > $@.$$$$ && mv -f $@.$$$$ $@

build/web/assets.o: build/web/assets.c server/http/assets.h Makefile
	$(Q)$(CC) -I. -O1 $(CFLAGS) $(HARD.$(ARCH)) -c $< -o $@.$$$$ && mv -f $@.$$$$ $@

$(B)/api/base/engine.c: $(ENGINE_SOURCES) $(B)/parts
	@mkdir -p $(@D)
	$(Q)cat $(ENGINE_SOURCES) | sha256sum | sed -E 's/^(.{16})([0-9a-f]+).*/#include "api\/base\/engine.h"\nconst char api_engine[] = "\1\2", api_engine_name[] = "\1";/' > $@

$(B)/api/base/version.c: changed
	@mkdir -p $(@D)
	$(Q)docker/version.sh $@

$(B)/api/base/engine.o $(B)/api/base/version.o: %.o: %.c $(B)/flags
	$(Q)$(CC) $(CFLAGS_ALL) -c $< -o $@

$(B)/libpendulum.a: $(CORE) $(B)/parts
	@rm -f $@
	$(call say,ar,$@)
	$(Q)$(AR) rcs $@ $(CORE)

$(B)/pendulumd: $(B)/server/main.o $(SERVER) $(API) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) $(HARD_ENTRY.$(MODE).$(ARCH)) -o $@ $(filter-out %/parts,$^) $(LIBS)

# what a test program has of a library's archive is wrapped too: allocations within GSL and SQLite fail as ours do
ARCHIVES = gsl gslcblas sqlite3 deflate
TEST_LIBS = $(foreach lib,$(LIBS),$(or $(if $(filter $(ARCHIVES:%=-l%),$(lib)),$(filter /%,$(shell $(CC) -print-file-name=$(lib:-l%=lib%).a))),$(lib)))

# gcc 12 for 64-bit ARM cannot make vectors of a sum in these, and ends
$(patsubst %,$(B)/tests/core/modes/test_%.o,modes still): CFLAGS += $(if $(filter aarch64,$(ARCH)),-fno-tree-vectorize)

define test_program
$(B)/tests/$(1)/run: $(call objects,tests/$(1)) $(HARNESS) $(PARTS.$(1)) $(B)/parts
	@mkdir -p $$(@D)
	$$(call say,link,$$@)
	$(Q)$$(LINK) $(WRAP) $(WRAP.$(1)) -o $$@ $$(filter-out %/parts,$$^) $$(TEST_LIBS) $(QUADMATH)
endef
$(foreach room,$(ROOMS),$(eval $(call test_program,$(room))))

# the same objects as on a processor that has the base instruction set alone: what chooses among the sets is another
$(B)/tests/base/%: $(B)/tests/%/run $(B)/tests/base/isa.o
	$(call say,link,$@)
	$(Q)$(LINK) $(WRAP) -o $@ $(B)/tests/base/isa.o $(call objects,tests/$*) $(HARNESS) $(PARTS.$*) $(TEST_LIBS) $(QUADMATH)

# the door of the engine for browsers as native code of the base instruction set, which the module is compared with
$(B)/tests/engine/native: $(call objects,tests/engine) $(B)/api/clients/browser/door.o $(B)/tests/base/isa.o $(API) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS)

# the engine in a caller's process (api/clients/browser/door.h), which sees the door alone
$(B)/libpendulum.so: $(B)/api/clients/browser/door.o $(API) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)echo '{ global: door_*; api_held_*; local: *; };' > $@.map
	$(Q)$(LINK:-pie=-shared) -Wl,-Bsymbolic,-z,text,-z,defs,--gc-sections,--version-script,$@.map,-soname,libpendulum.so.0 -o $@ $(filter-out %/parts,$^) $(CLI_LIBS)

# the command line: what computes beside what asks
$(B)/pendulum: $(call objects,api/clients/cli) $(API) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(CLI_LIBS)
$(B)/api/clients/cli/remote.o: | curl
curl:
	@$(PKG_CONFIG) --exists libcurl || { echo 'The command line needs libcurl. On Debian: docker/install.sh client' >&2; exit 1; }
$(call lazy,CLI_LIBS,$(PKG_CONFIG) --libs libcurl $(filter-out libmicrohttpd sqlite3 libpq libseccomp libisal libzstd,$(PKG)) && echo -lm)

$(B)/tests/bench/parts/run: $(call objects,tests/bench/parts) $(API) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS)

$(B)/tests/bench/service/service: $(call objects,tests/bench/service) $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS)

$(B)/tests/bench/jobs/engine: $(call objects,tests/bench/jobs) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS)

$(B)/tests/load/client: $(call objects,tests/load) $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^)

# what is put before a process
$(B)/tests/drill/%.so: tests/drill/%.c $(B)/flags
	@mkdir -p $(@D)
	$(call say,cc,$<)
	$(Q)$(CC) $(filter-out -fsanitize=%,$(CFLAGS_ALL)) -shared -fPIC $< -o $@

$(B)/tests/bench/modes/run: $(call objects,tests/bench/modes) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS) -ldl

# peers get every instruction of this machine
SUNDIALS = $(if $(wildcard /usr/include/cvode/cvode.h),-lsundials_cvode -lsundials_arkode -lsundials_nvecserial \
  $(if $(wildcard /usr/lib/*/libsundials_core.so),-lsundials_core))
$(B)/tests/bench/trajectories/peers.o: CFLAGS += -march=native -ffast-math
$(B)/tests/bench/trajectories/run: $(call objects,tests/bench/trajectories) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS) $(SUNDIALS) -ldl

$(B)/tests/bench/dynamics/run: $(call objects,tests/bench/dynamics) $(B)/tests/harness/quad.o $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS) $(QUADMATH) -ldl

$(B)/tests/bench/precision/run: $(call objects,tests/bench/precision) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS)

$(B)/tests/bench/horizon/run: $(call objects,tests/bench/horizon) $(B)/tests/harness/motions.o $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS)

$(B)/tests/bench/instructions/run: $(call objects,tests/bench/instructions) $(B)/libpendulum.a $(B)/parts
	$(call say,link,$@)
	$(Q)$(LINK) -o $@ $(filter-out %/parts,$^) $(LIBS)

# of what is instrumented only what a program needs is linked: libFuzzer looks at all of it after each execution. Kernels are those
# of the base instruction set, with all checks; the others take minutes to compile with them.
$(B)/libfuzzed.a: $(SERVER) $(API) $(B)/libpendulum.a
	@rm -f $@
	$(call say,ar,$@)
	$(Q)$(AR) rcs $@ $(SERVER) $(API) $(CORE)

$(B)/fuzz_%: $(B)/tests/fuzz/fuzz_%.o $(B)/tests/fuzz/fuzz.o $(B)/tests/base/isa.o $(B)/libfuzzed.a
	$(call say,link,$@)
	$(Q)$(LINK) -fsanitize=fuzzer -o $@ $^ $(LIBS)

# these files change when the flags or the lists of source files do, and so cause what depends on them to be redone
build/web/files: changed
	@$(call remember,$(sort $(WEB)))
build/web/tools: changed
	@$(call remember,$(filter no,$(ENGINE)) $(wildcard /usr/bin/clang /usr/bin/wasm-ld /usr/include/wasm32-wasi /usr/lib/llvm-*/lib/clang/*/lib/wasi))
# without where the sources lie: a checkout that was moved has the same objects
$(B)/flags: changed
	@command -v $(firstword $(CC)) >/dev/null && $(PKG_CONFIG) --exists $(PKG) || { \
	  echo 'The compiler or a library is missing. On Debian, docker/install.sh build installs all that the build needs.' >&2; exit 1; }
	@$(call remember,$(subst $(SAME),,$(CC) $(CXX) $(CFLAGS_ALL) $(CXXFLAGS_ALL) $(CORE_SPARED) $(LIGHT.$(MODE))))
# an instruction set that is idle has the code of another
$(ISAS:%=$(B)/set.%): $(B)/set.%: changed
	@$(call remember,$(if $(filter $*,$(ISA_IDLE)),$(ISA_RUNS)))
$(B)/parts: changed
	@$(call remember,$(LINK) $(sort $(CORE) $(API) $(SERVER) $(HARNESS) $(foreach room,$(ROOMS) bench/parts,$(call objects,tests/$(room)))))
remember = mkdir -p $(@D); echo $(if $(strip $(1)),'$(strip $(1))') | cmp -s - $@ || echo $(if $(strip $(1)),'$(strip $(1))') > $@
changed:

-include $(shell find $(B) -name '*.d' 2>/dev/null)
.PHONY: help run check quick build slurm bench bench-beside bench-horizon bench-precision bench-parts bench-page drill histories school soak lesson hostile pages pictures load bench-dynamics bench-modes bench-stiff bench-trajectories debug install uninstall site clean test asan tsan fuzz arm dist deb release tour valgrind rules lint format format-check clang-flags clang-flags-c++ curl changed
.DELETE_ON_ERROR:

# pendulumd: `make run` serves, `make check` tests, `make help` lists the rest.
MODE ?= release
B := build/$(MODE)

CC ?= gcc
CXX ?= g++
PKG := libmicrohttpd libcjson gsl
WARN := -Wall -Wextra -Wshadow -Wpointer-arith -Wvla -Wformat=2 -Werror
FLAGS.release := -O3 -g -DNDEBUG
FLAGS.debug := -O1 -g
FLAGS.asan := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
FLAGS.tsan := -O1 -g -fsanitize=thread
COMMON := -I. $(FLAGS.$(MODE)) $(WARN) -MMD -MP -pthread $(shell pkg-config --cflags $(PKG))
CFLAGS_ALL := -std=c17 -D_GNU_SOURCE -Wstrict-prototypes -Wmissing-prototypes $(COMMON) $(CFLAGS)
CXXFLAGS_ALL := -std=c++17 -fno-exceptions -fno-rtti $(COMMON) $(addprefix -isystem ,$(wildcard /usr/include/dragonbox-*)) $(CXXFLAGS)
LIBS := $(shell pkg-config --libs $(PKG)) -lm

objects = $(patsubst %,$(B)/%.o,$(basename $(wildcard $(1)/*.c $(1)/*.cpp)))
CORE := $(call objects,core)
API := $(call objects,api) $(B)/api/openapi_json.o
SERVER := $(filter-out $(B)/server/main.o,$(call objects,server))
HARNESS := $(call objects,tests/harness)
ROOMS := core laws api server wire
WRAP := -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=aligned_alloc

all: $(B)/pendulumd

$(B)/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CFLAGS_ALL) -c $< -o $@

$(B)/%.o: %.cpp
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS_ALL) -c $< -o $@

$(B)/api/openapi_json.c: api/openapi.yaml api/openapi_embed.py
	@mkdir -p $(@D)
	/usr/bin/python3 api/openapi_embed.py $< > $@.new && mv $@.new $@

$(B)/api/openapi_json.o: $(B)/api/openapi_json.c
	$(CC) $(CFLAGS_ALL) -c $< -o $@

$(B)/libpendulum.a: $(CORE)
	@rm -f $@
	ar rcs $@ $^

$(B)/pendulumd: $(B)/server/main.o $(SERVER) $(API) $(B)/libpendulum.a
	$(CC) $(FLAGS.$(MODE)) -pthread -o $@ $^ $(LIBS)

# one test program a room: build/MODE/tests/core/run and so on
TEST_PARTS.core := $(B)/libpendulum.a
TEST_PARTS.laws := $(B)/libpendulum.a
TEST_PARTS.api := $(API) $(B)/libpendulum.a
TEST_PARTS.server := $(SERVER) $(API) $(B)/libpendulum.a
TEST_PARTS.wire := $(API) $(B)/libpendulum.a
define test_program
$(B)/tests/$(1)/run: $$(call objects,tests/$(1)) $$(HARNESS) $$(TEST_PARTS.$(1))
	$$(CC) $$(FLAGS.$$(MODE)) -pthread $$(WRAP) -o $$@ $$^ $$(LIBS) -lquadmath
endef
$(foreach room,$(ROOMS),$(eval $(call test_program,$(room))))

test-%: $(B)/tests/%/run
	$< $(T)

clean:
	rm -rf build

-include $(shell find $(B) -name '*.d' 2>/dev/null)
.PHONY: all clean

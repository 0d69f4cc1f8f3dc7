# The engine for browsers: engine.wasm of the sources of core and api that answer what a page asks while hands move.
# usage: make -f api/clients/browser/engine.mk OUT=build/web/engine.wasm ENGINE_C=file     (ENGINE_C: names of the engine)
# Leaves to others: whether it can be made here (engine.sh), serving it (server/http).
# Invariant: the flags that decide bits are those of the base instruction set; what is not compiled is imported, and refused there.
D := build/wasm
CLANG ?= clang
CLANGXX ?= clang++
# asked of a server: what computes long (ensembles, exponents, sections, fits, responses, 32 digits) or needs GSL's matrices, and
# files that a page saves
ELSEWHERE := core/extended/% core/ensemble/% core/derivatives/derivatives.c core/derivatives/ideal%.c core/derivatives/kernel_ideal.c core/fit/% core/control/% core/modes/damped.c \
  core/modes/response.c core/modes/kernel_response.c core/integrate/methods/method_gsl.c core/integrate/events/section.c core/base/checkpoint.c \
  api/op/op_lyapunov.c api/op/op_sections.c api/op/varied.c api/op/ensemble/% api/op/fit/% \
  $(addprefix api/op/modes/,damped_json.c op_controllers.c op_response.c response_json.c) \
  $(addprefix api/encode/,colormap.c encode_arrays.c encode_hdf5.c encode_mat.c encode_npz.c encode_parquet.c encode_png.c \
  encode_raw.c hdf5.c zip64.c) \
  $(addprefix api/call/,job_json.c part.c relay%.c results.c) api/link/% api/class/%
SOURCES := $(filter-out $(ELSEWHERE),$(wildcard core/*/*.c core/*/*/*.c api/*/*.c api/op/*/*.c)) api/clients/browser/door.c api/clients/browser/missing.c
CPP := $(wildcard api/*/*.cpp api/*/*/*.cpp)
OBJECTS := $(SOURCES:%.c=$(D)/%.o) $(CPP:%.cpp=$(D)/%.o) $(D)/engine.o
# mmap's header alone is asked for: its one function is imported
FLAGS := --target=wasm32-wasi -msimd128 -ffp-contract=off -O2 -DNDEBUG -Wall -D_GNU_SOURCE -D_WASI_EMULATED_MMAN -I. \
  -DPEND_ISA=base -include api/clients/browser/missing.h -MMD -MP "-ffile-prefix-map=$(CURDIR)=."
LINK := --target=wasm32-wasi -mexec-model=reactor -O2 -lm -Wl,--gc-sections,--strip-all,--import-undefined,--stack-first,-z,stack-size=1048576

$(OUT): $(OBJECTS)
	@$(CLANG) $(OBJECTS) $(LINK) -o $@.new && mv -f $@.new $@
$(D)/%.o: %.c api/clients/browser/engine.mk
	@mkdir -p $(@D)
	@$(CLANG) $(FLAGS) -std=c17 -c $< -o $@
$(D)/%.o: %.cpp api/clients/browser/engine.mk
	@mkdir -p $(@D)
	@$(CLANGXX) $(FLAGS) -std=c++17 -fno-exceptions -fno-rtti $(addprefix -isystem ,$(wildcard /usr/include/dragonbox-*)) -c $< -o $@
$(D)/engine.o: $(ENGINE_C)
	@mkdir -p $(@D)
	@$(CLANG) $(FLAGS) -std=c17 -c $< -o $@
-include $(shell find $(D) -name '*.d' 2>/dev/null)
.DELETE_ON_ERROR:

/* Fuzz targets ("readers"): libFuzzer runs one at a time; a test replays the repository's corpora
 * and makes its own mutations.
 * Leaves to others: the input of a reader and its checks (fuzz_X).
 * Invariant: the input ends at an unreadable page, so that reading beyond its end crashes in every
 * build. */
#pragma once

#include <stddef.h>

#include "tests/harness/own.h"

enum { FUZZ_ROOM = 1 << 16, FUZZ_SEEDS = 64 };

struct fuzz_reader {
    const char *name; /* the reader's name, and that of its corpus: tests/fuzz/corpus/NAME */
    /* Reads `bytes` bytes at `text`, which it may change, followed by a NUL. Returns 0 if a check
     * fails. */
    int (*read)(char *text, size_t bytes);
    const char *seed[FUZZ_SEEDS]; /* valid inputs that the test mutates; NULL ends the list */
    int bare;                     /* no NUL follows the bytes */
};

/** Adds `count` readers, which must live as long as the program. */
void fuzz_register(const struct fuzz_reader reader[], int count);

/** Registers all readers of an array before main. */
#define FUZZ_READERS(readers_)                                                                     \
    __attribute__((constructor)) static void register_##readers_(void) {                           \
        fuzz_register(readers_, (int)(sizeof readers_ / sizeof *readers_));                        \
    }

/** Runs a reader on some bytes, at most FUZZ_ROOM - 1 of them. Returns the reader's result. */
int fuzz_show(const struct fuzz_reader *reader, const void *data, size_t bytes);

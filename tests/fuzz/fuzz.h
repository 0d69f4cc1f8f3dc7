/* Readers that are shown bytes which nobody would send: by libFuzzer, one reader a run, and by a
 * test that replays the corpora of the repository and makes mutations of its own.
 * Leaves to others: what a reader reads and what must hold of it (fuzz_X).
 * Invariant: what a reader is shown ends at a page that cannot be read, so that a reader that
 * looks a byte further ends at once in every build. */
#pragma once

#include <stddef.h>

#include "tests/harness/own.h"

enum { FUZZ_ROOM = 1 << 16, FUZZ_SEEDS = 64 };

struct fuzz_reader {
    const char *name; /* also that of its corpus, tests/fuzz/corpus/NAME */
    /* Reads `bytes` bytes at `text`, which it may change, and a NUL behind them. Returns 0 where
     * something does not hold that must. */
    int (*read)(char *text, size_t bytes);
    const char *seed[FUZZ_SEEDS]; /* good ones, which the test makes mutations of; NULL where there
                                     are no more */
    int bare;                     /* there is no NUL behind the bytes */
};

/** Adds readers, `count` of them, which live as long as the program. */
void fuzz_register(const struct fuzz_reader reader[], int count);

/** Registers all readers of an array before main. */
#define FUZZ_READERS(readers_)                                                                     \
    __attribute__((constructor)) static void register_##readers_(void) {                           \
        fuzz_register(readers_, (int)(sizeof readers_ / sizeof *readers_));                        \
    }

/** Shows a reader bytes; more than FUZZ_ROOM - 1 are not shown. Returns what the reader does. */
int fuzz_show(const struct fuzz_reader *reader, const void *data, size_t bytes);

/* The state of a computation as bytes: its owner passes every part to a checkpoint in a fixed
 * order, and the checkpoint saves the parts, restores them, or counts their bytes.
 * Leaves to others: which parts there are (the owners' `carry`), where the bytes are kept (server).
 * Invariant: one function of the owner passes the parts for all three, so that exactly the saved
 * parts are restored. */
#pragma once

#include <stddef.h>

enum pend_checkpoint_way { PEND_CHECKPOINT_COUNT, PEND_CHECKPOINT_TAKE, PEND_CHECKPOINT_PUT };

/* The largest value that a counter can have; sums of counters up to this cannot overflow a long. */
#define PEND_CHECKPOINT_MOST (1L << 53)

struct pend_checkpoint {
    enum pend_checkpoint_way way;
    char *at;     /* `bytes` bytes; only read if `way` is PEND_CHECKPOINT_PUT */
    size_t used;  /* bytes of the parts passed so far */
    size_t bytes; /* size of the memory at `at` */
};

/** Passes a part: `bytes` bytes at `data`, which are saved, overwritten or only counted. A part
 * that exceeds the checkpoint's memory marks the checkpoint as unusable. O(bytes). */
void pend_checkpoint_part(struct pend_checkpoint *checkpoint, void *data, size_t bytes);

/** Passes an array of `count` doubles, as pend_checkpoint_part. */
void pend_checkpoint_row(struct pend_checkpoint *checkpoint, double row[], size_t count);

/** Passes an integer from 0 to `most`. A restored integer outside this range becomes 0 and marks
 * the checkpoint as unusable: restored bytes come from a disk, and must neither index beyond an
 * array nor overflow a later sum. */
void pend_checkpoint_int(struct pend_checkpoint *checkpoint, int *number, int most);

/** Passes `count` counters, each from 0 to PEND_CHECKPOINT_MOST, as pend_checkpoint_int. */
void pend_checkpoint_counts(struct pend_checkpoint *checkpoint, long number[], size_t count);

/** Marks the checkpoint as unusable: from then on it only counts bytes, and pend_checkpoint_whole
 * returns false. */
void pend_checkpoint_refuse(struct pend_checkpoint *checkpoint);

/** Returns true while the checkpoint restores parts. */
int pend_checkpoint_puts(const struct pend_checkpoint *checkpoint);

/** Returns true if the parts passed filled exactly the checkpoint's memory. */
int pend_checkpoint_whole(const struct pend_checkpoint *checkpoint);
int pend_checkpoint_valid(const struct pend_checkpoint *checkpoint);

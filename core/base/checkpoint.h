/* What a computation has in hand, as bytes: a checkpoint is shown every part of it in a fixed
 * order and takes it down, puts it back, or only counts. Leaves to others: which parts there are
 * (the owners' `carry`), where the bytes are kept (server). Invariant: one function shows the
 * parts for all three, so that what is taken down is what is put back. */
#ifndef PEND_CHECKPOINT_H
#define PEND_CHECKPOINT_H

#include <stddef.h>

enum pend_checkpoint_way { PEND_CHECKPOINT_COUNT, PEND_CHECKPOINT_TAKE, PEND_CHECKPOINT_PUT };

/* a counter that is larger was never counted: it leaves room for any number of steps more */
#define PEND_CHECKPOINT_MOST (1L << 53)

struct pend_checkpoint {
    enum pend_checkpoint_way way;
    char *at;     /* the bytes; only read when they are put back */
    size_t used;  /* bytes shown so far */
    size_t bytes; /* there are; nothing beyond is touched */
};

/** Shows a part: so many bytes at `data`. What no room or no bytes are left for is only counted. */
void pend_checkpoint_part(struct pend_checkpoint *checkpoint, void *data, size_t bytes);

/** Shows an array of doubles. */
void pend_checkpoint_row(struct pend_checkpoint *checkpoint, double row[], size_t count);

/**
 * Shows a whole number of 0 .. most. One that is put back and lies outside becomes 0 and makes the
 * checkpoint refuse: what is put back comes from a disk, and must neither index beyond an array nor
 * overflow when it is counted on.
 */
void pend_checkpoint_int(struct pend_checkpoint *checkpoint, int *number, int most);

/** Shows `count` counters: each of 0 .. PEND_CHECKPOINT_MOST, as pend_checkpoint_int. */
void pend_checkpoint_counts(struct pend_checkpoint *checkpoint, long number[], size_t count);

/** Makes the checkpoint one that is not whole, and ends putting back: what it holds cannot be
 * gone on from. */
void pend_checkpoint_refuse(struct pend_checkpoint *checkpoint);

/** True while parts are put back. */
int pend_checkpoint_puts(const struct pend_checkpoint *checkpoint);

/** True where the parts shown were just the bytes that there are. */
int pend_checkpoint_whole(const struct pend_checkpoint *checkpoint);

#endif

/* What a computation has in hand, as bytes: a tape is shown every part of it in a fixed order and takes it down, puts
 * it back, or only counts. Leaves to others: which parts there are (the owners' `carry`), where the bytes are kept
 * (server). Invariant: one function shows the parts for all three, so that what is taken down is what is put back. */
#ifndef PEND_CHECKPOINT_H
#define PEND_CHECKPOINT_H

#include <stddef.h>

enum pend_tape_way { PEND_TAPE_COUNT, PEND_TAPE_TAKE, PEND_TAPE_PUT };

/* a counter that is larger was never counted: it leaves room for any number of steps more */
#define PEND_TAPE_MOST (1L << 53)

struct pend_tape {
    enum pend_tape_way way;
    char *at;     /* the bytes; only read when they are put back */
    size_t used;  /* bytes shown so far */
    size_t bytes; /* there are; nothing beyond is touched */
};

/** Shows a part: so many bytes at `data`. What no room or no bytes are left for is only counted. */
void pend_tape_part(struct pend_tape *tape, void *data, size_t bytes);

/** Shows an array of doubles. */
void pend_tape_row(struct pend_tape *tape, double row[], size_t count);

/**
 * Shows a whole number of 0 .. most. One that is put back and lies outside becomes 0 and makes the tape refuse: what is
 * put back comes from a disk, and must neither index beyond an array nor overflow when it is counted on.
 */
void pend_tape_int(struct pend_tape *tape, int *number, int most);

/** Shows `count` counters: each of 0 .. PEND_TAPE_MOST, as pend_tape_int. */
void pend_tape_counts(struct pend_tape *tape, long number[], size_t count);

/** Makes the tape one that is not whole, and ends putting back: what it holds cannot be gone on from. */
void pend_tape_refuse(struct pend_tape *tape);

/** True while parts are put back. */
int pend_tape_puts(const struct pend_tape *tape);

/** True where the parts shown were just the bytes that there are. */
int pend_tape_whole(const struct pend_tape *tape);

#endif

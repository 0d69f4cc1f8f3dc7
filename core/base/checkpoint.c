#include "core/base/checkpoint.h"

#include <assert.h>
#include <string.h>

int pend_checkpoint_valid(const struct pend_checkpoint *checkpoint) {
    if (checkpoint->way == PEND_CHECKPOINT_COUNT) return 1;
    if (checkpoint->way != PEND_CHECKPOINT_TAKE && checkpoint->way != PEND_CHECKPOINT_PUT) return 0;
    return checkpoint->used <= checkpoint->bytes && (checkpoint->at || !checkpoint->bytes);
}

void pend_checkpoint_refuse(struct pend_checkpoint *checkpoint) {
    assert(pend_checkpoint_valid(checkpoint));
    checkpoint->bytes = checkpoint->used;
    checkpoint->way = PEND_CHECKPOINT_COUNT;
}

void pend_checkpoint_part(struct pend_checkpoint *checkpoint, void *data, size_t bytes) {
    assert(pend_checkpoint_valid(checkpoint) && (data || !bytes));
    char *at =
        checkpoint->way == PEND_CHECKPOINT_COUNT || bytes > checkpoint->bytes - checkpoint->used
            ? NULL
            : checkpoint->at + checkpoint->used;
    if (at && bytes)
        memcpy(checkpoint->way == PEND_CHECKPOINT_TAKE ? at : data,
               checkpoint->way == PEND_CHECKPOINT_TAKE ? data : at, bytes);
    // once a part does not fit, no later part may be saved or restored
    if (checkpoint->way != PEND_CHECKPOINT_COUNT && !at && bytes)
        pend_checkpoint_refuse(checkpoint);
    checkpoint->used += bytes;
    assert(pend_checkpoint_valid(checkpoint));
}

void pend_checkpoint_row(struct pend_checkpoint *checkpoint, double row[], size_t count) {
    pend_checkpoint_part(checkpoint, row, count * sizeof(double));
}

void pend_checkpoint_int(struct pend_checkpoint *checkpoint, int *number, int most) {
    assert(most >= 0);
    assert(pend_checkpoint_puts(checkpoint) || (*number >= 0 && *number <= most));
    pend_checkpoint_part(checkpoint, number, sizeof *number);
    if (!pend_checkpoint_puts(checkpoint) || (*number >= 0 && *number <= most)) return;
    *number = 0;
    pend_checkpoint_refuse(checkpoint);
}

void pend_checkpoint_counts(struct pend_checkpoint *checkpoint, long number[], size_t count) {
    for (size_t i = 0; i < count; i++) {
        pend_checkpoint_part(checkpoint, &number[i], sizeof number[i]);
        if (!pend_checkpoint_puts(checkpoint) ||
            (number[i] >= 0 && number[i] <= PEND_CHECKPOINT_MOST))
            continue;
        number[i] = 0;
        pend_checkpoint_refuse(checkpoint);
    }
}

int pend_checkpoint_puts(const struct pend_checkpoint *checkpoint) {
    return checkpoint->way == PEND_CHECKPOINT_PUT;
}

int pend_checkpoint_whole(const struct pend_checkpoint *checkpoint) {
    assert(pend_checkpoint_valid(checkpoint));
    return checkpoint->way != PEND_CHECKPOINT_COUNT && checkpoint->used == checkpoint->bytes;
}

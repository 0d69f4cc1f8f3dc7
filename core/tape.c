#include "core/tape.h"

#include <string.h>

void pend_tape_part(struct pend_tape *tape, void *data, size_t bytes) {
    char *at = tape->way == PEND_TAPE_COUNT || bytes > tape->bytes - tape->used ? NULL : tape->at + tape->used;
    if (at && bytes) memcpy(tape->way == PEND_TAPE_TAKE ? at : data, tape->way == PEND_TAPE_TAKE ? data : at, bytes);
    /* what did not fit makes the tape too long for its bytes, once and for all */
    if (tape->way != PEND_TAPE_COUNT && !at && bytes) {
        tape->bytes = tape->used;
        tape->way = PEND_TAPE_COUNT;
    }
    tape->used += bytes;
}

void pend_tape_row(struct pend_tape *tape, double row[], size_t count) {
    pend_tape_part(tape, row, count * sizeof(double));
}

int pend_tape_puts(const struct pend_tape *tape) { return tape->way == PEND_TAPE_PUT; }

int pend_tape_whole(const struct pend_tape *tape) { return tape->way != PEND_TAPE_COUNT && tape->used == tape->bytes; }

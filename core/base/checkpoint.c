#include "core/base/checkpoint.h"

#include <string.h>

void pend_tape_refuse(struct pend_tape *tape) {
    tape->bytes = tape->used;
    tape->way = PEND_TAPE_COUNT;
}

void pend_tape_part(struct pend_tape *tape, void *data, size_t bytes) {
    char *at = tape->way == PEND_TAPE_COUNT || bytes > tape->bytes - tape->used ? NULL : tape->at + tape->used;
    if (at && bytes) memcpy(tape->way == PEND_TAPE_TAKE ? at : data, tape->way == PEND_TAPE_TAKE ? data : at, bytes);
    /* what did not fit makes the tape too long for its bytes, once and for all */
    if (tape->way != PEND_TAPE_COUNT && !at && bytes) pend_tape_refuse(tape);
    tape->used += bytes;
}

void pend_tape_row(struct pend_tape *tape, double row[], size_t count) {
    pend_tape_part(tape, row, count * sizeof(double));
}

void pend_tape_int(struct pend_tape *tape, int *number, int most) {
    pend_tape_part(tape, number, sizeof *number);
    if (!pend_tape_puts(tape) || (*number >= 0 && *number <= most)) return;
    *number = 0;
    pend_tape_refuse(tape);
}

void pend_tape_counts(struct pend_tape *tape, long number[], size_t count) {
    for (size_t i = 0; i < count; i++) {
        pend_tape_part(tape, &number[i], sizeof number[i]);
        if (!pend_tape_puts(tape) || (number[i] >= 0 && number[i] <= PEND_TAPE_MOST)) continue;
        number[i] = 0;
        pend_tape_refuse(tape);
    }
}

int pend_tape_puts(const struct pend_tape *tape) { return tape->way == PEND_TAPE_PUT; }

int pend_tape_whole(const struct pend_tape *tape) { return tape->way != PEND_TAPE_COUNT && tape->used == tape->bytes; }

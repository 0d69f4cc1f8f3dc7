#include "core/tape.h"

#include <string.h>

#include "tests/harness/test.h"

/* two parts of an owner */
struct owner {
    int number;
    double row[3];
};

static void show(struct owner *owner, struct pend_tape *tape) {
    pend_tape_part(tape, &owner->number, sizeof owner->number);
    pend_tape_row(tape, owner->row, 3);
}

TEST(tape_puts_back_what_it_took_down) {
    struct owner one = {7, {1, 2, 3}}, two = {0};
    char bytes[sizeof(int) + 3 * sizeof(double)];
    struct pend_tape tape = {.way = PEND_TAPE_COUNT};
    show(&one, &tape);
    CHECK_INT(tape.used, sizeof bytes);
    CHECK(!pend_tape_whole(&tape));
    tape = (struct pend_tape){.way = PEND_TAPE_TAKE, .at = bytes, .bytes = sizeof bytes};
    show(&one, &tape);
    CHECK(pend_tape_whole(&tape) && !pend_tape_puts(&tape));
    tape = (struct pend_tape){.way = PEND_TAPE_PUT, .at = bytes, .bytes = sizeof bytes};
    CHECK(pend_tape_puts(&tape));
    show(&two, &tape);
    CHECK(pend_tape_whole(&tape) && two.number == 7 && !memcmp(two.row, one.row, sizeof one.row));
}

TEST(tape_touches_nothing_beyond_its_bytes) {
    struct owner one = {7, {1, 2, 3}}, two = {5, {4, 4, 4}};
    char bytes[64];
    for (size_t room = 0; room < sizeof(int) + 3 * sizeof(double); room++) {
        memset(bytes, 'x', sizeof bytes);
        struct pend_tape tape = {.way = PEND_TAPE_TAKE, .at = bytes, .bytes = room};
        show(&one, &tape);
        CHECK(!pend_tape_whole(&tape) && tape.used == sizeof(int) + 3 * sizeof(double));
        CHECK(bytes[room] == 'x');
        tape = (struct pend_tape){.way = PEND_TAPE_PUT, .at = bytes, .bytes = room};
        show(&two, &tape);
        CHECK(!pend_tape_whole(&tape) && !pend_tape_puts(&tape) && two.row[0] == 4);
    }
    /* too long is not whole either */
    struct pend_tape tape = {.way = PEND_TAPE_PUT, .at = bytes, .bytes = sizeof bytes};
    show(&two, &tape);
    CHECK(!pend_tape_whole(&tape));
}

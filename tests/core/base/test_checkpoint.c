#include "core/base/checkpoint.h"

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

/* three counters and a choice, as a disk may give them back */
TEST(tape_refuses_numbers_that_nobody_counted) {
    static const long bad[] = {-1, PEND_TAPE_MOST + 1, 0x7fffffffffffffff};
    for (int i = 0; i < 6; i++) {
        long count[3] = {0, PEND_TAPE_MOST, 5};
        int choice = 1;
        struct pend_tape tape = {.way = PEND_TAPE_TAKE, .bytes = 64};
        char bytes[64];
        tape.at = bytes;
        pend_tape_counts(&tape, count, 3);
        pend_tape_int(&tape, &choice, 1);
        tape = (struct pend_tape){.way = PEND_TAPE_PUT, .at = bytes, .bytes = tape.used};
        int other = i == 3 ? 2 : i == 4 ? -1 : 12345;
        if (i < 3)
            memcpy(bytes + sizeof(long) * (size_t)i, &bad[i], sizeof bad[i]);
        else
            memcpy(bytes + 3 * sizeof(long), &other, sizeof other);
        pend_tape_counts(&tape, count, 3);
        pend_tape_int(&tape, &choice, 1);
        CHECK(!pend_tape_whole(&tape) && !pend_tape_puts(&tape));
        CHECK(choice == (i < 3) && count[2] == (i == 2 ? 0 : 5));
    }
}

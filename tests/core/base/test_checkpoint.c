#include "core/base/checkpoint.h"

#include <string.h>

#include "tests/harness/test.h"

/* two parts of an owner */
struct owner {
    int number;
    double row[3];
};

static void show(struct owner *owner, struct pend_checkpoint *checkpoint) {
    pend_checkpoint_part(checkpoint, &owner->number, sizeof owner->number);
    pend_checkpoint_row(checkpoint, owner->row, 3);
}

TEST(checkpoint_puts_back_what_it_took_down) {
    struct owner one = {7, {1, 2, 3}}, two = {0};
    char bytes[sizeof(int) + 3 * sizeof(double)];
    struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_COUNT};
    show(&one, &checkpoint);
    CHECK_INT(checkpoint.used, sizeof bytes);
    CHECK(!pend_checkpoint_whole(&checkpoint));
    checkpoint =
        (struct pend_checkpoint){.way = PEND_CHECKPOINT_TAKE, .at = bytes, .bytes = sizeof bytes};
    show(&one, &checkpoint);
    CHECK(pend_checkpoint_whole(&checkpoint) && !pend_checkpoint_puts(&checkpoint));
    checkpoint =
        (struct pend_checkpoint){.way = PEND_CHECKPOINT_PUT, .at = bytes, .bytes = sizeof bytes};
    CHECK(pend_checkpoint_puts(&checkpoint));
    show(&two, &checkpoint);
    CHECK(pend_checkpoint_whole(&checkpoint) && two.number == 7 &&
          !memcmp(two.row, one.row, sizeof one.row));
}

TEST(checkpoint_touches_nothing_beyond_its_bytes) {
    struct owner one = {7, {1, 2, 3}}, two = {5, {4, 4, 4}};
    char bytes[64];
    for (size_t room = 0; room < sizeof(int) + 3 * sizeof(double); room++) {
        memset(bytes, 'x', sizeof bytes);
        struct pend_checkpoint checkpoint = {
            .way = PEND_CHECKPOINT_TAKE, .at = bytes, .bytes = room};
        show(&one, &checkpoint);
        CHECK(!pend_checkpoint_whole(&checkpoint) &&
              checkpoint.used == sizeof(int) + 3 * sizeof(double));
        CHECK(bytes[room] == 'x');
        checkpoint =
            (struct pend_checkpoint){.way = PEND_CHECKPOINT_PUT, .at = bytes, .bytes = room};
        show(&two, &checkpoint);
        CHECK(!pend_checkpoint_whole(&checkpoint) && !pend_checkpoint_puts(&checkpoint) &&
              two.row[0] == 4);
    }
    /* a text that is too long is invalid too */
    struct pend_checkpoint checkpoint = {
        .way = PEND_CHECKPOINT_PUT, .at = bytes, .bytes = sizeof bytes};
    show(&two, &checkpoint);
    CHECK(!pend_checkpoint_whole(&checkpoint));
}

/* three counters and an enumeration, as a damaged disk may return them */
TEST(checkpoint_refuses_numbers_that_nobody_counted) {
    static const long bad[] = {-1, PEND_CHECKPOINT_MOST + 1, 0x7fffffffffffffff};
    for (int i = 0; i < 6; i++) {
        long count[3] = {0, PEND_CHECKPOINT_MOST, 5};
        int choice = 1;
        struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_TAKE, .bytes = 64};
        char bytes[64];
        checkpoint.at = bytes;
        pend_checkpoint_counts(&checkpoint, count, 3);
        pend_checkpoint_int(&checkpoint, &choice, 1);
        checkpoint = (struct pend_checkpoint){
            .way = PEND_CHECKPOINT_PUT, .at = bytes, .bytes = checkpoint.used};
        int other = i == 3 ? 2 : i == 4 ? -1 : 12345;
        if (i < 3)
            memcpy(bytes + sizeof(long) * (size_t)i, &bad[i], sizeof bad[i]);
        else
            memcpy(bytes + 3 * sizeof(long), &other, sizeof other);
        pend_checkpoint_counts(&checkpoint, count, 3);
        pend_checkpoint_int(&checkpoint, &choice, 1);
        CHECK(!pend_checkpoint_whole(&checkpoint) && !pend_checkpoint_puts(&checkpoint));
        CHECK(choice == (i < 3) && count[2] == (i == 2 ? 0 : 5));
    }
}

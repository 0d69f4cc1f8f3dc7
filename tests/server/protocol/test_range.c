#include "server/protocol/range.h"

#include <string.h>

#include "tests/harness/test.h"

TEST(one_range_of_bytes_is_read_and_nothing_else) {
    static const struct {
        const char *field;
        int good;
        long long first, last;
    } row[] = {
        {"bytes=0-0", 1, 0, 0},
        {"bytes=5-", 1, 5, -1},
        {"bytes=-7", 1, -1, 7},
        {"bytes=-0", 1, -1, 0},
        {"Bytes= 10-20 ", 1, 10, 20},
        {"bytes=999999999999999999-", 1, 999999999999999999, -1},
        {NULL, 0, 0, 0},
        {"", 0, 0, 0},
        {"bytes", 0, 0, 0},
        {"bytes=", 0, 0, 0},
        {"bytes=-", 0, 0, 0},
        {"bytes=5", 0, 0, 0},
        {"bytes=5-4", 0, 0, 0},
        {"bytes=1-2,4-5", 0, 0, 0},
        {"bytes=a-b", 0, 0, 0},
        {"bytes=0x1-2", 0, 0, 0},
        {"bytes=+1-2", 0, 0, 0},
        {"bytes=--1", 0, 0, 0},
        {"bytes=1-2x", 0, 0, 0},
        {"rows=1-2", 0, 0, 0},
        {"bytes=9999999999999999999-", 0, 0, 0},
        {"bytes=0-9999999999999999999", 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct api_range range;
        int good = srv_range_read(row[i].field, &range);
        CHECK_SAYING(good == row[i].good, "%s", row[i].field ? row[i].field : "none");
        if (!good || !row[i].good) continue;
        CHECK_INT(range.first, row[i].first);
        CHECK_INT(range.last, row[i].last);
    }
}

/* Tests of server/work/hold without a server: the counts. */
#include "server/work/hold.h"

#include <math.h>

#include "tests/harness/test.h"

TEST(bytes_that_no_memory_has_are_counted_without_overflow) {
    static const double told[] = {0, 1, 4096.9, 1e15, 1e16, 1e300, INFINITY, NAN, -1};
    static const size_t counted[] = {0,
                                     1,
                                     4096,
                                     1000000000000000,
                                     (size_t)1 << 53,
                                     (size_t)1 << 53,
                                     (size_t)1 << 53,
                                     (size_t)1 << 53,
                                     0};
    for (size_t i = 0; i < sizeof told / sizeof *told; i++)
        CHECK_SAYING(srv_hold_count(told[i]) == counted[i], "%g: %zu", told[i],
                     srv_hold_count(told[i]));
}

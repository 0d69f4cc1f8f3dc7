#include "server/base/buffer_pool.h"

#include <stdlib.h>

#include "tests/harness/test.h"

/* a buffer with so much memory */
static struct api_buffer spares_buffer(size_t bytes, size_t limit) {
    struct api_buffer buffer;
    api_buffer_init(&buffer, limit);
    CHECK(api_buffer_room(&buffer, bytes) == PEND_OK);
    buffer.bytes = bytes;
    return buffer;
}

TEST(memory_that_is_given_is_taken_again_last_first) {
    struct srv_spares spares;
    struct api_buffer one = spares_buffer(5000, 1 << 20), two = spares_buffer(6000, 1 << 20), next;
    char *first = one.data, *second = two.data;
    srv_spares_init(&spares);
    srv_spares_give(&spares, &one);
    srv_spares_give(&spares, &two);
    CHECK(!one.data && !one.cap && !two.data && one.limit == 1 << 20);
    long before = test_alloc_count();
    api_buffer_init(&next, 100000);
    srv_spares_take(&spares, &next);
    CHECK(next.data == second && next.bytes == 0 && next.cap >= 6000 && next.limit == 100000);
    srv_spares_take(&spares, &next);
    CHECK(next.data == second && spares.count == 1);
    CHECK_INT(test_alloc_count(), before);
    srv_spares_take(&spares, &one);
    CHECK(one.data == first);
    srv_spares_take(&spares, &two);
    CHECK(!two.data);
    api_buffer_clear(&next);
    srv_spares_give(&spares, &one);
    srv_spares_clear(&spares);
}

TEST(spare_memory_is_bounded_and_keeps_to_the_taker_s_limit) {
    struct srv_spares spares;
    srv_spares_init(&spares);
    struct api_buffer huge = spares_buffer(SRV_SPARE_BYTES + 1, SRV_SPARE_BYTES * 4), small;
    srv_spares_give(&spares, &huge);
    CHECK(!huge.data && !spares.count);
    for (int i = 0; i < SRV_SPARES + 3; i++) {
        struct api_buffer buffer = spares_buffer(50000, 1 << 20);
        srv_spares_give(&spares, &buffer);
        CHECK(!buffer.data);
    }
    CHECK_INT(spares.count, SRV_SPARES);
    api_buffer_init(&small, 1000);
    srv_spares_take(&spares, &small);
    CHECK(small.cap <= 1000 && small.limit == 1000);
    api_buffer_clear(&small);
    srv_spares_clear(&spares);
}

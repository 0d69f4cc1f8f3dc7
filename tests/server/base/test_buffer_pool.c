#include "server/base/buffer_pool.h"

#include <stdlib.h>

#include "tests/harness/test.h"

/* a buffer with this much memory */
static struct api_buffer pool_buffer(size_t bytes, size_t limit) {
    struct api_buffer buffer;
    api_buffer_init(&buffer, limit);
    CHECK(api_buffer_room(&buffer, bytes) == PEND_OK);
    buffer.bytes = bytes;
    return buffer;
}

TEST(memory_that_is_given_is_taken_again_last_first) {
    OWN(srv_buffer_pool, clear) pool;
    struct api_buffer one = pool_buffer(5000, 1 << 20), two = pool_buffer(6000, 1 << 20), next;
    char *first = one.data, *second = two.data;
    srv_buffer_pool_init(&pool);
    srv_buffer_pool_give(&pool, &one);
    srv_buffer_pool_give(&pool, &two);
    CHECK(!one.data && !one.cap && !two.data && one.limit == 1 << 20);
    long before = test_alloc_count();
    api_buffer_init(&next, 100000);
    srv_buffer_pool_take(&pool, &next);
    CHECK(next.data == second && next.bytes == 0 && next.cap >= 6000 && next.limit == 100000);
    srv_buffer_pool_take(&pool, &next);
    CHECK(next.data == second && pool.count == 1);
    CHECK_INT(test_alloc_count(), before);
    srv_buffer_pool_take(&pool, &one);
    CHECK(one.data == first);
    srv_buffer_pool_take(&pool, &two);
    CHECK(!two.data);
    api_buffer_clear(&next);
    srv_buffer_pool_give(&pool, &one);
}

TEST(spare_memory_is_bounded_and_keeps_to_the_taker_s_limit) {
    OWN(srv_buffer_pool, clear) pool;
    srv_buffer_pool_init(&pool);
    struct api_buffer huge = pool_buffer(SRV_SPARE_BYTES + 1, SRV_SPARE_BYTES * 4), small;
    srv_buffer_pool_give(&pool, &huge);
    CHECK(!huge.data && !pool.count);
    for (int i = 0; i < SRV_BUFFER_POOL + 3; i++) {
        struct api_buffer buffer = pool_buffer(50000, 1 << 20);
        srv_buffer_pool_give(&pool, &buffer);
        CHECK(!buffer.data);
    }
    CHECK_INT(pool.count, SRV_BUFFER_POOL);
    api_buffer_init(&small, 1000);
    srv_buffer_pool_take(&pool, &small);
    CHECK(small.cap <= 1000 && small.limit == 1000);
    api_buffer_clear(&small);
}

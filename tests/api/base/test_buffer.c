#include "api/base/buffer.h"

#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

static int holds(const struct api_buffer *buffer, const char *text) {
    return buffer->bytes == strlen(text) && !memcmp(buffer->data, text, buffer->bytes) &&
           buffer->bytes <= buffer->cap && buffer->cap <= buffer->limit;
}

TEST(buffer_begins_empty_and_allocates_nothing) {
    OWN(api_buffer, clear) buffer;
    long before = test_alloc_count();
    api_buffer_init(&buffer, 100);
    CHECK(!buffer.data && !buffer.bytes && !buffer.cap && buffer.limit == 100);
    CHECK_INT(api_buffer_add(&buffer, NULL, 0), PEND_OK);
    CHECK_INT(test_alloc_count(), before);
}

TEST(buffer_keeps_what_is_appended_in_order) {
    struct api_buffer buffer;
    api_buffer_init(&buffer, 1000);
    CHECK_INT(api_buffer_text(&buffer, "one "), PEND_OK);
    CHECK_INT(api_buffer_add(&buffer, "two\0three", 4), PEND_OK);
    CHECK_INT(api_buffer_format(&buffer, "%d %s", 4, "five"), PEND_OK);
    CHECK_INT((long long)buffer.bytes, 14);
    CHECK(!memcmp(buffer.data, "one two\0004 five", 14));
    api_buffer_clear(&buffer);
    CHECK(!buffer.data && !buffer.bytes && !buffer.cap && buffer.limit == 1000);
}

TEST(buffer_goes_to_its_limit_and_not_beyond) {
    OWN(api_buffer, clear) buffer;
    api_buffer_init(&buffer, 10);
    CHECK_INT(api_buffer_text(&buffer, "12345678"), PEND_OK);
    CHECK_INT(api_buffer_text(&buffer, "901"), PEND_LIMIT);
    CHECK_INT(api_buffer_format(&buffer, "%d", 901), PEND_LIMIT);
    CHECK_INT(api_buffer_room(&buffer, (size_t)-1), PEND_LIMIT);
    CHECK(holds(&buffer, "12345678"));
    CHECK_INT(api_buffer_format(&buffer, "%d", 90), PEND_OK);
    CHECK(holds(&buffer, "1234567890"));
    CHECK_INT(api_buffer_text(&buffer, "1"), PEND_LIMIT);
    CHECK_INT(api_buffer_text(&buffer, ""), PEND_OK);
    CHECK(holds(&buffer, "1234567890"));
}

TEST(buffer_grows_by_few_allocations) {
    OWN(api_buffer, clear) buffer;
    long before = test_alloc_count();
    int failed = 0;
    api_buffer_init(&buffer, 1 << 24);
    for (int i = 0; i < 1 << 20; i++)
        failed += api_buffer_add(&buffer, "0123456789abcdef", 16) != PEND_OK;
    CHECK_INT(failed, 0);
    CHECK_INT((long long)buffer.bytes, 1 << 24);
    CHECK_SAYING(test_alloc_count() - before < 20, "%ld allocations", test_alloc_count() - before);
}

TEST(buffer_formats_a_text_of_any_length) {
    OWN(api_buffer, clear) buffer;
    int faults = 0;
    api_buffer_init(&buffer, 1 << 20);
    for (int width = 0; width < 3000; width += 7) {
        buffer.bytes = 0;
        faults += api_buffer_format(&buffer, "%*d|", width, 7) != PEND_OK;
        faults += (int)buffer.bytes != (width > 1 ? width : 1) + 1 ||
                  buffer.data[buffer.bytes - 1] != '|';
    }
    CHECK_INT(faults, 0);
}

TEST(buffer_keeps_its_contents_when_memory_fails) {
    for (int for_good = 0; for_good < 2; for_good++) {
        OWN(api_buffer, clear) buffer;
        api_buffer_init(&buffer, 1 << 20);
        CHECK_INT(api_buffer_text(&buffer, "kept"), PEND_OK);
        char *data = buffer.data;
        static char more[1200]; /* doubling would be more than is needed */
        int failed = 0;
        for (long count = 1; count < 10; count++) {
            test_alloc_fail(count, for_good);
            enum pend_status status = api_buffer_add(&buffer, more, sizeof more);
            test_alloc_faults_off();
            if (status == PEND_OK) break;
            failed++;
            CHECK_INT(status, PEND_NO_MEMORY);
            CHECK(buffer.data == data && holds(&buffer, "kept"));
        }
        /* a single failure is overcome by requesting less */
        CHECK_INT(failed, for_good ? 1 : 0);
        CHECK_INT((long long)buffer.bytes, 4 + (int)sizeof more);
        buffer.bytes = 4;
        test_alloc_fail(1, 1);
        CHECK_INT(api_buffer_format(&buffer, "%*d", 200000, 7), PEND_NO_MEMORY);
        test_alloc_faults_off();
        CHECK(holds(&buffer, "kept"));
    }
}

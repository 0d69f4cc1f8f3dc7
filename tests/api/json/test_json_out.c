#include "api/json/json_out.h"

#include <math.h>
#include <string.h>

#include "tests/harness/test.h"

/* the contents of the buffer, as a string */
static const char *written(struct api_buffer *out) {
    if (api_buffer_room(out, 1) != PEND_OK) return "";
    out->data[out->bytes] = 0;
    return out->data;
}

TEST(commas_go_where_they_are_due) {
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1000);
    CHECK(!api_buffer_text(&out, "{"));
    CHECK(!api_out_whole(&out, "a", -3));
    CHECK(!api_out_open(&out, "b", '['));
    CHECK(!api_out_numbers(&out, NULL, 2, (double[]){1, 0.5}, 0));
    CHECK(!api_out_numbers(&out, NULL, 0, NULL, 0));
    CHECK(!api_buffer_text(&out, "]"));
    CHECK(!api_out_text(&out, "c\"", "ends with a comma,"));
    CHECK(!api_out_text(&out, "d", NULL));
    CHECK(!api_out_number(&out, "e", 1. / 3, 3));
    CHECK(!api_out_matrix(&out, "f", 2, (double[]){1, 2, 3, 4}, 0));
    CHECK(!api_buffer_text(&out, "}"));
    CHECK_TEXT(
        written(&out),
        "{\"a\":-3,\"b\":[[1,0.5],[]],\"c\\\"\":\"ends with a comma,\",\"d\":null,\"e\":0.333,"
        "\"f\":[[1,2],[3,4]]}");
}

TEST(a_number_that_is_not_finite_is_not_written) {
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1000);
    CHECK_INT(api_out_number(&out, "a", NAN, 0), PEND_NOT_FINITE);
    CHECK_INT(api_out_number(&out, "a", -INFINITY, 0), PEND_NOT_FINITE);
    CHECK_INT(api_out_numbers(&out, "a", 2, (double[]){1, INFINITY}, 0), PEND_NOT_FINITE);
    CHECK_INT((long long)out.bytes, 0);
}

TEST(no_number_is_longer_than_is_said) {
    unsigned long long seed = 3;
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1000);
    CHECK(!api_buffer_room(&out, 100));
    for (int i = 0; i < 200000; i++) {
        unsigned long long bits =
            (unsigned long long)(test_random(&seed) * 0x1p53) << 11 ^ (unsigned long long)i;
        double x = i % 2 ? ldexp(test_random(&seed) - 0.5, test_random_int(&seed, 120) - 60) : 0;
        if (i % 2 == 0) memcpy(&x, &bits, sizeof x);
        if (!isfinite(x)) continue;
        int digits = test_random_int(&seed, 18);
        long bytes = api_out_digits(out.data, x, digits) - out.data;
        if (!CHECK_SAYING(bytes < api_out_number_bytes(digits),
                          "%.17g takes %ld bytes at %d digits", x, bytes, digits))
            break;
    }
}

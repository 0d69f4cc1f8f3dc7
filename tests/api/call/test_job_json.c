/* Tests of api/call/job_json: instants as they are written and read. */
#include "api/call/job_json.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(an_instant_that_is_written_is_read_as_it_was) {
    uint64_t random = 1;
    for (int i = 0; i < 20000; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        /* to the year 9999, in the milliseconds that are written */
        int64_t us = (int64_t)(random >> 11) % INT64_C(253402300800000) * 1000 + 1000, back = 0;
        OWN(api_buffer, clear) out;
        char text[64] = "";
        api_buffer_init(&out, 4096);
        CHECK(api_job_time(&out, "t", us) == PEND_OK && out.bytes > 6);
        snprintf(text, sizeof text, "%.*s", (int)out.bytes - 6, (const char *)out.data + 5);
        CHECK_SAYING(api_job_instant(text, &back) && back == us, "%s: %lld for %lld", text,
                     (long long)back, (long long)us);
    }
}

TEST(instants_with_an_offset_or_a_fraction_are_read_and_what_is_none_is_not) {
    static const struct {
        const char *text;
        int64_t us; /* 0 = none */
    } known[] = {{"1970-01-01T00:00:01Z", 1000000},
                 {"2000-02-29T12:00:00Z", INT64_C(951825600000000)},
                 {"2000-02-29T13:30:00.25+01:30", INT64_C(951825600250000)},
                 {"2000-02-29T11:00:00.000001-01:00", INT64_C(951825600000001)},
                 {"1970-01-01T00:00:00Z", 0},
                 {"1969-12-31T00:00:00Z", 0},
                 {"9999-12-31T23:59:59.999999Z", INT64_C(253402300799999999)},
                 {"9999-12-31T23:59:59-00:01", 0},
                 {"2001-02-29T12:00:00Z", 0},
                 {"2000-13-01T12:00:00Z", 0},
                 {"2000-00-01T12:00:00Z", 0},
                 {"2000-01-00T12:00:00Z", 0},
                 {"2000-01-01T24:00:00Z", 0},
                 {"2000-01-01T12:60:00Z", 0},
                 {"2000-01-01T12:00:61Z", 0},
                 {"2000-01-01T12:00:00", 0},
                 {"2000-01-01T12:00:00.Z", 0},
                 {"2000-01-01T12:00:00.1234567Z", 0},
                 {"2000-01-01T12:00:00+1:00", 0},
                 {"2000-01-01T12:00:00+24:00", 0},
                 {"2000-01-01 12:00:00Z", 0},
                 {"2000-01-01", 0},
                 {"", 0}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        int64_t us = 0;
        int good = api_job_instant(known[i].text, &us);
        CHECK_SAYING(good == (known[i].us > 0) && (!good || us == known[i].us), "%s: %lld",
                     known[i].text, (long long)us);
    }
}

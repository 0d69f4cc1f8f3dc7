#include "server/base/clock.h"

#include <string.h>
#include <time.h>

#include "tests/harness/test.h"

TEST(the_clock_never_goes_back) {
    int64_t last = srv_clock_now(), first = last;
    for (int i = 0; i < 100000; i++) {
        int64_t now = srv_clock_now();
        if (now < last) {
            CHECK(now >= last);
            return;
        }
        last = now;
    }
    CHECK(last > first);
}

TEST(seconds_and_nanoseconds_are_the_same_clock) {
    double before = 1e-9 * (double)srv_clock_now(), seconds = srv_clock_seconds(NULL),
           after = 1e-9 * (double)srv_clock_now();
    CHECK(before <= seconds && seconds <= after);
    CHECK_INT(srv_clock_span(1.5), 1500000000);
    CHECK_INT(srv_clock_span(0), 0);
}

TEST(a_test_sets_the_clock_ahead_and_waits_end_when_they_would) {
    int64_t before = srv_clock_now();
    srv_clock_advance(srv_clock_span(3600));
    int64_t now = srv_clock_now(), system = now - srv_clock_span(1);
    CHECK(now - before >= srv_clock_span(3600));
    struct timespec real, instant = srv_clock_timespec(system);
    clock_gettime(CLOCK_MONOTONIC, &real);
    CHECK(instant.tv_sec <= real.tv_sec && instant.tv_sec >= real.tv_sec - 600);
    CHECK_INT(srv_clock_timespec(0).tv_sec, 0);
}

TEST(a_stamp_is_the_time_as_rfc_3339_writes_it) {
    struct srv_stamp stamp = {0};
    struct tm part = {0};
    time_t before = time(NULL);
    srv_clock_stamp(&stamp);
    time_t after = time(NULL);
    const char *rest = strptime(stamp.text, "%Y-%m-%dT%H:%M:%S", &part);
    REQUIRE(rest != NULL);
    CHECK(timegm(&part) >= before && timegm(&part) <= after);
    CHECK_INT((long long)strlen(rest), 5);
    CHECK(rest[0] == '.' && rest[4] == 'Z' && strspn(rest + 1, "0123456789") == 3);
    /* stamps of one second differ only in their milliseconds, and never decrease */
    char last[sizeof stamp.text];
    for (int i = 0; i < 2000; i++) {
        strcpy(last, stamp.text);
        srv_clock_stamp(&stamp);
        if (strcmp(last, stamp.text) > 0) {
            CHECK_TEXT(last, stamp.text);
            return;
        }
    }
}

#include "server/clock.h"

#include <stdio.h>
#include <time.h>

int64_t srv_clock_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

double srv_clock_seconds(void *context) {
    (void)context;
    return 1e-9 * (double)srv_clock_now();
}

int64_t srv_clock_span(double seconds) { return (int64_t)(seconds * 1e9); }

void srv_clock_stamp(char text[SRV_STAMP_BYTES]) {
    struct timespec now;
    struct tm part;
    clock_gettime(CLOCK_REALTIME, &now);
    gmtime_r(&now.tv_sec, &part);
    size_t length = strftime(text, SRV_STAMP_BYTES, "%Y-%m-%dT%H:%M:%S", &part);
    snprintf(text + length, SRV_STAMP_BYTES - length, ".%03dZ", (int)(now.tv_nsec / 1000000) % 1000);
}

#include "server/base/clock.h"

#include <assert.h>
#include <stdatomic.h>

enum { SECOND = 1000000000 };

/* ns that tests have set the clock ahead */
static _Atomic int64_t clock_ahead;

int64_t srv_clock_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * SECOND + now.tv_nsec +
           atomic_load_explicit(&clock_ahead, memory_order_relaxed);
}

void srv_clock_advance(int64_t ns) {
    assert(ns > 0);
    atomic_fetch_add(&clock_ahead, ns);
}

double srv_clock_seconds(void *context) {
    (void)context;
    return 1e-9 * (double)srv_clock_now();
}

int64_t srv_clock_span(double seconds) {
    assert(seconds >= 0 && seconds < 9e9); /* 9e9 s in ns fit into 64 bits */
    return (int64_t)(seconds * 1e9);
}

struct timespec srv_clock_timespec(int64_t ns) {
    assert(ns >= 0);
    ns -= atomic_load_explicit(&clock_ahead, memory_order_relaxed);
    return ns < 0 ? (struct timespec){0} : (struct timespec){ns / SECOND, ns % SECOND};
}

void srv_clock_stamp(struct srv_stamp *stamp) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (now.tv_sec != stamp->second) {
        struct tm part;
        gmtime_r(&now.tv_sec, &part);
        strftime(stamp->text, sizeof stamp->text, "%Y-%m-%dT%H:%M:%S.000Z", &part);
        stamp->second = now.tv_sec;
    }
    int ms = (int)(now.tv_nsec / 1000000);
    assert(ms >= 0 && ms < 1000 && stamp->text[19] == '.');
    stamp->text[20] = (char)('0' + ms / 100);
    stamp->text[21] = (char)('0' + ms / 10 % 10);
    stamp->text[22] = (char)('0' + ms % 10);
}

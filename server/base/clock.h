/* Time: a monotonic clock for durations and deadlines, and the wall clock for people.
 * Leaves to others: sleeping, and the consequences of a deadline.
 * Invariant: every duration and deadline of the server is in nanoseconds of srv_clock_now. */
#pragma once

#include <stdint.h>
#include <time.h>

/* A wall clock reading as text, cached because most of the text stays the same for a second. */
struct srv_stamp {
    int64_t second; /* the second that the text shows; 0 = none yet */
    char text[25];  /* 2026-01-31T09:30:00.125Z */
};

/** Returns the nanoseconds since some fixed instant; the value never decreases. Any thread. */
int64_t srv_clock_now(void);

/** Advances the clock by `ns` > 0, so that tests need not wait. Threads that already wait do not
 * wake earlier. Any thread. */
void srv_clock_advance(int64_t ns);

/** Returns srv_clock_now in seconds, in the form of api_call_clock; context is ignored. */
double srv_clock_seconds(void *context);

/** Converts seconds, 0 .. 9e9, to nanoseconds. */
int64_t srv_clock_span(double seconds);

/** Converts an instant of srv_clock_now, at least 0, to CLOCK_MONOTONIC, for system calls. */
struct timespec srv_clock_timespec(int64_t ns);

/** Writes the wall clock's time to stamp->text, in UTC as RFC 3339. Initialize a stamp as {0}. */
void srv_clock_stamp(struct srv_stamp *stamp);

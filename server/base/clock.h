/* Time: a clock that never goes back for durations and deadlines, and the wall clock for people.
 * Leaves to others: sleeping, and what is done when a time is over.
 * Invariant: every duration and deadline of the server is in nanoseconds of srv_clock_now. */
#ifndef SRV_CLOCK_H
#define SRV_CLOCK_H

#include <stdint.h>
#include <time.h>

/* A wall clock reading as text, kept from one to the next: most of it stays the same for a
 * second. */
struct srv_stamp {
    int64_t second; /* of the text; 0 at first */
    char text[25];  /* 2026-01-31T09:30:00.125Z */
};

/** Nanoseconds since some fixed instant; never goes back. Any thread. */
int64_t srv_clock_now(void);

/** srv_clock_now in seconds, in the form that api_call_clock wants; context is not read. */
double srv_clock_seconds(void *context);

/** Nanoseconds in so many seconds; seconds: 0 .. 9e9. */
int64_t srv_clock_span(double seconds);

/** An instant of srv_clock_now, at least 0, in the form that the system's calls want. */
struct timespec srv_clock_timespec(int64_t ns);

/** Puts the wall clock's time into stamp->text, in UTC as RFC 3339 writes it; a stamp begins as
 * {0}. */
void srv_clock_stamp(struct srv_stamp *stamp);

#endif

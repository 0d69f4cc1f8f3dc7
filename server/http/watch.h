/* The eye on every open connection: clients that go away, that drip, or that do not take their
 * answer.
 * Leaves to others: reading and writing (http); an inactive connection in general
 * (libmicrohttpd's own timeout).
 * Invariant: a socket is touched only while it is watched, and its owner cannot close it in that
 * moment. */
#ifndef SRV_WATCH_H
#define SRV_WATCH_H

#include <stdatomic.h>
#include <stdint.h>

#include "core/base/status.h"
#include "server/base/list.h"

enum {
    SRV_WATCH_TICK_MS = 25,    /* how often waiting clients are looked at */
    SRV_WATCH_MOMENT_MS = 250, /* how long a drain waits for what a client may be about to do */
    SRV_WATCH_LINGER_MS =
        2000, /* how long a connection that was refused in mid-request is read on, at most */
    SRV_WATCH_LINGERING = 1024 /* how many of them there are at most */
};

/* What a connection is doing. */
enum srv_watch_phase {
    SRV_WATCH_IDLE,    /* no request is under way: ends at the deadline */
    SRV_WATCH_READING, /* a request comes in: must be there at the deadline, else 408 and the end */
    SRV_WATCH_WAITING, /* a request is being computed: nobody else sees when the client goes away */
    SRV_WATCH_SENDING, /* an answer goes out: must be taken at the deadline, else the end */
    SRV_WATCH_STREAMING, /* the same, of an answer that is computed meanwhile */
    SRV_WATCH_LISTENING  /* a client waits for news, for long: looked at now and then */
};

/* One connection, inside its owner's structure; the fields are the watch's, but fd, left and
 * relayed, and late to read.
 */
struct srv_watched {
    int fd;
    /** The client of a waiting connection is gone. Called once a request, on the watch's thread,
     * with its lock held. */
    void (*left)(struct srv_watched *watched);
    struct srv_list link;
    enum srv_watch_phase phase;
    int64_t deadline;   /* ns of srv_clock_now, 0 = none */
    int64_t since;      /* ns: when it became idle */
    atomic_int late;    /* 408 was said */
    atomic_int relayed; /* a proxy's; set by the owner */
    int served;         /* a request of it is over */
    int seen;           /* how often in a row the end of the client's stream was seen */
};

struct srv_watch;

/**
 * Starts a watch and its thread.
 *
 * PEND_NO_MEMORY  also when no thread can be had.
 */
PEND_MUST_CHECK enum pend_status srv_watch_new(struct srv_watch **watch);

/** How many sockets may linger at one time, SRV_WATCH_LINGERING at most; before the first does. */
void srv_watch_lingering(struct srv_watch *watch, int most);

/** Ends the thread, and closes what lingers; nothing may be watched any more. */
void srv_watch_free(struct srv_watch **watch);

/** Begins to watch a new connection, which is idle; fd and left are set. */
void srv_watch_add(struct srv_watch *watch, struct srv_watched *watched, int64_t deadline);

/** Ends it; afterwards neither the socket nor the structure is touched. */
void srv_watch_remove(struct srv_watch *watch, struct srv_watched *watched);

/** Says what the connection does from now on, and until when. */
void srv_watch_phase(struct srv_watch *watch, struct srv_watched *watched,
                     enum srv_watch_phase phase, int64_t deadline);

/** Calls left for every waiting, streaming or listening connection: the server is stopping. */
void srv_watch_leave_all(struct srv_watch *watch);

/**
 * Connections that a drain should wait for: whose request or answer is not complete, that have
 * unread bytes, that linger since a moment only, or whose client may be sending a request at this
 * very instant.
 *
 * began     ns of srv_clock_now: when the drain began.
 * patience  ns: an idle connection is waited for so long after it was opened and, where it is a
 *           proxy's and a request was answered on it already, so long after the drain began. Never
 *           shorter than SRV_WATCH_MOMENT_MS after it became idle and, where a request was answered
 *           on it, after the drain began.
 */
int srv_watch_busy(struct srv_watch *watch, int64_t began, int64_t patience);

/**
 * Keeps a connection from being reset under an answer that says no while the client is still
 * sending: its socket is shut for writing and read on, unheeded, until the client ends, a limit is
 * reached, or the watch is freed.
 *
 * fd  a duplicate, taken; the owner may close its own at once.
 */
void srv_watch_linger(struct srv_watch *watch, int fd);

#endif

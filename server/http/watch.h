/* Watches every open connection for clients that leave, that send too slowly, or that do not take
 * their answer.
 * Leaves to others: reading and writing (http); an inactive connection in general
 * (libmicrohttpd's own timeout).
 * Invariant: a socket is used only while it is watched, and its owner cannot close it meanwhile. */
#ifndef SRV_WATCH_H
#define SRV_WATCH_H

#include <stdatomic.h>
#include <stdint.h>

#include "core/base/status.h"
#include "server/base/list.h"
#include "server/keys/key_ring.h"

enum {
    SRV_WATCH_TICK_MS = 25,    /* how often waiting clients are looked at */
    SRV_WATCH_MOMENT_MS = 250, /* how long a drain waits for a request that may be arriving */
    SRV_WATCH_LINGER_MS =
        2000, /* how long a connection that was refused in mid-request is read on, at most */
    SRV_WATCH_LINGERING = 1024 /* how many of them there are at most */
};

/* What a connection is doing. */
enum srv_watch_phase {
    SRV_WATCH_IDLE,    /* no request is under way: ends at the deadline */
    SRV_WATCH_READING, /* a request arrives: at the deadline 408 is sent and the connection ends */
    SRV_WATCH_WAITING, /* a request is computed: libmicrohttpd does not see the client leave */
    SRV_WATCH_SENDING, /* an answer is sent: at the deadline the connection ends */
    SRV_WATCH_STREAMING, /* the same, of an answer that is computed meanwhile */
    SRV_WATCH_LISTENING  /* a stream of events is open: the client is looked at rarely */
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
    int64_t deadline;     /* ns of srv_clock_now, 0 = none */
    int64_t since;        /* ns: when it became idle */
    atomic_int late;      /* its request came too late */
    atomic_int relayed;   /* a proxy's; set by the owner */
    atomic_int *siblings; /* how many connections its address has; NULL = it is never crowded out;
                             set by the owner */
    int served;           /* a request of it is over */
    int seen;             /* ticks in a row at which the end of the client's stream was seen */
    struct srv_key_ring *keys;     /* that the key of its request is one of, or NULL */
    char issued[API_DIGEST_BYTES]; /* its digest */
};

struct srv_watch;

/**
 * Starts a watch and its thread.
 *
 * PEND_NO_MEMORY  also when no thread can be had.
 */
PEND_MUST_CHECK enum pend_status srv_watch_new(struct srv_watch **watch);

/** True when the counts agree with each other and with the list; for assertions, under its lock.
 * O(1). */
int srv_watch_valid(const struct srv_watch *watch);

/** How many sockets may linger at one time, SRV_WATCH_LINGERING at most; before the first does. */
void srv_watch_lingering(struct srv_watch *watch, int most);

/** Ends the thread and closes the sockets that linger; no connection may be watched. */
void srv_watch_free(struct srv_watch **watch);

/** Begins to watch a new connection, which is idle; fd and left are set. */
void srv_watch_add(struct srv_watch *watch, struct srv_watched *watched, int64_t deadline);

/** Stops watching; afterwards neither the socket nor the structure is used. */
void srv_watch_remove(struct srv_watch *watch, struct srv_watched *watched);

/** Sets the phase of a connection and its deadline. */
void srv_watch_phase(struct srv_watch *watch, struct srv_watched *watched,
                     enum srv_watch_phase phase, int64_t deadline);

/**
 * Ends a connection that has not sent a byte, to make room for a new one: the oldest of those of
 * the address that has the most connections. Returns 0 where there is none. O(connections).
 */
int srv_watch_crowd_out(struct srv_watch *watch);

/** Notes the key of a request: once it is not good any more, the connection ends within half a
 * second, whatever it waits for or is sent, unless the request is over. NULL, "" = none. */
void srv_watch_key(struct srv_watch *watch, struct srv_watched *watched, struct srv_key_ring *keys,
                   const char issued[API_DIGEST_BYTES]);

/** Calls `left` for every waiting, streaming or listening connection, as the server is stopping. */
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
 * Keeps a connection from being reset under a refusal while the client is still sending: the socket
 * is shut for writing, and its bytes are read and dropped, until the client closes it, a limit is
 * reached, or the watch is freed.
 *
 * fd  a duplicate, taken; the owner may close its own at once.
 */
void srv_watch_linger(struct srv_watch *watch, int fd);

#endif

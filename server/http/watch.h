/* Watches every open connection for clients that disconnect, send too slowly, or do not read their
 * answer.
 * Leaves to others: reading and writing (http); an inactive connection in general
 * (libmicrohttpd's own timeout).
 * Invariant: a socket is used only while it is watched, and its owner cannot close it meanwhile. */
#pragma once

#include <stdatomic.h>
#include <stdint.h>

#include "core/base/status.h"
#include "server/base/list.h"
#include "server/keys/key_ring.h"

enum {
    SRV_WATCH_TICK_MS = 25,    /* period at which waiting clients are checked */
    SRV_WATCH_MOMENT_MS = 250, /* time for which a drain waits for a request that may be arriving */
    SRV_WATCH_LINGER_MS =
        2000, /* ms for which the bytes of a refused request are read and discarded */
    SRV_WATCH_LINGERING = 1024 /* maximum number of connections that linger in this way */
};

/* The phases of a connection. */
enum srv_watch_phase {
    SRV_WATCH_IDLE,      /* no request is under way: closed at the deadline */
    SRV_WATCH_READING,   /* a request arrives: at the deadline 408 is sent and the connection
                          * closed */
    SRV_WATCH_WAITING,   /* a request is computed: libmicrohttpd does not notice a disconnect */
    SRV_WATCH_SENDING,   /* an answer is being sent: at the deadline the connection is closed */
    SRV_WATCH_STREAMING, /* an answer is being sent while the rest of it is still computed */
    SRV_WATCH_LISTENING  /* a stream of events is open: the client is checked rarely */
};

/* One connection, inside its owner's structure. The watch owns the fields, except fd, left and
 * relayed; others may read `late`. */
struct srv_watched {
    int fd;
    /** The client of a waiting connection has disconnected. Called once per request, on the watch's
     * thread, with its lock held. */
    void (*left)(struct srv_watched *watched);
    struct srv_list link;
    enum srv_watch_phase phase;
    int64_t deadline;     /* ns of srv_clock_now, 0 = none */
    int64_t since;        /* ns: when the client became idle */
    atomic_int late;      /* the client's request missed the deadline */
    atomic_int relayed;   /* the connection is a proxy's; set by the owner */
    atomic_int *siblings; /* number of connections of its address; NULL = never closed for others;
                           * set by the owner */
    int served;           /* a request on it has ended */
    int seen;             /* consecutive ticks at which the end of the client's stream was seen */
    struct srv_key_ring *keys;     /* the key ring of its request's key, or NULL */
    char issued[API_DIGEST_BYTES]; /* the digest of that key */
};

struct srv_watch;

/**
 * Starts a watch and its thread.
 *
 * PEND_NO_MEMORY  also if the thread cannot be started.
 */
PEND_MUST_CHECK enum pend_status srv_watch_new(struct srv_watch **watch);

/** Sets the number of sockets that may linger at one time, SRV_WATCH_LINGERING at most; before the
 * first does. */
void srv_watch_lingering(struct srv_watch *watch, int most);

/** Ends the thread and closes lingering sockets; no connection may be watched. */
void srv_watch_free(struct srv_watch **watch);

/** Starts to watch a new connection, which is idle; fd and left must be set. */
void srv_watch_add(struct srv_watch *watch, struct srv_watched *watched, int64_t deadline);

/** Stops watching; afterwards neither the socket nor the structure is used. */
void srv_watch_remove(struct srv_watch *watch, struct srv_watched *watched);

/** Sets the phase of a connection and its deadline. */
void srv_watch_phase(struct srv_watch *watch, struct srv_watched *watched,
                     enum srv_watch_phase phase, int64_t deadline);

/** Closes a connection that has not sent a byte, to make room for a new one: the oldest one of the
 * address with the most connections. Returns 0 if there is none. O(connections). */
int srv_watch_crowd_out(struct srv_watch *watch);

/** Sets the key of a request. Once it is invalid, the connection is closed within half a second,
 * whatever its phase, unless the request has ended. NULL, "" = none. */
void srv_watch_key(struct srv_watch *watch, struct srv_watched *watched, struct srv_key_ring *keys,
                   const char issued[API_DIGEST_BYTES]);

/** Calls `left` for every waiting, streaming or listening connection, because the server is
 * stopping. */
void srv_watch_leave_all(struct srv_watch *watch);

/**
 * Returns the number of connections that a drain should wait for: with an incomplete request or
 * answer, with unread bytes, lingering for a short time only, or whose client may be sending a
 * request at this instant.
 *
 * began     ns of srv_clock_now: when the drain began.
 * patience  ns, at least SRV_WATCH_MOMENT_MS: how long to wait for a new connection after it was
 *           opened, and for a proxy's connection after the drain began. Other idle connections:
 *           SRV_WATCH_MOMENT_MS after their last request and after the start of the drain.
 */
int srv_watch_busy(struct srv_watch *watch, int64_t began, int64_t patience);

/**
 * Prevents a reset of a connection that was refused while the client is still sending: shuts the
 * socket for writing, and reads and discards its bytes until the client closes it, a limit is
 * reached, or the watch is freed.
 *
 * fd  a duplicate, closed by the watch; the owner may close its own at once.
 */
void srv_watch_linger(struct srv_watch *watch, int fd);

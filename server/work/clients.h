/* A record for each client: its lane in the queue, its quota, and that of its address.
 * Leaves to others: the identity of a client (identity), the order of the lanes' tasks (queue),
 * asking a client to wait (admission).
 * Invariant: a record exists while it is referenced; of records without references, the
 * SRV_CLIENTS_KEPT most recently used are kept. */
#pragma once

#include <stdatomic.h>
#include <stdint.h>

#include "server/base/hash_table.h"
#include "server/store/storage.h"
#include "server/work/queue.h"

enum { SRV_CLIENT_KEY = 68, SRV_CLIENTS_KEPT = 8192 };

/* A token bucket: the requests that may be sent now, and the time of that count. */
struct srv_bucket {
    double tokens;
    int64_t counted; /* ns; 0 = never */
};

/* Actions in classrooms, each with its own rate limit. */
enum srv_pace {
    SRV_PACE_ROOMS,  /* creating rooms */
    SRV_PACE_JOINS,  /* joining rooms */
    SRV_PACE_MISSES, /* requests with unknown room codes */
    SRV_PACE_TRIES,  /* all requests with room codes, after too many unknown ones */
    SRV_PACE_WRITES, /* writing items */
    SRV_PACES
};

struct srv_client {
    struct srv_lane lane;   /* the queue's */
    struct srv_asker asker; /* the storage's */
    /* for the table only: the following members */
    struct srv_list idle;      /* in the list of records without references */
    struct srv_hash_node node; /* by `key` */
    int users;
    struct srv_client *source;  /* the record of its address or account, which may be itself; while
                                 * used */
    struct srv_bucket own, all; /* the client's requests, and those of all clients with the same
                                 * source */
    struct srv_bucket seconds;  /* s of computation available; negative: seconds of debt */
    atomic_llong share;         /* bytes that its role may hold; 0 = the server's own limit */
    atomic_int priority;        /* number of queue levels by which its computations are delayed */
    struct srv_bucket pace[SRV_PACES];
    atomic_llong held, bodies; /* bytes that it holds in memory; those of bodies among them
                                * (hold) */
    atomic_int connections;    /* number of its open connections */
    char key[SRV_CLIENT_KEY];
};

struct srv_clients;

/** PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status srv_clients_new(struct srv_clients **clients);

/** Frees the table and its records; none may be referenced. */
void srv_clients_free(struct srv_clients **clients);

/**
 * Adds a reference to the record of a client, which is created if necessary; released by
 * srv_clients_give.
 *
 * key     its identity, shorter than SRV_CLIENT_KEY: longer ones are truncated.
 * source  the key of its address or account; NULL or the same key if that is its identity.
 *
 * Returns NULL if memory is short. Any thread.
 */
struct srv_client *srv_clients_take(struct srv_clients *clients, const char *key,
                                    const char *source);

/** Adds a reference to a record that already has one. Any thread. */
void srv_clients_share(struct srv_clients *clients, struct srv_client *client);

/** Ends a reference. Any thread. */
void srv_clients_give(struct srv_clients *clients, struct srv_client *client);

/* The remaining quota of a client. */
struct srv_quota {
    int granted;
    double limit;   /* requests per minute */
    double left;    /* requests */
    double refresh; /* s until the quota is full again */
    double retry;   /* s until a request is available, if none was granted */
};

/**
 * Subtracts one request from a client's quota per minute, all of which may come at once, and from
 * that of its source, which all of its clients share.
 *
 * shares  the source's quota as a multiple of a client's.
 */
struct srv_quota srv_clients_quota(struct srv_clients *clients, struct srv_client *client,
                                   double a_minute, double shares, int64_t now);

/**
 * Returns the number of seconds until a client may compute again; <= 0 if it may now.
 *
 * a_minute  seconds of computation per minute, >= 0, all of which may be used at once. A
 *           computation that starts while some are left may take more, which delays the next one.
 */
double srv_clients_debt(struct srv_clients *clients, struct srv_client *client, double a_minute,
                        int64_t now);

/** Subtracts seconds of computation from a client's; no effect on a client for which
 * srv_clients_debt was never called. Any thread. */
void srv_clients_charge(struct srv_clients *clients, struct srv_client *client, double seconds);

/**
 * Subtracts one action from a rate limit: `burst` at once, and then a rate per second.
 *
 * taken  0 = only checks whether one is available.
 *
 * Returns 0 if one was available, else the seconds until one is.
 */
double srv_clients_pace(struct srv_clients *clients, struct srv_client *client, enum srv_pace pace,
                        double a_second, double burst, int taken, int64_t now);

/* A record for each client: its lane in the queue, and its quota beside that of the address it
 * comes from.
 * Leaves to others: who a client is (identity), the order of the lanes' tasks (queue), telling a
 * client that it has to wait (admission).
 * Invariant: a record exists while it is referenced; of records without references the
 * SRV_CLIENTS_KEPT that were used last are kept. */
#ifndef SRV_CLIENTS_H
#define SRV_CLIENTS_H

#include <stdatomic.h>
#include <stdint.h>

#include "server/base/hash_table.h"
#include "server/store/storage.h"
#include "server/work/queue.h"

enum { SRV_CLIENT_KEY = 68, SRV_CLIENTS_KEPT = 8192 };

/* Requests that may be sent now, and since when they were counted. */
struct srv_bucket {
    double tokens;
    int64_t counted; /* ns; 0 = never */
};

/* What has a pace of its own in rooms of classes. */
enum srv_pace {
    SRV_PACE_ROOMS,  /* rooms that are made */
    SRV_PACE_JOINS,  /* pupils who join */
    SRV_PACE_MISSES, /* codes of rooms that there are not, */
    SRV_PACE_TRIES,  /* after which they are looked for, and then not even that */
    SRV_PACE_WRITES, /* items that are written */
    SRV_PACES
};

struct srv_client {
    struct srv_lane lane;   /* the queue's */
    struct srv_asker asker; /* the storage's */
    /* the rest is the table's */
    struct srv_list idle;      /* in the list of records without references */
    struct srv_hash_node node; /* by `key` */
    int users;
    struct srv_client *source;  /* the record of the address or account it comes from, which may be
                                   itself; while used */
    struct srv_bucket own, all; /* what it may send, and what all may together whose source it is */
    struct srv_bucket seconds;  /* s that it may compute; below 0 what it has computed beyond */
    atomic_llong share;         /* bytes that its role lets it hold; 0 = as the options say */
    atomic_int priority;        /* levels of the queue that its computations stand behind others */
    struct srv_bucket pace[SRV_PACES];
    atomic_llong held, bodies; /* bytes that it holds in memory; of them those of bodies (hold) */
    atomic_int connections;    /* that it has open */
    char key[SRV_CLIENT_KEY];
};

struct srv_clients;

/** PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status srv_clients_new(struct srv_clients **clients);

/** Frees the table and its records; none may be referenced. */
void srv_clients_free(struct srv_clients **clients);

/**
 * Adds a reference to the record of a client, which is made if there is none. Ends with
 * srv_clients_give.
 *
 * key     who it is, shorter than SRV_CLIENT_KEY: longer ones are cut.
 * source  the key of the address or account it comes from; NULL or the same where that is who it
 *         is.
 *
 * Returns NULL without memory. Any thread.
 */
struct srv_client *srv_clients_take(struct srv_clients *clients, const char *key,
                                    const char *source);

/** Adds a reference to a record that is referenced already. Any thread. */
void srv_clients_share(struct srv_clients *clients, struct srv_client *client);

/** Ends a reference. Any thread. */
void srv_clients_give(struct srv_clients *clients, struct srv_client *client);

/* What a client may still do. */
struct srv_quota {
    int granted;
    double limit;   /* requests a minute */
    double left;    /* requests */
    double refresh; /* s until all are there again */
    double retry;   /* s until one is there, if none was granted */
};

/**
 * Takes one request off a client's quota of so many a minute, which may all come at once, and off
 * that of its source, which all of its clients share.
 *
 * shares  how many times a client's quota the source has.
 */
struct srv_quota srv_clients_quota(struct srv_clients *clients, struct srv_client *client,
                                   double a_minute, double shares, int64_t now);

/**
 * For how many seconds a client has computed too much to compute again; <= 0 where it may.
 *
 * a_minute  seconds of computation that it has a minute, >= 0, all of which may come at once. What
 *           begins while some are left may take more: then that is waited for.
 */
double srv_clients_debt(struct srv_clients *clients, struct srv_client *client, double a_minute,
                        int64_t now);

/** Takes seconds that a client has computed off those that it has; nothing off one that
 * srv_clients_debt was never asked about. Any thread. */
void srv_clients_charge(struct srv_clients *clients, struct srv_client *client, double seconds);

/**
 * Takes one of what comes at a pace: `burst` of it at once, and so many a second.
 *
 * taken  0 = only looks whether one is there.
 *
 * Returns 0 when one was there, else after how many seconds one will be.
 */
double srv_clients_pace(struct srv_clients *clients, struct srv_client *client, enum srv_pace pace,
                        double a_second, double burst, int taken, int64_t now);

#endif

/* State shared by the parts of a running server.
 * Leaves to others: creating and freeing it (service_setup).
 * Invariant: a service outlives every exchange; fields that change while it runs are atomic or have
 * a lock of their own. */
#pragma once

#include <stdatomic.h>
#include <stdint.h>

#include "server/protocol/cache.h"
#include "server/work/clients.h"
#include "server/config/config.h"
#include "server/work/fairness.h"
#include "server/protocol/lengths.h"
#include "server/base/log.h"
#include "server/keys/key_ring.h"
#include "server/base/memory.h"
#include "server/base/metrics.h"
#include "server/protocol/peer.h"
#include "server/work/queue.h"
#include "server/base/buffer_pool.h"
#include "server/store/storage.h"

struct srv_events;
struct srv_inflight;
struct srv_part_runner;

/* The stages of the end of this process. */
enum srv_drain {
    SRV_DRAIN_NOT,  /* normal operation */
    SRV_DRAIN_LAST, /* no new connections; open ones are closed after their next answer */
    SRV_DRAIN_HURRY /* computations are cancelled, and none is started */
};

/* Options set by a reload, and values derived from them. */
struct srv_reloaded {
    struct srv_config config;
    struct srv_peers trusted;
    const char *hosts; /* host names that the server accepts */
    struct api_limits job_limits;
    struct srv_reloaded
        *before; /* kept to the end of the service, because other threads may be reading it */
};

struct srv_service {
    struct srv_config config; /* the options at the start; for those that a reload may change see
                               * srv_service_config */
    _Atomic(struct srv_reloaded *) reloaded; /* NULL = not reloaded yet */
    struct srv_peers trusted;                /* proxies that may name the client */
    const char *hosts;                       /* host names that the server accepts */
    struct srv_log *log;
    struct srv_key_ring *keys; /* keys of the operator; NULL = none, and no roles */
    struct srv_queue *queue;
    struct srv_fairness fairness; /* sharing of processors between sockets and workers */
    struct srv_clients *clients;
    struct srv_cache *cache;
    struct srv_inflight *inflight;  /* computations that other exchanges may join */
    struct srv_storage *storage;    /* the store of jobs; NULL = none */
    struct srv_part_runner *runner; /* computes jobs; NULL without a store */
    struct srv_files *files;        /* where large results are stored; NULL = in the database */
    struct srv_events *events;      /* listeners of events; NULL without a store */
    struct api_limits job_limits;
    struct srv_buffer_pool pool;
    struct srv_lengths lengths; /* lengths of results that were written once */
    struct srv_metrics metrics;
    uint64_t seed;            /* of request ids */
    atomic_ullong number;     /* requests so far */
    atomic_int draining;      /* enum srv_drain */
    atomic_int computing;     /* number of unfinished computations */
    atomic_int busy;          /* number of workers that are computing */
    atomic_int connections;   /* number of open connections */
    atomic_int listening;     /* number of open event streams */
    struct srv_memory memory; /* memory held */
    double started;           /* s since 1970 */
    int workers;
};

/** Returns the current options. The memory stays valid to the end of the service. Any thread. */
const struct srv_config *srv_service_config(const struct srv_service *service);

/** Returns the current trusted proxies. Valid and thread-safe as srv_service_config. */
const struct srv_peers *srv_service_trusted(const struct srv_service *service);

/** Returns the hosts that the server accepts. Valid and thread-safe as srv_service_config. */
const char *srv_service_hosts(const struct srv_service *service);

/** Returns the limits of a job's request. Valid and thread-safe as srv_service_config. */
const struct api_limits *srv_service_job_limits(const struct srv_service *service);

/** Returns why this process takes no jobs now, as a sentence without a full stop; NULL if it takes
 * them. */
const char *srv_service_jobless(const struct srv_service *service);

/** Returns the current values of the gauges of /metrics. */
struct srv_gauges srv_service_gauges(struct srv_service *service);

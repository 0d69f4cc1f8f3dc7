/* State that the parts of a running server share.
 * Leaves to others: making and ending it (service_setup).
 * Invariant: a service outlives every exchange; fields that change while it runs are atomic or have
 * a lock of their own. */
#ifndef SRV_SERVICE_H
#define SRV_SERVICE_H

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

/* How far the end of this process is. */
enum srv_drain {
    SRV_DRAIN_NOT,  /* the process serves */
    SRV_DRAIN_LAST, /* no new connections; requests on open ones are answered, and end the
                       connection */
    SRV_DRAIN_HURRY /* computations are ended, and none is begun */
};

/* Options and what follows from them, as a reload has set them. */
struct srv_reloaded {
    struct srv_config config;
    struct srv_peers trusted;
    const char *hosts; /* that it answers to */
    struct api_limits job_limits;
    struct srv_reloaded
        *before; /* kept to the end of the service, as other threads may be reading it */
};

struct srv_service {
    struct srv_config
        config; /* that it began with: for what a reload may change see srv_service_config */
    _Atomic(struct srv_reloaded *) reloaded; /* NULL = nothing was */
    struct srv_peers trusted;                /* proxies that may say who the client is */
    const char *hosts;                       /* that it answers to */
    struct srv_log *log;
    struct srv_key_ring *keys; /* that the operator handed out; NULL = none, and no roles */
    struct srv_queue *queue;
    struct srv_fairness fairness; /* who goes first, the sockets or the workers */
    struct srv_clients *clients;
    struct srv_cache *cache;
    struct srv_inflight *inflight;  /* computations that others may join */
    struct srv_storage *storage;    /* where jobs are kept; NULL = nowhere */
    struct srv_part_runner *runner; /* that computes them; NULL with the storage */
    struct srv_events *events;      /* who listens to them; NULL with the storage */
    struct api_limits job_limits;
    struct srv_buffer_pool pool;
    struct srv_lengths lengths; /* of results that were written once */
    struct srv_metrics metrics;
    uint64_t seed;            /* of request ids */
    atomic_ullong number;     /* requests so far */
    atomic_int draining;      /* enum srv_drain */
    atomic_int computing;     /* computations that are not over */
    atomic_int busy;          /* workers that compute just now */
    atomic_int connections;   /* open ones */
    atomic_int listening;     /* streams of events that are open */
    struct srv_memory memory; /* that is held */
    double started;           /* s since 1970 */
    int workers;
};

/** The options that are in force. The memory stays valid to the end of the service. Any thread. */
const struct srv_config *srv_service_config(const struct srv_service *service);

/** The trusted proxies that are in force. Valid and thread-safe as srv_service_config. */
const struct srv_peers *srv_service_trusted(const struct srv_service *service);

/** The hosts that the server answers to. Valid and thread-safe as srv_service_config. */
const char *srv_service_hosts(const struct srv_service *service);

/** The limits of a job's request. Valid and thread-safe as srv_service_config. */
const struct api_limits *srv_service_job_limits(const struct srv_service *service);

/** Returns why this process takes no jobs now, as a sentence without a full stop; NULL if it takes
 * them. */
const char *srv_service_jobless(const struct srv_service *service);

/** The present values of the gauges of /metrics. */
struct srv_gauges srv_service_gauges(struct srv_service *service);

#endif

/* What the parts of a running server share.
 * Leaves to others: making and ending it (daemon).
 * Invariant: outlives every exchange; what changes in it is atomic. */
#ifndef SRV_SERVICE_H
#define SRV_SERVICE_H

#include <stdatomic.h>
#include <stdint.h>

#include "server/config.h"
#include "server/log.h"
#include "server/queue.h"
#include "server/spares.h"

struct srv_service {
    struct srv_config config;
    struct srv_log *log;
    struct srv_queue *queue;
    struct srv_spares spares;
    uint64_t seed;        /* of request ids */
    atomic_ullong number; /* requests so far */
    atomic_int draining;  /* no new work is taken */
    atomic_int computing; /* exchanges that wait for a worker or have one */
    atomic_llong held;    /* bytes of bodies and answers in memory */
};

#endif

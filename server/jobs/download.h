/* The parts of a job's results on their way from the store to a computation: read ahead in
 * pieces by the threads of the storage, one piece after another, so that several downloads take
 * turns and no worker waits for a database.
 * Leaves to others: the route (job_results), the encoding (compute, api/call/results), resting
 * and going on (inflight).
 * Invariant: no lock is held while the store is asked; what is read ahead is counted until the
 * store has answered, also where nobody waits for it any more. */
#ifndef SRV_DOWNLOAD_H
#define SRV_DOWNLOAD_H

#include "server/work/exchange.h"

/**
 * A source for an exchange, whose `free` ends it. Nothing is read before it is asked whether it is
 * ready.
 *
 * source  out; NULL where there is no memory for it.
 * id      of the job.
 * parts  its parts, >= 1.
 * body    of the request that the job was made of; taken over, also on failure.
 *
 * Returns whether there is room for what is read ahead, DOWNLOAD_AHEAD pieces of SRV_CHUNK_BYTES.
 */
enum srv_room srv_download_new(struct srv_source **source, struct srv_exchange *exchange,
                               const char *id, long parts, void *body, size_t body_bytes);

#endif

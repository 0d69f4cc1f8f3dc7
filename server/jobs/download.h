/* Reads the parts of a job's results for the computation that encodes them. The threads of the
 * storage read ahead, one piece after another, so that several downloads take turns and no worker
 * waits for a database.
 * Leaves to others: the route (job_results), the encoding (compute, api/call/results), resting
 * and going on (inflight).
 * Invariant: no lock is held during a question to the store; memory for pieces is counted until the
 * store has answered, even if the client is gone. */
#ifndef SRV_DOWNLOAD_H
#define SRV_DOWNLOAD_H

#include "server/work/exchange.h"

/**
 * Makes the source of an exchange's answer; its `free` ends it. Reading begins when `ready` is
 * called first. If the caller sets source->from.partial, the first part that is not there ends the
 * source.
 *
 * source  out; NULL without memory.
 * id      of the job.
 * parts   number of its parts, >= 1.
 * body    of the request that the job was made of; taken over, also on failure.
 *
 * Returns whether memory may be counted for the body and the pieces that are read ahead,
 * DOWNLOAD_AHEAD pieces of SRV_CHUNK_BYTES.
 */
enum srv_room srv_download_new(struct srv_source **source, struct srv_exchange *exchange,
                               const char *id, long parts, void *body, size_t body_bytes);

#endif

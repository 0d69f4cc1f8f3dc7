/* Reads the parts of a job's results for the worker that encodes them. The storage threads read
 * ahead piece by piece, so that downloads take turns and no worker waits for the database. Leaves
 * to others: the route (job_results), the encoding (compute, api/call/results), parking work
 * (inflight).
 * Invariant: no lock is held during a query; the memory of pieces is accounted until the store has
 * answered, even if the client has left. */
#pragma once

#include "server/work/exchange.h"

/**
 * Creates the source of an exchange's answer; its `free` ends it. Reading begins at the first call
 * of `ready`. If the caller sets source->from.partial, the first missing part ends the source.
 *
 * source  out; NULL if memory is short.
 * id      the job's id.
 * parts   number of its parts, >= 1.
 * body    the job's request; ownership passes, also on failure.
 *
 * Returns whether the memory account has space for the body and DOWNLOAD_AHEAD pieces of
 * SRV_CHUNK_BYTES.
 */
enum srv_room srv_download_new(struct srv_source **source, struct srv_exchange *exchange,
                               const char *id, long parts, void *body, size_t body_bytes);

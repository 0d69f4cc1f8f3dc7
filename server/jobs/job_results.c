#include "server/jobs/jobs.h"

#include <stdlib.h>
#include <string.h>

#include "api/json/json_out.h"
#include "server/jobs/download.h"
#include "server/jobs/job_events.h"
#include "server/jobs/store_request.h"
#include "server/protocol/range.h"
#include "server/store/store_files.h"
#include "server/work/compute.h"

/* Passes the exchange to a worker, which reads the response from the store.
 * partial  non-zero: some parts may be missing. */
static void results_deliver(struct srv_store_request *asked, int partial) {
    assert(asked->request && asked->job.parts >= 1);
    struct srv_exchange *exchange = asked->exchange;
    struct srv_source *source;
    int op = 0;
    while (op < API_OP_COUNT && strcmp(api_op_at((enum api_op_id)op)->name, asked->job.operation))
        op++;
    if (op == API_OP_COUNT) {
        srv_exchange_busy(exchange, 1, "this version does not know the job's operation");
        srv_store_request_end(asked);
        return;
    }
    enum srv_room room = srv_download_new(&source, exchange, asked->id, asked->job.parts,
                                          asked->request, asked->request_bytes);
    asked->request = NULL;
    if (room != SRV_ROOM) {
        srv_exchange_crowded(exchange, room, "reading the job's results");
        srv_store_request_end(asked);
        return;
    }
    source->from.partial = partial;
    if (!strcmp(exchange->method, "GET") && !partial)
        source->ranged = srv_range_read(exchange->field[SRV_RANGE], &source->range);
    /* ranges refer to the response without a content coding */
    if (source->ranged) exchange->coding = SRV_IDENTITY;
    exchange->source = source;
    exchange->op = (enum api_op_id)op;
    srv_compute_begin(exchange);
    srv_store_request_leave(asked);
}

static enum srv_stored results_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    enum srv_stored stored = srv_store_job(store, asked->id, &asked->job);
    if (stored != SRV_STORED || asked->job.state != SRV_JOB_SUCCESSFUL) return stored;
    free(asked->request);
    return srv_store_job_request(store, asked->id, &asked->request, &asked->request_bytes);
}

/* Answers with the reason why there are no results, and ends the request. */
static void results_refuse(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    const struct srv_job *job = &asked->job;
    if (stored != SRV_STORED)
        srv_store_request_refuse(asked, stored);
    else if (job->state <= SRV_JOB_RUNNING)
        srv_exchange_problem(exchange, 409,
                             API_TYPE_NOT_DONE
                             "the job is %s, with %ld of %ld parts done: its results are available "
                             "at its end; ?partial=true returns those of finished parts",
                             srv_job_word(job->state), job->done, job->parts);
    else
        srv_exchange_problem(exchange, 409,
                             API_TYPE_NO_RESULTS "the job has no results: it is %s%s%.200s",
                             srv_job_word(job->state), job->message[0] ? ": " : "", job->message);
    srv_store_request_end(asked);
}

static void results_found(struct srv_store_request *asked, enum srv_stored stored) {
    if (stored == SRV_STORED && asked->job.state == SRV_JOB_SUCCESSFUL)
        results_deliver(asked, 0);
    else
        results_refuse(asked, stored);
}

/* --- the files of the results --- */

/* Appends a file to the answer, which asked->count counts. */
static enum srv_stored manifest_file(void *context, long part, const struct api_raw_file *file) {
    struct srv_store_request *asked = context;
    struct api_buffer *out = &asked->exchange->answer;
    char link[SRV_FILES_LINK];
    if (part != asked->count++) return SRV_STORED_DAMAGED;
    srv_files_link(asked->service->files, asked->id, part, file, link);
    return api_buffer_format(out, "%s{\"part\":%ld", part ? "," : "", part + 1) == PEND_OK &&
                   api_out_text(out, "href", link) == PEND_OK &&
                   api_out_whole(out, "rows", file->rows) == PEND_OK &&
                   api_out_whole(out, "bytes", (long)file->bytes) == PEND_OK &&
                   api_out_text(out, "sha256", file->digest) == PEND_OK &&
                   api_buffer_text(out, "}") == PEND_OK
               ? SRV_STORED
               : SRV_STORED_BROKEN;
}

static enum srv_stored manifest_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    enum srv_stored stored = srv_store_job(store, asked->id, &asked->job);
    if (stored != SRV_STORED || asked->job.state != SRV_JOB_SUCCESSFUL) return stored;
    if (!asked->service->files) return SRV_STORED_CLASH;
    for (long from = 0, before = -1; from < asked->job.parts; before = from) {
        SRV_STORED_TRY(srv_store_files(store, asked->id, &from, manifest_file, asked));
        if (from == before) return SRV_STORED_DAMAGED;
    }
    return SRV_STORED;
}

static void manifest_found(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    if (stored == SRV_STORED && asked->job.state == SRV_JOB_SUCCESSFUL &&
        api_buffer_text(&exchange->answer, "]}") == PEND_OK) {
        srv_exchange_answered(exchange, 200, "application/json");
        srv_exchange_header(exchange, "Cache-Control", "no-store");
        srv_store_request_end(asked);
        return;
    }
    exchange->answer.bytes = 0;
    if (stored != SRV_STORED_CLASH) {
        results_refuse(asked, stored);
        return;
    }
    srv_exchange_problem(exchange, 409,
                         API_TYPE_NO_RESULTS
                         "this job has no files of results: read them without ?manifest=true");
    srv_store_request_end(asked);
}

/* --- the request, and results while they are computed --- */

static enum srv_stored request_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    enum srv_stored stored = srv_store_job(store, asked->id, &asked->job);
    if (stored != SRV_STORED || asked->job.state > SRV_JOB_SUCCESSFUL) return stored;
    free(asked->request);
    return srv_store_job_request(store, asked->id, &asked->request, &asked->request_bytes);
}

static void request_found(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    if (stored != SRV_STORED) {
        srv_store_request_refuse(asked, stored);
    } else if (!asked->request || !asked->request_bytes) {
        srv_exchange_problem(exchange, 409,
                             API_TYPE_NO_RESULTS "the request is not stored: the job is %s",
                             srv_job_word(asked->job.state));
    } else if (api_buffer_add(&exchange->answer, asked->request, asked->request_bytes) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else {
        srv_exchange_answered(exchange, 200, "application/json");
        srv_exchange_header(exchange, "Cache-Control", "no-store");
    }
    srv_store_request_end(asked);
}

void srv_job_request(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (asked) srv_store_request_ask(asked, SRV_ASK_READ, request_find, request_found);
}

static void results_found_some(struct srv_store_request *asked, enum srv_stored stored) {
    const struct srv_job *job = &asked->job;
    int some = stored == SRV_STORED && job->state <= SRV_JOB_RUNNING && job->done > 0;
    if (some && asked->request)
        results_deliver(asked, 1);
    else
        results_found(asked, stored);
}

void srv_job_results(struct srv_exchange *exchange) {
    int some = exchange->query && !strcmp(exchange->query, "partial=true");
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (!asked) return;
    if (exchange->query && !strcmp(exchange->query, "manifest=true") &&
        api_buffer_format(&exchange->answer, "{\"job\":\"%s\",\"files\":[", asked->id) == PEND_OK) {
        srv_store_request_ask(asked, SRV_ASK_READ, manifest_find, manifest_found);
        return;
    }
    if (!some && exchange->query && *exchange->query) {
        srv_exchange_problem(exchange, 422,
                             "results take ?partial=true, ?manifest=true or no query, got ?%.100s",
                             exchange->query);
        srv_store_request_end(asked);
        return;
    }
    if (some) exchange->query = NULL;
    srv_store_request_ask(asked, SRV_ASK_READ, some ? request_find : results_find,
                          some ? results_found_some : results_found);
}

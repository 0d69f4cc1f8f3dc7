#include "server/job_results.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "server/admission.h"
#include "server/compute.h"
#include "server/errand.h"
#include "server/job_view.h"
#include "server/range.h"

/* Where a job's parts are read from, a chunk at a time. */
struct results_source {
    struct srv_source source; /* first */
    struct srv_ask ask;
    struct srv_storage *storage;
    char id[SRV_ID_BYTES];
    long shards, shard, chunk;
    void *request, *data; /* data: where the chunk goes */
    size_t bytes;
};

static enum srv_stored source_read(struct srv_store *store, struct srv_store_call *call) {
    struct results_source *source = (struct results_source *)((char *)call - offsetof(struct results_source, ask));
    return srv_store_chunk(store, source->id, source->shard, source->chunk, source->data, &source->bytes);
}

static enum pend_status source_fetch(void *context, void *data, size_t cap, size_t *bytes, struct pend_error *error) {
    struct results_source *source = context;
    enum srv_stored stored = SRV_STORED;
    *bytes = 0;
    if (cap < SRV_CHUNK_BYTES)
        return pend_fail(error, PEND_BUG, -1, 0, "a chunk of %d bytes has no room", SRV_CHUNK_BYTES);
    source->data = data;
    while (source->shard < source->shards && !*bytes) {
        source->ask.call.run = source_read;
        stored = srv_storage_wait(source->storage, SRV_ASK_READ, &source->ask);
        int none = stored == SRV_STORED_NONE && source->chunk > 0;
        if (stored != SRV_STORED && !none)
            return pend_fail(error, PEND_CANCELLED, -1, 0,
                             stored == SRV_STORED_NONE      ? "the job's results are not kept any more"
                             : stored == SRV_STORED_DAMAGED ? "the job's results are damaged where they are kept"
                                                            : "the store is out of reach");
        *bytes = none ? 0 : source->bytes;
        source->chunk++;
        if (*bytes == SRV_CHUNK_BYTES) break;
        source->shard++;
        source->chunk = 0;
    }
    return PEND_OK;
}

static void source_again(void *context) {
    struct results_source *source = context;
    source->shard = source->chunk = 0;
}

static void source_free(struct srv_source *source) {
    struct results_source *gone = (struct results_source *)source;
    free(gone->request);
    free(gone);
}

/* the exchange goes on to a worker, which takes the answer from the store */
static void results_deliver(struct srv_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    struct results_source *source = calloc(1, sizeof *source);
    int op = 0;
    while (op < API_OP_COUNT && strcmp(api_op_at((enum api_op_id)op)->name, errand->job.operation)) op++;
    if (!source || op == API_OP_COUNT) {
        srv_exchange_busy(exchange, 1, source ? "this version does not know the job's operation" : "out of memory");
        free(source);
        srv_errand_end(errand);
        return;
    }
    source->source = (struct srv_source){.from = {.fetch = source_fetch, .again = source_again, .context = source},
                                         .body = errand->request,
                                         .body_bytes = errand->request_bytes,
                                         .free = source_free};
    if (!strcmp(exchange->method, "GET"))
        source->source.ranged = srv_range_read(exchange->field[SRV_RANGE], &source->source.range);
    /* the bytes that are numbered are those of the answer as it is */
    if (source->source.ranged) exchange->coding = SRV_IDENTITY;
    source->request = errand->request;
    source->storage = exchange->service->storage;
    source->shards = errand->job.shards;
    memcpy(source->id, errand->id, sizeof source->id);
    exchange->source = &source->source;
    exchange->op = (enum api_op_id)op;
    errand->request = NULL;
    srv_compute_begin(exchange);
    srv_errand_leave(errand);
}

static enum srv_stored results_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_errand *errand = (struct srv_errand *)call;
    enum srv_stored stored = srv_store_job(store, errand->id, &errand->job);
    if (stored != SRV_STORED || errand->job.state != SRV_JOB_SUCCESSFUL) return stored;
    free(errand->request);
    return srv_store_request(store, errand->id, &errand->request, &errand->request_bytes);
}

static void results_found(struct srv_errand *errand, enum srv_stored stored) {
    struct srv_exchange *exchange = errand->exchange;
    const struct srv_job *job = &errand->job;
    if (stored == SRV_STORED && job->state == SRV_JOB_SUCCESSFUL) {
        results_deliver(errand);
        return;
    }
    if (stored != SRV_STORED)
        srv_errand_refuse(errand, stored);
    else if (job->state <= SRV_JOB_RUNNING)
        srv_exchange_problem(exchange, 409, "the job is %s, with %ld of %ld parts done: its results come with its end",
                             srv_job_word(job->state), job->done, job->shards);
    else
        srv_exchange_problem(exchange, 409, "the job has no results: it is %s%s%.200s", srv_job_word(job->state),
                             job->message[0] ? ": " : "", job->message);
    srv_errand_end(errand);
}

void srv_job_results(struct srv_exchange *exchange) {
    struct srv_errand *errand = srv_errand_begin_one(exchange);
    if (!errand) return;
    if (srv_admission_count(exchange))
        srv_errand_ask(errand, SRV_ASK_READ, results_find, results_found);
    else
        srv_errand_end(errand);
}

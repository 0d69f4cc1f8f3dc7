#include "server/jobs/job_results.h"

#include <stdlib.h>
#include <string.h>

#include "server/work/admission.h"
#include "server/work/compute.h"
#include "server/jobs/download.h"
#include "server/jobs/store_request.h"
#include "server/jobs/job_view.h"
#include "server/protocol/range.h"

/* the exchange goes on to a worker, which takes the answer from the store */
static void results_deliver(struct srv_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    struct srv_source *source;
    int op = 0;
    while (op < API_OP_COUNT && strcmp(api_op_at((enum api_op_id)op)->name, errand->job.operation)) op++;
    if (op == API_OP_COUNT) {
        srv_exchange_busy(exchange, 1, "this version does not know the job's operation");
        srv_errand_end(errand);
        return;
    }
    enum srv_room room =
        srv_download_new(&source, exchange, errand->id, errand->job.shards, errand->request, errand->request_bytes);
    errand->request = NULL;
    if (room != SRV_ROOM) {
        srv_exchange_crowded(exchange, room, "reading the job's results");
        srv_errand_end(errand);
        return;
    }
    if (!strcmp(exchange->method, "GET")) source->ranged = srv_range_read(exchange->field[SRV_RANGE], &source->range);
    /* the bytes that are numbered are those of the answer as it is */
    if (source->ranged) exchange->coding = SRV_IDENTITY;
    exchange->source = source;
    exchange->op = (enum api_op_id)op;
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

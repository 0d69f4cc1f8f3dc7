#include "server/jobs/job_results.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/work/compute.h"
#include "server/jobs/download.h"
#include "server/jobs/store_request.h"
#include "server/jobs/job_view.h"
#include "server/jobs/jobs.h"
#include "server/protocol/range.h"

/* What cites the job. Returns 0 without memory. */
static int results_cite(const struct srv_store_request *asked, struct api_cite *cite) {
    enum { ORIGIN_MORE = 16 };
    struct srv_exchange *exchange = asked->exchange;
    const struct srv_job *job = &asked->job;
    const char *host = exchange->host ? exchange->host : "localhost";
    char *origin = srv_exchange_text(exchange, strlen(host) + ORIGIN_MORE);
    if (!origin) return 0;
    sprintf(origin, "%s://%s", srv_exchange_scheme(exchange), host);
    *cite = (struct api_cite){.id = job->id,
                              .operation = job->operation,
                              .title = job->title,
                              .version = job->version,
                              .origin = origin,
                              .created = job->created,
                              .started = job->started,
                              .finished = job->finished,
                              .request = asked->request,
                              .request_bytes = asked->request_bytes};
    return api_cite_digest(cite) == PEND_OK;
}

/* Hands the exchange to a worker, which reads the response from the store.
 * crate    that it becomes the results of, taken over; NULL = of none.
 * partial  some parts may not be there yet. */
static void results_deliver(struct srv_store_request *asked, struct api_crate *crate, int partial) {
    assert(asked->request && asked->job.parts >= 1);
    struct srv_exchange *exchange = asked->exchange;
    struct srv_source *source;
    int op = 0;
    while (op < API_OP_COUNT && strcmp(api_op_at((enum api_op_id)op)->name, asked->job.operation))
        op++;
    if (op == API_OP_COUNT) {
        api_crate_free(&crate);
        srv_exchange_busy(exchange, 1, "this version does not know the job's operation");
        srv_store_request_end(asked);
        return;
    }
    enum srv_room room = srv_download_new(&source, exchange, asked->id, asked->job.parts,
                                          asked->request, asked->request_bytes);
    asked->request = NULL;
    if (room != SRV_ROOM) {
        api_crate_free(&crate);
        srv_exchange_crowded(exchange, room, "reading the job's results");
        srv_store_request_end(asked);
        return;
    }
    source->from.crate = crate;
    source->from.partial = partial;
    if (!strcmp(exchange->method, "GET") && !crate && !partial)
        source->ranged = srv_range_read(exchange->field[SRV_RANGE], &source->range);
    /* Ranges count the bytes of the response without a coding. */
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

/* Answers why there are no results, and ends the request to the store. */
static void results_refuse(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    const struct srv_job *job = &asked->job;
    if (stored != SRV_STORED)
        srv_store_request_refuse(asked, stored);
    else if (job->state <= SRV_JOB_RUNNING)
        srv_exchange_problem(exchange, 409,
                             API_TYPE_NOT_DONE "the job is %s, with %ld of %ld parts done: its "
                                               "results come with its end; ?partial=true asks for "
                                               "those of the parts that are done",
                             srv_job_word(job->state), job->done, job->parts);
    else
        srv_exchange_problem(exchange, 409,
                             API_TYPE_NO_RESULTS "the job has no results: it is %s%s%.200s",
                             srv_job_word(job->state), job->message[0] ? ": " : "", job->message);
    srv_store_request_end(asked);
}

static int results_there(const struct srv_store_request *asked, enum srv_stored stored) {
    return stored == SRV_STORED && asked->job.state == SRV_JOB_SUCCESSFUL;
}

static void results_found(struct srv_store_request *asked, enum srv_stored stored) {
    if (results_there(asked, stored))
        results_deliver(asked, NULL, 0);
    else
        results_refuse(asked, stored);
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
                             API_TYPE_NO_RESULTS "the job's request is not kept: it is %s",
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

/* Delivers what there is of a job that may still run. */
static void results_found_some(struct srv_store_request *asked, enum srv_stored stored) {
    const struct srv_job *job = &asked->job;
    int some = stored == SRV_STORED && job->state <= SRV_JOB_RUNNING && job->done > 0;
    if (some && asked->request)
        results_deliver(asked, NULL, 1);
    else
        results_found(asked, stored);
}

void srv_job_results(struct srv_exchange *exchange) {
    int some = exchange->query && !strcmp(exchange->query, "partial=true");
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (!asked) return;
    if (!some && exchange->query && *exchange->query) {
        srv_exchange_problem(exchange, 422, "results take ?partial=true or no query, got ?%.100s",
                             exchange->query);
        srv_store_request_end(asked);
        return;
    }
    if (some) exchange->query = NULL;
    srv_store_request_ask(asked, SRV_ASK_READ, some ? request_find : results_find,
                          some ? results_found_some : results_found);
}

/* --- citing --- */

static void cite_found(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    struct api_cite cite;
    if (!results_there(asked, stored)) {
        results_refuse(asked, stored);
        return;
    }
    if (!results_cite(asked, &cite) || api_cite_write(&cite, &exchange->answer) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else {
        srv_exchange_answered(exchange, 200, "application/x-bibtex; charset=utf-8");
        srv_exchange_header(exchange, "Cache-Control", "no-store");
    }
    srv_store_request_end(asked);
}

void srv_job_cite(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (asked) srv_store_request_ask(asked, SRV_ASK_READ, results_find, cite_found);
}

/* what the query of a crate says besides the form of the results */
struct crate_query {
    char text[16]; /* the extension of the results */
    char author[SRV_TITLE_BYTES], license[SRV_TITLE_BYTES];
};

/* Is it a URL, as an id of the metadata has to be? */
static int crate_url(const char *text) {
    size_t scheme = !strncmp(text, "https://", 8) ? 8 : !strncmp(text, "http://", 7) ? 7 : 0;
    for (const char *c = text; *c; c++)
        if (*c <= ' ' || *c > '~' || strchr("\"<>\\^`{|}", *c)) return 0;
    return scheme && text[scheme];
}

static int crate_named(const char *wanted, const char *name, size_t letters) {
    return strlen(wanted) == letters && !strncmp(wanted, name, letters);
}

/* Takes one value of the query. Returns 0 where there is none of this name, or not such a one. */
static int crate_take(struct crate_query *query, const char *name, size_t letters,
                      const char *value, size_t bytes) {
    char raw[3 * SRV_TITLE_BYTES];
    if (bytes > sizeof raw) return 0;
    for (size_t i = 0; i < bytes; i++) raw[i] = value[i] == '+' ? ' ' : value[i];
    if (crate_named("results", name, letters)) {
        if (bytes >= sizeof query->text || query->text[0]) return 0;
        memcpy(query->text, value, bytes);
        return 1;
    }
    if (crate_named("author", name, letters))
        return !query->author[0] && srv_jobs_title(raw, bytes, query->author);
    return crate_named("license", name, letters) && !query->license[0] &&
           srv_jobs_title(raw, bytes, query->license) && crate_url(query->license);
}

/* The representation that a crate's query asks for; NULL for a query that is none. */
static const struct api_format *crate_read_query(const char *text, struct crate_query *query) {
    for (const char *at = text; at && *at; at += *at == '&') {
        size_t letters = strcspn(at, "=&"), equals = at[letters] == '=';
        const char *value = at + letters + equals;
        size_t bytes = strcspn(value, "&");
        if (!bytes || !crate_take(query, at, letters, value, bytes)) return NULL;
        at = value + bytes;
    }
    return api_crate_format(query->text[0] ? query->text : "json");
}

static void crate_found(struct srv_store_request *asked, enum srv_stored stored) {
    const struct crate_query *query = asked->more;
    struct api_cite cite;
    struct api_crate *crate;
    if (!results_there(asked, stored)) {
        results_refuse(asked, stored);
        return;
    }
    int cited = results_cite(asked, &cite);
    cite.author = query->author;
    cite.license = query->license;
    if (cited && api_crate_new(&crate, &cite) == PEND_OK) {
        results_deliver(asked, crate, 0);
    } else {
        srv_exchange_busy(asked->exchange, 1, "out of memory");
        srv_store_request_end(asked);
    }
}

void srv_job_crate(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (!asked) return;
    struct crate_query *query = asked->more = calloc(1, sizeof *query);
    asked->more_free = free;
    if (!query) {
        srv_exchange_busy(exchange, 1, "out of memory");
        srv_store_request_end(asked);
        return;
    }
    const struct api_format *format = crate_read_query(exchange->query, query);
    if (format) {
        exchange->query = NULL;
        exchange->field[SRV_ACCEPT] = format->media_type;
        srv_store_request_ask(asked, SRV_ASK_READ, results_find, crate_found);
        return;
    }
    srv_exchange_problem(exchange, 422,
                         "a crate takes results=json, ndjson, csv, bin, npz, npy, parquet, h5, "
                         "mat or png, author=NAME and license=URL as its query, got ?%.100s",
                         exchange->query);
    srv_store_request_end(asked);
}

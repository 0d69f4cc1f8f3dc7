#include "api/call/call.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/forecast.h"
#include "api/encode/negotiate.h"

/* approximate time to read and encode one stored row, s */
static const double fetch_row_seconds = 5e-7;
/* bytes of memory of a call without its operation; of a call that reads a job's results (a chunk, a
 * record, its rows) */
static const double call_bytes = 4096, results_bytes = 1 << 20;

enum stage { STAGE_NEW, STAGE_READY, STAGE_RUNNING, STAGE_DONE, STAGE_BROKEN };

struct api_call {
    const struct api_limits *limits;
    struct api_limits own; /* limits for an answer that is read from a source */
    double (*now)(void *context);
    void *context;
    int (*hurry)(void *company);
    void *company;
    enum stage stage;
    const struct api_op *op;
    const struct api_format *format;
    void *state;                 /* the operation's state */
    struct api_source source;    /* the stored parts of the answer; all NULL if it is computed */
    struct api_results *results; /* set while the answer is read from the source */
    int fetched;                 /* the source is exhausted */
    int waits;                   /* the source has no bytes available at present */
    int ranged;                  /* only the bytes in `range` are requested */
    struct api_range range;
    long long known;         /* total bytes of the answer, set by api_call_length; <= 0 = unknown */
    long long position;      /* bytes of the answer skipped or written so far */
    struct api_buffer whole; /* the answer's bytes before the requested range is cut out */
    struct api_problem problem;
    double seconds; /* computation time so far */
    long steps;
    size_t before; /* bytes in the caller's buffer before the answer began */
    int promised;  /* the head was sent, so the answer can no longer become a problem */
    double cost;   /* estimated time, s */
    struct api_forecast forecast;
    double letters; /* bytes of the request, an upper bound of the memory of its names and lists */
    struct api_answer answer;
    char digest[API_DIGEST_BYTES];
    char columns[API_COLUMNS_TEXT];
    struct api_stats_headers stat_fields;
    char file_name[40];
};

int api_call_valid(const struct api_call *call) {
    int open = call->stage == STAGE_READY || call->stage == STAGE_RUNNING;
    return api_problem_valid(&call->problem) && api_buffer_valid(&call->whole) &&
           (!call->state || open) &&
           (!open || (call->op && call->format && call->answer.status && !call->problem.status));
}

enum pend_status api_call_new(struct api_call **call, const struct api_limits *limits) {
    *call = calloc(1, sizeof **call);
    if (!*call) return PEND_NO_MEMORY;
    (*call)->limits = limits;
    api_problem_init(&(*call)->problem);
    api_buffer_init(&(*call)->whole, (size_t)limits->answer_bytes);
    return PEND_OK;
}

static void call_keep_stats(struct api_call *call) {
    if (!call->answer.has_stat_fields) return;
    api_stats_fields(&call->stat_fields, call->source.fetch ? api_results_stats(call->results)
                                                            : api_op_stats(call->op, call->state));
    call->answer.stat_fields = &call->stat_fields;
}

/* frees the operation's state; keeps its number of steps for the log */
static void call_end_op(struct api_call *call) {
    api_results_free(&call->results);
    if (!call->state) return;
    if (call->op->steps) call->steps = call->op->steps(call->state);
    api_op_free(call->op, &call->state);
}

void api_call_free(struct api_call **call) {
    if (!*call) return;
    assert(api_call_valid(*call));
    call_end_op(*call);
    api_problem_clear(&(*call)->problem);
    api_buffer_clear(&(*call)->whole);
    free(*call);
    *call = NULL;
}

void api_call_clock(struct api_call *call, double (*now)(void *context), void *context) {
    call->now = now;
    call->context = context;
}

void api_call_hurry(struct api_call *call, int (*hurry)(void *company), void *company) {
    call->hurry = hurry;
    call->company = company;
}

/* ends the call after the head was sent; only some representations can then report the error */
static enum api_progress call_break(struct api_call *call, struct api_buffer *out) {
    size_t before = out->bytes;
    call_end_op(call);
    call->stage = STAGE_BROKEN;
    if (!call->format->problem_line) return API_BROKEN;
    enum pend_status status = api_buffer_text(out, "{\"problem\":");
    if (status == PEND_OK) status = api_problem_write(&call->problem, out);
    if (status == PEND_OK) status = api_buffer_text(out, "}\n");
    if (status != PEND_OK) out->bytes = before;
    return API_BROKEN;
}

/* ends the call: its problem replaces the bytes that were written. If memory is short, a shorter
 * problem is tried, and then an empty body. */
static enum api_progress call_refuse(struct api_call *call, struct api_buffer *out) {
    if (call->promised) return call_break(call, out);
    call_end_op(call);
    out->bytes = call->before;
    if (api_problem_write(&call->problem, out) != PEND_OK) {
        int status = call->problem.status;
        api_problem_clear(&call->problem);
        api_problem_set(&call->problem, status, "out of memory");
        if (api_problem_write(&call->problem, out) != PEND_OK) out->bytes = call->before;
    }
    call->answer = (struct api_answer){.status = call->problem.status, .length = -1};
    call->answer.media_type = "application/problem+json";
    if (call->op && call->op->form) call->answer.accepts = "application/json, multipart/form-data";
    call->cost = 0;
    call->stage = STAGE_DONE;
    return API_DONE;
}

/* sets the problem of a failure, unless one is set; PEND_NO_MEMORY replaces the errors, which may
 * be incomplete */
static enum api_progress call_fail(struct api_call *call, enum pend_status status,
                                   const struct pend_error *error, struct api_buffer *out) {
    const char *text = error && error->text[0] ? error->text : pend_status_text(status);
    if (status == PEND_NO_MEMORY) api_problem_clear(&call->problem);
    if (status == PEND_LIMIT)
        api_problem_set(
            &call->problem, 422,
            API_TYPE_LIMIT
            "the answer exceeds the limit max-answer-bytes of %.0f: ask for fewer numbers",
            call->limits->answer_bytes);
    api_problem_set(&call->problem, api_problem_http(status), "%s", text);
    return call_refuse(call, out);
}

static void call_head(struct api_call *call, long long length) {
    const struct api_op *op = call->op;
    const struct api_format *format = call->format;
    const char *type = format->content_type ? format->content_type : format->media_type;
    call->answer = (struct api_answer){.status = 200,
                                       .media_type = type,
                                       .etag = call->digest,
                                       .length = length,
                                       .deprecated = call->problem.deprecated,
                                       .has_stat_fields = op->stats != 0};
    if (call->columns[0]) call->answer.columns = call->columns;
    if (!op->table || !format->extension) return;
    snprintf(call->file_name, sizeof call->file_name, "%s.%s", op->name, format->extension);
    call->answer.file_name = call->file_name;
}

/* fills in the head of the answer from the parsed request; returns 0 if it would take far too long
 */
static int call_foresee(struct api_call *call) {
    const struct api_op *op = call->op;
    const struct api_table *table = op->table ? api_op_table(op, call->state) : NULL;
    if (op->cost) call->cost = op->cost(call->state);
    if (table && call->format->bare) api_table_columns(table, call->columns);
    int exact = table && call->format->exact && !table->rows_later;
    call_head(call, exact ? (long long)call->format->bytes(table) : -1);
    return api_forecast_begins(op, call->state, call->limits, call->cost, &call->problem);
}

/* reads the request for the preferred representation. If that cannot hold the answer and JSON is
 * acceptable too, it is read for JSON. */
static enum pend_status call_read(struct api_call *call, const struct api_request *request) {
    const struct api_format *json = api_negotiate_format(request->accept, 0);
    for (;;) {
        enum pend_status status = api_request_read(
            request, call->format, call->limits, &call->problem, &call->state, call->digest, NULL);
        if (status != PEND_INVALID || !json || call->format == json) return status;
        api_op_free(call->op, &call->state);
        api_problem_clear(&call->problem);
        call->format = json;
    }
}

/* restricts the operation to the requested part; returns 0 with a problem if there is none */
static int call_part(struct api_call *call, const struct api_request *request) {
    const struct api_op *op = call->op;
    long most = op->parts && !op->carry ? op->parts(call->state) : 0;
    assert(!request->parts || (request->part >= 1 && request->part <= request->parts));
    if (request->parts > most || (request->parts && call->format->picture))
        api_problem_set(&call->problem, 422,
                        "only numbers of ensembles have parts that are independent; these have at "
                        "most %ld, got %ld",
                        most, request->parts);
    else if (request->parts)
        op->part(call->state, request->part - 1, request->parts);
    return !call->problem.status;
}

enum api_progress api_call_open(struct api_call *call, const struct api_request *request,
                                struct api_buffer *out) {
    assert(api_call_valid(call) && call->stage == STAGE_NEW);
    call->op = api_op_at(request->op);
    call->letters = (double)request->body_bytes;
    call->before = out->bytes;
    call->format = api_negotiate_format(request->accept, call->op->samples);
    api_request_check(request, call->limits, &call->problem);
    if (!call->format) api_negotiate_refuse(&call->problem, call->op->samples);
    if (call->problem.status) return call_refuse(call, out);
    enum pend_status status = call_read(call, request);
    if (status != PEND_OK) return call_fail(call, status, NULL, out);
    if (!call_part(call, request) || !call_foresee(call)) return call_refuse(call, out);
    call->stage = STAGE_READY;
    assert(api_call_valid(call));
    return API_MORE;
}

enum api_progress api_call_results(struct api_call *call, const struct api_request *request,
                                   const struct api_source *source, struct api_buffer *out) {
    call->own = *call->limits;
    call->own.stored = source->again && !source->partial;
    call->limits = &call->own;
    enum api_progress progress = api_call_open(call, request, out);
    /* the request was valid when the job was accepted, so an error now is not the client's */
    if (progress == API_DONE && call->answer.status == 400) {
        api_problem_clear(&call->problem);
        api_problem_set(&call->problem, 500,
                        "the stored request of this job is damaged: submit the job again");
        return call_refuse(call, out);
    }
    if (progress != API_MORE) return progress;
    call->source = *source;
    api_results_head(source, &call->answer);
    call->cost = api_op_table(api_op_at(request->op), call->state)->rows * fetch_row_seconds;
    return API_MORE;
}

/* --- ranges --- */

/* resolves the range once the total length is known; returns 0 if it is empty */
static int call_settle_range(struct api_call *call, long long total) {
    struct api_range *range = &call->range;
    call->answer.total = total;
    int tail = range->first < 0;
    if (tail) range->first = range->last < total ? total - range->last : 0;
    if (tail || range->last < 0 || range->last >= total) range->last = total - 1;
    call->answer.status = 206;
    call->answer.first = range->first;
    call->answer.length = range->last - range->first + 1;
    return range->first <= range->last;
}

static enum api_progress call_refuse_range(struct api_call *call, struct api_buffer *out) {
    long long total = call->answer.total;
    api_problem_set(&call->problem, 416,
                    "the answer has %lld bytes: the requested range lies beyond its end", total);
    enum api_progress progress = call_refuse(call, out);
    call->answer.total = total;
    return progress;
}

void api_call_length(struct api_call *call, long long bytes) {
    assert(api_call_valid(call));
    call->known = bytes;
}

enum api_progress api_call_range(struct api_call *call, struct api_range range,
                                 struct api_buffer *out) {
    assert(call->stage == STAGE_READY && call->source.fetch);
    call->ranged = 1;
    call->range = range;
    call->answer.total = -1;
    long long length = call->answer.length < 0 ? call->known : call->answer.length;
    if (length < 0 || (!length && call->answer.length < 0) || call_settle_range(call, length))
        return API_MORE;
    return call_refuse_range(call, out);
}

/* appends the next piece of an answer whose parts are stored */
static enum pend_status call_fetch(struct api_call *call, struct api_buffer *out, int *done,
                                   struct pend_error *error) {
    const struct api_table *table = api_op_table(call->op, call->state);
    if (!call->results)
        PEND_TRY(api_results_new(&call->results, call->format, table, call->op->json != NULL,
                                 table->rows_later, &call->source, out, error));
    if (!call->fetched)
        return api_results_fetch(call->results, &call->source, out, &call->fetched, error);
    PEND_TRY(api_results_end(call->results, out, done));
    call->fetched = !api_results_again(call->results, &call->source);
    return PEND_OK;
}

/* appends the requested bytes of the next piece. If the total length is unknown, the answer is
 * written twice; the first pass only counts its bytes. */
static enum pend_status call_fetch_range(struct api_call *call, struct api_buffer *out, int *done,
                                         struct pend_error *error) {
    struct api_buffer *whole = &call->whole;
    whole->bytes = 0;
    PEND_TRY(call_fetch(call, whole, done, error));
    long long begin = call->position, end = call->position += (long long)whole->bytes;
    if (call->answer.total >= 0) {
        long long from = begin > call->range.first ? begin : call->range.first;
        long long to = end <= call->range.last ? end : call->range.last + 1;
        if (*done && end != call->answer.total) return PEND_BUG;
        *done |= end > call->range.last;
        return from < to ? api_buffer_add(out, whole->data + (from - begin), (size_t)(to - from))
                         : PEND_OK;
    }
    if (!*done) return PEND_OK;
    *done = 0;
    call->position = call->fetched = 0;
    api_results_free(&call->results);
    call->source.again(call->source.context);
    return call_settle_range(call, end) ? PEND_OK : PEND_INVALID;
}

static enum pend_status call_turn(struct api_call *call, const struct api_turn *turn, int *done,
                                  struct pend_error *error) {
    const struct api_source *source = &call->source;
    if (!source->fetch) return call->op->run(call->state, turn, done, error);
    do {
        call->waits = !call->fetched && source->ready && !source->ready(source->context);
        if (call->waits) return PEND_OK;
        PEND_TRY((call->ranged ? call_fetch_range : call_fetch)(call, turn->out, done, error));
    } while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

/* true if the call can end within its limits; stored answers and streams already begun pass */
static int call_hopeful(struct api_call *call) {
    return call->source.fetch || call->promised ||
           api_forecast_good(&call->forecast, call->op, call->state, call->limits, call->seconds,
                             &call->problem);
}

enum api_progress api_call_run(struct api_call *call, struct api_buffer *out) {
    assert(api_call_valid(call) && call->stage != STAGE_NEW);
    if (call->stage == STAGE_DONE) return API_DONE;
    if (call->stage == STAGE_BROKEN) return API_BROKEN;
    if (call->stage == STAGE_READY) call->before = out->bytes;
    call->stage = STAGE_RUNNING;
    struct api_turn turn = {.out = out,
                            .now = call->now,
                            .context = call->context,
                            .hurry = call->hurry,
                            .company = call->company,
                            .problem = &call->problem,
                            .earlier = call->seconds,
                            .before = out->bytes};
    struct pend_error error = {.text = ""};
    int done = 0;
    if (turn.now) turn.begun = turn.now(turn.context);
    enum pend_status status = call_turn(call, &turn, &done, &error);
    if (turn.now) call->seconds = api_turn_seconds(&turn);
    if (status == PEND_INVALID && call->answer.status == 206 && call->answer.length <= 0)
        return call_refuse_range(call, out);
    if (status != PEND_OK) return call_fail(call, status, &error, out);
    if (!done && call->waits) return API_WAITS;
    if (!done) return call_hopeful(call) ? API_MORE : call_refuse(call, out);
    call_keep_stats(call);
    call_end_op(call);
    call->stage = STAGE_DONE;
    assert(api_call_valid(call));
    return API_DONE;
}

int api_call_streams(const struct api_call *call) {
    assert(api_call_valid(call));
    int open = call->stage == STAGE_READY || call->stage == STAGE_RUNNING;
    if (open && call->format->bare && call->op->stats_first && call->op->stats_first(call->state))
        return 0;
    return open && call->op->samples;
}

void api_call_promise(struct api_call *call) {
    assert(api_call_streams(call));
    call->promised = 1;
}

const char *api_call_etag(const struct api_call *call) { return call->answer.etag; }

double api_call_cost(const struct api_call *call) { return call->cost; }

int api_call_foresees(const struct api_call *call) {
    assert(api_call_valid(call) && call->op);
    return call->op->progress && !call->source.fetch;
}

double api_call_answer_bytes(const struct api_call *call) {
    assert(api_call_valid(call));
    if (!call->state || !call->op->table) return API_OP_SMALL_BYTES;
    return call->format->bytes(api_op_table(call->op, call->state));
}

double api_call_bytes(const struct api_call *call) {
    assert(api_call_valid(call));
    if (!call->state) return 0;
    double all = call_bytes + call->letters + (double)call->whole.cap;
    /* the rows of a job are read, not computed; the operation only holds its request */
    if (call->source.fetch)
        return all + 8 * call->letters + results_bytes +
               api_results_bytes(&call->source, call->format, api_op_table(call->op, call->state));
    return all + (call->op->bytes ? call->op->bytes(call->state) : API_OP_SMALL_BYTES);
}

enum api_progress api_call_stop(struct api_call *call, int status, const char *detail,
                                struct api_buffer *out) {
    assert(api_call_valid(call));
    if (call->stage == STAGE_DONE) return API_DONE;
    if (call->stage == STAGE_BROKEN) return API_BROKEN;
    if (call->stage == STAGE_NEW) call->before = out->bytes;
    api_problem_clear(&call->problem);
    api_problem_set(&call->problem, status, "%s", detail);
    return call_refuse(call, out);
}

struct api_answer api_call_answer(const struct api_call *call) {
    assert(api_call_valid(call));
    return call->answer;
}

const char *api_call_reason(const struct api_call *call) { return call->problem.detail; }

long api_call_steps(const struct api_call *call) {
    assert(api_call_valid(call));
    return call->state && call->op->steps ? call->op->steps(call->state) : call->steps;
}

#include "api/call.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/digest.h"
#include "api/encode.h"
#include "api/engine.h"
#include "api/field.h"
#include "api/negotiate.h"

enum stage { STAGE_NEW, STAGE_READY, STAGE_RUNNING, STAGE_DONE, STAGE_BROKEN };

struct api_call {
    const struct api_limits *limits;
    double (*now)(void *context);
    void *context;
    enum stage stage;
    const struct api_op *op;
    const struct api_format *format;
    void *state; /* the operation's */
    struct api_problem problem;
    double seconds; /* of the turns so far */
    long steps;
    size_t before; /* bytes of the caller's buffer before the answer began */
    int promised;  /* the answer's head is out of our hands */
    double cost;   /* s, as estimated */
    struct api_answer answer;
    char digest[API_DIGEST_BYTES];
    char columns[API_COLUMNS_TEXT];
    char file_name[40];
};

enum pend_status api_call_new(struct api_call **call, const struct api_limits *limits) {
    *call = calloc(1, sizeof **call);
    if (!*call) return PEND_NO_MEMORY;
    (*call)->limits = limits;
    api_problem_init(&(*call)->problem);
    return PEND_OK;
}

/* lets go of what the operation holds; its steps are kept for the log */
static void call_end_op(struct api_call *call) {
    if (!call->state) return;
    if (call->op->steps) call->steps = call->op->steps(call->state);
    call->op->free(&call->state);
}

void api_call_free(struct api_call **call) {
    if (!*call) return;
    call_end_op(*call);
    api_problem_clear(&(*call)->problem);
    free(*call);
    *call = NULL;
}

void api_call_clock(struct api_call *call, double (*now)(void *context), void *context) {
    call->now = now;
    call->context = context;
}

/* ends the call after its answer was promised: only some representations can still say why */
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

/* ends the call with its problem in place of what was written. Where there is no room for that a shorter one is tried,
 * and then nothing: the status says enough. */
static enum api_progress call_refuse(struct api_call *call, struct api_buffer *out) {
    if (call->promised) return call_break(call, out);
    call_end_op(call);
    out->bytes = call->before;
    if (api_problem_write(&call->problem, out) != PEND_OK) {
        int status = call->problem.status;
        api_problem_clear(&call->problem);
        api_problem_set(&call->problem, status, "there was no memory to say more");
        if (api_problem_write(&call->problem, out) != PEND_OK) out->bytes = call->before;
    }
    call->answer =
        (struct api_answer){.status = call->problem.status, .media_type = "application/problem+json", .length = -1};
    call->cost = 0;
    call->stage = STAGE_DONE;
    return API_DONE;
}

/* makes a problem of a failure, unless one was stated where it happened; memory that ran out comes before faults that
 * could not be told in full */
static enum api_progress call_fail(struct api_call *call, enum pend_status status, const struct pend_error *error,
                                   struct api_buffer *out) {
    const char *text = error && error->text[0] ? error->text : pend_status_text(status);
    if (status == PEND_NO_MEMORY) api_problem_clear(&call->problem);
    if (status == PEND_LIMIT)
        api_problem_set(&call->problem, 422,
                        "the answer grew beyond the limit max-answer-bytes of %.0f: ask for fewer numbers",
                        call->limits->answer_bytes);
    api_problem_set(&call->problem, pend_status_http(status), "%s", text);
    return call_refuse(call, out);
}

/* what can be said of a request before its body is looked at; a problem where it is refused */
static void call_check_envelope(struct api_call *call, const struct api_request *request) {
    struct api_problem *problem = &call->problem;
    if (call->op->body && !api_negotiate_json(request->content_type))
        api_problem_set(problem, 415, "the body must be JSON in UTF-8, with Content-Type: application/json%s%s",
                        request->content_type ? ", not " : "", request->content_type ? request->content_type : "");
    call->format = api_negotiate_format(request->accept, call->op->samples);
    if (!call->format) api_negotiate_refuse(problem, call->op->samples);
    if (request->query && *request->query)
        api_problem_set(problem, 422, "this route takes no query, got \"?%s\"", request->query);
    if (call->op->body && (double)request->body_bytes > call->limits->body_bytes)
        api_problem_set(problem, 413, "the body has %zu bytes, more than the limit max-body-bytes of %.0f",
                        request->body_bytes, call->limits->body_bytes);
}

/* what tells the request from others */
static void call_digest(struct api_call *call, const struct api_request *request, const struct api_value *root) {
    const char *argument = request->argument ? request->argument : "";
    const char *const parts[] = {call->op->name, argument, call->format->media_type, api_engine, NULL};
    api_digest(call->digest, parts, root);
}

/* the head of the answer, from what was read of the request */
static void call_foresee(struct api_call *call) {
    const struct api_op *op = call->op;
    const struct api_format *format = call->format;
    const struct api_table *table = op->table ? op->table(call->state) : NULL;
    call->answer =
        (struct api_answer){.status = 200, .media_type = format->content_type, .etag = call->digest, .length = -1};
    if (op->cost) call->cost = op->cost(call->state);
    if (!table) return;
    if (format->exact) call->answer.length = (long long)format->bytes(table);
    if (format->bare) {
        api_table_columns(table, call->columns);
        call->answer.columns = call->columns;
    }
    if (!format->extension) return;
    snprintf(call->file_name, sizeof call->file_name, "%s.%s", op->name, format->extension);
    call->answer.file_name = call->file_name;
}

/* reads the body and hands it to the operation */
static enum pend_status call_read(struct api_call *call, const struct api_request *request) {
    struct api_problem *problem = &call->problem;
    struct api_json *document = NULL;
    struct api_value root;
    struct api_reading reading = {
        .argument = request->argument, .format = call->format, .limits = call->limits, .problem = problem};
    enum pend_status status = PEND_OK;
    if (call->op->body) {
        const char *body = request->body ? request->body : "";
        status = api_json_new(&document, body, request->body_bytes, (int)call->limits->depth, problem);
        if (status != PEND_OK) goto out;
        root = api_json_root(document);
        reading.root = &root;
        status = PEND_INVALID;
        if (!api_field_object(&root, problem)) goto out;
    }
    status = call->op->read(&call->state, &reading);
    if (status == PEND_OK) call_digest(call, request, reading.root);
out:
    api_json_free(&document);
    return status;
}

enum api_progress api_call_open(struct api_call *call, const struct api_request *request, struct api_buffer *out) {
    call->op = api_op_at(request->op);
    call->before = out->bytes;
    call_check_envelope(call, request);
    if (call->problem.status) return call_refuse(call, out);
    enum pend_status status = call_read(call, request);
    if (status != PEND_OK) return call_fail(call, status, NULL, out);
    call_foresee(call);
    call->stage = STAGE_READY;
    return API_MORE;
}

enum api_progress api_call_run(struct api_call *call, struct api_buffer *out) {
    struct api_turn turn = {
        .out = out, .now = call->now, .context = call->context, .earlier = call->seconds, .before = out->bytes};
    struct pend_error error = {.text = ""};
    int done = 0;
    if (call->stage == STAGE_DONE) return API_DONE;
    if (call->stage == STAGE_BROKEN) return API_BROKEN;
    if (call->stage == STAGE_READY) call->before = out->bytes;
    call->stage = STAGE_RUNNING;
    if (turn.now) turn.begun = turn.now(turn.context);
    enum pend_status status = call->op->run(call->state, &turn, &done, &error);
    if (turn.now) call->seconds = api_turn_seconds(&turn);
    if (status != PEND_OK) return call_fail(call, status, &error, out);
    if (!done) return API_MORE;
    call_end_op(call);
    call->stage = STAGE_DONE;
    return API_DONE;
}

int api_call_streams(const struct api_call *call) {
    return (call->stage == STAGE_READY || call->stage == STAGE_RUNNING) && call->op->samples;
}

void api_call_promise(struct api_call *call) {
    assert(api_call_streams(call));
    call->promised = 1;
}

const char *api_call_etag(const struct api_call *call) { return call->answer.etag; }

double api_call_cost(const struct api_call *call) { return call->cost; }

enum api_progress api_call_stop(struct api_call *call, int status, const char *detail, struct api_buffer *out) {
    if (call->stage == STAGE_DONE) return API_DONE;
    if (call->stage == STAGE_BROKEN) return API_BROKEN;
    if (call->stage == STAGE_NEW) call->before = out->bytes;
    api_problem_clear(&call->problem);
    api_problem_set(&call->problem, status, "%s", detail);
    return call_refuse(call, out);
}

struct api_answer api_call_answer(const struct api_call *call) {
    return call->answer;
}

long api_call_steps(const struct api_call *call) {
    return call->state && call->op->steps ? call->op->steps(call->state) : call->steps;
}

#include "api/call/relay_host.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/part.h"

struct api_relay_host {
    double (*now)(void *context);
    struct api_limits limits; /* of what it has */
    struct api_call *call;
    struct api_part *part;
    struct api_buffer out, more;
};

enum pend_status api_relay_host_new(struct api_relay_host **host, double (*now)(void *context)) {
    struct api_relay_host *made = *host = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    made->now = now;
    return PEND_OK;
}

void api_relay_host_free(struct api_relay_host **host) {
    if (!*host) return;
    api_call_free(&(*host)->call);
    api_part_free(&(*host)->part);
    api_buffer_clear(&(*host)->out);
    api_buffer_clear(&(*host)->more);
    free(*host);
    *host = NULL;
}

/* copies a text of whatever length, cut where it is too long */
static void host_text(char *to, size_t room, const char *text) { snprintf(to, room, "%s", text); }

/* what is told of a call */
static void host_tell(const struct api_relay_host *host, enum api_progress progress,
                      struct api_relay_told *told) {
    const struct api_call *call = host->call;
    struct api_answer answer = api_call_answer(call);
    told->progress = (int)progress;
    told->status = answer.status;
    told->length = answer.length;
    told->steps = api_call_steps(call);
    told->cost = api_call_cost(call);
    told->bytes = api_call_bytes(call) + (double)host->out.cap;
    told->answer = api_call_answer_bytes(call);
    told->streams = progress == API_MORE && api_call_streams(call);
    if (answer.etag) host_text(told->digest, sizeof told->digest, answer.etag);
    if (answer.columns) host_text(told->columns, sizeof told->columns, answer.columns);
    if (!answer.remarks) return;
    told->remarks = *answer.remarks;
    for (int i = 0; i < told->remarks.count; i++)
        while (strcmp(api_remarks_name(told->named[i]), told->remarks.field[i].name))
            told->named[i]++;
}

/* the request's texts follow the head; 0 if they are not all there */
static int host_request(const struct api_relay_head *head, const char *texts, size_t bytes,
                        struct api_request *request, const void **start, size_t *start_bytes) {
    const char *text[API_RELAY_TEXTS] = {0};
    for (int i = 0; i < API_RELAY_TEXTS; i++) {
        size_t length = (size_t)head->bytes[i];
        if (!length) continue;
        if (length > bytes || texts[length - 1]) return 0;
        text[i] = texts;
        texts += length;
        bytes -= length;
    }
    if (bytes || head->op < 0 || head->op >= API_OP_COUNT) return 0;
    *request = (struct api_request){.op = (enum api_op_id)head->op,
                                    .argument = text[0],
                                    .query = text[1],
                                    .content_type = text[2],
                                    .accept = text[3],
                                    .body = text[4],
                                    .body_bytes = text[4] ? (size_t)head->bytes[4] - 1 : 0};
    *start = text[5];
    *start_bytes = text[5] ? (size_t)head->bytes[5] - 1 : 0;
    return 1;
}

static int host_open(struct api_relay_host *host, const struct api_relay_head *head,
                     const struct api_request *request, struct api_relay_told *told) {
    if (api_call_new(&host->call, &host->limits) != PEND_OK) return 0;
    if (head->clock) api_call_clock(host->call, host->now, NULL);
    host_tell(host, api_call_open(host->call, request, &host->out), told);
    if (told->streams && host->out.limit < API_CALL_STREAM) host->out.limit = API_CALL_STREAM;
    return 1;
}

/* The bytes of an answer that may stream leave after each run; those of others when they are
 * complete, because until then the operation may look back at them. */
static int host_run(struct api_relay_host *host, const struct api_relay_head *head,
                    struct api_relay_told *told, struct api_buffer **out) {
    if (!host->call) return 0;
    if (head->promised && api_call_streams(host->call)) api_call_promise(host->call);
    enum api_progress progress = api_call_run(host->call, &host->out);
    host_tell(host, progress, told);
    if (progress == API_MORE && !told->streams) *out = NULL;
    return 1;
}

static void host_plan(struct api_relay_host *host, const struct api_relay_head *head,
                      const struct api_request *request, struct api_relay_told *told) {
    struct api_plan plan;
    told->status = api_plan_read(&plan, request, &host->limits, head->seconds,
                                 head->body ? &host->more : NULL, &host->out);
    told->plan.parts = plan.parts;
    told->plan.chained = plan.chained;
    told->plan.cost = plan.cost;
    told->plan.bytes = plan.bytes;
    told->plan.kept = plan.kept;
    if (!told->status) host_text(told->digest, sizeof told->digest, plan.digest);
}

static void host_begin(struct api_relay_host *host, const struct api_relay_head *head,
                       const struct api_request *request, const void *start, size_t bytes,
                       struct api_relay_told *told) {
    struct pend_error error = {.text = ""};
    enum pend_status status =
        api_part_new(&host->part, request, &host->limits, head->number, head->parts, &error);
    if (status == PEND_OK) {
        api_part_clock(host->part, host->now, NULL);
        if (start) status = api_part_resume(host->part, start, bytes, &error);
        told->bytes = api_part_bytes(host->part);
    }
    told->status = (int)status;
    host_text(told->text, sizeof told->text, error.text);
}

static int host_part(struct api_relay_host *host, struct api_relay_told *told,
                     struct api_buffer **out, struct api_buffer **more) {
    struct pend_error error = {.text = ""};
    if (!host->part) return 0;
    enum pend_status status = api_part_run(host->part, &host->out, &told->done, &error);
    if (status == PEND_OK && told->done) status = api_part_carry(host->part, &host->more);
    told->status = (int)status;
    told->bytes = api_part_bytes(host->part) + (double)(host->out.cap + host->more.cap);
    host_text(told->text, sizeof told->text, error.text);
    if (!told->done || status != PEND_OK) *out = *more = NULL;
    return 1;
}

/* begins anew with another request */
static int host_take(struct api_relay_host *host, const struct api_relay_head *head,
                     const char *texts, size_t bytes, struct api_relay_told *told) {
    struct api_request request;
    const void *start;
    size_t start_bytes;
    api_call_free(&host->call);
    api_part_free(&host->part);
    host->limits = head->limits;
    host->out.limit = host->more.limit = (size_t)head->limits.answer_bytes;
    if (head->kind == API_RELAY_PLAN && bytes > host->more.limit) host->more.limit = 2 * bytes;
    if (head->number < 0 || head->parts <= head->number - (head->kind != API_RELAY_BEGIN) ||
        !host_request(head, texts, bytes, &request, &start, &start_bytes))
        return 0;
    switch (head->kind) {
    case API_RELAY_OPEN:
        return host_open(host, head, &request, told);
    case API_RELAY_PLAN:
        host_plan(host, head, &request, told);
        return 1;
    case API_RELAY_BEGIN:
        host_begin(host, head, &request, start, start_bytes, told);
        return 1;
    default:
        return 0;
    }
}

int api_relay_host_answer(struct api_relay_host *host, const void *message, size_t bytes,
                          struct api_relay_told *told, struct api_buffer **out,
                          struct api_buffer **more) {
    struct api_relay_head head;
    assert(host && message);
    if (bytes < sizeof head) return 0;
    memcpy(&head, message, sizeof head);
    memset(told, 0, sizeof *told);
    told->length = -1;
    *out = &host->out;
    *more = &host->more;
    /* what was lent has been sent, unless it is to be completed first */
    if (!host->call || head.kind != API_RELAY_RUN || api_call_streams(host->call))
        if (head.kind != API_RELAY_PART) host->out.bytes = host->more.bytes = 0;
    if (head.kind == API_RELAY_RUN) return host_run(host, &head, told, out);
    if (head.kind == API_RELAY_PART) return host_part(host, told, out, more);
    return host_take(host, &head, (const char *)message + sizeof head, bytes - sizeof head, told);
}

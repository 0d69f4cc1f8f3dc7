#include "api/call/relay.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "api/base/text.h"

enum { RELAY_PARTS = 1000000000 }; /* more than any job has members or steps for */

/* does the text end within its room, with nothing in it that a header field must not have? */
static int relay_text(const char *text, size_t room) {
    const char *end = memchr(text, 0, room);
    for (const char *at = text; end && at < end; at++)
        if (*at < ' ' || *at > '~') return 0;
    return end != NULL;
}

/* a sentence, which may name what a client wrote: UTF-8 without control characters */
static int relay_sentence(const char *text, size_t room) {
    const char *end = memchr(text, 0, room);
    for (const char *at = text; end && at < end;) {
        int bytes =
            (unsigned char)*at < ' ' || *at == 127 ? 0 : api_text_utf8(at, (size_t)(end - at));
        if (!bytes) return 0;
        at += bytes;
    }
    return end != NULL;
}

static int relay_digest(const char digest[API_DIGEST_BYTES]) {
    return relay_text(digest, API_DIGEST_BYTES) &&
           (!digest[0] || strspn(digest, "0123456789abcdef") == API_DIGEST_BYTES - 1);
}

/* a number of seconds or bytes */
static int relay_amount(double value) { return isfinite(value) && value >= 0; }

static int relay_remarks(const struct api_relay_told *told) {
    if (told->remarks.count < 0 || told->remarks.count > API_REMARKS_FIELDS) return 0;
    for (int i = 0; i < told->remarks.count; i++)
        if (told->named[i] < 0 || !api_remarks_name(told->named[i]) ||
            !relay_text(told->remarks.field[i].value, API_REMARKS_TEXT))
            return 0;
    return 1;
}

/* a problem has a status of its own, and an answer 200 */
static int relay_call(const struct api_relay_told *told, enum api_relay_kind kind) {
    int problem = told->status >= 400 && told->status < 600;
    switch (told->progress) {
    case API_MORE:
        return told->status == 200 && (kind == API_RELAY_RUN || told->digest[0]);
    case API_DONE:
        return problem || (kind == API_RELAY_RUN && told->status == 200);
    case API_BROKEN:
        return problem && kind == API_RELAY_RUN;
    default:
        return 0;
    }
}

static int relay_plan(const struct api_relay_told *told) {
    int refused = told->status >= 400 && told->status < 600;
    return (refused || (!told->status && told->digest[0])) && told->plan.parts >= 1 &&
           told->plan.parts <= RELAY_PARTS && relay_amount(told->plan.cost) &&
           relay_amount(told->plan.bytes) && relay_amount(told->plan.kept);
}

static int relay_texts(const struct api_relay_told *told) {
    return relay_digest(told->digest) && relay_text(told->columns, sizeof told->columns) &&
           relay_sentence(told->text, sizeof told->text);
}

int api_relay_believable(const struct api_relay_told *told, enum api_relay_kind kind) {
    if (!relay_texts(told) || !relay_remarks(told) || !relay_amount(told->cost) ||
        !relay_amount(told->bytes) || !relay_amount(told->answer) || told->length < -1 ||
        told->steps < 0)
        return 0;
    if (kind == API_RELAY_OPEN || kind == API_RELAY_RUN) return relay_call(told, kind);
    if (kind == API_RELAY_PLAN) return relay_plan(told);
    return told->status >= PEND_OK && told->status < PEND_STATUS_COUNT;
}

enum pend_status api_relay_ask(const struct api_relay *relay, const struct api_relay_ask *ask,
                               struct api_relay_told *told, struct api_buffer *out,
                               struct api_buffer *more, struct pend_error *error) {
    PEND_TRY(relay->ask(relay->context, ask, told, out, more, error));
    if (!api_relay_believable(told, ask->kind))
        return pend_fail(error, PEND_BUG, -1, 0,
                         "the process that computed this told what cannot be");
    for (int i = 0; i < told->remarks.count; i++)
        told->remarks.field[i].name = api_remarks_name(told->named[i]);
    return PEND_OK;
}

void api_relay_put(const struct api_relay_ask *ask, struct api_relay_head *head,
                   const void *texts[API_RELAY_TEXTS]) {
    const struct api_request *request = ask->request;
    memset(head, 0, sizeof *head);
    memset(texts, 0, API_RELAY_TEXTS * sizeof *texts);
    head->kind = (int)ask->kind;
    head->promised = ask->promised;
    if (!request) return;
    assert(ask->limits);
    head->op = (int)request->op;
    head->clock = ask->clock;
    head->body = ask->body;
    head->limits = *ask->limits;
    head->seconds = ask->seconds;
    head->number = ask->number;
    head->parts = ask->parts;
    const char *const names[] = {request->argument, request->query, request->content_type,
                                 request->accept};
    for (int i = 0; i < 4; i++) {
        texts[i] = names[i];
        head->bytes[i] = names[i] ? strlen(names[i]) + 1 : 0;
    }
    texts[4] = request->body;
    head->bytes[4] = request->body ? request->body_bytes + 1 : 0;
    texts[5] = ask->start;
    head->bytes[5] = ask->start ? ask->start_bytes + 1 : 0;
}

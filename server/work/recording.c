#include "server/work/recording.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/op.h"

enum { RECORDING_FIRST = 160 }; /* the room for the first line in bytes */

static const char *const recording_ends[SRV_RECORDING_ENDS] = {"none", "whole", "stream", "broken"};

/* The digest of two pieces. Returns 0 without memory. */
static int recording_seal(const void *one, size_t one_bytes, const void *two, size_t two_bytes,
                          char seal[API_DIGEST_BYTES]) {
    struct api_digest_stream *stream = api_digest_begin();
    if (!stream) return 0;
    api_digest_add(stream, one, one_bytes);
    api_digest_add(stream, two, two_bytes);
    api_digest_end(&stream, seal);
    return 1;
}

/* --- writing --- */

static enum pend_status recording_line(struct api_buffer *out, const char *name,
                                       const char *value) {
    if (strchr(value, '\n')) return PEND_INVALID;
    PEND_TRY(api_buffer_text(out, name));
    PEND_TRY(api_buffer_text(out, value));
    return api_buffer_add(out, "\n", 1);
}

static enum pend_status recording_head(struct srv_recording *recording, struct api_buffer *out) {
    const struct api_limit_row *row;
    PEND_TRY(recording_line(out, "engine: ", recording->engine));
    PEND_TRY(recording_line(out, "operation: ", api_op_at(recording->request.op)->name));
    if (recording->request.argument)
        PEND_TRY(recording_line(out, "argument: ", recording->request.argument));
    PEND_TRY(recording_line(out, "method: ", recording->method));
    PEND_TRY(recording_line(out, "target: ", recording->target));
    for (int i = 0; i < recording->fields; i++) {
        PEND_TRY(api_buffer_format(out, "field: %s: ", recording->field[i].name));
        PEND_TRY(recording_line(out, "", recording->field[i].value));
    }
    for (int i = 0; (row = api_limits_row(i)); i++)
        PEND_TRY(api_buffer_format(out, "limit: %s %.17g\n", row->name,
                                   *api_limits_value(&recording->limits, i)));
    return api_buffer_add(out, "\n", 1);
}

enum pend_status srv_recording_write_head(struct srv_recording *recording, struct api_buffer *out) {
    struct api_buffer head;
    const struct api_request *request = &recording->request;
    assert(recording->fields <= SRV_RECORDING_FIELDS && api_op_at(request->op));
    api_buffer_init(&head, SRV_RECORDING_HEAD);
    enum pend_status status = recording_head(recording, &head);
    if (status == PEND_OK &&
        !recording_seal(head.data, head.bytes, request->body, request->body_bytes, recording->seal))
        status = PEND_NO_MEMORY;
    if (status == PEND_OK)
        status = api_buffer_format(out, "pendulumd request 1 %zu %zu %s\n", head.bytes,
                                   request->body_bytes, recording->seal);
    if (status == PEND_OK) status = api_buffer_add(out, head.data, head.bytes);
    api_buffer_clear(&head);
    return status;
}

int srv_recording_write_answer(const struct srv_recording_answer *answer,
                               const char seal[API_DIGEST_BYTES], char text[SRV_RECORDING_ANSWER]) {
    char own[API_DIGEST_BYTES];
    assert(answer->end > SRV_RECORDING_NONE && answer->end < SRV_RECORDING_ENDS);
    assert(answer->status >= 100 && answer->status <= 999 && strlen(answer->digest) == 64);
    int bytes = snprintf(text, SRV_RECORDING_ANSWER, "\nanswer %d %s %s ", answer->status,
                         recording_ends[answer->end], answer->digest);
    if (!recording_seal(seal, 64, text, (size_t)bytes, own)) return 0;
    return bytes + snprintf(text + bytes, SRV_RECORDING_ANSWER - (size_t)bytes, "%s\n", own);
}

/* --- reading --- */

static enum pend_status recording_bad(struct pend_error *error, const char *what) {
    return pend_fail(error, PEND_INVALID, -1, 0, "%s", what);
}

/* The value of a line that begins with a name, else NULL. */
static const char *recording_value(const char *line, const char *name) {
    size_t bytes = strlen(name);
    return strncmp(line, name, bytes) ? NULL : line + bytes;
}

static int recording_operation(struct srv_recording *recording, const char *name) {
    for (int op = 0; op < API_OP_COUNT; op++)
        if (!strcmp(api_op_at((enum api_op_id)op)->name, name)) {
            recording->request.op = (enum api_op_id)op;
            return 1;
        }
    return 0;
}

/* Parses a line such as "Content-Type: application/json". */
static int recording_field(struct srv_recording *recording, char *text) {
    char *colon = strstr(text, ": ");
    if (!colon || recording->fields == SRV_RECORDING_FIELDS) return 0;
    *colon = 0;
    recording->field[recording->fields].name = text;
    recording->field[recording->fields++].value = colon + 2;
    if (!strcmp(text, "Content-Type")) recording->request.content_type = colon + 2;
    if (!strcmp(text, "Accept")) recording->request.accept = colon + 2;
    return 1;
}

/* Parses a line such as "max-arms 5000". */
static int recording_limit(struct srv_recording *recording, char *text) {
    const struct api_limit_row *row;
    char *blank = strchr(text, ' '), *end;
    if (!blank) return 0;
    *blank = 0;
    double value = strtod(blank + 1, &end);
    for (int i = 0; (row = api_limits_row(i)); i++) {
        if (strcmp(row->name, text)) continue;
        *api_limits_value(&recording->limits, i) = value;
        return end > blank + 1 && !*end && value >= row->least && value <= row->most;
    }
    return 0;
}

/* Parses one line of the head. Returns 0 if it is malformed. */
static int recording_take(struct srv_recording *recording, char *line) {
    const char *value;
    if ((value = recording_value(line, "engine: ")))
        recording->engine = value;
    else if ((value = recording_value(line, "argument: ")))
        recording->request.argument = value;
    else if ((value = recording_value(line, "method: ")))
        recording->method = value;
    else if ((value = recording_value(line, "target: ")))
        recording->target = value;
    else if ((value = recording_value(line, "operation: ")))
        return recording_operation(recording, value);
    else if (recording_value(line, "field: "))
        return recording_field(recording, line + strlen("field: "));
    else
        return recording_value(line, "limit: ") &&
               recording_limit(recording, line + strlen("limit: "));
    return 1;
}

/* Parses the lines from `head` to the empty line, which ends at `end`. */
static enum pend_status recording_lines(struct srv_recording *recording, char *head, char *end,
                                        struct pend_error *error) {
    char *line = head;
    recording->request.op = API_OP_COUNT;
    if (memchr(head, 0, (size_t)(end - head)) || end - head < 2 || end[-1] != '\n')
        return recording_bad(error, "its head is damaged");
    while (line < end - 1) {
        char *next = memchr(line, '\n', (size_t)(end - line));
        *next = 0;
        if (!recording_take(recording, line))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "its line '%.60s' means nothing to this version", line);
        line = next + 1;
    }
    if (recording->request.op == API_OP_COUNT || !recording->engine || !recording->method ||
        !recording->target)
        return recording_bad(error, "its head is not complete");
    const char *query = strchr(recording->target, '?');
    recording->request.query = query ? query + 1 : NULL;
    return PEND_OK;
}

/* Parses the last line, which may be missing. */
static enum pend_status recording_answer(struct srv_recording *recording, const char *text,
                                         size_t bytes, struct pend_error *error) {
    struct srv_recording_answer *answer = &recording->answer;
    char copy[SRV_RECORDING_ANSWER], again[SRV_RECORDING_ANSWER], word[8] = "";
    if (!bytes) return PEND_OK;
    if (bytes >= sizeof copy) return recording_bad(error, "bytes follow its end");
    memcpy(copy, text, bytes);
    copy[bytes] = 0;
    int good = sscanf(copy, "\nanswer %3d %7s %64s", &answer->status, word, answer->digest) == 3 &&
               answer->status >= 100 && strlen(answer->digest) == 64;
    for (int i = SRV_RECORDING_WHOLE; good && i < SRV_RECORDING_ENDS; i++)
        if (!strcmp(recording_ends[i], word)) answer->end = (enum srv_recording_end)i;
    if (!good || !answer->end) return recording_bad(error, "the line of its answer is damaged");
    int written = srv_recording_write_answer(answer, recording->seal, again);
    if (!written) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    return (size_t)written == bytes && !memcmp(again, text, bytes)
               ? PEND_OK
               : recording_bad(error, "the line of its answer is damaged");
}

enum pend_status srv_recording_read(struct srv_recording *recording, char *data, size_t bytes,
                                    struct pend_error *error) {
    char first[RECORDING_FIRST], digest[API_DIGEST_BYTES], form[RECORDING_FIRST];
    size_t head, body;
    const char *end = memchr(data, '\n', bytes < RECORDING_FIRST - 1 ? bytes : RECORDING_FIRST - 1);
    *recording = (struct srv_recording){.engine = NULL};
    api_limits_init(&recording->limits);
    if (!end) return recording_bad(error, "it is no recorded request");
    size_t line = (size_t)(end - data) + 1;
    memcpy(first, data, line);
    first[line] = 0;
    if (sscanf(first, "pendulumd request 1 %9zu %19zu %64s", &head, &body, digest) != 3)
        return recording_bad(error, "it is no recorded request, or one of another version");
    snprintf(form, sizeof form, "pendulumd request 1 %zu %zu %s\n", head, body, digest);
    if (strcmp(form, first)) return recording_bad(error, "its first line is damaged");
    size_t left = bytes - line;
    if (head > SRV_RECORDING_HEAD || head > left || body > left - head)
        return recording_bad(error, "its end is missing");
    if (!recording_seal(data + line, head, data + line + head, body, recording->seal))
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    if (strcmp(recording->seal, digest))
        return recording_bad(error, "its bytes are not those that were recorded");
    recording->request.body = body ? data + line + head : NULL;
    recording->request.body_bytes = body;
    PEND_TRY(recording_answer(recording, data + line + head + body, left - head - body, error));
    return recording_lines(recording, data + line, data + line + head, error);
}

#include "api/clients/browser/door.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "api/op/op.h"

/* The largest answer and the largest request. A page cannot show more; in a process it is a large
 * buffer. */
#ifdef __wasm__
#define DOOR_ANSWER_BYTES (64 << 20)
#else
#define DOOR_ANSWER_BYTES (1 << 30)
#endif
#define DOOR_HEAD_BYTES (1 << 14)

static _Thread_local struct {
    char *room;
    size_t room_bytes;
    struct api_limits limits;
    struct api_call *call;
    struct api_buffer out, head;
} door;

char *door_room(size_t bytes) {
    door_close();
    free(door.room);
    door.room = bytes < DOOR_ANSWER_BYTES ? malloc(bytes + 1) : NULL;
    door.room_bytes = door.room ? bytes : 0;
    return door.room;
}

/* takes the next text of the request buffer; NULL if no NUL ends it */
static const char *door_text(size_t *at) {
    assert(*at <= door.room_bytes);
    const char *text = door.room + *at;
    const char *end = door.room ? memchr(text, 0, door.room_bytes - *at) : NULL;
    if (!end) return NULL;
    *at += (size_t)(end - text) + 1;
    return text;
}

int door_open(void) {
    size_t at = 0;
    door_close();
    const char *name = door_text(&at);
    const char *argument = name ? door_text(&at) : NULL;
    const char *accept = argument ? door_text(&at) : NULL;
    int id = accept ? (int)api_op_find(name) : API_OP_COUNT;
    // presets with an argument means the operation of one preset, which has the same name
    if (id == API_OP_PRESETS && *argument) id = API_OP_PRESET;
    if (id == API_OP_COUNT) return DOOR_UNKNOWN;
    int body = api_op_at((enum api_op_id)id)->body;
    struct api_request request = {.op = (enum api_op_id)id,
                                  .argument = *argument ? argument : NULL,
                                  .content_type = body ? "application/json" : NULL,
                                  .accept = accept,
                                  .body = body ? door.room + at : NULL,
                                  .body_bytes = body ? door.room_bytes - at : 0};
    api_limits_init(&door.limits);
#ifndef __wasm__
    // the computation uses only the caller's own machine, so there are no other limits (as in
    // pendulum --local)
    for (int i = 0; api_limits_row(i); i++)
        *api_limits_value(&door.limits, i) = api_limits_row(i)->most;
#endif
    door.limits.answer_bytes = DOOR_ANSWER_BYTES;
    api_buffer_init(&door.out, DOOR_ANSWER_BYTES);
    api_buffer_init(&door.head, DOOR_HEAD_BYTES);
    if (api_call_new(&door.call, &door.limits) != PEND_OK) return DOOR_FULL;
    return (int)api_call_open(door.call, &request, &door.out);
}

double door_cost(void) {
    assert(door.call);
    return api_call_cost(door.call);
}

void door_promise(void) {
    assert(door.call);
    if (api_call_streams(door.call)) api_call_promise(door.call);
}

int door_run(void) {
    assert(door.call);
    return (int)api_call_run(door.call, &door.out);
}

const char *door_data(void) { return door.out.data; }

size_t door_bytes(void) { return door.out.bytes; }

void door_taken(void) { door.out.bytes = 0; }

int door_status(void) {
    assert(door.call);
    return api_call_answer(door.call).status;
}

const char *door_head(void) {
    assert(door.call);
    struct api_answer answer = api_call_answer(door.call);
    struct api_buffer *head = &door.head;
    head->bytes = 0;
    int good = api_buffer_format(head, "Content-Type: %s\n", answer.media_type) == PEND_OK;
    if (good && answer.columns)
        good = api_buffer_format(head, "X-Columns: %s\n", answer.columns) == PEND_OK;
    if (good && answer.file_name)
        good = api_buffer_format(head, "Content-Disposition: attachment; filename=\"%s\"\n",
                                 answer.file_name) == PEND_OK;
    for (int i = 0; good && answer.stat_fields && i < answer.stat_fields->count; i++)
        good = api_buffer_format(head, "%s: %s\n", answer.stat_fields->field[i].name,
                                 answer.stat_fields->field[i].value) == PEND_OK;
    return good && api_buffer_add(head, "", 1) == PEND_OK ? head->data : NULL;
}

void door_close(void) {
    api_call_free(&door.call);
    api_buffer_clear(&door.out);
    api_buffer_clear(&door.head);
}

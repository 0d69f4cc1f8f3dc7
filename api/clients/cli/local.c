#include "api/clients/cli/local.h"

#include <assert.h>
#include <string.h>
#include <time.h>

#include "api/call/call.h"
#include "api/clients/cli/request.h"
#include "api/op/op.h"

static enum api_op_id operation(const char *route) {
    enum api_op_id op = api_op_find(route);
    if (op == API_OP_COUNT || !api_op_at(op)->body) cli_end(CLI_USAGE, "%s needs a server", route);
    return op;
}

static void warn(const struct api_stats_headers *stat_fields) {
    for (int i = 0; stat_fields && i < stat_fields->count; i++)
        if (!strcmp(stat_fields->field[i].name, "X-Warning")) cli_warn(stat_fields->field[i].value);
}

void cli_local(const char *route, const struct api_buffer *body, const char *accept,
               struct cli_part part, struct cli_sink *sink) {
    struct api_request request = {.op = operation(route),
                                  .part = part.part,
                                  .parts = part.parts,
                                  .content_type = "application/json",
                                  .accept = accept,
                                  .body = body->data,
                                  .body_bytes = body->bytes};
    struct api_limits limits;
    api_limits_init(&limits);
    for (int i = 0; api_limits_row(i); i++) *api_limits_value(&limits, i) = api_limits_row(i)->most;
    struct api_call *call;
    struct api_buffer out;
    api_buffer_init(&out, (size_t)limits.answer_bytes);
    cli_need(api_call_new(&call, &limits) == PEND_OK);
    enum api_progress progress = api_call_open(call, &request, &out);
    double cost = progress == API_MORE ? api_call_cost(call) : 0;
    time_t begin = time(NULL), told = begin;
    int streams = progress == API_MORE && api_call_streams(call);
    if (streams) api_call_promise(call);
    while (progress == API_MORE) {
        progress = api_call_run(call, &out);
        if (streams || (progress == API_DONE && api_call_answer(call).status < 400)) {
            if (out.bytes > 0) cli_sink_add(sink, out.data, out.bytes);
            out.bytes = 0;
        }
        if (time(NULL) != told && progress == API_MORE) {
            told = time(NULL);
            cli_progress("%ld s of about %.0f", (long)(told - begin), cost);
        }
    }
    assert(api_call_valid(call));
    struct api_answer answer = api_call_answer(call);
    if (progress == API_BROKEN)
        cli_end(CLI_FAILED + cli_scheduled, "the output ends early: %s", api_call_reason(call));
    if (answer.status >= 400) cli_refuse(answer.status, &out);
    warn(answer.stat_fields);
    api_call_free(&call);
    api_buffer_clear(&out);
}

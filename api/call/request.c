#include "api/call/request.h"

#include <stdio.h>
#include <string.h>

#include "api/base/engine.h"
#include "api/call/canonical.h"
#include "api/call/form.h"
#include "api/encode/encode_raw.h"
#include "api/encode/negotiate.h"
#include "api/json/did_you_mean.h"

/* true if the body is a multipart form and the operation accepts forms */
static int request_form(const struct api_request *request) {
    const char *type = request->content_type, *text;
    size_t bytes;
    return type && api_op_at(request->op)->form &&
           api_negotiate_parameter(type, strlen(type), "multipart/form-data", "", &text, &bytes);
}

/* reports query parameters; options belong in the body or in header fields */
static void request_query(const char *query, struct api_problem *problem) {
    char name[20] = "";
    sscanf(query, "%19[^=&]", name);
    const char *head = api_name_head(name);
    api_problem_set(problem, 422, "this route takes no query, got \"?%s\": %s%s%s", query,
                    head ? "send the header field \"" : "put it into the body", head ? head : "",
                    head ? "\"" : "");
}

void api_request_check(const struct api_request *request, const struct api_limits *limits,
                       struct api_problem *problem) {
    const struct api_op *op = api_op_at(request->op);
    if (op->body && !api_negotiate_json(request->content_type) && !request_form(request))
        api_problem_set(problem, 415,
                        "the body must be JSON in UTF-8, with Content-Type: application/json%s%s%s",
                        op->form ? ", or multipart/form-data with the parts request and csv" : "",
                        request->content_type ? ", not " : "",
                        request->content_type ? request->content_type : "");
    if (request->query && *request->query) request_query(request->query, problem);
    if (op->body && (double)request->body_bytes > limits->body_bytes)
        api_problem_set(problem, 413,
                        API_TYPE_LIMIT
                        "the body has %zu bytes, more than the limit max-body-bytes of %.0f",
                        request->body_bytes, limits->body_bytes);
}

struct span {
    const char *text;
    size_t bytes;
};

static enum pend_status request_body(const struct api_request *request,
                                     const struct api_limits *limits, struct api_buffer *joined,
                                     struct span *body, struct api_problem *problem) {
    const char *text = request->body ? request->body : "";
    *body = (struct span){text, request->body_bytes};
    if (!request_form(request)) return PEND_OK;
    enum pend_status status =
        api_form_json(request->content_type, text, request->body_bytes, limits, joined, problem);
    if (status == PEND_LIMIT) {
        api_problem_set(problem, 422,
                        API_TYPE_LIMIT
                        "the form's tables would take %zu bytes of JSON or more: send fewer rows",
                        joined->limit);
        return PEND_INVALID;
    }
    PEND_TRY(status);
    *body = (struct span){joined->bytes ? joined->data : "", joined->bytes};
    return PEND_OK;
}

/* appends the body in canonical form, unless the client wrote numbers in a shorter form */
static enum pend_status request_canonical(const struct span *body, const struct api_value *root,
                                          struct api_buffer *canonical) {
    size_t before = canonical->bytes;
    if (!root) return PEND_OK;
    enum pend_status status = api_canonical_write(root, canonical);
    if (status != PEND_OK && status != PEND_LIMIT) return status;
    if (status == PEND_OK && canonical->bytes - before <= body->bytes) return PEND_OK;
    canonical->bytes = before;
    return api_buffer_add(canonical, body->text, body->bytes);
}

enum pend_status api_request_read(const struct api_request *request,
                                  const struct api_format *format, const struct api_limits *limits,
                                  struct api_problem *problem, void **state,
                                  char digest[API_DIGEST_BYTES], struct api_buffer *canonical) {
    const struct api_op *op = api_op_at(request->op);
    const char *argument = request->argument ? request->argument : "";
    /* the engine is part of an answer's identity, but not of a job's */
    const char *engine = format == &api_format_raw ? "" : api_engine;
    const char *const parts[] = {op->name, argument, format->media_type, engine, NULL};
    struct api_json *document = NULL;
    struct api_buffer joined;
    struct api_value root;
    struct api_reading reading = {.op = op,
                                  .argument = request->argument,
                                  .format = format,
                                  .limits = limits,
                                  .problem = problem};
    enum pend_status status = PEND_OK;
    *state = NULL;
    api_buffer_init(&joined, (size_t)(2 * limits->body_bytes));
    struct span body = {"", 0};
    if (op->body) {
        status = request_body(request, limits, &joined, &body, problem);
        if (status == PEND_OK)
            status = api_json_new(&document, body.text, body.bytes, (int)limits->depth, problem);
        if (status != PEND_OK) goto out;
        root = api_json_root(document);
        reading.root = &root;
        status = PEND_INVALID;
        if (!api_field_object(&root, NULL, problem)) goto out;
    }
    status = api_op_read(state, &reading);
    if (status == PEND_OK) api_digest(digest, parts, reading.root);
    if (status == PEND_OK && canonical) status = request_canonical(&body, reading.root, canonical);
    if (status != PEND_OK) api_op_free(op, state);
out:
    api_json_free(&document);
    api_buffer_clear(&joined);
    return status;
}

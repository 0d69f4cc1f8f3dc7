#include "api/link/scene.h"

#include <stdio.h>
#include <string.h>

#include "api/call/canonical.h"
#include "api/encode/encode.h"
#include "api/encode/negotiate.h"

static const char *const scene_fields[] = {"title", "request", "view", NULL};

static void scene_check_title(const struct api_value *title, struct api_problem *problem) {
    const char *text = api_value_text(title);
    long characters = 0;
    char found[API_FOUND_BYTES];
    if (api_value_kind(title) == API_MISSING) return;
    for (const char *at = text; at && *at; at++) characters += ((unsigned char)*at & 0xc0) != 0x80;
    if (text && characters <= API_SCENE_TITLE) return;
    api_value_found(title, found);
    if (text)
        api_value_fault(title, problem,
                        API_CODE_WRONG_COUNT "must be a text of at most %d characters, got %ld",
                        API_SCENE_TITLE, characters);
    else
        api_value_fault(title, problem,
                        API_CODE_WRONG_TYPE "must be a text of at most %d characters, got %s",
                        API_SCENE_TITLE, found);
}

/* appends a member in canonical form; *bytes: length of its value */
static enum pend_status scene_member(const char *name, const struct api_value *value,
                                     const char *otherwise, struct api_buffer *out, size_t *bytes) {
    PEND_TRY(api_out_key(out, name));
    size_t before = out->bytes;
    PEND_TRY(api_value_kind(value) == API_MISSING ? api_buffer_text(out, otherwise)
                                                  : api_canonical_write(value, out));
    *bytes = out->bytes - before;
    return PEND_OK;
}

enum pend_status api_scene_check_request(const struct api_value *value,
                                         const struct api_limits *limits,
                                         struct api_problem *problem) {
    struct api_reading reading = {.op = &api_op_trajectories,
                                  .root = value,
                                  .format = &api_format_octets,
                                  .limits = limits,
                                  .problem = problem};
    void *state = NULL;
    if (!api_field_object(value, NULL, problem)) return PEND_INVALID;
    enum pend_status status = api_op_read(&state, &reading);
    api_op_free(&api_op_trajectories, &state);
    return status;
}

/* writes the members that determine the id: "title":...,"request":...,"view":... */
static enum pend_status scene_write(const struct api_value *root, double most,
                                    struct api_buffer *inner, struct api_problem *problem) {
    struct api_value view = api_value_member(root, "view");
    size_t bytes = 0;
    PEND_TRY(scene_member("title", API_MEMBER(root, "title"), "\"\"", inner, &bytes));
    PEND_TRY(scene_member("request", API_MEMBER(root, "request"), "{}", inner, &bytes));
    PEND_TRY(scene_member("view", &view, "{}", inner, &bytes));
    if (bytes > API_SCENE_VIEW)
        api_value_fault(&view, problem,
                        API_CODE_WRONG_COUNT "must have at most %d bytes without blanks, got %zu",
                        API_SCENE_VIEW, bytes);
    if ((double)inner->bytes > most)
        api_problem_set(
            problem, 413,
            API_TYPE_LIMIT
            "the scene has %zu bytes without blanks, more than the limit max-scene-bytes of %.0f",
            inner->bytes, most);
    return problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status scene_check(const struct api_value *root, const struct api_limits *limits,
                                    double most, struct api_buffer *inner,
                                    struct api_problem *problem) {
    if (!api_field_object(root, NULL, problem)) return PEND_INVALID;
    struct api_value view = api_value_member(root, "view");
    (void)api_value_only(root, scene_fields, problem);
    scene_check_title(API_MEMBER(root, "title"), problem);
    enum pend_status status = api_scene_check_request(API_MEMBER(root, "request"), limits, problem);
    if (status == PEND_NO_MEMORY) return status;
    if (api_value_kind(&view) != API_MISSING) (void)api_field_object(&view, NULL, problem);
    return problem->status ? PEND_INVALID : scene_write(root, most, inner, problem);
}

/* encodes a digest's first 130 bits as 26 letters, five bits each */
static void scene_name(const char *inner, char id[API_SCENE_ID]) {
    static const char letters[] = "0123456789abcdefghjkmnpqrstvwxyz", digits[] = "0123456789abcdef";
    char digest[API_DIGEST_BYTES];
    unsigned bits = 0, held = 0;
    api_digest(digest, (const char *const[]){"scene", inner, NULL}, NULL);
    for (int i = 0, k = 0; k < API_SCENE_ID - 1; i++) {
        bits = bits << 4 | (unsigned)(strchr(digits, digest[i]) - digits);
        held += 4;
        if (held < 5) continue;
        held -= 5;
        id[k++] = letters[bits >> held & 31];
    }
    id[API_SCENE_ID - 1] = 0;
}

static enum pend_status scene_finish(const char *id, const char *created, const char *inner,
                                     struct api_buffer *scene) {
    PEND_TRY(api_buffer_text(scene, "{"));
    PEND_TRY(api_out_text(scene, "id", id));
    PEND_TRY(api_out_text(scene, "created", created));
    PEND_TRY(api_buffer_format(scene, ",%s,", inner));
    return api_buffer_format(scene, "\"links\":{\"self\":\"/v1/scenes/%s\",\"page\":\"/#s=%s\"}}",
                             id, id);
}

static enum pend_status scene_make(const struct api_request *request,
                                   const struct api_limits *limits, double most,
                                   const char *created, char id[API_SCENE_ID],
                                   struct api_buffer *scene, struct api_problem *problem) {
    struct api_json *document = NULL;
    struct api_buffer inner;
    api_buffer_init(&inner, (size_t)limits->body_bytes * 8);
    enum pend_status status = api_json_new(&document, request->body ? request->body : "",
                                           request->body_bytes, (int)limits->depth, problem);
    if (status != PEND_OK) goto out;
    struct api_value root = api_json_root(document);
    status = scene_check(&root, limits, most, &inner, problem);
    if (status == PEND_OK) status = api_buffer_add(&inner, "", 1);
    if (status != PEND_OK) goto out;
    scene_name(inner.data, id);
    status = scene_finish(id, created, inner.data, scene);
out:
    api_buffer_clear(&inner);
    api_json_free(&document);
    return status;
}

int api_scene_read(const struct api_request *request, const struct api_limits *limits, double most,
                   const char *created, char id[API_SCENE_ID], struct api_buffer *scene,
                   struct api_buffer *out) {
    struct api_request checked = *request;
    struct api_problem problem;
    enum pend_status status = PEND_INVALID;
    api_problem_init(&problem);
    checked.op = API_OP_TRAJECTORIES;
    api_request_check(&checked, limits, &problem);
    if (!api_negotiate_format(request->accept, 0)) api_negotiate_refuse(&problem, 0);
    if (!problem.status) status = scene_make(&checked, limits, most, created, id, scene, &problem);
    return api_problem_end(&problem, status, out);
}

#include "api/base/problem.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/text.h"

/* reason phrases of RFC 9110 and RFC 6585 */
static const struct {
    int status;
    const char *title;
} problem_titles[] = {
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {406, "Not Acceptable"},
    {408, "Request Timeout"},
    {409, "Conflict"},
    {410, "Gone"},
    {411, "Length Required"},
    {412, "Precondition Failed"},
    {413, "Content Too Large"},
    {414, "URI Too Long"},
    {415, "Unsupported Media Type"},
    {416, "Range Not Satisfiable"},
    {417, "Expectation Failed"},
    {421, "Misdirected Request"},
    {422, "Unprocessable Content"},
    {429, "Too Many Requests"},
    {431, "Request Header Fields Too Large"},
    {500, "Internal Server Error"},
    {501, "Not Implemented"},
    {503, "Service Unavailable"},
    {504, "Gateway Timeout"},
    {505, "HTTP Version Not Supported"},
};

/* the words for the letters of API_CODE and API_TYPE */
static const struct {
    char letter;
    const char *word;
} problem_kinds[] = {
    {'u', "unknown_field"},   {'m', "missing"},         {'t', "wrong_type"},
    {'r', "out_of_range"},    {'n', "wrong_count"},     {'w', "unknown_name"},
    {'d', "duplicate"},       {'c', "conflict"},        {'a', "not_applicable"},
    {'o', "wrong_order"},     {'g', "not_a_tree"},      {'l', "over_limit"},
    {'s', "unsupported"},     {'I', "invalid-request"}, {'J', "not-json"},
    {'L', "over-limit"},      {'Q', "quota"},           {'R', "rate"},
    {'C', "bad-credentials"}, {'O', "not-yours"},       {'P', "role"},
    {'W', "origin"},          {'K', "key-reused"},      {'D', "not-done"},
    {'E', "no-results"},      {'S', "no-store"},
};

/* removes the code from the front of a format; NULL if it has none */
static const char *problem_kind(const char **format) {
    if (**format != 1) return NULL;
    char letter = (*format)[1];
    *format += 2;
    for (size_t i = 0; i < sizeof problem_kinds / sizeof *problem_kinds; i++)
        if (problem_kinds[i].letter == letter) return problem_kinds[i].word;
    assert(!"a kind without a word");
    return NULL;
}

static const char *problem_title(int status) {
    for (size_t i = 0; i < sizeof problem_titles / sizeof *problem_titles; i++)
        if (problem_titles[i].status == status) return problem_titles[i].title;
    return status < 500 ? "Client Error" : "Server Error";
}

/* prints; a text that is too long is cut after a whole character and ends with "..." */
__attribute__((format(printf, 3, 0))) static void
problem_print(char *out, size_t cap, const char *format, va_list arguments) {
    int bytes = vsnprintf(out, cap, format, arguments);
    if (bytes < 0) out[0] = 0;
    if (bytes < 0 || (size_t)bytes < cap) return;
    memcpy(out + api_text_cut(out, cap - 1, cap - 4), "...", 4);
}

int api_problem_valid(const struct api_problem *problem) {
    int faults = problem->count || problem->beyond;
    return problem->count >= 0 && problem->count <= API_PROBLEM_FAULTS && problem->beyond >= 0 &&
           (!problem->count || problem->faults) && (!faults || problem->status);
}

void api_problem_init(struct api_problem *problem) { *problem = (struct api_problem){0}; }

void api_problem_clear(struct api_problem *problem) {
    assert(api_problem_valid(problem));
    free(problem->faults);
    api_problem_init(problem);
}

static void problem_state(struct api_problem *problem, int status) {
    problem->status = status;
    snprintf(problem->title, sizeof problem->title, "%s", problem_title(status));
}

void api_problem_set_list(struct api_problem *problem, int status, const char *format,
                          va_list arguments) {
    assert(api_problem_valid(problem) && status >= 400 && status <= 599);
    if (problem->status) return;
    problem_state(problem, status);
    problem->type = problem_kind(&format);
    problem_print(problem->detail, sizeof problem->detail, format, arguments);
}

int api_problem_http(enum pend_status status) {
    int ours = (unsigned)status >= PEND_BUG || status == PEND_NO_CONVERGENCE;
    int later = status == PEND_NO_MEMORY || status == PEND_CANCELLED || status == PEND_DEADLINE;
    return status == PEND_OK ? 200 : ours ? 500 : later ? 503 : 422;
}

void api_problem_set(struct api_problem *problem, int status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    api_problem_set_list(problem, status, format, arguments);
    va_end(arguments);
}

void api_problem_meant(struct api_problem *problem, const char *name) {
    assert(api_problem_valid(problem));
    if (problem->count) problem->faults[problem->count - 1].meant = name;
}

int api_problem_is_meant(const struct api_problem *problem, const char *pointer, const char *name) {
    size_t bytes = strlen(pointer);
    assert(api_problem_valid(problem));
    for (int i = 0; i < problem->count; i++) {
        const struct api_fault *fault = &problem->faults[i];
        if (!fault->meant || (name && strcmp(fault->meant, name))) continue;
        const char *last = strrchr(fault->pointer, '/');
        if (last && (size_t)(last - fault->pointer) == bytes &&
            !memcmp(fault->pointer, pointer, bytes))
            return 1;
    }
    return 0;
}

int api_problem_full(struct api_problem *problem) {
    int full = problem->count == API_PROBLEM_FAULTS;
    problem->beyond += full;
    return full;
}

void api_problem_fault_list(struct api_problem *problem, const char *pointer, const char *format,
                            va_list arguments) {
    assert(api_problem_valid(problem));
    if (!problem->status) {
        const char *kind = API_TYPE_INVALID;
        problem_state(problem, 422);
        problem->type = problem_kind(&kind);
    }
    if (!problem->faults) problem->faults = malloc(API_PROBLEM_FAULTS * sizeof *problem->faults);
    if (!problem->faults || problem->count == API_PROBLEM_FAULTS) {
        problem->beyond++;
        return;
    }
    struct api_fault *fault = &problem->faults[problem->count++];
    snprintf(fault->pointer, sizeof fault->pointer, "%s", pointer);
    fault->meant = NULL;
    fault->code = problem_kind(&format);
    if (!fault->code) fault->code = "invalid";
    problem_print(fault->detail, sizeof fault->detail, format, arguments);
    assert(api_problem_valid(problem));
}

void api_problem_fault(struct api_problem *problem, const char *pointer, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    api_problem_fault_list(problem, pointer, format, arguments);
    va_end(arguments);
}

/* writes the detail; without one, the number of errors */
static enum pend_status problem_write_detail(const struct api_problem *problem,
                                             struct api_buffer *out) {
    if (problem->detail[0]) return api_text_quote(out, problem->detail, strlen(problem->detail));
    long faults = problem->count + problem->beyond;
    if (faults == 1 && problem->count == 1)
        return api_buffer_text(out, "\"1 error in the request: see errors\"");
    if (faults) return api_buffer_format(out, "\"%ld errors in the request: see errors\"", faults);
    return api_text_quote(out, problem->title, strlen(problem->title));
}

static enum pend_status problem_write_faults(const struct api_problem *problem,
                                             struct api_buffer *out) {
    for (int i = 0; i < problem->count; i++) {
        PEND_TRY(api_buffer_text(out, i ? "," : ",\"errors\":["));
        const struct api_fault *fault = &problem->faults[i];
        PEND_TRY(api_buffer_text(out, "{\"pointer\":"));
        PEND_TRY(api_text_quote(out, fault->pointer, strlen(fault->pointer)));
        PEND_TRY(api_buffer_text(out, ",\"detail\":"));
        PEND_TRY(api_text_quote(out, fault->detail, strlen(fault->detail)));
        PEND_TRY(api_buffer_format(out, ",\"code\":\"%s\"}", fault->code));
    }
    if (problem->count) PEND_TRY(api_buffer_text(out, "]"));
    return problem->beyond ? api_buffer_format(out, ",\"errors_omitted\":%ld", problem->beyond)
                           : PEND_OK;
}

static enum pend_status problem_write_all(const struct api_problem *problem,
                                          struct api_buffer *out) {
    PEND_TRY(api_buffer_format(out, "{\"type\":\"%s%s\",\"title\":",
                               problem->type ? "urn:pendulumd:problem-" : "about:blank",
                               problem->type ? problem->type : ""));
    PEND_TRY(api_text_quote(out, problem->title, strlen(problem->title)));
    PEND_TRY(api_buffer_format(out, ",\"status\":%d,\"detail\":", problem->status));
    PEND_TRY(problem_write_detail(problem, out));
    PEND_TRY(problem_write_faults(problem, out));
    return api_buffer_text(out, "}");
}

enum pend_status api_problem_write(const struct api_problem *problem, struct api_buffer *out) {
    assert(api_problem_valid(problem));
    size_t before = out->bytes;
    enum pend_status status = problem_write_all(problem, out);
    if (status != PEND_OK) out->bytes = before;
    return status;
}

int api_problem_end(struct api_problem *problem, enum pend_status status, struct api_buffer *out) {
    int http = 0;
    if (status != PEND_OK) {
        if (status == PEND_NO_MEMORY) api_problem_clear(problem);
        api_problem_set(problem, api_problem_http(status), "%s", pend_status_text(status));
        http = problem->status;
        if (api_problem_write(problem, out) != PEND_OK) out->bytes = 0;
    }
    api_problem_clear(problem);
    return http;
}

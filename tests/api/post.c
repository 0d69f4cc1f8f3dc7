#include "tests/api/post.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

static int is_json(const char *media_type) {
    return !strcmp(media_type, "application/json") ||
           !strcmp(media_type, "application/problem+json");
}

struct test_reply test_send(const struct api_request *request, const struct api_limits *limits) {
    struct test_reply reply = {.status = 0};
    struct api_limits usual;
    struct api_call *call = NULL;
    api_limits_init(&usual);
    api_buffer_init(&reply.out, (size_t)1 << 30);
    if (api_call_new(&call, limits ? limits : &usual) != PEND_OK) return reply;
    enum api_progress progress = api_call_open(call, request, &reply.out);
    for (; progress == API_MORE; reply.runs++) progress = api_call_run(call, &reply.out);
    reply.status = api_call_answer(call).status;
    reply.media_type = api_call_answer(call).media_type;
    reply.steps = api_call_steps(call);
    api_call_free(&call);
    if (api_buffer_room(&reply.out, 1) != PEND_OK) return reply;
    reply.out.data[reply.out.bytes] = 0;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    if (is_json(reply.media_type) && reply.out.bytes)
        CHECK_SAYING(api_json_new(&reply.json, reply.out.data, reply.out.bytes, 64, &problem) ==
                         PEND_OK,
                     "the answer is no JSON: %s: %.200s", problem.detail, reply.out.data);
    return reply;
}

struct test_reply test_post_as(enum api_op_id op, const char *body, const char *accept,
                               const struct api_limits *limits) {
    struct api_request request = {.op = op,
                                  .content_type = "application/json",
                                  .accept = accept,
                                  .body = body,
                                  .body_bytes = strlen(body)};
    return test_send(&request, limits);
}

struct test_reply test_post(enum api_op_id op, const char *body) {
    return test_post_as(op, body, NULL, NULL);
}

void test_reply_free(struct test_reply *reply) {
    api_json_free(&reply->json);
    api_buffer_clear(&reply->out);
}

/* a visitor is called with the value at the pointer, because values are on the stack of their
 * reader */

typedef void visit_fn(const struct api_value *value, void *context);

static void visit_from(const struct api_value *value, const char *pointer, visit_fn *visit,
                       void *context) {
    char step[80];
    if (!*pointer) {
        visit(value, context);
        return;
    }
    size_t bytes = strcspn(pointer + 1, "/");
    if (bytes >= sizeof step) return;
    memcpy(step, pointer + 1, bytes);
    step[bytes] = 0;
    int array = api_value_kind(value) == API_ARRAY;
    struct api_value next =
        array ? api_value_item(value, atoi(step)) : api_value_member(value, step);
    visit_from(&next, pointer + 1 + bytes, visit, context);
}

static void visit_at(const struct test_reply *reply, const char *pointer, visit_fn *visit,
                     void *context) {
    if (!reply->json) return;
    struct api_value root = api_json_root(reply->json);
    visit_from(&root, pointer, visit, context);
}

static void visit_number(const struct api_value *value, void *context) {
    if (api_value_kind(value) == API_NUMBER) *(double *)context = api_value_number(value);
}

static void visit_text(const struct api_value *value, void *context) {
    *(const char **)context = api_value_text(value);
}

static void visit_count(const struct api_value *value, void *context) {
    if (api_value_kind(value) != API_MISSING) *(int *)context = api_value_count(value);
}

double test_reply_number(const struct test_reply *reply, const char *pointer) {
    double number = NAN;
    visit_at(reply, pointer, visit_number, &number);
    return number;
}

double test_reply_off(const struct test_reply *reply, int j, double truth) {
    char pointer[40];
    snprintf(pointer, sizeof pointer, "/unknowns/%d/value", j);
    double value = test_reply_number(reply, pointer);
    snprintf(pointer, sizeof pointer, "/unknowns/%d/error", j);
    return fabs(value - truth) / test_reply_number(reply, pointer);
}

const char *test_reply_text(const struct test_reply *reply, const char *pointer) {
    const char *text = NULL;
    visit_at(reply, pointer, visit_text, &text);
    return text;
}

int test_reply_count(const struct test_reply *reply, const char *pointer) {
    int count = -1;
    visit_at(reply, pointer, visit_count, &count);
    return count;
}

int test_reply_faults(const struct test_reply *reply) {
    int count = test_reply_count(reply, "/errors");
    return count < 0 ? 0 : count;
}

int test_reply_has_fault(const struct test_reply *reply, const char *pointer, const char *piece) {
    for (int i = 0; i < test_reply_faults(reply); i++) {
        char at[40];
        snprintf(at, sizeof at, "/errors/%d/pointer", i);
        const char *found = test_reply_text(reply, at);
        snprintf(at, sizeof at, "/errors/%d/detail", i);
        const char *detail = test_reply_text(reply, at);
        if (found && detail && !strcmp(found, pointer) && strstr(detail, piece)) return 1;
    }
    return 0;
}

void test_refused(enum api_op_id op, const char *body, const char *pointer, const char *piece,
                  const char *file, int line) {
    OWN(test_reply, free) reply = test_post(op, body);
    int good = reply.status == 422 && !strcmp(reply.media_type, "application/problem+json") &&
               test_reply_faults(&reply) == 1 && test_reply_has_fault(&reply, pointer, piece);
    test_check(good, file, line, "expected one fault at \"%s\" with \"%s\", got %d %s", pointer,
               piece, reply.status, reply.out.data);
}

/* a table of refusals while it is read: the contents of its last template */
struct refusals {
    const char *file;
    int line, rows;
    enum api_op_id op;
    char pointer[80], before[700], after[300];
};

/* the next field of a row, ending at " | "; NULL after the last */
static char *refusals_field(char **rest) {
    char *field = *rest, *bar = field ? strstr(field, " | ") : NULL;
    if (bar) *bar = 0;
    *rest = bar ? bar + 3 : NULL;
    return field;
}

/* "@ operation pointer template" */
static int refusals_template(struct refusals *table, const char *line) {
    const char *at = strchr(line, '%');
    char op[20];
    int begin = 0;
    table->op = (enum api_op_id)0;
    if (!at || sscanf(line, "@ %19s %79s %n", op, table->pointer, &begin) < 2) return 0;
    snprintf(table->before, sizeof table->before, "%.*s", (int)(at - line) - begin, line + begin);
    snprintf(table->after, sizeof table->after, "%s", at + 1);
    if (!strcmp(table->pointer, "/")) table->pointer[0] = 0;
    while (table->op < API_OP_COUNT && strcmp(api_op_at(table->op)->name, op) != 0) table->op++;
    return table->op < API_OP_COUNT;
}

static void refusals_row(struct refusals *table, char *rest) {
    const char *fields = refusals_field(&rest), *at = refusals_field(&rest),
               *piece = refusals_field(&rest), *code = refusals_field(&rest);
    char body[1600], pointer[160];
    if (!test_check(piece != NULL, table->file, table->line, "a row has three fields")) return;
    snprintf(body, sizeof body, "%s%s%s", table->before, fields, table->after);
    snprintf(pointer, sizeof pointer, "%s%s", table->pointer, at);
    test_refused(table->op, body, pointer, piece, table->file, table->line);
    table->rows++;
    if (!code) return;
    OWN(test_reply, free) reply = test_post(table->op, body);
    const char *found = test_reply_text(&reply, "/errors/0/code");
    test_check(found && !strcmp(found, code), table->file, table->line, "the code is %s", found);
}

void test_refused_rows(const char *file) {
    struct refusals table = {.file = file};
    FILE *rows = fopen(file, "re");
    char *line = NULL;
    size_t room = 0;
    for (ssize_t bytes; rows && (bytes = getline(&line, &room, rows)) > 0;) {
        table.line++;
        if (line[bytes - 1] == '\n') line[bytes - 1] = 0;
        if (*line == '@')
            test_check(refusals_template(&table, line), file, table.line, "no template: %s", line);
        else if (*line && *line != '#')
            refusals_row(&table, line);
    }
    CHECK_SAYING(table.rows > 0, "%s has no rows", file);
    free(line);
    if (rows) fclose(rows);
}

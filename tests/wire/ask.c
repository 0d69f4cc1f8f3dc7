#include "tests/wire/ask.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *ask_long(double span) {
    static char body[8192];
    enum { ARMS = 60 };
    size_t at = (size_t)snprintf(body, sizeof body, "{\"pendulum\":{\"length\":[");
    for (int i = 0; i < ARMS; i++)
        at += (size_t)snprintf(body + at, sizeof body - at, i ? ",1" : "1");
    at += (size_t)snprintf(body + at, sizeof body - at, "],\"mass\":[");
    for (int i = 0; i < ARMS; i++)
        at += (size_t)snprintf(body + at, sizeof body - at, i ? ",1" : "1");
    at += (size_t)snprintf(body + at, sizeof body - at, "],\"parent\":[");
    for (int i = 0; i < ARMS; i++)
        at += (size_t)snprintf(body + at, sizeof body - at, i ? ",%d" : "%d", i);
    snprintf(
        body + at, sizeof body - at,
        "]},\"times\":{\"start\":0,\"stop\":%g,\"count\":5},\"method\":\"taylor\",\"rtol\":1e-12}",
        span);
    return body;
}

int ask(struct test_server *server, struct test_reply *reply, const char *path, const char *body) {
    return test_request(server, reply, "POST", path, "", body);
}

cJSON *ask_json(const struct test_reply *reply) {
    cJSON *json = cJSON_ParseWithLength(reply->body ? reply->body : "", reply->body_bytes);
    CHECK_SAYING(json != NULL, "not JSON: %.200s", reply->body);
    return json;
}

double ask_at(const cJSON *rows, int row, int column) {
    const cJSON *item = cJSON_GetArrayItem(cJSON_GetArrayItem(rows, row), column);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static int has_pointer(const cJSON *errors, const char *pointer) {
    const cJSON *error;
    cJSON_ArrayForEach(error, errors) {
        const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(error, "pointer"));
        if (text && !strcmp(text, pointer)) return 1;
    }
    return 0;
}

void ask_problem(const struct test_reply *reply, int status, const char *pointer) {
    CHECK_INT(reply->status, status);
    if (!reply->status) return;
    const char *type = test_reply_header(reply, "Content-Type");
    CHECK_TEXT(type, "application/problem+json");
    cJSON *problem = ask_json(reply);
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(problem, "status");
    CHECK_SAYING(number && number->valueint == status, "status is not in %s", reply->body);
    static const char *const text[] = {"type", "title", "detail"};
    for (int i = 0; i < 3; i++) {
        const char *value =
            cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(problem, text[i]));
        CHECK_SAYING(value && *value, "no %s in %s", text[i], reply->body);
    }
    if (pointer)
        CHECK_SAYING(has_pointer(cJSON_GetObjectItemCaseSensitive(problem, "errors"), pointer),
                     "no %s in %s", pointer, reply->body);
    cJSON_Delete(problem);
}

int ask_await(const struct test_server *server, const char *name, double least, double most) {
    double now = NAN;
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.005)) {
        now = ask_metric(server, name);
        if (now >= least && now <= most) return 1;
    }
    return CHECK_SAYING(0, "%s is %g, not %g to %g", name, now, least, most);
}

double ask_metric(const struct test_server *server, const char *name) {
    OWN(test_reply, clear) reply;
    double value = -1;
    char line[96];
    snprintf(line, sizeof line, "\n%s ", name);
    if (test_request(server, &reply, "GET", "/metrics", "", NULL) == 200) {
        const char *at = strstr(reply.body, line);
        if (at) value = atof(at + strlen(line));
    }
    return value;
}

long long ask_process(int pid, const char *name, int base) {
    char path[64], line[512];
    long long value = -1;
    snprintf(path, sizeof path, "/proc/%d/status", pid);
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file))
        if (!strncmp(line, name, strlen(name)) && line[strlen(name)] == ':')
            value = strtoll(line + strlen(name) + 1, NULL, base);
    if (file) fclose(file);
    return value;
}

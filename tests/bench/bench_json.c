/* Reading a request's JSON: bodies of 8 MiB, of numbers and of many small objects, beside cJSON.
 * Leaves to others: reading the parts of a request (bench_request).
 * Invariant: bodies are made once and are the same for both readers. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "api/json_in.h"
#include "api/number.h"
#include "tests/bench/bench.h"

enum { BYTES = 8 << 20, ROOM = 200 };

struct body {
    char *text;
    size_t bytes;
};

static struct body body_new(void (*item)(char *text, unsigned short seed[3])) {
    struct body body = {malloc(BYTES + ROOM), 1};
    unsigned short seed[3] = {1};
    if (!body.text) bench_broken("out of memory");
    body.text[0] = '[';
    while (body.bytes < BYTES) {
        item(body.text + body.bytes, seed);
        body.bytes += strlen(body.text + body.bytes);
    }
    body.text[body.bytes - 1] = ']';
    body.text[body.bytes] = 0;
    return body;
}

static void item_number(char *text, unsigned short seed[3]) {
    char *end = api_number_write(text, 20 * erand48(seed) - 10);
    memcpy(end, ",", 2);
}

static void item_digit(char *text, unsigned short seed[3]) { sprintf(text, "%d,", (int)(2 * erand48(seed))); }

static void item_arm(char *text, unsigned short seed[3]) {
    sprintf(text, "{\"name\":\"arm %d\",\"parent\":\"arm 1\",\"length\":%.3f,\"mass\":1.5},",
            (int)(1000000 * erand48(seed)), erand48(seed));
}

static void item_state(char *text, unsigned short seed[3]) {
    sprintf(text, "{\"phi\":[%.3f,1],\"phid\":[0,0]},", erand48(seed));
}

static const struct body *body(int kind) {
    static void (*const items[])(char *, unsigned short *) = {item_number, item_digit, item_arm, item_state};
    static struct body bodies[4];
    if (!bodies[kind].text) bodies[kind] = body_new(items[kind]);
    return &bodies[kind];
}

static void ours(struct bench *bench, int kind) {
    const struct body *text = body(kind);
    while (bench_go(bench, 1)) {
        struct api_json *document;
        struct api_problem problem;
        api_problem_init(&problem);
        if (api_json_new(&document, text->text, text->bytes, 16, &problem)) bench_broken(problem.detail);
        api_json_free(&document);
    }
}

static void with_cjson(struct bench *bench, int kind) {
    const struct body *text = body(kind);
    while (bench_go(bench, 1)) {
        cJSON *document = cJSON_ParseWithLength(text->text, text->bytes);
        if (!document) bench_broken("cJSON");
        cJSON_Delete(document);
    }
}

BENCH(json_8_mib_of_numbers, "body") { ours(bench, 0); }
BENCH(json_8_mib_of_zeros_and_ones, "body") { ours(bench, 1); }
BENCH(json_8_mib_of_arms, "body") { ours(bench, 2); }
BENCH(json_8_mib_of_states, "body") { ours(bench, 3); }
BENCH(json_8_mib_of_numbers_cjson, "body") { with_cjson(bench, 0); }
BENCH(json_8_mib_of_arms_cjson, "body") { with_cjson(bench, 2); }

/* Reading a request's JSON, compared with cJSON: 8 MiB of numbers, and 3 MiB of small objects,
 * whose number is almost the reader's limit (API_SCAN_VALUES).
 * Leaves to others: reading the parts of a request (bench_call).
 * Invariant: bodies are created once, and both readers read the same. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "api/json/json_in.h"
#include "api/number/number.h"
#include "tests/bench/parts/bench.h"

enum { MIB = 1 << 20, ROOM = 200 };

enum kind { NUMBERS, DIGITS, ARMS, STATES, KINDS };

struct body {
    char *text;
    size_t bytes;
};

typedef void (*item_fn)(char *text, unsigned short seed[3]);

static struct body body_new(item_fn item, size_t bytes) {
    struct body body = {malloc(bytes + ROOM), 1};
    unsigned short seed[3] = {1};
    if (!body.text) bench_broken("out of memory");
    body.text[0] = '[';
    while (body.bytes < bytes) {
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

static void item_digit(char *text, unsigned short seed[3]) {
    sprintf(text, "%d,", (int)(2 * erand48(seed)));
}

static void item_arm(char *text, unsigned short seed[3]) {
    sprintf(text, "{\"name\":\"arm %d\",\"parent\":\"arm 1\",\"length\":%.3f,\"mass\":1.5},",
            (int)(1000000 * erand48(seed)), erand48(seed));
}

static void item_state(char *text, unsigned short seed[3]) {
    sprintf(text, "{\"phi\":[%.6f,1],\"phid\":[0,0]},", erand48(seed));
}

static const struct {
    item_fn item;
    size_t bytes;
} kinds[KINDS] = {
    {item_number, 8 * MIB}, {item_digit, 8 * MIB}, {item_arm, 3 * MIB}, {item_state, 3 * MIB}};

static const struct body *body(enum kind kind) {
    static struct body bodies[KINDS];
    if (!bodies[kind].text) bodies[kind] = body_new(kinds[kind].item, kinds[kind].bytes);
    return &bodies[kind];
}

static void ours(struct bench *bench, enum kind kind) {
    const struct body *text = body(kind);
    while (bench_go(bench, 1)) {
        struct api_json *document;
        struct api_problem problem;
        api_problem_init(&problem);
        if (api_json_new(&document, text->text, text->bytes, 16, &problem))
            bench_broken(problem.detail);
        api_json_free(&document);
    }
}

static void with_cjson(struct bench *bench, enum kind kind) {
    const struct body *text = body(kind);
    while (bench_go(bench, 1)) {
        cJSON *document = cJSON_ParseWithLength(text->text, text->bytes);
        if (!document) bench_broken("cJSON");
        cJSON_Delete(document);
    }
}

BENCH(json_8_mib_of_numbers, "body") { ours(bench, NUMBERS); }
BENCH(json_8_mib_of_zeros_and_ones, "body") { ours(bench, DIGITS); }
BENCH(json_3_mib_of_arms, "body") { ours(bench, ARMS); }
BENCH(json_3_mib_of_states, "body") { ours(bench, STATES); }
BENCH(json_8_mib_of_numbers_cjson, "body") { with_cjson(bench, NUMBERS); }
BENCH(json_3_mib_of_arms_cjson, "body") { with_cjson(bench, ARMS); }

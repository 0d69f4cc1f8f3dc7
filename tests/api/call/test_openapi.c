#include "api/call/openapi.h"

#include <stdio.h>
#include <string.h>

#include "api/base/limits.h"
#include "api/json/json_in.h"
#include "api/number/number.h"
#include "core/integrate/methods/method.h"
#include "tests/harness/test.h"

enum { DEPTH = 64, STEPS = 12 };

static struct api_json *document_new(void) {
    struct api_json *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    enum pend_status status =
        api_json_new(&document, api_openapi[0].json, api_openapi[0].bytes, DEPTH, &problem);
    CHECK_SAYING(status == PEND_OK, "%s", problem.detail);
    return document;
}

/* the value at the end of a path of keys; the values of the path are stored in `steps`, because
 * values point at their parents */
static const struct api_value *find(const struct api_json *document, struct api_value steps[STEPS],
                                    const char *const keys[]) {
    int i = 0;
    steps[0] = api_json_root(document);
    for (; keys[i]; i++) steps[i + 1] = api_value_member(&steps[i], keys[i]);
    return &steps[i];
}

static const char *text_at(const struct api_json *document, const char *const keys[]) {
    struct api_value steps[STEPS];
    const char *text = api_value_text(find(document, steps, keys));
    return text ? text : "";
}

TEST(openapi_document_is_json_of_version_3_1) {
    OWN(api_json, free) *document = document_new();
    REQUIRE(document);
    CHECK(!strncmp(text_at(document, (const char *const[]){"openapi", NULL}), "3.1.", 4));
    CHECK_INT((long long)strlen(api_openapi[0].json), (long long)api_openapi[0].bytes);
}

TEST(openapi_document_tells_every_limit_as_the_table_has_it) {
    OWN(api_json, free) *document = document_new();
    REQUIRE(document);
    const char *text = text_at(document, (const char *const[]){"info", "description", NULL});
    int rows = 0;
    for (; api_limits_row(rows); rows++) {
        const struct api_limit_row *row = api_limits_row(rows);
        char line[300];
        snprintf(line, sizeof line, "| `%s` | %.0f %s | %s |", row->name, row->start, row->unit,
                 row->meaning);
        CHECK_SAYING(strstr(text, line) != NULL, "missing: %s", line);
    }
    int told = 0;
    for (const char *at = text; (at = strstr(at, "| `max-")); at++) told++;
    CHECK_SAYING(told >= rows, "%d of %d limits", told,
                 rows); /* besides these, limits of the server */
}

TEST(openapi_document_names_the_methods_that_there_are) {
    OWN(api_json, free) *document = document_new();
    struct api_value steps[STEPS];
    REQUIRE(document);
    const struct api_value *names = find(
        document, steps, (const char *const[]){"components", "schemas", "Method", "enum", NULL});
    const char *text = text_at(
        document, (const char *const[]){"components", "schemas", "Method", "description", NULL});
    int count = 0;
    for (; pend_method_at(count); count++) {
        char row[80];
        struct api_value name = api_value_item(names, count);
        CHECK_TEXT(api_value_text(&name), pend_method_at(count)->name);
        snprintf(row, sizeof row, "| `%s` | ", pend_method_at(count)->name);
        CHECK_SAYING(strstr(text, row) != NULL, "missing: %s", row);
    }
    CHECK_INT(api_value_count(names), count);
    CHECK_TEXT(text_at(document,
                       (const char *const[]){"components", "schemas", "Method", "default", NULL}),
               pend_method_at(0)->name);
}

/* "| `taylor` | 1e-12 | 1e-16 to 0.1 |" */
static void check_tolerance(const char *text, const char *method, const char *start, double least,
                            double most) {
    char number[2][API_NUMBER_BYTES + 1], row[160];
    *api_number_write(number[0], least) = *api_number_write(number[1], most) = 0;
    snprintf(row, sizeof row, "| `%s` | %s | %s to %s |", method, start, number[0], number[1]);
    CHECK_SAYING(strstr(text, row) != NULL, "missing: %s", row);
}

TEST(openapi_document_tells_the_tolerances_of_every_method) {
    OWN(api_json, free) *document = document_new();
    REQUIRE(document);
    static const char *const rtol[] = {
        "components", "schemas", "TrajectoryRequest", "properties", "rtol", "description", NULL};
    static const char *const atol[] = {
        "components", "schemas", "TrajectoryRequest", "properties", "atol", "description", NULL};
    for (int i = 0; pend_method_at(i); i++) {
        const struct pend_method *method = pend_method_at(i);
        char name[40], start[API_NUMBER_BYTES + 20];
        snprintf(name, sizeof name, "| `%s` |", method->name);
        int obeys = (method->flags & PEND_METHOD_TOLERANCES) != 0;
        CHECK_INT(strstr(text_at(document, rtol), name) != NULL, obeys);
        if (!obeys) continue;
        *api_number_write(start, method->rtol_default) = 0;
        check_tolerance(text_at(document, rtol), method->name, start, method->rtol_min,
                        method->rtol_max);
        snprintf(start, sizeof start, method->atol_divisor > 0 ? "rtol / %g" : "0",
                 method->atol_divisor);
        check_tolerance(text_at(document, atol), method->name, start, method->atol_min,
                        method->atol_max);
    }
}

TEST(openapi_document_of_some_tags_is_json_with_their_paths_and_what_these_refer_to) {
    static const struct {
        const char *query;
        int compute, classes; /* whether it contains their operations; -1: it is refused */
    } cases[] = {
        {"tag=compute", 1, 0},
        {"tag=jobs,classes", 0, 1},
        {"tag=scenes&tag=classes", 0, 1},
        {"tag=jobs%2Cscenes", 0, 0},
        {"tag=page", 0, 0},
        {"tag=presets%2ccompute,jobs", 1, 0},
        {"tag=fits", -1, 0},
        {"tag=jobs,Scenes", -1, 0},
        {"tags=jobs", -1, 0},
        {"tag=", -1, 0},
        {"tag=service", 0, 0},
        {"tag=compute,classes", 1, 1},
    };
    OWN(api_buffer, clear) text;
    api_buffer_init(&text, 4 << 20);
    for (size_t i = 0; i < 2 * sizeof cases / sizeof *cases; i++) {
        OWN(api_json, free) *document = NULL;
        OWN(api_problem, clear) problem;
        api_problem_init(&problem);
        text.bytes = 0;
        int good =
            api_openapi_write(&api_openapi[i % 2], cases[i / 2].query, &text, &problem) == PEND_OK;
        CHECK_INT(good, cases[i / 2].compute >= 0);
        if (!good) {
            CHECK_INT(problem.status, 422);
            continue;
        }
        CHECK_SAYING(api_json_new(&document, text.data, text.bytes, DEPTH, &problem) == PEND_OK,
                     "%s: %s", cases[i / 2].query, problem.detail);
        REQUIRE(api_buffer_add(&text, "", 1) == PEND_OK);
        CHECK_INT(strstr(text.data, "\"/v1/modes\":{") != NULL, cases[i / 2].compute);
        CHECK_INT(strstr(text.data, "\"FitRequest\":{") != NULL, cases[i / 2].compute);
        CHECK_INT(strstr(text.data, "\"/v1/classes\":{") != NULL, cases[i / 2].classes);
    }
}

#include "api/link/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/text.h"
#include "tests/harness/test.h"

#define REQUEST                                                                                    \
    "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"times\":{\"stop\":1,"      \
    "\"step\":0.1}}"
#define CREATED "2026-01-31T09:30:00.125Z"

/* The result for one body. */
struct scene {
    int http;
    char id[API_SCENE_ID];
    struct api_buffer text, problem; /* NUL-terminated */
};

static struct scene scene_of_bytes(const char *body, size_t bytes, double most,
                                   const char *accept) {
    struct scene scene = {.http = 0};
    struct api_limits limits;
    struct api_request request = {
        .content_type = "application/json", .accept = accept, .body = body, .body_bytes = bytes};
    api_limits_init(&limits);
    api_buffer_init(&scene.text, 1 << 20);
    api_buffer_init(&scene.problem, 1 << 20);
    scene.http =
        api_scene_read(&request, &limits, most, CREATED, scene.id, &scene.text, &scene.problem);
    CHECK(api_buffer_add(&scene.text, "", 1) == PEND_OK &&
          api_buffer_add(&scene.problem, "", 1) == PEND_OK);
    return scene;
}

static struct scene scene_of(const char *body) {
    return scene_of_bytes(body, strlen(body), 1 << 18, NULL);
}

static void scene_end(struct scene *scene) {
    api_buffer_clear(&scene->text);
    api_buffer_clear(&scene->problem);
}

static void check_refused(const char *body, int http, const char *word) {
    OWN(scene, end) scene = scene_of(body);
    CHECK_INT(scene.http, http);
    CHECK_SAYING(strstr(scene.problem.data, word) != NULL, "%s is not in %s", word,
                 scene.problem.data);
    CHECK_INT((long long)scene.text.bytes, 1);
}

TEST(scene_is_told_back_whole_in_one_form) {
    OWN(scene, end) scene =
        scene_of("{\"view\":{\"speed\":1.50},\"request\":" REQUEST ",\"title\":\"A\"}");
    char wanted[600];
    CHECK_INT(scene.http, 0);
    CHECK_INT((long long)strspn(scene.id, "0123456789abcdefghjkmnpqrstvwxyz"), API_SCENE_ID - 1);
    snprintf(wanted, sizeof wanted,
             "{\"id\":\"%s\",\"created\":\"" CREATED
             "\",\"title\":\"A\",\"request\":{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],"
             "\"parent\":[0,1]},\"times\":{\"step\":0.1,\"stop\":1}},\"view\":{\"speed\":1.5},"
             "\"links\":{\"self\":\"/v1/scenes/%s\",\"page\":\"/#s=%s\"}}",
             scene.id, scene.id, scene.id);
    CHECK_TEXT(scene.text.data, wanted);
}

TEST(scene_has_the_same_id_however_it_is_spelt_and_another_if_anything_differs) {
    static const char *const same[] = {
        "{\"request\":" REQUEST "}",
        " { \"view\" : {}, \"title\":\"\", \"request\":" REQUEST "}",
        ("{\"request\":{\"times\":{\"step\":1e-1,\"stop\":1.0},\"pendulum\":{\"parent\":[0,1],"
         "\"mass\":[1,1],\"length\":[1,1.0]}}}"),
    };
    static const char *const other[] = {
        "{\"request\":" REQUEST ",\"title\":\"a\"}",
        "{\"request\":" REQUEST ",\"view\":{\"a\":1}}",
        "{\"request\":" REQUEST ",\"view\":{\"a\":-1}}",
        "{\"request\":{\"pendulum\":{\"length\":[1,1.0000000000000002],\"mass\":[1,1],\"parent\":["
        "0,1]},\"times\":{\"stop\":1,\"step\":0.1}}}",
        "{\"request\":{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"times\":{"
        "\"stop\":1,\"step\":0.1},\"method\":\"ode23\"}}",
    };
    enum { SAME = sizeof same / sizeof *same, OTHER = sizeof other / sizeof *other };
    char id[1 + OTHER][API_SCENE_ID];
    for (int i = 0; i < SAME; i++) {
        OWN(scene, end) scene = scene_of(same[i]);
        CHECK_SAYING(!scene.http, "%s", scene.problem.data);
        if (!i) memcpy(id[0], scene.id, API_SCENE_ID);
        CHECK_TEXT(scene.id, id[0]);
    }
    for (int i = 0; i < OTHER; i++) {
        OWN(scene, end) scene = scene_of(other[i]);
        CHECK_SAYING(!scene.http, "%s", scene.problem.data);
        memcpy(id[1 + i], scene.id, API_SCENE_ID);
        for (int k = 0; k <= i; k++) CHECK(strcmp(id[k], scene.id) != 0);
    }
}

TEST(scene_tells_every_fault_below_request) {
    check_refused("{}", 422, "\"/request\"");
    check_refused("[]", 422, "\"pointer\":\"\"");
    check_refused("{", 400, "JSON");
    check_refused("{\"request\":7}", 422, "\"/request\"");
    check_refused("{\"request\":" REQUEST ",\"titel\":\"\"}", 422, "did you mean \\\"title\\\"");
    check_refused("{\"request\":" REQUEST ",\"title\":7}", 422, "\"/title\"");
    check_refused("{\"request\":" REQUEST ",\"view\":[]}", 422, "\"/view\"");
    const char *three = "{\"request\":{\"pendulum\":{\"length\":[1,-1],\"mass\":[1,1],\"parent\":["
                        "0,1]},\"times\":[1,1],\"rtol\":9},\"title\":null}";
    check_refused(three, 422, "\"/request/pendulum/length/1\"");
    check_refused(three, 422, "\"/request/times/1\"");
    check_refused(three, 422, "\"/request/rtol\"");
    check_refused(three, 422, "\"/title\"");
}

/* a body with a title and a view of this many letters of two bytes each */
static char *letters(int title, int view, size_t *bytes) {
    char *body = malloc(2 * (size_t)(title + view) + 1000), *at = body;
    at += sprintf(at, "{\"request\":%s,\"title\":\"", REQUEST);
    for (int i = 0; i < title; i++) at += sprintf(at, "\xc3\xa9");
    at += sprintf(at, "\",\"view\":{\"t\":\"");
    for (int i = 0; i < view; i++) at += sprintf(at, "\xc3\xa9");
    at += sprintf(at, "\"}}");
    *bytes = (size_t)(at - body);
    return body;
}

TEST(scene_is_bounded_in_its_title_its_view_and_all_of_it) {
    static const struct {
        int title, view, http;
        double most;
        const char *word;
    } rows[] = {
        {API_SCENE_TITLE, 0, 0, 1 << 18, ""},
        {API_SCENE_TITLE + 1, 0, 422, 1 << 18, "200 characters, got 201"},
        {0, API_SCENE_VIEW / 2 - 4, 0, 1 << 18, ""},
        {0, API_SCENE_VIEW / 2 - 3, 422, 1 << 18, "16384 bytes without blanks, got 16386"},
        {10, 1000, 413, 2000, "max-scene-bytes of 2000"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        size_t bytes;
        OWN_MEMORY char *body = letters(rows[i].title, rows[i].view, &bytes);
        OWN(scene, end) scene = scene_of_bytes(body, bytes, rows[i].most, NULL);
        CHECK_INT(scene.http, rows[i].http);
        CHECK_SAYING(strstr(scene.problem.data, rows[i].word) != NULL, "%s", scene.problem.data);
    }
}

TEST(scene_is_json_and_nothing_else) {
    OWN(scene, end) scene = scene_of_bytes(
        "{\"request\":" REQUEST "}", strlen("{\"request\":" REQUEST "}"), 1 << 18, "text/csv");
    CHECK_INT(scene.http, 406);
}

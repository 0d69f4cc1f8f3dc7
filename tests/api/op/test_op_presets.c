#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/tree/presets.h"
#include "tests/api/post.h"
#include "tests/harness/test.h"

static struct test_reply get(enum api_op_id op, const char *name) {
    struct api_request request = {.op = op, .argument = name};
    return test_send(&request, NULL);
}

TEST(the_list_has_every_preset_whole) {
    struct test_reply reply = get(API_OP_PRESETS, NULL);
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/presets"), pend_preset_count());
    for (int i = 0; i < pend_preset_count(); i++) {
        struct pend_preset preset;
        char pointer[60];
        pend_preset_get(i, &preset);
        snprintf(pointer, sizeof pointer, "/presets/%d/name", i);
        CHECK_TEXT(test_reply_text(&reply, pointer), preset.name);
        snprintf(pointer, sizeof pointer, "/presets/%d/n", i);
        CHECK(test_reply_number(&reply, pointer) == preset.n);
        struct test_reply alone = get(API_OP_PRESET, preset.name);
        CHECK_INT(alone.status, 200);
        CHECK_SAYING(strstr(reply.out.data, alone.out.data) != NULL, "%s is not in the list",
                     preset.name);
        test_reply_free(&alone);
    }
    test_reply_free(&reply);
}

TEST(every_preset_is_a_request_for_its_trajectory) {
    for (int i = 0; i < pend_preset_count(); i++) {
        struct pend_preset preset;
        pend_preset_get(i, &preset);
        struct test_reply reply = get(API_OP_PRESET, preset.name);
        CHECK_INT(reply.status, 200);
        CHECK_TEXT(test_reply_text(&reply, "/title"), preset.title);
        char *pendulum = strstr(reply.out.data, "\"pendulum\":"),
             *times = strstr(reply.out.data, "\"times\":");
        REQUIRE(pendulum && times);
        char *body = malloc(reply.out.bytes + 100);
        sprintf(body, "{%.*s\"times\":[0,0.01],\"output\":[\"phi\"]}", (int)(times - pendulum),
                pendulum);
        struct test_reply run = test_post(API_OP_TRAJECTORIES, body);
        CHECK_SAYING(run.status == 200, "%s: %.300s", preset.name, run.out.data);
        CHECK(test_reply_number(&run, "/phi/0/0") == preset.phi[0]);
        test_reply_free(&run);
        sprintf(body, "{%s", pendulum);
        struct api_limits limits;
        api_limits_init(&limits);
        limits.answer_bytes = 1; /* read and checked whole, but not computed */
        run = test_post_as(API_OP_TRAJECTORIES, body, NULL, &limits);
        CHECK(test_reply_faults(&run) == 1 &&
              test_reply_has_fault(&run, "/times", "max-answer-bytes"));
        test_reply_free(&run);
        free(body);
        test_reply_free(&reply);
    }
}

TEST(an_unknown_preset_is_not_found_and_a_near_name_is_offered) {
    struct test_reply reply = get(API_OP_PRESET, "duble");
    CHECK_INT(reply.status, 404);
    CHECK_TEXT(test_reply_text(&reply, "/detail"),
               "there is no preset \"duble\"; did you mean \"double\"?");
    test_reply_free(&reply);
    reply = get(API_OP_PRESET, "zeppelin");
    CHECK_INT(reply.status, 404);
    CHECK_TEXT(test_reply_text(&reply, "/detail"),
               "there is no preset \"zeppelin\"; /v1/presets lists them");
    test_reply_free(&reply);
    reply = get(API_OP_PRESET, NULL);
    CHECK_INT(reply.status, 404);
    test_reply_free(&reply);
}

#include "api/read/method_json.h"

#include <stdio.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define BODY(members)                                                                              \
    "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]},\"initial\":{\"phi\":[-1]},\"times\":[0,0.5]" \
    ",\"output\":["                                                                                \
    "\"phi\"]," members "}"

TEST(every_method_of_the_table_is_served_by_its_name) {
    for (int i = 0; pend_method_at(i); i++) {
        char body[300];
        const char *name = pend_method_at(i)->name;
        snprintf(body, sizeof body, BODY("\"method\":\"%s\""), name);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_SAYING(reply.status == 200, "%s: %s", name, reply.out.data);
        CHECK_TEXT(test_reply_text(&reply, "/stats/method"), name);
    }
}

TEST(taylor_is_the_default) {
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, BODY("\"precision\":\"double\""));
    CHECK_TEXT(test_reply_text(&reply, "/stats/method"), "taylor");
}

TEST(tolerances_have_the_methods_own_range) {
    for (int i = 0; pend_method_at(i); i++) {
        const struct pend_method *method = pend_method_at(i);
        char body[300], piece[160];
        snprintf(body, sizeof body, BODY("\"method\":\"%s\",\"rtol\":1e-40"), method->name);
        snprintf(piece, sizeof piece, "must be from %.15g to %.15g for method %s, got 1e-40",
                 method->rtol_min, method->rtol_max, method->name);
        if (!(method->flags & PEND_METHOD_TOLERANCES))
            snprintf(piece, sizeof piece, "has no meaning for method %s: leave it out",
                     method->name);
        CHECK_REFUSED(API_OP_TRAJECTORIES, body, "/rtol", piece);
        snprintf(body, sizeof body, BODY("\"method\":\"%s\",\"atol\":2e3"), method->name);
        snprintf(piece, sizeof piece, "for method %s", method->name);
        CHECK_REFUSED(API_OP_TRAJECTORIES, body, "/atol", piece);
        if (!(method->flags & PEND_METHOD_TOLERANCES)) continue;
        snprintf(body, sizeof body, BODY("\"method\":\"%s\",\"rtol\":%.17g,\"atol\":%.17g"),
                 method->name, method->rtol_max, method->atol_max);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_SAYING(reply.status == 200, "%s: %s", method->name, reply.out.data);
    }
}

TEST(a_tighter_tolerance_takes_more_steps) {
    OWN(test_reply, free) loose =
        test_post(API_OP_TRAJECTORIES, BODY("\"method\":\"ode23\",\"rtol\":1e-2"));
    OWN(test_reply, free) tight =
        test_post(API_OP_TRAJECTORIES, BODY("\"method\":\"ode23\",\"rtol\":1e-6"));
    CHECK(test_reply_number(&loose, "/stats/steps") > 0);
    CHECK(test_reply_number(&tight, "/stats/steps") >
          2 * test_reply_number(&loose, "/stats/steps"));
}

TEST(linear_needs_gravity_and_few_arms) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.mode_arms = 1;
    OWN(test_reply, free) reply =
        test_post_as(API_OP_TRAJECTORIES,
                     "{\"pendulum\":{\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0],[1,"
                     "1]]},\"times\":[0],\"method\":\"linear\"}",
                     NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/method", "method linear takes at most 1 arms"));
}

/* for methods that compare by component the default of atol is a thousandth of rtol, and 0 is
 * accepted */
TEST(the_default_of_atol_follows_rtol) {
    static const char *const names[] = {"ode23", "rkf45", "rk8pd", "msadams"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        static const char *const atols[] = {"", ",\"atol\":1e-8", ",\"atol\":0"};
        struct test_reply reply[3];
        for (int j = 0; j < 3; j++) {
            char body[300];
            snprintf(body, sizeof body, BODY("\"method\":\"%s\",\"rtol\":1e-5%s"), names[i],
                     atols[j]);
            reply[j] = test_post(API_OP_TRAJECTORIES, body);
            CHECK_SAYING(reply[j].status == 200, "%s%s: %s", names[i], atols[j], reply[j].out.data);
        }
        CHECK(test_reply_number(&reply[0], "/phi/1/0") == test_reply_number(&reply[1], "/phi/1/0"));
        CHECK(test_reply_number(&reply[0], "/phi/1/0") != test_reply_number(&reply[2], "/phi/1/0"));
        for (int j = 0; j < 3; j++) test_reply_free(&reply[j]);
    }
}

/* Requests and answers about periodic orbits. The numbers are tested in
 * tests/core/orbits/test_orbits.c. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

#define TWO "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"
/* the outer arm comes first */
#define TURNED "\"pendulum\":{\"length\":[1,2],\"mass\":[1,3],\"parent\":[2,0]}"
#define DRIVEN                                                                                     \
    "\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0.1],"    \
    "\"torque\":[{\"harmonics\":[{\"amplitude\":0.1,\"omega\":0.5}]}]}"

TEST(orbits_of_a_mode_are_answered_one_or_all) {
    OWN(test_reply, free) one = test_post(API_OP_ORBITS, "{" TWO ",\"mode\":2,\"amplitude\":1}");
    OWN(test_reply, free) all =
        test_post(API_OP_ORBITS, "{" TWO ",\"mode\":2,\"amplitude\":57.29577951308232,\"unit\":"
                                 "\"deg\",\"branch\":true}");
    CHECK_INT(one.status, 200);
    CHECK_INT(all.status, 200);
    int rows = test_reply_count(&all, "/period");
    char last[40];
    CHECK_INT(test_reply_count(&one, "/period"), 1);
    CHECK(rows > 10 && test_reply_number(&all, "/stats/orbits") == rows);
    snprintf(last, sizeof last, "/period/%d", rows - 1);
    CHECK(fabs(test_reply_number(&all, last) / test_reply_number(&one, "/period/0") - 1) < 1e-12);
    CHECK(fabs(test_reply_number(&one, "/amplitude/0/1") - 1) < 1e-13);
    CHECK_INT(test_reply_count(&one, "/multipliers/re/0"), 4);
    CHECK(test_reply_number(&one, "/phid/0/0") == 0 && test_reply_number(&one, "/stable/0") == 1);
    CHECK_TEXT(test_reply_text(&one, "/end"), "reached");
    CHECK_TEXT(test_reply_text(&all, "/end"), "reached");
    CHECK(test_reply_count(&one, "/warnings") < 1);
}

/* the orbit's start, posted as a trajectory, repeats after the period */
TEST(orbits_come_back_as_trajectories_do_in_the_callers_order) {
    char body[600];
    OWN(test_reply, free) orbit =
        test_post(API_OP_ORBITS, "{" TURNED ",\"mode\":1,\"amplitude\":1.5}");
    CHECK_INT(orbit.status, 200);
    double period = test_reply_number(&orbit, "/period/0"), phi[2];
    for (int k = 0; k < 2; k++) phi[k] = test_reply_number(&orbit, k ? "/phi/0/1" : "/phi/0/0");
    snprintf(body, sizeof body,
             "{" TURNED ",\"initial\":{\"phi\":[%.17g,%.17g]},\"times\":[0,%.17g]}", phi[0], phi[1],
             period);
    OWN(test_reply, free) motion = test_post(API_OP_TRAJECTORIES, body);
    CHECK_INT(motion.status, 200);
    CHECK(fabs(test_reply_number(&motion, "/phi/1/0") - phi[0]) < 1e-9);
    CHECK(fabs(test_reply_number(&motion, "/phi/1/1") - phi[1]) < 1e-9);
    CHECK(fabs(test_reply_number(&motion, "/phid/1/0")) < 1e-9);
    CHECK(fabs(phi[0] - phi[1]) > 0.01);
}

TEST(orbits_of_a_driven_pendulum_follow_what_varies) {
    OWN(test_reply, free) omega = test_post(
        API_OP_ORBITS, "{" DRIVEN ",\"branch\":{\"vary\":\"omega\",\"to\":0.6},\"digits\":9}");
    OWN(test_reply, free) torque =
        test_post(API_OP_ORBITS, "{" DRIVEN ",\"branch\":{\"vary\":\"torque_amplitude\",\"arm\":1,"
                                 "\"to\":0.2},\"step\":0.5,\"settle\":3}");
    OWN(test_reply, free) alone = test_post(API_OP_ORBITS, "{" DRIVEN "}");
    CHECK_INT(omega.status, 200);
    CHECK_INT(torque.status, 200);
    CHECK_INT(alone.status, 200);
    CHECK(test_reply_number(&omega, "/omega/0") == 0.5);
    CHECK(fabs(test_reply_number(&alone, "/period/0") - 4 * M_PI) < 1e-13);
    CHECK(test_reply_count(&alone, "/value") < 0 && test_reply_count(&alone, "/energy") < 0);
    int rows = test_reply_count(&torque, "/value");
    char last[40];
    snprintf(last, sizeof last, "/value/%d", rows - 1);
    CHECK(rows > 2 && fabs(test_reply_number(&torque, last) - 0.2) < 1e-14);
    CHECK(test_reply_number(&torque, "/value/0") == 0.1);
}

#define CASCADE                                                                                    \
    "\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0.5],"    \
    "\"torque\":[{\"harmonics\":[{\"amplitude\":0.9,\"omega\":0.6666666666666666}]}]},"            \
    "\"settle\":50,\"branch\":{\"vary\":\"torque_amplitude\",\"arm\":1,\"to\":1.08}"

TEST(orbits_switch_to_the_branch_that_begins_at_a_bifurcation) {
    OWN(test_reply, free) once = test_post(API_OP_ORBITS, "{" CASCADE ",\"switch\":[1]}");
    OWN(test_reply, free) twice = test_post(API_OP_ORBITS, "{" CASCADE ",\"switch\":[1,1]}");
    OWN(test_reply, free) swing = test_post(
        API_OP_ORBITS, "{" TWO ",\"mode\":2,\"amplitude\":2,\"branch\":true,\"switch\":[-1]}");
    CHECK_INT(once.status, 200);
    CHECK_INT(twice.status, 200);
    CHECK_INT(swing.status, 200);
    CHECK_TEXT(test_reply_text(&once, "/bifurcations/0/kind"), "symmetry");
    CHECK(test_reply_number(&once, "/bifurcations/0/after") == 0);
    CHECK_TEXT(test_reply_text(&twice, "/bifurcations/0/kind"), "doubling");
    CHECK(test_reply_number(&twice, "/bifurcations/0/value") ==
          test_reply_number(&once, "/bifurcations/1/value"));
    CHECK(fabs(test_reply_number(&twice, "/period/0") - 6 * M_PI) < 1e-12);
    CHECK(fabs(test_reply_number(&once, "/period/0") - 3 * M_PI) < 1e-12);
    CHECK_TEXT(test_reply_text(&swing, "/end"), "reached");
    CHECK(test_reply_number(&swing, "/energy/0") >
          test_reply_number(&swing, "/bifurcations/0/energy"));
    CHECK(fabs(test_reply_number(&swing, "/phid/0/0")) > 1e-4 ||
          fabs(test_reply_number(&swing, "/phid/0/1")) > 1e-4);
}

/* the same numbers as in the list of bifurcations */
TEST(orbits_have_their_bifurcations_as_rows) {
    OWN(test_reply, free) list = test_post(API_OP_ORBITS, "{" CASCADE ",\"switch\":[1]}");
    OWN(test_reply, free) rows =
        test_post(API_OP_ORBITS, "{" CASCADE ",\"switch\":[1],\"rows\":\"bifurcations\"}");
    OWN(test_reply, free) none =
        test_post(API_OP_ORBITS, "{" TWO ",\"mode\":1,\"amplitude\":0.1,\"branch\":true,\"rows\":"
                                 "\"bifurcations\"}");
    CHECK_INT(list.status, 200);
    CHECK_INT(rows.status, 200);
    CHECK_INT(none.status, 200);
    int count = test_reply_count(&list, "/bifurcations");
    CHECK(count == 2 && test_reply_count(&rows, "/kind") == count);
    CHECK_INT(test_reply_count(&none, "/kind"), 0);
    for (int i = 0; i < count; i++) {
        static const struct {
            const char *name, *last;
        } same[] = {{"after", ""}, {"value", ""}, {"period", ""}, {"phi", "/0"}, {"phid", "/0"}};
        for (size_t k = 0; k < sizeof same / sizeof *same; k++) {
            char row[40], item[60];
            snprintf(row, sizeof row, "/%s/%d%s", same[k].name, i, same[k].last);
            snprintf(item, sizeof item, "/bifurcations/%d/%s%s", i, same[k].name, same[k].last);
            CHECK(test_reply_number(&rows, row) == test_reply_number(&list, item));
        }
    }
    CHECK(test_reply_number(&rows, "/kind/0") == 3 && test_reply_number(&rows, "/kind/1") == 4);
    CHECK(test_reply_number(&rows, "/stats/orbits") == test_reply_number(&list, "/stats/orbits"));
}

TEST(orbits_say_in_words_how_they_ended) {
    static const struct {
        const char *body, *end;
    } some[] = {
        {"{" TWO ",\"mode\":1,\"amplitude\":2,\"branch\":true,\"points\":3}", "points"},
        {"{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"mode\":1,\"energy\":19.7}",
         NULL},
        {"{" DRIVEN ",\"periods\":2}", "meets"},
        {"{" TWO ",\"mode\":2,\"amplitude\":2,\"branch\":true,\"switch\":[2]}", "missing"},
        {"{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0."
         "05],\"torque\":[{\"harmonics\":[{\"amplitude\":0.06,\"omega\":0.5}]}]},\"branch\":{"
         "\"vary\":\"omega\",\"to\":1.2},\"switch\":[1]}",
         "apart"},
    };
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        OWN(test_reply, free) reply = test_post(API_OP_ORBITS, some[i].body);
        CHECK_INT(reply.status, 200);
        if (some[i].end) CHECK_TEXT(test_reply_text(&reply, "/end"), some[i].end);
        CHECK(strcmp(test_reply_text(&reply, "/end"), "reached") != 0);
        CHECK_INT(test_reply_count(&reply, "/warnings"), 1);
        CHECK(strlen(test_reply_text(&reply, "/message")) > 40);
    }
}

TEST(orbits_say_which_others_they_meet_where_their_branch_turns_back) {
    OWN(test_reply, free) reply = test_post(
        API_OP_ORBITS,
        "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0.5],"
        "\"torque\":[{\"harmonics\":[{\"amplitude\":1.02,\"omega\":0.6666666666666666}]}]},"
        "\"initial\":{\"theta\":[0.3]},\"settle\":100,\"branch\":{\"vary\":\"torque_amplitude\","
        "\"arm\":1,\"to\":0.95}}");
    CHECK_INT(reply.status, 200);
    CHECK_TEXT(test_reply_text(&reply, "/end"), "back");
    CHECK_TEXT(test_reply_text(&reply, "/bifurcations/0/kind"), "symmetry");
    CHECK(strstr(test_reply_text(&reply, "/message"), "their own mirror images") != NULL);
}

/* chains of arms of 1 m and 1 kg; s that their orbits took on the notebook's machine */
static const struct {
    int arms, mode;
    double amplitude;
    const char *more;
    double seconds;
} measured[] = {
    {1, 1, 2.9, ",\"branch\":true", 0.0040},
    {2, 1, 2, ",\"branch\":true", 0.0092},
    {2, 2, 2, "", 0.0066},
    {3, 1, 1.5, ",\"branch\":true", 0.0081},
    {5, 1, 1, ",\"branch\":true", 0.025},
    {5, 5, 0.5, ",\"branch\":true", 0.045},
    {8, 1, 0.8, ",\"branch\":true", 0.046},
    {20, 1, 0.6, "", 0.31},
    {20, 1, 0.6, ",\"branch\":true", 6.2},
    {20, 10, 0.3, "", 0.64},
    {40, 1, 0.4, "", 8.2},
};

TEST(orbits_are_estimated_within_a_factor_of_six_of_what_was_measured) {
    for (size_t i = 0; i < sizeof measured / sizeof *measured; i++) {
        char body[1200], *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1");
        struct api_limits limits;
        OWN(api_call, free) *call;
        api_limits_init(&limits);
        for (int k = 1; k < measured[i].arms; k++) at += sprintf(at, ",1");
        at += sprintf(at, "],\"mass\":[1");
        for (int k = 1; k < measured[i].arms; k++) at += sprintf(at, ",1");
        at += sprintf(at, "],\"parent\":[0");
        for (int k = 1; k < measured[i].arms; k++) at += sprintf(at, ",%d", k);
        at += sprintf(at, "]},\"mode\":%d,\"amplitude\":%g%s}", measured[i].mode,
                      measured[i].amplitude, measured[i].more);
        struct api_request request = {.op = API_OP_ORBITS,
                                      .content_type = "application/json",
                                      .body = body,
                                      .body_bytes = (size_t)(at - body)};
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, 1 << 20);
        REQUIRE(api_call_new(&call, &limits) == PEND_OK);
        CHECK_INT(api_call_open(call, &request, &out), API_MORE);
        double ratio = api_call_cost(call) / measured[i].seconds;
        CHECK_SAYING(ratio > 1.0 / 6 && ratio < 6, "%d arms: %g of what was measured",
                     measured[i].arms, ratio);
    }
}

TEST(orbits_come_as_tables_too) {
    static const char body[] =
        "{" TWO ",\"mode\":1,\"amplitude\":0.5,\"branch\":true,\"rows\":\"orbits\",\"points\":9}";
    static const struct {
        const char *accept, *text;
    } rows[] = {
        {"text/csv",
         "energy,period,amplitude_1,amplitude_2,phi_1,phi_2,phid_1,phid_2,stable,closure,"
         "multipliers_re_1,"},
        {"application/x-ndjson", "{\"energy\":"},
        {"application/x-npz", "multipliers.npy"},
        {"application/x-npz", "amplitude.npy"},
        {"application/x-matlab-data", ""},
        {"application/octet-stream", ""},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        OWN(test_reply, free) reply = test_post_as(API_OP_ORBITS, body, rows[i].accept, NULL);
        CHECK_INT(reply.status, 200);
        CHECK_SAYING(memmem(reply.out.data, reply.out.bytes, rows[i].text, strlen(rows[i].text)),
                     "%s lacks %s: %.300s", rows[i].accept, rows[i].text, reply.out.data);
    }
}

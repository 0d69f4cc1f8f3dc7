/* Tests of the derivatives of an ensemble's members: they equal those of each member's trajectory,
 * bit for bit, for ideal and real pendulums; every representation; members that fail; refusals.
 * Leaves to others: the derivatives themselves (core/derivatives/test_derivatives), ranges of
 * members and failing allocations (test_op_ensembles, api/call/test_faults).
 * Invariant: requests are texts as clients send them. */
#include "api/op/ensemble/member_derived.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* arm 2 is at the pivot, so that the stored order is not the caller's */
#define PENDULUM                                                                                   \
    "\"pendulum\":{\"length\":[%s,1],\"mass\":[1,%s],\"parent\":[2,0],\"gravity\":9.5%s}"
#define REAL ",\"damping\":[0.1,0],\"torque\":[0,{\"harmonics\":[{\"amplitude\":0.5,\"omega\":3}]}]"
#define BY                                                                                         \
    "\"derivatives\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":2},"             \
    "{\"vary\":\"gravity\"},{\"vary\":\"mass\",\"arm\":2}]"
#define GRID                                                                                       \
    "\"grid\":[{\"vary\":\"length\",\"arm\":1,\"start\":1,\"stop\":1.5,\"count\":2},"              \
    "{\"vary\":\"mass\",\"arm\":2,\"start\":2,\"stop\":3,\"count\":2}],"                           \
    "\"initial\":{\"theta\":[1,0.5],\"thetad\":[0,-1]}"

static struct test_reply posted(enum api_op_id op, const char *length, const char *mass, int real,
                                const char *more) {
    char body[1500];
    snprintf(body, sizeof body, "{" PENDULUM ",%s}", length, mass, real ? REAL : "", more);
    return test_post(op, body);
}

static double number_at(const struct test_reply *reply, const char *name, const int index[],
                        int axes) {
    char pointer[100], *at = stpcpy(stpcpy(pointer, "/derivatives/"), name);
    for (int a = 0; a < axes; a++) at += snprintf(at, 8, "/%d", index[a]);
    return test_reply_number(reply, pointer);
}

/* the numbers of member m equal those of a trajectory at `instants` instants, whose last is a final
 * state */
static void check_member(const struct test_reply *all, const char *name, int m,
                         const struct test_reply *one, const char *of, int instants, int final) {
    for (int i = final ? instants - 1 : 0; i < instants; i++)
        for (int k = 0; k < 2; k++)
            for (int j = 0; j < 4; j++) {
                const int here[3] = {final ? m : m * instants + i, k, j}, there[3] = {i, k, j};
                double got = number_at(all, name, here, 3), want = number_at(one, of, there, 3);
                CHECK_SAYING(got == want && isfinite(got), "%s of member %d: %.17g, not %.17g",
                             name, m, got, want);
            }
}

TEST(members_have_the_derivatives_of_their_trajectories) {
    static const char *const lengths[] = {"1", "1.5"}, *const masses[] = {"2", "3"};
    for (int real = 0; real < 2; real++) {
        OWN(test_reply, free) last = posted(
            API_OP_ENSEMBLES, "2", "2", real,
            GRID "," BY ",\"start\":0.5,\"duration\":1.5,\"observables\":[\"final\",\"flips\"]");
        OWN(test_reply, free) rows =
            posted(API_OP_ENSEMBLES, "2", "2", real,
                   GRID "," BY ",\"times\":[0.5,1,2],\"observables\":[\"trajectory\"],\"output\":["
                        "\"theta\",\"phid\",\"lambda\"]");
        CHECK_INT(last.status, 200);
        CHECK_INT(rows.status, 200);
        for (int m = 0; m < 4; m++) {
            OWN(test_reply, free) one =
                posted(API_OP_TRAJECTORIES, lengths[m % 2], masses[m / 2], real,
                       "\"initial\":{\"theta\":[1,0.5],\"thetad\":[0,-1]},\"times\":[0.5,1,2]," BY);
            CHECK_INT(one.status, 200);
            check_member(&last, "final_phi", m, &one, "phi", 3, 1);
            check_member(&last, "final_phid", m, &one, "phid", 3, 1);
            check_member(&rows, "theta", m, &one, "phi", 3, 0);
            check_member(&rows, "phid", m, &one, "phid", 3, 0);
            check_member(&rows, "lambda", m, &one, "lambda", 3, 0);
        }
        CHECK_INT(test_reply_count(&last, "/derivatives"), 2);
        CHECK_INT(test_reply_count(&rows, "/derivatives"), 3);
    }
}

TEST(members_on_a_cart_have_the_derivatives_of_their_trajectories) {
    static const char pendulum[] =
        "{\"pendulum\":{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1],\"pivot\":{\"cart\":{"
        "\"mass\":2,\"angle\":0.3}}},";
    static const char by[] = "\"derivatives\":[{\"vary\":\"mass\",\"arm\":\"cart\"},{\"vary\":"
                             "\"gravity\"}]}";
    static const char *const names[] = {"cart_x", "cart_v", "final_phi", "phi"};
    char body[3][500];
    struct test_reply reply[3];
    snprintf(
        body[0], sizeof body[0],
        "%s\"states\":[{\"theta\":[1,2]}],\"duration\":1,\"observables\":[\"final\",\"cart\"],%s",
        pendulum, by);
    snprintf(body[1], sizeof body[1],
             "%s\"states\":[{\"theta\":[1,2]}],\"times\":[0,1],\"observables\":[\"trajectory\"],"
             "\"output\":[\"phi\",\"cart\"],%s",
             pendulum, by);
    snprintf(body[2], sizeof body[2],
             "%s\"initial\":{\"theta\":[1,2]},\"times\":[0,1],\"output\":[\"phi\",\"cart\"],%s",
             pendulum, by);
    for (int i = 0; i < 3; i++) {
        reply[i] = test_post(i < 2 ? API_OP_ENSEMBLES : API_OP_TRAJECTORIES, body[i]);
        CHECK_SAYING(reply[i].status == 200, "%s", reply[i].out.data);
    }
    for (int j = 0; j < 2; j++) {
        const int first[] = {0, j}, last[] = {1, j}, arm[] = {0, 1, j}, end[] = {1, 1, j};
        for (int i = 0; i < 2; i++) {
            double want = number_at(&reply[2], names[i], last, 2);
            CHECK(fabs(want) > 1e-3);
            CHECK(number_at(&reply[0], names[i], first, 2) == want);
            CHECK(number_at(&reply[1], names[i], last, 2) == want);
        }
        double want = number_at(&reply[2], "phi", end, 3);
        CHECK(fabs(want) > 1e-3);
        CHECK(number_at(&reply[0], "final_phi", arm, 3) == want);
        CHECK(number_at(&reply[1], "phi", end, 3) == want);
    }
    for (int i = 0; i < 3; i++) test_reply_free(&reply[i]);
}

#define FREE "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
#define STATES "\"states\":[{\"theta\":[1,2]},{},{\"theta\":[0.1,0]}],"

TEST(members_derivatives_have_an_axis_in_every_representation) {
    static const struct {
        const char *accept, *text;
    } rows[] = {
        {"text/csv", "derivatives_final_phi_2_2,derivatives_final_phid_1_1"},
        {"application/x-ndjson", "\"derivatives\":{\"final_phi\":[["},
        {"application/x-npz", "derivatives_final_phid.npy"},
        {"application/x-npz", "'shape': (3, 2, 2), }"},
        {"application/x-matlab-data", ""},
        {"application/octet-stream", ""},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        OWN(test_reply, free) reply = test_post_as(
            API_OP_ENSEMBLES,
            FREE STATES "\"duration\":1,\"derivatives\":[{\"vary\":\"gravity\"},{\"vary\":\"phi\","
                        "\"arm\":1}]}",
            rows[i].accept, NULL);
        CHECK_INT(reply.status, 200);
        CHECK_SAYING(memmem(reply.out.data, reply.out.bytes, rows[i].text, strlen(rows[i].text)),
                     "%s lacks %s", rows[i].accept, rows[i].text);
    }
}

TEST(members_that_fail_have_no_derivatives_and_leave_the_others_alone) {
    // about every fourth length is drawn negative, and is invalid
    OWN(test_reply, free) reply =
        test_post(API_OP_ENSEMBLES, FREE
                  "\"random\":{\"count\":20,\"seed\":3,\"draw\":[{\"vary\":\"length\",\"arm\":1,"
                  "\"distribution\":\"normal\",\"mean\":1,\"deviation\":1.5}]},\"duration\":1,"
                  "\"derivatives\":[{\"vary\":\"gravity\"}]}");
    int failed = 0;
    CHECK_INT(reply.status, 200);
    for (int m = 0; m < 20; m++) {
        char pointer[32];
        const int index[3] = {m, 0, 0};
        snprintf(pointer, sizeof pointer, "/status/%d", m);
        int bad = test_reply_number(&reply, pointer) != 0;
        double slope = number_at(&reply, "final_phi", index, 3);
        CHECK(bad ? isnan(slope) : fabs(slope) > 1e-3);
        failed += bad;
    }
    CHECK(failed > 2 && failed < 12);
    CHECK_INT((long)test_reply_number(&reply, "/stats/failed"), failed);
}

TEST(members_whose_derivatives_overflow_keep_their_motion_and_say_so) {
    // a pendulum of centimetres moves chaotically: neighbours diverge as about e^(40 t)
    OWN(test_reply, free) reply = test_post(
        API_OP_ENSEMBLES,
        "{\"pendulum\":{\"length\":[0.01,0.01],\"mass\":[1,1],\"parent\":[0,1]},\"states\":["
        "{\"theta\":[0,0]},{\"theta\":[2,2.5]}],\"times\":[0,1,60],\"observables\":["
        "\"trajectory\"],\"output\":[\"theta\"],\"derivatives\":[{\"vary\":\"theta\",\"arm\":1}]}");
    CHECK_INT(reply.status, 200);
    for (int row = 0; row < 6; row++) {
        char pointer[32];
        const int index[3] = {row, 0, 0};
        snprintf(pointer, sizeof pointer, "/status/%d", row);
        double slope = fabs(number_at(&reply, "theta", index, 3));
        int over = row == 5;
        CHECK_SAYING((test_reply_number(&reply, pointer) != 0) == over, "row %d: %s", row,
                     reply.out.data);
        CHECK(over ? isnan(slope) : row == 4 ? slope > 1e4 : slope <= 2);
        snprintf(pointer, sizeof pointer, "/theta/%d/0", row);
        CHECK((test_reply_number(&reply, pointer) != 0) == (row > 2));
    }
    CHECK_INT((long)test_reply_number(&reply, "/stats/failed"), 1);
}

TEST(members_whose_outputs_overflow_have_no_derivatives) {
    // the memory of a range is not cleared before use: its old contents must not appear
    static const char *const masses[] = {"1", "1e307"};
    for (int i = 0; i < 2; i++) {
        char body[300];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[100],\"mass\":[%s],\"parent\":[0]},\"states\":["
                 "{\"theta\":[0.5]},{\"theta\":[0.6]}],\"times\":[0,1,2],\"observables\":["
                 "\"trajectory\"],\"output\":[\"theta\",\"energy\"],\"derivatives\":[{"
                 "\"vary\":\"theta\",\"arm\":1}]}",
                 masses[i]);
        OWN(test_reply, free) reply = test_post(API_OP_ENSEMBLES, body);
        CHECK_INT(reply.status, 200);
        for (int row = 0; row < 6; row++) {
            char pointer[32];
            const int index[3] = {row, 0, 0};
            snprintf(pointer, sizeof pointer, "/status/%d", row);
            CHECK_INT((long)test_reply_number(&reply, pointer), i);
            CHECK(isnan(number_at(&reply, "theta", index, 3)) == i);
        }
    }
}

TEST(members_derivatives_count_in_the_estimates) {
    // a thousand parameters for as many members take minutes
    static char body[60000];
    char *at =
        body + sprintf(body, FREE "\"random\":{\"count\":1000000,\"draw\":[{\"vary\":"
                                  "\"theta\",\"arm\":1,\"distribution\":\"uniform\","
                                  "\"low\":-1,\"high\":1}]},\"duration\":10,\"derivatives\":[");
    for (int i = 0; i < 1000; i++) at += sprintf(at, "%s{\"vary\":\"gravity\"}", i ? "," : "");
    strcpy(at, "]}");
    OWN(test_reply, free) reply = test_post(API_OP_ENSEMBLES, body);
    CHECK_INT(reply.status, 422);
    CHECK(test_reply_has_fault(&reply, "", "limit"));
}

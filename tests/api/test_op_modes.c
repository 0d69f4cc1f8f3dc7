#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define DOUBLE "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"
#define TRIPLE "\"pendulum\":{\"length\":[2,2,2],\"mass\":[3,3,3],\"parent\":[0,1,1],\"gravity\":10}"
#define MIXED "\"pendulum\":{\"length\":[0.7,1,0.9,0.3],\"mass\":[2,1,3,0.5],\"parent\":[2,0,2,1]}"

/* the largest difference from n numbers in an array */
static double gap_of(const struct test_reply *reply, const char *array, int n, const double want[]) {
    double gap = test_reply_count(reply, array) == n ? 0 : INFINITY;
    for (int i = 0; i < n; i++) {
        char pointer[60];
        snprintf(pointer, sizeof pointer, "%s/%d", array, i);
        gap = fmax(gap, fabs(test_reply_number(reply, pointer) - want[i]));
    }
    return gap;
}

TEST(the_papers_double_pendulum_has_its_modes) {
    struct test_reply reply = test_post(API_OP_MODES, "{" DOUBLE "}");
    double w = sqrt(9.81), omega[] = {w * sqrt(2 - sqrt(2)), w * sqrt(2 + sqrt(2))};
    CHECK_INT(reply.status, 200);
    CHECK(gap_of(&reply, "/omega", 2, omega) < 1e-14 * omega[1]);
    CHECK(gap_of(&reply, "/vectors/0", 2, (double[]){1, sqrt(2)}) < 1e-14);
    CHECK(gap_of(&reply, "/vectors/1", 2, (double[]){1, -sqrt(2)}) < 1e-14);
    CHECK(gap_of(&reply, "/mode", 2, (double[]){1, 2}) == 0);
    CHECK(fabs(test_reply_number(&reply, "/frequency/0") * test_reply_number(&reply, "/period/0") - 1) < 1e-15);
    CHECK(test_reply_number(&reply, "/identity/relative_difference") < 1e-14);
    CHECK(fabs(test_reply_number(&reply, "/identity/length_total_over_g") - 2 / 9.81) < 1e-16);
    test_reply_free(&reply);
}

TEST(the_papers_non_standard_triple_has_its_modes) {
    struct test_reply reply = test_post(API_OP_MODES, "{" TRIPLE ",\"normalize\":\"first\"}");
    double w = sqrt(5), r = sqrt(1.5), omega[] = {w * sqrt(3 - sqrt(6)), w, w * sqrt(3 + sqrt(6))};
    CHECK(gap_of(&reply, "/omega", 3, omega) < 1e-14 * omega[2]);
    CHECK(gap_of(&reply, "/vectors/0", 3, (double[]){1, r, r}) < 1e-14);
    CHECK(gap_of(&reply, "/vectors/1", 3, (double[]){0, 1, -1}) < 1e-14);
    CHECK(gap_of(&reply, "/vectors/2", 3, (double[]){1, -r, -r}) < 1e-14);
    test_reply_free(&reply);
}

static double matrix_at(const struct test_reply *reply, const char *name, int i, int j) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, "/%s/%d/%d", name, i, j);
    return test_reply_number(reply, pointer);
}

TEST(matrices_and_vectors_are_in_the_callers_order) {
    struct test_reply reply =
        test_post(API_OP_MODES, "{" MIXED ",\"include\":[\"B\",\"A\",\"S\",\"M\"],\"normalize\":\"mass\"}");
    CHECK_INT(reply.status, 200);
    double eigen = 0, mass = 0, inverse = 0;
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 4; i++) {
            char pointer[60];
            snprintf(pointer, sizeof pointer, "/omega/%d", k);
            double omega = test_reply_number(&reply, pointer), a = 0, sb = 0, vmv = 0;
            for (int j = 0; j < 4; j++) {
                a += matrix_at(&reply, "A", i, j) * matrix_at(&reply, "vectors", k, j);
                sb += matrix_at(&reply, "S", k, j) * matrix_at(&reply, "B", i, j);
                for (int p = 0; p < 4; p++)
                    vmv += matrix_at(&reply, "vectors", k, j) * matrix_at(&reply, "M", j, p) *
                           matrix_at(&reply, "vectors", i, p);
            }
            eigen = fmax(eigen, fabs(a - omega * omega * matrix_at(&reply, "vectors", k, i)));
            inverse = fmax(inverse, fabs(sb - (i == k)));
            mass = fmax(mass, fabs(vmv - (i == k)));
        }
    CHECK(inverse == 0);
    CHECK_RESIDUAL(eigen, 1e-11, "A v = omega^2 v");
    CHECK_RESIDUAL(mass, 1e-14, "v^T M v = 1");
    test_reply_free(&reply);
}

TEST(max_makes_the_largest_entry_one) {
    struct test_reply reply = test_post(API_OP_MODES, "{" DOUBLE ",\"normalize\":\"max\"}");
    CHECK(gap_of(&reply, "/vectors/0", 2, (double[]){1 / sqrt(2), 1}) < 1e-14);
    test_reply_free(&reply);
}

TEST(a_selection_is_part_of_all_modes) {
    static const struct {
        const char *select;
        int first, count;
    } cases[] = {{"\"all\"", 1, 4},
                 {"{\"slowest\":2}", 1, 2},
                 {"{\"fastest\":3}", 2, 3},
                 {"{\"fastest\":4}", 1, 4},
                 {"{\"from\":0,\"to\":1000}", 1, 4},
                 {"{\"from\":3,\"to\":6}", 2, 1},
                 {"{\"from\":1000,\"to\":1001}", 1, 0}};
    struct test_reply all = test_post(API_OP_MODES, "{" MIXED "}");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char body[300], pointer[60];
        snprintf(body, sizeof body, "{" MIXED ",\"select\":%s}", cases[i].select);
        struct test_reply some = test_post(API_OP_MODES, body);
        CHECK_INT(some.status, 200);
        CHECK_SAYING(test_reply_count(&some, "/omega") == cases[i].count, "%s gives %.200s", cases[i].select,
                     some.out.data);
        CHECK_INT(test_reply_count(&some, "/vectors"), cases[i].count);
        CHECK_INT(test_reply_count(&some, "/identity") > 0, i == 0);
        for (int k = 0; k < cases[i].count; k++) {
            snprintf(pointer, sizeof pointer, "/omega/%d", cases[i].first - 1 + k);
            double want = test_reply_number(&all, pointer);
            snprintf(pointer, sizeof pointer, "/omega/%d", k);
            CHECK(test_reply_number(&some, pointer) == want);
            snprintf(pointer, sizeof pointer, "/mode/%d", k);
            CHECK(test_reply_number(&some, pointer) == cases[i].first + k);
            CHECK(matrix_at(&some, "vectors", k, 3) == matrix_at(&all, "vectors", cases[i].first - 1 + k, 3));
        }
        test_reply_free(&some);
    }
    test_reply_free(&all);
}

TEST(vectors_can_be_left_out) {
    struct test_reply reply = test_post(API_OP_MODES, "{" DOUBLE ",\"vectors\":false}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/vectors"), -1);
    CHECK_INT(test_reply_count(&reply, "/omega"), 2);
    test_reply_free(&reply);
}

TEST(amplitudes_and_phases_rebuild_the_start) {
    static const char body[] = "{" MIXED ",\"initial\":{\"theta\":[0.1,-0.2,0.3,0.05],\"thetad\":[1,0.5,-1,0.2]}}";
    static const double theta[] = {0.1, -0.2, 0.3, 0.05}, rate[] = {1, 0.5, -1, 0.2};
    struct test_reply reply = test_post(API_OP_MODES, body);
    double gap = 0;
    for (int i = 0; i < 4; i++) {
        double angle = 0, velocity = 0;
        for (int k = 0; k < 4; k++) {
            char pointer[60];
            snprintf(pointer, sizeof pointer, "/amplitude/%d", k);
            double amplitude = test_reply_number(&reply, pointer);
            snprintf(pointer, sizeof pointer, "/phase/%d", k);
            double phase = test_reply_number(&reply, pointer);
            snprintf(pointer, sizeof pointer, "/omega/%d", k);
            double omega = test_reply_number(&reply, pointer), v = matrix_at(&reply, "vectors", k, i);
            angle += amplitude * v * cos(phase);
            velocity -= amplitude * v * omega * sin(phase);
        }
        gap = fmax(gap, fmax(fabs(angle - theta[i]), fabs(velocity - rate[i])));
    }
    CHECK_RESIDUAL(gap, 1e-13, "the start as a sum of modes");
    test_reply_free(&reply);
    reply = test_post(API_OP_MODES, "{" DOUBLE ",\"initial\":{\"mode\":2,\"amplitude\":0.2},\"vectors\":false,"
                                    "\"select\":{\"fastest\":1}}");
    CHECK(gap_of(&reply, "/amplitude", 1, (double[]){0.2 / sqrt(2)}) < 1e-14);
    test_reply_free(&reply);
}

TEST(faults_of_modes_have_their_pointers) {
    static const struct {
        const char *body, *pointer, *piece;
    } bad[] = {
        {"{" DOUBLE ",\"select\":\"some\"}", "/select", "must be one of \"all\", got the text \"some\""},
        {"{" DOUBLE ",\"select\":3}", "/select", "got 3"},
        {"{" DOUBLE ",\"select\":{}}", "/select", "must be \"all\", or have one of"},
        {"{" DOUBLE ",\"select\":{\"slowest\":3}}", "/select/slowest", "must be a whole number from 1 to 2, got 3"},
        {"{" DOUBLE ",\"select\":{\"fastest\":0}}", "/select/fastest", "got 0"},
        {"{" DOUBLE ",\"select\":{\"slowest\":1,\"fastest\":1}}", "/select", "have one of"},
        {"{" DOUBLE ",\"select\":{\"from\":2,\"to\":1}}", "/select/to", "must not be below from (2 rad/s), got 1"},
        {"{" DOUBLE ",\"select\":{\"from\":2}}", "/select/to", "is missing"},
        {"{" DOUBLE ",\"select\":{\"from\":-2,\"to\":1}}", "/select/from", "at least 0 rad/s, got -2"},
        {"{" DOUBLE ",\"select\":{\"slow\":2,\"slowest\":1}}", "/select/slow", "not a known field"},
        {"{" DOUBLE ",\"vectors\":1}", "/vectors", "must be true or false, got 1"},
        {"{" DOUBLE ",\"normalize\":\"maximum\"}", "/normalize", "must be one of \"first\", \"mass\", \"max\""},
        {"{" DOUBLE ",\"include\":\"A\"}", "/include", "must be an array of names"},
        {"{" DOUBLE ",\"include\":[\"A\",\"Q\"]}", "/include/1", "must be one of \"A\", \"M\", \"S\", \"B\""},
        {"{" DOUBLE ",\"include\":[\"A\",\"A\"]}", "/include/1", "is in the list already"},
        {"{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]],\"gravity\":0}}", "/pendulum",
         "finding the modes needs a gravity greater than 0, got 0"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_REFUSED(API_OP_MODES, bad[i].body, bad[i].pointer, bad[i].piece);
}

TEST(limits_of_modes_are_named) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.mode_arms = 1;
    struct test_reply reply = test_post_as(API_OP_MODES, "{" DOUBLE "}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/pendulum", "(the limit max-mode-arms)"));
    test_reply_free(&reply);
    api_limits_init(&limits);
    limits.matrix_arms = 1;
    reply = test_post_as(API_OP_MODES, "{" DOUBLE ",\"include\":[\"S\"]}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/include", "(the limit max-matrix-arms)"));
    test_reply_free(&reply);
    api_limits_init(&limits);
    limits.answer_bytes = 2100;
    reply = test_post_as(API_OP_MODES, "{" DOUBLE "}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "", "more than the limit max-answer-bytes of 2100"));
    test_reply_free(&reply);
}

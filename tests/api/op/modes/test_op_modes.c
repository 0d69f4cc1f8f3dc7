#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define DOUBLE "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"
#define TRIPLE                                                                                     \
    "\"pendulum\":{\"length\":[2,2,2],\"mass\":[3,3,3],\"parent\":[0,1,1],\"gravity\":10}"
#define MIXED "\"pendulum\":{\"length\":[0.7,1,0.9,0.3],\"mass\":[2,1,3,0.5],\"parent\":[2,0,2,1]}"

/* the largest difference from n numbers in an array */
static double gap_of(const struct test_reply *reply, const char *array, int n,
                     const double want[]) {
    double gap = test_reply_count(reply, array) == n ? 0 : INFINITY;
    for (int i = 0; i < n; i++) {
        char pointer[60];
        snprintf(pointer, sizeof pointer, "%s/%d", array, i);
        gap = fmax(gap, fabs(test_reply_number(reply, pointer) - want[i]));
    }
    return gap;
}

TEST(the_papers_double_pendulum_has_its_modes) {
    OWN(test_reply, free) reply = test_post(API_OP_MODES, "{" DOUBLE "}");
    double w = sqrt(9.81), omega[] = {w * sqrt(2 - sqrt(2)), w * sqrt(2 + sqrt(2))};
    CHECK_INT(reply.status, 200);
    CHECK(gap_of(&reply, "/omega", 2, omega) < 1e-14 * omega[1]);
    CHECK(gap_of(&reply, "/vectors/0", 2, (double[]){1, sqrt(2)}) < 1e-14);
    CHECK(gap_of(&reply, "/vectors/1", 2, (double[]){1, -sqrt(2)}) < 1e-14);
    CHECK(gap_of(&reply, "/mode", 2, (double[]){1, 2}) == 0);
    CHECK(fabs(test_reply_number(&reply, "/frequency/0") * test_reply_number(&reply, "/period/0") -
               1) < 1e-15);
    CHECK(test_reply_number(&reply, "/identity/relative_difference") < 1e-14);
    CHECK(fabs(test_reply_number(&reply, "/identity/length_total_over_g") - 2 / 9.81) < 1e-16);
}

TEST(the_papers_non_standard_triple_has_its_modes) {
    OWN(test_reply, free) reply = test_post(API_OP_MODES, "{" TRIPLE ",\"normalize\":\"first\"}");
    double w = sqrt(5), r = sqrt(1.5), omega[] = {w * sqrt(3 - sqrt(6)), w, w * sqrt(3 + sqrt(6))};
    CHECK(gap_of(&reply, "/omega", 3, omega) < 1e-14 * omega[2]);
    CHECK(gap_of(&reply, "/vectors/0", 3, (double[]){1, r, r}) < 1e-14);
    CHECK(gap_of(&reply, "/vectors/1", 3, (double[]){0, 1, -1}) < 1e-14);
    CHECK(gap_of(&reply, "/vectors/2", 3, (double[]){1, -r, -r}) < 1e-14);
}

static double matrix_at(const struct test_reply *reply, const char *name, int i, int j) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, "/%s/%d/%d", name, i, j);
    return test_reply_number(reply, pointer);
}

TEST(matrices_and_vectors_are_in_the_callers_order) {
    OWN(test_reply, free) reply = test_post(
        API_OP_MODES, "{" MIXED ",\"include\":[\"B\",\"A\",\"S\",\"M\"],\"normalize\":\"mass\"}");
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
}

TEST(max_makes_the_largest_entry_one) {
    OWN(test_reply, free) reply = test_post(API_OP_MODES, "{" DOUBLE ",\"normalize\":\"max\"}");
    CHECK(gap_of(&reply, "/vectors/0", 2, (double[]){1 / sqrt(2), 1}) < 1e-14);
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
    OWN(test_reply, free) all = test_post(API_OP_MODES, "{" MIXED "}");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char body[300], pointer[60];
        snprintf(body, sizeof body, "{" MIXED ",\"select\":%s}", cases[i].select);
        OWN(test_reply, free) some = test_post(API_OP_MODES, body);
        CHECK_INT(some.status, 200);
        CHECK_SAYING(test_reply_count(&some, "/omega") == cases[i].count, "%s gives %.200s",
                     cases[i].select, some.out.data);
        CHECK_INT(test_reply_count(&some, "/vectors"), cases[i].count);
        CHECK_INT(test_reply_count(&some, "/identity") > 0, i == 0);
        for (int k = 0; k < cases[i].count; k++) {
            snprintf(pointer, sizeof pointer, "/omega/%d", cases[i].first - 1 + k);
            double want = test_reply_number(&all, pointer);
            snprintf(pointer, sizeof pointer, "/omega/%d", k);
            CHECK(test_reply_number(&some, pointer) == want);
            snprintf(pointer, sizeof pointer, "/mode/%d", k);
            CHECK(test_reply_number(&some, pointer) == cases[i].first + k);
            CHECK(matrix_at(&some, "vectors", k, 3) ==
                  matrix_at(&all, "vectors", cases[i].first - 1 + k, 3));
        }
    }
}

TEST(vectors_can_be_left_out) {
    OWN(test_reply, free) reply = test_post(API_OP_MODES, "{" DOUBLE ",\"vectors\":false}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/vectors"), -1);
    CHECK_INT(test_reply_count(&reply, "/omega"), 2);
}

TEST(amplitudes_and_phases_rebuild_the_start) {
    static const char body[] =
        "{" MIXED ",\"initial\":{\"theta\":[0.1,-0.2,0.3,0.05],\"thetad\":[1,0.5,-1,0.2]}}";
    static const double theta[] = {0.1, -0.2, 0.3, 0.05}, rate[] = {1, 0.5, -1, 0.2};
    OWN(test_reply, free) reply = test_post(API_OP_MODES, body);
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
            double omega = test_reply_number(&reply, pointer),
                   v = matrix_at(&reply, "vectors", k, i);
            angle += amplitude * v * cos(phase);
            velocity -= amplitude * v * omega * sin(phase);
        }
        gap = fmax(gap, fmax(fabs(angle - theta[i]), fabs(velocity - rate[i])));
    }
    CHECK_RESIDUAL(gap, 1e-13, "the start as a sum of modes");
    test_reply_free(&reply);
    reply = test_post(API_OP_MODES,
                      "{" DOUBLE ",\"initial\":{\"mode\":2,\"amplitude\":0.2},\"vectors\":false,"
                      "\"select\":{\"fastest\":1}}");
    CHECK(gap_of(&reply, "/amplitude", 1, (double[]){0.2 / sqrt(2)}) < 1e-14);
}

/* the residual of A v = lambda v, lambda = omega^2 - growth^2, relative to the size of its terms;
 * and the number of growing modes */
static double equilibrium_residual(const struct test_reply *reply, int n, int *growing) {
    double worst = 0;
    for (int k = 0; k < n; k++) {
        char pointer[60];
        snprintf(pointer, sizeof pointer, "/omega/%d", k);
        double omega = test_reply_number(reply, pointer);
        snprintf(pointer, sizeof pointer, "/growth/%d", k);
        double growth = test_reply_number(reply, pointer);
        CHECK((omega > 0) != (growth > 0));
        *growing += growth > 0;
        for (int i = 0; i < n; i++) {
            double sum = -(omega * omega - growth * growth) * matrix_at(reply, "vectors", k, i),
                   size = fabs(sum);
            for (int j = 0; j < n; j++) {
                double term = matrix_at(reply, "A", i, j) * matrix_at(reply, "vectors", k, j);
                sum += term;
                size += fabs(term);
            }
            worst = fmax(worst, fabs(sum) / size);
        }
    }
    return worst;
}

TEST(modes_about_standing_arms_grow_and_swing) {
    OWN(test_reply, free) reply =
        test_post(API_OP_MODES,
                  "{" MIXED ",\"about\":[\"up\",\"down\",\"up\",\"down\"],\"include\":[\"A\"]}");
    CHECK_INT(reply.status, 200);
    int growing = 0;
    CHECK_RESIDUAL(equilibrium_residual(&reply, 4, &growing), 1e-14,
                   "A v = lambda v about standing arms");
    CHECK_INT(growing, 2);
    CHECK_INT(test_reply_count(&reply, "/period"), -1);
    /* (A^-1)_kk = ±l_k/g: the lengths of upright arms count as negative */
    CHECK(fabs(test_reply_number(&reply, "/identity/length_total_over_g") -
               (-0.7 + 1 - 0.9 + 0.3) / 9.81) < 1e-16);
    CHECK(test_reply_number(&reply, "/identity/relative_difference") < 1e-14);
    test_reply_free(&reply);
    /* the inverted pendulum, and two arms both inverted: they grow at the rates at which hanging
     * ones oscillate */
    reply = test_post(API_OP_MODES,
                      "{\"pendulum\":{\"L\":[2],\"m\":[1],\"S\":[[1]]},\"about\":[\"up\"]}");
    CHECK(gap_of(&reply, "/growth", 1, (double[]){sqrt(9.81 / 2)}) < 1e-15);
    CHECK(gap_of(&reply, "/omega", 1, (double[]){0}) == 0);
    test_reply_free(&reply);
    double w = sqrt(9.81), rate[] = {w * sqrt(2 + sqrt(2)), w * sqrt(2 - sqrt(2))};
    reply = test_post(API_OP_MODES, "{" DOUBLE ",\"about\":[\"up\",\"up\"]}");
    CHECK(gap_of(&reply, "/growth", 2, rate) < 1e-14);
    test_reply_free(&reply);
    /* the default is all down */
    reply = test_post(API_OP_MODES, "{" DOUBLE ",\"about\":[\"down\",\"down\"]}");
    CHECK_INT(test_reply_count(&reply, "/period"), 2);
    CHECK_INT(test_reply_count(&reply, "/growth"), -1);
}

TEST(a_start_about_standing_arms_rises_falls_and_swings) {
    /* angles from the equilibrium: arms 1 and 3 stand at theta = pi */
    static const double theta[] = {0.1, -0.2, 0.3, 0.05}, rate[] = {1, 0.5, -1, 0.2};
    OWN(test_reply, free) reply =
        test_post(API_OP_MODES,
                  "{" MIXED ",\"about\":[\"up\",\"down\",\"up\",\"down\"],\"initial\":{\"theta\":["
                  "3.241592653589793,-0.2,-2.841592653589793,0.05],\"thetad\":[1,0.5,-1,0.2]}}");
    double gap = 0;
    CHECK_INT(reply.status, 200);
    for (int i = 0; i < 4; i++) {
        double angle = 0, velocity = 0;
        for (int k = 0; k < 4; k++) {
            static const char *const names[] = {"amplitude", "phase",  "omega",
                                                "growth",    "rising", "falling"};
            double x[6], v = matrix_at(&reply, "vectors", k, i);
            for (int j = 0; j < 6; j++) {
                char pointer[60];
                snprintf(pointer, sizeof pointer, "/%s/%d", names[j], k);
                x[j] = test_reply_number(&reply, pointer);
            }
            angle += v * (x[0] * cos(x[1]) + x[4] + x[5]);
            velocity += v * (x[3] * (x[4] - x[5]) - x[0] * x[2] * sin(x[1]));
        }
        gap = fmax(gap, fmax(fabs(angle - theta[i]), fabs(velocity - rate[i])));
    }
    CHECK_RESIDUAL(gap, 1e-13, "the start about standing arms as a sum of modes");
}

TEST(modes_are_rows_of_a_table_in_other_representations) {
    static const char body[] = "{" TRIPLE ",\"initial\":{\"theta\":[0.1,0,0]}}";
    struct test_reply json = test_post(API_OP_MODES, body);
    struct test_reply csv = test_post_as(API_OP_MODES, body, "text/csv", NULL);
    CHECK_INT(csv.status, 200);
    CHECK(!strncmp(csv.out.data,
                   "mode,omega,frequency,period,amplitude,phase,vectors_1,vectors_2,vectors_3",
                   73));
    struct test_reply octets = test_post_as(API_OP_MODES, body, "application/octet-stream", NULL);
    CHECK_INT(octets.status, 200);
    REQUIRE(octets.out.bytes == 3 * 9 * sizeof(double));
    static const char *const names[] = {"mode",   "omega",     "frequency",
                                        "period", "amplitude", "phase"};
    for (int k = 0; k < 3; k++) {
        double row[9];
        memcpy(row, octets.out.data + k * sizeof row, sizeof row);
        for (int c = 0; c < 6; c++) {
            char pointer[60];
            snprintf(pointer, sizeof pointer, "/%s/%d", names[c], k);
            CHECK(row[c] == test_reply_number(&json, pointer));
        }
        for (int i = 0; i < 3; i++) CHECK(row[6 + i] == matrix_at(&json, "vectors", k, i));
    }
    test_reply_free(&octets);
    test_reply_free(&csv);
    test_reply_free(&json);
    static const char *const types[] = {"text/csv", "application/x-ndjson", "application/x-npz",
                                        "application/x-matlab-data", "application/octet-stream"};
    for (int i = 0; i < 5; i++) {
        struct test_reply none = test_post_as(
            API_OP_MODES, "{" DOUBLE ",\"select\":{\"from\":99,\"to\":100}}", types[i], NULL);
        CHECK_INT(none.status, 200);
        test_reply_free(&none);
        OWN(test_reply, free) refused =
            test_post_as(API_OP_MODES, "{" DOUBLE ",\"include\":[\"A\"]}", types[i], NULL);
        CHECK(test_reply_has_fault(&refused, "/include",
                                   "matrices are returned only in application/json"));
    }
}

TEST(a_multiple_frequency_that_is_cut_keeps_its_basis) {
    static const char star[] =
        "{\"pendulum\":{\"length\":[1,1,1,1,1],\"mass\":[1,1,1,1,1],\"parent\":[0,1,1,1,1]}";
    char body[300];
    snprintf(body, sizeof body, "%s}", star);
    OWN(test_reply, free) all = test_post(API_OP_MODES, body);
    for (int count = 1; count <= 5; count++) {
        snprintf(body, sizeof body, "%s,\"select\":{\"slowest\":%d}}", star, count);
        OWN(test_reply, free) some = test_post(API_OP_MODES, body);
        for (int k = 0; k < count; k++)
            for (int i = 0; i < 5; i++)
                CHECK(fabs(matrix_at(&some, "vectors", k, i) - matrix_at(&all, "vectors", k, i)) <
                      1e-14);
    }
}

/* a request for a tree of `n` different arms, three per joint */
static void body_of(struct api_buffer *body, int n, const char *more) {
    char piece[40];
    api_buffer_init(body, 1 << 20);
    for (int list = 0; list < 3; list++) {
        static const char *const names[] = {"{\"pendulum\":{\"length\":[", "],\"mass\":[",
                                            "],\"parent\":["};
        REQUIRE(api_buffer_text(body, names[list]) == PEND_OK);
        for (int i = 0; i < n; i++) {
            if (list < 2)
                snprintf(piece, sizeof piece, "%s%.6f", i ? "," : "",
                         1 + fmod((list + 1) * 0.6180339887 * i, 1));
            if (list == 2) snprintf(piece, sizeof piece, "%s%d", i ? "," : "", (i + 2) / 3);
            REQUIRE(api_buffer_text(body, piece) == PEND_OK);
        }
    }
    REQUIRE(api_buffer_text(body, "]}") == PEND_OK && api_buffer_text(body, more) == PEND_OK &&
            api_buffer_add(body, "}", 2) == PEND_OK);
    body->bytes--;
}

/* a clock that advances by a part of a turn at each query */
static double ticking(void *context) { return *(double *)context += 1e-3; }

TEST(a_search_comes_back_every_turn) {
    OWN(api_call, free) *call = NULL;
    struct api_limits limits;
    OWN(api_buffer, clear) out, body;
    double time = 0;
    int runs = 0;
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 26);
    body_of(&body, 300, "");
    struct api_request request = {.op = API_OP_MODES,
                                  .content_type = "application/json",
                                  .body = body.data,
                                  .body_bytes = body.bytes};
    REQUIRE(api_call_new(&call, &limits) == PEND_OK);
    api_call_clock(call, ticking, &time);
    CHECK_INT(api_call_open(call, &request, &out), API_MORE);
    CHECK(api_call_cost(call) > 0);
    while (api_call_run(call, &out) == API_MORE) runs++;
    CHECK_INT(api_call_answer(call).status, 200);
    CHECK_SAYING(runs > 20, "300 arms in %d runs", runs);
    api_call_free(&call);
    /* cancelled in the middle of its search, it ends at once */
    out.bytes = 0;
    REQUIRE(api_call_new(&call, &limits) == PEND_OK);
    api_call_clock(call, ticking, &time);
    CHECK_INT(api_call_open(call, &request, &out), API_MORE);
    for (int i = 0; i < 3; i++) CHECK_INT(api_call_run(call, &out), API_MORE);
    CHECK_INT(api_call_stop(call, 503, "stopped", &out), API_DONE);
    CHECK_INT(api_call_answer(call).status, 503);
}

TEST(all_modes_of_a_thousand_arms_are_the_same_in_json_and_in_doubles) {
    enum { N = 1000, COLUMNS = 4 + N };
    OWN(api_buffer, clear) body;
    body_of(&body, N, "");
    OWN(test_reply, free) json = test_post(API_OP_MODES, body.data);
    OWN(test_reply, free) octets =
        test_post_as(API_OP_MODES, body.data, "application/octet-stream", NULL);
    CHECK_INT(json.status, 200);
    CHECK_INT(octets.status, 200);
    CHECK(test_reply_number(&json, "/identity/relative_difference") < 1e-13);
    REQUIRE(octets.out.bytes == N * COLUMNS * sizeof(double));
    double row[COLUMNS];
    for (int k = 0; k < N; k += 37) {
        memcpy(row, octets.out.data + (size_t)k * sizeof row, sizeof row);
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/omega/%d", k);
        CHECK(row[0] == k + 1 && row[1] == test_reply_number(&json, pointer));
        for (int i = 0; i < N; i += 41) CHECK(row[4 + i] == matrix_at(&json, "vectors", k, i));
    }
}

TEST(too_much_names_the_way_out) {
    struct api_limits limits;
    OWN(api_buffer, clear) body;
    body_of(&body, 200, "");
    api_limits_init(&limits);
    limits.answer_bytes = 600000;
    OWN(test_reply, free) reply = test_post_as(API_OP_MODES, body.data, NULL, &limits);
    CHECK(test_reply_has_fault(
        &reply, "", "fewer modes by \"select\", or only the frequencies by \"vectors\": false"));
    CHECK(test_reply_has_fault(&reply, "", "application/octet-stream"));
    test_reply_free(&reply);
    reply = test_post_as(API_OP_MODES, body.data, "application/octet-stream", &limits);
    CHECK_INT(reply.status, 200);
    test_reply_free(&reply);
    limits.answer_bytes = 300000;
    reply = test_post_as(API_OP_MODES, body.data, "application/octet-stream", &limits);
    CHECK(test_reply_has_fault(&reply, "", "which take 320000 bytes during the computation"));
    test_reply_free(&reply);
    limits.mode_arms = 100;
    reply = test_post_as(API_OP_MODES, body.data, NULL, &limits);
    CHECK(test_reply_has_fault(
        &reply, "/pendulum",
        "at most 100 arms (the limit max-mode-arms) for all modes, and at most 50 modes of 200 "
        "arms; got 200 modes"));
}

/* each is refused with a reason, whatever is requested, and is no error of the server */
TEST(pendulums_beyond_what_a_double_holds_have_no_modes) {
    static const char *const bad[] = {
        "\"length\":[1e308,1],\"mass\":[1,1],\"parent\":[0,1]",
        "\"length\":[1,1e308],\"mass\":[1,1],\"parent\":[0,1]",
        "\"length\":[5e-324,1],\"mass\":[1,1],\"parent\":[0,1]",
        "\"length\":[1,1],\"mass\":[1e308,1],\"parent\":[0,1]",
        "\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1],\"gravity\":1e308",
        "\"length\":[1,5.6e-149],\"mass\":[1,2.2e136],\"parent\":[0,1]",
        "\"length\":[2.3e93,1e-160],\"mass\":[3.8e-54,44],\"parent\":[0,1]",
        "\"length\":[1,1e300,1],\"mass\":[1,1,2.9e44],\"parent\":[0,1,2]",
        "\"length\":[2,1e300],\"mass\":[2,0.1],\"parent\":[0,1]",
        "\"length\":[1,1],\"mass\":[1e-295,1e-295],\"parent\":[0,1]",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char body[256];
        snprintf(body, sizeof body, "{\"pendulum\":{%s}}", bad[i]);
        OWN(test_reply, free) reply = test_post(API_OP_MODES, body);
        CHECK_INT(reply.status, 422);
        CHECK_SAYING(memmem(reply.out.data, reply.out.bytes, "differ too much", 15) != NULL, "%s",
                     bad[i]);
    }
    /* extreme, but still possible */
    OWN(test_reply, free) good = test_post(
        API_OP_MODES, "{\"pendulum\":{\"length\":[1e100,1e-100],\"mass\":[1,1],\"parent\":[0,1]}}");
    CHECK_INT(good.status, 200);
}

TEST(limits_of_modes_are_named) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.mode_arms = 1;
    OWN(test_reply, free) reply = test_post_as(API_OP_MODES, "{" DOUBLE "}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/pendulum", "(the limit max-mode-arms)"));
    test_reply_free(&reply);
    reply = test_post_as(API_OP_MODES, "{" DOUBLE ",\"select\":{\"slowest\":1}}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/pendulum", "at most 0 modes of 2 arms"));
    test_reply_free(&reply);
    limits.mode_arms = 1.5;
    reply = test_post_as(API_OP_MODES, "{" DOUBLE ",\"select\":{\"slowest\":1}}", NULL, &limits);
    CHECK_INT(reply.status, 200);
    test_reply_free(&reply);
    api_limits_init(&limits);
    limits.matrix_arms = 1;
    reply = test_post_as(API_OP_MODES, "{" DOUBLE ",\"include\":[\"S\"]}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/include", "(the limit max-matrix-arms)"));
    test_reply_free(&reply);
    api_limits_init(&limits);
    limits.answer_bytes = 1100;
    reply = test_post_as(API_OP_MODES, "{" DOUBLE "}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "", "more than the limit max-answer-bytes of 1100"));
}

/* all kinds of answers have the same name and sign, and say whether the equilibrium is stable */
TEST(modes_say_whether_they_grow_and_where_they_are_another_motions) {
    static const struct {
        const char *body, *word; /* of the warning; NULL: there is none */
        int stable;
        double growth; /* of the first mode; NAN: it has none */
    } some[] = {
        {"\"length\":[1],\"mass\":[1],\"parent\":[0]}", NULL, 1, NAN},
        {"\"length\":[1],\"mass\":[1],\"parent\":[0]},\"about\":[\"up\"]", NULL, 0, 3.132091952673},
        {"\"arms\":[{\"length\":1,\"mass\":1,\"damping\":2}]}", NULL, 1, -1},
        {"\"arms\":[{\"length\":1,\"mass\":0,\"body\":{\"mass\":1,\"center\":[-1,0],"
         "\"inertia\":1}}]}",
         NULL, 0, 0},
        {"\"arms\":[{\"length\":1,\"mass\":1,\"friction\":{\"torque\":0.01,\"speed\":0.001}}]}",
         "dry friction", 1, -1.102564946},
        {"\"arms\":[{\"length\":1,\"mass\":1,\"friction\":{\"torque\":0.01,\"speed\":2}}]}", NULL,
         1, -0.0025},
        {"\"arms\":[{\"length\":1,\"mass\":1}],\"pivot\":{\"y\":{\"harmonics\":[{\"amplitude\":0."
         "01,\"omega\":300}]}}}",
         "shaken at up to 3 m/s", 1, 0},
        {"\"arms\":[{\"length\":1,\"mass\":1}],\"pivot\":{\"acceleration\":[3,0]}}", NULL, 1, 0},
    };
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        char body[400];
        snprintf(body, sizeof body, "{\"pendulum\":{%s}", some[i].body);
        OWN(test_reply, free) reply = test_post(API_OP_MODES, body);
        OWN(test_reply, free) table = test_post_as(API_OP_MODES, body, "text/csv", NULL);
        REQUIRE(reply.status == 200 && table.status == 200);
        CHECK(test_reply_number(&reply, "/stats/stable") == some[i].stable);
        CHECK_INT(test_reply_count(&reply, "/warnings"), some[i].word ? 1 : -1);
        if (some[i].word) {
            CHECK(strstr(test_reply_text(&reply, "/warnings/0"), some[i].word) != NULL);
            CHECK(strstr(table.out.data, some[i].word) != NULL);
        }
        double growth = test_reply_number(&reply, "/growth/0");
        if (isnan(some[i].growth))
            CHECK_INT(test_reply_count(&reply, "/growth"), -1);
        else
            CHECK_SAYING(some[i].stable ? fabs(growth - some[i].growth) < 1e-9 : growth > 0,
                         "%s grows by %.17g", some[i].body, growth);
        if (test_reply_count(&reply, "/decay") > 0)
            CHECK(growth == 0 - test_reply_number(&reply, "/decay/0"));
    }
}

TEST(modes_of_a_real_pendulum_have_decay_and_complex_shapes) {
    struct test_reply rod =
        test_post(API_OP_MODES, "{\"pendulum\":{\"length\":[0.9],\"mass\":[0],\"parent\":[0],"
                                "\"rod\":[1.7]}}");
    CHECK_INT(rod.status, 200);
    CHECK(fabs(test_reply_number(&rod, "/omega/0") - sqrt(1.5 * 9.81 / 0.9)) < 1e-14 * 4);
    CHECK(test_reply_number(&rod, "/decay/0") == 0);
    test_reply_free(&rod);
    OWN(test_reply, free) two =
        test_post(API_OP_MODES, "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1],"
                                "\"damping\":[0.1,0.2],\"stiffness\":[1,2],\"rest\":[0.3,0.1]}}");
    CHECK_INT(two.status, 200);
    CHECK_INT(test_reply_count(&two, "/vectors/im"), 2);
    CHECK(test_reply_number(&two, "/decay/1") > 0 && test_reply_number(&two, "/omega/1") > 0);
    CHECK(test_reply_number(&two, "/equilibrium/0") > -1.5707);
}

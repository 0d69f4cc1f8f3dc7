#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"

#define PAPER                                                                                      \
    "\"pendulum\":{\"L\":[2,1.5,0.75,1.25],\"m\":[1,1,1,0.1],\"S\":[[1,0,0,0],[1,1,0,0],[1,1,1,0]" \
    ",[1,1,0,1]]}"
#define TIMES "\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}"

static const char example[] = "{" PAPER "," TIMES ",\"method\":\"taylor\",\"rtol\":1e-12}";

static double at(const struct test_reply *reply, const char *name, int i, int k) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, "/%s/%d/%d", name, i, k);
    return test_reply_number(reply, pointer);
}

TEST(the_papers_example_agrees_with_the_reference) {
    struct test_paper_row row[TEST_PAPER_ROWS];
    REQUIRE(test_paper_read(row));
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, example);
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/t"), 501);
    double phi = 0, rate = 0, force = 0;
    for (int i = 0; i < TEST_PAPER_ROWS; i++) {
        char pointer[60];
        snprintf(pointer, sizeof pointer, "/t/%d", 10 * i);
        CHECK(test_reply_number(&reply, pointer) == row[i].t);
        for (int k = 0; k < 4; k++) {
            phi = fmax(phi, fabs(at(&reply, "phi", 10 * i, k) - row[i].phi[k]));
            rate = fmax(rate, fabs(at(&reply, "phid", 10 * i, k) - row[i].rate[k]));
            force = fmax(force, fabs(at(&reply, "lambda", 10 * i, k) - row[i].force[k]));
        }
    }
    CHECK_RESIDUAL(phi, 1e-9, "phi of the paper's example");
    CHECK_RESIDUAL(rate, 1e-9, "phi' of the paper's example");
    CHECK_RESIDUAL(force, 1e-9, "lambda of the paper's example");
    CHECK(test_reply_number(&reply, "/stats/steps") > 10 && reply.steps > 10);
    CHECK(test_reply_number(&reply, "/stats/energy_drift") < 1e-12);
}

TEST(csv_has_the_digits_of_json) {
    static const char *const bodies[] = {example, "{" PAPER "," TIMES
                                                  ",\"digits\":5,\"output\":[\"phi\",\"z\"]}"};
    static const int columns[] = {13, 13};
    for (int b = 0; b < 2; b++) {
        OWN(test_reply, free) json = test_post(API_OP_TRAJECTORIES, bodies[b]);
        OWN(test_reply, free) csv = test_post_as(API_OP_TRAJECTORIES, bodies[b], "text/csv", NULL);
        CHECK_INT(csv.status, 200);
        CHECK_TEXT(csv.media_type, "text/csv; charset=utf-8; header=present");
        static const char *const names[2][3] = {{"phi", "phid", "lambda"}, {"phi", "z/re", "z/im"}};
        char *line = strchr(csv.out.data, '\n') + 1;
        int rows = 0;
        for (; *line; rows++) {
            double number[13] = {0};
            int count = 0;
            do number[count++] = strtod(line, &line);
            while (*line++ == ',' && count < 13);
            if (!CHECK_INT(count, columns[b])) break;
            char pointer[60];
            snprintf(pointer, sizeof pointer, "/t/%d", rows);
            int same = number[0] == test_reply_number(&json, pointer);
            for (int k = 0; k < 12; k++)
                same &= number[k + 1] == at(&json, names[b][k / 4], rows, k % 4);
            if (!CHECK_SAYING(same, "row %d differs", rows)) break;
        }
        CHECK_INT(rows, 501);
    }
}

/* the longest run of digits, without points, in a text after its first '[' */
static int longest_mantissa(const char *text) {
    int longest = 0, digits = 0, exponent = 0;
    for (const char *p = strchr(text, '['); *p; p++) {
        if (*p == 'e') exponent = 1;
        if (strchr(",[]{}:", *p)) digits = exponent = 0;
        if (*p >= '0' && *p <= '9' && !exponent && (digits || *p != '0')) digits++;
        if (digits > longest) longest = digits;
    }
    return longest;
}

TEST(digits_are_significant_digits) {
    for (int digits = 1; digits <= 17; digits += 4) {
        char body[400];
        snprintf(body, sizeof body,
                 "{" PAPER ",\"times\":[0,0.5,1],\"output\":[\"phi\"],\"digits\":%d}", digits);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        char *stats = strstr(reply.out.data, "\"stats\"");
        REQUIRE(stats);
        *stats = 0;
        CHECK_INT(longest_mantissa(reply.out.data),
                  digits < 16 ? digits : longest_mantissa(reply.out.data));
        CHECK(longest_mantissa(reply.out.data) <= digits);
        *stats = '"';
    }
}

TEST(backwards_in_time_leads_back) {
    OWN(test_reply, free) there =
        test_post(API_OP_TRAJECTORIES, "{" PAPER ",\"times\":[0,1],\"digits\":17}");
    char body[800];
    snprintf(body, sizeof body,
             "{" PAPER
             ",\"initial\":{\"phi\":[%.17g,%.17g,%.17g,%.17g],\"phid\":[%.17g,%.17g,%.17g,%.17g]},"
             "\"times\":{\"start\":1,\"stop\":0,\"step\":0.5}}",
             at(&there, "phi", 1, 0), at(&there, "phi", 1, 1), at(&there, "phi", 1, 2),
             at(&there, "phi", 1, 3), at(&there, "phid", 1, 0), at(&there, "phid", 1, 1),
             at(&there, "phid", 1, 2), at(&there, "phid", 1, 3));
    OWN(test_reply, free) back = test_post(API_OP_TRAJECTORIES, body);
    double gap = 0;
    CHECK(test_reply_number(&back, "/t/1") == 0.5);
    for (int k = 0; k < 4; k++)
        gap = fmax(gap, fabs(at(&back, "phi", 2, k)) + fabs(at(&back, "phid", 2, k)));
    CHECK_RESIDUAL(gap, 1e-11, "there and back");
    CHECK(fabs(at(&there, "phi", 1, 0)) > 1);
}

TEST(an_answer_beyond_the_limit_is_refused_before_it_is_computed) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.answer_bytes = 100000;
    OWN(test_reply, free) reply = test_post_as(API_OP_TRAJECTORIES, example, NULL, &limits);
    CHECK_INT(reply.status, 422);
    CHECK_INT(reply.runs, 0);
    CHECK(test_reply_has_fault(&reply, "/times", "asks for 501 rows of 13 numbers, up to"));
    CHECK(test_reply_has_fault(&reply, "/times", "more than the limit max-answer-bytes of 100000"));
    test_reply_free(&reply);
    reply = test_post_as(API_OP_TRAJECTORIES,
                         "{" PAPER "," TIMES ",\"digits\":5,\"output\":[\"phi\"]}", NULL, &limits);
    CHECK_INT(reply.status, 200);
}

TEST(a_run_beyond_the_step_limit_ends_as_a_problem) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.steps = 20;
    OWN(test_reply, free) reply = test_post_as(API_OP_TRAJECTORIES, example, "text/csv", &limits);
    CHECK_INT(reply.status, 422);
    CHECK_TEXT(reply.media_type, "application/problem+json");
    CHECK(strstr(
        reply.out.data,
        "the limit of 20 steps was reached before the last instant, 5 s (max-steps): ask for"));
}

TEST(numbers_that_overflow_end_as_a_problem) {
    static const char *const bodies[] = {
        "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]},\"initial\":{\"phi\":[0],\"phid\":[1e200]}"
        ",\"times\":[0,1]}",
        "{\"pendulum\":{\"L\":[1e200],\"m\":[1e308],\"S\":[[1]]},\"times\":[0,1],\"output\":["
        "\"energy\"]}",
    };
    for (int i = 0; i < 2; i++) {
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, bodies[i]);
        CHECK_SAYING(reply.status == 422, "%d %.300s", reply.status, reply.out.data);
        CHECK(!strstr(reply.out.data, "nan") && !strstr(reply.out.data, "inf"));
    }
}

TEST(all_faults_of_a_request_are_told_at_once) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES, "{\"pendulum\":{\"length\":[1,-1],\"mass\":[1,1],\"parent\":"
                                       "[0,1]},\"initial\":{\"phi\":[1,2,3]},\"times\":{"
                                       "\"start\":0,\"step\":0},\"method\":\"runge\","
                                       "\"rtol\":\"small\",\"output\":[\"psi\"],\"digits\":99,"
                                       "\"precision\":\"octuple\",\"meta\":{}}");
    static const char *const pointers[] = {
        "/pendulum/length/1", "/initial/phi", "/times/stop", "/times/step", "/method", "/rtol",
        "/output/0",          "/digits",      "/precision",  "/meta"};
    CHECK_INT(reply.status, 422);
    for (size_t i = 0; i < sizeof pointers / sizeof *pointers; i++)
        CHECK_SAYING(test_reply_has_fault(&reply, pointers[i], ""), "no fault at %s: %s",
                     pointers[i], reply.out.data);
    CHECK_INT(test_reply_faults(&reply), 10);
    CHECK_TEXT(test_reply_text(&reply, "/detail"), "10 errors in the request: see errors");
}

/* ---- how long digits hold */

#define TUMBLE                                                                                     \
    "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{\"theta\":[2,"  \
    "2.5]},"                                                                                       \
    "\"times\":{\"start\":0,\"stop\":30,\"step\":0.25},\"output\":[\"thetad\"],"

static double trust_until(const char *more) {
    char body[400];
    snprintf(body, sizeof body, TUMBLE "%s}", more);
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_SAYING(reply.status == 200, "%s: %s", more, reply.out.data);
    return test_reply_number(&reply, "/stats/trust_until");
}

TEST(trust_tells_how_long_a_chaotic_motion_is_known) {
    double usual = trust_until("\"trust\":true"), strict = trust_until("\"trust\":1e-10");
    double loose = trust_until("\"trust\":true,\"rtol\":1e-6"),
           coarse = trust_until("\"trust\":0.1");
    CHECK_SAYING(usual > 8 && usual < 20, "%g", usual);
    CHECK_SAYING(strict < usual && usual < coarse && loose < usual, "%g %g %g %g", strict, usual,
                 coarse, loose);
    CHECK_SAYING(trust_until("\"trust\":0.01,\"method\":\"ode23\"") < 3, "ode23 is coarse");
    CHECK_SAYING(trust_until("\"trust\":0.01,\"method\":\"linear\"") < 1, "this is no small swing");
    CHECK(fmod(usual, 0.25) == 0);
}

TEST(trust_of_a_tame_motion_reaches_the_last_instant) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES, "{" PAPER ",\"times\":[0,1,5],\"trust\":true}");
    CHECK(test_reply_number(&reply, "/stats/trust_until") == 5);
    test_reply_free(&reply);
    reply = test_post(API_OP_TRAJECTORIES, "{" PAPER ",\"times\":[3,2,-2],\"trust\":true}");
    CHECK(test_reply_number(&reply, "/stats/trust_until") == -2);
    test_reply_free(&reply);
    reply = test_post(API_OP_TRAJECTORIES, "{" PAPER ",\"times\":[0,1],\"trust\":false}");
    CHECK(reply.status == 200 && !strstr(reply.out.data, "trust_until"));
}

/* the double pendulum from (2, 2.5): compared with 90 digits, angles in 32 digits are accurate to
 * 1e-6 until 32.5 s at rtol 1e-28 and 35.5 s at 1e-30, and those of 1e-12 until 8.75 s */
TEST(trust_judges_32_digits_too) {
    static const struct {
        const char *rtol;
        double least, most;
    } runs[] = {{"", 30, 32.75}, {",\"rtol\":1e-30", 30, 35.75}, {",\"rtol\":1e-12", 8, 9}};
    for (size_t i = 0; i < sizeof runs / sizeof *runs; i++) {
        char body[400];
        snprintf(
            body, sizeof body,
            "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{\"phi\":"
            "[0.42920367320510344,0.92920367320510344]},\"times\":{\"stop\":60,\"step\":0.25},"
            "\"output\":[\"phi\"],\"precision\":\"extended\",\"trust\":true%s}",
            runs[i].rtol);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply.status, 200);
        double until = test_reply_number(&reply, "/stats/trust_until");
        CHECK_SAYING(until >= runs[i].least && until <= runs[i].most, "%g s with%s", until,
                     runs[i].rtol);
        CHECK_INT(strstr(reply.out.data, "which double precision reaches") != NULL, i == 2);
    }
}

TEST(an_energy_beyond_all_numbers_is_told_in_words) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES,
                  "{\"pendulum\":{\"length\":[1000],\"mass\":[1e304],\"parent\":[0]},\"initial\":{"
                  "\"theta\":[0],\"thetad\":[1]},\"times\":[0,0.1],\"output\":[\"phi\"]}");
    CHECK_INT(reply.status, 200);
    CHECK_SAYING(strstr(reply.out.data, "the energy exceeds the range of a double") != NULL, "%s",
                 reply.out.data);
}

TEST(an_energy_that_was_lost_is_told_in_words) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES,
                  "{" PAPER ",\"times\":[0,100],\"method\":\"ode23\",\"output\":[\"phi\"]}");
    CHECK(test_reply_number(&reply, "/stats/energy_drift") > 0.01);
    CHECK(strstr(reply.out.data, "the energy was not conserved") != NULL);
    test_reply_free(&reply);
    reply = test_post(API_OP_TRAJECTORIES, "{" PAPER ",\"times\":[0,2],\"output\":[\"phi\"]}");
    CHECK(strstr(reply.out.data, "energy was not conserved") == NULL);
}

TEST(extended_precision_follows_a_chaotic_motion_to_its_end) {
    OWN(test_reply, free) loose =
        test_post(API_OP_TRAJECTORIES, TUMBLE "\"precision\":\"extended\",\"rtol\":1e-26}");
    OWN(test_reply, free) tight =
        test_post(API_OP_TRAJECTORIES, TUMBLE "\"precision\":\"extended\",\"rtol\":1e-30}");
    OWN(test_reply, free) plain = test_post(API_OP_TRAJECTORIES, TUMBLE "\"rtol\":1e-16}");
    CHECK(tight.status == 200 && plain.status == 200);
    CHECK_TEXT(test_reply_text(&tight, "/stats/method"), "taylor");
    double a = test_reply_number(&loose, "/thetad/100/1"),
           b = test_reply_number(&tight, "/thetad/100/1");
    double off = fabs(test_reply_number(&plain, "/thetad/100/1") - b);
    CHECK_SAYING(fabs(a - b) < 1e-6 && fabs(b) > 0.01, "25 s: %g and %g", a, b);
    CHECK_SAYING(off > 1e-3, "doubles are right too, within %g", off);
}

/* two unit arms that tumble, to 20 s; `more` is the rest of the request */
static struct test_reply tumble(const char *accept, const char *more) {
    char body[512];
    snprintf(body, sizeof body,
             "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{"
             "\"theta\":[2,2.5]},\"times\":{\"stop\":20,\"step\":0.1},\"output\":[\"phi\"]%s}",
             more);
    return test_post_as(API_OP_TRAJECTORIES, body, accept, NULL);
}

TEST(horizon_is_told_by_default_and_in_words_where_it_falls_short) {
    OWN(test_reply, free) reply = tumble("application/json", "");
    double usual = test_reply_number(&reply, "/stats/horizon");
    CHECK_SAYING(usual >= 7 && usual <= 9.7, "%g", usual); // the true value is 8.8 s
    CHECK(strstr(reply.out.data,
                 "},\"warnings\":[\"accuracy is lost before the last instant: after t = "));
    test_reply_free(&reply);
    reply = tumble("application/json", ",\"accuracy\":0.01");
    CHECK(test_reply_number(&reply, "/stats/horizon") > usual + 3);
    test_reply_free(&reply);
    reply = tumble("application/json", ",\"precision\":\"extended\"");
    CHECK(test_reply_number(&reply, "/stats/horizon") == 20 && !strstr(reply.out.data, "warnings"));
    test_reply_free(&reply);
    reply = tumble("text/csv", "");
    CHECK(strstr(reply.out.data,
                 "\n# warning: accuracy is lost before the last instant: after t = "));
    test_reply_free(&reply);
    reply = tumble("application/x-ndjson", "");
    CHECK(strstr(reply.out.data, "}\n{\"stats\":{\"method\":\"taylor\"") &&
          strstr(reply.out.data, "],\"warnings\":") == NULL);
    CHECK(strstr(reply.out.data, "},\"warnings\":[\"accuracy"));
}

TEST(horizon_does_not_change_an_answers_rows) {
    OWN(test_reply, free) usual = tumble("application/octet-stream", ""),
                          other = tumble("application/octet-stream", ",\"accuracy\":1e-12");
    CHECK(usual.status == 200 && usual.out.bytes == other.out.bytes &&
          !memcmp(usual.out.data, other.out.data, usual.out.bytes));
}

/* a swing of 1e-12 rad is lost next to pi/2; theta and phi' are as small, and have their digits */
TEST(small_angles_from_hanging_keep_their_digits) {
    static const struct {
        const char *body;
        double largest;
    } ways[] = {{"\"method\":\"taylor\"", 2e-13},
                {"\"precision\":\"extended\"", 2e-15},
                {"\"method\":\"linear\"", 2e-15}};
    const double frequency = sqrt(9.81);
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++)
        for (int turned = 0; turned < 2; turned++) {
            char body[400];
            snprintf(body, sizeof body,
                     "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"initial\":{"
                     "\"theta\":[%s]},\"times\":[0,0.25,1,3],\"output\":[\"theta\",\"thetad\","
                     "\"phidd\"],%s}",
                     turned ? "-3.25e-12" : "1e-12", ways[w].body);
            OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
            CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
            double times[] = {0, 0.25, 1, 3}, start = turned ? -3.25e-12 : 1e-12, worst = 0;
            CHECK(test_reply_number(&reply, "/theta/0/0") == start);
            for (int i = 0; i < 4; i++) {
                char place[40];
                double theta = start * cos(frequency * times[i]);
                snprintf(place, sizeof place, "/theta/%d/0", i);
                worst = fmax(worst, fabs(test_reply_number(&reply, place) - theta) / fabs(start));
                snprintf(place, sizeof place, "/phidd/%d/0", i);
                worst = fmax(worst, fabs(test_reply_number(&reply, place) + 9.81 * theta) /
                                        fabs(9.81 * start));
            }
            CHECK_SAYING(worst <= ways[w].largest, "%s: off by %g of the swing", ways[w].body,
                         worst);
        }
    OWN(test_reply, free) reply =
        test_post(API_OP_FORCES, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},"
                                 "\"state\":{\"theta\":[1e-12]}}");
    double got = test_reply_number(&reply, "/phidd/0");
    CHECK_SAYING(fabs(got + 9.81e-12) < 1e-25, "%.17g", got);
    test_reply_free(&reply);
    reply = test_post(API_OP_MODES, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},"
                                    "\"initial\":{\"theta\":[1e-12]}}");
    got = test_reply_number(&reply, "/amplitude/0");
    CHECK_SAYING(fabs(got - 1e-12) < 1e-26, "%.17g", got);
}

/* the largest error of theta relative to the scale, against scale cos(frequency t), 16 rows */
static double swing_error(const struct test_reply *reply, int from, double scale,
                          double frequency) {
    double worst = 0;
    for (int i = 0; i < 16; i++) {
        char place[60];
        snprintf(place, sizeof place, "/theta/%d/0", from + i);
        double exact = scale * cos(frequency * i / 8.0);
        worst = fmax(worst, fabs(test_reply_number(reply, place) - exact) / fabs(scale));
    }
    return worst;
}

#define ONE_ARM "\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]}"
#define SWING_ROWS                                                                                 \
    "\"times\":{\"stop\":1.875,\"step\":0.125},\"observables\":[\"trajectory\"],\"output\":["      \
    "\"theta\",\"thetad\"]"

/* the same for members, however their start is given */
TEST(small_angles_of_members_keep_their_digits) {
    static const char *const ways[] = {
        "\"states\":[{\"theta\":[1e-12]},{\"theta\":[2e-12]}]",
        "\"states\":[{\"mode\":1,\"amplitude\":1e-12},{\"mode\":1,\"amplitude\":2e-12}]",
        "\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":1e-12,\"stop\":2e-12,\"count\":2}]"};
    const double frequency = sqrt(9.81);
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
        char body[500];
        snprintf(body, sizeof body, "{" ONE_ARM ",%s," SWING_ROWS "}", ways[w]);
        OWN(test_reply, free) reply = test_post(API_OP_ENSEMBLES, body);
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        for (int member = 0; member < 2; member++) {
            double error = swing_error(&reply, 16 * member, (1 + member) * 1e-12, frequency);
            CHECK_SAYING(error <= 2e-12, "%s, member %d: off by %g of the swing", ways[w], member,
                         error);
        }
    }
    OWN(test_reply, free) reply =
        test_post(API_OP_ENSEMBLES, "{" ONE_ARM ",\"states\":[{\"theta\":[1e-12]}],\"duration\":1,"
                                    "\"observables\":[\"final\"]}");
    double rate = test_reply_number(&reply, "/final/phid/0/0"),
           exact = -1e-12 * frequency * sin(frequency);
    CHECK_SAYING(fabs(rate - exact) <= 1e-11 * fabs(exact), "%.17g beside %.17g", rate, exact);
}

/* a swing of 1e-12 rad passes its lowest point every half period, and half its height in between */
TEST(small_swings_pass_a_section_in_time) {
    const double half = M_PI / sqrt(9.81);
    OWN(test_reply, free) reply =
        test_post(API_OP_SECTIONS, "{" ONE_ARM ",\"initial\":{\"theta\":[1e-12]},\"duration\":10,"
                                   "\"section\":{\"arm\":1,\"theta\":0,\"direction\":\"both\"}}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    CHECK_INT(test_reply_count(&reply, "/t"), 10);
    for (int i = 0; i < 10; i++) {
        char place[20];
        snprintf(place, sizeof place, "/t/%d", i);
        double t = test_reply_number(&reply, place);
        CHECK_SAYING(fabs(t - (i + 0.5) * half) < 1e-11, "passage %d at %.17g", i, t);
    }
    test_reply_free(&reply);
    reply = test_post(API_OP_SECTIONS,
                      "{" ONE_ARM ",\"initial\":{\"theta\":[1e-12]},\"duration\":1,\"section\":{"
                      "\"arm\":1,\"theta\":5e-13,\"direction\":\"both\"}}");
    double t = test_reply_number(&reply, "/t/0");
    CHECK_SAYING(fabs(t - half / 3) < 1e-11, "half its height at %.17g", t);
}

/* forces of a list of states have the same digits as those of each alone */
TEST(small_angles_of_many_states_keep_their_digits) {
    OWN(test_reply, free) reply =
        test_post(API_OP_FORCES, "{" ONE_ARM ",\"states\":[{\"theta\":[1e-12]},{\"theta\":[1]},{"
                                 "\"theta\":[-3e-12]},{\"theta\":[1e17],\"unit\":\"rad\"}]}");
    double first = test_reply_number(&reply, "/phidd/0/0"),
           third = test_reply_number(&reply, "/phidd/2/0");
    CHECK_SAYING(fabs(first + 9.81e-12) < 1e-25, "%.17g", first);
    CHECK_SAYING(fabs(third - 3 * 9.81e-12) < 3e-25, "%.17g", third);
    double second = test_reply_number(&reply, "/phidd/1/0"),
           fourth = test_reply_number(&reply, "/phidd/3/0");
    CHECK(fabs(second + 9.81 * sin(1)) < 1e-14);
    CHECK_SAYING(fabs(fourth + 9.81 * sin(1e17)) < 1e-14, "%.17g beside %.17g", fourth,
                 -9.81 * sin(1e17));
}

/* degrees give angles of many turns that a double does not represent: the remainder counts wherever
 * a motion starts */
TEST(huge_angles_in_degrees_are_exact_wherever_a_motion_starts) {
    const char *const starts[] = {"{\"theta\":[999999999999990],\"unit\":\"deg\"}",
                                  "{\"theta\":[270],\"unit\":\"deg\"}"};
    double rate[2], t[2], exponent[2], acc[2];
    for (int i = 0; i < 2; i++) {
        char body[500];
        snprintf(body, sizeof body,
                 "{" ONE_ARM ",\"states\":[%s],\"duration\":1,\"observables\":[\"final\"]}",
                 starts[i]);
        OWN(test_reply, free) reply = test_post(API_OP_ENSEMBLES, body);
        rate[i] = test_reply_number(&reply, "/final/phid/0/0");
        test_reply_free(&reply);
        snprintf(body, sizeof body, "{" ONE_ARM ",\"states\":[%s]}", starts[i]);
        reply = test_post(API_OP_FORCES, body);
        acc[i] = test_reply_number(&reply, "/phidd/0/0");
        test_reply_free(&reply);
        snprintf(body, sizeof body,
                 "{" ONE_ARM ",\"initial\":%s,\"duration\":3,\"section\":{\"arm\":1,\"theta\":0}}",
                 starts[i]);
        reply = test_post(API_OP_SECTIONS, body);
        t[i] = test_reply_number(&reply, "/t/0");
        test_reply_free(&reply);
        snprintf(body, sizeof body, "{" ONE_ARM ",\"initial\":%s,\"duration\":10,\"count\":1}",
                 starts[i]);
        reply = test_post(API_OP_LYAPUNOV, body);
        exponent[i] = test_reply_number(&reply, "/exponents/0/0");
    }
    CHECK_SAYING(fabs(rate[0] - rate[1]) < 1e-11, "%.17g beside %.17g", rate[0], rate[1]);
    CHECK_SAYING(fabs(acc[0] - acc[1]) < 1e-13, "%.17g beside %.17g", acc[0], acc[1]);
    CHECK_SAYING(fabs(t[0] - t[1]) < 1e-11, "%.17g beside %.17g", t[0], t[1]);
    CHECK_SAYING(fabs(exponent[0] - exponent[1]) < 1e-7, "%.17g beside %.17g", exponent[0],
                 exponent[1]);
}

TEST(a_damped_arm_dies_away_as_its_closed_form) {
    // m l^2 theta'' + c theta' + m g l theta = 0, to the square of the angle
    OWN(test_reply, free) reply = test_post(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"length\":[0.8],\"mass\":[1.5],\"parent\":[0],\"damping\":[0.3]},"
        "\"initial\":{\"theta\":[1e-5]},\"times\":{\"stop\":5,\"step\":1},\"output\":[\"theta\","
        "\"energy\",\"exchange\"]}");
    double decay = 0.3 / (2 * 1.5 * 0.64), omega = sqrt(9.81 / 0.8 - decay * decay), worst = 0;
    CHECK_INT(reply.status, 200);
    for (int i = 0; i <= 5; i++) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/theta/%d/0", i);
        double want = 1e-5 * exp(-decay * i) * (cos(omega * i) + decay / omega * sin(omega * i));
        worst = fmax(worst, fabs(test_reply_number(&reply, pointer) - want) / 1e-5);
    }
    CHECK_RESIDUAL(worst, 1e-9, "theta of a damped small swing");
    double lost =
        test_reply_number(&reply, "/energy/total/0") - test_reply_number(&reply, "/energy/total/5");
    CHECK(fabs(lost - test_reply_number(&reply, "/exchange/heat/5")) < 2e-14);
    CHECK(test_reply_number(&reply, "/exchange/work/5") == 0);
    CHECK(test_reply_number(&reply, "/stats/energy_drift") < 1e-13);
}

TEST(symplectic_takes_of_real_pendulums_those_that_keep_their_energy) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,0],\"parent\":[0,1],\"rod\":[null,1],\"at\":["
        "null,[0.5,0.2]],\"stiffness\":[3,1],\"damping\":[0,0]},\"times\":{\"stop\":9,\"step\":1},"
        "\"method\":\"symplectic\"}");
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/stats/energy_drift") < 1e-13);
}

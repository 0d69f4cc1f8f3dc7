#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

static struct test_reply get(enum api_op_id op, const char *name) {
    struct api_request request = {.op = op, .argument = name};
    return test_send(&request, NULL);
}

/* a number of preset i of the list, or one of its list at index `place` */
static double number(const struct test_reply *reply, int i, const char *place) {
    char pointer[80];
    snprintf(pointer, sizeof pointer, "/presets/%d/%s", i, place);
    return test_reply_number(reply, pointer);
}

static const char *text(const struct test_reply *reply, int i, const char *place) {
    char pointer[80];
    snprintf(pointer, sizeof pointer, "/presets/%d/%s", i, place);
    return test_reply_text(reply, pointer);
}

/* lower-case words joined by hyphens, fit for a URL */
static int is_slug(const char *name) {
    return *name && strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789-") == strlen(name);
}

TEST(the_list_has_every_preset_whole) {
    OWN(test_reply, free) reply = get(API_OP_PRESETS, NULL);
    CHECK_INT(reply.status, 200);
    int count = test_reply_count(&reply, "/presets");
    CHECK(count >= 20);
    for (int i = 0; i < count; i++) {
        const char *name = text(&reply, i, "name");
        double samples = number(&reply, i, "times/stop") / number(&reply, i, "times/step");
        CHECK_SAYING(is_slug(name), "%s is not fit for a URL", name);
        CHECK_SAYING(strlen(text(&reply, i, "title")) > 3 &&
                         strlen(text(&reply, i, "description")) > 40,
                     "%s says too little", name);
        CHECK_SAYING(samples >= 100 && samples <= 5000 && fabs(samples - round(samples)) < 1e-9,
                     "%s has %g samples", name, samples);
        OWN(test_reply, free) alone = get(API_OP_PRESET, name);
        CHECK_INT(alone.status, 200);
        CHECK_SAYING(strstr(reply.out.data, alone.out.data) != NULL, "%s is not in the list", name);
    }
}

TEST(presets_of_the_contract_have_the_shapes_of_their_names) {
    static const struct {
        const char *name, *piece;
    } wanted[] = {{"paper-four-arms",
                   "\"n\":4,\"pendulum\":{\"length\":[2,1.5,0.75,1.25],\"mass\":[1,1,1,0.1],"
                   "\"parent\":[0,1,2,2],\"gravity\":9.81},\"initial\":{\"phi\":[0,0,0,0],"
                   "\"phid\":[0,0,0,0]},\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}}"},
                  {"single", "\"parent\":[0]"},
                  {"double", "\"parent\":[0,1]"},
                  {"triple", "\"parent\":[0,1,2]"},
                  {"non-standard-triple", "\"parent\":[0,1,1]"},
                  {"chain-10", "\"parent\":[0,1,2,3,4,5,6,7,8,9]"},
                  {"star", "\"parent\":[0,1,1,1,1,1,1,1,1]"},
                  {"binary-4", "\"parent\":[0,1,1,2,2,3,3,4,4,5,5,6,6,7,7]"}};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        OWN(test_reply, free) reply = get(API_OP_PRESET, wanted[i].name);
        CHECK_INT(reply.status, 200);
        CHECK_SAYING(strstr(reply.out.data, wanted[i].piece) != NULL, "%s: %s", wanted[i].name,
                     reply.out.data);
    }
}

/* the request in a preset, without its times */
static char *request_of(const struct test_reply *preset, const char *more) {
    char *pendulum = strstr(preset->out.data, "\"pendulum\":"),
         *times = strstr(preset->out.data, ",\"times\":"), *body = malloc(preset->out.bytes + 200);
    assert(pendulum && times && body);
    sprintf(body, "{%.*s%s}", (int)(times - pendulum), pendulum, more);
    return body;
}

TEST(preset_two_to_one_has_frequencies_in_that_ratio) {
    OWN(test_reply, free) preset = get(API_OP_PRESET, "two-to-one");
    char *body = request_of(&preset, ""), *initial = strstr(body, ",\"initial\":");
    strcpy(initial, "}");
    OWN(test_reply, free) modes = test_post(API_OP_MODES, body);
    double slow = test_reply_number(&modes, "/omega/0"),
           fast = test_reply_number(&modes, "/omega/1");
    CHECK_RESIDUAL(fabs(fast / slow - 2), 1e-15, "frequencies as 2 to 1");
    free(body);
}

/* the largest rate and acceleration of any arm at the first instant */
static double liveliest(const struct test_reply *run, int arms) {
    double most = 0;
    for (int k = 0; k < arms; k++) {
        char rate[40], acc[40];
        snprintf(rate, sizeof rate, "/phid/0/%d", k);
        snprintf(acc, sizeof acc, "/phidd/0/%d", k);
        most = fmax(most, fabs(test_reply_number(run, rate)) + fabs(test_reply_number(run, acc)));
    }
    return most;
}

TEST(every_preset_is_a_request_for_its_trajectory_and_moves) {
    OWN(test_reply, free) list = get(API_OP_PRESETS, NULL);
    for (int i = 0; i < test_reply_count(&list, "/presets"); i++) {
        const char *name = text(&list, i, "name");
        OWN(test_reply, free) reply = get(API_OP_PRESET, name);
        OWN_MEMORY char *body =
            request_of(&reply, ",\"times\":[0,0.01],\"output\":[\"phi\",\"phid\",\"phidd\"]");
        OWN(test_reply, free) run = test_post(API_OP_TRAJECTORIES, body);
        CHECK_SAYING(run.status == 200, "%s: %.300s", name, run.out.data);
        CHECK(test_reply_number(&run, "/phi/0/0") == number(&list, i, "initial/phi/0"));
        CHECK_INT(test_reply_count(&run, "/phi/0"), (int)number(&list, i, "n"));
        CHECK_SAYING(liveliest(&run, (int)number(&list, i, "n")) > 0.1, "%s stays where it is",
                     name);
        test_reply_free(&run);
        sprintf(body, "{%s", strstr(reply.out.data, "\"pendulum\":"));
        struct api_limits limits;
        api_limits_init(&limits);
        limits.answer_bytes = 1; /* read and checked whole, but not computed */
        run = test_post_as(API_OP_TRAJECTORIES, body, NULL, &limits);
        CHECK(test_reply_faults(&run) == 1 &&
              test_reply_has_fault(&run, "/times", "max-answer-bytes"));
    }
}

TEST(an_unknown_preset_is_not_found_and_a_near_name_is_offered) {
    OWN(test_reply, free) reply = get(API_OP_PRESET, "duble");
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
}

/* the motion of a real preset, with some of its text replaced */
static struct test_reply motion(const char *name, const char *old, const char *new,
                                const char *output) {
    OWN(test_reply, free) preset = get(API_OP_PRESET, name);
    char *pendulum = strstr(preset.out.data, "\"pendulum\":"), *body = malloc(4000), *place;
    int bytes =
        snprintf(body, 4000, "{%.*s,\"output\":[%s]}", (int)strlen(pendulum) - 1, pendulum, output);
    if (old && CHECK_SAYING((place = strstr(body, old)) != NULL, "%s is not in %s", old, body)) {
        char rest[4000];
        snprintf(rest, sizeof rest, "%s", place + strlen(old));
        snprintf(place, (size_t)(4000 - (place - body)), "%s%s", new, rest);
    }
    CHECK(bytes < 3900);
    struct test_reply reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_SAYING(reply.status == 200, "%s: %.300s", name, reply.out.data);
    free(body);
    return reply;
}

/* the largest |x - middle| of an arm between two samples */
static double reach(const struct test_reply *reply, int arm, int from, int to, double middle) {
    double most = 0;
    for (int i = from; i <= to; i += 3) {
        char pointer[60];
        snprintf(pointer, sizeof pointer, "/theta/%d/%d", i, arm);
        most = fmax(most, fabs(test_reply_number(reply, pointer) - middle));
    }
    return most;
}

static const double pi = 3.14159265358979323846;

/* It stays upright if (a w)^2 > 2 g l, where a is the amplitude and w the frequency of the pivot
 * (Landau and Lifshitz, Mechanics, section 30): here a > sqrt(2 * 9.81 * 0.25) / 200 = 11.07 mm.
 * Started 0.3 rad from the top and damped, it goes no farther except for the vibration, a / l times
 * its sine. */
TEST(kapitzas_pendulum_stays_up_and_falls_with_less) {
    static const char kept[] = "\"amplitude\":0.02";
    OWN(test_reply, free) up = motion("kapitza", NULL, NULL, "\"theta\"");
    OWN(test_reply, free) less = motion("kapitza", kept, "\"amplitude\":0.012", "\"theta\"");
    OWN(test_reply, free) down = motion("kapitza", kept, "\"amplitude\":0.0105", "\"theta\"");
    CHECK(reach(&up, 0, 0, 3000, pi) < 0.4);
    CHECK(reach(&up, 0, 0, 3000, pi) > 0.2);
    CHECK(reach(&less, 0, 0, 3000, pi) < 0.6);
    CHECK(reach(&down, 0, 0, 3000, pi) > 2);
}

/* Half a beat of the two slow modes, s, in closed form: the arms against each other with w^2 = g /
 * l leave the frame at rest; together with the frame det(K - w^2 M) = 0 for two unknowns. Frame 0.7
 * m with 2 kg and 60 N m, two arms of 0.4 m with 0.5 kg, 0.2 m beside its end. */
static double half_beat(void) {
    double g = 9.81, frame = 2 * 0.49 / 3 + 2 * 0.5 * (0.49 + 0.04), arm = 2 * 0.5 * 0.16;
    double both = 2 * 0.5 * 0.7 * 0.4, spring = 60 + 2 * g * 0.35 + 2 * 0.5 * g * 0.7;
    double pull = 2 * 0.5 * g * 0.4, a = frame * arm - both * both;
    double b = spring * arm + pull * frame, c = spring * pull;
    return pi / (sqrt(g / 0.4) - sqrt((b - sqrt(b * b - 4 * a * c)) / (2 * a)));
}

TEST(coupled_pendulums_hand_their_motion_over) {
    OWN(test_reply, free) reply = motion("coupled", NULL, NULL, "\"theta\",\"energy\"");
    double first = reach(&reply, 1, 0, 100, 0), second = reach(&reply, 2, 0, 50, 0);
    double later = 1, most = 0, when = 0;
    for (int at = 300; at < 600; at += 25) {
        double here = reach(&reply, 1, at, at + 75, 0);
        if (here < later) later = here, most = reach(&reply, 2, at, at + 75, 0), when = 0.02 * at;
    }
    /* the middle of a window of a second and a half, which contains a whole swing */
    CHECK_SAYING(fabs(when + 0.75 - half_beat()) < 0.5, "%g s, not %g", when + 0.75, half_beat());
    CHECK(first > 0.18 && second < 0.08);
    CHECK_SAYING(later < 0.04 && most > 0.17, "the first has %g, the second %g", later, most);
    CHECK(test_reply_number(&reply, "/stats/energy_drift") < 1e-11);
}

/* The pendulum of Baker and Gollub (Chaotic Dynamics, Cambridge 1990) with q = 2 and w = 2/3
 * repeats after one period of its drive at g = 0.9, after two at 1.07, and is chaotic at 1.15. The
 * period in periods of the drive: by the rate at three instants a period apart, after 98 of
 * them. */
TEST(the_driven_pendulum_repeats_itself_or_not_as_the_books_have_it) {
    static const struct {
        const char *amplitude;
        int once, twice;
    } tries[] = {
        {"\"amplitude\":0.9", 1, 1}, {"\"amplitude\":1.07", 0, 1}, {"\"amplitude\":1.15", 0, 0}};
    for (size_t i = 0; i < sizeof tries / sizeof *tries; i++) {
        char body[600];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,"
                 "\"damping\":[0.5],\"torque\":[{\"harmonics\":[{%s,\"omega\":"
                 "0.6666666666666666}]}]},\"initial\":{\"theta\":[0.2]},\"output\":[\"theta\","
                 "\"thetad\"],\"times\":{\"stop\":942.47779607693793,\"count\":101}}",
                 tries[i].amplitude);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        double rate[3];
        for (int k = 0; k < 3; k++) {
            char pointer[40];
            snprintf(pointer, sizeof pointer, "/thetad/%d/0", 98 + k);
            rate[k] = test_reply_number(&reply, pointer);
        }
        CHECK_SAYING((fabs(rate[1] - rate[2]) < 1e-6) == tries[i].once, "%s: %g %g",
                     tries[i].amplitude, rate[1], rate[2]);
        CHECK_SAYING((fabs(rate[0] - rate[2]) < 1e-6) == tries[i].twice, "%s: %g %g",
                     tries[i].amplitude, rate[0], rate[2]);
    }
}

TEST(bars_keep_their_energy_and_the_laboratory_loses_it_as_told) {
    struct test_reply bars = motion("double-bars", NULL, NULL, "\"theta\"");
    CHECK(test_reply_number(&bars, "/stats/energy_drift") < 1e-11);
    CHECK(reach(&bars, 1, 0, 2000, 0) > 2 * pi);
    test_reply_free(&bars);
    OWN(test_reply, free) rig = motion("laboratory-double", NULL, NULL, "\"theta\",\"exchange\"");
    CHECK(test_reply_number(&rig, "/stats/energy_drift") < 1e-11);
    CHECK(test_reply_number(&rig, "/exchange/work/2000") > 0.1);
    CHECK(test_reply_number(&rig, "/exchange/heat/2000") > 0.1);
}

TEST(a_metronome_on_a_cart_swings_about_up_and_moves_its_cart) {
    OWN(test_reply, free) reply = motion("metronome-cart", NULL, NULL, "\"theta\",\"cart\"");
    CHECK(test_reply_number(&reply, "/stats/energy_drift") < 1e-11);
    double most = 0, least = 0;
    for (int i = 0; i <= 200; i++) {
        char path[40];
        snprintf(path, sizeof path, "/cart/x/%d", i);
        double x = test_reply_number(&reply, path);
        if (x > most) most = x;
        if (x < least) least = x;
        snprintf(path, sizeof path, "/theta/%d/0", i);
        CHECK(fabs(fabs(test_reply_number(&reply, path)) - pi) < 0.75);
    }
    CHECK(most - least > 0.01 && most - least < 0.05);
}

/* Laws: a change of the units of length, mass and time multiplies the numbers of answers by the
 * corresponding powers, and changes nothing else. This reveals a hidden length of a metre or rate
 * of 1/s. The file is named after its first operation. Leaves to others: the numbers in metres,
 * kilograms and seconds (test_op_X). Invariant: all units are powers of two, so that requests scale
 * without rounding. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* powers of two by which lengths, masses and times are multiplied */
struct units {
    int length, mass, time;
};

static const struct units all[] = {{-30, 0, 0}, {20, 0, 0}, {0, -30, 0},   {0, 25, 0},
                                   {0, 0, -12}, {0, 0, 12}, {-25, 20, 15}, {15, -20, -9}};

static int power(const struct units *units, const int by[3]) {
    return units->length * by[0] + units->mass * by[1] + units->time * by[2];
}

/* writes a request in which <X L M T> stands for X m^L kg^M s^T */
static void write_request(const char *from, const struct units *units, char *to, size_t bytes) {
    while (*from) {
        double x;
        int by[3], length = 1, all_of_it = 0;
        if (sscanf(from, "<%lf %d %d %d>%n", &x, &by[0], &by[1], &by[2], &all_of_it) == 4)
            snprintf(to, bytes, "%.17g", ldexp(x, power(units, by))), length = all_of_it;
        else
            snprintf(to, bytes, "%c", *from);
        from += length;
        bytes -= strlen(to), to += strlen(to);
    }
    CHECK(bytes > 1);
}

/* numbers of an answer and the powers of their units; a # in the pointer is 0, 1 and so on, as long
 * as there are numbers */
struct number {
    const char *pointer;
    int by[3];
};

struct law {
    enum api_op_id op;
    double most; /* of the largest number of a pointer */
    const char *request;
    struct number number[9]; /* up to one without a pointer */
};

/* a bent pair of arms with all kinds of friction, on a cart with a spring */
#define ON_A_CART                                                                                  \
    "\"pendulum\":{\"gravity\":<9.81 1 0 -2>,\"drag_per_mass\":<0.03 0 0 -1>,\"arms\":["           \
    "{\"name\":\"a\",\"length\":<0.9 1 0 0>,\"mass\":<1.1 0 1 0>,\"damping\":<0.2 2 1 -1>,"        \
    "\"torque\":<0.7 2 1 -2>,\"drag\":{\"linear\":<0.1 0 1 -1>,\"quadratic\":<0.2 -1 1 0>,"        \
    "\"speed\":<0.1 1 0 -1>}},"                                                                    \
    "{\"name\":\"b\",\"parent\":\"a\",\"length\":<1.3 1 0 0>,\"rod\":<2 0 1 0>,"                   \
    "\"at\":[<0.4 1 0 0>,<-0.2 1 0 0>],\"stiffness\":<3 2 1 -2>,\"rest\":1.1,"                     \
    "\"body\":{\"mass\":<1.5 0 1 0>,\"center\":[<-0.2 1 0 0>,<0.1 1 0 0>],"                        \
    "\"inertia\":<0.2 2 1 0>}}],"                                                                  \
    "\"pivot\":{\"cart\":{\"mass\":<0.3 0 1 0>,\"angle\":0.4,\"stiffness\":<4 0 1 -2>,"            \
    "\"damping\":<0.3 0 1 -1>}}}"
#define STATE                                                                                      \
    "{\"theta\":[2,-1.5],\"thetad\":[<1 0 0 -1>,<-2 0 0 -1>],\"cart\":{\"x\":<0.4 1 0 0>,"         \
    "\"v\":<-0.7 1 0 -1>}}"
/* two arms that spin without gravity */
#define FREE                                                                                       \
    "\"pendulum\":{\"gravity\":0,\"length\":[<1 1 0 0>,<0.7 1 0 0>],\"mass\":[<1 0 1 0>,"          \
    "<1.5 0 1 0>],\"parent\":[0,1]}"
#define SPIN "{\"theta\":[2,-1.5],\"thetad\":[<3 0 0 -1>,<-2 0 0 -1>]}"

static const struct law laws[] = {
    {API_OP_MODES,
     1e-11,
     "{" ON_A_CART "}",
     {{"/omega/#", {0, 0, -1}},
      {"/growth/#", {0, 0, -1}},
      {"/equilibrium/#", {0, 0, 0}},
      {"/cart/equilibrium", {1, 0, 0}},
      {"/cart/re/#", {1, 0, 0}},
      {"/vectors/re/0/#", {0, 0, 0}},
      {"/vectors/re/2/#", {0, 0, 0}},
      {"/vectors/im/1/#", {0, 0, 0}}}},
    {API_OP_RESPONSE,
     1e-11,
     "{" ON_A_CART ",\"drive\":{\"cart\":{\"amplitude\":<0.3 1 1 -2>}},\"omega\":[<2.5 0 0 -1>],"
     "\"output\":[\"phi\",\"lambda\",\"cart\"],\"poles\":true}",
     {{"/poles/omega/#", {0, 0, -1}},
      {"/poles/decay/#", {0, 0, -1}},
      {"/equilibrium/#", {0, 0, 0}},
      {"/phi/amplitude/0/#", {0, 0, 0}},
      {"/lambda/amplitude/0/#", {1, 1, -2}},
      {"/cart/amplitude/0", {1, 0, 0}}}},
    {API_OP_FORCES,
     1e-12,
     "{" ON_A_CART ",\"states\":[{\"theta\":[0.5,1]}," STATE "],\"derivatives\":[{\"vary\":\"phi\","
     "\"arm\":1}]}",
     {{"/phidd/1/#", {0, 0, -2}},
      {"/lambda/1/#", {1, 1, -2}},
      {"/z/re/1/#", {1, 0, 0}},
      {"/derivatives/z_re/1/#/0", {1, 0, 0}},
      {"/derivatives/phidd/1/#/0", {0, 0, -2}}}},
    {API_OP_TRAJECTORIES,
     1e-10,
     "{" ON_A_CART ",\"initial\":" STATE ",\"times\":{\"stop\":<3 0 0 1>,\"count\":4},\"output\":["
     "\"phi\",\"lambda\",\"energy\",\"cart\"]}",
     {{"/phi/3/#", {0, 0, 0}},
      {"/lambda/3/#", {1, 1, -2}},
      {"/energy/total/#", {2, 1, -2}},
      {"/cart/x/#", {1, 0, 0}},
      {"/stats/horizon", {0, 0, 1}}}},
    {API_OP_TRAJECTORIES,
     1e-9,
     "{" ON_A_CART ",\"initial\":{\"mode\":1,\"amplitude\":0.1},\"times\":{\"stop\":<1 0 0 1>,"
     "\"count\":2},\"output\":[\"theta\",\"cart\"]}",
     {{"/theta/0/#", {0, 0, 0}}, {"/theta/1/#", {0, 0, 0}}, {"/cart/x/#", {1, 0, 0}}}},
    {API_OP_ENSEMBLES,
     1e-5,
     "{" ON_A_CART ",\"states\":[" STATE "],\"duration\":<4 0 0 1>,\"observables\":[\"lyapunov\","
     "\"horizon\",\"final\"]}",
     {{"/lyapunov/0", {0, 0, -1}}, {"/horizon/0", {0, 0, 1}}, {"/final/phi/0/#", {0, 0, 0}}}},
    {API_OP_ENSEMBLES,
     1e-5,
     "{" FREE ",\"states\":[" SPIN "],\"duration\":<6 0 0 1>,\"observables\":[\"lyapunov\"]}",
     {{"/lyapunov/0", {0, 0, -1}}}},
    {API_OP_LYAPUNOV,
     1e-6,
     "{" FREE ",\"initial\":" SPIN ",\"duration\":<6 0 0 1>,\"samples\":2,\"count\":\"all\"}",
     {{"/exponents/1/#", {0, 0, -1}}, {"/stats/frequency", {0, 0, -1}}}},
    {API_OP_CONTROLLERS,
     1e-9,
     "{" ON_A_CART ",\"equilibrium\":{\"theta\":[0.18,0.19]},\"actuators\":{\"joints\":[1],"
     "\"cart\":true},\"period\":<0.1 0 0 1>,\"delay\":1}",
     {{"/control/0/law/feedback/gains/0", {2, 1, -2}},
      {"/control/1/law/feedback/gains/4", {0, 1, -2}},
      {"/control/1/law/feedback/gains/5", {0, 1, -1}},
      {"/multipliers/re/#", {0, 0, 0}},
      {"/margins/0/phase", {0, 0, 0}},
      {"/A/0/0", {0, 0, 0}},
      {"/modes/reach/#", {0, 0, 0}}}},
};

/* the largest difference of the numbers at a pointer, relative to the largest of them */
static double law_gap(const struct test_reply *got, const struct test_reply *want,
                      const struct number *number, int times) {
    double most = 0, size = 0;
    int count = 0;
    for (;; count++) {
        const char *place = strchr(number->pointer, '#');
        char pointer[80];
        if (!place && count) break;
        if (place)
            snprintf(pointer, sizeof pointer, "%.*s%d%s", (int)(place - number->pointer),
                     number->pointer, count, place + 1);
        else
            snprintf(pointer, sizeof pointer, "%s", number->pointer);
        double is = ldexp(test_reply_number(got, pointer), -times),
               should = test_reply_number(want, pointer);
        if (place && isnan(is) && isnan(should)) break;
        most = fmax(most, isnan(is - should) ? INFINITY : fabs(is - should));
        size = fmax(size, fabs(should));
    }
    CHECK_SAYING(count > 0 && size > 0, "%s has no number", number->pointer);
    return most / size;
}

TEST(law_answers_do_not_depend_on_the_units_of_length_mass_and_time) {
    static const struct units metres = {0, 0, 0};
    for (size_t i = 0; i < sizeof laws / sizeof *laws; i++) {
        const struct law *law = &laws[i];
        char body[2000];
        write_request(law->request, &metres, body, sizeof body);
        OWN(test_reply, free) want = test_post(law->op, body);
        CHECK_SAYING(want.status == 200, "%d for %s", want.status, body);
        for (size_t j = 0; j < sizeof all / sizeof *all; j++) {
            write_request(law->request, &all[j], body, sizeof body);
            OWN(test_reply, free) got = test_post(law->op, body);
            CHECK_SAYING(got.status == 200, "%d for %s", got.status, body);
            for (const struct number *number = law->number; number->pointer; number++) {
                double gap = law_gap(&got, &want, number, power(&all[j], number->by));
                CHECK_SAYING(gap <= law->most, "%s of %s: a gap of %g", number->pointer, body, gap);
            }
        }
    }
}

/* a start in a mode is given by the largest angle of an arm, and not by a cart's position */
TEST(law_a_start_in_a_mode_on_a_cart_has_its_amplitude) {
    char body[2000];
    write_request(laws[4].request, &(struct units){0, 0, 0}, body, sizeof body);
    OWN(test_reply, free) start = test_post(API_OP_TRAJECTORIES, body);
    write_request(laws[0].request, &(struct units){0, 0, 0}, body, sizeof body);
    OWN(test_reply, free) modes = test_post(API_OP_MODES, body);
    double most = 0, hanging = 2 * atan(1);
    for (int k = 0; k < 2; k++) {
        char theta[32], rest[32];
        snprintf(theta, sizeof theta, "/theta/0/%d", k);
        snprintf(rest, sizeof rest, "/equilibrium/%d", k);
        most = fmax(most, fabs(test_reply_number(&start, theta) - hanging -
                               test_reply_number(&modes, rest)));
    }
    CHECK_SAYING(fabs(most - 0.1) < 1e-14, "an amplitude of %.17g, not 0.1", most);
}

/* Motions in pieces: closed forms, and digits of an independent reference.
 * Leaves to others: refused requests (refused.txt), inputs alone (core/tree/test_rules.c). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* a bar of 0.5 m and 0.6 kg, without gravity unless stated */
#define BAR "\"length\":0.5,\"mass\":0,\"rod\":0.6"
static const double inertia = 0.6 * 0.5 * 0.5 / 3;

static struct test_reply ask(const char *pendulum, const char *theta, const char *rest) {
    static char body[4000];
    snprintf(body, sizeof body,
             "{\"pendulum\":{%s},\"initial\":{\"theta\":[%s]},\"rtol\":1e-15,\"output\":[\"theta\","
             "\"thetad\",\"phidd\",\"lambda\",\"joint_force\",\"exchange\",\"energy\"],%s}",
             pendulum, theta, rest);
    struct test_reply reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    return reply;
}

static double number(const struct test_reply *reply, const char *name, int i, int k) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, k < 0 ? "/%s/%d" : "/%s/%d/%d", name, i, k);
    return test_reply_number(reply, pointer);
}

/* half swings of pi sqrt(J/k), each smaller by 2 f / k; at rest inside f / k */
TEST(a_spring_with_coulomb_friction_swings_as_the_closed_form_has_it) {
    const double f = 0.11, k = 2, half = M_PI * sqrt(inertia / k);
    double middle = f / k, far = 1 - middle, worst = 0;
    OWN(test_reply, free) reply =
        ask("\"gravity\":0,\"arms\":[{" BAR ",\"stiffness\":2,\"friction\":{"
            "\"torque\":0.11}}]",
            "1", "\"times\":{\"start\":0,\"stop\":5,\"count\":501}");
    for (int i = 0; i <= 500; i++) {
        double t = 5 * i / 500.0;
        int swing = (int)(t / half);
        // about +-f/k in turn, from 1; each half swing is smaller by 2 f / k
        double size = far - swing * 2 * middle, side = swing % 2 ? -1 : 1;
        double want = side * (middle + size * cos(M_PI * (t / half - swing)));
        if (swing >= 9) want = -(middle + far - 9 * 2 * middle) + 0 * t;
        worst = fmax(worst, fabs(number(&reply, "theta", i, 0) - want));
    }
    CHECK_RESIDUAL(worst, 1e-13, "half swings");
    CHECK_RESIDUAL(fabs(number(&reply, "exchange/heat", 500, -1) - (1 - 0.01 * 0.01)), 1e-13,
                   "their heat");
    CHECK(number(&reply, "thetad/500", 0, -1) == 0);
}

/* flights between impacts are a geometric series; then the bar rests on its stop */
TEST(a_bar_bounces_off_its_stop_as_the_closed_form_has_it) {
    const double a = 0.3 / inertia, e = 0.6;
    double begin = 0, v = 0, q = -0.25, worst = 0;
    OWN(test_reply, free) reply =
        ask("\"gravity\":0,\"arms\":[{" BAR
            ",\"torque\":0.3,\"stop\":{\"max\":0.25,\"restitution\":0.6}}]",
            "-0.25", "\"times\":{\"start\":0,\"stop\":2,\"count\":401}");
    for (int i = 0; i <= 400; i++) {
        double t = 2 * i / 400.0, flight;
        for (;;) {
            flight = begin == 0 ? sqrt(2 * 0.5 / a) : 2 * v / a;
            if (flight < 1e-9 || t <= begin + flight) break;
            v = begin == 0 ? e * a * flight : e * v;
            begin += flight, q = 0.25;
        }
        double x = t - begin, want = flight < 1e-9 ? 0.25 : q - v * x + a * x * x / 2;
        worst = fmax(worst, fabs(number(&reply, "theta", i, 0) - want));
    }
    CHECK_RESIDUAL(worst, 1e-13, "bounces");
    CHECK(fabs(number(&reply, "exchange/heat", 400, -1) - 0.15) < 1e-14);
    CHECK(number(&reply, "thetad/400", 0, -1) == 0);
}

/* a growing torque: the joint sticks up to its static friction, then slides against the smaller one
 */
TEST(a_joint_slips_where_its_holding_torque_comes_to_its_bound) {
    OWN(test_reply, free) reply = ask(
        "\"gravity\":0,\"arms\":[{" BAR ",\"friction\":{\"torque\":0.2,\"static\":0.3},\"torque\":{"
        "\"table\":{\"t\":[0,1],\"value\":[0,1],\"hold\":\"linear\"}}}]",
        "0.4", "\"times\":[0,0.25,0.7,1]");
    double x = 0.7 - 0.3, place = 0.4 + (0.1 * x * x / 2 + x * x * x / 6) / inertia;
    CHECK(fabs(number(&reply, "theta", 1, 0) - 0.4) < 1e-15);
    CHECK_RESIDUAL(fabs(number(&reply, "theta/2", 0, -1) - place), 1e-15, "after the slip");
    CHECK(fabs(number(&reply, "phidd", 2, 0) - (0.7 - 0.2) / inertia) < 1e-14);
}

/* in contact, friction keeps the joint at its stop after its torque has changed sign */
TEST(a_joint_with_friction_leaves_its_stop_late) {
    OWN(test_reply, free) reply = ask(
        "\"gravity\":0,\"arms\":[{" BAR ",\"friction\":{\"torque\":0.05},\"stop\":{\"max\":0.2},"
        "\"torque\":{\"table\":{\"t\":[0,2],\"value\":[0.3,-0.3],\"hold\":\"linear\"}}}]",
        "0.2", "\"times\":[0,1.1,2]");
    double x = 2 - 0.35 / 0.3, place = 0.2 - 0.3 * x * x * x / 6 / inertia;
    CHECK(fabs(number(&reply, "theta", 1, 0) - 0.2) < 1e-15);
    CHECK_RESIDUAL(fabs(number(&reply, "theta/2", 0, -1) - place), 2e-15, "after it has left");
}

/* a joint that never slips makes one rigid body of two arms, with forces inside it */
TEST(a_joint_that_holds_is_as_a_rigid_body) {
    OWN(test_reply, free) held =
        ask("\"arms\":[{\"name\":\"a\",\"length\":0.5,\"mass\":0.1,\"rod\":0.4},{\"name\":\"b\","
            "\"parent\":\"a\",\"length\":0.4,\"mass\":0.3,\"friction\":{\"torque\":99}},{\"name\":"
            "\"c\",\"parent\":\"b\",\"length\":0.3,\"mass\":0,\"rod\":0.2}]",
            "0.3,0.3,-0.4", "\"times\":[0,0.5,1]");
    OWN(test_reply, free) whole = ask(
        "\"arms\":[{\"name\":\"a\",\"length\":0.5,\"mass\":0.1,\"rod\":0.4,\"body\":{\"mass\":0.3,"
        "\"center\":0.9}},{\"name\":\"c\",\"parent\":\"a\",\"at\":0.9,\"length\":0.3,\"mass\":0,"
        "\"rod\":0.2}]",
        "0.3,-0.4", "\"times\":[0,0.5,1]");
    double gap = 0, force = 0;
    static const char *const rows[] = {"theta", "thetad", "phidd"};
    for (int i = 0; i < 3; i++) {
        for (int r = 0; r < 3; r++) {
            gap = fmax(gap, fabs(number(&held, rows[r], i, 0) - number(&whole, rows[r], i, 0)));
            gap = fmax(gap, fabs(number(&held, rows[r], i, 2) - number(&whole, rows[r], i, 1)));
        }
        CHECK(number(&held, "theta", i, 0) == number(&held, "theta", i, 1));
        force = fmax(force, fabs(number(&held, "joint_force/along", i, 0) -
                                 number(&whole, "joint_force/along", i, 0)));
        force = fmax(force, fabs(number(&held, "joint_force/across", i, 2) -
                                 number(&whole, "joint_force/across", i, 1)));
    }
    CHECK_SAYING(gap < 1e-13, "%g", gap);
    CHECK_RESIDUAL(force, 1e-12, "forces at its joints");
}

/* Three bars that stick, slide and hit: the digits of extrapolated midpoint steps in 40 digits with
 * a multiplier for each sticking joint, and events by secants, on which two of its step sizes agree
 * to 2e-29; 29 events. */
TEST(three_bars_stick_slide_and_hit_as_in_40_digits) {
    static const double theta[][3] = {
        {-0.10007785906300919282, 0.17618984977241791963, 0.21476445451312269143},
        {-1.1440981623129305917, -1.2872727845062613677, -0.84303115679531923592},
        {-0.0067768973665188727707, -0.10669748908369472808, 0.01198898875846514164},
        {1.034363942770082546, 1.2337572365915163292, 1.1748608122393911274},
        {0.14700404669288916031, -0.0047739107272493073355, -0.24411679130909551719}};
    OWN(test_reply, free) reply = ask(
        "\"arms\":[{\"name\":\"a\"," BAR ",\"friction\":{\"torque\":0.2}},{\"name\":\"b\","
        "\"parent\":\"a\",\"length\":0.4,\"mass\":0,\"rod\":0.6,\"friction\":{\"torque\":0.1,"
        "\"static\":0.15}},{\"name\":\"c\",\"parent\":\"b\",\"length\":0.3,\"mass\":0,\"rod\":0.6,"
        "\"friction\":{\"torque\":0.04},\"stop\":{\"min\":-1.5,\"max\":0.9,\"restitution\":0.5}}]",
        "1.5,0.9,0.4", "\"times\":[0,0.5,1,1.5,2,2.5]");
    double worst = 0;
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs(number(&reply, "theta", i + 1, k) - theta[i][k]));
    CHECK_RESIDUAL(worst, 1e-14, "three bars");
    CHECK_RESIDUAL(fabs(number(&reply, "exchange/heat", 5, -1) - 1.9882762285789358993), 1e-13,
                   "their heat");
    CHECK_RESIDUAL(test_reply_number(&reply, "/stats/energy_drift"), 1e-14, "their balance");
}

/* an elastic bar with gravity between two stops, 1e4 impacts; a joint that sticks twice per period
 * of the torque that drives it, 1e3 times */
TEST(work_heat_and_energy_balance_through_ten_thousand_bounces_and_a_thousand_sticks) {
    OWN(test_reply, free) reply = ask("\"arms\":[{" BAR ",\"stop\":{\"min\":-0.1,\"max\":0.1,"
                                      "\"restitution\":1}}]",
                                      "0],\"thetad\":[3", "\"times\":[0,1000]");
    CHECK_RESIDUAL(test_reply_number(&reply, "/stats/energy_drift"), 1e-13, "bounces");
    test_reply_free(&reply);
    reply = ask("\"gravity\":0,\"arms\":[{\"name\":\"a\"," BAR
                ",\"friction\":{\"torque\":0.5},\"torque\":{\"harmonics\":[{\"amplitude\":0.8,"
                "\"omega\":6.283185307179586}]}},{\"parent\":"
                "\"a\"," BAR ",\"friction\":{\"torque\":0.05}}]",
                "0,0.3", "\"times\":[0,500]");
    CHECK_RESIDUAL(test_reply_number(&reply, "/stats/energy_drift"), 1e-13, "sticks");
    CHECK(number(&reply, "exchange/heat", 1, -1) > 20);
}

/* members side by side, each with the pieces of its table, end like single motions */
TEST(members_of_an_ensemble_follow_a_table_as_a_motion_alone_does) {
    static const char pendulum[] =
        "\"arms\":[{\"length\":0.8,\"mass\":1,\"damping\":0.1,\"torque\":{\"table\":{\"t\":[0,0.3,"
        "0.7,1.2],\"value\":[2.2,-5.5,1,4],\"hold\":\"linear\"}}},{\"parent\":\"1\",\"length\":0.6,"
        "\"mass\":0.5}]";
    static char body[2000];
    double worst = 0;
    snprintf(body, sizeof body,
             "{\"pendulum\":{%s},\"states\":[{\"theta\":[0,1]},{\"theta\":[1,1]},{\"theta\":[2,1]}]"
             ",\"start\":0.1,\"duration\":1,\"rtol\":1e-15,\"observables\":[\"final\","
             "\"energy_drift\"]}",
             pendulum);
    OWN(test_reply, free) many = test_post(API_OP_ENSEMBLES, body);
    CHECK_SAYING(many.status == 200, "%s", many.out.data);
    for (int i = 0; i < 3; i++) {
        char theta[20];
        snprintf(theta, sizeof theta, "%d,1", i);
        OWN(test_reply, free) alone = ask(pendulum, theta, "\"times\":[0.1,1.1]");
        for (int k = 0; k < 2; k++)
            worst = fmax(worst, fabs(number(&alone, "theta", 1, k) - M_PI_2 -
                                     number(&many, "final/phi", i, k)));
        CHECK(number(&many, "energy_drift", i, -1) < 1e-14);
    }
    CHECK_RESIDUAL(worst, 1e-13, "members by a table");
}

/* a bar without gravity, driven from rest: theta - theta_0 is inversely proportional to its mass */
TEST(derivatives_and_fits_pass_through_tables) {
    static const char pendulum[] =
        "\"gravity\":0,\"arms\":[{" BAR ",\"torque\":{\"table\":{\"t\":[0,0.3,0.7,1.2],\"value\":["
        "0.2,-0.5,0.1,0.4],\"hold\":\"linear\"}}}]";
    static char body[2000];
    snprintf(body, sizeof body,
             "{\"pendulum\":{%s},\"initial\":{\"theta\":[0.1]},\"times\":[0,0.5,1.2],\"output\":["
             "\"theta\"],\"derivatives\":[{\"vary\":\"rod\",\"arm\":1}]}",
             pendulum);
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    for (int i = 1; i < 3; i++) {
        double want = -(number(&reply, "theta", i, 0) - 0.1) / 0.6;
        double found = test_reply_number(&reply, i == 1 ? "/derivatives/theta/1/0/0"
                                                        : "/derivatives/theta/2/0/0");
        CHECK_SAYING(fabs(found - want) < 1e-14, "%.17g for %.17g", found, want);
    }
    test_reply_free(&reply);
    snprintf(body, sizeof body,
             "{\"pendulum\":{%s},\"initial\":{\"theta\":[0.1]},\"data\":{\"t\":[0,0.3,0.6,0.9,1.2],"
             "\"series\":[{\"theta\":1,\"values\":[0.1,0.172,-0.248,-0.828,-1.16]}]},\"unknowns\":["
             "{\"vary\":\"rod\",\"arm\":1}]}",
             pendulum);
    reply = test_post(API_OP_FITS, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
}

/* the second arm lies on its stop when the first comes to rest, and stays: digits of 40 digits */
TEST(an_arm_on_its_stop_rests_when_the_arm_that_carries_it_stops) {
    static const double theta[] = {-0.66301846844888586, 0.33698153155111414};
    struct test_reply reply = ask(
        "\"arms\":[{\"length\":0.3,\"mass\":0.5,\"friction\":{\"torque\":1.25}},{\"parent\":\"1\","
        "\"length\":1,\"mass\":0.5,\"friction\":{\"torque\":0.125},\"torque\":9,\"stop\":{\"min\":"
        "-0.125,\"max\":1,\"restitution\":0.5}}]",
        "0,0", "\"times\":[0,1,3]");
    for (int k = 0; k < 2; k++) {
        CHECK(fabs(number(&reply, "theta", 2, k) - theta[k]) < 1e-13);
        CHECK(number(&reply, "thetad", 2, k) == 0);
    }
    test_reply_free(&reply);
}

/* data of a damped arm along a spline by SciPy's DOP853 */
TEST(fits_along_a_pivot_find_the_length_the_friction_and_the_start) {
    struct test_reply reply = test_post(
        API_OP_FITS,
        "{\"pendulum\":{\"arms\":[{\"length\":0.5,\"mass\":1,\"damping\":0.02}],\"pivot\":{\"x\":{"
        "\"table\":{\"t\":[0,0.5,1,1.5,2],\"value\":[0,0.2,-0.1,0.15,0]}}}},\"initial\":{\"theta\":"
        "["
        "0.3]},\"data\":{\"t\":[0,0.25,0.5,0.75,1,1.25,1.5,1.75,2],\"series\":[{\"theta\":1,"
        "\"values\":[0.4,0.20289632147,0.040437830465,0.22437326054,0.06146472391,-0.61844125563,"
        "-0.64546187715,0.34466036784,1.0990923046]}]},\"unknowns\":[{\"vary\":\"length\",\"arm\":"
        "1},"
        "{\"vary\":\"damping\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1}]}");
    static const double want[] = {0.43, 0.05, 0.4};
    double worst = 0;
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    for (int i = 0; i < 3; i++) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/unknowns/%d/value", i);
        worst = fmax(worst, fabs(test_reply_number(&reply, pointer) - want[i]));
    }
    CHECK_RESIDUAL(worst, 1e-10, "unknowns along a spline");
    test_reply_free(&reply);
}

/* a double pendulum after 24 s of chaos: digits of a computation in 40 digits by multipliers,
 * which doubles have lost */
TEST(numbers_of_32_digits_follow_a_table_where_doubles_are_lost) {
    static const double want[] = {19.72879081980146, 7.421768452722298};
    for (int extended = 0; extended < 2; extended++) {
        char body[600];
        snprintf(
            body, sizeof body,
            "{\"pendulum\":{\"arms\":[{\"length\":1,\"mass\":1,\"torque\":{\"table\":{\"t\":[0,5,"
            "10,15,20,40],\"value\":[1,-2,1.5,-0.5,1,0],\"hold\":\"zero\"}}},{\"parent\":\"1\","
            "\"length\":1,\"mass\":1}]},\"initial\":{\"theta\":[2,2.5]},\"times\":[0,16,24],"
            "\"output\":[\"theta\"],%s}",
            extended ? "\"precision\":\"extended\"" : "\"rtol\":1e-15,\"trust\":true");
        struct test_reply reply = test_post(API_OP_TRAJECTORIES, body);
        double worst = 0;
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        for (int k = 0; k < 2; k++)
            worst = fmax(worst, fabs(number(&reply, "theta", 2, k) - want[k]));
        CHECK_SAYING(extended ? worst < 1e-14 : worst > 1e-4, "%g", worst);
        CHECK(test_reply_number(&reply, extended ? "/stats/horizon" : "/stats/trust_until") ==
              (extended ? 24 : 16));
        test_reply_free(&reply);
    }
}

/* a bar whose pivot follows a spline: the digits of a Taylor solver in 30 digits */
TEST(a_pivot_follows_the_natural_spline_through_its_places) {
    static const char pendulum[] = "\"arms\":[{" BAR "}],\"pivot\":{\"x\":{\"table\":{\"t\":[0,"
                                   "0.25,0.75,1.25,2],\"value\":[0,0.25,-0.125,0.1875,0]}}}";
    static const double theta[] = {0.3449045917013090740826, 0.1574876200803062838502,
                                   -1.527024737902296395533, 2.068819005823300209106};
    OWN(test_reply, free) reply = ask(pendulum, "0.4", "\"times\":[0,0.25,0.75,1.25,2]");
    double worst = 0;
    for (int i = 0; i < 4; i++)
        worst = fmax(worst, fabs(number(&reply, "theta", i + 1, 0) - theta[i]));
    CHECK_RESIDUAL(worst, 1e-14, "along the spline");
    CHECK_RESIDUAL(test_reply_number(&reply, "/stats/energy_drift"), 1e-14, "the pivot's work");
    CHECK(test_reply_number(&reply, "/stats/horizon") == 2);
    double theta0 = number(&reply, "theta", 4, 0), rate = number(&reply, "thetad", 4, 0);
    test_reply_free(&reply);
    char start[80];
    snprintf(start, sizeof start, "%.17g],\"thetad\":[%.17g", theta0, rate);
    reply = ask(pendulum, start, "\"times\":{\"start\":2,\"stop\":0,\"count\":2}");
    CHECK_RESIDUAL(fabs(number(&reply, "theta", 1, 0) - 0.4), 1e-13, "and back");
}

/* derivatives with respect to numbers of the pendulum, members and positions along the spline,
 * against differences of motions and positions of the table */
TEST(derivatives_members_and_conditions_follow_a_pivot) {
    static const char form[] =
        "{\"pendulum\":{\"arms\":[{\"length\":%.17g,\"mass\":1}],\"pivot\":{\"x\":{\"table\":{"
        "\"t\":[0,0.25,0.75,2],\"value\":[0,0.25,-0.125,0]}}}},%s,\"rtol\":1e-15}";
    static const char tell[] =
        "\"initial\":{\"theta\":[0.4]},\"times\":[0,0.75,1],\"output\":[\"theta\",\"z\"]";
    char body[1000], rest[400];
    double z[3];
    for (int i = 0; i < 3; i++) {
        snprintf(rest, sizeof rest, "%s%s", tell,
                 i ? "" : ",\"derivatives\":[{\"vary\":\"length\",\"arm\":1}]");
        snprintf(body, sizeof body, form, i ? 0.5 + (i - 1.5) * 2e-4 : 0.5, rest);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        z[i] =
            i ? number(&reply, "z/re", 2, 0) : test_reply_number(&reply, "/derivatives/z_re/2/0/0");
    }
    CHECK_RESIDUAL(fabs((z[2] - z[1]) / 2e-4 - z[0]), 1e-7, "derivatives along a spline");
    snprintf(body, sizeof body, form, 0.5,
             "\"initial\":{\"theta\":[0.4]},\"times\":[0,1],\"output\":[\"theta\"],\"events\":[{"
             "\"of\":\"x\",\"arm\":1,\"value\":-0.3,\"stop\":1}]");
    struct test_reply hit = test_post(API_OP_TRAJECTORIES, body);
    double t = test_reply_number(&hit, "/events/0/t");
    test_reply_free(&hit);
    snprintf(rest, sizeof rest,
             "\"states\":[{},{\"theta\":[0.4]},{}],\"duration\":%.17g,\"observables\":[\"final\","
             "\"energy_drift\"]",
             t);
    snprintf(body, sizeof body, form, 0.5, rest);
    OWN(test_reply, free) many = test_post(API_OP_ENSEMBLES, body);
    CHECK(number(&many, "energy_drift", 1, -1) < 1e-14);
    snprintf(rest, sizeof rest,
             "\"initial\":{\"theta\":[0.4]},\"times\":[0,%.17g],\"output\":[\"theta\",\"z\"]", t);
    snprintf(body, sizeof body, form, 0.5, rest);
    OWN(test_reply, free) alone = test_post(API_OP_TRAJECTORIES, body);
    CHECK_RESIDUAL(fabs(number(&alone, "z/re", 1, 0) + 0.3), 1e-14, "the condition");
    CHECK_RESIDUAL(fabs(number(&many, "final/phi", 1, 0) + M_PI_2 - number(&alone, "theta", 1, 0)),
                   1e-14, "a member along a spline");
}

/* each impact is reported before and after it; the flights are the geometric series of the
 * bounces */
TEST(impacts_are_events_before_and_after) {
    static const char body[] =
        "{\"pendulum\":{\"gravity\":0,\"arms\":[{" BAR ",\"torque\":0.3,\"stop\":{\"max\":0.25,"
        "\"restitution\":0.6}}]},\"initial\":{\"theta\":[-0.25]},\"rtol\":1e-15,\"times\":[0,1.5],"
        "\"rows\":\"events\",\"events\":[{\"of\":\"impact\",\"arm\":1}]}";
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    const double a = 0.3 / inertia;
    double t = sqrt(1 / a), v = a * t, worst = 0;
    int rows = (int)test_reply_number(&reply, "/stats/events");
    CHECK_SAYING(rows >= 8 && rows % 2 == 0, "%d", rows);
    for (int i = 0; i < rows; i += 2) {
        worst = fmax(worst, fabs(number(&reply, "t", i, -1) - t));
        worst = fmax(worst, fabs(number(&reply, "phid", i, 0) - v));
        worst = fmax(worst, fabs(number(&reply, "phid", i + 1, 0) + 0.6 * v));
        CHECK(number(&reply, "t", i, -1) == number(&reply, "t", i + 1, -1));
        CHECK(number(&reply, "direction", i, -1) == 1);
        v *= 0.6, t += 2 * v / a;
    }
    CHECK_RESIDUAL(worst, 1e-13, "impacts");
}

TEST(answers_say_why_they_have_no_horizon) {
#define ARM "\"arms\":[{\"length\":1,\"mass\":1"
#define SEEN ",\"initial\":{\"theta\":[1]},\"times\":[0,2]"
    static const struct {
        enum api_op_id op;
        const char *body, *why;
    } rows[] = {
        {API_OP_TRAJECTORIES, ARM ",\"friction\":{\"torque\":0.1}}]}" SEEN, "stick or hit a stop"},
        {API_OP_TRAJECTORIES,
         ARM "}],\"control\":[{\"joint\":1,\"period\":0.1,\"law\":{\"pid\":{\"p\":1,\"reference\":"
             "0}}}]}" SEEN,
         "through controllers"},
        {API_OP_TRAJECTORIES,
         ARM ",\"stop\":{\"min\":-0.2}}]}" SEEN
             ",\"rows\":\"events\",\"events\":[{\"of\":\"theta\",\"arm\":1,\"value\":0}]",
         "stick or hit a stop"},
        {API_OP_SECTIONS,
         ARM ",\"stop\":{\"min\":-0.2}}]},\"initial\":{\"theta\":[1]},\"duration\":2,\"section\":{"
             "\"arm\":1,\"theta\":0}",
         "stick or hit a stop"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char body[600];
        snprintf(body, sizeof body, "{\"pendulum\":{%s}", rows[i].body);
        OWN(test_reply, free) reply = test_post(rows[i].op, body);
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        const char *why = test_reply_text(&reply, "/stats/no_horizon");
        CHECK(why && strstr(why, rows[i].why) && !strstr(reply.out.data, "\"horizon\""));
    }
}

/* pendubot and acrobot: energy by the motor in one joint, then a feedback; without a limit a lost
 * pendulum is whirled ever faster */
TEST(a_motor_in_one_joint_swings_two_arms_up_and_one_without_a_limit_ends) {
    static const char *const gains[] = {"-1.88,-18.57,-2.63,-3.87", "-68.12,-36.88,-18.6,-11.88"};
    for (int i = 0; i < 3; i++) {
        char body[1000];
        snprintf(
            body, sizeof body,
            "{\"pendulum\":{\"length\":[0.5,0.5],\"mass\":[0.2,0.2],\"parent\":[0,1],\"damping\":["
            "0.002,0.002],\"control\":[{\"joint\":%d,\"period\":0.01,%s\"law\":{\"swing_up\":{"
            "\"gain\":%d,"
            "\"within\":{\"theta\":0.4,\"thetad\":3},\"then\":{\"feedback\":{\"gains\":[%s],"
            "\"reference\":["
            "3.141592653589793,3.141592653589793,0,0]}}}}}]},\"initial\":{\"theta\":[%s],\"unit\":"
            "\"deg\"},\"times\":[0,10],\"output\":[\"theta\"]}",
            i ? 2 : 1, i < 2 ? "\"limit\":[-3,3]," : "", i < 2 ? 2 : 2000, gains[i > 0],
            i ? "57,0" : "10,90");
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_SAYING(reply.status == (i == 2 ? 422 : 200), "%s", reply.out.data);
        for (int k = 0; k < 2 && i < 2; k++)
            CHECK(fabs(remainder(number(&reply, "theta", 1, k) - M_PI, 2 * M_PI)) < 1e-3);
        CHECK((i == 2) == (strstr(reply.out.data, "give them a \\\"limit\\\"") != NULL));
    }
}

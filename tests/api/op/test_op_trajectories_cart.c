/* Tests of requests with a pivot on a cart: its start, its columns in every operation, axes over
 * its numbers, and refusals. Leaves to others: the equations (laws/test_cart), errors of its fields
 * (test_terms_json). Invariant: arms of an answer are those of the request; the cart's numbers are
 * separate. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define CART                                                                                       \
    "\"pendulum\":{\"length\":[1,0.5,0.7],\"mass\":[1,2,1],\"parent\":[0,1,0],\"pivot\":{"         \
    "\"cart\":"                                                                                    \
    "{\"mass\":2,\"angle\":0.2,\"damping\":0.3,\"stiffness\":20,\"force\":{\"constant\":1,"        \
    "\"harmonics\":[{\"amplitude\":2,\"omega\":3}]}}}}"
#define START "{\"phi\":[-1,0.5,-2],\"phid\":[0.3,0,1],\"cart\":{\"x\":0.1,\"v\":-0.4}}"

TEST(a_tree_on_a_cart_is_told_as_it_was_given) {
    OWN(test_reply, free) reply = test_post(API_OP_TREES, "{" CART "}");
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/n") == 3);
    CHECK(test_reply_number(&reply, "/pivot/cart/mass") == 2);
    CHECK(test_reply_number(&reply, "/pivot/cart/angle") == 0.2);
    CHECK(test_reply_number(&reply, "/pivot/cart/stiffness") == 20);
    CHECK(test_reply_number(&reply, "/pivot/cart/force/constant") == 1);
    CHECK(test_reply_number(&reply, "/pivot/cart/force/harmonics/0/omega") == 3);
    CHECK(test_reply_number(&reply, "/length_total") == 2.2);
    CHECK(test_reply_number(&reply, "/subtree_mass/0") == 3);
    CHECK(test_reply_number(&reply, "/depth/1") == 2 && test_reply_number(&reply, "/depth/2") == 1);
    CHECK(test_reply_number(&reply, "/parent/2") == 0);
    CHECK(test_reply_number(&reply, "/S/1/0") == 1 && test_reply_number(&reply, "/S/2/0") == 0);
    CHECK(strstr(reply.out.data, "\"S\":[[1,0,0],[1,1,0],[0,0,1]]"));
    CHECK(strstr(reply.out.data, "\"B\":[[1,-1,0],[0,1,0],[0,0,1]]"));
}

/* the answer of a method, or of 32 digits, at nine instants */
static struct test_reply long_run(const char *more) {
    char body[800];
    snprintf(body, sizeof body,
             "{" CART ",\"initial\":" START ",\"times\":{\"stop\":16,\"count\":9},%s}", more);
    return test_post(API_OP_TRAJECTORIES, body);
}

TEST(trust_on_a_cart_ends_where_the_angles_part) {
    static const char *const method[] = {"\"method\":\"rk8pd\",\"trust\":1e-6",
                                         "\"method\":\"rkf45\",\"rtol\":1e-5,\"trust\":1e-3",
                                         "\"method\":\"ode23\",\"trust\":0.01"};
    static const double bound[] = {1e-6, 1e-3, 0.01};
    OWN(test_reply, free) exact = long_run("\"precision\":\"extended\"");
    for (int m = 0; m < 3; m++) {
        OWN(test_reply, free) reply = long_run(method[m]);
        CHECK_INT(reply.status, 200);
        double until = 0;
        for (int i = 0, parted = 0; i < 9; i++) {
            for (int k = 0; k < 3; k++) {
                char at[40];
                snprintf(at, sizeof at, "/phi/%d/%d", i, k);
                parted |=
                    fabs(test_reply_number(&reply, at) - test_reply_number(&exact, at)) > bound[m];
            }
            if (!parted) until = 2 * i;
        }
        CHECK(until > 0 || m == 2);
        CHECK(test_reply_number(&reply, "/stats/trust_until") == until);
    }
}

TEST(a_trajectory_on_a_cart_agrees_with_the_forces_of_its_states) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES,
                  "{" CART ",\"initial\":" START ",\"times\":[0,0.001],\"rtol\":1e-14,\"output\":["
                  "\"phi\",\"cart\",\"z\",\"phid\",\"energy\",\"exchange\",\"joint_force\"]}");
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/cart/x/0") == 0.1);
    CHECK(test_reply_number(&reply, "/cart/v/0") == -0.4);
    CHECK(test_reply_number(&reply, "/phi/0/2") == -2);
    // both arms of the pivot begin at the cart
    CHECK(fabs(test_reply_number(&reply, "/z/re/0/2") - 0.1 * cos(0.2) - 0.7 * cos(2)) < 1e-15);
    double speed = test_reply_number(&reply, "/cart/v/1"), sum = 0;
    OWN(test_reply, free) forces = test_post(API_OP_FORCES, "{" CART ",\"state\":" START "}");
    CHECK_INT(forces.status, 200);
    double acc = test_reply_number(&forces, "/cart/acceleration");
    CHECK(fabs((speed + 0.4) / 0.001 - acc) < 0.05);
    double reaction = test_reply_number(&forces, "/cart/reaction");
    CHECK(fabs(test_reply_number(&reply, "/cart/reaction/0") / reaction - 1) < 1e-13);
    // energy minus work plus heat is constant
    static const char *const part[] = {"/energy/total/1", "/energy/total/0", "/exchange/work/1",
                                       "/exchange/heat/1"};
    static const double sign[] = {1, -1, -1, 1};
    for (int i = 0; i < 4; i++) sum += sign[i] * test_reply_number(&reply, part[i]);
    CHECK(fabs(sum) < 1e-13);
}

TEST(every_method_and_precision_gives_the_same_motion_on_a_cart) {
    static const char *const ways[] = {"\"method\":\"taylor\"", "\"method\":\"rk8pd\"",
                                       "\"method\":\"msadams\"", "\"method\":\"ode23\"",
                                       "\"precision\":\"extended\""};
    double first[2] = {0, 0};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        char body[700];
        snprintf(body, sizeof body,
                 "{" CART ",\"initial\":" START
                 ",\"times\":[0.5,1],%s,%s\"output\":[\"cart\",\"phi\",\"energy\",\"exchange\"]}",
                 ways[i], i == 3 ? "\"rtol\":1e-9,\"atol\":1e-10," : "");
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_SAYING(reply.status == 200, "%s: %.300s", ways[i], reply.out.data);
        double x = test_reply_number(&reply, "/cart/x/1"),
               phi = test_reply_number(&reply, "/phi/1/1");
        if (!i) first[0] = x, first[1] = phi;
        double gap = fmax(fabs(x - first[0]), fabs(phi - first[1]));
        CHECK_SAYING(gap < (i == 3 ? 1e-6 : 1e-9), "%s: %g", ways[i], gap);
        // energy minus work plus heat is constant, with every method
        double sum = test_reply_number(&reply, "/energy/total/1") -
                     test_reply_number(&reply, "/energy/total/0") -
                     test_reply_number(&reply, "/exchange/work/1") +
                     test_reply_number(&reply, "/exchange/heat/1");
        CHECK_SAYING(fabs(sum) < (i == 3 ? 1e-5 : 1e-8), "%s: balance %g", ways[i], sum);
    }
}

TEST(modes_on_a_cart_count_it) {
    OWN(test_reply, free) reply = test_post(
        API_OP_MODES, "{\"pendulum\":{\"length\":[0.4],\"mass\":[1],\"parent\":[0],\"pivot\":{"
                      "\"cart\":{\"mass\":3}}}}");
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/omega/0") == 0);
    double omega = sqrt((1 + 1.0 / 3) * 9.81 / 0.4);
    CHECK(fabs(test_reply_number(&reply, "/omega/1") / omega - 1) < 1e-14);
    CHECK(test_reply_number(&reply, "/cart/equilibrium") == 0);
    CHECK(fabs(test_reply_number(&reply, "/cart/re/1") + 0.1) < 1e-14);
    CHECK(test_reply_number(&reply, "/vectors/re/1/0") == 1);
}

TEST(members_on_a_cart_vary_in_its_numbers) {
    static const char *const names[] = {"mass", "damping", "stiffness",        "phi",
                                        "phid", "torque",  "torque_amplitude", "torque_omega"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char body[700];
        snprintf(
            body, sizeof body,
            "{" CART
            ",\"duration\":1,\"observables\":[\"final\",\"cart\",\"lyapunov\"],\"initial\":" START
            ",\"grid\":[{\"vary\":\"%s\",\"arm\":\"cart\",\"start\":1,\"stop\":2,\"count\":2}]}",
            names[i]);
        OWN(test_reply, free) reply = test_post(API_OP_ENSEMBLES, body);
        CHECK_SAYING(reply.status == 200, "%s: %.300s", names[i], reply.out.data);
        CHECK(test_reply_number(&reply, "/cart/x/0") != test_reply_number(&reply, "/cart/x/1"));
        CHECK(test_reply_number(&reply, "/final/phi/0/2") !=
              test_reply_number(&reply, "/final/phi/1/2"));
    }
    // a member ends where a trajectory does
    OWN(test_reply, free) one =
        test_post(API_OP_ENSEMBLES, "{" CART ",\"duration\":1,\"observables\":[\"cart\",\"final\"],"
                                    "\"states\":[" START "]}");
    OWN(test_reply, free) alone =
        test_post(API_OP_TRAJECTORIES,
                  "{" CART ",\"initial\":" START ",\"times\":[0,1],\"output\":[\"cart\",\"phi\"]}");
    CHECK(fabs(test_reply_number(&one, "/cart/x/0") - test_reply_number(&alone, "/cart/x/1")) <
          1e-11);
    CHECK(fabs(test_reply_number(&one, "/final/phi/0/2") - test_reply_number(&alone, "/phi/1/2")) <
          1e-10);
}

TEST(two_metronomes_on_a_cart_with_friction_end_against_each_other) {
    // Huygens' clocks: the motion that moves the cart decays
    OWN(test_reply, free) reply = test_post(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"length\":[0.25,0.25],\"mass\":[0.1,0.1],\"parent\":[0,0],\"pivot\":{"
        "\"cart\":{\"mass\":0.6,\"damping\":0.3}}},\"initial\":{\"theta\":[0.4,0.05]},\"times\":{"
        "\"stop\":120,\"step\":0.5},\"output\":[\"theta\",\"cart\"]}");
    CHECK_INT(reply.status, 200);
    double together = 0, apart = 0;
    for (int i = 200; i <= 240; i++) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/theta/%d/0", i);
        double first = test_reply_number(&reply, pointer);
        snprintf(pointer, sizeof pointer, "/theta/%d/1", i);
        double second = test_reply_number(&reply, pointer);
        together = fmax(together, fabs(first + second));
        apart = fmax(apart, fabs(first - second));
    }
    CHECK_SAYING(together < 0.02 && apart > 0.3, "together %g, apart %g", together, apart);
}

TEST(a_real_pendulum_that_starts_in_a_mode_stays_in_it) {
    // after a period the small motion equals the start, reduced by the decay
    static const char pendulum[] =
        "\"pendulum\":{\"length\":[1,0.6],\"mass\":[1,0.5],\"parent\":[0,1],\"rod\":[0.5,null],"
        "\"damping\":[0.2,0.05],\"stiffness\":[1,null],\"pivot\":{\"cart\":{\"mass\":2,"
        "\"stiffness\":50,\"damping\":0.3}}}";
    char body[900];
    snprintf(body, sizeof body, "{%s}", pendulum);
    OWN(test_reply, free) modes = test_post(API_OP_MODES, body);
    for (int i = 0; i < 4; i++) {
        // at the fourth time another mode's period is tested, which is not a period of this one
        char at[40];
        int j = i < 3 ? i : 2, mode = i < 3 ? i + 1 : 2;
        snprintf(at, sizeof at, "/omega/%d", j);
        double omega = test_reply_number(&modes, at);
        snprintf(at, sizeof at, "/decay/%d", j);
        double shrunk = exp(-test_reply_number(&modes, at) * 2 * M_PI / omega);
        snprintf(body, sizeof body,
                 "{%s,\"initial\":{\"mode\":%d,\"amplitude\":1e-6},\"times\":[0,%.17g],\"output\":["
                 "\"theta\",\"cart\"]}",
                 pendulum, mode, 2 * M_PI / omega);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply.status, 200);
        double gap = fabs(test_reply_number(&reply, "/cart/x/1") -
                          shrunk * test_reply_number(&reply, "/cart/x/0"));
        gap = fmax(gap, fabs(test_reply_number(&reply, "/theta/1/1") -
                             shrunk * test_reply_number(&reply, "/theta/0/1")));
        CHECK_SAYING(i == 3 || gap < 1e-11, "mode %d: %g", mode, gap);
        CHECK(i < 3 || gap > 1e-9);
    }
}

TEST(all_modes_of_an_arm_on_a_free_cart_can_be_started_in) {
    // it slides, or it swings, each by the requested amount
    static const char body[] = "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],"
                               "\"pivot\":{\"cart\":{\"mass\":1}}},\"initial\":{\"mode\":%d,"
                               "\"amplitude\":0.1},\"times\":[0],\"output\":[\"theta\",\"cart\"]}";
    for (int mode = 1; mode <= 2; mode++) {
        char asked[300];
        snprintf(asked, sizeof asked, body, mode);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, asked);
        CHECK_INT(reply.status, 200);
        double theta = test_reply_number(&reply, "/theta/0/0");
        double place = test_reply_number(&reply, "/cart/x/0");
        CHECK(mode == 1 ? theta == 0 && place == 0.1 : fabs(fabs(theta) - 0.1) < 1e-15);
        // the common center of mass stays where it is
        CHECK(mode == 1 || fabs(2 * place + theta) < 1e-12);
    }
}

/* on a cart without friction and drives the symplectic method gives the motion of the others */
TEST(a_cart_without_losses_moves_by_the_symplectic_method_as_by_taylor) {
    static const char *const method[] = {"taylor", "symplectic"};
    struct test_reply reply[2];
    for (int i = 0; i < 2; i++) {
        char body[400];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1],\"pivot\":{"
                 "\"cart\":{\"mass\":2,\"angle\":0.2,\"stiffness\":20}}},\"times\":[0,1,2],"
                 "\"method\":\"%s\",\"output\":[\"phi\",\"cart\"]}",
                 method[i]);
        reply[i] = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply[i].status, 200);
        CHECK(test_reply_number(&reply[i], "/stats/energy_drift") < 1e-13);
    }
    double gap =
        fabs(test_reply_number(&reply[0], "/phi/2/1") - test_reply_number(&reply[1], "/phi/2/1"));
    gap = fmax(gap, fabs(test_reply_number(&reply[0], "/cart/x/2") -
                         test_reply_number(&reply[1], "/cart/x/2")));
    CHECK_RESIDUAL(gap, 1e-12, "a cart by two methods");
    for (int i = 0; i < 2; i++) test_reply_free(&reply[i]);
}

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define TWO "\"pendulum\":{\"length\":[1,0.6],\"mass\":[1,2],\"parent\":[0,1]}"
/* springs, rods, and a pivot that moves */
#define REAL                                                                                       \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":1,\"mass\":1,\"rod\":0.5,\"stiffness\":3," \
    "\"rest\":0.2},{\"parent\":\"a\",\"length\":0.6,\"mass\":2}],\"pivot\":{\"x\":{\"harmonics\":" \
    "[{\"amplitude\":0.1,\"omega\":5,\"phase\":1}]}}}"

/* the energy of a trajectory at the start of member i of a reply with starts */
static double energy_of(const char *pendulum, const struct test_reply *reply, int i, double time) {
    char body[900], at[40], *end = body;
    OWN(test_reply, free) one;
    end += sprintf(end, "{%s,\"time\":%g,\"state\":{", pendulum, time);
    for (int part = 0; part < 2; part++) {
        end += sprintf(end, "%s\"%s\":[", part ? "," : "", part ? "phid" : "phi");
        for (int k = 0; k < 2; k++) {
            snprintf(at, sizeof at, "/start/%s/%d/%d", part ? "phid" : "phi", i, k);
            end += sprintf(end, "%s%.17g", k ? "," : "", test_reply_number(reply, at));
        }
        end += sprintf(end, "]");
    }
    strcpy(end, "}}");
    one = test_post(API_OP_FORCES, body);
    return test_reply_number(&one, "/energy/total");
}

TEST(members_start_on_the_energy_that_is_asked_for) {
    static const struct {
        const char *pendulum, *members;
        double energy, more, time;
    } ask[] = {
        {TWO,
         "\"energy\":40,\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":-3,\"stop\":3,\"count\":"
         "5}],\"initial\":{\"theta\":[0,1],\"thetad\":[1,-2]}",
         40, 0, 0},
        {TWO,
         "\"grid\":[{\"vary\":\"energy\",\"start\":10,\"stop\":50,\"count\":5}],\"initial\":{"
         "\"theta\":[1,1],\"thetad\":[1,0]}",
         10, 10, 0},
        {TWO,
         "\"members\":[{\"energy\":20},{\"energy\":25},{\"energy\":30},{\"energy\":35},{\"energy\":"
         "40}],\"initial\":{\"theta\":[0,0],\"thetad\":[1,3]}",
         20, 5, 0},
        {TWO,
         "\"energy\":30,\"states\":[{\"phid\":[1,1],\"phi\":[0,0]},{\"theta\":[0,0],\"thetad\":[0,"
         "1]},{\"theta\":[1,1],\"thetad\":[-1,0]},{\"theta\":[1,0],\"thetad\":[9,9]},{\"theta\":[1,"
         "2],\"thetad\":[9,-9]}]",
         30, 0, 0},
        {REAL,
         "\"energy\":60,\"start\":0.3,\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":-2,"
         "\"stop\":2,\"count\":5}],\"initial\":{\"theta\":[0,1],\"thetad\":[1,-2]}",
         60, 0, 0.3},
    };
    double worst = 0;
    for (size_t j = 0; j < sizeof ask / sizeof *ask; j++) {
        char body[900];
        snprintf(body, sizeof body, "{%s,%s,\"duration\":0.1,\"observables\":[\"start\"]}",
                 ask[j].pendulum, ask[j].members);
        OWN(test_reply, free) reply = test_post(API_OP_ENSEMBLES, body);
        CHECK_SAYING(reply.status == 200, "%.300s", reply.out.data);
        for (int i = 0; i < 5; i++) {
            double wanted = ask[j].energy + i * ask[j].more,
                   got = energy_of(ask[j].pendulum, &reply, i, ask[j].time);
            worst = fmax(worst, fabs(got - wanted) / wanted);
        }
    }
    CHECK_RESIDUAL(worst, 1e-13, "energies of starts, relative");
}

TEST(rates_keep_their_direction_and_members_that_cannot_have_the_energy_say_so) {
    OWN(test_reply, free) reply = test_post(
        API_OP_ENSEMBLES,
        "{" TWO ",\"energy\":-20,\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":0,\"stop\":3,"
        "\"count\":2}],\"initial\":{\"theta\":[0,0],\"thetad\":[1,-2]},\"duration\":1,"
        "\"observables\":[\"start\",\"final\"]}");
    CHECK(test_reply_number(&reply, "/status/0") == 0);
    CHECK(test_reply_number(&reply, "/status/1") == 1);
    double first = test_reply_number(&reply, "/start/phid/0/0"),
           second = test_reply_number(&reply, "/start/phid/0/1");
    CHECK(first > 0 && fabs(second + 2 * first) < 1e-15 * first * 4);
    CHECK(test_reply_number(&reply, "/stats/failed") == 1);
    test_reply_free(&reply);
    // the energy of the angles alone: at rest, to the last digit
    reply = test_post(API_OP_ENSEMBLES,
                      "{" TWO ",\"energy\":0,\"states\":[{\"phi\":[0,0],\"phid\":[1,1]}],"
                      "\"duration\":1,\"observables\":[\"start\"]}");
    CHECK(test_reply_number(&reply, "/start/phid/0/0") == 0);
    CHECK(test_reply_number(&reply, "/status/0") == 0);
}

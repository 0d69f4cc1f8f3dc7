/* The cost of searching for events of a double pendulum over 20 s, compared with the run alone, and
 * of the response of 1000 arms at a frequency.
 * Leaves to others: samples of a run (bench_trajectory).
 * Invariant: the timed code has to succeed. */
#include <stdlib.h>

#include "core/integrate/events/events.h"
#include "core/integrate/run/run.h"
#include "core/modes/response.h"
#include "tests/bench/parts/bench.h"

enum { CHAIN = 1000, CONDITIONS = 11 };

static const double length[] = {1, 1}, mass[] = {1, 1}, start[] = {0, 0.1}, rest[] = {0, 0};
static const int parent[] = {-1, 0};

static struct pend_event condition(enum pend_quantity quantity, int arm, double level) {
    return (struct pend_event){.quantity = quantity,
                               .arm = arm,
                               .other = 1 - arm,
                               .level = level,
                               .ways = PEND_WAY_UP | PEND_WAY_DOWN,
                               .most = 1000000};
}

static void look_for(struct bench *bench, int count, const struct pend_event event[]) {
    struct pend_tree *tree;
    if (pend_tree_new(&tree, 2, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    const struct pend_events_problem problem = {.tree = tree,
                                                .loads.gravity = 9.81,
                                                .phi = start,
                                                .rate = rest,
                                                .duration = 20,
                                                .count = count,
                                                .event = event};
    while (bench_go(bench, 1)) {
        struct pend_events *events;
        struct pend_hit hit;
        enum pend_found found = PEND_FOUND_NOTHING;
        double phi[2], rate[2];
        if (pend_events_new(&events, &problem, NULL) != PEND_OK) bench_broken("events");
        while (found != PEND_FOUND_END)
            if (pend_events_next(events, 1000, &found, &hit, phi, rate, NULL) != PEND_OK)
                bench_broken("events");
        pend_events_free(&events);
    }
    pend_tree_free(&tree);
}

/* a level that is never reached shows the cost per step */
static void look(struct bench *bench, enum pend_quantity quantity, double level) {
    const struct pend_event event = condition(quantity, 1, level);
    look_for(bench, 1, &event);
}

/* the first of eleven conditions, all of which occur */
static void look_for_first(struct bench *bench, int count) {
    const struct pend_event event[CONDITIONS] = {
        condition(PEND_QUANTITY_PHI, 1, -1),       condition(PEND_QUANTITY_RATE, 1, 0),
        condition(PEND_QUANTITY_FORCE, 0, -10),    condition(PEND_QUANTITY_X, 1, 0),
        condition(PEND_QUANTITY_PHI, 0, -1),       condition(PEND_QUANTITY_RATE, 0, 0),
        condition(PEND_QUANTITY_FORCE, 1, 0),      condition(PEND_QUANTITY_Y, 1, -1),
        condition(PEND_QUANTITY_KINETIC, 0, 5),    condition(PEND_QUANTITY_POTENTIAL, 0, -10),
        condition(PEND_QUANTITY_DISTANCE, 0, 0.99)};
    look_for(bench, count, event);
}

/* the same motion without conditions */
BENCH(events_0, "run") {
    struct pend_tree *tree;
    double t[2], out[2][4];
    if (pend_tree_new(&tree, 2, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    const struct pend_problem problem = {.tree = tree,
                                         .loads.gravity = 9.81,
                                         .phi = start,
                                         .rate = rest,
                                         .times = {.count = 2, .span = 20, .divisor = 1}};
    while (bench_go(bench, 1)) {
        struct pend_samples samples = {.cap = 2, .t = t, .phi = out[0], .rate = out[1]};
        struct pend_run *run;
        int done = 0;
        if (pend_run_new(&run, &pend_method_taylor, &problem, NULL) != PEND_OK ||
            pend_run_next(run, &samples, 1e9, &done, NULL) != PEND_OK || !done)
            bench_broken("run");
        pend_run_free(&run);
    }
    pend_tree_free(&tree);
}
BENCH(events_1, "run") { look_for_first(bench, 1); }
BENCH(events_4, "run") { look_for_first(bench, 4); }
BENCH(events_11, "run") { look_for_first(bench, CONDITIONS); }
BENCH(events_of_an_angle, "run") { look(bench, PEND_QUANTITY_PHI, -1); }
BENCH(events_of_an_angle_never_reached, "run") { look(bench, PEND_QUANTITY_PHI, 1e6); }
BENCH(events_of_a_force, "run") { look(bench, PEND_QUANTITY_FORCE, 0); }
BENCH(events_of_a_place, "run") { look(bench, PEND_QUANTITY_X, 0); }
BENCH(events_of_an_energy, "run") { look(bench, PEND_QUANTITY_KINETIC, 5); }

BENCH(response_of_1000_arms, "frequency") {
    static double l[CHAIN], m[CHAIN], phi[CHAIN], out[2][PEND_RESPONSE_LANES * CHAIN];
    static int p[CHAIN];
    struct pend_tree *tree;
    struct pend_response *response;
    double *re[PEND_RESPONSE_PARTS] = {out[0]}, *im[PEND_RESPONSE_PARTS] = {out[1]};
    unsigned char defined[PEND_RESPONSE_LANES];
    double omega[PEND_RESPONSE_LANES];
    const struct pend_response_drive drive = {.pivot_re = {1, 0}};
    for (int k = 0; k < CHAIN; k++)
        l[k] = 0.001 * (1 + k % 7), m[k] = 1 + k % 3, p[k] = k - 1, phi[k] = -1.5707963267948966;
    if (pend_tree_new(&tree, CHAIN, l, m, p, NULL) != PEND_OK) bench_broken("tree");
    const struct pend_loads loads = {.gravity = 9.81};
    if (pend_response_new(&response, tree, &loads, phi, NULL) != PEND_OK) bench_broken("response");
    for (int i = 0; i < PEND_RESPONSE_LANES; i++) omega[i] = 0.7 + 1.3 * i;
    while (bench_go(bench, PEND_RESPONSE_LANES))
        pend_response_at(response, PEND_RESPONSE_LANES, omega, &drive, re, im, defined);
    pend_response_free(&response);
    pend_tree_free(&tree);
}

/* Searches for events beside the steps alone, of a double pendulum over 20 s, and the response of
 * 1000 arms: what a condition costs a run, and a frequency.
 * Leaves to others: samples of a run (bench_trajectory).
 * Invariant: what is timed has to succeed. */
#include <stdlib.h>

#include "core/integrate/events.h"
#include "core/modes/response.h"
#include "tests/bench/parts/bench.h"

enum { CHAIN = 1000 };

static const double length[] = {1, 1}, mass[] = {1, 1}, start[] = {0, 0.1}, rest[] = {0, 0};
static const int parent[] = {-1, 0};

/* a level that is never reached tells the cost of the steps */
static void look(struct bench *bench, enum pend_quantity quantity, double level) {
    struct pend_tree *tree;
    if (pend_tree_new(&tree, 2, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    const struct pend_event event = {.quantity = quantity,
                                     .arm = 1,
                                     .level = level,
                                     .ways = PEND_WAY_UP | PEND_WAY_DOWN,
                                     .most = 1000000};
    const struct pend_events_problem problem = {.tree = tree,
                                                .loads.gravity = 9.81,
                                                .phi = start,
                                                .rate = rest,
                                                .duration = 20,
                                                .count = 1,
                                                .event = &event};
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

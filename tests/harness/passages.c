#include "tests/harness/passages.h"

#include <math.h>

#include "tests/harness/test.h"

const double test_passages_duration = 1.5;

/* the quantity of a condition in row i of a record */
static double passages_quantity(const struct test_record *r, const struct test_tree *t,
                                const struct pend_event *event, long i) {
    const struct pend_samples *s = &r->samples;
    long at = i * t->n + t->tree->order[event->arm], to = i * t->n + t->tree->order[event->other];
    switch (event->quantity) {
    case PEND_QUANTITY_THETA:
        return s->phi[at] + M_PI_2;
    case PEND_QUANTITY_PHI:
        return s->phi[at];
    case PEND_QUANTITY_RATE:
        return s->rate[at];
    case PEND_QUANTITY_FORCE:
        return s->force[at];
    case PEND_QUANTITY_X:
        return s->z_re[at];
    case PEND_QUANTITY_Y:
        return s->z_im[at];
    case PEND_QUANTITY_DISTANCE:
        return hypot(s->z_re[at] - s->z_re[to], s->z_im[at] - s->z_im[to]);
    case PEND_QUANTITY_KINETIC:
        return s->kinetic[i];
    case PEND_QUANTITY_POTENTIAL:
        return s->potential[i];
    default:
        return s->kinetic[i] + s->potential[i];
    }
}

/* samples in 32 digits at instants after the start, which is the first of them */
void test_passages_exactly(struct test_record *record, const struct test_tree *t,
                           const struct pend_loads *loads, long count, const double time[]) {
    struct pend_problem problem = {.tree = t->tree,
                                   .loads = *loads,
                                   .phi = t->phi,
                                   .rate = t->rate,
                                   .times = {.count = count, .divisor = 1, .list = time}};
    test_record_blocks(record, pend_method_taylor.extended, &problem, count, 1e18);
    CHECK_SAYING(record->status == PEND_OK, "%s", record->error.text);
}

/* conditions of all kinds on values that the motion takes; a level is the quantity at a random
 * instant of the grid */
void test_passages_conditions(struct pend_event event[TEST_PASSAGES_CONDITIONS],
                              const struct test_tree *t, const struct test_record *grid,
                              int conserves, unsigned long long *seed) {
    for (int i = 0; i < TEST_PASSAGES_CONDITIONS; i++) {
        int arm = test_random_int(seed, t->n);
        event[i] = (struct pend_event){.quantity = (enum pend_quantity)(i % PEND_QUANTITIES),
                                       .arm = arm,
                                       .other = t->n > 1 ? (arm + 1) % t->n : 0,
                                       .ways = PEND_WAY_UP | PEND_WAY_DOWN,
                                       .most = TEST_PASSAGES_MOST};
        // the energy of what conserves it is no condition
        if (event[i].quantity == PEND_QUANTITY_ENERGY && conserves)
            event[i].quantity = PEND_QUANTITY_PHI;
        if (event[i].quantity == PEND_QUANTITY_DISTANCE && t->n == 1)
            event[i].quantity = PEND_QUANTITY_X;
        double a = passages_quantity(grid, t, &event[i],
                                     test_random_int(seed, TEST_PASSAGES_GRID - 1) + 1);
        double b = passages_quantity(grid, t, &event[i],
                                     test_random_int(seed, TEST_PASSAGES_GRID - 1) + 1);
        event[i].level = a + (b - a) * test_random(seed);
    }
}

/* the largest part of its scale by which a quantity misses its level at the hits of a condition,
 * and whether it is on the side of each hit's way between it and the next */
static double passages_levels(const struct test_passages *found, const struct test_tree *t,
                              const struct pend_loads *loads, const struct pend_event *event,
                              int which) {
    static double time[2 * TEST_PASSAGES_MOST + 1];
    static int hit[TEST_PASSAGES_MOST];
    struct test_record record;
    long count = 1;
    int hits = 0;
    double worst = 0;
    time[0] = 0;
    for (int i = 0; i < found->count; i++)
        if (found->hit[i].event == which) hit[hits++] = i;
    for (int i = 0; i < hits; i++) {
        double at = found->hit[hit[i]].time;
        double next = i + 1 < hits ? found->hit[hit[i + 1]].time : test_passages_duration;
        if (at > time[count - 1]) time[count++] = at;
        if ((at + next) / 2 > time[count - 1]) time[count++] = (at + next) / 2;
    }
    if (!hits) return 0;
    test_passages_exactly(&record, t, loads, count, time);
    long row = 1;
    for (int i = 0; i < hits; i++) {
        const struct pend_hit *h = &found->hit[hit[i]];
        if (i) CHECK_SAYING(h->way != found->hit[hit[i - 1]].way, "twice the same way");
        if (record.samples.t[row] != h->time) continue;
        double gap = passages_quantity(&record, t, event, row++) - event->level;
        worst = fmax(worst, fabs(gap) / (1 + fabs(event->level)));
        if (row >= count || i + 1 >= hits || record.samples.t[row] == found->hit[hit[i + 1]].time)
            continue;
        gap = passages_quantity(&record, t, event, row++) - event->level;
        CHECK_SAYING((gap > 0) == (h->way == PEND_WAY_UP) || fabs(gap) < 1e-9,
                     "not on its side: %g", gap);
    }
    test_record_clear(&record);
    return worst;
}

/* changes of side from instant to instant of the grid, which are the parity of the hits between */
static void passages_parity(const struct test_passages *found, const struct test_tree *t,
                            const struct test_record *grid, const struct pend_event *event,
                            int which) {
    int next = 0;
    for (long i = 1; i < TEST_PASSAGES_GRID; i++) {
        double before = passages_quantity(grid, t, event, i - 1) - event->level;
        double after = passages_quantity(grid, t, event, i) - event->level;
        int hits = 0;
        while (next < found->count && found->hit[next].time <= grid->samples.t[i])
            hits += found->hit[next++].event == which;
        if (fmin(fabs(before), fabs(after)) < 1e-9 * (1 + fabs(event->level))) continue;
        CHECK_SAYING((hits % 2 != 0) == ((before > 0) != (after > 0)),
                     "%d hits of quantity %d between %g and %g s, from %g to %g", hits,
                     event->quantity, grid->samples.t[i - 1], grid->samples.t[i], before, after);
    }
}

void test_passages_grid(struct test_record *record, const struct test_tree *t,
                        const struct pend_loads *loads) {
    double time[TEST_PASSAGES_GRID];
    for (int i = 0; i < TEST_PASSAGES_GRID; i++)
        time[i] = test_passages_duration * i / (TEST_PASSAGES_GRID - 1);
    test_passages_exactly(record, t, loads, TEST_PASSAGES_GRID, time);
}

void test_passages_random(struct test_tree *t, struct test_bodies *b, struct test_record *grid,
                          struct pend_event event[TEST_PASSAGES_CONDITIONS], int i,
                          unsigned long long *seed) {
    int real = i % 2;
    test_tree_random(t, TEST_TREE_ATTACHED, 1 + i % TEST_PASSAGES_ARMS, 0.3, seed);
    if (real) test_bodies_random(b, t->tree, TEST_TERMS_ALL & ~TEST_TERMS_FRICTION, seed);
    test_passages_grid(grid, t, &b->loads);
    test_passages_conditions(event, t, grid, !real, seed);
}

double test_passages_check(const struct test_passages *found, const struct test_tree *t,
                           const struct pend_loads *loads, const struct test_record *grid,
                           const struct pend_event event[TEST_PASSAGES_CONDITIONS]) {
    double worst = 0;
    for (int i = 1; i < found->count; i++) CHECK(found->hit[i].time >= found->hit[i - 1].time);
    for (int i = 0; i < TEST_PASSAGES_CONDITIONS; i++) {
        passages_parity(found, t, grid, &event[i], i);
        worst = fmax(worst, passages_levels(found, t, loads, &event[i], i));
    }
    return worst;
}

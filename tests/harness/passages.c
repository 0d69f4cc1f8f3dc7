#include "tests/harness/passages.h"

#include <math.h>
#include <stdlib.h>

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

/* conditions of all kinds on values that the motion reaches; a level is the quantity at a random
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
        // the energy of a conservative pendulum is no condition
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

/* the passages of a condition, in the order of time; returns their number */
static int passages_of(const struct test_passages *found, int which, int hit[TEST_PASSAGES_MOST]) {
    int hits = 0;
    for (int i = 0; i < found->count; i++)
        if (found->hit[i].event == which) hit[hits++] = i;
    return hits;
}

/* the instant half way between a passage of a condition and the next one, or the end */
static double passages_half(const struct test_passages *found, const int hit[], int hits, int i) {
    double at = found->hit[hit[i]].time;
    return (at + (i + 1 < hits ? found->hit[hit[i + 1]].time : test_passages_duration)) / 2;
}

static int passages_order(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* A motion in 32 digits at all instants that are checked, and one that begins at a distance of
 * passages_beside: chaos amplifies that distance as it amplifies rounding errors. */
struct passages_truth {
    struct test_record exact, aside;
};

/* rad and rad/s of every arm, with alternating signs */
static const double passages_beside = 0x1p-40;

/* one motion for all conditions: the start, the passages, and half way to the next of each
 * condition, every instant once; and its neighbour */
static void passages_record(struct passages_truth *truth, const struct test_passages *found,
                            const struct test_tree *t, const struct pend_loads *loads) {
    static double time[2 * TEST_PASSAGES_MOST + 1];
    static int hit[TEST_PASSAGES_MOST];
    double phi[TEST_PASSAGES_ARMS], rate[TEST_PASSAGES_ARMS];
    struct test_tree near = *t;
    long count = 1, kept = 1;
    time[0] = 0;
    for (int which = 0; which < TEST_PASSAGES_CONDITIONS; which++) {
        int hits = passages_of(found, which, hit);
        for (int i = 0; i < hits; i++) {
            time[count++] = found->hit[hit[i]].time;
            time[count++] = passages_half(found, hit, hits, i);
        }
    }
    qsort(time, (size_t)count, sizeof *time, passages_order);
    for (long i = 1; i < count; i++)
        if (time[i] > time[kept - 1]) time[kept++] = time[i];
    test_passages_exactly(&truth->exact, t, loads, kept, time);
    for (int k = 0; k < t->n; k++) {
        double way = k % 2 ? -passages_beside : passages_beside;
        phi[k] = t->phi[k] + way, rate[k] = t->rate[k] + way;
    }
    near.phi = phi, near.rate = rate;
    test_passages_exactly(&truth->aside, &near, loads, kept, time);
}

/* the row of an instant of the record */
static long passages_row(const struct test_record *record, double time) {
    const double *t = record->samples.t,
                 *at = bsearch(&time, t, (size_t)record->samples.count, sizeof *t, passages_order);
    CHECK_SAYING(at, "no row at %g s", time);
    return at ? at - t : 0;
}

/* the largest error of a quantity at the passages of a condition, relative to its scale and to the
 * growth of a unit of the start so far; and whether it is on the right side between each passage
 * and the next */
static double passages_levels(const struct test_passages *found, const struct test_tree *t,
                              const struct passages_truth *truth, const struct pend_event *event,
                              int which) {
    static int hit[TEST_PASSAGES_MOST];
    const struct test_record *record = &truth->exact;
    int hits = passages_of(found, which, hit);
    double worst = 0, grown = 0;
    long seen = 0;
    for (int i = 0; i < hits; i++) {
        const struct pend_hit *h = &found->hit[hit[i]];
        if (i) CHECK_SAYING(h->way != found->hit[hit[i - 1]].way, "twice the same way");
        long row = passages_row(record, h->time);
        double gap = passages_quantity(record, t, event, row) - event->level;
        for (; seen <= row; seen++) {
            double moved = passages_quantity(&truth->aside, t, event, seen) -
                           passages_quantity(record, t, event, seen);
            grown = fmax(grown, fabs(moved) / passages_beside);
        }
        worst = fmax(worst, fabs(gap) / (1 + fabs(event->level) + grown));
        row = passages_row(record, passages_half(found, hit, hits, i));
        gap = passages_quantity(record, t, event, row) - event->level;
        CHECK_SAYING((gap > 0) == (h->way == PEND_WAY_UP) || fabs(gap) < 1e-9,
                     "not on its side: %g", gap);
    }
    return worst;
}

/* changes of side between instants of the grid, which are the parity of the passages between
 * them */
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

/* ---- extremes */

enum { EXTREMES = TEST_PASSAGES_EXTREMES, LEFT = 3, AROUND = 5 };

/* the distance of a level from the extreme, relative to its scale; half of the interval around an
 * extreme that is checked; and at the end of the search for it, s */
static const double passages_aside = 1e-10, passages_around = 1e-3, passages_near = 6e-5;

/* the instant of a random extreme of a random quantity over the grid, which the condition gets
 * without a level; NaN = none was found */
static double passages_extreme(struct pend_event *event, const struct test_tree *t,
                               const struct test_record *grid, int conserves,
                               unsigned long long *seed) {
    int at = test_random_int(seed, TEST_PASSAGES_GRID);
    *event =
        (struct pend_event){.quantity = (enum pend_quantity)test_random_int(seed, PEND_QUANTITIES),
                            .arm = test_random_int(seed, t->n),
                            .ways = PEND_WAY_UP | PEND_WAY_DOWN,
                            .most = TEST_PASSAGES_MOST};
    event->other = (event->arm + 1) % t->n;
    if (event->quantity == PEND_QUANTITY_ENERGY && conserves) return NAN;
    if (event->quantity == PEND_QUANTITY_DISTANCE && t->n == 1) return NAN;
    for (int i = 0; i < TEST_PASSAGES_GRID; i++, at = (at + 1) % TEST_PASSAGES_GRID) {
        if (at < 2 || at > TEST_PASSAGES_GRID - 3) continue;
        double before = passages_quantity(grid, t, event, at - 1);
        double here = passages_quantity(grid, t, event, at);
        double after = passages_quantity(grid, t, event, at + 1), bent = before - 2 * here + after;
        if ((here > before) != (here > after) || fabs(bent) < 1e-4 * (1 + fabs(here))) continue;
        double step = grid->samples.t[1] - grid->samples.t[0];
        return grid->samples.t[at] + (before - after) / (2 * bent) * step;
    }
    return NAN;
}

/* samples in 32 digits at AROUND instants from `around` before each extreme to `around` after it */
static void passages_look(struct test_record *record, const struct test_tree *t,
                          const struct pend_loads *loads, const double extreme[EXTREMES],
                          double around) {
    double time[1 + AROUND * EXTREMES] = {0};
    long kept = 1;
    for (int i = 0; i < EXTREMES; i++)
        for (int j = 0; j < AROUND; j++)
            time[1 + AROUND * i + j] = extreme[i] + around * (j - AROUND / 2) / 2;
    qsort(time, 1 + AROUND * EXTREMES, sizeof *time, passages_order);
    for (int i = 1; i < 1 + AROUND * EXTREMES; i++)
        if (time[i] > time[kept - 1]) time[kept++] = time[i];
    test_passages_exactly(record, t, loads, kept, time);
}

/* how far a quantity is below its value at the extreme, j halves of `around` from it */
static double passages_drop(const struct test_record *record, const struct test_tree *t,
                            const struct pend_event *event, double extreme, double around, int j) {
    long here = passages_row(record, extreme);
    long there = passages_row(record, extreme + around * j / 2);
    return passages_quantity(record, t, event, here) - passages_quantity(record, t, event, there);
}

/* distance of the maximum, s, from five values around it */
static double passages_top(const double drop[AROUND], double around) {
    double slope = 8 * (drop[1] - drop[3]) - (drop[0] - drop[4]);
    double bent = 16 * (drop[1] + drop[3]) - (drop[0] + drop[4]);
    double by = around / 2 * slope / bent;
    return bent != 0 ? fmin(fmax(by, -around), around) : 0;
}

/* whether the quantity is a parabola around the extreme, whose maximum is where it was found, and
 * which is high enough for the levels next to it */
static int passages_smooth(const double drop[AROUND], double aside) {
    double off = passages_top(drop, passages_around) / (passages_around / 2);
    int smooth = (drop[0] > 0) == (drop[4] > 0) && off * off * fabs(drop[1]) < aside / 16;
    for (int i = 0; i < AROUND; i += 4) {
        double half = drop[i ? 3 : 1], parts = drop[i] / half;
        smooth &= fabs(half) > 20 * aside && parts > 3 && parts < 5;
    }
    return smooth;
}

int test_passages_grazing(struct pend_event event[TEST_PASSAGES_CONDITIONS], double time[EXTREMES],
                          const struct test_tree *t, const struct pend_loads *loads,
                          const struct test_record *grid, int conserves, unsigned long long *seed) {
    enum { WIDE = 4, ROUNDS = 6 }; // the rounds in between search nearby
    struct test_record record;
    int smooth = 0;
    for (int i = 0; i < EXTREMES; i++) {
        time[i] = NAN;
        for (int tries = 0; tries < 100 && isnan(time[i]); tries++)
            time[i] = passages_extreme(&event[LEFT * i], t, grid, conserves, seed);
        if (isnan(time[i])) return 0;
    }
    for (int round = 1; round <= ROUNDS; round++) {
        double around = round > WIDE && round < ROUNDS ? passages_near : passages_around;
        passages_look(&record, t, loads, time, around);
        for (int i = 0; i < EXTREMES; i++) {
            double drop[AROUND];
            struct pend_event *within = &event[LEFT * i], *beyond = within + 1;
            for (int j = 0; j < AROUND; j++)
                drop[j] = passages_drop(&record, t, within, time[i], around, j - AROUND / 2);
            double top = passages_quantity(&record, t, within, passages_row(&record, time[i]));
            double aside = passages_aside * (1 + fabs(top)), inwards = drop[0] > 0 ? -aside : aside;
            *beyond = within[2] = *within;
            within->level = within[2].level = top + inwards, beyond->level = top - inwards;
            if (round < ROUNDS)
                time[i] += passages_top(drop, around);
            else if (passages_smooth(drop, aside))
                smooth++;
            else
                time[i] = NAN;
        }
        test_record_clear(&record);
    }
    return smooth;
}

void test_passages_grazed(const struct test_passages *found, const double time[EXTREMES]) {
    for (int i = 0; i < EXTREMES; i++) {
        int hits[LEFT] = {0}, before = 0;
        double first[LEFT] = {0};
        if (isnan(time[i])) continue;
        for (int j = 0; j < found->count; j++) {
            int which = found->hit[j].event - LEFT * i;
            double gap = found->hit[j].time - time[i];
            if (which < 0 || which >= LEFT || fabs(gap) > passages_around) continue;
            if (!hits[which]++) first[which] = gap;
            before += which != 1 && gap < 0;
        }
        CHECK_SAYING(hits[0] == 2 && hits[2] == 2 && hits[1] == 0 && before == 2,
                     "%d and %d passages within an extreme, %d beyond, %d before it", hits[0],
                     hits[2], hits[1], before);
        CHECK(first[0] == first[2]);
    }
}

double test_passages_check(const struct test_passages *found, const struct test_tree *t,
                           const struct pend_loads *loads, const struct test_record *grid,
                           const struct pend_event event[TEST_PASSAGES_CONDITIONS]) {
    struct passages_truth truth;
    double worst = 0;
    for (int i = 1; i < found->count; i++) {
        const struct pend_hit *last = &found->hit[i - 1], *next = &found->hit[i];
        CHECK(next->time > last->time || (next->time == last->time && next->event >= last->event));
    }
    passages_record(&truth, found, t, loads);
    for (int i = 0; i < TEST_PASSAGES_CONDITIONS; i++) {
        passages_parity(found, t, grid, &event[i], i);
        worst = fmax(worst, passages_levels(found, t, &truth, &event[i], i));
    }
    test_record_clear(&truth.exact);
    test_record_clear(&truth.aside);
    return worst;
}

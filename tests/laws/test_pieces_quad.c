/* Laws: joints with Coulomb friction stick and slide as in an independent reference in 33 digits,
 * with all arms of the tree: extrapolated midpoint steps, a torque for each sticking joint such
 * that its relative acceleration is 0, changes of modes by roots of the length of a step, and the
 * modes of joints at rest by trying all. Leaves to others: stops (tests/api/op/test_op_pieces.c).
 * Invariant: static and sliding friction are equal, so that the modes are unique. */
#include <math.h>
#include <stdlib.h>

#include "core/integrate/run/run.h"
#include "core/tree/rules.h"
#include "tests/harness/quad_bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"

enum { ARMS = 3, GRID = 32, ROWS = 9 };

struct truth {
    const struct pend_tree *tree;
    const struct pend_terms *terms;
    double value[3 * ARMS + 1], bound[ARMS];
    int mode[ARMS], events; /* 0 sticks, +1 and -1 slide in that direction */
    test_quad phi[ARMS], rate[ARMS], torque[ARMS], time;
};

static test_quad relative(const struct truth *t, const test_quad x[], int k) {
    return x[k] - (t->tree->parent[k] < 0 ? 0 : x[t->tree->parent[k]]);
}

/* accelerations; the torques of sticking joints follow from the responses to unit torques */
static void accelerate(void *context, const struct test_quad_state *state, test_quad acc[]) {
    struct truth *t = context;
    const struct pend_loads loads = {9.81, t->terms, t->value};
    const int *row = t->terms->row;
    test_quad answer[ARMS][ARMS], matrix[ARMS * ARMS], hold[ARMS];
    int of[ARMS], count = 0;
    for (int k = 0; k < ARMS; k++) t->value[row[PEND_TERM_SLIDE] + k] = -t->mode[k] * t->bound[k];
    test_quad_bodies(t->tree, &loads, state, acc, NULL);
    for (int k = 0; k < ARMS; k++) {
        if (t->mode[k]) continue;
        t->value[row[PEND_TERM_INPUT] + k] = 1;
        test_quad_bodies(t->tree, &loads, state, answer[count], NULL);
        t->value[row[PEND_TERM_INPUT] + k] = 0;
        for (int i = 0; i < ARMS; i++) answer[count][i] -= acc[i];
        of[count++] = k;
    }
    for (int i = 0; i < count; i++) {
        hold[i] = -relative(t, acc, of[i]);
        for (int j = 0; j < count; j++) matrix[i * count + j] = relative(t, answer[j], of[i]);
    }
    test_quad_solve(count, matrix, hold);
    for (int i = 0; i < count; i++) {
        t->torque[of[i]] = hold[i];
        for (int k = 0; k < ARMS; k++) acc[k] += hold[i] * answer[i][k];
    }
}

/* becomes negative when joint k changes its mode */
static test_quad margin(struct truth *t, int k) {
    test_quad acc[ARMS];
    if (t->mode[k]) return t->mode[k] * relative(t, t->rate, k);
    accelerate(t, &(struct test_quad_state){t->phi, t->rate, t->time}, acc);
    return t->bound[k] - test_quad_abs(t->torque[k]);
}

/* whether the modes of the joints at rest, except for one that is given, are consistent */
static int consistent(struct truth *t, const int rests[], int forced) {
    test_quad acc[ARMS];
    int good = 1;
    accelerate(t, &(struct test_quad_state){t->phi, t->rate, t->time}, acc);
    for (int k = 0; k < ARMS; k++) {
        if (!rests[k] || k == forced) continue;
        if (t->mode[k])
            good &= t->mode[k] * relative(t, acc, k) > -1e-25;
        else
            good &= test_quad_abs(t->torque[k]) < t->bound[k] + 1e-25;
    }
    return good;
}

/* finds the modes of the joints at rest; one that was released keeps its direction */
static void sort(struct truth *t, const int rests[], int forced) {
    static const int modes[] = {0, 1, -1};
    int kept[ARMS], found = 0;
    for (int k = 0; k < ARMS; k++) kept[k] = t->mode[k];
    for (int code = 0; code < 27 && !found; code++) {
        int left = code, twice = 0;
        for (int k = 0; k < ARMS; k++, left /= 3) {
            int chosen = rests[k] && k != forced;
            t->mode[k] = chosen ? modes[left % 3] : kept[k];
            twice |= !chosen && left % 3;
        }
        found = !twice && consistent(t, rests, forced);
    }
    REQUIRE(found);
}

static void move(struct truth *t, const struct truth *from, test_quad span) {
    *t = *from;
    (void)test_quad_advance(ARMS, accelerate, t, t->phi, t->rate, t->time, span, 1);
    t->time += span;
}

/* the length of a step at which a margin is 0, by the rule of false position */
static test_quad length_of(const struct truth *from, int k, test_quad span) {
    struct truth t;
    test_quad low = span / 1024, high = span, x = span;
    move(&t, from, low);
    test_quad at_low = margin(&t, k);
    move(&t, from, high);
    test_quad at_high = margin(&t, k), last = 1;
    CHECK(at_low > 0 && at_high < 0);
    for (int i = 0; i < 60 && test_quad_abs(last) > 1e-31 && high - low > 1e-32; i++) {
        x = high - at_high * (high - low) / (at_high - at_low);
        move(&t, from, x);
        last = margin(&t, k);
        if (last > 0)
            low = x, at_low = last, at_high /= 2;
        else
            high = x, at_high = last, at_low /= 2;
    }
    return x;
}

/* takes a step of at most `span`, to the first change of a mode */
static void advance(struct truth *t, test_quad span) {
    struct truth from = *t;
    test_quad first = span;
    int at = -1, rests[ARMS];
    move(t, &from, span);
    for (int k = 0; k < ARMS; k++) {
        test_quad x = margin(t, k) < 0 ? length_of(&from, k, span) : span;
        if (x < first) first = x, at = k;
    }
    if (at < 0) return;
    move(t, &from, first);
    for (int k = 0; k < ARMS; k++) rests[k] = k == at || !t->mode[k];
    int forced = !t->mode[at];
    (void)margin(t, at);
    if (forced) t->mode[at] = t->torque[at] > 0 ? -1 : 1;
    if (!forced) t->rate[at] = t->tree->parent[at] < 0 ? 0 : t->rate[t->tree->parent[at]];
    t->events++;
    sort(t, rests, forced ? at : -1);
}

static void compare(const int parent[], const double bound[], int *events) {
    static const double length[] = {0.5, 0.4, 0.3}, mass[] = {0.5, 0.4, 0.3},
                        phi[] = {0.3, -0.8, -1.4}, rate[ARMS];
    const unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_INPUT] = 1, [PEND_TERM_SLIDE] = 1},
                        ones[PEND_TERM_ONES] = {[PEND_TERM_PIECE] = 1};
    struct truth t = {0};
    OWN(pend_tree, free) *tree;
    OWN(pend_terms, free) *terms = NULL;
    OWN(test_record, clear) record = {0};
    double worst = 0;
    REQUIRE(pend_tree_new(&tree, ARMS, length, mass, parent, NULL) == PEND_OK);
    REQUIRE(pend_terms_new(&terms, ARMS, rows, ones, 0, NULL, NULL) == PEND_OK);
    REQUIRE(terms->count == (int)(sizeof t.value / sizeof *t.value));
    const struct pend_rules rules = {.sliding = bound, .holding = bound};
    double value[3 * ARMS + 1] = {0};
    terms->rules = &rules;
    const struct pend_problem problem = {.tree = tree,
                                         .loads = {9.81, terms, value},
                                         .phi = phi,
                                         .rate = rate,
                                         .times = {.count = ROWS, .span = 1, .divisor = ROWS - 1},
                                         .rtol = 1e-15};
    test_record(&record, "taylor", &problem);
    REQUIRE(record.status == PEND_OK);
    t.tree = tree, t.terms = terms;
    for (int k = 0; k < ARMS; k++) t.phi[k] = phi[k], t.bound[k] = bound[k];
    sort(&t, (int[]){1, 1, 1}, -1);
    for (int i = 1; i <= GRID; i++) {
        while (t.time < (test_quad)i / GRID) advance(&t, (test_quad)i / GRID - t.time);
        for (int k = 0; k < ARMS && i % (GRID / (ROWS - 1)) == 0; k++) {
            long at = (long)i / (GRID / (ROWS - 1)) * ARMS + k;
            worst = fmax(worst, fabs((double)(record.samples.phi[at] - t.phi[k])));
            worst = fmax(worst, fabs((double)(record.samples.rate[at] - t.rate[k])) / 10);
        }
    }
    CHECK_RESIDUAL(worst, 2e-14, "three arms that stick and slide");
    *events += t.events;
}

TEST(three_arms_stick_and_slide_as_in_33_digits) {
    static const int chain[] = {-1, 0, 1}, fork[] = {-1, 0, 0};
    static const double rubs[][ARMS] = {{0.6, 0.4, 0.2}, {0.9, 0.3, 0.25}};
    int events = 0;
    compare(chain, rubs[0], &events);
    compare(fork, rubs[1], &events);
    CHECK_SAYING(events > 12, "%d changes of modes", events);
}

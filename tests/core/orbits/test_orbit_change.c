/* Tests of bifurcations between the orbits of a branch: each is real, they are in order, none is
 * missed, and each has the right kind.
 * Leaves to others: the branches that begin there (test_orbit_switch).
 * Invariant: the kind follows from the multipliers of orbits at the bifurcation and on both sides
 * of it. */
#include "core/orbits/orbit_change.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>

#include "tests/harness/found.h"
#include "tests/harness/test.h"

/* a tree of n arms, each carried by the one before or by that arm's parent */
static void grow(struct found *f, int n, unsigned long long *seed) {
    double length[FOUND_ARMS], mass[FOUND_ARMS];
    int parent[FOUND_ARMS];
    for (int k = 0; k < n; k++) {
        length[k] = 0.4 + 0.8 * test_random(seed), mass[k] = 0.2 + test_random(seed);
        parent[k] = k < 2 || test_random(seed) < 0.6 ? k - 1 : k - 2;
    }
    pend_tree_free(&f->tree);
    REQUIRE(pend_tree_new(&f->tree, n, length, mass, parent, NULL) == PEND_OK);
}

/* orbits of a tree with friction that a torque on the first arm drives, from hanging on; the torque
 * or its frequency grows */
static struct found *driven(int n, unsigned long long *seed) {
    static double phi[FOUND_ARMS], rate[FOUND_ARMS];
    struct found *f = found_chain(n, 0, 1, 1);
    grow(f, n, seed);
    const struct pend_terms *terms = found_terms(f, PEND_TERM_DAMPING, 1);
    double *torque = f->term + terms->harmonic[0].at;
    for (int k = 0; k < n; k++) {
        f->term[pend_terms_place(terms, PEND_TERM_DAMPING, k)] = 0.01 + 0.1 * test_random(seed);
        phi[k] = -M_PI / 2, rate[k] = 0;
    }
    torque[0] = 0.5 + 2 * test_random(seed), torque[1] = 0.8 + 1.2 * test_random(seed);
    f->problem.driven = f->problem.periods = 1, f->problem.points = 50;
    f->problem.phi = phi, f->problem.rate = rate;
    if (test_random(seed) < 0.5) {
        f->problem.vary = PEND_ORBIT_OMEGA, f->problem.to = 2.5 + 1.5 * test_random(seed);
    } else {
        f->problem.vary = PEND_ORBIT_PARAMETER, f->problem.to = 4 + 4 * test_random(seed);
        f->problem.by = (struct pend_parameter){PEND_PARAMETER_TERM, terms->harmonic[0].at};
    }
    return f;
}

static struct found *swinging(int n, unsigned long long *seed) {
    struct found *f = found_chain(n, test_random_int(seed, n), 2, 1);
    grow(f, n, seed);
    return f;
}

/* how many multipliers are outside the unit circle by more than `border` */
static int growing(const struct found *f, int row, double border) {
    int count = 0;
    for (int j = 0; j < 2 * f->tree->n; j++)
        count += hypot(f->re[row][j], f->im[row][j]) > 1 + border;
    return count;
}

/* The distance of the multipliers at a bifurcation from those of its kind: one is at +1, or at -1,
 * or a pair is on the circle; for conservative orbits two pairs meet there. The orbit's own pair is
 * the last one. */
static double away(const struct found *f, int i) {
    int loses = f->problem.driven, m = 2 * f->tree->n - (loses ? 0 : 2);
    double least = INFINITY;
    for (int j = 0; j < m; j++) {
        double complex x = f->re_there[i][j] + I * f->im_there[i][j];
        double here = cabs(f->kind[i] == PEND_ORBITS_DOUBLING ? x + 1 : x - 1);
        if (f->kind[i] == PEND_ORBITS_TORUS)
            here = cimag(x) != 0 && loses ? fabs(cabs(x) - 1) : INFINITY;
        for (int k = 0; k < j && f->kind[i] == PEND_ORBITS_TORUS && !loses; k++)
            here =
                fmin(here, cabs(x - f->re_there[i][k] - I * f->im_there[i][k]) + fabs(cabs(x) - 1));
        least = fmin(least, here);
    }
    return least;
}

/* The bifurcations reported between two orbits are exactly the changes of their multipliers; orbits
 * with one within rounding errors of the circle are skipped. */
static void check_steps(const struct found *f, int number) {
    int last = 0, told = 0;
    for (int row = 1; row < f->rows; row++) {
        for (int i = 0; i < f->bifurcations; i++)
            if (f->after[i] == row) told += f->kind[i] == PEND_ORBITS_TORUS ? 2 : 1;
        int now = growing(f, row, 1e-5), change = abs(now - growing(f, last, 1e-5));
        if (now != growing(f, row, 1e-9)) continue;
        CHECK_SAYING(change <= told && (told - change) % 2 == 0,
                     "tree %d: %d multipliers pass between orbits %d and %d, %d are told", number,
                     change, last, row, told);
        last = row, told = 0;
    }
    for (int i = 0; i < f->bifurcations; i++)
        CHECK_SAYING(away(f, i) < (f->problem.driven ? 1e-4 : 1e-2),
                     "tree %d: a bifurcation of kind %d at %g is %g away from one", number,
                     (int)f->kind[i], f->at[i], away(f, i));
}

TEST(bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else) {
    unsigned long long seed = 35;
    int kinds[PEND_ORBITS_KINDS] = {0};
    for (int number = 0; number < 30; number++) {
        int n = number % 2 ? 3 + number / 2 % 3 : 1 + number / 2 % 4;
        OWN(found, free) *f = number % 2 ? swinging(n, &seed) : driven(n, &seed);
        found_search(f);
        REQUIRE(f->status == PEND_OK);
        check_steps(f, number);
        for (int i = 0; i < f->bifurcations; i++) kinds[f->kind[i]]++;
        // all of these are their own mirror images; where another branch crosses, swings are not
        for (int i = 0; i < f->bifurcations && f->problem.driven; i++)
            CHECK(f->kind[i] != PEND_ORBITS_BRANCH);
        for (int i = 1; i < f->bifurcations; i++) CHECK(f->after[i] >= f->after[i - 1]);
    }
    CHECK(kinds[PEND_ORBITS_FOLD] > 10 && kinds[PEND_ORBITS_BRANCH] > 10);
    CHECK(kinds[PEND_ORBITS_SYMMETRY] > 10 && kinds[PEND_ORBITS_TORUS] > 5);
}

/* two pairs of real multipliers meet at 3.62 and 0.276 in the step in which another passes +1 */
TEST(bifurcations_are_not_hidden_by_multipliers_that_meet_away_from_the_circle) {
    static const double length[] = {0.6, 0.97, 0.44}, mass[] = {0.29, 0.74, 0.74};
    static const int parent[] = {-1, 0, 0};
    OWN(found, free) *f = found_chain(3, 0, 2, 1);
    pend_tree_free(&f->tree);
    REQUIRE(pend_tree_new(&f->tree, 3, length, mass, parent, NULL) == PEND_OK);
    found_search(f);
    REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->bifurcations == 8);
    CHECK(f->kind[7] == PEND_ORBITS_SYMMETRY);
    CHECK_RESIDUAL(fabs(f->at[7] - 17.917900006), 1e-7, "energy of the bifurcation, J");
    check_steps(f, 0);
}

/* an arm whose swing to one side equals that to the other half a period later, until the torque is
 * 1.00432: theta'' + theta'/2 + sin theta = g cos 2t/3 */
static struct found *torque_grows(double from, double to) {
    struct found *f = found_driven(0.5, from, 2.0 / 3);
    f->problem.branch = 1, f->problem.vary = PEND_ORBIT_PARAMETER, f->problem.to = to;
    f->problem.by = (struct pend_parameter){PEND_PARAMETER_TERM, f->terms->harmonic[0].at};
    f->problem.settle = 100;
    return f;
}

TEST(bifurcations_at_which_a_driven_swing_loses_its_symmetry_are_told_from_both_sides) {
    OWN(found, free) *f = torque_grows(0.9, 1.02), *g = torque_grows(1.02, 0.95);
    found_search(f);
    found_search(g);
    REQUIRE(f->status == PEND_OK && g->status == PEND_OK);
    REQUIRE(f->bifurcations == 1 && g->bifurcations == 1);
    CHECK(f->end == PEND_ORBITS_REACHED && f->kind[0] == PEND_ORBITS_SYMMETRY && !f->turns[0]);
    // the branch of asymmetric swings turns back where it meets the others
    CHECK(g->end == PEND_ORBITS_BACK && g->kind[0] == PEND_ORBITS_SYMMETRY && g->turns[0]);
    CHECK_RESIDUAL(fabs(f->at[0] - g->at[0]), 1e-6, "torque of the bifurcation, N m");
    CHECK(g->stable[0] && g->stable[g->rows - 1]);
    // the others continue beyond
    g->problem.switches = g->problem.leave[0] = 1;
    found_search(g);
    CHECK(g->status == PEND_OK && g->end == PEND_ORBITS_REACHED && g->rows > 3);
    CHECK(fabs(g->value[g->rows - 1] - 0.95) < 1e-14 && g->stable[g->rows - 1]);
}

/* The same for trees: from an orbit of the asymmetric branch back to where it began. Returns false
 * if the tree has no such branch. */
static int symmetry_from_beyond(struct found *f) {
    int first = 0;
    double *varied = f->term + f->terms->harmonic[0].at + (f->problem.vary == PEND_ORBIT_OMEGA);
    static double phi[FOUND_ARMS], rate[FOUND_ARMS];
    found_search(f);
    while (first < f->bifurcations && f->kind[first] != PEND_ORBITS_SYMMETRY) first++;
    if (first == f->bifurcations) return 0;
    double at = f->at[first];
    f->problem.switches = 1, f->problem.leave[0] = first + 1;
    found_search(f);
    if (f->rows < 6) return 0;
    CHECK(f->kind[0] == PEND_ORBITS_SYMMETRY && f->at[0] == at);
    for (int k = 0; k < f->tree->n; k++) phi[k] = f->phi[5][k], rate[k] = f->rate[5][k];
    *varied = f->value[5];
    f->problem.phi = phi, f->problem.rate = rate, f->problem.to = 2 * at - *varied;
    f->problem.switches = 0, f->problem.points = 25;
    found_search(f);
    int back = 0; // there may be folds on the way
    while (back < f->bifurcations && f->kind[back] != PEND_ORBITS_SYMMETRY) back++;
    if (!CHECK(f->status == PEND_OK && back < f->bifurcations)) return 0;
    CHECK(f->turns[back]);
    CHECK_SAYING(fabs(f->at[back] - at) < 1e-6, "at %.12g, from beyond at %.12g", at, f->at[back]);
    return 1;
}

TEST(bifurcations_at_which_driven_trees_lose_their_symmetry_are_told_from_both_sides) {
    unsigned long long seed = 36;
    int seen[4] = {0};
    for (int number = 0; number < 16; number++) {
        int n = 2 + number % 2;
        OWN(found, free) *f = driven(n, &seed);
        seen[n] += symmetry_from_beyond(f);
    }
    CHECK(seen[2] > 0 && seen[3] > 0);
}

/* orbits of twice the period turn back where they meet those of the single period */
TEST(bifurcations_at_which_a_period_was_doubled_are_told_from_both_sides) {
    OWN(found, free) *f = torque_grows(1.068, 1.05);
    f->problem.periods = 2, f->problem.settle = 2000;
    found_search(f);
    REQUIRE(f->status == PEND_OK && f->bifurcations == 1);
    CHECK(f->end == PEND_ORBITS_BACK && f->kind[0] == PEND_ORBITS_DOUBLING && f->turns[0]);
    CHECK_RESIDUAL(fabs(f->at[0] - 1.0663738), 1e-6, "torque of the bifurcation, N m");
}

/* Searches at the edges of constants of orbit_constants: where they end, where a bifurcation is or
 * how far an orbit misses its start at most, and by how many calls and motions. */
TEST(searches_end_as_they_must) {
    static const struct {
        char what; // chain up to a, driven or swinging tree of a seed, torque from a to b
        int n;
        double a, b;
        enum pend_orbits_end end;
        int bifurcation; // -1: none
        double least, most;
        long maps[2], calls;
    } row[] = {
        {'c', 1, 2e-6, 0, PEND_ORBITS_REACHED, -1, 0, 1, {1, 50}, 90}, // orbits_alike
        {'c', 1, 1e-6, 0, PEND_ORBITS_MEETS, -1, 0, 1, {1, 90}, 400},
        {'c', 20, 0.6, 0, PEND_ORBITS_REACHED, -1, 0, 1, {25, 50}, 300}, // NEWTON_NEAR, piece
        {'u', 1, 2.1 * 9.81, 0, PEND_ORBITS_LOST, -1, 4e-10, 1e-9, {300, 600}, 2500}, // exact
        {'b', 2, 3.1, 0, PEND_ORBITS_WILD, -1, 3.4e-4, 1e-3, {100, 400}, 2000},       // branch_wild
        {'t', 1, 3, 2, PEND_ORBITS_REACHED, -1, 0, 1, {50, 99}, 400}, // NEWTON_FAR, newton_longest
        {'t', 2, 1.068, 1.05, PEND_ORBITS_BACK, 0, 1.06, 1.07, {79, 90}, 400}, // change_other
        {'d', 3, 110, 0, PEND_ORBITS_BACK, 1, 1.94474881, 1.9447491, {190, 220}, 900}, // driven,
                                                                                       // MOST
        {'d', 3, 116, 0, PEND_ORBITS_POINTS, 1, 2.05440595, 2.05440615, {280, 350}, 1300}, // beside
        {'s', 3, 115, 0, PEND_ORBITS_REACHED, 0, 41.94817, 41.948172, {116, 124}, 500},    // zero
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        unsigned long long seed = (unsigned long long)row[i].a;
        char what = row[i].what;
        OWN(found, free) *f = what == 'd'   ? driven(row[i].n, &seed)
                              : what == 's' ? swinging(row[i].n, &seed)
                              : what == 't' ? torque_grows(row[i].a, row[i].b)
                                            : found_chain(row[i].n, 0, row[i].a, what != 'c');
        if (what == 't') f->problem.periods = row[i].n, f->problem.settle = row[i].n > 1 ? 2000 : 0;
        if (what == 'u') f->problem.target = PEND_ORBIT_ENERGY;
        double seen = 0;
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->bifurcations > row[i].bifurcation);
        for (int k = 0; k < f->rows; k++) seen = fmax(seen, f->closure[k]);
        if (row[i].bifurcation >= 0) seen = f->at[row[i].bifurcation];
        CHECK_SAYING(f->end == row[i].end && seen >= row[i].least && seen <= row[i].most,
                     "row %zu: end %d, %.12g", i, (int)f->end, seen);
        CHECK_SAYING(f->maps >= row[i].maps[0] && f->maps <= row[i].maps[1] &&
                         f->calls <= row[i].calls,
                     "row %zu: %ld motions, %ld calls", i, f->maps, f->calls);
    }
}

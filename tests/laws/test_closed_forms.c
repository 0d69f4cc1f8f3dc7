/* Laws: motions of real pendulums with closed-form or published solutions.
 * Leaves to others: the equations at one state (test_bodies_quad), agreement of methods
 * (test_real_pendulums).
 * Invariant: references are computed here from the formula or taken from the named source, and hold
 * for every kernel of power series that supports the pendulum. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/run/run.h"
#include "core/taylor/jets_loads.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 3, INSTANTS = 1001 };

/* a pendulum of up to ARMS arms with any terms, and its samples */
struct rig {
    int n;
    double length[ARMS], mass[ARMS], phi[ARMS], rate[ARMS];
    int parent[ARMS];
    struct pend_tree *tree;
    struct pend_terms *terms;
    double *value;
    struct pend_loads loads;
    double t[INSTANTS], angle[INSTANTS * ARMS], speed[INSTANTS * ARMS];
};

/* a chain of n arms of 1 m and 1 kg that hangs at rest, with the terms of every row and one of
 * harmonics, all without effect yet */
static void rig_open(struct rig *r, int n, double gravity, int harmonics, const int drives[]) {
    unsigned char rows[PEND_TERM_ROWS], ones[PEND_TERM_ONES];
    int place[4];
    memset(r, 0, sizeof *r);
    memset(rows, 1, sizeof rows);
    memset(ones, 1, sizeof ones);
    memset(ones + PEND_TERM_RAIL, 0, PEND_TERM_ONES - PEND_TERM_RAIL); // no cart, no pieces
    r->n = n;
    for (int k = 0; k < n; k++) {
        r->length[k] = r->mass[k] = 1;
        r->parent[k] = k - 1;
        r->phi[k] = -M_PI_2;
    }
    if (pend_terms_new(&r->terms, n, rows, ones, harmonics, drives, place) != PEND_OK) abort();
    r->value = calloc((size_t)r->terms->count + 1, sizeof *r->value);
    if (!r->value) abort();
    r->loads = (struct pend_loads){gravity, r->terms, r->value};
}

static void rig_tree(struct rig *r) {
    pend_tree_free(&r->tree);
    unsigned char bare[ARMS] = {1, 1, 1};
    if (pend_tree_new_bare(&r->tree, r->n, r->length, r->mass, bare, r->parent, NULL) != PEND_OK)
        abort();
    int speeds[] = {PEND_TERM_FRICTION_SPEED, PEND_TERM_DRAG_SPEED};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < r->n; k++) r->value[r->terms->row[speeds[i]] + k] = 1;
}

static void rig_close(struct rig *r) {
    pend_tree_free(&r->tree);
    pend_terms_free(&r->terms);
    free(r->value);
}

/* the kernel that runs the rigs: the general one, selected by terms without effect, or the one that
 * supports the effective terms */
static int rig_lean;

#define LAW(law)                                                                                   \
    static void law##_holds(void);                                                                 \
    TEST(law) {                                                                                    \
        for (rig_lean = 0; rig_lean < 2; rig_lean++) law##_holds();                                \
    }                                                                                              \
    static void law##_holds(void)

/* non-zero if a term has an effect; terms that belong together are kept together */
static int rig_does(const struct rig *r, int row) {
    if (row == PEND_TERM_AT_X || row == PEND_TERM_AT_Y) {
        int hung = 0;
        for (int k = 0; k < r->n; k++) hung |= r->terms->hung[k];
        return hung;
    }
    if (row == PEND_TERM_FRICTION_SPEED || row == PEND_TERM_DRAG_SPEED) return 0;
    for (int k = 0; k < r->n; k++)
        if (r->value[r->terms->row[row] + k] != 0) return 1;
    return 0;
}

/* loads with the effective terms; a kernel that supports their kinds computes the rig */
static struct pend_loads rig_leave(const struct rig *r) {
    const struct pend_terms *all = r->terms;
    unsigned char rows[PEND_TERM_ROWS], ones[PEND_TERM_ONES] = {0};
    int drives[4] = {0}, place[4], gone = 0;
    struct pend_terms *terms;
    for (int row = 0; row < PEND_TERM_ROWS; row++) rows[row] = (unsigned char)rig_does(r, row);
    for (int i = 0; i < PEND_TERM_ONES; i++)
        ones[i] = all->one[i] >= 0 && r->value[all->one[i]] != 0;
    for (int i = 0; i < all->harmonics; i++) drives[i] = all->harmonic[i].drives;
    if (pend_terms_new(&terms, r->n, rows, ones, all->harmonics, drives, place) != PEND_OK) abort();
    double *value = calloc((size_t)terms->count + 1, sizeof *value);
    if (!value) abort();
    memcpy(terms->hung, all->hung, (size_t)r->n);
    for (int row = 0; row < PEND_TERM_ROWS; row++)
        if (terms->row[row] >= 0)
            memcpy(value + terms->row[row], r->value + all->row[row], (size_t)r->n * sizeof *value);
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (terms->one[i] >= 0) value[terms->one[i]] = r->value[all->one[i]];
    for (int i = 0; i < all->harmonics; i++)
        memcpy(value + terms->harmonic[i].at, r->value + all->harmonic[i].at, 3 * sizeof *value);
    for (int row = 0; row < PEND_TERM_ROWS; row++)
        gone |= (row == PEND_TERM_FRICTION || row == PEND_TERM_DRAG) && terms->row[row] >= 0;
    CHECK(!jets_loads_suit(r->tree, all));
    CHECK(gone || ones[PEND_TERM_DRAG_PER_MASS] || jets_loads_suit(r->tree, terms));
    return (struct pend_loads){r->loads.gravity, terms, value};
}

static double *rig_term(struct rig *r, enum pend_term_row row, int k) {
    return &r->value[pend_terms_place(r->terms, row, k)];
}

static void rig_harmonic(struct rig *r, int i, double amplitude, double omega, double phase) {
    double *h = r->value + r->terms->harmonic[i].at;
    h[0] = amplitude, h[1] = omega, h[2] = phase;
}

/* samples at start + span i / parts, i = 0 .. parts, in stored order, which is the chain's */
static void rig_run(struct rig *r, double start, double span, int parts) {
    int lean = rig_lean && r->loads.terms;
    struct pend_problem problem = {
        .tree = r->tree,
        .loads = lean ? rig_leave(r) : r->loads,
        .phi = r->phi,
        .rate = r->rate,
        .times = {.count = parts + 1, .start = start, .span = span, .divisor = parts},
        .rtol = 1e-15,
        .atol = 1e-15,
        .atol_given = 1};
    struct pend_samples samples = {.cap = INSTANTS, .t = r->t, .phi = r->angle, .rate = r->speed};
    struct pend_run *run;
    struct pend_error error = {0};
    enum pend_status status = pend_run_new(&run, pend_method_find("taylor"), &problem, &error);
    int done = 0;
    while (status == PEND_OK && !done) status = pend_run_next(run, &samples, 1e9, &done, &error);
    CHECK_SAYING(done, "%s", error.text);
    pend_run_free(&run);
    if (!lean) return;
    OWN(pend_terms, free) *terms = (struct pend_terms *)problem.loads.terms;
    free((double *)problem.loads.value);
}

/* the arithmetic-geometric mean */
static double mean(double a, double b) {
    for (int i = 0; i < 8; i++) {
        double next = (a + b) / 2;
        b = sqrt(a * b), a = next;
    }
    return a;
}

LAW(law_a_bar_swings_with_two_thirds_of_its_length) {
    // T = 2 pi sqrt(2 l / 3 g) / agm(1, cos(A / 2)); after a quarter of it the bar hangs straight
    // down
    double worst = 0, rounds = 0;
    for (int i = 0; i < 4; i++) {
        OWN(rig, close) r;
        double swing = 2.5 * pow(10, -i), l = 0.7 + i;
        rig_open(&r, 1, 9.81, 0, NULL);
        r.length[0] = l, r.mass[0] = 0, r.phi[0] += swing;
        *rig_term(&r, PEND_TERM_ROD, 0) = 3;
        rig_tree(&r);
        double period = 2 * M_PI * sqrt(2 * l / (3 * 9.81)) / mean(1, cos(swing / 2));
        rig_run(&r, 0, period, 4);
        for (int j = 0; j <= 4; j++) {
            static const double way[] = {1, 0, -1, 0, 1};
            worst = fmax(worst, fabs(r.angle[j] + M_PI_2 - way[j] * swing) / swing);
        }
        rounds += fabs(r.speed[1]) > 0.1 * swing;
    }
    CHECK(rounds == 4);
    CHECK_RESIDUAL(worst, 2e-12, "angle at quarters of the period, of the swing");
}

/* J q'' + c q' + k q = b + f cos(w t): the steady motion plus the decaying part of the start */
static double oscillator(double inertia, double c, double k, double b, double f, double w,
                         double start, double t) {
    double beta = c / (2 * inertia), omega = sqrt(k / inertia - beta * beta);
    double in = k - inertia * w * w, out = c * w, size = in * in + out * out;
    double steady = b / k + f * (in * cos(w * t) + out * sin(w * t)) / size;
    double q = start - b / k - f * in / size, v = -f * out * w / size;
    return steady + exp(-beta * t) * (q * cos(omega * t) + (v + beta * q) / omega * sin(omega * t));
}

LAW(law_a_damped_driven_arm_on_a_spring_without_gravity_is_the_linear_oscillator) {
    // damping, drag of the tip and drag per mass all act on q' = phi'; a swing of any size is
    // exactly linear
    struct rig r;
    double worst = 0, most = 0, c = 0.3, b = 0.2, gamma = 0.07, l = 1.3, rod = 0.6, body = 0.9;
    rig_open(&r, 1, 0, 1, (int[]){0});
    r.length[0] = l, r.mass[0] = 1.7, r.phi[0] += 2;
    *rig_term(&r, PEND_TERM_ROD, 0) = rod;
    *rig_term(&r, PEND_TERM_BODY, 0) = body;
    *rig_term(&r, PEND_TERM_CENTER_X, 0) = 0.3;
    *rig_term(&r, PEND_TERM_CENTER_Y, 0) = -0.4;
    *rig_term(&r, PEND_TERM_INERTIA, 0) = 0.11;
    *rig_term(&r, PEND_TERM_DAMPING, 0) = c;
    *rig_term(&r, PEND_TERM_STIFFNESS, 0) = 5;
    *rig_term(&r, PEND_TERM_REST, 0) = 0.25;
    *rig_term(&r, PEND_TERM_TORQUE, 0) = 0.8;
    *rig_term(&r, PEND_TERM_DRAG, 0) = b;
    r.value[r.terms->one[PEND_TERM_DRAG_PER_MASS]] = gamma;
    rig_tree(&r);
    rig_harmonic(&r, 0, 1.9, 1.4, 0);
    double inertia = 1.7 * l * l + rod * l * l / 3 + body * 0.25 + 0.11;
    rig_run(&r, 0, 20, 100);
    for (int j = 0; j <= 100; j++) {
        double exact = oscillator(inertia, c + b * l * l + 2 * gamma * inertia, 5, 0.8 + 5 * 0.25,
                                  1.9, 1.4, 2, r.t[j]);
        worst = fmax(worst, fabs(r.angle[j] + M_PI_2 - exact));
        most = fmax(most, fabs(exact));
    }
    rig_close(&r);
    CHECK(most >= 2);
    CHECK_RESIDUAL(worst, 2e-13, "angle over 20 s");
}

LAW(law_a_damped_pendulum_of_small_swing_decays_as_its_linear_form) {
    struct rig r;
    double worst = 0, swing = 1e-7;
    rig_open(&r, 1, 9.81, 0, NULL);
    r.length[0] = 0.8, r.phi[0] += swing;
    *rig_term(&r, PEND_TERM_DAMPING, 0) = 0.3;
    rig_tree(&r);
    rig_run(&r, 0, 10, 50);
    for (int j = 0; j <= 50; j++) {
        double exact = oscillator(0.64, 0.3, 0.8 * 9.81, 0, 0, 0, r.phi[0] + M_PI_2, r.t[j]);
        worst = fmax(worst, fabs(r.angle[j] + M_PI_2 - exact) / swing);
    }
    rig_close(&r);
    // the angle's own last bit is 2e-16 of 1e-7
    CHECK_RESIDUAL(worst, 2e-8, "angle of a swing of 1e-7 rad, of the swing");
}

LAW(law_an_arm_without_gravity_is_brought_to_rest_by_dry_friction) {
    // J r' = -f tanh(r / s): sinh(r / s) = sinh(r_0 / s) e^{-f t / (J s)}, at rest about J r_0 / f
    enum { PARTS = 80 };
    const double speeds[] = {1, 0.1, 0.01, 1e-3, 1e-5}, torque = 0.5, begin = 2, span = 8;
    double worst = 0;
    for (int way = -1; way <= 1; way += 2)
        for (size_t i = 0; i < sizeof speeds / sizeof *speeds; i++) {
            OWN(rig, close) r;
            rig_open(&r, 1, 0, 0, NULL);
            rig_tree(&r);
            *rig_term(&r, PEND_TERM_FRICTION, 0) = torque;
            *rig_term(&r, PEND_TERM_FRICTION_SPEED, 0) = speeds[i];
            r.rate[0] = way * begin;
            rig_run(&r, 0, span, PARTS);
            for (int k = 0; k <= PARTS; k++) {
                long double a = (long double)begin / speeds[i];
                long double left = a - (long double)torque * r.t[k] / speeds[i];
                // asinh x is ln 2x where x is beyond what a long double holds
                long double rate = left > 40 ? left : asinhl(expl(left) * (1 - expl(-2 * a)) / 2);
                worst = fmax(worst, fabs(way * r.speed[k] - (double)(rate * speeds[i])) / begin);
            }
        }
    CHECK_RESIDUAL(worst, 1e-13, "rates while dry friction brings an arm to rest");
}

/* the largest angle from upright in 8 s of an arm whose pivot oscillates as a cos(W t) vertically,
 * a^2 W^2 = share 2 g l */
static double kapitza(double amplitude, double share) {
    OWN(rig, close) r;
    double most = 0;
    rig_open(&r, 1, 9.81, 1, (int[]){PEND_DRIVE_PIVOT_Y});
    r.phi[0] = M_PI_2 + 0.01;
    rig_tree(&r);
    rig_harmonic(&r, 0, amplitude, sqrt(share * 2 * 9.81) / amplitude, 0);
    // at rest on average, when the pivot passes its middle
    rig_run(&r, 0, 8, 1000);
    for (int j = 0; j <= 1000; j++) most = fmax(most, fabs(r.angle[j] - M_PI_2));
    return most;
}

LAW(law_an_arm_stands_upside_down_from_kapitzas_threshold_on) {
    for (int i = 0; i < 2; i++) {
        double amplitude = i ? 0.01 : 0.03;
        for (int share = 5; share <= 15; share += 2) {
            double most = kapitza(amplitude, share / 10.0);
            if (share < 10) CHECK_SAYING(most > 1, "falls below: %g of %d", most, share);
            if (share > 10) CHECK_SAYING(most < 0.1, "stands above: %g of %d", most, share);
        }
    }
}

/* the distance of two runs at their last samples */
static double rig_apart(const struct rig *a, const struct rig *b, int last) {
    double gap = 0;
    for (int k = 0; k < a->n; k++) {
        int at = last * a->n + k;
        gap = fmax(gap, fabs(a->angle[at] - b->angle[at]) + fabs(a->speed[at] - b->speed[at]));
    }
    return gap;
}

/* three rods with springs, a shaken pivot and a driven joint, both even about t = 0 */
static void rig_even(struct rig *r, double friction) {
    rig_open(r, 3, 9.81, 2, (int[]){PEND_DRIVE_PIVOT_X, 1});
    for (int k = 0; k < 3; k++) {
        r->phi[k] += 0.9 - 0.8 * k, r->rate[k] = 0.5 + k;
        *rig_term(r, PEND_TERM_ROD, k) = 1.2;
        *rig_term(r, PEND_TERM_STIFFNESS, k) = 3 + k;
        *rig_term(r, PEND_TERM_REST, k) = 0.2;
        *rig_term(r, PEND_TERM_DAMPING, k) = 0.1 * friction;
        *rig_term(r, PEND_TERM_FRICTION, k) = 0.1 * friction;
        *rig_term(r, PEND_TERM_DRAG, k) = 0.1 * friction;
        *rig_term(r, PEND_TERM_DRAG_QUADRATIC, k) = 0.1 * friction;
    }
    r->value[r->terms->one[PEND_TERM_DRAG_PER_MASS]] = 0.1 * friction;
    rig_tree(r);
    rig_harmonic(r, 0, 0.1, 5, 0);
    rig_harmonic(r, 1, 0.7, 3, 0);
}

LAW(law_without_friction_and_with_even_drives_time_may_be_reversed) {
    double gap[2];
    for (int friction = 0; friction < 2; friction++) {
        struct rig on, back;
        rig_even(&on, friction);
        rig_even(&back, friction);
        rig_run(&on, 0, 3, 1);
        for (int k = 0; k < 3; k++) back.rate[k] = -back.rate[k];
        rig_run(&back, 0, -3, 1);
        for (int k = 0; k < 3; k++) back.speed[3 + k] = -back.speed[3 + k];
        gap[friction] = rig_apart(&on, &back, 1);
        rig_close(&on);
        rig_close(&back);
    }
    CHECK_SAYING(gap[0] < 1e-13, "reversed rates after -3 s against 3 s: %g", gap[0]);
    CHECK_SAYING(gap[1] > 0.1, "friction is reversed too: %g", gap[1]);
}

LAW(law_what_loses_energy_finds_its_start_again_when_run_backwards) {
    struct rig on, back;
    rig_even(&on, 1);
    rig_even(&back, 1);
    rig_run(&on, 0, 2, 1);
    memcpy(back.phi, on.angle + 3, sizeof back.phi);
    memcpy(back.rate, on.speed + 3, sizeof back.rate);
    rig_run(&back, 2, -2, 1);
    double gap = 0;
    for (int k = 0; k < 3; k++)
        gap = fmax(gap, fabs(back.angle[3 + k] - on.phi[k]) + fabs(back.speed[3 + k] - on.rate[k]));
    CHECK_RESIDUAL(gap, 1e-12, "the start, from 2 s on");
    rig_close(&on);
    rig_close(&back);
}

LAW(law_a_body_of_two_masses_is_two_arms_that_a_stiff_spring_joins) {
    // 1 kg at 1 m, 0.5 kg at 0.7 m from there, rotated by 0.4 rad: one rigid body
    struct rig body;
    double x = 1 + 0.7 * cos(0.4), y = 0.7 * sin(0.4), gap[2];
    rig_open(&body, 1, 9.81, 0, NULL);
    body.phi[0] = 0.3;
    *rig_term(&body, PEND_TERM_BODY, 0) = 0.5;
    *rig_term(&body, PEND_TERM_CENTER_X, 0) = x;
    *rig_term(&body, PEND_TERM_CENTER_Y, 0) = y;
    rig_tree(&body);
    rig_run(&body, 0, 1, 10);
    for (int i = 0; i < 2; i++) {
        OWN(rig, close) two;
        rig_open(&two, 2, 9.81, 0, NULL);
        two.length[1] = 0.7, two.mass[1] = 0.5, two.phi[0] = 0.3, two.phi[1] = 0.7;
        *rig_term(&two, PEND_TERM_STIFFNESS, 1) = i ? 1e5 : 1e4;
        *rig_term(&two, PEND_TERM_REST, 1) = 0.4;
        rig_tree(&two);
        rig_run(&two, 0, 1, 10);
        gap[i] = 0;
        for (int j = 0; j <= 10; j++) gap[i] = fmax(gap[i], fabs(two.angle[2 * j] - body.angle[j]));
    }
    rig_close(&body);
    CHECK_RESIDUAL(gap[1], 1e-3, "angle with a spring of 1e5 N m/rad");
    double ratio = gap[0] / gap[1];
    CHECK_SAYING(ratio > 7 && ratio < 14, "ten times the stiffness: %g times nearer", ratio);
}

LAW(law_an_arm_on_a_rods_point_is_the_ideal_tree_as_the_rod_weighs_nothing) {
    // a mass at 0.6 m on an arm of 1 m, to which the second arm is attached
    struct rig ideal;
    double gap[3];
    rig_open(&ideal, 2, 9.81, 0, NULL);
    ideal.length[0] = 0.6, ideal.phi[0] += 2, ideal.phi[1] += 1;
    rig_tree(&ideal);
    ideal.loads = (struct pend_loads){.gravity = 9.81};
    rig_run(&ideal, 0, 2, 1);
    for (int i = 0; i < 3; i++) {
        OWN(rig, close) rod;
        rig_open(&rod, 2, 9.81, 0, NULL);
        rod.phi[0] += 2, rod.phi[1] += 1, rod.mass[0] = 0;
        *rig_term(&rod, PEND_TERM_ROD, 0) = i ? pow(10, -4 - i) : 0;
        *rig_term(&rod, PEND_TERM_BODY, 0) = 1;
        *rig_term(&rod, PEND_TERM_CENTER_X, 0) = *rig_term(&rod, PEND_TERM_AT_X, 1) = 0.6;
        rod.terms->hung[1] = 1;
        rig_tree(&rod);
        rig_run(&rod, 0, 2, 1);
        gap[i] = rig_apart(&rod, &ideal, 1);
    }
    rig_close(&ideal);
    CHECK_RESIDUAL(gap[0], 5e-13, "a rod of 0 kg, after 2 s");
    CHECK_RESIDUAL(gap[2], 1e-4, "a rod of 1e-6 kg, after 2 s");
    CHECK_SAYING(fabs(gap[1] / gap[2] - 10) < 0.1, "a tenth of the mass: %g", gap[1] / gap[2]);
}

/* the number of periods of its drive after which the motion repeats: 1, 2, 4, 8, or 0 for none of
 * them; tested after `before` periods, over 64 */
static int repeats(struct rig *r, double period, int before) {
    rig_run(r, 0, before * period, before);
    for (int every = 1; every <= 8; every *= 2) {
        double gap = 0;
        for (int j = before - 64; j <= before - 8; j++)
            gap = fmax(gap, fabs(remainder(r->angle[j + every] - r->angle[j], 2 * M_PI)));
        if (gap < 1e-4) return every;
    }
    return 0;
}

/*
 * theta'' + theta' / 2 + sin theta = b cos(2 t / 3), the pendulum of both books (J. R. Taylor's in
 * units of 1 / (3 pi) s). Its periods double where a multiplier of the orbit is -1. SciPy 1.10
 * found these by Newton's method on the orbit and its variation over its period (DOP853, 3e-13),
 * and Brent's on the multiplier: from hanging, and turning over once a period. Taylor
 * prints 1.0663, 1.0793 and 1.0821.
 */
static const double doubles[] = {1.06637286246, 1.07931390590, 1.08208438429},
                    turning_doubles[] = {1.42487324721, 1.45982460384};

LAW(law_the_driven_damped_pendulum_doubles_its_period_where_its_multiplier_is_minus_1) {
    // w = 2 pi, w_0 = 1.5 w, beta = w_0 / 4, from -pi/2 at rest
    const struct {
        double gamma;
        int every;
    } tries[] = {{doubles[0] - 1e-3, 1},
                 {doubles[0] + 1e-3, 2},
                 {doubles[1] - 5e-4, 2},
                 {doubles[1] + 5e-4, 4},
                 {doubles[2] - 1e-4, 4},
                 {doubles[2] + 2e-4, 8},
                 {1.105, 0}};
    for (int i = 0; i < 7; i++) {
        OWN(rig, close) r;
        double w = 1.5 * 2 * M_PI;
        rig_open(&r, 1, w * w, 1, (int[]){0});
        r.phi[0] = -M_PI;
        *rig_term(&r, PEND_TERM_DAMPING, 0) = w / 2;
        rig_tree(&r);
        rig_harmonic(&r, 0, tries[i].gamma * w * w, 2 * M_PI, 0);
        int every = repeats(&r, 1, 600);
        CHECK_SAYING(every == tries[i].every, "gamma %g repeats after %d", tries[i].gamma, every);
    }
}

LAW(law_the_pendulum_of_baker_and_gollub_goes_to_chaos_and_back) {
    // G. L. Baker and J. P. Gollub, Chaotic Dynamics (Cambridge 1990)
    const struct {
        double b;
        int every;
    } tries[] = {{0.9, 1},
                 {doubles[0] - 2e-3, 1},
                 {doubles[0] + 2e-3, 2},
                 {1.15, 0},
                 {1.35, 1},
                 {turning_doubles[0] - 2e-3, 1},
                 {turning_doubles[0] + 2e-3, 2},
                 {turning_doubles[1] - 2e-3, 2},
                 {turning_doubles[1] + 2e-3, 4},
                 {1.5, 0}};
    for (size_t i = 0; i < sizeof tries / sizeof *tries; i++) {
        OWN(rig, close) r;
        rig_open(&r, 1, 1, 1, (int[]){0});
        r.phi[0] += 0.2;
        *rig_term(&r, PEND_TERM_DAMPING, 0) = 0.5;
        rig_tree(&r);
        rig_harmonic(&r, 0, tries[i].b, 2.0 / 3, 0);
        int every = repeats(&r, 3 * M_PI, 400);
        CHECK_SAYING(every == tries[i].every, "b %g repeats after %d", tries[i].b, every);
    }
}

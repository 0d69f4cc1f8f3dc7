/* 32 digits: a tumbling double pendulum alone and in lanes, compared with the same recurrences in
 * the compiler's quadruple precision; and very long runs: the energy error of symplectic, of
 * taylor, and of GSL's rk4 with the same computing time. Leaves to others: trajectories in doubles
 * (bench_trajectory). Invariant: the final state of timed code is checked with 32 digits, or its
 * energy error is reported. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "core/dynamics/dynamics.h"
#include "core/dynamics/kinematics.h"
#include "core/extended/extended.h"
#include "core/integrate/methods/method.h"
#include "tests/bench/parts/bench.h"

enum { ARMS = 2 };

static const struct pend_loads loads = {.gravity = 9.81};
static const double one[ARMS] = {1, 1};
static const int chain[ARMS] = {-1, 0};
/* theta = (2, 2.5), at rest; the state after 20 s to 15 digits and more */
static const double tumble[ARMS] = {2 - M_PI_2, 2.5 - M_PI_2}, still[ARMS];
static const double tumbled[ARMS] = {-1.4164560416052849, -43.45858340112293};

static struct pend_tree *pair_new(void) {
    struct pend_tree *tree;
    if (pend_tree_new(&tree, ARMS, one, one, chain, NULL) != PEND_OK) bench_broken("tree");
    return tree;
}

BENCH(extended_double_pendulum_alone, "s of 20 s, all digits of a double at the end") {
    struct pend_tree *tree = pair_new();
    struct pend_extended *extended;
    double phi[ARMS], rate[ARMS];
    struct pend_extended_state start = {.phi = (double *)tumble, .rate = (double *)still},
                               end = {.phi = phi, .rate = rate};
    if (pend_extended_new(&extended, tree, NULL, 1e-30, 0, pend_isa_best(), NULL) != PEND_OK)
        bench_broken("memory");
    while (bench_go(bench, 20)) {
        pend_extended_start(extended, &loads, &start, 0, 20);
        while (pend_extended_step(extended) == PEND_EXTENDED_UNDER_WAY) continue;
        pend_extended_end(extended, &end);
        for (int k = 0; k < ARMS; k++)
            if (!(fabs(phi[k] - tumbled[k]) <= 1e-15 * fabs(tumbled[k]))) bench_broken("a digit");
    }
    pend_extended_free(&extended);
    pend_tree_free(&tree);
}

/* ---- the peer: the same recurrences, order and step rule in the compiler's own type; 1 / (j + 1)
 * is a double, so that only its time is meaningful */

#ifdef __x86_64__
#define NUMBER_OTHER __float128
__float128 sinf128(__float128 x);
__float128 cosf128(__float128 x);
static inline __float128 num_of(double x) { return x; }
static inline __float128 num_add(__float128 x, __float128 y) { return x + y; }
static inline __float128 num_sub(__float128 x, __float128 y) { return x - y; }
static inline __float128 num_mul(__float128 x, __float128 y) { return x * y; }
static inline __float128 num_div(__float128 x, __float128 y) { return x / y; }
static inline __float128 num_fma(__float128 x, __float128 y, __float128 z) { return x * y + z; }
static inline __float128 num_neg(__float128 x) { return -x; }
#include "core/taylor/jets_template.h"

enum { ORDER = 40 };

struct quad {
    struct jets_system system;
    double share[ORDER + 2];
    num series[4][(ORDER + 3) * ARMS], array[64 * ARMS], phi[ARMS], rate[ARMS];
};

static void quad_init(struct quad *q, const struct pend_tree *tree) {
    num *at = q->array;
    memset(q, 0, sizeof *q);
    q->system = (struct jets_system){
        .n = ARMS, .stride = ARMS, .tile = 8, .parent = tree->parent, .end = tree->end};
    q->system.share = q->share;
    q->system.rate = q->series[0];
    q->system.force = q->series[1] + ARMS;
    q->system.turn_re = q->series[2];
    q->system.turn_im = q->series[3];
#define X(name) q->system.name = at, at += ARMS;
    JETS_ARRAYS(X)
#undef X
    for (int j = 0; j < ORDER + 2; j++) q->share[j] = 1.0 / (j + 1);
    for (int k = 0; k < ARMS; k++) {
        q->system.len[k] = q->system.inv_len[k] = q->system.mass[k] = 1;
        q->phi[k] = tumble[k];
    }
}

static double quad_step(struct quad *q) {
    struct jets_system *s = &q->system;
    double lead = 0, x = INFINITY;
    for (int k = 0; k < ARMS; k++) {
        num angle = k ? q->phi[k] - q->phi[0] : q->phi[0];
        s->sine[k] = sinf128(angle);
        s->cosine[k] = cosf128(angle);
        s->rate[k] = q->rate[k];
    }
    jets_factor(s);
    jets_orders(s, loads.gravity, ORDER);
    for (int k = 0; k < ARMS; k++)
        lead = fmax(lead, fmax(fabs((double)s->rate[k]), fabs((double)s->rate[ARMS + k])));
    for (int j = ORDER - 3; j <= ORDER; j++)
        for (int k = 0; k < ARMS; k++)
            x = fmin(x, pow(0x1p-106 * lead / fabs((double)s->rate[j * ARMS + k]), 1.0 / j));
    for (int k = 0; k < ARMS; k++) {
        num phi = 0, rate = 0;
        for (int j = ORDER; j >= 0; j--) {
            rate = rate * x + s->rate[j * ARMS + k];
            phi = phi * x + s->rate[j * ARMS + k] / (j + 1);
        }
        q->phi[k] += phi * x;
        q->rate[k] = rate;
    }
    return x;
}

BENCH(extended_double_pendulum_quad_of_the_compiler, "s of the first second") {
    struct pend_tree *tree = pair_new();
    static struct quad quad;
    while (bench_go(bench, 1)) {
        quad_init(&quad, tree);
        for (double t = 0; t < 1; t += quad_step(&quad)) continue;
        if (!(fabs((double)quad.phi[1]) < 10)) bench_broken("quad");
    }
    pend_tree_free(&tree);
}
#endif

/* ---- very long runs: 1000 s, about 350 periods, of a double pendulum with large swings */

static const double swing[ARMS] = {1 - M_PI_2, 1 - M_PI_2};

/* reported in the unit: the largest error of the energy so far, relative to the energy scale of the
 * tree */
static void swing_tell(struct bench *bench, char *text, double worst) {
    snprintf(text, 80, "s of motion, energy within %.0e after 1000 s", worst);
    bench->unit = text;
}

static double swing_error(const struct pend_tree *tree, const double phi[], const double rate[]) {
    struct pend_energy first = pend_kinematics_energy(tree, &loads, swing, still);
    struct pend_energy now = pend_kinematics_energy(tree, &loads, phi, rate);
    return fabs(now.kinetic + now.potential - first.kinetic - first.potential) /
           pend_kinematics_energy_scale(tree, &loads, first.kinetic);
}

static void swing_method(struct bench *bench, const struct pend_method *method, double rtol,
                         char *text) {
    struct pend_tree *tree = pair_new();
    double phi[ARMS], rate[ARMS], worst = 0;
    struct pend_problem problem = {
        .tree = tree, .loads = loads, .phi = swing, .rate = still, .rtol = rtol};
    problem.times = (struct pend_times){.count = 2, .span = 1000, .divisor = 1};
    while (bench_go(bench, 1000)) {
        void *stepper;
        double reached = 0;
        if (method->open(&stepper, &problem, NULL) != PEND_OK) bench_broken(method->name);
        while (reached < 1000)
            if (method->step(stepper, 1000, &reached, NULL) != PEND_OK) bench_broken(method->name);
        method->at(stepper, &reached, 1, &(struct pend_points){.phi = phi, .rate = rate});
        worst = fmax(worst, swing_error(tree, phi, rate));
        method->close(&stepper);
    }
    swing_tell(bench, text, worst);
    pend_tree_free(&tree);
}

BENCH(long_run_symplectic, "") {
    static char text[80];
    swing_method(bench, &pend_method_symplectic, 0, text);
}

BENCH(long_run_taylor_1e_16, "") {
    static char text[80];
    swing_method(bench, &pend_method_taylor, 1e-16, text);
}

struct swing_equations {
    const struct pend_tree *tree;
    void *work;
};

static int swing_derivative(double t, const double y[], double f[], void *context) {
    const struct swing_equations *equations = context;
    (void)t;
    memcpy(f, y + ARMS, ARMS * sizeof(double));
    pend_dynamics(equations->tree, &loads, y, y + ARMS, equations->work, f + ARMS, NULL);
    return GSL_SUCCESS;
}

/* GSL's classical fourth order with a fixed step that takes about as long as symplectic */
BENCH(long_run_gsl_rk4_of_4_ms, "") {
    static char text[80];
    enum { STEPS = 250000 };
    struct swing_equations equations = {
        pair_new(), aligned_alloc(64, (pend_dynamics_work_bytes(ARMS) + 63) / 64 * 64)};
    gsl_odeiv2_system system = {swing_derivative, NULL, 2 * ARMS, &equations};
    gsl_odeiv2_step *step = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk4, 2 * ARMS);
    double y[2 * ARMS], error[2 * ARMS];
    if (!equations.work || !step) bench_broken("memory");
    while (bench_go(bench, 1000)) {
        memcpy(y, swing, sizeof swing);
        memcpy(y + ARMS, still, sizeof still);
        for (int i = 0; i < STEPS; i++)
            if (gsl_odeiv2_step_apply(step, 0.004 * i, 0.004, y, error, NULL, NULL, &system))
                bench_broken("rk4");
    }
    swing_tell(bench, text, swing_error(equations.tree, y, y + ARMS));
    gsl_odeiv2_step_free(step);
    free(equations.work);
    pend_tree_free((struct pend_tree **)&equations.tree);
}

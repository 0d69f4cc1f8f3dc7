#include "tests/harness/found.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/isa.h"
#include "core/extended/extended.h"
#include "tests/harness/test.h"

static void found_keep(struct found *f, const struct pend_orbit *o) {
    size_t n = (size_t)f->tree->n, row = (size_t)f->rows++;
    REQUIRE(f->rows <= FOUND_ROWS);
    memcpy(f->phi[row], o->phi, n * sizeof(double));
    memcpy(f->low[row], o->phi_low, n * sizeof(double));
    memcpy(f->rate[row], o->rate, n * sizeof(double));
    memcpy(f->amplitude[row], o->amplitude, n * sizeof(double));
    memcpy(f->re[row], o->re, 2 * n * sizeof(double));
    memcpy(f->im[row], o->im, 2 * n * sizeof(double));
    f->period[row] = o->period, f->energy[row] = o->energy, f->value[row] = o->value;
    f->closure[row] = o->closure, f->stable[row] = o->stable;
}

void found_search(struct found *f) {
    OWN(pend_orbits, free) *search;
    struct pend_error error = {.code = PEND_OK};
    enum pend_orbits_found what = PEND_ORBITS_NOTHING;
    f->problem.tree = f->tree;
    f->rows = f->bifurcations = 0, f->calls = 0;
    f->status = pend_orbits_new(&search, &f->problem, &error);
    while (f->status == PEND_OK && what != PEND_ORBITS_END) {
        f->status = pend_orbits_next(search, &what, &error), f->calls++;
        if (f->status != PEND_OK) break;
        struct pend_orbit orbit = pend_orbits_orbit(search);
        if (what == PEND_ORBITS_ORBIT) found_keep(f, &orbit);
        if (what != PEND_ORBITS_BIFURCATION) continue;
        REQUIRE(f->bifurcations < FOUND_KINDS);
        f->kind[f->bifurcations] = orbit.kind;
        f->after[f->bifurcations] = f->rows - 1;
        f->turns[f->bifurcations] = orbit.turns;
        size_t numbers = 2 * (size_t)f->tree->n;
        memcpy(f->re_there[f->bifurcations], orbit.re, numbers * sizeof(double));
        memcpy(f->im_there[f->bifurcations], orbit.im, numbers * sizeof(double));
        f->at[f->bifurcations++] = f->problem.driven ? orbit.value : orbit.energy;
    }
    if (f->status == PEND_OK) f->end = pend_orbits_end(search);
    if (f->status == PEND_OK) (void)pend_orbits_steps(search, &f->maps);
}

struct found *found_chain(int n, int mode, double amplitude, int branch) {
    double length[FOUND_ARMS], mass[FOUND_ARMS];
    int parent[FOUND_ARMS];
    struct found *f = calloc(1, sizeof *f);
    CHECK(f && n <= FOUND_ARMS);
    for (int k = 0; k < n; k++) length[k] = mass[k] = 1, parent[k] = k - 1;
    CHECK(pend_tree_new(&f->tree, n, length, mass, parent, NULL) == PEND_OK);
    f->problem = (struct pend_orbit_problem){.loads = {.gravity = 9.81},
                                             .branch = branch,
                                             .points = 300,
                                             .step = branch ? 0.1 : 0.3,
                                             .mode = mode,
                                             .target = PEND_ORBIT_AMPLITUDE,
                                             .until = amplitude};
    return f;
}

struct found *found_trunk(int n, int mode, double amplitude, int branch) {
    double length[FOUND_ARMS] = {1}, mass[FOUND_ARMS] = {1};
    int parent[FOUND_ARMS] = {-1};
    struct found *f = found_chain(n, mode, amplitude, branch);
    for (int k = 1; k < n; k++) length[k] = 0.7, mass[k] = 0.6;
    pend_tree_free(&f->tree);
    CHECK(pend_tree_new(&f->tree, n, length, mass, parent, NULL) == PEND_OK);
    return f;
}

const struct pend_terms *found_terms(struct found *f, enum pend_term_row row, int harmonics) {
    static const int drives[] = {0};
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int place[1];
    rows[row] = 1;
    CHECK(pend_terms_new(&f->terms, f->tree->n, rows, ones, harmonics, drives, place) == PEND_OK);
    CHECK(f->terms->count <= (int)(sizeof f->term / sizeof *f->term));
    f->problem.loads.terms = f->terms, f->problem.loads.value = f->term;
    return f->terms;
}

struct found *found_driven(double damping, double torque, double omega) {
    struct found *f = found_chain(1, 0, 1, 0);
    const struct pend_terms *terms = found_terms(f, PEND_TERM_DAMPING, 1);
    static const double hanging[] = {-M_PI / 2}, still[] = {0};
    f->term[pend_terms_place(terms, PEND_TERM_DAMPING, 0)] = damping;
    f->term[terms->harmonic[0].at] = torque, f->term[terms->harmonic[0].at + 1] = omega;
    f->problem.loads.gravity = 1;
    f->problem.driven = f->problem.periods = 1;
    f->problem.phi = hanging, f->problem.rate = still;
    f->problem.step = 0.1;
    return f;
}

void found_free(struct found **f) {
    if (!*f) return;
    pend_terms_free(&(*f)->terms);
    pend_tree_free(&(*f)->tree);
    free(*f);
    *f = NULL;
}

/* ---- multipliers in 32 digits */

void found_moved(const struct found *f, int row, double time, int j, double h, double out[],
                 double out_low[]) {
    int n = f->tree->n;
    double state[4 * FOUND_ARMS];
    OWN(pend_extended, free) *run;
    enum pend_extended_stage stage;
    memset(state, 0, sizeof state);
    for (int k = 0; k < n; k++) {
        state[k] = f->phi[row][k], state[FOUND_ARMS + k] = f->low[row][k];
        state[2 * FOUND_ARMS + k] = f->rate[row][k];
    }
    // the low parts hold the whole of h, so that it is exact
    if (j >= 0) state[(j < n ? FOUND_ARMS + j : 3 * FOUND_ARMS + j - n)] += h;
    struct pend_extended_state start = {state, state + FOUND_ARMS, state + 2 * FOUND_ARMS,
                                        state + 3 * FOUND_ARMS};
    struct pend_extended_state end = {out, out_low, out + n, out_low + n};
    REQUIRE(pend_extended_new(&run, f->tree, f->problem.loads.terms, 1e-28, 1e-30, pend_isa_best(),
                              NULL) == PEND_OK);
    pend_extended_start(run, &f->problem.loads, &start, 0, time);
    while ((stage = pend_extended_step(run)) == PEND_EXTENDED_UNDER_WAY) continue;
    CHECK(stage == PEND_EXTENDED_STOPPED);
    pend_extended_end(run, &end);
}

/* the trace of the monodromy matrix, and that of its square, from central differences of motions
 * in 32 digits over the whole period */
static void traces(const struct found *f, int row, double *trace, double *square) {
    enum { ALL = 2 * FOUND_ARMS };
    int m = 2 * f->tree->n;
    static double matrix[ALL][ALL];
    double h = 1e-10, plus[ALL], plus_low[ALL], minus[ALL], minus_low[ALL];
    for (int j = 0; j < m; j++) {
        found_moved(f, row, f->period[row], j, h, plus, plus_low);
        found_moved(f, row, f->period[row], j, -h, minus, minus_low);
        for (int i = 0; i < m; i++)
            matrix[i][j] = ((plus[i] - minus[i]) + (plus_low[i] - minus_low[i])) / (2 * h);
    }
    *trace = *square = 0;
    for (int i = 0; i < m; i++) {
        *trace += matrix[i][i];
        for (int j = 0; j < m; j++) *square += matrix[i][j] * matrix[j][i];
    }
}

void found_check_multipliers(const struct found *f, int row) {
    double trace, square, size = 1;
    double complex sum = 0, squares = 0;
    traces(f, row, &trace, &square);
    for (int j = 0; j < 2 * f->tree->n; j++) {
        double complex x = f->re[row][j] + I * f->im[row][j];
        sum += x, squares += x * x;
        size = fmax(size, cabs(x));
    }
    // a pair of ones is accurate to the square root of the rounding errors; 6e-12 was observed
    CHECK(fabs(creal(sum) - trace) < 1e-11 * size * size && fabs(cimag(sum)) < 1e-12 * size);
    CHECK(fabs(creal(squares) - square) < 1e-11 * size * size);
}

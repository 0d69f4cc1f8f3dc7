#include "core/dynamics/dynamics.h"

#include <assert.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/dynamics/dynamics_careful.h"
#include "core/dynamics/kernel_dynamics.h"

static const struct dynamics_kernel *dynamics_kernel(enum pend_isa isa) {
    return PEND_ISA_PICK(pend_kernel_dynamics, isa);
}

static size_t dynamics_row(int n) {
    return ((size_t)n + DYNAMICS_BLOCK - 1) / DYNAMICS_BLOCK * DYNAMICS_BLOCK;
}

/* the scratch memory that either form needs, then space for forces the caller did not request, then
 * for rates that acc would overwrite */
static size_t dynamics_shared_bytes(int n) {
    size_t quick = DYNAMICS_VALUES * dynamics_row(n) * sizeof(double),
           careful = pend_dynamics_careful_bytes(n);
    return quick > careful ? quick : careful;
}

/* requirements of every form; pend_tree_new has checked the tree's own invariants */
PEND_VALIDATOR dynamics_valid(const struct pend_tree *tree, const struct pend_loads *loads,
                              const void *work) {
    return tree && tree->n >= 1 && isfinite(loads->gravity) && (size_t)work % 64 == 0;
}

size_t pend_dynamics_work_bytes(int n) {
    assert(n >= 1);
    return dynamics_shared_bytes(n) + 2 * dynamics_row(n) * sizeof(double);
}

void pend_dynamics_for(enum pend_isa isa, const struct pend_tree *tree,
                       const struct pend_loads *loads, const double phi[], const double rate[],
                       void *work, double acc[], double force[]) {
    assert(dynamics_valid(tree, loads, work));
    assert(phi != acc && phi != force && rate != force);
    double *spare = (double *)((char *)work + dynamics_shared_bytes(tree->n)),
           *kept = spare + dynamics_row(tree->n);
    // keep the rates: the fast form writes acc before it knows whether it lost digits
    if (rate == acc) rate = memcpy(kept, rate, (size_t)tree->n * sizeof *rate);
    if (!dynamics_kernel(isa)->one(tree, loads, phi, rate, work, acc, force ? force : spare))
        pend_dynamics_careful(tree, loads, phi, rate, work, acc, force);
}

void pend_dynamics(const struct pend_tree *tree, const struct pend_loads *loads, const double phi[],
                   const double rate[], void *work, double acc[], double force[]) {
    pend_dynamics_for(pend_isa_best(), tree, loads, phi, rate, work, acc, force);
}

size_t pend_dynamics_at_bytes(const struct pend_tree *tree, const struct pend_loads *loads) {
    return loads->terms ? pend_bodies_bytes(tree, loads->terms) : pend_dynamics_work_bytes(tree->n);
}

void pend_dynamics_at(const struct pend_tree *tree, const struct pend_loads *loads, double time,
                      const double phi[], const double rate[], void *work, double acc[],
                      double force[]) {
    struct bodies_state state = {phi, NULL, rate, time, 0};
    struct bodies_forces forces = {.tip_along = force};
    if (loads->terms)
        pend_bodies_at(tree, loads, &state, work, acc, &forces);
    else
        pend_dynamics(tree, loads, phi, rate, work, acc, force);
}

/* masses count as unlike beyond this ratio; a chain is solved in pieces up to the same ratio */
static const double DYNAMICS_UNLIKE = 64;

int pend_dynamics_unlike(const struct pend_tree *tree, const struct pend_loads *loads) {
    const struct pend_terms *terms = loads->terms;
    double least = INFINITY, most = 0;
    assert(tree->n >= 1);
    for (int k = 0; k < tree->n; k++) {
        double mass = tree->mass[k];
        if (terms)
            mass += pend_terms_get(terms, loads->value, PEND_TERM_ROD, k) +
                    pend_terms_get(terms, loads->value, PEND_TERM_BODY, k);
        least = fmin(least, mass), most = fmax(most, mass);
    }
    return most > DYNAMICS_UNLIKE * least;
}

/* memory of the fast form, then that of one state of the careful form: phi, rate, acc, force and
 * its scratch */
static size_t dynamics_vec_quick_bytes(int n) {
    return (size_t)DYNAMICS_VALUES * DYNAMICS_VEC * (size_t)n * sizeof(double);
}

size_t pend_dynamics_vec_bytes(int n) {
    assert(n >= 1);
    return dynamics_vec_quick_bytes(n) + 4 * dynamics_row(n) * sizeof(double) +
           pend_dynamics_careful_bytes(n);
}

static void dynamics_lane(const struct pend_tree *tree, const struct pend_loads *loads,
                          const double phi[], const double rate[], void *work, double acc[],
                          double force[]) {
    size_t row = dynamics_row(tree->n);
    double *one = (double *)((char *)work + dynamics_vec_quick_bytes(tree->n));
    for (int k = 0; k < tree->n; k++)
        one[k] = phi[DYNAMICS_VEC * k], one[row + k] = rate[DYNAMICS_VEC * k];
    pend_dynamics_careful(tree, loads, one, one + row, one + 4 * row, one + 2 * row, one + 3 * row);
    for (int k = 0; k < tree->n; k++) {
        acc[DYNAMICS_VEC * k] = one[2 * row + k];
        force[DYNAMICS_VEC * k] = one[3 * row + k];
    }
}

void pend_dynamics_vec_for(enum pend_isa isa, const struct pend_tree *tree,
                           const struct pend_loads *loads, const double phi[], const double rate[],
                           void *work, double acc[], double force[]) {
    assert(dynamics_valid(tree, loads, work));
    assert(phi != acc && rate != acc && force && force != acc);
    unsigned kept = dynamics_kernel(isa)->lanes(tree, loads, phi, rate, work, acc, force);
    for (int i = 0; i < DYNAMICS_VEC; i++)
        if (!(kept >> i & 1))
            dynamics_lane(tree, loads, phi + i, rate + i, work, acc + i, force + i);
}

void pend_dynamics_vec(const struct pend_tree *tree, const struct pend_loads *loads,
                       const double phi[], const double rate[], void *work, double acc[],
                       double force[]) {
    pend_dynamics_vec_for(pend_isa_best(), tree, loads, phi, rate, work, acc, force);
}

/* the fewest rows for which filling all lanes pays; the largest tree whose lanes fit into the
 * cache */
enum { DYNAMICS_VEC_LEAST = 4, DYNAMICS_VEC_ARMS = 1024 };

size_t pend_dynamics_many_bytes(int n) {
    assert(n >= 1);
    if (n > DYNAMICS_VEC_ARMS) return pend_dynamics_work_bytes(n);
    size_t lanes = 4 * DYNAMICS_VEC * (size_t)n * sizeof(double) + pend_dynamics_vec_bytes(n);
    return lanes > pend_dynamics_work_bytes(n) ? lanes : pend_dynamics_work_bytes(n);
}

/* computes up to DYNAMICS_VEC rows; lanes without a row repeat the last one */
static void dynamics_rows(const struct pend_tree *tree, const struct pend_loads *loads, int count,
                          const double phi[], const double rate[], void *work, double acc[],
                          double force[]) {
    int n = tree->n;
    size_t all = DYNAMICS_VEC * (size_t)n;
    double *lane_phi = work, *lane_rate = lane_phi + all, *lane_acc = lane_rate + all,
           *lane_force = lane_acc + all;
    for (int k = 0; k < n; k++)
        for (int i = 0; i < DYNAMICS_VEC; i++) {
            size_t from = (size_t)(i < count ? i : count - 1) * (size_t)n + (size_t)k;
            lane_phi[DYNAMICS_VEC * k + i] = phi[from];
            lane_rate[DYNAMICS_VEC * k + i] = rate[from];
        }
    pend_dynamics_vec(tree, loads, lane_phi, lane_rate, lane_force + all, lane_acc, lane_force);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < n; k++) {
            acc[(size_t)i * (size_t)n + (size_t)k] = lane_acc[DYNAMICS_VEC * k + i];
            force[(size_t)i * (size_t)n + (size_t)k] = lane_force[DYNAMICS_VEC * k + i];
        }
}

void pend_dynamics_many(const struct pend_tree *tree, const struct pend_loads *loads, long count,
                        const double phi[], const double rate[], void *work, double acc[],
                        double force[]) {
    assert(dynamics_valid(tree, loads, work));
    assert(count >= 0 && force && force != acc && phi != acc && rate != acc);
    long least = tree->n > DYNAMICS_VEC_ARMS ? LONG_MAX : DYNAMICS_VEC_LEAST;
    while (count > 0) {
        int rows = count < least ? 1 : count < DYNAMICS_VEC ? (int)count : DYNAMICS_VEC;
        size_t step = (size_t)rows * (size_t)tree->n;
        if (rows > 1)
            dynamics_rows(tree, loads, rows, phi, rate, work, acc, force);
        else
            pend_dynamics(tree, loads, phi, rate, work, acc, force);
        phi += step, rate += step, acc += step, force += step, count -= rows;
    }
}

void pend_dynamics_fine(const struct pend_tree *tree, const struct pend_loads *loads,
                        const double phi[], const double phi_low[], const double rate[], void *work,
                        double scratch[], double acc[], double force[]) {
    assert(dynamics_valid(tree, loads, work));
    assert(force && force != acc && scratch != acc && scratch != force);
    const double far = 0x1p36;
    int n = tree->n;
    double *moved = scratch, *moved_acc = scratch + n, *moved_force = scratch + 2 * (ptrdiff_t)n;
    for (int k = 0; k < n; k++) moved[k] = phi[k] + far * phi_low[k];
    pend_dynamics(tree, loads, phi, rate, work, acc, force);
    pend_dynamics(tree, loads, moved, rate, work, moved_acc, moved_force);
    for (int k = 0; k < n; k++) {
        acc[k] += (moved_acc[k] - acc[k]) / far;
        force[k] += (moved_force[k] - force[k]) / far;
    }
}

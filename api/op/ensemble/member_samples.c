#include "api/op/ensemble/member_samples.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/dynamics/dynamics.h"
#include "core/dynamics/kinematics_at.h"
#include "core/tree/turns.h"

/* the outputs, in the order of their columns; those from PHIDD on are computed from the others */
enum output { PHI, PHID, THETA, THETAD, LAMBDA, CART, PHIDD, Z, ZD, ENERGY, OUTPUTS };

static const char *const names[OUTPUTS + 1] = {"phi",   "phid", "theta", "thetad", "lambda", "cart",
                                               "phidd", "z",    "zd",    "energy", NULL};

/* per output: names of its parts; their number; whether each has one number per arm */
static const struct {
    const char *part[3];
    int parts, arms;
} columns[OUTPUTS] = {
    [PHI] = {{NULL}, 1, 1},      [PHID] = {{NULL}, 1, 1},
    [THETA] = {{NULL}, 1, 1},    [THETAD] = {{NULL}, 1, 1},
    [LAMBDA] = {{NULL}, 1, 1},   [CART] = {{"x", "v"}, 2, 0},
    [PHIDD] = {{NULL}, 1, 1},    [Z] = {{"re", "im"}, 2, 1},
    [ZD] = {{"re", "im"}, 2, 1}, [ENERGY] = {{"kinetic", "potential", "total"}, 3, 0},
};

/* s per arm, measured: of accelerations of an ideal and of a real pendulum, and of positions,
 * velocities and energies */
static const double ideal_seconds = 40e-9, real_seconds = 400e-9, place_seconds = 30e-9;

struct api_member_samples {
    const struct api_tree *tree;
    unsigned outputs;
    struct pend_tree own; /* the member's own tree */
    struct pend_loads loads;
    double *subtree, *acc, *force, *re, *im, *low, *scratch; /* scratch: 4 n values */
    void *work;
};

enum { ROWS = 6 + 4 }; /* number of arrays of n values */

unsigned api_member_outputs_read(const struct api_value *list, struct api_problem *problem) {
    unsigned found = api_field_words(list, names, problem);
    return found ? found : 1u << PHI | 1u << PHID | 1u << LAMBDA;
}

int api_member_outputs_cart(unsigned outputs) { return (int)(outputs >> CART & 1); }

int api_member_outputs_derived(unsigned outputs) { return outputs >> PHIDD != 0; }

void api_member_outputs_columns(unsigned outputs, int n, struct api_table *table) {
    assert(outputs && n >= 1);
    api_table_add(table, "member", NULL, 0);
    api_table_add(table, "status", NULL, 0);
    api_table_add(table, "t", NULL, 0);
    for (int i = 0; i < OUTPUTS; i++)
        for (int part = 0; outputs >> i & 1 && part < columns[i].parts; part++)
            api_table_add(table, names[i], columns[i].part[part], columns[i].arms ? n : 0);
}

void api_member_outputs_differ(unsigned outputs, struct api_derived *derived,
                               struct api_table *table) {
    static const int what[OUTPUTS][3] = {
        [PHI] = {PEND_DERIVED_PHI},
        [PHID] = {PEND_DERIVED_RATE},
        [THETA] = {PEND_DERIVED_PHI},
        [THETAD] = {PEND_DERIVED_RATE},
        [LAMBDA] = {PEND_DERIVED_FORCE},
        [CART] = {PEND_DERIVED_CART_PLACE, PEND_DERIVED_CART_SPEED},
        [PHIDD] = {PEND_DERIVED_ACC},
        [Z] = {PEND_DERIVED_Z_RE, PEND_DERIVED_Z_IM},
        [ZD] = {PEND_DERIVED_ZD_RE, PEND_DERIVED_ZD_IM},
        [ENERGY] = {PEND_DERIVED_KINETIC, PEND_DERIVED_POTENTIAL, API_DERIVED_TOTAL}};
    for (int i = 0; i < OUTPUTS; i++)
        for (int part = 0; outputs >> i & 1 && part < columns[i].parts; part++)
            api_derived_add(derived, table, names[i], columns[i].part[part], what[i][part]);
}

double api_member_outputs_cost(unsigned outputs, const struct api_tree *tree) {
    double arm = 0;
    if (outputs >> PHIDD & 1) arm += tree->loads.terms ? real_seconds : ideal_seconds;
    for (int i = Z; i <= ENERGY; i++) arm += (outputs >> i & 1) * place_seconds;
    return arm * (tree->n + 1);
}

static size_t samples_work(const struct api_tree *tree) {
    return (pend_dynamics_at_bytes(tree->tree, &tree->loads) + 63) / 64 * 64;
}

enum pend_status api_member_samples_new(struct api_member_samples **samples,
                                        const struct api_tree *tree, unsigned outputs) {
    size_t n = (size_t)tree->tree->n, work = samples_work(tree),
           all = work + (ROWS * n * sizeof(double) + 63) / 64 * 64;
    struct api_member_samples *made = *samples = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    *made = (struct api_member_samples){
        .tree = tree, .outputs = outputs, .own = *tree->tree, .loads = tree->loads};
    made->work = aligned_alloc(64, all);
    if (!made->work) {
        api_member_samples_free(samples);
        return PEND_NO_MEMORY;
    }
    double *at = (double *)(void *)((char *)made->work + work);
    double **row[] = {&made->subtree, &made->acc, &made->force,  &made->re,
                      &made->im,      &made->low, &made->scratch};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++, at += n) *row[i] = at;
    return PEND_OK;
}

void api_member_samples_free(struct api_member_samples **samples) {
    if (*samples) free((*samples)->work);
    free(*samples);
    *samples = NULL;
}

double api_member_samples_bytes(const struct api_tree *tree) {
    return (double)sizeof(struct api_member_samples) + (double)samples_work(tree) + 128 +
           (double)ROWS * tree->tree->n * sizeof(double);
}

void api_member_samples_pendulum(struct api_member_samples *samples,
                                 const struct pend_member *member) {
    assert(member->length && member->mass);
    samples->own = pend_member_tree(samples->tree->tree, member, samples->subtree);
    samples->loads = member->loads;
}

struct row {
    const struct api_tree *tree;
    double *at;
    int bad; /* whether a number was not finite */
};

static void row_put(struct row *row, double x) {
    row->bad |= !isfinite(x);
    *row->at++ = isfinite(x) ? x : NAN;
}

/* appends n values, from stored to the caller's order, without a cart */
static void row_arms(struct row *row, const double x[]) {
    const struct api_tree *tree = row->tree;
    assert(tree->n + tree->cart == tree->tree->n);
    for (int k = tree->cart; k < tree->tree->n; k++) {
        row->bad |= !isfinite(x[k]);
        row->at[tree->tree->order[k]] = isfinite(x[k]) ? x[k] : NAN;
    }
    row->at += tree->n;
}

/* computes the angular accelerations; for a small swing from theta, which has more digits than
 * phi */
static const double *accelerate(struct api_member_samples *samples, double t, const double phi[],
                                const double rate[], const double theta[]) {
    const struct pend_tree *tree = &samples->own;
    double largest = 0, low = 0;
    for (int k = 0; k < tree->n; k++) {
        struct pend_sum hanging = pend_turns_hanging(theta[k]);
        samples->low[k] = (hanging.high - phi[k]) + hanging.low;
        largest = fmax(largest, fabs(theta[k]));
        low = fmax(low, fabs(samples->low[k]));
    }
    if (!samples->loads.terms && low > 0 && largest <= PEND_TURNS_SMALL)
        pend_dynamics_fine(tree, &samples->loads, phi, samples->low, rate, samples->work,
                           samples->scratch, samples->acc, samples->force);
    else
        pend_dynamics_at(tree, &samples->loads, t, phi, rate, samples->work, samples->acc,
                         samples->force);
    return samples->acc;
}

struct state {
    double t;
    const double *phi, *rate, *force, *theta;
    struct pend_energy energy;
};

static void row_derived(struct row *row, struct api_member_samples *samples,
                        const struct state *state) {
    const struct pend_tree *tree = &samples->own;
    const struct pend_loads *loads = &samples->loads;
    double t = state->t;
    const double *phi = state->phi, *rate = state->rate;
    if (samples->outputs >> PHIDD & 1)
        row_arms(row, accelerate(samples, t, phi, rate, state->theta));
    if (samples->outputs >> Z & 1) {
        pend_kinematics_position_at(tree, loads, t, phi, samples->re, samples->im);
        row_arms(row, samples->re);
        row_arms(row, samples->im);
    }
    if (samples->outputs >> ZD & 1) {
        pend_kinematics_velocity_at(tree, loads, t, phi, rate, samples->re, samples->im);
        row_arms(row, samples->re);
        row_arms(row, samples->im);
    }
    if (samples->outputs >> ENERGY & 1) {
        row_put(row, state->energy.kinetic);
        row_put(row, state->energy.potential);
        row_put(row, state->energy.kinetic + state->energy.potential);
    }
}

static void row_write(struct api_member_samples *samples, double member, const struct state *state,
                      double numbers[]) {
    unsigned outputs = samples->outputs;
    struct row row = {samples->tree, numbers, 0};
    const double *from[CART] = {state->phi, state->rate, state->theta, state->rate, state->force};
    row_put(&row, member);
    row_put(&row, 0);
    row_put(&row, state->t);
    for (int i = 0; i < CART; i++)
        if (outputs >> i & 1) row_arms(&row, from[i]);
    if (outputs >> CART & 1) {
        row_put(&row, state->phi[0]);
        row_put(&row, state->rate[0]);
    }
    if (api_member_outputs_derived(outputs)) row_derived(&row, samples, state);
    if (row.bad) numbers[1] = 1;
}

/* computes the energies at all instants, if requested; together for an ideal pendulum, because that
 * is faster */
static void states_energy(struct api_member_samples *samples,
                          const struct api_member_states *states,
                          struct pend_energy energy[API_MEMBER_ROWS]) {
    const struct pend_tree *tree = &samples->own;
    const struct pend_loads *loads = &samples->loads;
    if (!(samples->outputs >> ENERGY & 1)) return;
    if (!loads->terms)
        pend_kinematics_energies(tree, loads, states->count, states->phi, states->rate, energy);
    for (int j = 0; loads->terms && j < states->count; j++)
        energy[j] = pend_kinematics_energy_at(tree, loads, states->t[j], states->phi + j * tree->n,
                                              states->rate + j * tree->n, samples->scratch);
}

void api_member_samples_rows(struct api_member_samples *samples, double member,
                             const struct api_member_states *states, double row[], long stride) {
    struct pend_energy energy[API_MEMBER_ROWS] = {{0, 0}};
    int n = samples->own.n;
    assert(states->count >= 0 && states->count <= API_MEMBER_ROWS && stride >= 3);
    states_energy(samples, states, energy);
    for (int j = 0; j < states->count; j++) {
        const struct state state = {.t = states->t[j],
                                    .phi = states->phi + j * n,
                                    .rate = states->rate + j * n,
                                    .force = states->force + j * n,
                                    .theta = states->theta + j * n,
                                    .energy = energy[j]};
        row_write(samples, member, &state, row + j * stride);
    }
}

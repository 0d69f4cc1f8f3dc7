#include "core/derivatives/ideal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/tree/turns.h"

enum { LANES = IDEAL_LANES, IDEAL_STATES = 12, IDEAL_ROWS = 18 };

const struct ideal_kernel *pend_kernel_ideal(void) {
    return PEND_ISA_PICK(pend_kernel_ideal, pend_isa_best());
}

static double *ideal_take(char *base, size_t *used, size_t numbers) {
    double *part = base ? (double *)(void *)(base + *used) : NULL;
    *used += (numbers * sizeof(double) + 63) / 64 * 64;
    return part;
}

static void ideal_lay_known(struct ideal *ideal, int n, int order, int real, char *base,
                            size_t *used) {
    struct ideal_known *known = &ideal->known;
    size_t tiles = ((size_t)n + LANES - 1) / LANES;
    known->tile = (size_t)LANES * (size_t)(order + IDEAL_BEYOND);
    double **series[] = {&known->rate,    &known->force,          &known->turn_re,
                         &known->turn_im, &known->acc_re,         &known->acc_im,
                         &known->across,  &known->pivot_force_re, &known->pivot_force_im};
    for (size_t i = 0; i < (real ? 9 : 6); i++)
        *series[i] = ideal_take(base, used, tiles * known->tile + 2 * LANES);
    double **own[] = {&known->inertia, &known->hold,        &known->stiff,
                      &known->bend,    &known->yield,       &known->slip_along,
                      &known->bear,    &known->slip_across, &known->twist};
    for (size_t i = 0; real && i < sizeof own / sizeof *own; i++)
        *own[i] = ideal_take(base, used, (size_t)n);
    if (base) known->force += LANES; // space for row -1 of the forces
    known->table = ideal_take(base, used, 2 * IDEAL_DENSE * IDEAL_PITCH);
#define X(name) known->system.name = ideal_take(base, used, (size_t)n);
    JETS_FACTOR_ARRAYS(X)
#undef X
}

static void ideal_lay_group(struct ideal_group *g, int n, int order, char *base, size_t *used) {
    size_t arms = (size_t)n * LANES;
    struct ideal_group made = {.rows = (size_t)(order + IDEAL_BEYOND + 2) | 1};
    double **array[IDEAL_ROWS] = {
        &made.phi,      &made.phi_low, &made.rate,    &made.rate_low, &made.end_phi, &made.end_low,
        &made.end_rate, &made.slow,    &made.length,  &made.mass,     &made.out[0],  &made.out[1],
        &made.out[2],   &made.out[3],  &made.inertia, &made.hold,     &made.stiff,   &made.torque};
    for (int i = 0; i < IDEAL_ROWS; i++) *array[i] = ideal_take(base, used, arms);
    made.gravity = ideal_take(base, used, LANES);
    double **series[] = {&made.angle, &made.along, &made.across};
    for (int i = 0; i < 3; i++) *series[i] = ideal_take(base, used, arms * made.rows);
    made.work = ideal_take(base, used, arms * IDEAL_WORK);
    if (base) *g = made;
}

static size_t ideal_lay(struct ideal *ideal, const struct pend_tree *tree,
                        const struct pend_terms *terms, int order, int count, char *base) {
    size_t used = (sizeof *ideal + 63) / 64 * 64, stride = pend_jets_stride(tree->n);
    terms = pend_ideal_terms(terms);
    ideal->groups = (count + LANES - 1) / LANES;
    void *jets = ideal_take(base, &used, pend_jets_bytes(tree, terms, order) / sizeof(double));
    if (base) pend_jets_init(&ideal->jets, tree, &ideal->loads, order, jets);
    double **state[IDEAL_STATES] = {
        &ideal->begin.phi,  &ideal->begin.phi_low, &ideal->begin.rate, &ideal->begin.rate_low,
        &ideal->end.phi,    &ideal->end.phi_low,   &ideal->end.rate,   &ideal->end.rate_low,
        &ideal->values.phi, &ideal->values.rate,   &ideal->values.acc, &ideal->values.force};
    for (int i = 0; i < IDEAL_STATES; i++) *state[i] = ideal_take(base, &used, stride);
    ideal_lay_known(ideal, tree->n, order, terms != NULL, base, &used);
    ideal->group = (struct ideal_group *)(void *)ideal_take(
        base, &used, ((size_t)ideal->groups * sizeof *ideal->group + 7) / 8);
    for (int i = 0; i < ideal->groups; i++)
        ideal_lay_group(base ? &ideal->group[i] : NULL, tree->n, order, base, &used);
    return used;
}

size_t pend_ideal_bytes(const struct pend_tree *tree, const struct pend_terms *terms, int order,
                        int count) {
    struct ideal sketch = {.groups = 0};
    return ideal_lay(&sketch, tree, terms, order, count, NULL);
}

/* sets the derivative of a parameter with respect to itself to its unit */
static void ideal_seed(struct ideal *ideal, int i, struct pend_parameter by, double seed) {
    struct ideal_group *g = &ideal->group[i / LANES];
    size_t at = (size_t)by.at * LANES + (size_t)(i % LANES);
    assert(i / LANES < ideal->groups && by.at >= 0);
    assert(by.at < ideal->known.n || by.kind == PEND_PARAMETER_TERM);
    switch (by.kind) {
    case PEND_PARAMETER_PHI:
        g->end_phi[at] = seed;
        break;
    case PEND_PARAMETER_RATE:
        g->end_rate[at] = seed;
        break;
    case PEND_PARAMETER_LENGTH:
        g->length[at] = seed / ideal->jets.tree->len[by.at];
        g->lengths = ideal->known.lengths = 1;
        break;
    case PEND_PARAMETER_MASS:
        g->mass[at] = seed;
        g->masses = ideal->known.masses = 1;
        break;
    case PEND_PARAMETER_GRAVITY:
        g->gravity[i % LANES] = seed;
        break;
    case PEND_PARAMETER_TERM:
        break; // lengths and terms are set by pend_ideal_vary
    }
    if (ideal->known.loaded && (by.kind == PEND_PARAMETER_TERM || by.kind == PEND_PARAMETER_LENGTH))
        pend_ideal_vary(&ideal->known, g, i % LANES, ideal->jets.tree, &ideal->loads, by, seed);
}

/* stores the start as the end of a preceding step, with whole turns, which springs distinguish */
static void ideal_start(struct ideal *ideal, const struct pend_problem *problem) {
    int whole = pend_terms_whole_turns(ideal->loads.terms);
    for (int k = 0; k < ideal->known.n; k++) {
        struct pend_sum phi = {problem->phi[k], problem->phi_low ? problem->phi_low[k] : 0};
        if (whole) phi = pend_turns_rest(phi.high, phi.low, NULL);
        ideal->end.phi[k] = phi.high, ideal->end.phi_low[k] = phi.low;
        ideal->end.rate[k] = problem->rate[k];
        ideal->end.rate_low[k] = problem->rate_low ? problem->rate_low[k] : 0;
    }
}

void pend_ideal_init(struct ideal *ideal, const struct pend_problem *problem, int order, int count,
                     const struct pend_parameter parameter[], const double seed[]) {
    const struct pend_tree *tree = problem->tree;
    struct pend_loads loads = problem->loads;
    loads.terms = pend_ideal_terms(loads.terms);
    assert(order >= 1 && count >= 1);
    memset(ideal, 0, pend_ideal_bytes(tree, loads.terms, order, count));
    *ideal = (struct ideal){
        .loads = loads, .first = pend_times_at(&problem->times, 0), .kernel = pend_kernel_ideal()};
    ideal_lay(ideal, tree, loads.terms, order, count, (char *)ideal);
    struct jets_system *s = &ideal->known.system;
    ideal->known.n = s->n = tree->n;
    ideal->known.order = order;
    if (tree->n > 1 && tree->n <= PEND_JETS_PAD && !ideal->jets.general) {
        // the series of a small tree already have the layout of the kernel
        assert(ideal->jets.system.tile == ideal->known.tile);
        ideal->known.rate = ideal->jets.rate;
        if (!loads.terms) ideal->known.force = ideal->jets.force;
        ideal->known.kept_re = ideal->jets.system.turn_re;
        ideal->known.kept_im = ideal->jets.system.turn_im;
    }
    s->parent = tree->parent, s->end = tree->end, s->share = ideal->jets.share;
    for (int k = 0; k < tree->n; k++)
        s->len[k] = tree->len[k], s->inv_len[k] = 1 / tree->len[k], s->mass[k] = tree->mass[k];
    if (loads.terms) pend_ideal_load(&ideal->known, tree, &loads);
    if (ideal->jets.general) {
        ideal->known.lift_x = ideal->jets.bodies.lift_x;
        ideal->known.lift_y = ideal->jets.bodies.lift_y;
    } else if (loads.terms && ideal->jets.loads.moves) {
        ideal->known.lift_x = ideal->jets.loads.lift_x;
        ideal->known.lift_y = ideal->jets.loads.lift_y;
    }
    ideal_start(ideal, problem);
    for (int i = 0; i < ideal->groups; i++)
        ideal->group[i].lanes = count - i * LANES < LANES ? count - i * LANES : LANES;
    for (int i = 0; i < count; i++) ideal_seed(ideal, i, parameter[i], seed[i]);
}

void pend_ideal_turn(struct ideal *ideal) {
    struct jets_state swap = ideal->begin;
    ideal->begin = ideal->end, ideal->end = swap;
    for (int i = 0; i < ideal->groups; i++) {
        struct ideal_group *g = &ideal->group[i], old = *g;
        g->phi = old.end_phi, g->phi_low = old.end_low;
        g->rate = old.end_rate, g->rate_low = old.slow;
        g->end_phi = old.phi, g->end_low = old.phi_low;
        g->end_rate = old.rate, g->slow = old.rate_low;
    }
}

/* the deflection of an arm's spring; for the first arm, it is measured from the vertical */
static double ideal_bend(const struct ideal *ideal, int k) {
    double angle = ideal->known.system.angle[k] + ideal->known.system.angle_low[k];
    if (ideal->known.system.parent[k] < 0) angle += M_PI_2;
    return angle - pend_terms_get(ideal->loads.terms, ideal->loads.value, PEND_TERM_REST, k);
}

/* passes the motion's series and its start to the kernel */
static void ideal_learn(struct ideal *ideal) {
    const struct jets_state *at = &ideal->begin;
    struct ideal_known *known = &ideal->known;
    for (int k = 0; k < known->n; k++) {
        int up = known->system.parent[k];
        double x = at->phi[k], y = up < 0 ? 0 : at->phi[up], gap = x - y, back = x - gap;
        double rest = (x - (gap + back)) + (back - y);
        known->system.angle[k] = gap;
        known->system.angle_low[k] = rest + (at->phi_low[k] - (up < 0 ? 0 : at->phi_low[up]));
        if (known->loaded) known->bend[k] = ideal_bend(ideal, k);
    }
    for (int k = 0; k < known->n && !known->kept_re; k++)
        for (int j = 0; j <= known->order; j++) {
            size_t from = pend_jets_place(&ideal->jets, k, j), to = ideal_place(known, k, j);
            known->rate[to] = ideal->jets.rate[from];
            if (j < known->order && !known->loaded) known->force[to] = ideal->jets.force[from];
        }
    known->unit = ideal->unit, known->square = ideal->unit * ideal->unit;
    known->gravity = ideal->loads.gravity * known->square;
    ideal->kernel->know(known);
}

double pend_ideal_expand(struct ideal *ideal, double since, double unit, double log_rtol,
                         double log_atol) {
    int order = ideal->known.order;
    assert(isfinite(unit) && unit != 0);
    ideal->unit = unit;
    jets_state_time(&ideal->begin, ideal->first, since);
    pend_jets_expand(&ideal->jets, &ideal->loads, unit, &ideal->begin, order);
    double reach = pend_jets_reach(&ideal->jets, order, log_rtol, log_atol);
    ideal_learn(ideal);
    for (int i = 0; i < ideal->groups; i++) {
        double x = ideal->kernel->expand(&ideal->known, &ideal->group[i], unit, log_rtol, log_atol);
        if (isnan(x)) return NAN;
        reach = fmin(reach, x);
    }
    return reach;
}

void pend_ideal_advance(struct ideal *ideal, double x) {
    assert(isfinite(x) && ideal->unit != 0);
    pend_jets_advance(&ideal->jets, ideal->known.order, x, ideal->unit, &ideal->begin, &ideal->end);
    for (int i = 0; i < ideal->groups; i++)
        ideal->kernel->advance(&ideal->known, &ideal->group[i], ideal->unit, x);
}

void pend_ideal_values(struct ideal *ideal, double x, int all) {
    struct jets_values values = ideal->values;
    assert(isfinite(x) && ideal->unit != 0);
    if (!all) values.acc = NULL;
    if (!all || ideal->loads.terms) values.force = NULL;
    pend_jets_values(&ideal->jets, ideal->known.order, &x, 1, ideal->unit, &ideal->begin, &values);
    for (int i = 0; i < ideal->groups; i++)
        ideal->kernel->values(&ideal->known, &ideal->group[i], ideal->unit, x, all);
}

void pend_ideal_view(const struct ideal *ideal, int first, const struct derivatives_view *view) {
    double *to[] = {view->phi, view->rate, view->acc, view->force};
    const double *value[] = {ideal->values.phi, ideal->values.rate, ideal->values.acc,
                             ideal->values.force};
    assert(first >= 0 && first % DERIVATIVES_PASS == 0);
    for (int i = 0; i < 4; i++)
        for (int k = 0; to[i] && k < ideal->known.n; k++) {
            to[i][(size_t)k * DERIVATIVES_LANES] = value[i][k];
            for (int j = 0; j < DERIVATIVES_PASS; j++) {
                int at = first + j, group = at / LANES;
                size_t from = (size_t)k * LANES + (size_t)(at % LANES);
                to[i][(size_t)k * DERIVATIVES_LANES + DERIVATIVES_FIRST + (size_t)j] =
                    group < ideal->groups ? ideal->group[group].out[i][from] : 0;
            }
        }
}

void pend_ideal_carry(struct ideal *ideal, struct pend_checkpoint *checkpoint) {
    size_t n = (size_t)ideal->known.n;
    double *state[] = {ideal->begin.phi,      ideal->begin.phi_low, ideal->begin.rate,
                       ideal->begin.rate_low, ideal->end.phi,       ideal->end.phi_low,
                       ideal->end.rate,       ideal->end.rate_low};
    for (int i = 0; i < 8; i++) pend_checkpoint_row(checkpoint, state[i], n);
    for (int i = 0; i < ideal->groups; i++) {
        struct ideal_group *g = &ideal->group[i];
        double *row[] = {g->phi,     g->phi_low, g->rate,     g->rate_low,
                         g->end_phi, g->end_low, g->end_rate, g->slow};
        for (int j = 0; j < 8; j++) pend_checkpoint_row(checkpoint, row[j], n * LANES);
    }
}

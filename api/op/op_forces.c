/* POST /v1/forces: accelerations, forces, positions and energies of given states, without
 * integration.
 * Leaves to others: reading (tree_json, state_json), the mechanics (core/dynamics/dynamics,
 * kinematics), the bytes (encode).
 * Invariant: one row per state, in the order of the request. */
#include "api/op/op.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "api/op/derived.h"
#include "api/read/state_json.h"
#include "core/bodies/bodies.h"
#include "core/dynamics/dynamics.h"
#include "core/dynamics/kinematics_at.h"
#include "core/tree/turns.h"

static const char *const fields[] = {"pendulum", "initial", "state",       "states",
                                     "time",     "digits",  "derivatives", NULL};

enum {
    PHIDD,
    LAMBDA,
    Z_RE,
    Z_IM,
    ZD_RE,
    ZD_IM,
    ZDD_RE,
    ZDD_IM,
    KINETIC,
    POTENTIAL,
    TOTAL,
    JOINT_ALONG,
    JOINT_ACROSS,
    TIP_ALONG,
    TIP_ACROSS,
    CART_ACC,
    CART_REACTION,
    COLUMNS
};

/* constants of the estimated cost: s per number of the answer, and additional s if it is text */
static const double number_seconds = 5e-8, text_seconds = 3e-8;

enum { BLOCK_ROWS = 64, BLOCK_NUMBERS = 16384 };

/* states whose accelerations are computed together */
enum { AT_ONCE = PEND_DYNAMICS_VEC };

/* the columns of the answer, in the order above; the energies and a cart have one number per row */
static const struct {
    const char *name, *part;
} columns[COLUMNS] = {
    [PHIDD] = {"phidd", NULL},
    [LAMBDA] = {"lambda", NULL},
    [Z_RE] = {"z", "re"},
    [Z_IM] = {"z", "im"},
    [ZD_RE] = {"zd", "re"},
    [ZD_IM] = {"zd", "im"},
    [ZDD_RE] = {"zdd", "re"},
    [ZDD_IM] = {"zdd", "im"},
    [KINETIC] = {"energy", "kinetic"},
    [POTENTIAL] = {"energy", "potential"},
    [TOTAL] = {"energy", "total"},
    [JOINT_ALONG] = {"joint_force", "along"},
    [JOINT_ACROSS] = {"joint_force", "across"},
    [TIP_ALONG] = {"tip_force", "along"},
    [TIP_ACROSS] = {"tip_force", "across"},
    [CART_ACC] = {"cart", "acceleration"},
    [CART_REACTION] = {"cart", "reaction"},
};

static int column_of_arms(int column) {
    return column < KINETIC || (column > TOTAL && column < CART_ACC);
}

/* the quantity to which a column's derivatives belong */
static const int derived_of[COLUMNS] = {
    [PHIDD] = PEND_DERIVED_ACC,
    [LAMBDA] = PEND_DERIVED_FORCE,
    [Z_RE] = PEND_DERIVED_Z_RE,
    [Z_IM] = PEND_DERIVED_Z_IM,
    [ZD_RE] = PEND_DERIVED_ZD_RE,
    [ZD_IM] = PEND_DERIVED_ZD_IM,
    [ZDD_RE] = PEND_DERIVED_ZDD_RE,
    [ZDD_IM] = PEND_DERIVED_ZDD_IM,
    [KINETIC] = PEND_DERIVED_KINETIC,
    [POTENTIAL] = PEND_DERIVED_POTENTIAL,
    [TOTAL] = API_DERIVED_TOTAL,
    [JOINT_ALONG] = PEND_DERIVED_JOINT_ALONG,
    [JOINT_ACROSS] = PEND_DERIVED_JOINT_ACROSS,
    [TIP_ALONG] = PEND_DERIVED_FORCE,
    [TIP_ACROSS] = PEND_DERIVED_TIP_ACROSS,
    [CART_ACC] = PEND_DERIVED_CART_ACC,
    [CART_REACTION] = PEND_DERIVED_CART_REACTION,
};

struct forces {
    struct api_tree tree;
    double time; /* s, the time at which drives are evaluated */
    int count;   /* number of columns, of which the last ones exist only for real pendulums */
    struct api_states *states;
    struct api_derived derived;
    struct api_table table;
    const struct api_format *format;

    /* set while it runs; the arrays are in one block, which begins with `work` */
    struct api_writer *writer;
    struct api_stats stats;
    long next, cap; /* index of the first state that is not written; rows per block */
    void *work;
    double *row[4];  /* accelerations and forces of AT_ONCE states; the two parts of a vector;
                      * stored order */
    double *scratch; /* scratch of 4 n numbers */
    double *column[COLUMNS];
};

static void forces_clear(void *state) {
    struct forces *forces = state;
    free(forces->work);
    api_writer_free(&forces->writer);
    api_derived_clear(&forces->derived);
    api_states_free(&forces->states);
    api_tree_clear(&forces->tree);
}

/* ---- reading */

static void forces_check_size(struct forces *forces, const struct api_reading *reading) {
    struct api_table *table = &forces->table;
    forces->count = forces->tree.cart ? COLUMNS : forces->tree.loads.terms ? CART_ACC : JOINT_ALONG;
    for (int c = 0; c < forces->count; c++)
        api_table_add(table, columns[c].name, columns[c].part,
                      column_of_arms(c) ? forces->tree.n : 0);
    for (int c = 0; c < forces->count && forces->derived.count; c++)
        api_derived_add(&forces->derived, table, columns[c].name, columns[c].part, derived_of[c]);
    api_reading_check_size(reading, table, reading->root, "states", "fewer at a time");
}

/* the number of states; 0 after an error */
static long forces_count(struct forces *forces, const struct api_value *one,
                         const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value many = api_value_member(reading->root, "states");
    forces->table.single = api_value_kind(&many) == API_MISSING;
    if (forces->table.single) return 1;
    long count = api_value_count(&many);
    if (api_value_kind(one) != API_MISSING)
        api_value_fault(one, problem,
                        API_CODE_CONFLICT
                        "cannot be combined with \"states\": give one of the two");
    if (api_value_kind(&many) != API_ARRAY || !count) {
        api_value_fault(&many, problem,
                        API_CODE_WRONG_COUNT "must be an array of at least one state");
        return 0;
    }
    if ((double)count <= reading->limits->samples) return count;
    api_value_fault(&many, problem,
                    API_CODE_LIMIT
                    "has %ld states, more than the limit %s of %.0f: ask for fewer at a time",
                    count, api_limits_name(reading->limits, &reading->limits->samples),
                    reading->limits->samples);
    return 0;
}

/* reads the states; allocates memory for them only if the rest of the request has no error and the
 * answer is not too large */
static enum pend_status forces_read_states(struct forces *forces,
                                           const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value many = api_value_member(reading->root, "states"),
                     one = api_field_renamed(reading->root, "initial", "state", problem);
    forces->table.rows = forces_count(forces, &one, reading);
    if (!forces->table.rows) return PEND_INVALID;
    if (forces->tree.tree) forces_check_size(forces, reading);
    if (!problem->status)
        PEND_TRY(
            api_states_new(&forces->states, forces->table.rows, api_tree_stored(&forces->tree)));
    if (forces->table.single)
        api_states_read(forces->states, 0, &one, &forces->tree, reading->limits, problem);
    API_VALUE_EACH (state, api_value_item(&many, 0))
        api_states_read(forces->states, state.index, &state, &forces->tree, reading->limits,
                        problem);
    return problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status forces_read(void *state, const struct api_reading *reading) {
    struct forces *forces = state;
    struct api_value time = api_value_member(reading->root, "time");
    long rounded = 0;
    forces->format = reading->format;
    (void)api_value_only(reading->root, fields, reading->problem);
    (void)api_value_read_number(&time, -1e9, 1e9, "s", &forces->time, reading->problem);
    api_value_usual_number(&time, 0);
    (void)api_field_whole(API_MEMBER(reading->root, "digits"), 1, 17, &rounded, reading->problem);
    forces->table.digits = (int)rounded;
    enum pend_status status = api_reading_tree(reading, &forces->tree);
    if (status == PEND_NO_MEMORY) return status;
    status = api_derived_read(&forces->derived, API_MEMBER(reading->root, "derivatives"),
                              &forces->tree, reading->problem);
    if (status == PEND_NO_MEMORY) return status;
    return forces_read_states(forces, reading);
}

/* ---- running */

static size_t forces_work(const struct forces *forces) {
    const struct pend_loads *loads = &forces->tree.loads;
    if (loads->terms) return pend_dynamics_at_bytes(forces->tree.tree, loads);
    return pend_dynamics_many_bytes(forces->tree.n);
}

/* allocates one block: the scratch of the dynamics, its results for some states, two rows, the
 * columns of `cap` rows */
static enum pend_status forces_allocate(struct forces *forces, struct pend_error *error) {
    size_t n = (size_t)api_tree_stored(&forces->tree), work = (forces_work(forces) + 63) / 64 * 64;
    long cap = BLOCK_NUMBERS / (long)api_table_numbers(&forces->table, 0);
    if (cap > BLOCK_ROWS) cap = BLOCK_ROWS;
    if (cap > forces->table.rows) cap = forces->table.rows;
    if (forces->derived.count && cap > api_derived_cap(&forces->derived, forces->table.rows))
        cap = api_derived_cap(&forces->derived, forces->table.rows);
    forces->cap = cap < 1 ? 1 : cap;
    size_t numbers = (2 * AT_ONCE + 2 + 4) * n + (size_t)forces->cap * (COLUMNS * n);
    forces->work = aligned_alloc(64, work + (numbers * sizeof(double) + 63) / 64 * 64);
    if (!forces->work)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for states of %zu arms", n);
    double *at = (double *)((char *)forces->work + work);
    for (int i = 0; i < 2; i++, at += AT_ONCE * n) forces->row[i] = at;
    for (int i = 2; i < 4; i++, at += n) forces->row[i] = at;
    forces->scratch = at;
    at += 4 * n;
    for (int c = 0; c < COLUMNS; c++) {
        forces->column[c] = at;
        at += (size_t)forces->cap * (column_of_arms(c) ? n : 1);
    }
    return PEND_OK;
}

/* copies a row in stored order to row i of a column */
static void forces_put(const struct forces *forces, const double row[], long i, int column) {
    assert(i >= 0 && column >= 0 && forces->column[column]);
    api_tree_put(&forces->tree, row, forces->column[column] + i * forces->tree.n);
}

/* true for a small swing about hanging, whose angles need the low part of phi */
static int forces_swing(int n, const double phi[], const double phi_low[]) {
    double largest = 0, low = 0;
    for (int k = 0; k < n; k++) {
        low = fmax(low, fabs(phi_low[k]));
        largest = fmax(largest, fabs(pend_turns_theta(phi[k], phi_low[k])));
    }
    return low > 0 && largest <= PEND_TURNS_SMALL;
}

/* computes the accelerations and all forces of a real pendulum into row i of the columns */
static void forces_real(const struct forces *forces, const double phi[], const double rate[],
                        long i, double acc[], double force[]) {
    size_t n = (size_t)forces->tree.tree->n;
    double *along = forces->scratch, *across = along + n, *tip = across + n;
    struct bodies_state state = {phi, NULL, rate, forces->time, 0};
    struct bodies_forces all = {along, across, force, tip};
    pend_bodies_at(forces->tree.tree, &forces->tree.loads, &state, forces->work, acc, &all);
    forces_put(forces, along, i, JOINT_ALONG);
    forces_put(forces, across, i, JOINT_ACROSS);
    forces_put(forces, force, i, TIP_ALONG);
    forces_put(forces, tip, i, TIP_ACROSS);
    if (!forces->tree.cart) return;
    forces->column[CART_ACC][i] = acc[0];
    forces->column[CART_REACTION][i] = across[0];
}

static void forces_compute(const struct forces *forces, long s, long i) {
    assert(s >= 0 && i >= 0);
    const struct pend_tree *tree = forces->tree.tree;
    const double *phi = forces->states->phi + s * tree->n,
                 *rate = forces->states->rate + s * tree->n;
    const double *low = forces->states->phi_low + s * tree->n;
    const struct pend_loads *loads = &forces->tree.loads;
    double *re = forces->row[2], *im = forces->row[3];
    // the first state of a group computes the accelerations and forces of all of them
    long behind = i % AT_ONCE, left = forces->table.rows - s;
    double *acc = forces->row[0] + behind * tree->n, *force = forces->row[1] + behind * tree->n;
    if (loads->terms)
        forces_real(forces, phi, rate, i, acc, force);
    else if (!behind)
        pend_dynamics_many(tree, loads, left < AT_ONCE ? left : AT_ONCE, phi, rate, forces->work,
                           acc, force);
    if (!loads->terms && forces_swing(tree->n, phi, low))
        pend_dynamics_fine(tree, loads, phi, low, rate, forces->work, forces->scratch, acc, force);
    forces_put(forces, acc, i, PHIDD);
    forces_put(forces, force, i, LAMBDA);
    pend_kinematics_position_at(tree, loads, forces->time, phi, re, im);
    forces_put(forces, re, i, Z_RE);
    forces_put(forces, im, i, Z_IM);
    pend_kinematics_velocity_at(tree, loads, forces->time, phi, rate, re, im);
    forces_put(forces, re, i, ZD_RE);
    forces_put(forces, im, i, ZD_IM);
    pend_kinematics_acceleration_at(tree, loads, forces->time, phi, rate, acc, re, im);
    forces_put(forces, re, i, ZDD_RE);
    forces_put(forces, im, i, ZDD_IM);
    struct pend_energy energy =
        pend_kinematics_energy_at(tree, loads, forces->time, phi, rate, forces->scratch);
    forces->column[KINETIC][i] = energy.kinetic;
    forces->column[POTENTIAL][i] = energy.potential;
    forces->column[TOTAL][i] = energy.kinetic + energy.potential;
}

static enum pend_status forces_begin(struct forces *forces, struct api_buffer *out,
                                     struct pend_error *error) {
    PEND_TRY(api_states_settle(forces->states, &forces->tree, error));
    // no angle is reported, and forces do not depend on whole turns, except with springs or a cart
    int whole = pend_terms_whole_turns(forces->tree.loads.terms);
    for (long i = 0; i < forces->table.rows * forces->tree.n && whole; i++) {
        double *phi = &forces->states->phi[i], *low = &forces->states->phi_low[i];
        struct pend_sum rest = pend_turns_rest(*phi, *low, NULL);
        *phi = rest.high, *low = rest.low;
    }
    PEND_TRY(forces_allocate(forces, error));
    // derivatives of states; the first state is an arbitrary start
    struct pend_problem problem = {.tree = forces->tree.tree,
                                   .loads = forces->tree.loads,
                                   .phi = forces->states->phi,
                                   .rate = forces->states->rate,
                                   .times = {.count = 1, .start = forces->time, .divisor = 1}};
    if (forces->derived.count)
        PEND_TRY(api_derived_begin(&forces->derived, &problem, forces->cap, error));
    return api_writer_new(&forces->writer, forces->format, &forces->table, out);
}

static enum pend_status forces_block(struct forces *forces, struct api_buffer *out,
                                     struct pend_error *error) {
    long rows = forces->table.rows - forces->next;
    if (rows > forces->cap) rows = forces->cap;
    const double *column[API_COLUMNS];
    for (long i = 0; i < rows; i++) {
        size_t at = (size_t)(forces->next + i) * (size_t)forces->tree.tree->n;
        forces_compute(forces, forces->next + i, i);
        if (forces->derived.count)
            api_derived_state(&forces->derived, forces->states->phi + at,
                              forces->states->phi_low + at, forces->states->rate + at, forces->time,
                              i);
    }
    memcpy(column, forces->column, (size_t)forces->count * sizeof *column);
    api_derived_columns(&forces->derived, column + forces->count);
    forces->next += rows;
    return api_writer_block(forces->writer, rows, column, out, error);
}

static enum pend_status forces_run(void *state, const struct api_turn *turn, int *done,
                                   struct pend_error *error) {
    struct forces *forces = state;
    if (!forces->writer) PEND_TRY(forces_begin(forces, turn->out, error));
    do {
        if (forces->next < forces->table.rows) {
            PEND_TRY(forces_block(forces, turn->out, error));
            continue;
        }
        if (!forces->stats.count) api_turn_tell(turn, 0, &forces->stats);
        PEND_TRY(api_writer_finish(forces->writer, &forces->stats, turn->out, done));
    } while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

static double forces_cost(const void *state) {
    const struct forces *forces = state;
    double numbers = (double)forces->table.rows * api_table_numbers(&forces->table, 0);
    numbers += (double)forces->table.rows * 100 * ceil(forces->derived.count / 8.0);
    return numbers * (number_seconds + (forces->format->digits ? text_seconds : 0));
}

static double forces_bytes(const void *state) {
    const struct forces *forces = state;
    double n = api_tree_stored(&forces->tree),
           block = 2.0 * BLOCK_NUMBERS + (2 * AT_ONCE + 2 + 4 + 2 * COLUMNS) * n;
    return block * sizeof(double) + (double)forces_work(forces) + api_tree_bytes(&forces->tree) +
           api_states_bytes(forces->states) +
           api_derived_bytes(
               &forces->derived, &forces->tree,
               forces->derived.count ? api_derived_cap(&forces->derived, forces->table.rows) : 0) +
           api_writer_bytes(forces->format, &forces->table);
}

const struct api_op api_op_forces = {.name = "forces",
                                     .size = sizeof(struct forces),
                                     .body = 1,
                                     .terms = 1,
                                     .cart = 1,
                                     .samples = 1,
                                     .read = forces_read,
                                     .run = forces_run,
                                     .table = offsetof(struct forces, table),
                                     .cost = forces_cost,
                                     .bytes = forces_bytes,
                                     .stats = offsetof(struct forces, stats),
                                     .clear = forces_clear};

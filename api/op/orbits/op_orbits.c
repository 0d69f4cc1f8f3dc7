/* POST /v1/orbits: periodic orbits and their branches.
 * Leaves to others: reading (orbits_json), the search (core/orbits), the bytes (encode).
 * Invariant: all orbits are found before the first is written, so that the head of the answer
 * contains their number; every reported orbit returned to its start. */
#include "api/op/op.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "api/json/json_out.h"
#include "api/op/derived.h"
#include "api/op/orbits/bifurcations.h"
#include "api/op/orbits/orbits_json.h"
#include "api/op/orbits/orbits_told.h"
#include "core/orbits/orbits.h"

enum {
    MAIN_COLUMNS = 9,
    FIRST_ROOM = 64,
    MOST_PARTS = 1000,
    CARRIED = 2 /* to be increased if orbits_carry, or `carry` of core, changes */
};

/* constants of the estimated cost. s per arm, step and eight derivatives: ideal, real, many arms; s
 * per arm and step of a plain motion. Maps per orbit: alone, and on a branch with its bifurcations;
 * additional maps for each further one */
static const double ideal_seconds = 3.5e-6, real_seconds = 1.2e-5, arms_cached = 25,
                    plain_seconds = 2e-6, maps_alone = 3.5, maps_on_branch = 4, maps_an_arm = 0.4,
                    steps_least = 8, steps_an_arm = 0.55;

/* approximate maximum of bytes that one part of a job passes to the next */
static const double carried_bytes = 1 << 30;

struct orbits {
    struct api_orbits asked;
    const struct api_format *format;
    struct api_table table;
    double step_cap;
    const char *step_name; /* name of the limit on steps */

    /* set while it runs */
    struct pend_orbits *search;
    double *start; /* for driven pendulums: start of 2 n numbers */
    long count, room;
    double *column[API_COLUMNS];
    struct api_bifurcations bifurcations;
    int found_all, written;
    double until; /* the fraction of all steps at which this part ends; the last part does not reach
                   * it */
    int last;     /* whether this is the last part, which writes all rows */
    double earlier; /* s used by the earlier parts */
    enum pend_orbits_end end;
    struct api_writer *writer;
    struct api_stats stats;
    char warning[API_WARNING_TEXT];
};

static void orbits_clear(void *state) {
    struct orbits *orbits = state;
    pend_orbits_free(&orbits->search);
    api_writer_free(&orbits->writer);
    api_bifurcations_clear(&orbits->bifurcations);
    for (int c = 0; c < orbits->table.count; c++) free(orbits->column[c]);
    free(orbits->start);
    api_orbits_clear(&orbits->asked);
}

/* ---- reading */

static void orbits_columns(struct orbits *orbits) {
    struct api_table *table = &orbits->table;
    int n = orbits->asked.tree.n;
    assert(!table->count && n >= 1);
    if (orbits->asked.rows) {
        api_bifurcations_table(&orbits->bifurcations, table);
        return;
    }
    if (orbits->asked.varies) api_table_add(table, orbits->asked.varies, NULL, 0);
    if (!orbits->asked.problem.driven) api_table_add(table, "energy", NULL, 0);
    api_table_add(table, "period", NULL, 0);
    api_table_add(table, "amplitude", NULL, n);
    api_table_add(table, "phi", NULL, n);
    api_table_add(table, "phid", NULL, n);
    api_table_add(table, "stable", NULL, 0);
    api_table_add(table, "closure", NULL, 0);
    api_table_add_inner(table, "multipliers", "re", 0, 2 * n);
    api_table_add_inner(table, "multipliers", "im", 0, 2 * n);
}

static enum pend_status orbits_read(void *state, const struct api_reading *reading) {
    struct orbits *orbits = state;
    orbits->format = reading->format;
    orbits->last = 1;
    orbits->step_cap = reading->limits->steps;
    orbits->step_name = api_limits_name(reading->limits, &reading->limits->steps);
    enum pend_status status = api_orbits_read(&orbits->asked, reading);
    if (status == PEND_OK) {
        // each kind of bifurcation may occur between two orbits
        orbits->table.rows = orbits->asked.problem.branch ? orbits->asked.problem.points : 1;
        if (orbits->asked.rows) orbits->table.rows *= 3;
        orbits->bifurcations = (struct api_bifurcations){.tree = orbits->asked.tree.tree,
                                                         .driven = orbits->asked.problem.driven,
                                                         .varies = orbits->asked.varies};
        orbits->table.rows_later = 1;
        orbits->table.digits = orbits->asked.digits;
        orbits_columns(orbits);
        api_reading_check_kept(reading, &orbits->table, API_MEMBER(reading->root, "count"),
                               orbits->asked.tree.n, "orbits", "fewer points");
        if (reading->problem->status) status = PEND_INVALID;
    }
    return status;
}

/* ---- running */

static enum pend_status orbits_begin(struct orbits *orbits, struct pend_error *error) {
    const struct api_tree *tree = &orbits->asked.tree;
    struct pend_orbit_problem problem = orbits->asked.problem;
    struct api_states *start = orbits->asked.start;
    size_t n = (size_t)tree->n;
    problem.tree = tree->tree, problem.loads = tree->loads;
    if (problem.driven) {
        orbits->start = calloc(2 * n, sizeof(double));
        if (!orbits->start)
            return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a state of %zu arms", n);
        if (start) PEND_TRY(api_states_settle(start, tree, error));
        for (size_t k = 0; k < n; k++) {
            orbits->start[k] = start ? start->phi[k] : -M_PI / 2;
            orbits->start[n + k] = start ? start->rate[k] : 0;
        }
        problem.phi = orbits->start, problem.rate = orbits->start + n;
    }
    return pend_orbits_new(&orbits->search, &problem, error);
}

static enum pend_status orbits_grow(struct orbits *orbits, struct pend_error *error) {
    return api_table_grow(&orbits->table, orbits->count, FIRST_ROOM, &orbits->room, orbits->column,
                          error);
}

static enum pend_status orbits_keep(struct orbits *orbits, const struct pend_orbit *orbit,
                                    struct pend_error *error) {
    size_t n = (size_t)orbits->asked.tree.n;
    const int *order = orbits->asked.tree.tree->order;
    int c = 0;
    assert(orbits->count < orbits->table.rows);
    PEND_TRY(orbits_grow(orbits, error));
    size_t row = (size_t)orbits->count++;
    if (orbits->asked.varies) orbits->column[c++][row] = orbit->value;
    if (!orbits->asked.problem.driven) orbits->column[c++][row] = orbit->energy;
    orbits->column[c++][row] = orbit->period;
    const double *const arms[] = {orbit->amplitude, orbit->phi, orbit->rate};
    for (int i = 0; i < 3; i++, c++)
        for (size_t k = 0; k < n; k++) orbits->column[c][row * n + (size_t)order[k]] = arms[i][k];
    orbits->column[c++][row] = orbit->stable;
    orbits->column[c++][row] = orbit->closure;
    memcpy(orbits->column[c++] + row * 2 * n, orbit->re, 2 * n * sizeof(double));
    memcpy(orbits->column[c++] + row * 2 * n, orbit->im, 2 * n * sizeof(double));
    assert(c == orbits->table.count && c <= MAIN_COLUMNS);
    return PEND_OK;
}

/* stores a bifurcation, which is located after the next orbit was found; one at which a branch
 * begins precedes all orbits */
static enum pend_status orbits_note(struct orbits *orbits, const struct pend_orbit *orbit,
                                    struct pend_error *error) {
    long after = orbits->count ? orbits->count - 1 : 0;
    if (api_bifurcations_add(&orbits->bifurcations, orbit, after) == PEND_OK) return PEND_OK;
    return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for bifurcations");
}

static enum pend_status orbits_search(struct orbits *orbits, struct pend_error *error) {
    enum pend_orbits_found found;
    PEND_TRY(pend_orbits_next(orbits->search, &found, error));
    struct pend_orbit orbit = pend_orbits_orbit(orbits->search);
    long maps, steps = pend_orbits_steps(orbits->search, &maps);
    if ((double)steps > orbits->step_cap)
        return pend_fail(error, PEND_TOO_MANY_STEPS, -1, 0,
                         "more steps than the limit %s of %.0f: ask for smaller swings, fewer "
                         "points or fewer periods",
                         orbits->step_name, orbits->step_cap);
    if (found == PEND_ORBITS_ORBIT && !orbits->asked.rows)
        return orbits_keep(orbits, &orbit, error);
    orbits->count += found == PEND_ORBITS_ORBIT; // if bifurcations are the rows
    if (found == PEND_ORBITS_BIFURCATION) return orbits_note(orbits, &orbit, error);
    if (found != PEND_ORBITS_END) return PEND_OK;
    orbits->found_all = 1;
    orbits->end = pend_orbits_end(orbits->search);
    orbits->table.rows = orbits->asked.rows ? orbits->bifurcations.count : orbits->count;
    return PEND_OK;
}

/* ---- results */

static void orbits_tell(struct orbits *orbits, const struct api_turn *turn) {
    struct api_stats *stats = &orbits->stats;
    long maps, steps = pend_orbits_steps(orbits->search, &maps);
    api_stats_text(stats, "end", api_orbits_end(orbits->end));
    api_stats_whole(stats, "orbits", orbits->count);
    api_stats_whole(stats, "bifurcations", orbits->bifurcations.count);
    api_stats_whole(stats, "shots", maps);
    api_stats_whole(stats, "steps", steps);
    api_turn_tell(turn, orbits->earlier, stats);
    api_orbits_sentence(&orbits->asked.problem, orbits->search, orbits->count, orbits->warning);
    if (orbits->end != PEND_ORBITS_REACHED)
        api_stats_warning(stats, "warning_end", orbits->warning);
}

/* additional members of JSON, which replace its closing brace */
static enum pend_status orbits_more(const struct orbits *orbits, struct api_buffer *out) {
    assert(out->bytes && out->data[out->bytes - 1] == '}');
    out->data[out->bytes - 1] = ',';
    PEND_TRY(api_out_text(out, "end", api_orbits_end(orbits->end)));
    PEND_TRY(api_out_text(out, "message", orbits->warning));
    PEND_TRY(api_bifurcations_write(&orbits->bifurcations, orbits->table.digits, out));
    return api_buffer_text(out, "}");
}

static enum pend_status orbits_rows(struct orbits *orbits, const struct api_turn *turn,
                                    struct pend_error *error) {
    const double *column[API_COLUMNS];
    if (!orbits->table.rows) return PEND_OK;
    if (!orbits->asked.rows)
        return api_writer_block(orbits->writer, orbits->count,
                                (const double *const *)orbits->column, turn->out, error);
    free(orbits->bifurcations.block);
    orbits->bifurcations.block = NULL;
    PEND_TRY(api_bifurcations_columns(&orbits->bifurcations, &orbits->table, column));
    return api_writer_block(orbits->writer, orbits->table.rows, column, turn->out, error);
}

static enum pend_status orbits_write(struct orbits *orbits, const struct api_turn *turn, int *done,
                                     struct pend_error *error) {
    if (!orbits->writer)
        PEND_TRY(api_writer_new(&orbits->writer, orbits->format, &orbits->table, turn->out));
    if (!orbits->written) {
        orbits->written = 1;
        PEND_TRY(orbits_rows(orbits, turn, error));
    }
    if (!orbits->stats.count) orbits_tell(orbits, turn);
    PEND_TRY(api_writer_finish(orbits->writer, &orbits->stats, turn->out, done));
    return *done && orbits->format == &api_format_json ? orbits_more(orbits, turn->out) : PEND_OK;
}

/* true at the end of a part that is followed by another */
static int orbits_over(struct orbits *orbits, const struct api_turn *turn) {
    const struct pend_orbit_problem *p = &orbits->asked.problem;
    long steps;
    if (orbits->last || !pend_orbits_rests(orbits->search, &steps)) return 0;
    if (!orbits->found_all && (double)steps < orbits->until * p->points * (1 + (double)p->switches))
        return 0;
    orbits->earlier += fmax(0, api_turn_seconds(turn));
    return 1;
}

static enum pend_status orbits_run(void *state, const struct api_turn *turn, int *done,
                                   struct pend_error *error) {
    struct orbits *orbits = state;
    if (!orbits->search) PEND_TRY(orbits_begin(orbits, error));
    do {
        *done = orbits_over(orbits, turn);
        if (*done) break;
        if (orbits->found_all)
            PEND_TRY(orbits_write(orbits, turn, done, error));
        else
            PEND_TRY(orbits_search(orbits, error));
    } while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

static void orbits_json(void *state) {
    struct orbits *orbits = state;
    api_writer_free(&orbits->writer);
    orbits->format = &api_format_json;
    orbits->written = 0;
}

static long orbits_steps(const void *state) {
    const struct orbits *orbits = state;
    long maps;
    return orbits->search ? pend_orbits_steps(orbits->search, &maps) : 0;
}

static void orbits_progress(const void *state, double *steps, double *work) {
    const struct orbits *orbits = state;
    *steps = -1;
    *work = orbits->search ? pend_orbits_progress(orbits->search) : 0;
}

/* one part per step, or fewer if many rows have to be passed on */
static long orbits_parts(const void *state) {
    const struct orbits *orbits = state;
    const struct pend_orbit_problem *p = &orbits->asked.problem;
    double steps = (double)p->points * (1 + p->switches);
    double bytes = 8 * api_table_numbers(&orbits->table, 0) * (double)orbits->table.rows;
    if (!p->branch || (p->driven && !p->vary)) return 1;
    return (long)fmin(fmin(steps, MOST_PARTS), 1 + carried_bytes / bytes);
}

static void orbits_part(void *state, long number, long parts) {
    struct orbits *orbits = state;
    orbits->until = (double)(number + 1) / (double)parts;
    orbits->last = number + 1 == parts;
}

/* saves or restores everything found so far, which the last part writes */
static enum pend_status orbits_carry(void *state, struct pend_checkpoint *checkpoint,
                                     struct pend_error *error) {
    struct orbits *orbits = state;
    int version = CARRIED, puts = pend_checkpoint_puts(checkpoint);
    long count = orbits->count;
    if (!orbits->search) PEND_TRY(orbits_begin(orbits, error));
    pend_checkpoint_part(checkpoint, &version, sizeof version);
    if (version != CARRIED) return PEND_INVALID;
    pend_checkpoint_counts(checkpoint, &count, 1);
    pend_checkpoint_row(checkpoint, &orbits->earlier, 1);
    if (puts && !pend_checkpoint_puts(checkpoint)) return PEND_INVALID;
    // restored counts must not exceed what a search can find
    if (puts && count > (long)orbits->table.rows) return PEND_INVALID;
    PEND_TRY(pend_orbits_carry(orbits->search, checkpoint));
    PEND_TRY(api_bifurcations_carry(&orbits->bifurcations, checkpoint));
    for (; pend_checkpoint_puts(checkpoint) && orbits->count < count; orbits->count++) {
        if (orbits->asked.rows) continue;
        PEND_TRY(orbits_grow(orbits, error));
    }
    /* memory for the restored rows ran out, so the checkpoint is refused */
    if (orbits->count < count) return PEND_INVALID;
    for (int c = 0; c < orbits->table.count && !orbits->asked.rows; c++) {
        size_t width = (size_t)api_column_numbers(&orbits->table.column[c]);
        if (count) pend_checkpoint_row(checkpoint, orbits->column[c], (size_t)count * width);
    }
    return PEND_OK;
}

/* number of steps of a motion over `periods` periods of a drive, estimated as for sections */
static double orbits_driven_steps(const struct api_orbits *asked, double periods) {
    double rate =
        api_swing(&asked->tree, NULL) + pend_loads_rate(&asked->tree.loads, asked->tree.tree);
    return steps_least + periods * 2 * M_PI / asked->omega * rate;
}

static double orbits_cost(const void *state) {
    const struct api_orbits *asked = &((const struct orbits *)state)->asked;
    const struct pend_orbit_problem *p = &asked->problem;
    double n = asked->tree.n, passes = ceil(2 * n / 8), swing = M_PI;
    double maps = p->branch ? maps_on_branch + maps_an_arm * n : maps_alone;
    // each branch may take as long, and the next branch has twice the period
    double branches = p->switches ? exp2(fmin(p->switches, 3)) * (p->switches + 1) : 1;
    double arm = asked->tree.loads.terms ? real_seconds : ideal_seconds * (1 + n / arms_cached);
    if (p->driven) {
        double points = p->vary ? p->points : 4;
        double steps = orbits_driven_steps(asked, p->periods);
        double settle = p->settle ? orbits_driven_steps(asked, p->settle) : 0;
        return (branches * maps * points * steps * passes * arm + settle * plain_seconds) * n;
    }
    if (p->target == PEND_ORBIT_AMPLITUDE) swing = p->until;
    double points = fmin(p->points, swing / p->step + 15);
    return branches * maps * points * (steps_least + steps_an_arm * n) * passes * n * arm;
}

/* rows are in a buffer that doubles when full; representations that do not stream store a copy */
static double orbits_bytes(const void *state) {
    const struct orbits *orbits = state;
    struct pend_orbit_problem problem = orbits->asked.problem;
    double numbers = api_table_numbers(&orbits->table, 0);
    double room = (double)(orbits->room ? orbits->room : FIRST_ROOM);
    if (orbits->room && orbits->count + 1 >= orbits->room) room *= 3;
    room = fmin(room, 1.5 * (double)orbits->table.rows);
    problem.tree = orbits->asked.tree.tree, problem.loads = orbits->asked.tree.loads;
    return API_OP_SMALL_BYTES + pend_orbits_bytes(&problem) + 2 * sizeof(double) * numbers * room +
           api_bifurcations_bytes(&orbits->bifurcations, orbits->asked.rows) +
           api_tree_bytes(&orbits->asked.tree) + api_states_bytes(orbits->asked.start) +
           2.0 * API_PIECE_BYTES;
}

const struct api_op api_op_orbits = {.name = "orbits",
                                     .size = sizeof(struct orbits),
                                     .body = 1,
                                     .terms = 1,
                                     .samples = 1,
                                     .read = orbits_read,
                                     .run = orbits_run,
                                     .steps = orbits_steps,
                                     .progress = orbits_progress,
                                     .table = offsetof(struct orbits, table),
                                     .cost = orbits_cost,
                                     .bytes = orbits_bytes,
                                     .parts = orbits_parts,
                                     .part = orbits_part,
                                     .carry = orbits_carry,
                                     .stats = offsetof(struct orbits, stats),
                                     .json = orbits_json,
                                     .clear = orbits_clear};

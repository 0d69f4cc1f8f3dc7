#include "api/op/ensemble/member_range.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/ensemble/member_events.h"
#include "core/ensemble/ensemble.h"
#include "core/integrate/pieces/pieces.h"

struct api_member_range {
    const struct api_ensemble *ensemble;
    struct pend_ensemble *work;
    struct api_member_derived *derived; /* NULL if not requested */
    long first, count, slice;
    int moved;           /* whether all motions are complete, so that only derivatives remain */
    long differentiated; /* number of members whose derivatives are complete */
    long due, rows;      /* rows of the current member: how many need derivatives, and how many are
                          * complete */
    struct api_member_range_stats stats;
    double *raw;
    long *found;   /* number of passages of each member, if they are the rows */
    double *start; /* the current member's angles, rates, lengths, masses and numbers of terms */
    double *room;  /* scratch of api_members_fill */
    struct api_member_samples *samples; /* the rows of trajectories; NULL if there are none */
    int shapes; /* whether the rows depend on numbers of the pendulum that differ between members */
};

static double *range_row(const struct api_member_range *range, long member, long row) {
    const struct api_ensemble *e = range->ensemble;
    assert(row >= 0 && row < api_ensemble_rows(e) && member >= range->first);
    return range->raw + ((member - range->first) * api_ensemble_rows(e) + row) * e->numbers;
}

static long range_number(const struct api_member_range *range, long i) {
    return range->ensemble->members.first + i;
}

static int range_fetch(void *context, long i, struct pend_member *member) {
    const struct api_member_range *range = context;
    const struct api_ensemble *e = range->ensemble;
    member->start = e->origin;
    api_members_fill(&e->members, e->tree.tree, i, member, range->room);
    if (e->events.count && !e->events.rows)
        api_member_events_blank(&e->events, 0, range_row(range, i, 0) + e->events_at);
    return 0;
}

static void range_hit(void *context, long i, const struct pend_hit *hit, const double phi[],
                      const double rate[]) {
    const struct api_member_range *range = context;
    const struct api_events *events = &range->ensemble->events;
    if (events->rows)
        api_member_events_row(events, range_number(range, i), hit, phi, rate,
                              range_row(range, i, range->found[i - range->first]++));
    else
        api_member_events_note(events, hit, phi, rate,
                               range_row(range, i, 0) + range->ensemble->events_at);
}

/* marks passages after a member's failure as unknown in its rows */
static void range_doubt(const struct api_member_range *range, long i, enum pend_status status) {
    const struct api_ensemble *e = range->ensemble;
    if (status == PEND_OK || !e->events.count) return;
    if (!e->events.rows)
        api_member_events_blank(&e->events, NAN, range_row(range, i, 0) + e->events_at);
    for (long row = 0; e->events.rows && row < range->found[i - range->first]; row++)
        range_row(range, i, row)[1] = api_observables_status(status);
}

/* fills in a member's start and its pendulum in the range's own arrays */
static struct pend_member range_start(const struct api_member_range *range, long i) {
    const struct api_ensemble *e = range->ensemble;
    const struct pend_tree *tree = e->tree.tree;
    size_t n = (size_t)tree->n;
    struct pend_member start = {.phi = range->start,
                                .rate = range->start + n,
                                .length = range->start + 2 * n,
                                .mass = range->start + 3 * n,
                                .loads = e->tree.loads,
                                .value = range->start + 4 * n,
                                .start = e->origin};
    memcpy(start.length, tree->len, n * sizeof(double));
    memcpy(start.mass, tree->mass, n * sizeof(double));
    if (e->tree.loads.terms) {
        memcpy(start.value, e->tree.loads.value,
               (size_t)e->tree.loads.terms->count * sizeof(double));
        start.loads.value = start.value;
    }
    api_members_fill(&e->members, tree, i, &start, range->room);
    return start;
}

static void range_rows(void *context, long i, long first, int count, const double phi[],
                       const double rate[], const double force[], const double theta[]) {
    const struct api_member_range *range = context;
    const struct api_ensemble *e = range->ensemble;
    int n = e->tree.tree->n;
    struct pend_member start;
    if (range->shapes) {
        start = range_start(range, i);
        api_member_samples_pendulum(range->samples, &start);
    }
    for (int done = 0, some; done < count; done += some) {
        double t[API_MEMBER_ROWS];
        some = count - done < API_MEMBER_ROWS ? count - done : API_MEMBER_ROWS;
        for (int j = 0; j < some; j++) t[j] = pend_times_at(&e->times.times, first + done + j);
        const struct api_member_states states = {.count = some,
                                                 .t = t,
                                                 .phi = phi + done * n,
                                                 .rate = rate + done * n,
                                                 .force = force + done * n,
                                                 .theta = theta + done * n};
        api_member_samples_rows(range->samples, (double)range_number(range, i), &states,
                                range_row(range, i, first + done), e->numbers);
    }
}

static void range_unknown(double at[], long count) {
    for (long i = 0; i < count; i++) at[i] = NAN;
}

/* fills the rows that a failed member did not reach with its number, its status, the time, and
 * NaN */
static void range_blank(const struct api_member_range *range, long i, enum pend_status status,
                        double reached) {
    const struct api_ensemble *e = range->ensemble;
    for (long row = 0; row < api_ensemble_rows(e); row++) {
        double *at = range_row(range, i, row);
        if (reached != 0 && fabs(e->instants[row]) <= fabs(reached)) continue;
        range_unknown(at + 3, e->numbers - 3);
        at[0] = (double)range_number(range, i);
        at[1] = api_observables_status(status);
        at[2] = pend_times_at(&e->times.times, row);
    }
}

static int range_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct api_member_range *range = context;
    const struct api_ensemble *e = range->ensemble;
    assert(i >= range->first && i < e->members.count);
    range->stats.finished++;
    int bad = api_observables_end(&e->seen, &e->tree, outcome) != PEND_OK;
    // a member that reached its end may have rows with a status: their numbers are not finite
    long rows = !bad && e->instants ? api_ensemble_rows(e) : 0, good = 0;
    while (good < rows && range_row(range, i, good)[1] == 0) good++;
    bad |= good < rows;
    range->stats.failed += bad;
    range->stats.steps += outcome->steps;
    range->stats.lost += !bad && fabs(outcome->horizon) < fabs(outcome->time);
    range_doubt(range, i, outcome->status);
    if (e->events.rows) return 0;
    if (e->instants) {
        if (outcome->status != PEND_OK) range_blank(range, i, outcome->status, outcome->time);
        return 0;
    }
    /* generate the start again only if the answer contains it */
    struct pend_member start = {.phi = NULL};
    if (e->seen.wanted & (1u << API_SEE_START | 1u << API_SEE_PARAMETERS))
        start = range_start(range, i);
    double *row = range_row(range, i, 0);
    api_observables_write(&e->seen, &e->tree, range_number(range, i), &start, outcome, row);
    memset(row + e->derived_at, 0, (size_t)(e->numbers - e->derived_at) * sizeof *row);
    return 0;
}

PEND_VALIDATOR range_valid(const struct api_member_range *range) {
    const struct api_member_range_stats *stats = &range->stats;
    return range->first >= 0 && range->slice > 0 && range->raw && range->work &&
           stats->finished <= range->ensemble->members.count - range->first &&
           stats->failed + stats->lost <= stats->finished;
}

/* sets which outputs are computed for members */
static void range_ask(const struct api_ensemble *e, struct pend_ensemble_problem *problem) {
    if (!e->events.rows) api_observables_ask(&e->seen, problem);
    if (!e->events.count) return;
    // passages may occur until the end of the duration
    problem->spare = 0;
    problem->until = e->events.rows ? PEND_UNTIL_TOLD : PEND_UNTIL_TIME;
    problem->events = e->events.count;
    problem->event = e->events.event;
}

/* removes the gaps between the passages of successive members; returns the number of passages */
static long range_close(const struct api_member_range *range) {
    const struct api_ensemble *e = range->ensemble;
    if (!e->events.rows) return range->count * api_ensemble_rows(e);
    long rows = 0;
    for (long i = 0; i < range->count; i++) {
        size_t numbers = (size_t)range->found[i] * (size_t)e->numbers;
        memmove(range->raw + rows * e->numbers, range_row(range, range->first + i, 0),
                numbers * sizeof(double));
        rows += range->found[i];
    }
    return rows;
}

/* prepares the derivatives of the members, one after another */
static enum pend_status range_differ(struct api_member_range *range) {
    const struct api_ensemble *e = range->ensemble;
    struct api_member_derived_of of = {.derived = &e->derived,
                                       .tree = &e->tree,
                                       .members = &e->members,
                                       .times = e->instants ? &e->times.times : NULL,
                                       .origin = e->origin,
                                       .duration = e->duration,
                                       .rtol = e->rtol,
                                       .atol = e->atol,
                                       .step_cap = e->step_cap};
    return e->derived.count ? api_member_derived_new(&range->derived, &of) : PEND_OK;
}

enum pend_status api_member_range_new(struct api_member_range **range, const struct api_ensemble *e,
                                      long first, long count, double raw[],
                                      struct pend_error *error) {
    size_t n = (size_t)e->tree.tree->n;
    assert(!e->members.states->mode_most); /* api_ensemble_prepare must have been called */
    assert(first >= 0 && count <= e->members.count - first);
    size_t terms = e->tree.loads.terms ? (size_t)e->tree.loads.terms->count : 0;
    size_t own = ((4 + API_ENERGY_ROOM) * n + terms) * sizeof(double),
           found = e->events.rows ? (size_t)count * sizeof(long) : 0;
    struct api_member_range *s = *range = calloc(1, sizeof *s + own + found);
    if (!s) return PEND_NO_MEMORY;
    *s = (struct api_member_range){
        .ensemble = e, .first = first, .count = count, .raw = raw, .start = (double *)(s + 1)};
    s->room = s->start + 4 * n + terms;
    if (found) s->found = (long *)(void *)(s->room + API_ENERGY_ROOM * n);
    /* about half a millisecond */
    s->slice = 1 + 500 / (long)n;
    struct pend_ensemble_problem problem = {
        .tree = e->tree.tree,
        .loads = e->tree.loads,
        .duration = e->duration,
        .rtol = e->rtol,
        .atol = e->atol,
        .accuracy = pend_pieces_unestimated(e->tree.terms) ? 0 : e->accuracy,
        .step_cap = e->step_cap,
        .fetch = range_fetch,
        .deliver = range_deliver,
        .rows = range_rows,
        .hit = range_hit,
        .context = s};
    range_ask(e, &problem);
    if (e->instants) {
        problem.times = e->instants;
        problem.times_count = e->times.times.count;
    }
    enum pend_status status = pend_ensemble_new(&s->work, &problem, pend_isa_best(), error);
    if (status == PEND_OK && e->instants)
        status = api_member_samples_new(&s->samples, &e->tree, e->seen.output);
    if (status == PEND_OK) status = range_differ(s);
    s->shapes = api_member_outputs_derived(e->seen.output) && api_members_shapes(&e->members);
    if (status != PEND_OK) {
        api_member_range_free(range);
        return status;
    }
    pend_ensemble_begin(s->work, first, count);
    assert(range_valid(s));
    return PEND_OK;
}

void api_member_range_free(struct api_member_range **range) {
    struct api_member_range *gone = *range;
    if (!gone) return;
    pend_ensemble_free(&gone->work);
    api_member_samples_free(&gone->samples);
    api_member_derived_free(&gone->derived);
    free(gone);
    *range = NULL;
}

/* the number of a member's rows before its motion failed */
static long range_good(const struct api_member_range *range, long member) {
    long rows = 0, all = api_ensemble_rows(range->ensemble);
    while (rows < all && range_row(range, member, rows)[1] == 0) rows++;
    return rows;
}

/* discards the derivatives of a member's pending rows after a failure */
static void range_undo(struct api_member_range *range, long member, enum pend_status status) {
    const struct api_ensemble *e = range->ensemble;
    range->stats.failed += range_good(range, member) == api_ensemble_rows(e);
    for (long row = range->rows; row < range->due; row++) {
        double *at = range_row(range, member, row);
        range_unknown(at + e->derived_at, e->numbers - e->derived_at);
        at[1] = api_observables_status(status);
    }
}

/* continues the derivatives of a member, or of the next one that has a row */
static enum pend_status range_differentiate(struct api_member_range *range,
                                            struct pend_error *error) {
    const struct api_ensemble *e = range->ensemble;
    long member = range->first + range->differentiated;
    if (range->rows == range->due) {
        range->rows = 0, range->due = range_good(range, member);
        // rows after the last valid one have no derivatives, and the status of the failure
        for (long row = range->due; row < api_ensemble_rows(e); row++) {
            double *at = range_row(range, member, row);
            range_unknown(at + e->derived_at, e->numbers - e->derived_at);
            if (at[1] == 0) at[1] = api_observables_status(PEND_NOT_FINITE);
        }
        if (range->due) return api_member_derived_begin(range->derived, member, range->due, error);
    } else {
        double *raw = range_row(range, member, 0) + e->derived_at;
        enum pend_status status =
            api_member_derived_next(range->derived, raw, e->numbers, &range->rows);
        if (status == PEND_NO_MEMORY) return status;
        if (status != PEND_OK) {
            range_undo(range, member, status);
            range->due = range->rows;
        }
    }
    if (range->rows == range->due) range->rows = range->due = 0, range->differentiated++;
    return PEND_OK;
}

enum pend_status api_member_range_go(struct api_member_range *range, int *done,
                                     struct pend_error *error) {
    enum pend_status status = PEND_OK;
    assert(range_valid(range));
    if (!range->moved)
        status = pend_ensemble_go(range->work, range->slice, &range->moved);
    else if (range->derived && range->differentiated < range->count)
        status = range_differentiate(range, error);
    *done = range->moved && (!range->derived || range->differentiated == range->count);
    if (*done) range->stats.rows = range_close(range);
    assert(range_valid(range));
    return status;
}

struct api_member_range_stats api_member_range_stats(const struct api_member_range *range) {
    assert(range_valid(range));
    return range->stats;
}

#include "api/op/ensemble.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/read/method_json.h"
#include "api/op/picture_json.h"
#include "core/ensemble/ensemble.h"
#include "core/integrate/method.h"

static const char *const fields[] = {"pendulum", "initial", "states",      "grid",    "random",
                                     "duration", "times",   "observables", "output",  "method",
                                     "rtol",     "atol",    "digits",      "picture", "accuracy",
                                     "start",    NULL};

/* constants of the estimated cost: steps a radian of the fastest swing, s an arm and squared order,
 * s a number */
static const double steps_a_radian = 6, pair_seconds = 0.15e-9, number_seconds = 20e-9;

/* the most doubles of raw rows of one member: the memory of a range of one member */
static const double member_numbers = 1 << 24;

struct api_ensemble {
    struct api_tree tree;
    struct api_members members;
    struct api_observables seen;
    struct api_times times;
    double *instants; /* s, from the first one on; NULL without a trajectory */
    double origin, duration, rtol, atol, accuracy; /* s, when members begin, and how long */
    long step_cap, numbers;
};

/* a range of members while it is computed */
struct api_member_range {
    const struct api_ensemble *ensemble;
    struct pend_ensemble *work;
    long first, slice;
    struct api_member_range_stats stats;
    double *raw;
    double *start; /* of the member at hand: angles, rates, lengths, masses, numbers of terms */
};

void api_ensemble_free(struct api_ensemble **ensemble) {
    struct api_ensemble *e = *ensemble;
    if (!e) return;
    free(e->instants);
    api_times_clear(&e->times);
    api_members_clear(&e->members);
    api_tree_clear(&e->tree);
    free(e);
    *ensemble = NULL;
}

/* reading */

static void read_method(struct api_ensemble *e, const struct api_reading *reading) {
    static const char *const methods[] = {"taylor", NULL};
    const struct pend_method *taylor = &pend_method_taylor;
    struct api_value method = api_value_member(reading->root, "method");
    struct api_value rtol = api_value_member(reading->root, "rtol"),
                     atol = api_value_member(reading->root, "atol");
    int chosen = 0;
    if (api_field_word(&method, methods, &chosen, reading->problem) > 0) api_value_usual(&method);
    api_value_usual_number(&rtol, taylor->rtol_default);
    api_value_usual_number(&atol, 0);
    e->accuracy = api_accuracy_read(reading->root, reading->problem);
    e->rtol = taylor->rtol_default;
    e->atol = 0;
    (void)api_value_read_number(&rtol, taylor->rtol_min, taylor->rtol_max, "", &e->rtol,
                                reading->problem);
    (void)api_value_read_number(&atol, taylor->atol_min, taylor->atol_max, "", &e->atol,
                                reading->problem);
}

/* reads how long members are followed: a duration, or the instants of a trajectory */
static enum pend_status read_time(struct api_ensemble *e, const struct api_reading *reading) {
    struct api_value duration = api_value_member(reading->root, "duration");
    struct api_value times = api_value_member(reading->root, "times");
    struct api_value start = api_value_member(reading->root, "start");
    struct api_problem *problem = reading->problem;
    int rows = e->seen.wanted >> API_SEE_TRAJECTORY & 1;
    if (!rows) {
        if (api_value_kind(&times) != API_MISSING)
            api_value_fault(&times, problem,
                            "is for the observable \"trajectory\": give a \"duration\"");
        if (api_field_needed(&duration, problem) &&
            api_value_read_number(&duration, 0, 1e9, "s", &e->duration, problem) > 0 &&
            e->duration == 0)
            api_value_fault(&duration, problem, "must be greater than 0");
        (void)api_value_read_number(&start, -1e9, 1e9, "s", &e->origin, problem);
        api_value_usual_number(&start, 0);
        return PEND_OK;
    }
    if (api_value_kind(&start) != API_MISSING)
        api_value_fault(&start, problem,
                        "does not go together with \"times\", the first of which is when members "
                        "begin");
    if (api_value_kind(&duration) != API_MISSING)
        api_value_fault(&duration, problem,
                        "does not go together with \"times\", which say how long a trajectory is");
    enum pend_status status = api_times_read(&e->times, &times, reading->limits, problem);
    if (status != PEND_OK) return status == PEND_NO_MEMORY ? status : PEND_OK;
    long count = e->times.times.count;
    e->instants = malloc((size_t)count * sizeof *e->instants);
    if (!e->instants) return PEND_NO_MEMORY;
    e->origin = pend_times_at(&e->times.times, 0);
    for (long i = 0; i < count; i++) e->instants[i] = pend_times_at(&e->times.times, i) - e->origin;
    e->duration = e->instants[count - 1];
    return PEND_OK;
}

/* adds faults for too many rows, too much memory and too much time */
static void check_size(struct api_ensemble *e, const struct api_reading *reading) {
    const struct api_limits *limits = reading->limits;
    struct api_table *table = &e->seen.table;
    double rows = (double)e->members.count * (double)api_ensemble_rows(e);
    int trajectory = e->instants != NULL;
    e->numbers = (long)api_table_numbers(table, 0);
    if (trajectory && rows > limits->samples) {
        api_value_fault(
            reading->root, reading->problem,
            "asks for %.15g rows, instants times members, more than the limit %s of %.0f: ask for "
            "fewer of either at a time",
            rows, api_limits_name(limits, &limits->samples), limits->samples);
        return;
    }
    if ((double)api_ensemble_rows(e) * (double)e->numbers > member_numbers) {
        api_value_fault(reading->root, reading->problem,
                        "asks for %.15g numbers a member, more than the %.0f that an ensemble "
                        "keeps for one: ask for "
                        "fewer instants, or for members one by one as trajectories",
                        (double)api_ensemble_rows(e) * (double)e->numbers, member_numbers);
        return;
    }
    table->rows = (long)rows;
    api_reading_check_size(reading, table, reading->root, "rows", "fewer members or observables");
    double cost = api_ensemble_cost(e, e->members.count);
    if (cost > limits->compute_seconds)
        api_value_fault(reading->root, reading->problem,
                        "would take about %.3g s, more than the limit %s of %.0f: ask for fewer "
                        "members, a shorter time or a looser tolerance at a time",
                        cost, api_limits_name(limits, &limits->compute_seconds),
                        limits->compute_seconds);
}

/* what is told of a cart alone */
static void check_cart(const struct api_ensemble *e, const struct api_reading *reading) {
    const char *name = e->instants ? "output" : "observables";
    struct api_value list = api_value_member(reading->root, name);
    if (e->tree.cart || !api_observables_cart(&e->seen)) return;
    api_value_fault(&list, reading->problem,
                    "has \"cart\", and the pendulum has none: give one in \"pivot\"");
}

static enum pend_status read_parts(struct api_ensemble *e, const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    const struct api_value *root = reading->root;
    struct api_value digits = api_value_member(root, "digits");
    long rounded = 0;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &e->tree);
    if (status == PEND_NO_MEMORY) return status;
    api_observables_read(&e->seen, root, problem);
    PEND_TRY(read_time(e, reading));
    read_method(e, reading);
    (void)api_field_whole(&digits, 1, 17, &rounded, problem);
    status = api_members_read(&e->members, root, &e->tree, reading->limits, problem);
    if (status == PEND_NO_MEMORY) return status;
    if (problem->status) return PEND_INVALID;
    e->seen.table.digits = (int)rounded;
    check_cart(e, reading);
    if (problem->status) return PEND_INVALID;
    api_observables_columns(&e->seen, e->tree.n, &e->members);
    api_picture_read(&e->seen, &e->members, &e->tree, reading);
    if (!problem->status) check_size(e, reading);
    return problem->status ? PEND_INVALID : PEND_OK;
}

enum pend_status api_ensemble_new(struct api_ensemble **ensemble,
                                  const struct api_reading *reading) {
    struct api_ensemble *e = *ensemble = calloc(1, sizeof *e);
    if (!e) return PEND_NO_MEMORY;
    // one member among many may take a hundredth
    e->step_cap = (long)(reading->limits->steps / 100);
    enum pend_status status = read_parts(e, reading);
    if (status != PEND_OK) api_ensemble_free(ensemble);
    return status;
}

/* properties */

long api_ensemble_count(const struct api_ensemble *e) { return e->members.count; }

const struct api_table *api_ensemble_table(const struct api_ensemble *e) { return &e->seen.table; }

long api_ensemble_rows(const struct api_ensemble *e) {
    return e->instants ? e->times.times.count : 1;
}

long api_ensemble_numbers(const struct api_ensemble *e) { return e->numbers; }

double api_ensemble_cost(const struct api_ensemble *e, long members) {
    assert(members >= 0 && e->tree.tree);
    const struct pend_tree *tree = e->tree.tree;
    double shortest = INFINITY, order = 4 - 0.65 * log(fmax(0.01 * e->rtol, 1e-16));
    for (int k = 0; k < tree->n; k++) shortest = fmin(shortest, tree->len[k]);
    double rate =
        sqrt(fabs(e->tree.loads.gravity) / shortest) + pend_loads_rate(&e->tree.loads, tree);
    double radians = fabs(e->duration) * rate;
    double steps = 1 + steps_a_radian * radians * 28 / order;
    struct pend_ensemble_problem problem = {.until = PEND_UNTIL_TIME};
    api_observables_ask(&e->seen, &problem);
    // many end early, or are spared; a neighbour is as much work again
    if (problem.until != PEND_UNTIL_TIME) steps *= 0.3;
    if (problem.observe & PEND_OBSERVE_LYAPUNOV) steps *= 2;
    double numbers = (double)api_ensemble_rows(e) * (double)e->numbers;
    return (double)members *
           (steps * tree->n * order * order * pair_seconds + numbers * number_seconds);
}

double api_ensemble_bytes(const struct api_ensemble *e) {
    double n = api_tree_stored(&e->tree),
           list = e->instants ? 2.0 * (double)e->times.times.count * sizeof(double) : 0;
    double varied = (double)e->members.variations * sizeof *e->members.variation;
    // numbers of terms for each lane, and more series, with those of a neighbour
    if (e->tree.loads.terms) varied += 16 * sizeof(double) * e->tree.loads.terms->count;
    double arm_bytes = e->tree.loads.terms ? 54000 : 18000;
    return 32768 + (n + 16) * arm_bytes + list + varied + api_tree_bytes(&e->tree) +
           api_states_bytes(e->members.states);
}

enum pend_status api_ensemble_prepare(struct api_ensemble *e, struct pend_error *error) {
    assert(api_states_valid(e->members.states));
    return api_states_settle(e->members.states, &e->tree, error);
}

/* ranges of members */

static double *range_row(const struct api_member_range *range, long member, long row) {
    const struct api_ensemble *e = range->ensemble;
    assert(row >= 0 && row < api_ensemble_rows(e) && member >= range->first);
    return range->raw + ((member - range->first) * api_ensemble_rows(e) + row) * e->numbers;
}

static int range_fetch(void *context, long i, struct pend_member *member) {
    const struct api_member_range *range = context;
    const struct api_ensemble *e = range->ensemble;
    api_members_fill(&e->members, e->tree.tree->n, i, member);
    member->start = e->origin;
    return 0;
}

static void range_rows(void *context, long i, long first, int count, const double phi[],
                       const double rate[], const double force[], const double theta[]) {
    const struct api_member_range *range = context;
    const struct api_ensemble *e = range->ensemble;
    int n = e->tree.tree->n;
    for (int j = 0; j < count; j++)
        api_observables_sample(&e->seen, &e->tree, i, pend_times_at(&e->times.times, first + j),
                               phi + j * n, rate + j * n, force + j * n, theta + j * n,
                               range_row(range, i, first + j));
}

/* fills the rows that a failed member did not reach: its number, its status, the time, and zeros */
static void range_blank(const struct api_member_range *range, long i, enum pend_status status,
                        double reached) {
    const struct api_ensemble *e = range->ensemble;
    for (long row = 0; row < api_ensemble_rows(e); row++) {
        double *at = range_row(range, i, row);
        if (reached != 0 && fabs(e->instants[row]) <= fabs(reached)) continue;
        memset(at, 0, (size_t)e->numbers * sizeof *at);
        at[0] = (double)i;
        at[1] = api_observables_status(status);
        at[2] = pend_times_at(&e->times.times, row);
    }
}

static int range_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct api_member_range *range = context;
    const struct api_ensemble *e = range->ensemble;
    assert(i >= range->first && i < e->members.count);
    const struct pend_tree *tree = e->tree.tree;
    size_t n = (size_t)tree->n;
    range->stats.finished++;
    range->stats.failed += outcome->status != PEND_OK;
    range->stats.steps += outcome->steps;
    range->stats.lost += outcome->status == PEND_OK && fabs(outcome->horizon) < fabs(outcome->time);
    if (e->instants) {
        if (outcome->status != PEND_OK) range_blank(range, i, outcome->status, outcome->time);
        return 0;
    }
    struct pend_member start = {.phi = range->start,
                                .rate = range->start + n,
                                .length = range->start + 2 * n,
                                .mass = range->start + 3 * n,
                                .loads = e->tree.loads,
                                .value = range->start + 4 * n};
    size_t terms = e->tree.loads.terms ? (size_t)e->tree.loads.terms->count : 0;
    /* the start is drawn again only if it is answered */
    if (e->seen.wanted & (1u << API_SEE_START | 1u << API_SEE_PARAMETERS)) {
        memcpy(start.length, tree->len, n * sizeof(double));
        memcpy(start.mass, tree->mass, n * sizeof(double));
        if (terms) memcpy(start.value, e->tree.loads.value, terms * sizeof(double));
        api_members_fill(&e->members, tree->n, i, &start);
    }
    api_observables_write(&e->seen, &e->tree, i, &start, outcome, range_row(range, i, 0));
    return 0;
}

int api_member_range_valid(const struct api_member_range *range) {
    const struct api_member_range_stats *stats = &range->stats;
    return range->first >= 0 && range->slice > 0 && range->raw && range->work &&
           stats->finished <= range->ensemble->members.count - range->first &&
           stats->failed + stats->lost <= stats->finished;
}

enum pend_status api_member_range_new(struct api_member_range **range, const struct api_ensemble *e,
                                      long first, long count, double raw[],
                                      struct pend_error *error) {
    size_t n = (size_t)e->tree.tree->n;
    assert(!e->members.states->mode_most); /* api_ensemble_prepare was called */
    assert(first >= 0 && count <= e->members.count - first);
    size_t terms = e->tree.loads.terms ? (size_t)e->tree.loads.terms->count : 0;
    struct api_member_range *s = *range = calloc(1, sizeof *s + (4 * n + terms) * sizeof(double));
    if (!s) return PEND_NO_MEMORY;
    *s = (struct api_member_range){
        .ensemble = e, .first = first, .raw = raw, .start = (double *)(s + 1)};
    /* about half a millisecond */
    s->slice = 1 + 500 / (long)n;
    struct pend_ensemble_problem problem = {.tree = e->tree.tree,
                                            .loads = e->tree.loads,
                                            .duration = e->duration,
                                            .rtol = e->rtol,
                                            .atol = e->atol,
                                            .accuracy = e->accuracy,
                                            .step_cap = e->step_cap,
                                            .fetch = range_fetch,
                                            .deliver = range_deliver,
                                            .rows = range_rows,
                                            .context = s};
    api_observables_ask(&e->seen, &problem);
    if (e->instants) {
        problem.times = e->instants;
        problem.times_count = e->times.times.count;
    }
    enum pend_status status = pend_ensemble_new(&s->work, &problem, pend_isa_best(), error);
    if (status != PEND_OK) {
        api_member_range_free(range);
        return status;
    }
    pend_ensemble_begin(s->work, first, count);
    assert(api_member_range_valid(s));
    return PEND_OK;
}

void api_member_range_free(struct api_member_range **range) {
    assert(!*range || !(*range)->work || api_member_range_valid(*range));
    if (*range) pend_ensemble_free(&(*range)->work);
    free(*range);
    *range = NULL;
}

enum pend_status api_member_range_go(struct api_member_range *range, int *done) {
    assert(api_member_range_valid(range));
    enum pend_status status = pend_ensemble_go(range->work, range->slice, done);
    assert(api_member_range_valid(range));
    return status;
}

struct api_member_range_stats api_member_range_stats(const struct api_member_range *range) {
    assert(api_member_range_valid(range));
    return range->stats;
}

enum pend_status api_ensemble_write(const struct api_ensemble *e, struct api_writer *writer,
                                    long rows, const double raw[], struct api_buffer *out,
                                    struct pend_error *error) {
    assert(api_writer_valid(writer) && rows >= 0);
    const struct api_table *table = &e->seen.table;
    const double *data[API_COLUMNS];
    double *block = malloc((size_t)(rows * e->numbers) * sizeof *block + 1), *at = block;
    if (!block) return PEND_NO_MEMORY;
    long offset = 0;
    for (int c = 0; c < table->count; c++) {
        long width = api_column_numbers(&table->column[c]);
        data[c] = at;
        for (long i = 0; i < rows; i++, at += width)
            memcpy(at, raw + i * e->numbers + offset, (size_t)width * sizeof *at);
        offset += width;
    }
    enum pend_status status = api_writer_block(writer, rows, data, out, error);
    free(block);
    return status;
}

#include "api/op/ensemble/ensemble.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/ensemble/member_events.h"
#include "api/op/ensemble/picture_json.h"
#include "api/op/form_json.h"
#include "core/ensemble/ensemble_alone.h"
#include "core/integrate/pieces/control.h"
#include "core/integrate/pieces/pieces.h"

static const char *const fields[] = {
    "pendulum",    "initial", "states",      "members", "grid",   "random", "energy",
    "duration",    "times",   "observables", "output",  "method", "rtol",   "atol",
    "digits",      "picture", "accuracy",    "time",    "start",  "events", "rows",
    "derivatives", "columns", "number",      "none",    "within", NULL};

/* constants of the estimated cost: steps per radian of the fastest swing; s per arm and squared
 * order; s per number; time of a member computed alone, relative to one in lanes */
static const double steps_a_radian = 6, pair_seconds = 0.15e-9, number_seconds = 20e-9, alone = 8;

/* the most doubles in one member's raw rows, which limits the memory of a range */
static const double member_numbers = 1 << 24;

void api_ensemble_free(struct api_ensemble **ensemble) {
    struct api_ensemble *e = *ensemble;
    if (!e) return;
    free(e->instants);
    api_times_clear(&e->times);
    api_members_clear(&e->members);
    api_derived_clear(&e->derived);
    api_tree_clear(&e->tree);
    free(e);
    *ensemble = NULL;
}

/* ---- reading */

static void read_method(struct api_ensemble *e, const struct api_reading *reading) {
    static const char *const methods[] = {"taylor", NULL};
    const struct pend_method *taylor = &pend_method_taylor;
    struct api_value method = api_value_member(reading->root, "method");
    struct api_value rtol = api_value_member(reading->root, "rtol"),
                     atol = api_value_member(reading->root, "atol");
    int chosen = 0;
    const char *word = api_value_text(&method);
    if (word && !strcmp(word, pend_method_radau.name))
        api_value_fault(&method, reading->problem,
                        API_CODE_UNSUPPORTED
                        "\"radau\" computes one motion at a time, by POST /v1/trajectories: leave "
                        "it out, or ask for each member there");
    else if (api_field_word(&method, methods, &chosen, reading->problem) > 0)
        api_value_usual(&method);
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

static enum pend_status read_time(struct api_ensemble *e, const struct api_reading *reading) {
    struct api_value duration = api_value_member(reading->root, "duration");
    struct api_value times = api_value_member(reading->root, "times");
    struct api_problem *problem = reading->problem;
    struct api_value start = api_field_renamed(reading->root, "time", "start", problem);
    int rows = e->seen.wanted >> API_SEE_TRAJECTORY & 1;
    if (!rows) {
        if (api_value_kind(&times) != API_MISSING)
            api_value_fault(&times, problem,
                            API_CODE_NOT_APPLICABLE
                            "is only for the observable \"trajectory\": give a \"duration\"");
        if (api_field_needed(&duration, problem) &&
            api_value_read_number(&duration, 0, 1e9, "s", &e->duration, problem) > 0 &&
            e->duration == 0)
            api_value_fault(&duration, problem, API_CODE_OUT_OF_RANGE "must be greater than 0");
        (void)api_value_read_number(&start, -1e9, 1e9, "s", &e->origin, problem);
        api_value_usual_number(&start, 0);
        return PEND_OK;
    }
    if (api_value_kind(&start) != API_MISSING)
        api_value_fault(&start, problem,
                        API_CODE_CONFLICT
                        "cannot be combined with \"times\": members start at the first time");
    if (api_value_kind(&duration) != API_MISSING)
        api_value_fault(&duration, problem,
                        API_CODE_CONFLICT
                        "cannot be combined with \"times\", which set the length of a trajectory");
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

static void set_columns(struct api_ensemble *e) {
    struct api_table *table = &e->seen.table;
    if (e->events.rows)
        table->rows_later = 1;
    else
        api_observables_columns(&e->seen, e->tree.n, &e->members);
    e->events_at = (long)api_table_numbers(table, 0);
    if (e->events.count) api_member_events_columns(&e->events, table);
    e->derived_at = (long)api_table_numbers(table, 0);
}

/* marks numbers that may be missing: for a failed member all except its number, status and
 * instants; and times of events that never happen */
static void set_gaps(struct api_table *table) {
    static const char *const known[] = {"member", "status", "t"};
    for (int c = 0; c < table->count; c++) {
        int is_known = 0;
        for (size_t i = 0; i < sizeof known / sizeof *known; i++)
            is_known |= !strcmp(table->column[c].name, known[i]);
        table->column[c].sparse = !is_known;
    }
}

/* adds the columns of derivatives; adds an error if no observable has derivatives */
static void set_derived(struct api_ensemble *e, const struct api_reading *reading) {
    struct api_value list = api_value_member(reading->root, "derivatives");
    struct api_problem *problem = reading->problem;
    if (!e->derived.count) return;
    if (e->events.rows)
        api_value_fault(
            &list, problem,
            API_CODE_CONFLICT
            "cannot be combined with \"rows\": \"events\": passages have no derivatives");
    else if (e->events.stops)
        api_value_fault(&list, problem,
                        API_CODE_CONFLICT
                        "cannot be combined with conditions that stop a member, since its end "
                        "depends on the parameters: leave out \"stop\"");
    else if (!api_observables_derived(&e->seen, &e->derived))
        api_value_fault(&list, problem,
                        API_CODE_NOT_APPLICABLE "are only for the observables \"final\", \"cart\" "
                                                "and \"trajectory\": ask for one of them");
}

static void check_size(struct api_ensemble *e, const struct api_reading *reading) {
    const struct api_limits *limits = reading->limits;
    struct api_table *table = &e->seen.table;
    double rows = (double)e->members.count * (double)api_ensemble_rows(e);
    int trajectory = e->instants != NULL;
    if (trajectory && rows > limits->samples) {
        api_value_fault(
            reading->root, reading->problem,
            API_CODE_LIMIT
            "asks for %.15g rows, instants times members, more than the limit %s of %.0f: ask for "
            "fewer of either at a time",
            rows, api_limits_name(limits, &limits->samples), limits->samples);
        return;
    }
    if ((double)api_ensemble_rows(e) * (double)e->numbers > member_numbers) {
        api_value_fault(reading->root, reading->problem,
                        API_CODE_LIMIT
                        "asks for %.15g numbers for each member, more than the %.0f "
                        "that an ensemble stores for one: ask for fewer instants or "
                        "passages, or request each member separately as a trajectory",
                        (double)api_ensemble_rows(e) * (double)e->numbers, member_numbers);
        return;
    }
    table->rows = (long)rows;
    api_reading_check_size(reading, table, reading->root, "rows",
                           e->events.rows ? "fewer members, or fewer passages of each condition by "
                                            "\"count\""
                                          : "fewer members or observables");
    double cost = api_ensemble_cost(e, e->members.count);
    if (cost > limits->compute_seconds)
        api_value_fault(
            reading->root, reading->problem,
            API_CODE_LIMIT "would take about %.3g s, more than the limit %s of %.0f: ask for fewer "
                           "members, a shorter time or a looser tolerance at a time",
            cost, api_limits_name(limits, &limits->compute_seconds), limits->compute_seconds);
}

static void check_cart(const struct api_ensemble *e, const struct api_reading *reading) {
    const char *name = e->instants ? "output" : "observables";
    struct api_value list = api_value_member(reading->root, name);
    if (e->tree.cart || !api_observables_cart(&e->seen)) return;
    api_value_fault(&list, reading->problem,
                    API_CODE_NOT_APPLICABLE
                    "has \"cart\", but the pendulum has no cart: give one in \"pivot\"");
}

/* whether a name selects a column; both "final" and "final_phi" do */
static int is_named(const struct api_column *column, const char *name) {
    size_t bytes = strlen(column->name);
    if (strncmp(name, column->name, bytes) != 0) return 0;
    if (!name[bytes]) return 1;
    return name[bytes] == '_' && column->part && !strcmp(name + bytes + 1, column->part);
}

/* marks the columns that a name selects; adds an error if there are none */
static void choose_named(const struct api_table *table, const struct api_value *name,
                         char chosen[API_COLUMNS], struct api_problem *problem) {
    char all[API_COLUMNS_TEXT];
    const char *text = api_value_text(name);
    int found = 0;
    for (int c = 0; text && c < table->count; c++)
        if (is_named(&table->column[c], text)) chosen[c] = 1, found = 1;
    if (found) return;
    api_table_columns(table, all);
    api_value_fault(name, problem,
                    API_CODE_UNKNOWN_NAME "is not a column of this answer, which has %.160s", all);
}

/* keeps the requested columns, or all, and notes their positions in raw rows */
static void choose_columns(struct api_ensemble *e, const struct api_reading *reading) {
    struct api_value list = api_value_member(reading->root, "columns");
    struct api_table *table = &e->seen.table;
    char chosen[API_COLUMNS] = {0};
    int all = api_value_kind(&list) == API_MISSING, count = table->count;
    long offset = 0;
    e->numbers = (long)api_table_numbers(table, 0);
    if (!all && (api_value_kind(&list) != API_ARRAY || !api_value_count(&list)))
        api_value_fault(&list, reading->problem,
                        API_CODE_WRONG_COUNT "must be an array of at least one name of a column");
    if (!all && table->picture.across)
        api_value_fault(&list, reading->problem,
                        API_CODE_CONFLICT "cannot be combined with a picture: leave them out");
    if (reading->problem->status) return;
    struct api_value name = api_value_item(&list, 0);
    for (; !all && api_value_kind(&name) != API_MISSING; name = api_value_next(&name))
        choose_named(table, &name, chosen, reading->problem);
    table->count = 0;
    for (int c = 0; c < count; c++) {
        struct api_column column = table->column[c];
        if (all || chosen[c]) {
            e->offset[table->count] = offset;
            table->column[table->count++] = column;
        }
        offset += api_column_numbers(&column);
    }
}

/* adds errors for requests that motions in pieces do not support: derivatives and horizons across
 * jumps, settling without a target */
static void check_pieces(const struct api_ensemble *e, const struct api_reading *reading) {
    const struct api_value *root = reading->root, *seen = API_MEMBER(root, "observables");
    const struct pend_rules *rules = e->tree.rules;
    struct pend_ensemble_problem problem = {.loads = e->tree.loads, .duration = e->duration};
    struct pend_error error;
    if (e->seen.wanted >> API_SEE_SETTLED & 1 &&
        !(rules && rules->controllers && pend_control_last(rules, 0)->kind == PEND_LAW_FEEDBACK))
        api_value_fault(
            seen, reading->problem,
            API_CODE_NOT_APPLICABLE
            "has \"settled\", which needs a controller that ends in a \"feedback\": its "
            "reference is the target");
    if (!rules) return;
    api_observables_ask(&e->seen, &problem);
    problem.accuracy = e->seen.wanted >> API_SEE_HORIZON & 1;
    if (pend_ensemble_alone_check(&problem, &error) != PEND_OK)
        api_value_fault(seen, reading->problem, API_CODE_UNSUPPORTED "%s", error.text);
    if (e->derived.count &&
        pend_pieces_check_smooth(e->tree.terms, "derivatives", &error) != PEND_OK)
        api_value_fault(API_MEMBER(root, "derivatives"), reading->problem,
                        API_CODE_UNSUPPORTED "%s", error.text);
    if (pend_rules_check(rules, e->tree.tree->order, e->origin, e->origin + e->duration, &error))
        api_value_fault(API_MEMBER(root, "pendulum"), reading->problem, API_CODE_UNSUPPORTED "%s",
                        error.text);
}

static enum pend_status read_parts(struct api_ensemble *e, const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    const struct api_value *root = reading->root;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &e->tree);
    if (status == PEND_NO_MEMORY) return status;
    api_observables_read(&e->seen, root, problem);
    api_member_events_read(&e->events, reading, &e->tree, e->seen.wanted >> API_SEE_TRAJECTORY & 1);
    PEND_TRY(read_time(e, reading));
    read_method(e, reading);
    api_form_read(&e->seen.table, root, problem);
    status = api_members_read(&e->members, root, &e->tree, reading->limits, problem);
    if (status == PEND_NO_MEMORY) return status;
    status = api_derived_read(&e->derived, API_MEMBER(root, "derivatives"), &e->tree, problem);
    if (status == PEND_NO_MEMORY) return status;
    if (problem->status) return PEND_INVALID;
    check_cart(e, reading);
    check_pieces(e, reading);
    if (problem->status) return PEND_INVALID;
    set_columns(e);
    set_derived(e, reading);
    set_gaps(&e->seen.table);
    api_picture_read(&e->seen, &e->members, &e->tree, reading);
    if (!problem->status) choose_columns(e, reading);
    if (!problem->status) check_size(e, reading);
    return problem->status ? PEND_INVALID : PEND_OK;
}

enum pend_status api_ensemble_new(struct api_ensemble **ensemble,
                                  const struct api_reading *reading) {
    struct api_ensemble *e = *ensemble = calloc(1, sizeof *e);
    if (!e) return PEND_NO_MEMORY;
    // one of many members may use at most a hundredth of all steps
    e->step_cap = (long)(reading->limits->steps / 100);
    enum pend_status status = read_parts(e, reading);
    if (status != PEND_OK) api_ensemble_free(ensemble);
    return status;
}

/* ---- properties */

long api_ensemble_count(const struct api_ensemble *e) { return e->members.count; }

long api_ensemble_rows(const struct api_ensemble *e) {
    if (e->events.rows) return (long)fmin(api_member_events_most(&e->events), 1e15);
    return e->instants ? e->times.times.count : 1;
}

long api_ensemble_numbers(const struct api_ensemble *e) { return e->numbers; }

double api_ensemble_cost(const struct api_ensemble *e, long members) {
    assert(members >= 0 && e->tree.tree);
    const struct pend_tree *tree = e->tree.tree;
    double shortest = INFINITY, order = 4 - 0.65 * log(fmax(0.01 * e->rtol, 1e-16));
    for (int k = 0; k < tree->n; k++) shortest = fmin(shortest, tree->len[k]);
    double rate = sqrt(fabs(e->tree.loads.gravity) / shortest) + api_terms_pace(&e->tree);
    double radians = fabs(e->duration) * rate;
    double steps = 1 + steps_a_radian * radians * 28 / order;
    struct pend_ensemble_problem problem = {.until = PEND_UNTIL_TIME};
    api_observables_ask(&e->seen, &problem);
    // many members end early or are skipped; a neighbour doubles the time
    if (problem.until != PEND_UNTIL_TIME) steps *= 0.3;
    if (problem.observe & PEND_OBSERVE_LYAPUNOV) steps *= 2;
    steps += pend_rules_pieces(e->tree.rules, tree->n, e->duration, rate);
    if (!pend_pieces_smooth(e->tree.terms)) steps *= alone;
    if (e->events.count && problem.until != PEND_UNTIL_TIME) steps /= 0.3;
    double numbers = (double)api_ensemble_rows(e) * (double)e->numbers;
    double search = steps * api_member_events_cost(&e->events);
    // the number of passages is unknown; each takes a microsecond
    if (e->events.rows) numbers = 0;
    if (e->instants)
        search += (double)api_ensemble_rows(e) * api_member_outputs_cost(e->seen.output, &e->tree);
    return (double)members *
           (search + api_derived_seconds(&e->derived, &e->tree, radians) +
            steps * tree->n * order * order * pair_seconds + numbers * number_seconds);
}

double api_ensemble_bytes(const struct api_ensemble *e) {
    double n = api_tree_stored(&e->tree),
           list = e->instants ? 2.0 * (double)e->times.times.count * sizeof(double) : 0;
    double varied = api_members_bytes(&e->members);
    // numbers of terms for each lane, and additional series; both also for a neighbour
    if (e->tree.loads.terms) varied += 16 * sizeof(double) * e->tree.loads.terms->count;
    double arm_bytes = e->tree.loads.terms ? 58000 : 22000;
    if (e->instants) varied += api_member_samples_bytes(&e->tree);
    if (e->events.count) varied += api_member_events_bytes(&e->events);
    if (e->events.rows) varied += (double)API_ENSEMBLE_RANGE * sizeof(long);
    long rows = e->instants ? api_ensemble_rows(e) : 2; // with derivatives, the first included
    if (e->derived.count) varied += api_member_derived_bytes(&e->derived, &e->tree, rows);
    return 32768 + (n + 16) * arm_bytes + list + varied + api_tree_bytes(&e->tree) +
           api_states_bytes(e->members.states);
}

enum pend_status api_ensemble_prepare(struct api_ensemble *e, struct pend_error *error) {
    assert(api_states_valid(e->members.states));
    return api_states_settle(e->members.states, &e->tree, error);
}

enum pend_status api_ensemble_write(const struct api_ensemble *e, struct api_writer *writer,
                                    long rows, const double raw[], struct api_buffer *out,
                                    struct pend_error *error) {
    assert(api_writer_valid(writer) && rows >= 0);
    const struct api_table *table = &e->seen.table;
    const double *data[API_COLUMNS];
    double *block = malloc((size_t)(rows * e->numbers) * sizeof *block + 1), *at = block;
    if (!block) return PEND_NO_MEMORY;
    for (int c = 0; c < table->count; c++) {
        long width = api_column_numbers(&table->column[c]);
        data[c] = at;
        for (long i = 0; i < rows; i++, at += width)
            memcpy(at, raw + i * e->numbers + e->offset[c], (size_t)width * sizeof *at);
    }
    enum pend_status status = api_writer_block(writer, rows, data, out, error);
    free(block);
    return status;
}

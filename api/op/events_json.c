#include "api/op/events_json.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "api/json/json_out.h"
#include "core/integrate/pieces/pieces.h"
#include "core/tree/rules.h"
#include "core/tree/turns.h"

enum {
    T,
    EVENT,
    DIRECTION,
    PHI,
    PHID,
    CART_X,
    CART_V,
    COUNT_USUAL = 1000,
    FIRST_ROOM = 64,
    PIECE = 50000
};

static const char *const condition_fields[] = {"of",   "arm",       "to",    "value", "bound",
                                               "unit", "direction", "count", "stop",  NULL};
static const char *const quantities[] = {"phi",    "theta",  "phid",     "thetad",  "lambda",
                                         "x",      "y",      "distance", "kinetic", "potential",
                                         "energy", "impact", NULL};
static const enum pend_quantity meanings[] = {
    PEND_QUANTITY_PHI,     PEND_QUANTITY_THETA,     PEND_QUANTITY_RATE,   PEND_QUANTITY_RATE,
    PEND_QUANTITY_FORCE,   PEND_QUANTITY_X,         PEND_QUANTITY_Y,      PEND_QUANTITY_DISTANCE,
    PEND_QUANTITY_KINETIC, PEND_QUANTITY_POTENTIAL, PEND_QUANTITY_ENERGY, PEND_QUANTITY_IMPACT};

/* the most arms whose positions are computed, some 20 ms per step; the cost of one relative to that
 * of an arm in a step */
static const double followed_most = 20000, followed_times = 6;

static const double value_most = 1e15;

static int present(const struct api_value *value) { return api_value_kind(value) != API_MISSING; }

/* ---- reading */

static void read_arms(const struct api_events *events, struct pend_event *event,
                      const struct api_value *value, struct api_problem *problem) {
    struct api_value arm = api_value_member(value, "arm"), to = api_value_member(value, "to");
    int whole = pend_quantity_energy(event->quantity);
    int both = event->quantity == PEND_QUANTITY_DISTANCE;
    if (whole && present(&arm))
        api_value_fault(&arm, problem,
                        API_CODE_NOT_APPLICABLE
                        "has no meaning for an energy, which belongs to the whole pendulum");
    if (!both && present(&to))
        api_value_fault(&to, problem,
                        API_CODE_NOT_APPLICABLE
                        "is only for \"distance\": it names the other arm's tip");
    if (whole || !events->tree->tree) return;
    int first = api_tree_read_arm(events->tree, &arm, problem), second = first;
    if (both) second = api_tree_read_arm(events->tree, &to, problem);
    if (both && first >= 0 && first == second)
        api_value_fault(&to, problem, API_CODE_CONFLICT "must be another arm than \"arm\"");
    if (first >= 0) event->arm = events->tree->tree->place[first];
    if (second >= 0) event->other = events->tree->tree->place[second];
}

/* reads the level: a value, or a bound of the magnitude */
static void read_level(struct pend_event *event, const struct api_value *condition,
                       struct api_problem *problem) {
    struct api_value value = api_value_member(condition, "value");
    struct api_value bound = api_value_member(condition, "bound");
    struct api_value unit = api_value_member(condition, "unit");
    int degrees = 0, angle = event->quantity <= PEND_QUANTITY_RATE;
    double least = event->quantity == PEND_QUANTITY_DISTANCE ? 0 : -value_most;
    (void)api_field_word(&unit, api_field_angles, &degrees, problem);
    if (present(&unit) && !angle)
        api_value_fault(&unit, problem,
                        API_CODE_NOT_APPLICABLE "is only for angles and their rates: leave it out");
    if (present(&value) == present(&bound))
        api_value_fault(condition, problem,
                        API_CODE_CONFLICT "must have either \"value\", which the quantity passes, "
                                          "or \"bound\", which its absolute value passes");
    (void)api_value_read_number(&value, least, value_most, "", &event->level, problem);
    event->bound = present(&bound);
    if (api_value_read_number(&bound, 0, value_most, "", &event->level, problem) > 0 &&
        event->level == 0)
        api_value_fault(&bound, problem,
                        API_CODE_OUT_OF_RANGE
                        "must be greater than 0: an absolute value touches 0 without passing it. "
                        "Ask for \"value\": 0, which is passed up or down");
    if (degrees && angle) event->level *= M_PI / 180;
}

/* an impact needs a stop, and has no level */
static void read_impact(const struct api_events *events, const struct api_value *condition,
                        const struct pend_event *event, struct api_problem *problem) {
    static const char *const levels[] = {"value", "bound", "unit"};
    const struct pend_rules *rules = events->tree->rules;
    for (int i = 0; i < 3; i++) {
        struct api_value level = api_value_member(condition, levels[i]);
        if (present(&level))
            api_value_fault(&level, problem,
                            API_CODE_NOT_APPLICABLE "has no meaning for an impact: leave it out");
    }
    if (!problem->status && (!rules || !rules->least ||
                             (isinf(rules->least[event->arm]) && isinf(rules->most[event->arm]))))
        api_value_fault(condition, problem,
                        API_CODE_NOT_APPLICABLE "asks for impacts, but this arm has no \"stop\"");
}

static void read_condition(struct api_events *events, const struct api_value *value,
                           const struct api_limits *limits, struct api_problem *problem) {
    static const char *const words[] = {"both", "up", "down", NULL};
    static const unsigned ways[] = {PEND_WAY_UP | PEND_WAY_DOWN, PEND_WAY_UP, PEND_WAY_DOWN};
    struct api_value of = api_value_member(value, "of");
    struct pend_event *event = &events->event[events->count++];
    int quantity = 0, word = 0;
    *event = (struct pend_event){.most = events->usual};
    if (!api_field_object(value, condition_fields, problem)) return;
    if (!api_field_needed(&of, problem) || api_field_word(&of, quantities, &quantity, problem) < 0)
        return;
    event->quantity = meanings[quantity];
    read_arms(events, event, value, problem);
    if (event->quantity == PEND_QUANTITY_IMPACT)
        read_impact(events, value, event, problem);
    else
        read_level(event, value, problem);
    (void)api_field_word(API_MEMBER(value, "direction"), words, &word, problem);
    event->ways = ways[word];
    (void)api_field_whole(API_MEMBER(value, "count"), 1, (long)limits->samples, &event->most,
                          problem);
    (void)api_field_whole(API_MEMBER(value, "stop"), 1, (long)limits->samples, &event->stop,
                          problem);
    if (event->stop > event->most) event->most = event->stop;
    events->stops |= event->stop > 0;
}

/* adds errors for other fields that exclude conditions */
static void check_others(const struct api_events *events, const struct api_value *field,
                         const struct api_reading *reading, const struct api_states *start,
                         const struct api_method *method, int spans) {
    struct api_problem *problem = reading->problem;
    const struct api_value *root = reading->root;
    struct api_value initial = api_value_member(root, "initial");
    if (method->method && method->method != &pend_method_taylor)
        api_value_fault(
            field, problem,
            API_CODE_UNSUPPORTED
            "need the method taylor in double precision: leave \"method\" and \"precision\" out");
    if (!problem->status && !spans)
        api_value_fault(API_MEMBER(root, "times"), problem,
                        API_CODE_OUT_OF_RANGE "must span a time in which to search for events");
    for (int k = events->tree->cart; start && k < start->n; k++)
        if (fabs(start->phi[k]) > PEND_TURNS_FROM) {
            api_value_fault(&initial, problem,
                            API_CODE_OUT_OF_RANGE
                            "must not have angles beyond %g rad if there are events",
                            PEND_TURNS_FROM);
            break;
        }
    if (!events->rows && reading->format != &api_format_json)
        api_value_fault(field, problem,
                        API_CODE_UNSUPPORTED
                        "can be returned together with samples only in %s, and not by a job: ask "
                        "for events alone by \"rows\": \"events\"",
                        api_format_json.media_type);
}

/* adds errors for outputs that are not available if the rows are passages */
static void check_rows(const struct api_events *events, const struct api_value *rows,
                       const struct api_value *root, struct api_problem *problem) {
    static const char *const absent[] = {"output", "trust", "derivatives"};
    if (!events->count) {
        api_value_fault(rows, problem,
                        API_CODE_MISSING "needs \"events\", whose passages are the rows");
        return;
    }
    for (int i = 0; i < 3; i++) {
        struct api_value field = api_value_member(root, absent[i]);
        if (present(&field))
            api_value_fault(&field, problem,
                            API_CODE_CONFLICT
                            "cannot be combined with \"rows\": \"events\", whose columns are t, "
                            "event, direction, phi and phid: leave it out");
    }
}

static void check_size(const struct api_events *events, const struct api_value *field,
                       const struct api_limits *limits, struct api_problem *problem) {
    double numbers = 3 + 2.0 * api_tree_stored(events->tree), rows = 0;
    for (int i = 0; i < events->count; i++) rows += (double)events->event[i].most;
    if (8 * rows * numbers > limits->answer_bytes)
        api_value_fault(field, problem,
                        API_CODE_LIMIT
                        "may have %.0f passages of %d arms, %.0f bytes, more than the limit "
                        "max-answer-bytes of %.0f: ask for fewer by \"count\"",
                        rows, events->tree->n, 8 * rows * numbers, limits->answer_bytes);
}

/* counts the arms whose positions are computed: those on the path to each tip, and for energies all
 * of them, three times */
static void count_followed(struct api_events *events, const struct api_value *field,
                           struct api_problem *problem) {
    const struct pend_tree *tree = events->tree->tree;
    int energies = 0;
    for (int i = 0; i < events->count && tree; i++) {
        const struct pend_event *event = &events->event[i];
        int tips = event->quantity >= PEND_QUANTITY_X && event->quantity < PEND_QUANTITY_KINETIC;
        energies |= pend_quantity_energy(event->quantity);
        if (tips) events->followed += tree->depth[event->arm];
        if (event->quantity == PEND_QUANTITY_DISTANCE)
            events->followed += tree->depth[event->other];
    }
    if (energies && tree) events->followed += 3.0 * tree->n;
    if (events->followed > followed_most)
        api_value_fault(field, problem,
                        API_CODE_LIMIT
                        "need the positions of %.0f arms in each step, those between the pivot and "
                        "the named tips, but at most %.0f are possible: ask for fewer",
                        events->followed, followed_most);
}

void api_events_read_list(struct api_events *events, const struct api_value *field,
                          const struct api_limits *limits, struct api_problem *problem) {
    struct api_value item = api_value_item(field, 0);
    assert(events->usual >= 1 && !events->count);
    if (!present(field)) return;
    if (api_value_kind(field) != API_ARRAY || api_value_count(field) < 1 ||
        api_value_count(field) > API_EVENTS_MOST) {
        api_value_fault(field, problem,
                        API_CODE_WRONG_COUNT "must be an array of 1 to %d conditions",
                        API_EVENTS_MOST);
        return;
    }
    for (; present(&item); item = api_value_next(&item))
        read_condition(events, &item, limits, problem);
    count_followed(events, field, problem);
}

void api_events_read(struct api_events *events, const struct api_reading *reading,
                     const struct api_tree *tree, const struct api_states *start,
                     const struct api_method *method, const struct pend_times *times) {
    static const char *const words[] = {"instants", "events", NULL};
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value field = api_value_member(root, "events");
    struct api_value rows = api_value_member(root, "rows");
    *events =
        (struct api_events){.tree = tree,
                            .usual = COUNT_USUAL,
                            .step_cap = reading->limits->steps,
                            .step_name = api_limits_name(reading->limits, &reading->limits->steps)};
    if (api_field_word(&rows, words, &events->rows, problem) > 0 && !events->rows)
        api_value_usual(&rows);
    api_events_read_list(events, &field, reading->limits, problem);
    if (events->rows) check_rows(events, &rows, root, problem);
    if (!events->count) return;
    check_others(events, &field, reading, start, method, times->count > 1);
    check_size(events, &field, reading->limits, problem);
}

void api_events_clear(struct api_events *events) {
    pend_events_free(&events->search);
    for (int c = 0; c < API_EVENTS_COLUMNS; c++) free(events->column[c]);
    free(events->state);
}

/* ---- the search */

static enum pend_status events_begin(struct api_events *events, const struct api_states *start,
                                     const struct api_method *method,
                                     const struct pend_times *times, struct pend_error *error) {
    size_t n = (size_t)api_tree_stored(events->tree);
    double first = pend_times_at(times, 0);
    events->state = malloc(2 * n * sizeof(double));
    if (!events->state)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a state of %zu arms", n);
    const struct pend_events_problem problem = {.tree = events->tree->tree,
                                                .loads = events->tree->loads,
                                                .phi = start->phi,
                                                .rate = start->rate,
                                                .phi_low = start->phi_low,
                                                .rate_low = start->rate_low,
                                                .start = first,
                                                .duration =
                                                    pend_times_at(times, times->count - 1) - first,
                                                .rtol = method->rtol,
                                                .atol = method->atol,
                                                .accuracy = events->rows ? method->accuracy : 0,
                                                .count = events->count,
                                                .event = events->event};
    return pend_events_new(&events->search, &problem, error);
}

static enum pend_status events_grow(struct api_events *events, struct pend_error *error) {
    long room = events->room ? 2 * events->room : FIRST_ROOM;
    if (events->found < events->room) return PEND_OK;
    for (int c = 0; c < API_EVENTS_COLUMNS; c++) {
        size_t width = c == PHI || c == PHID ? (size_t)events->tree->n : 1;
        double *grown = realloc(events->column[c], (size_t)room * width * sizeof *grown);
        if (!grown)
            return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for %ld events", room);
        events->column[c] = grown;
    }
    events->room = room;
    return PEND_OK;
}

static enum pend_status events_keep(struct api_events *events, const struct pend_hit *hit,
                                    double first, struct pend_error *error) {
    int n = events->tree->n, cart = events->tree->cart;
    const int *order = events->tree->tree->order;
    const double *phi = events->state, *rate = phi + api_tree_stored(events->tree);
    PEND_TRY(events_grow(events, error));
    long row = events->found++;
    assert(events->found <= events->room);
    events->column[T][row] = first + hit->time;
    events->column[EVENT][row] = hit->event + 1;
    events->column[DIRECTION][row] = hit->way == PEND_WAY_UP ? 1 : -1;
    for (int k = cart; k < n + cart; k++) {
        events->column[PHI][row * n + order[k]] = phi[k];
        events->column[PHID][row * n + order[k]] = rate[k];
    }
    events->column[CART_X][row] = cart ? phi[0] : 0;
    events->column[CART_V][row] = cart ? rate[0] : 0;
    return PEND_OK;
}

/* removes the instants after the one at which a condition ended the motion */
static void events_cut(const struct api_events *events, struct pend_times *times) {
    double first = pend_times_at(times, 0), stopped = pend_events_stopped(events->search);
    long good = 1, bad = times->count;
    if (isnan(stopped)) return;
    // instants from `bad` on are after the end of the motion
    while (bad - good > 0) {
        long middle = good + (bad - good) / 2;
        if (fabs(pend_times_at(times, middle) - first) <= fabs(stopped))
            good = middle + 1;
        else
            bad = middle;
    }
    times->count = good;
}

/* searches for the next passages, as many as one piece of work yields */
static enum pend_status events_next(struct api_events *events, double first,
                                    struct pend_error *error) {
    double arms = events->tree->n * api_events_times(events) + 2.0 * events->count;
    long most = (long)(PIECE / 16 / arms);
    enum pend_found found;
    struct pend_hit hit;
    PEND_TRY(pend_events_next(events->search, most > 0 ? most : 1, &found, &hit, events->state,
                              events->state + api_tree_stored(events->tree), error));
    if (found == PEND_FOUND_PASSAGE) PEND_TRY(events_keep(events, &hit, first, error));
    events->searched = found == PEND_FOUND_END;
    if ((double)pend_events_steps(events->search) <= events->step_cap) return PEND_OK;
    return pend_fail(error, PEND_TOO_MANY_STEPS, -1, 0,
                     "more steps than the limit %s of %.0f: ask for a shorter time",
                     events->step_name, events->step_cap);
}

enum pend_status api_events_look(struct api_events *events, const struct api_states *start,
                                 const struct api_method *method, struct pend_times *times,
                                 const struct api_turn *turn, struct pend_error *error) {
    double first = pend_times_at(times, 0);
    if (!events->search) PEND_TRY(events_begin(events, start, method, times, error));
    do PEND_TRY(events_next(events, first, error));
    while (!events->searched && !api_turn_over(turn) && events->found < events->room);
    if (events->searched) events_cut(events, times);
    return PEND_OK;
}

/* ---- results */

void api_events_columns(const struct api_events *events, struct api_table *table) {
    assert(events->count <= API_EVENTS_MOST);
    if (events->rows || events->stops) table->rows_later = 1;
    if (!events->rows) return;
    table->count = 0;
    table->rows = 0;
    api_table_add(table, "t", NULL, 0);
    api_table_add(table, "event", NULL, 0);
    api_table_add(table, "direction", NULL, 0);
    api_table_add(table, "phi", NULL, events->tree->n);
    api_table_add(table, "phid", NULL, events->tree->n);
    if (events->tree->cart) {
        api_table_add(table, "cart", "x", 0);
        api_table_add(table, "cart", "v", 0);
    }
    for (int i = 0; i < events->count; i++) table->rows += events->event[i].most;
}

/* adds the number of passages and their horizon, with a warning if that is before the end */
static void events_tell_horizon(struct api_events *events, const struct pend_times *times,
                                struct api_stats *stats) {
    double first = pend_times_at(times, 0), held = pend_events_held(events->search);
    double span = pend_times_at(times, times->count - 1) - first,
           stopped = pend_events_stopped(events->search),
           end = isnan(stopped) ? pend_events_progress(events->search) * span : stopped;
    const char *unknown = pend_pieces_unestimated(events->tree->terms);
    long holding = 0;
    if (unknown) api_stats_text(stats, "no_horizon", unknown);
    if (isnan(held)) return;
    while (holding < events->found && fabs(events->column[T][holding] - first) <= fabs(held))
        holding++;
    api_stats_number(stats, "horizon", first + held);
    api_stats_whole(stats, "holding", holding);
    if (fabs(held) >= fabs(end) * (1 - 1e-12)) return;
    snprintf(events->warning, sizeof events->warning,
             "accuracy is lost before the end: after t = %.6g s the errors of the motion may "
             "exceed the requested accuracy (estimated). Only the first %ld passages are certain. "
             "A smaller rtol extends this.",
             first + held, holding);
    api_stats_warning(stats, "warning_horizon", events->warning);
}

void api_events_tell(struct api_events *events, const struct pend_times *times,
                     struct api_stats *stats) {
    double stopped = pend_events_stopped(events->search);
    api_stats_whole(stats, "events", events->found);
    if (events->rows) api_stats_whole(stats, "steps", pend_events_steps(events->search));
    if (events->rows) events_tell_horizon(events, times, stats);
    if (!isnan(stopped)) api_stats_number(stats, "stopped", pend_times_at(times, 0) + stopped);
}

enum pend_status api_events_append(const struct api_events *events, int digits,
                                   struct api_buffer *out) {
    int n = events->tree->n;
    if (!events->count) return PEND_OK;
    assert(out->bytes && out->data[out->bytes - 1] == '}');
    out->data[out->bytes - 1] = ',';
    PEND_TRY(api_out_open(out, "events", '['));
    for (long i = 0; i < events->found; i++) {
        PEND_TRY(api_buffer_text(out, i ? ",{" : "{"));
        PEND_TRY(api_out_whole(out, "event", (long)events->column[EVENT][i]));
        PEND_TRY(api_out_number(out, "t", events->column[T][i], digits));
        PEND_TRY(api_out_text(out, "direction", events->column[DIRECTION][i] > 0 ? "up" : "down"));
        PEND_TRY(api_out_numbers(out, "phi", n, events->column[PHI] + i * n, digits));
        PEND_TRY(api_out_numbers(out, "phid", n, events->column[PHID] + i * n, digits));
        if (events->tree->cart) {
            PEND_TRY(api_out_open(out, "cart", '{'));
            PEND_TRY(api_out_number(out, "x", events->column[CART_X][i], digits));
            PEND_TRY(api_out_number(out, "v", events->column[CART_V][i], digits));
            PEND_TRY(api_buffer_text(out, "}"));
        }
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "]}");
}

enum pend_status api_events_write(struct api_events *events, const struct pend_times *times,
                                  struct api_writer *writer, struct api_stats *stats,
                                  const struct api_turn *turn, int *done,
                                  struct pend_error *error) {
    assert(events->searched && events->rows);
    if (!stats->count) {
        api_events_tell(events, times, stats);
        api_turn_tell(turn, 0, stats);
        if (events->found)
            PEND_TRY(api_writer_block(writer, events->found, (const double *const *)events->column,
                                      turn->out, error));
    }
    do PEND_TRY(api_writer_finish(writer, stats, turn->out, done));
    while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

double api_events_times(const struct api_events *events) {
    if (!events->count) return 0;
    return 2 + followed_times * events->followed / events->tree->n;
}

double api_events_bytes(const struct api_events *events) {
    double n = events->tree ? api_tree_stored(events->tree) : 0, room = (double)events->room;
    if (!events->count) return 0;
    // memory grows at most once per turn, during which the old and the new block exist
    room = 3 * fmax(room, FIRST_ROOM);
    return sizeof(double) * ((5 + 2 * n) * room + 2 * n + 90 * n * (events->count > 0)) + 40000.0 +
           90.0 * 64 * events->count;
}

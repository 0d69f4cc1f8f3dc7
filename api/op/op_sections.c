/* POST /v1/sections: the instants at which an arm passes a direction, or that are one drive period
 * apart, with the states at these instants.
 * Leaves to others: reading (tree_json, state_json), the search (core/integrate/events/section),
 * the bytes (encode).
 * Invariant: all passages are found before the first is written, so that the head of the answer
 * contains their number. */
#include "api/op/op.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "api/op/derived.h"
#include "api/read/method_json.h"
#include "api/read/state_json.h"
#include "core/integrate/events/section.h"
#include "core/integrate/pieces/pieces.h"
#include "core/tree/rules.h"
#include "core/tree/turns.h"

static const char *const fields[] = {"pendulum", "initial",  "section", "time",
                                     "start",    "duration", "count",   "rtol",
                                     "accuracy", "digits",   NULL};
static const char *const arm_fields[] = {"arm", "theta", "phi", "unit", "direction", NULL};
static const char *const section_fields[] = {"arm",       "theta",  "phi",   "unit",
                                             "direction", "period", "first", NULL};

enum { T, PHI, PHID, COLUMNS = 6, COUNT_USUAL = 1000, FIRST_ROOM = 256, PIECE = 50000 };

static const double duration_most = 1e9, angle_most = 1e6;

/* s, shortest period of a stroboscopic section; most periods in the searched time, whose number
 * must be exact as a double */
static const double period_least = 1e-9, periods_most = 1e15;

/* constants of the estimated cost: steps per radian of the fastest swing, s per step and arm */
static const double steps_a_radian = 4, arm_seconds = 2e-6;

struct sections {
    struct api_tree tree;
    struct api_states *start;
    double origin, duration; /* s; origin: the start in the time of drives */
    double angle, angle_low, rtol, accuracy;
    double period, first; /* s, of a stroboscopic section; period 0 = a section at an arm's angle */
    int arm;              /* stored number of the arm */
    unsigned ways;
    struct api_table table;
    int direction, cart; /* indices of the columns direction and cart, if present */
    const struct api_format *format;
    double step_cap;
    const char *step_name; /* name of the limit on steps */

    /* set while it runs */
    struct pend_section *section;
    struct api_writer *writer;
    long count, room; /* number of passages found; capacity */
    double *column[COLUMNS];
    double *state; /* 2 n numbers, stored order */
    int found_all;
    double until;
    struct api_stats stats;
    char warning[API_WARNING_TEXT];
};

static void sections_clear(void *state) {
    struct sections *sections = state;
    for (int c = 0; c < COLUMNS; c++) free(sections->column[c]);
    free(sections->state);
    api_writer_free(&sections->writer);
    pend_section_free(&sections->section);
    api_states_free(&sections->start);
    api_tree_clear(&sections->tree);
}

/* --- reading --- */

/* reads the angle of the section, as phi in rad */
static void sections_read_angle(struct sections *sections, const struct api_value *section,
                                struct api_problem *problem) {
    struct api_value theta = api_value_member(section, "theta"),
                     phi = api_value_member(section, "phi");
    int degrees = 0, from_theta = api_value_kind(&theta) != API_MISSING;
    double angle = 0;
    (void)api_field_word(API_MEMBER(section, "unit"), api_field_angles, &degrees, problem);
    if (from_theta && api_value_kind(&phi) != API_MISSING)
        api_value_fault(&phi, problem,
                        API_CODE_CONFLICT "cannot be combined with \"theta\": give one of the two");
    if (!from_theta && api_value_kind(&phi) == API_MISSING)
        api_value_fault(section, problem,
                        API_CODE_MISSING "needs the angle of the section: \"theta\" or \"phi\"");
    (void)api_value_read_number(&theta, -angle_most, angle_most, "", &angle, problem);
    (void)api_value_read_number(&phi, -angle_most, angle_most, "", &angle, problem);
    angle *= degrees ? M_PI / 180 : 1;
    struct pend_sum hanging = pend_turns_hanging(angle);
    sections->angle = from_theta ? hanging.high : angle;
    sections->angle_low = from_theta ? hanging.low : 0;
}

static void sections_drive_period(struct sections *sections, const struct api_value *period,
                                  struct api_problem *problem) {
    const struct pend_loads *loads = &sections->tree.loads;
    double omega = 0, other = 0;
    for (int i = 0; loads->terms && i < loads->terms->harmonics; i++) {
        const double *harmonic = loads->value + loads->terms->harmonic[i].at;
        double own = fabs(harmonic[1]);
        if (harmonic[0] == 0 || own == 0 || own == omega) continue;
        *(omega == 0 ? &omega : &other) = own;
    }
    if (other > 0)
        api_value_fault(
            period, problem,
            API_CODE_CONFLICT
            "is unknown: the drives have no common period (angular frequencies %.17g and "
            "%.17g rad/s); give the period in seconds",
            omega, other);
    else if (omega > 0)
        sections->period = 2 * M_PI / omega;
    else
        api_value_fault(period, problem,
                        API_CODE_NOT_APPLICABLE "is unknown: the pendulum has no periodic drive; "
                                                "give the period in seconds");
}

static void sections_read_period(struct sections *sections, const struct api_value *section,
                                 struct api_problem *problem) {
    struct api_value period = api_value_member(section, "period"),
                     first = api_value_member(section, "first");
    const char *text = api_value_text(&period);
    for (int i = 0; arm_fields[i]; i++) {
        struct api_value field = api_value_member(section, arm_fields[i]);
        if (api_value_kind(&field) != API_MISSING)
            api_value_fault(&field, problem,
                            API_CODE_CONFLICT
                            "cannot be combined with a period: a section is taken either when an "
                            "arm passes a direction, or stroboscopically");
    }
    (void)api_value_read_number(&first, -duration_most, duration_most, "s", &sections->first,
                                problem);
    api_value_usual_number(&first, 0);
    if (!api_field_needed(&period, problem)) return;
    if (text && strcmp(text, "drive") != 0)
        api_value_fault(
            &period, problem,
            API_CODE_WRONG_TYPE "must be a number of seconds, or \"drive\", got \"%.40s\"", text);
    else if (text && sections->tree.tree)
        sections_drive_period(sections, &period, problem);
    else if (!text)
        (void)api_value_read_number(&period, period_least, duration_most, "s", &sections->period,
                                    problem);
}

static void sections_read_section(struct sections *sections, const struct api_value *section,
                                  struct api_problem *problem) {
    static const char *const words[] = {"up", "down", "both", NULL};
    static const unsigned ways[] = {PEND_WAY_UP, PEND_WAY_DOWN, PEND_WAY_UP | PEND_WAY_DOWN};
    int word = 0;
    if (!api_field_object(section, section_fields, problem)) return;
    if (api_value_kind(API_MEMBER(section, "period")) != API_MISSING ||
        api_value_kind(API_MEMBER(section, "first")) != API_MISSING) {
        sections_read_period(sections, section, problem);
        return;
    }
    int caller = api_tree_read_arm(&sections->tree, API_MEMBER(section, "arm"), problem);
    if (caller >= 0) sections->arm = sections->tree.tree->place[caller];
    sections_read_angle(sections, section, problem);
    (void)api_field_word(API_MEMBER(section, "direction"), words, &word, problem);
    sections->ways = ways[word];
}

static void sections_read_time(struct sections *sections, const struct api_value *root,
                               struct api_problem *problem) {
    struct api_value duration = api_value_member(root, "duration"),
                     start = api_field_renamed(root, "time", "start", problem);
    (void)api_value_read_number(&start, -duration_most, duration_most, "s", &sections->origin,
                                problem);
    api_value_usual_number(&start, 0);
    if (api_field_needed(&duration, problem))
        (void)api_value_read_number(&duration, 1e-9, duration_most, "s", &sections->duration,
                                    problem);
    double span = sections->duration + fabs(sections->first - sections->origin);
    if (span > periods_most * sections->period && sections->period > 0)
        api_value_fault(API_MEMBER(API_MEMBER(root, "section"), "period"), problem,
                        API_CODE_LIMIT "is too short for %.6g s: at most %.0e periods are possible",
                        span, periods_most);
}

static enum pend_status sections_check_size(struct sections *sections,
                                            const struct api_reading *reading) {
    struct api_table *table = &sections->table;
    int n = sections->tree.n;
    api_table_add(table, "t", NULL, 0);
    api_table_add(table, "phi", NULL, n);
    api_table_add(table, "phid", NULL, n);
    if (sections->period == 0) {
        sections->direction = table->count;
        api_table_add(table, "direction", NULL, 0);
    }
    if (sections->tree.cart) {
        sections->cart = table->count;
        api_table_add(table, "cart", "x", 0);
        api_table_add(table, "cart", "v", 0);
    }
    api_reading_check_kept(reading, table, API_MEMBER(reading->root, "count"), n, "passages",
                           "fewer");
    return reading->problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status sections_read(void *state, const struct api_reading *reading) {
    struct sections *sections = state;
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    double most = reading->limits->samples;
    long rounded = 0, rows = most < COUNT_USUAL ? (long)most : COUNT_USUAL;
    sections->format = reading->format;
    sections->step_cap = reading->limits->steps;
    sections->step_name = api_limits_name(reading->limits, &reading->limits->steps);
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &sections->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK)
        PEND_TRY(api_states_new(&sections->start, 1, api_tree_stored(&sections->tree)));
    api_states_read(sections->start, 0, API_MEMBER(root, "initial"), &sections->tree,
                    reading->limits, problem);
    sections_read_section(sections, API_MEMBER(root, "section"), problem);
    sections_read_time(sections, root, problem);
    (void)api_field_whole(API_MEMBER(root, "count"), 1, (long)most, &rows, problem);
    (void)api_value_read_number(API_MEMBER(root, "rtol"), 1e-16, 0.1, "", &sections->rtol, problem);
    sections->accuracy = api_accuracy_read(root, problem);
    (void)api_field_whole(API_MEMBER(root, "digits"), 1, 17, &rounded, problem);
    sections->table.digits = (int)rounded;
    sections->table.rows = rows;
    sections->table.rows_later = 1;
    return problem->status ? PEND_INVALID : sections_check_size(sections, reading);
}

/* --- running --- */

static enum pend_status sections_begin(struct sections *sections, struct pend_error *error) {
    size_t n = (size_t)api_tree_stored(&sections->tree);
    PEND_TRY(api_states_settle(sections->start, &sections->tree, error));
    sections->state = malloc(2 * n * sizeof(double));
    if (!sections->state)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a state of %zu arms", n);
    const struct pend_section_problem problem = {.tree = sections->tree.tree,
                                                 .loads = sections->tree.loads,
                                                 .phi = sections->start->phi,
                                                 .rate = sections->start->rate,
                                                 .phi_low = sections->start->phi_low,
                                                 .rate_low = sections->start->rate_low,
                                                 .duration = sections->duration,
                                                 .arm = sections->arm,
                                                 .angle = sections->angle,
                                                 .angle_low = sections->angle_low,
                                                 .ways = sections->ways,
                                                 .rtol = sections->rtol,
                                                 .accuracy = sections->accuracy,
                                                 .start = sections->origin,
                                                 .period = sections->period,
                                                 .first = sections->first - sections->origin};
    return pend_section_new(&sections->section, &problem, error);
}

static enum pend_status sections_keep(struct sections *sections, const struct pend_passage *passage,
                                      struct pend_error *error) {
    int n = sections->tree.n, cart = sections->tree.cart;
    const double *phi = sections->state, *rate = phi + n + cart;
    const int *order = sections->tree.tree->order;
    PEND_TRY(api_table_grow(&sections->table, sections->count, FIRST_ROOM, &sections->room,
                            sections->column, error));
    long row = sections->count++;
    sections->column[T][row] = sections->origin + passage->time;
    if (sections->direction)
        sections->column[sections->direction][row] = passage->way == PEND_WAY_UP ? 1 : -1;
    for (int k = cart; k < n + cart; k++) {
        sections->column[PHI][row * n + order[k]] = phi[k];
        sections->column[PHID][row * n + order[k]] = rate[k];
    }
    if (cart) {
        sections->column[sections->cart][row] = phi[0];
        sections->column[sections->cart + 1][row] = rate[0];
    }
    sections->until = sections->column[T][row];
    return PEND_OK;
}

/* searches for the next passage; after the last one the table is complete */
static enum pend_status sections_search(struct sections *sections, struct api_buffer *out,
                                        struct pend_error *error) {
    long steps = PIECE / (api_tree_stored(&sections->tree) * 16L);
    enum pend_found found;
    struct pend_passage passage;
    double *phi = sections->state, *rate = phi + api_tree_stored(&sections->tree);
    PEND_TRY(pend_section_next(sections->section, steps > 0 ? steps : 1, &found, &passage, phi,
                               rate, error));
    if (found == PEND_FOUND_PASSAGE) PEND_TRY(sections_keep(sections, &passage, error));
    if (found == PEND_FOUND_END) sections->until = sections->origin + sections->duration;
    if ((double)pend_section_steps(sections->section) > sections->step_cap)
        return pend_fail(
            error, PEND_TOO_MANY_STEPS, -1, 0,
            "more steps than the limit %s of %.0f: ask for a shorter time or fewer passages",
            sections->step_name, sections->step_cap);
    if (found != PEND_FOUND_END && sections->count < sections->table.rows) return PEND_OK;
    sections->found_all = 1;
    sections->table.rows = sections->count;
    PEND_TRY(api_writer_new(&sections->writer, sections->format, &sections->table, out));
    if (!sections->count) return PEND_OK;
    return api_writer_block(sections->writer, sections->count,
                            (const double *const *)sections->column, out, error);
}

/* adds the number of passages and their horizon, with a warning if that is before the end */
static void sections_tell_horizon(struct sections *sections) {
    double own = pend_section_held(sections->section),
           held = isnan(own) ? own : fmin(sections->origin + own, sections->until);
    long holding = 0;
    const char *unknown = pend_pieces_unestimated(sections->tree.terms);
    if (unknown) api_stats_text(&sections->stats, "no_horizon", unknown);
    if (isnan(held)) return;
    while (holding < sections->count && sections->column[T][holding] <= held) holding++;
    api_stats_number(&sections->stats, "horizon", held);
    api_stats_whole(&sections->stats, "holding", holding);
    if (held >= sections->until) return;
    snprintf(sections->warning, sizeof sections->warning,
             "accuracy is lost before the end: after t = %.6g s the errors of the motion may "
             "exceed %.3g (estimated). Only the first %ld passages are certain.%s",
             held, sections->accuracy, holding,
             sections->rtol > 1e-16 ? " A smaller rtol extends this." : "");
    api_stats_warning(&sections->stats, "warning_horizon", sections->warning);
}

static enum pend_status sections_run(void *state, const struct api_turn *turn, int *done,
                                     struct pend_error *error) {
    struct sections *sections = state;
    if (!sections->section) PEND_TRY(sections_begin(sections, error));
    do {
        if (!sections->found_all) {
            PEND_TRY(sections_search(sections, turn->out, error));
            continue;
        }
        if (!sections->stats.count) {
            api_stats_whole(&sections->stats, "steps", pend_section_steps(sections->section));
            api_stats_whole(&sections->stats, "passages", sections->count);
            api_stats_number(&sections->stats, "until", sections->until);
            sections_tell_horizon(sections);
            api_turn_tell(turn, 0, &sections->stats);
        }
        PEND_TRY(api_writer_finish(sections->writer, &sections->stats, turn->out, done));
    } while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

static long sections_steps(const void *state) {
    const struct sections *sections = state;
    return sections->section ? pend_section_steps(sections->section) : 0;
}

/* a search ends at its time or at its number of passages; the latter end can be estimated once some
 * passages were found */
static void sections_progress(const void *state, double *steps, double *work) {
    enum { PASSAGES_KNOWN = 5 };
    const struct sections *sections = state;
    int known = sections->section && !sections->found_all && sections->count >= PASSAGES_KNOWN;
    double found = known ? (double)sections->count / (double)sections->table.rows : -1;
    *steps = *work = known ? fmax(pend_section_progress(sections->section), found) : -1;
}

static double sections_cost(const void *state) {
    const struct sections *sections = state;
    double rate = api_swing(&sections->tree, sections->start);
    double pace = rate + api_terms_pace(&sections->tree);
    /* a search may end long before its time, at its number of passages, because an arm passes only
     * once or twice per turn or swing */
    double passages = (double)sections->table.rows;
    double most = sections->period > 0 ? passages * sections->period : 20 * passages / rate;
    double seconds = fmin(sections->duration, most);
    double pieces = pend_rules_pieces(sections->tree.rules, sections->tree.tree->n, seconds, rate);
    return (fmin(steps_a_radian * seconds * pace, sections->step_cap) + pieces) *
           (api_tree_stored(&sections->tree) + 2) * arm_seconds;
}

/* rows are in a buffer that doubles when full; representations that do not stream store a copy */
static double sections_bytes(const void *state) {
    const struct sections *sections = state;
    double n = api_tree_stored(&sections->tree), numbers = api_table_numbers(&sections->table, 0);
    double room = (double)(sections->room ? sections->room : FIRST_ROOM);
    if (sections->room && sections->count + 1 >= sections->room) room *= 3;
    room = fmin(room, 1.5 * (double)sections->table.rows);
    double kept = sections->format->block ? 0 : numbers * fmin(room, (double)sections->table.rows);
    // real pendulums have more series
    double an_arm = sections->tree.loads.terms ? 20000 : 7500;
    return 32768 + (n + 16) * an_arm + sizeof(double) * (numbers * room + kept + 2 * n) +
           api_tree_bytes(&sections->tree) + api_states_bytes(sections->start) + API_PIECE_BYTES;
}

const struct api_op api_op_sections = {.name = "sections",
                                       .size = sizeof(struct sections),
                                       .body = 1,
                                       .terms = 1,
                                       .pieces = 1,
                                       .cart = 1,
                                       .samples = 1,
                                       .read = sections_read,
                                       .run = sections_run,
                                       .steps = sections_steps,
                                       .progress = sections_progress,
                                       .table = offsetof(struct sections, table),
                                       .cost = sections_cost,
                                       .doubt = 5,
                                       .bytes = sections_bytes,
                                       .stats = offsetof(struct sections, stats),
                                       .clear = sections_clear};

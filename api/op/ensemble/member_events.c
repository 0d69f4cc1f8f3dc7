#include "api/op/ensemble/member_events.h"

#include <assert.h>
#include <limits.h>
#include <math.h>

/* measured cost, s per step: of a condition, and of computing the position of an arm */
static const double condition_seconds = 0.5e-6, followed_seconds = 4e-6;

/* default number of passages of each condition if passages are the rows */
enum { COUNT_USUAL = 1000 };

void api_member_events_read(struct api_events *events, const struct api_reading *reading,
                            const struct api_tree *tree, int trajectory) {
    static const char *const words[] = {"members", "events", NULL};
    static const char *const absent[] = {"observables", "output", "picture"};
    struct api_value field = api_value_member(reading->root, "events");
    struct api_value rows = api_value_member(reading->root, "rows");
    struct api_problem *problem = reading->problem;
    int word = 0;
    if (api_field_word(&rows, words, &word, problem) > 0 && !word) api_value_usual(&rows);
    // next to observables, passages are counted and the first one is stored
    *events =
        (struct api_events){.tree = tree, .rows = word, .usual = word ? COUNT_USUAL : LONG_MAX};
    api_events_read_list(events, &field, reading->limits, problem);
    if (word && !events->count && !problem->status)
        api_value_fault(&rows, problem,
                        API_CODE_MISSING "needs \"events\", whose passages are the rows");
    for (int i = 0; word && i < 3; i++) {
        struct api_value other = api_value_member(reading->root, absent[i]);
        if (api_value_kind(&other) != API_MISSING)
            api_value_fault(&other, problem,
                            API_CODE_CONFLICT
                            "cannot be combined with \"rows\": \"events\", whose columns are "
                            "member, status, t, event, direction, phi and phid: leave it out");
    }
    if (events->count && trajectory)
        api_value_fault(&field, problem,
                        API_CODE_CONFLICT
                        "cannot be combined with the observable \"trajectory\": ask for them in "
                        "another request");
}

void api_member_events_columns(const struct api_events *events, struct api_table *table) {
    int count = events->count, n = events->tree->n;
    assert(count >= 1);
    if (events->rows) {
        api_table_add(table, "member", NULL, 0);
        api_table_add(table, "status", NULL, 0);
        api_table_add(table, "t", NULL, 0);
        api_table_add(table, "event", NULL, 0);
        api_table_add(table, "direction", NULL, 0);
        api_table_add(table, "phi", NULL, n);
        api_table_add(table, "phid", NULL, n);
        if (!events->tree->cart) return;
        api_table_add(table, "cart", "x", 0);
        api_table_add(table, "cart", "v", 0);
        return;
    }
    api_table_add(table, "events", "count", count);
    api_table_add(table, "events", "time", count);
    api_table_add(table, "events", "direction", count);
    api_table_add_inner(table, "events", "phi", count, n);
    api_table_add_inner(table, "events", "phid", count, n);
    if (events->tree->cart) {
        api_table_add(table, "events", "cart_x", count);
        api_table_add(table, "events", "cart_v", count);
    }
    if (!events->stops) return;
    api_table_add(table, "events", "stopped", 0);
}

double api_member_events_most(const struct api_events *events) {
    double most = 0;
    for (int i = 0; i < events->count; i++) most += (double)events->event[i].most;
    return most;
}

/* how many numbers the columns of a condition have */
static int numbers(const struct api_events *events) {
    return 3 + 2 * events->tree->n + 2 * events->tree->cart;
}

void api_member_events_blank(const struct api_events *events, double unknown, double at[]) {
    int count = events->count, all = count * numbers(events);
    assert(count >= 1 && !events->rows);
    for (int i = 0; i < all; i++) at[i] = unknown;
    for (int i = 0; i < count; i++) at[count + i] = NAN;
    if (events->stops) at[all] = NAN;
}

/* copies a state in the caller's order; returns the end */
static double *put_state(const struct api_tree *tree, const double x[], double at[]) {
    assert(tree->n + tree->cart == tree->tree->n);
    for (int k = tree->cart; k < tree->tree->n; k++) at[tree->tree->order[k]] = x[k];
    return at + tree->n;
}

void api_member_events_note(const struct api_events *events, const struct pend_hit *hit,
                            const double phi[], const double rate[], double at[]) {
    int count = events->count, n = events->tree->n, i = hit->event;
    double *first = at + 3 * count;
    assert(i >= 0 && i < count);
    long passed = (long)(at[i] += 1);
    if (passed == events->event[i].stop) at[count * numbers(events)] = hit->time;
    if (passed > 1) return;
    at[count + i] = hit->time;
    at[2 * count + i] = hit->way == PEND_WAY_UP ? 1 : -1;
    (void)put_state(events->tree, phi, first + i * n);
    (void)put_state(events->tree, rate, first + (count + i) * n);
    if (!events->tree->cart) return;
    first[2 * count * n + i] = phi[0];
    first[2 * count * n + count + i] = rate[0];
}

void api_member_events_row(const struct api_events *events, long member, const struct pend_hit *hit,
                           const double phi[], const double rate[], double row[]) {
    assert(events->rows && hit->event >= 0 && hit->event < events->count);
    assert(member >= 0);
    row[0] = (double)member;
    row[1] = 0;
    row[2] = hit->time;
    row[3] = hit->event + 1;
    row[4] = hit->way == PEND_WAY_UP ? 1 : -1;
    double *at = put_state(events->tree, rate, put_state(events->tree, phi, row + 5));
    if (events->tree->cart) at[0] = phi[0], at[1] = rate[0];
}

double api_member_events_cost(const struct api_events *events) {
    return events->count * condition_seconds + events->followed * followed_seconds;
}

double api_member_events_bytes(const struct api_events *events) {
    double n = events->tree ? events->tree->n + 1 : 0, count = events->count;
    if (!events->count) return 0;
    return 8192 + count * (EVENT_HITS * sizeof(struct pend_hit) + 16 * sizeof(struct event_watch)) +
           n * 2 * EVENT_TERMS * sizeof(double);
}

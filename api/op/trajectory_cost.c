#include "api/op/trajectory_cost.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { SAMPLE_NUMBERS = 16384 /* of a block of samples */ };

/* constants of the estimated cost: s a step, s a step and arm, s a number of the answer as
 * text and as it is */
static const double step_seconds = 3e-7, arm_seconds = 6e-7, text_seconds = 4e-8,
                    binary_seconds = 1.5e-8;

/* steps for the fastest swing to go on by a radian, times what a step costs in steps of taylor's;
 * at default tolerances
 */
static const struct {
    const char *method;
    double steps;
} steps_a_radian[] = {{"taylor", 4}, {"linear", 0},   {"ode23", 6},     {"rkf45", 45},
                      {"rk8pd", 35}, {"msadams", 30}, {"symplectic", 1}};
static const double steps_of_others = 20;

/* how many times as long 32 digits take, the fixed step, and a comparison with 32 digits beside
 * the trajectory */
static const double extended_times = 25, quad_times = 2000, symplectic_times = 20,
                    trust_times = API_TRAJECTORY_TRUST_TIMES;

/* rad/s at which the fastest arm turns, about: as fast as the shortest arm swings, faster where
 * many hang on each other, and as the start has it */
static double trajectory_rate(const struct api_trajectory_size *size) {
    const struct pend_tree *tree = size->tree->tree;
    assert(tree && size->start->rate);
    double shortest = INFINITY, rate = 0;
    for (int k = 0; k < tree->n; k++) {
        shortest = fmin(shortest, tree->len[k]);
        rate = fmax(rate, fabs(size->start->rate[k]));
    }
    return rate + pend_loads_rate(&size->tree->loads, tree) +
           sqrt(fabs(size->tree->loads.gravity) / shortest * sqrt(tree->n));
}

double api_trajectory_cost_seconds(const struct api_trajectory_size *size) {
    const struct api_table *table = size->table;
    const struct pend_times *times = &size->times->times;
    assert(times->count >= 1 && table->rows >= 0 && size->method->method);
    double span = fabs(pend_times_at(times, times->count - 1) - pend_times_at(times, 0)),
           steps = steps_of_others;
    double numbers = (double)table->rows * api_table_numbers(table, 0);
    for (size_t i = 0; i < sizeof steps_a_radian / sizeof *steps_a_radian; i++)
        if (!strcmp(size->method->method->name, steps_a_radian[i].method))
            steps = steps_a_radian[i].steps;
    steps *= span * trajectory_rate(size);
    if (size->method->step > 0) steps = span / size->method->step;
    double times_as_long = size->trusts ? 1 + trust_times : 1;
    if (size->method->method == pend_method_taylor.extended)
        times_as_long = size->trusts ? 2 * extended_times : extended_times;
    if (size->method->method == &pend_method_taylor_quad)
        times_as_long = size->trusts ? 2 * quad_times : quad_times;
    if (size->method->method == &pend_method_symplectic) times_as_long = symplectic_times;
    if (size->events->rows) times_as_long = 0;
    times_as_long += api_events_times(size->events);
    return times_as_long * fmin(steps, (double)size->step_cap) *
               (step_seconds + size->tree->n * arm_seconds) +
           api_derived_seconds(size->derived, size->tree, span * trajectory_rate(size)) +
           numbers * (size->format->digits ? text_seconds : binary_seconds);
}

/* bytes that a method takes for each arm of an ideal and of a real pendulum: its series, stages and
 * scratch; small trees are filled up to whole lanes. `linear` takes ideal ones only. */
static const struct trajectory_room {
    const char *method;
    double ideal, real;
} rooms[] = {{"taylor", 9000, 12500}, {"symplectic", 16000, 48000}, {"linear", 6000, 6000}},
  room_of_others = {"", 8000, 13000}, room_of_extended = {"", 30000, 90000},
  room_of_comparison = {"", 30000, 60000};
static const double lane_arms = 16, method_bytes = 32768;

/* numbers that `linear` takes for each pair of arms: its modes, and what they are made
 * orthogonal to */
static const double linear_numbers = 2.2;

static double trajectory_derived_bytes(const struct api_trajectory_size *size) {
    const struct api_derived *derived = size->derived;
    if (!derived->count) return 0;
    return api_derived_bytes(derived, size->tree, api_derived_cap(derived, size->table->rows));
}

double api_trajectory_cost_bytes(const struct api_trajectory_size *size) {
    assert(size->format && size->table && size->derived->count >= 0);
    const struct trajectory_room *room = &room_of_others;
    double n = api_tree_stored(size->tree), row = api_table_numbers(size->table, 0);
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++)
        if (!strcmp(size->method->method->name, rooms[i].method)) room = &rooms[i];
    if (size->method->method == pend_method_taylor.extended) room = &room_of_extended;
    int real = size->tree->loads.terms != NULL;
    double an_arm = real ? room->real : room->ideal;
    if (size->trusts)
        an_arm = 2 * an_arm + (real ? room_of_comparison.real : room_of_comparison.ideal);
    double square =
        size->method->method == &pend_method_linear ? linear_numbers * sizeof(double) * n * n : 0;
    double list = size->times->list ? (double)size->times->times.count * sizeof(double) : 0;
    double block = fmin(SAMPLE_NUMBERS, (double)size->table->rows * (row + 8)) + row + 8;
    if (size->events->count) an_arm *= 2; // a search has a stepper of its own
    return method_bytes + (n + lane_arms) * an_arm + square + list + 2 * sizeof(double) * block +
           api_tree_bytes(size->tree) + api_states_bytes(size->start) +
           trajectory_derived_bytes(size) + api_events_bytes(size->events) +
           api_writer_bytes(size->format, size->table);
}

#include "api/op/trajectory_cost.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/tree/rules.h"

enum { SAMPLE_NUMBERS = 16384 /* numbers in a block of samples */ };

/* constants of the estimated cost: s per step; s per step and arm; s per number of the answer, as
 * text and in binary form */
static const double step_seconds = 1e-6, arm_seconds = 3e-7, text_seconds = 4e-8,
                    binary_seconds = 1.5e-8;

/* Steps at default tolerances, in units of the cost of a step of taylor: per radian of the fastest
 * swing, per radian of a spring or a drive, and per decay by 1/e due to friction. */
static const struct trajectory_steps {
    const char *method;
    double swing, drive, decay;
} steps_of[] = {{"taylor", 2, 0.4, 0.1},   {"linear", 0, 0, 0},    {"ode23", 4, 4, 0.4},
                {"rkf45", 30, 30, 0.5},    {"rk8pd", 20, 20, 0.5}, {"msadams", 20, 20, 1.5},
                {"symplectic", 1.2, 1, 0}, {"radau", 4, 1, 0}},
  steps_of_others = {"", 20, 20, 1};

/* cost, in steps, of the change between two pieces and of the step that ends one */
static const double steps_a_piece = 1.6;

/* time relative to the taylor method: with 32 digits, with a fixed step; additional time of a
 * comparison with 32 digits */
static const double extended_times = 25, symplectic_times = 17,
                    trust_times = API_TRAJECTORY_TRUST_TIMES;

/* steps per second of the motion; fade: those that friction causes */
static double trajectory_pace(const struct api_trajectory_size *size, double *fade) {
    const struct pend_loads *loads = &size->tree->loads;
    const struct trajectory_steps *steps = &steps_of_others;
    double decay = pend_loads_decay(loads, size->tree->tree),
           drive = pend_loads_rate(loads, size->tree->tree) - decay;
    for (size_t i = 0; i < sizeof steps_of / sizeof *steps_of; i++)
        if (!strcmp(size->method->method->name, steps_of[i].method)) steps = &steps_of[i];
    *fade = steps->decay * decay;
    return steps->swing * api_swing(size->tree, size->start) + steps->drive * drive + *fade;
}

static double trajectory_span(const struct api_trajectory_size *size) {
    const struct pend_times *times = &size->times->times;
    return pend_times_at(times, times->count - 1) - pend_times_at(times, 0);
}

/* whether friction causes most of the steps, and more of them than radau would take */
static int trajectory_fades(const struct api_trajectory_size *size) {
    enum { MANY = 1000, ARMS = 256 }; // limits of radau's matrices
    static const double most = 0.9;
    double fade, pace = trajectory_pace(size, &fade);
    return fade > most * pace && trajectory_span(size) * fade > MANY && size->tree->n <= ARMS;
}

const char *api_trajectory_way_out(struct api_trajectory_size size) {
    if (size.method->method == &pend_method_symplectic)
        return "ask for a shorter time or a longer step";
    if (!trajectory_fades(&size)) return NULL;
    return "ask for method \"radau\", whose steps friction does not shorten, or for a shorter time";
}

int api_trajectory_stiff(struct api_trajectory_size size, long steps, char text[API_WARNING_TEXT]) {
    enum { MANY = 2000 };
    if (steps < MANY || !trajectory_fades(&size)) return 0;
    snprintf(text, API_WARNING_TEXT,
             "friction stops an arm in about %.2g s; this, not accuracy, made %ld steps necessary. "
             "Friction does not shorten the steps of method radau.",
             1 / pend_loads_decay(&size.tree->loads, size.tree->tree), steps);
    return 1;
}

/* s per step of radau: its stages, the derivatives with respect to all arms, the factors of four
 * matrices */
static double trajectory_implicit(double n) {
    static const double step = 3e-5, arm = 1e-5, pair = 5e-7, triple = 6e-9;
    return step + n * (arm + n * (pair + n * triple));
}

double api_trajectory_cost_seconds(struct api_trajectory_size size) {
    const struct api_table *table = size.table;
    assert(size.times->times.count >= 1 && table->rows >= 0 && size.method->method);
    double fade, span = fabs(trajectory_span(&size)), steps = span * trajectory_pace(&size, &fade),
                 n = size.tree->n, a_step = step_seconds + n * arm_seconds;
    double numbers = (double)table->rows * api_table_numbers(table, 0);
    if (size.method->step > 0) steps = span / size.method->step;
    if (size.method->method == &pend_method_radau) a_step = trajectory_implicit(n);
    double times_as_long = size.trusts ? 1 + trust_times : 1;
    if (size.method->method == pend_method_taylor.extended)
        times_as_long = size.trusts ? 2 * extended_times : extended_times;
    if (size.method->method == &pend_method_symplectic) times_as_long = symplectic_times;
    if (size.events->rows) times_as_long = 0;
    times_as_long += api_events_times(size.events);
    double swing = api_swing(size.tree, size.start),
           rate = swing + pend_loads_rate(&size.tree->loads, size.tree->tree);
    steps = fmin(steps, (double)size.step_cap) +
            steps_a_piece * pend_rules_pieces(size.tree->rules, size.tree->tree->n, span, swing);
    return times_as_long * steps * a_step +
           api_derived_seconds(size.derived, size.tree, span * rate) +
           numbers * (size.format->digits ? text_seconds : binary_seconds);
}

/* Bytes per arm of an ideal and of a real pendulum that a method needs: series, stages and scratch;
 * small trees are padded to whole lanes. `linear` supports only ideal pendulums. */
static const struct trajectory_room {
    const char *method;
    double ideal, real;
} rooms[] = {{"taylor", 10500, 14500},
             {"symplectic", 17500, 50000},
             {"linear", 6000, 6000},
             {"radau", 40000, 40000}},
  room_of_others = {"", 9500, 17000}, room_of_extended = {"", 31500, 92000},
  room_of_comparison = {"", 30000, 60000};
static const double lane_arms = 16, method_bytes = 32768;

/* numbers per pair of arms that `linear` needs: its modes, and their orthogonalization */
static const double linear_numbers = 2.2;

/* numbers per pair of arms that radau needs: the derivatives of accelerations, and four complex
 * matrices */
static const double radau_numbers = 10;

double api_trajectory_cost_bytes(struct api_trajectory_size size) {
    assert(size.format && size.table && size.derived->count >= 0);
    const struct trajectory_room *room = &room_of_others;
    double n = api_tree_stored(size.tree), row = api_table_numbers(size.table, 0);
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++)
        if (!strcmp(size.method->method->name, rooms[i].method)) room = &rooms[i];
    if (size.method->method == pend_method_taylor.extended) room = &room_of_extended;
    int real = size.tree->loads.terms != NULL;
    double an_arm = real ? room->real : room->ideal;
    if (size.trusts)
        an_arm = 2 * an_arm + (real ? room_of_comparison.real : room_of_comparison.ideal);
    double square =
        size.method->method == &pend_method_linear ? linear_numbers * sizeof(double) * n * n : 0;
    if (size.method->method == &pend_method_radau) square = radau_numbers * sizeof(double) * n * n;
    double list = size.times->list ? (double)size.times->times.count * sizeof(double) : 0;
    double block = fmin(SAMPLE_NUMBERS, (double)size.table->rows * (row + 8)) + row + 8;
    long cap = size.derived->count ? api_derived_cap(size.derived, size.table->rows) : 0;
    double derived = cap ? api_derived_bytes(size.derived, size.tree, cap) : 0;
    if (size.events->count) an_arm *= 2; // a search for events has its own stepper
    return method_bytes + (n + lane_arms) * an_arm + square + list + 2 * sizeof(double) * block +
           api_tree_bytes(size.tree) + api_states_bytes(size.start) + derived +
           api_events_bytes(size.events) + api_writer_bytes(size.format, size.table);
}

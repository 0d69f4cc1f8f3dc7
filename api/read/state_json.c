#include "api/read/state_json.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "core/modes/damped.h"
#include "core/modes/modes.h"
#include "core/tree/turns.h"

/* a number of 32 digits */
struct exact {
    double high, low;
};
static const struct exact exact_one = {1, 0},
                          exact_degree = {0x1.1df46a2529d39p-6, 0x1.5c1d8becdd291p-62},
                          exact_right_angle = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};

/* 32 digits of a larger angle in rad would not determine its direction to double precision */
static const double DEGREES_MOST = 1e15;

static const char *const state_fields[] = {"phi",       "phid", "theta", "thetad", "mode",
                                           "amplitude", "unit", "cart",  NULL};

/* the forms of a state: the field that selects the form, its second field, and the direction from
 * which the angle is measured */
static const struct {
    const char *angle, *rate;
    int from_hanging; /* whether phi = angle - pi/2 */
} state_forms[] = {{"phi", "phid", 0}, {"theta", "thetad", 1}, {"mode", "amplitude", 0}};

enum { FORM_COUNT = 3, FORM_MODE = 2 };

/* the most arms of a real pendulum that starts in a mode: with friction or drag, and without */
enum { MODE_ARMS_DAMPED = 100, MODE_ARMS_STILL = 300 };

enum pend_status api_states_new(struct api_states **states, long count, int n) {
    size_t arms = (size_t)n, one = 4 * arms * sizeof(double) + sizeof(double) + sizeof(int);
    *states = NULL;
    if ((size_t)count > (SIZE_MAX - sizeof **states) / one) return PEND_NO_MEMORY;
    *states = calloc(1, sizeof **states + (size_t)count * one);
    if (!*states) return PEND_NO_MEMORY;
    (*states)->n = n;
    (*states)->count = count;
    (*states)->phi = (double *)(*states + 1);
    (*states)->rate = (*states)->phi + (size_t)count * arms;
    (*states)->phi_low = (*states)->rate + (size_t)count * arms;
    (*states)->rate_low = (*states)->phi_low + (size_t)count * arms;
    (*states)->amplitude = (*states)->rate_low + (size_t)count * arms;
    (*states)->mode = (int *)((*states)->amplitude + count);
    assert(api_states_valid(*states));
    return PEND_OK;
}

int api_states_valid(const struct api_states *states) {
    return states->n >= 0 && states->count >= 0 && 0 <= states->mode_least &&
           states->mode_least <= states->mode_most &&
           states->mode ==
               (const int *)(states->phi + (size_t)states->count * (4 * (size_t)states->n + 1));
}

void api_states_free(struct api_states **states) {
    free(*states);
    *states = NULL;
}

double api_states_bytes(const struct api_states *states) {
    if (!states) return 0;
    double n = states->n,
           modes = states->mode_most ? states->mode_most - states->mode_least + 1 : 0;
    /* memory of the modes during their computation: vectors and scratch */
    double settle = modes > 0 ? 2.2 * sizeof(double) * n * (modes + 16) + 2048 * n : 0;
    return (double)sizeof *states + (double)states->count * (4 * n + 2) * sizeof(double) + settle;
}

/* scale x - offset, as a double and its rounding error */
static struct exact exact_turn(struct exact scale, double x, struct exact offset) {
    double product = scale.high * x, rest = fma(scale.high, x, -product) + scale.low * x;
    double high = product - offset.high, part = high - product;
    double low = (product - (high - part)) - (offset.high + part) + (rest - offset.low);
    struct exact sum = {high + low, 0};
    sum.low = low - (sum.high - high);
    return sum;
}

/* reads n numbers in the caller's order, scales and shifts them, and stores them in stored order;
 * `low` may be NULL */
static void read_angles(const struct api_value *value, const struct api_tree *tree,
                        struct exact scale, struct exact offset, double out[], double low[],
                        struct api_problem *problem) {
    int count, lone = api_value_kind(value) == API_NUMBER;
    // the number of arms of a rejected tree is unknown
    if (lone && !tree->n) return;
    int good = api_field_numbers(value, tree->n, "arm", NULL, problem);
    const double one = api_value_number(value);
    const double *numbers = lone ? &one : api_value_numbers(value, &count);
    if (good <= 0 || !out || !tree->tree) return;
    for (int i = 0; i < tree->n; i++) {
        if (scale.high != 1 && fabs(numbers[i]) > DEGREES_MOST) {
            struct api_value number = lone ? *value : api_value_item(value, i);
            api_value_fault(&number, problem,
                            API_CODE_OUT_OF_RANGE "must be from -1e15 to 1e15 degrees, got %.15g",
                            numbers[i]);
            continue;
        }
        struct exact x = exact_turn(scale, numbers[i], offset);
        out[tree->tree->place[i]] = x.high;
        if (low) low[tree->tree->place[i]] = x.low;
    }
}

/* checks the size of a real pendulum, whose modes are all computed together */
static void check_real_mode(const struct api_tree *tree, const struct api_value *mode,
                            struct api_problem *problem) {
    int most = pend_loads_lose(&tree->loads) ? MODE_ARMS_DAMPED : MODE_ARMS_STILL;
    assert(tree->terms);
    if (tree->n <= most) return;
    api_value_fault(mode, problem,
                    API_CODE_LIMIT "is for a real pendulum of %d arms; a start in a mode allows at "
                                   "most %d arms with friction or drag, and %d without",
                    tree->n, MODE_ARMS_DAMPED, MODE_ARMS_STILL);
}

static void read_mode(struct api_states *states, long i, const struct api_value *mode,
                      const struct api_value *amplitude, double scale, const struct api_tree *tree,
                      const struct api_limits *limits, struct api_problem *problem) {
    long number = 0;
    double size = 0;
    long most = tree->n ? api_tree_stored(tree) : (long)limits->arms; // a cart counts as an arm
    (void)api_field_whole(mode, 1, most, &number, problem);
    if (api_field_needed(amplitude, problem))
        (void)api_value_read_number(amplitude, -INFINITY, INFINITY, "", &size, problem);
    if (tree->terms)
        check_real_mode(tree, mode, problem);
    else
        api_tree_modes_allowed(tree, mode, 1, "a start in a mode", limits, problem);
    if (!states) return;
    states->mode[i] = (int)number;
    if (!states->mode_most || number < states->mode_least) states->mode_least = (int)number;
    if (number > states->mode_most) states->mode_most = (int)number;
    states->amplitude[i] = scale * size;
}

/* the form whose first field is present, FORM_COUNT if there is none; adds errors for fields of a
 * second form and for fields whose partner is missing */
static int state_form(const struct api_value *value, struct api_problem *problem) {
    int found = FORM_COUNT;
    for (int form = 0; form < FORM_COUNT; form++) {
        struct api_value angle = api_value_member(value, state_forms[form].angle);
        struct api_value rate = api_value_member(value, state_forms[form].rate);
        int given = api_value_kind(&angle) != API_MISSING,
            partner = api_value_kind(&rate) != API_MISSING;
        if (!given && !partner) continue;
        if (found == FORM_COUNT) found = form;
        if (found != form)
            api_value_fault(given ? &angle : &rate, problem,
                            API_CODE_CONFLICT
                            "cannot be combined with \"%s\": give a state by phi and phid, by "
                            "theta and thetad, or by mode and amplitude",
                            state_forms[found].angle);
        else if (!given)
            api_value_fault(&angle, problem, API_CODE_MISSING "is missing, but \"%s\" needs it",
                            state_forms[form].rate);
    }
    return found;
}

static int read_degrees(const struct api_value *value, struct api_problem *problem) {
    int unit = 0;
    struct api_value field = api_value_member(value, "unit");
    if (api_field_word(&field, api_field_angles, &unit, problem) > 0 && !unit)
        api_value_usual(&field);
    return unit;
}

/* the first of some angles without a unit that is more than a turn, if all are whole numbers, as
 * degrees are; else 0 */
static double angles_like_degrees(const struct api_value *angle) {
    struct api_value unit = api_value_member(angle->parent, "unit");
    int count = 0;
    double far = 0;
    const double *number = api_value_numbers(angle, &count);
    for (int k = 0; number && k < count && api_value_kind(&unit) == API_MISSING; k++) {
        if (number[k] != rint(number[k])) return 0;
        if (far == 0 && fabs(number[k]) > 2 * M_PI) far = number[k];
    }
    return far;
}

/* reads a state given by angles and rates, from the real axis or from the vertical */
static void read_turns(struct api_states *states, long i, const struct api_value *angle,
                       const struct api_value *rate, int degrees, int from_hanging,
                       const struct api_tree *tree, struct api_problem *problem) {
    static const struct exact none = {0, 0};
    size_t first = states ? (size_t)i * (size_t)states->n : 0;
    struct exact turn = degrees ? exact_degree : exact_one;
    if (states) states->degrees = angles_like_degrees(angle);
    if (!from_hanging) api_value_usual_zeros(angle);
    api_value_usual_zeros(rate);
    read_angles(angle, tree, turn, from_hanging ? exact_right_angle : none,
                states ? states->phi + first : NULL, states ? states->phi_low + first : NULL,
                problem);
    read_angles(rate, tree, turn, none, states ? states->rate + first : NULL,
                states ? states->rate_low + first : NULL, problem);
}

/* reads position, m, and speed, m/s, of a cart on its rail, which is stored arm 0 */
static void read_cart(struct api_states *states, long i, const struct api_value *cart,
                      const struct api_tree *tree, struct api_problem *problem) {
    static const char *const names[] = {"x", "v", NULL};
    double number[2] = {0, 0};
    if (api_value_kind(cart) == API_MISSING || !api_field_object(cart, names, problem)) return;
    if (tree->tree && !tree->cart)
        api_value_fault(cart, problem,
                        API_CODE_NOT_APPLICABLE
                        "is the position and the velocity of a cart, but the pendulum has no cart: "
                        "give one in \"pivot\", or leave it out");
    for (int j = 0; j < 2; j++) {
        struct api_value field = api_value_member(cart, names[j]);
        api_value_usual_number(&field, 0);
        (void)api_value_read_number(&field, -INFINITY, INFINITY, j ? "m/s" : "m", &number[j],
                                    problem);
    }
    api_value_usual_object(cart);
    if (!states || !tree->cart) return;
    states->phi[(size_t)i * (size_t)states->n] = number[0];
    states->rate[(size_t)i * (size_t)states->n] = number[1];
}

void api_states_read(struct api_states *states, long i, const struct api_value *value,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem) {
    assert(!states || (api_states_valid(states) && i >= 0 && i < states->count));
    if (api_value_kind(value) == API_ARRAY)
        api_value_fault(value, problem,
                        API_CODE_WRONG_TYPE
                        "must be an object with \"theta\" and \"thetad\", or \"phi\" and \"phid\", "
                        "each a list, got an array");
    if (api_value_kind(value) == API_MISSING || api_value_kind(value) == API_ARRAY ||
        !api_field_object(value, state_fields, problem))
        return;
    int degrees = read_degrees(value, problem), form = state_form(value, problem);
    struct api_value cart = api_value_member(value, "cart");
    read_cart(states, i, &cart, tree, problem);
    if (form == FORM_MODE && api_value_kind(&cart) != API_MISSING)
        api_value_fault(&cart, problem,
                        API_CODE_CONFLICT
                        "is set by the mode: leave it out, or give the state by angles");
    if (form == FORM_COUNT) return;

    struct api_value angle = api_value_member(value, state_forms[form].angle);
    struct api_value rate = api_value_member(value, state_forms[form].rate);
    if (form != FORM_MODE)
        read_turns(states, i, &angle, &rate, degrees, state_forms[form].from_hanging, tree,
                   problem);
    else if (api_value_kind(&angle) != API_MISSING)
        read_mode(states, i, &angle, &rate, degrees ? M_PI / 180 : 1, tree, limits, problem);
    assert(!states || api_states_valid(states));
}

/* computes the modes to which the states refer, and those between them */
static enum pend_status states_modes(struct pend_modes **modes, const struct api_states *states,
                                     const struct api_tree *tree, struct pend_error *error) {
    int low = states->n, high = 0;
    for (long i = 0; i < states->count; i++) {
        int mode = states->mode[i];
        if (mode && mode < low) low = mode;
        if (mode > high) high = mode;
    }
    struct pend_modes_request request = {.loads = tree->loads,
                                         .vectors = 1,
                                         .normalize = PEND_NORMALIZE_MAX,
                                         .select = PEND_SELECT_NUMBERS,
                                         .first = low - 1,
                                         .count = high - low + 1};
    return high ? pend_modes_select(modes, tree->tree, &request, error) : PEND_OK;
}

/* computes the states given as modes of a real pendulum: its equilibrium near hanging, plus the
 * real part of the mode's shape, with the rates of that mode */
static enum pend_status states_settle_real(struct api_states *states, const struct api_tree *tree,
                                           struct pend_error *error) {
    size_t n = (size_t)states->n;
    struct pend_damped *modes;
    double *near = malloc(n * sizeof *near);
    if (!near) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a start in a mode");
    for (size_t k = 0; k < n; k++) near[k] = -M_PI / 2;
    if (tree->cart) near[0] = 0;
    enum pend_status status = pend_damped_new(&modes, tree->tree, &tree->loads, near, error);
    free(near);
    if (status != PEND_OK) return status;
    for (long i = 0; i < states->count; i++) {
        size_t j = (size_t)states->mode[i] - 1, at = (size_t)i * n;
        if (!states->mode[i]) continue;
        for (size_t k = 0; k < n; k++) {
            double re = modes->re[j * n + k], im = modes->im[j * n + k];
            states->phi[at + k] = modes->phi[k] + states->amplitude[i] * re;
            states->rate[at + k] =
                states->amplitude[i] * (modes->decay[j] * re - modes->omega[j] * im);
        }
    }
    pend_damped_free(&modes);
    states->mode_least = states->mode_most = 0;
    return PEND_OK;
}

enum pend_status api_states_settle(struct api_states *states, const struct api_tree *tree,
                                   struct pend_error *error) {
    struct pend_modes *modes = NULL;
    size_t n = (size_t)states->n;
    assert(api_states_valid(states) && states->n == api_tree_stored(tree));
    if (tree->terms && states->mode_most) return states_settle_real(states, tree, error);
    PEND_TRY(states_modes(&modes, states, tree, error));
    for (long i = 0; i < states->count; i++) {
        if (!states->mode[i]) continue;
        const double *vector = modes->vector + (size_t)(states->mode[i] - 1 - modes->first) * n;
        for (size_t k = 0; k < n; k++) {
            struct pend_sum phi = pend_turns_hanging(states->amplitude[i] * vector[k]);
            states->phi[(size_t)i * n + k] = phi.high;
            states->phi_low[(size_t)i * n + k] = phi.low;
        }
    }
    pend_modes_free(&modes);
    states->mode_least = states->mode_most = 0;
    return PEND_OK;
}

#include "api/op/modes/response_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/modes/damped_json.h"

static const char *const fields[] = {"pendulum", "initial", "drive",  "omega",
                                     "output",   "poles",   "digits", NULL};
static const char *const range_fields[] = {"start", "stop", "count", "scale", NULL};
static const char *const drive_fields[] = {"pivot", "torque", "cart", NULL};
static const char *const pivot_fields[] = {"x", "y", "amplitude", "direction", "unit", NULL};
static const char *const torque_fields[] = {"arm", "amplitude", NULL};
static const char *const cart_fields[] = {"amplitude", NULL};

const char *const api_response_outputs[API_RESPONSE_OUTPUTS + 1] = {
    "phi", "z", "lambda", "joint_force", "tip_force", "transmissibility", "cart", NULL};

/* upper limits of frequencies and amplitudes, whose squares must not overflow */
static const double omega_most = 1e9, amplitude_most = 1e9;
/* ---- drives */

static int present(const struct api_value *value) { return api_value_kind(value) != API_MISSING; }

/* reads {"x": 1, "y": 0} or {"amplitude": 1, "direction": 0.5} */
static void read_pivot(struct api_response *asked, const struct api_value *value,
                       struct api_problem *problem) {
    struct api_value x = api_value_member(value, "x"), y = api_value_member(value, "y");
    struct api_value amplitude = api_value_member(value, "amplitude");
    struct api_value direction = api_value_member(value, "direction");
    double size = 1, angle = 0;
    int degrees = 0;
    if (!api_field_object(value, pivot_fields, problem)) return;
    (void)api_value_read_number(&x, -amplitude_most, amplitude_most, "m", &asked->pivot[0],
                                problem);
    (void)api_value_read_number(&y, -amplitude_most, amplitude_most, "m", &asked->pivot[1],
                                problem);
    (void)api_value_read_number(&amplitude, 0, amplitude_most, "m", &size, problem);
    (void)api_value_read_number(&direction, -1e6, 1e6, "", &angle, problem);
    (void)api_field_word(API_MEMBER(value, "unit"), api_field_angles, &degrees, problem);
    int straight = present(&x) || present(&y), along = present(&direction);
    asked->given = straight || present(&amplitude);
    if (straight && (along || present(&amplitude)))
        api_value_fault(value, problem,
                        API_CODE_CONFLICT
                        "must have \"x\" and \"y\", or a \"direction\" with an \"amplitude\", not "
                        "both");
    else if (!straight && !along)
        api_value_fault(value, problem,
                        API_CODE_MISSING "must give the direction in which the pivot is shaken: "
                                         "\"x\" and \"y\", or a \"direction\"");
    if (straight || !along) return;
    if (degrees) angle *= M_PI / 180;
    asked->pivot[0] = size * cos(angle);
    asked->pivot[1] = size * sin(angle);
}

/* reads {"arm": 2, "amplitude": 0.1} */
static void read_torque(struct api_response *asked, const struct api_value *value,
                        struct api_problem *problem) {
    if (!api_field_object(value, torque_fields, problem)) return;
    asked->couple = 1;
    asked->given = api_value_read_number(API_MEMBER(value, "amplitude"), -amplitude_most,
                                         amplitude_most, "N m", &asked->couple, problem) > 0;
    int caller = api_tree_read_arm(&asked->tree, API_MEMBER(value, "arm"), problem);
    if (caller >= 0) asked->arm = asked->tree.tree->place[caller];
}

/* reads {"amplitude": 0.1}, a force on the cart */
static void read_cart(struct api_response *asked, const struct api_value *value,
                      struct api_problem *problem) {
    if (!api_field_object(value, cart_fields, problem)) return;
    if (asked->tree.tree && !asked->tree.cart)
        api_value_fault(value, problem,
                        API_CODE_NOT_APPLICABLE
                        "is a force on a cart, but the pendulum has no cart: give one in "
                        "\"pivot\", or drive the pivot or a joint");
    asked->arm = 0;
    asked->couple = 1;
    asked->given = api_value_read_number(API_MEMBER(value, "amplitude"), -amplitude_most,
                                         amplitude_most, "N", &asked->couple, problem) > 0;
}

static void read_own(struct api_response *asked, const struct api_value *value,
                     struct api_problem *problem) {
    const struct pend_terms *terms = asked->tree.loads.terms;
    asked->own = asked->given = 1;
    if (asked->tree.tree && (!terms || !terms->harmonics))
        api_value_fault(value, problem,
                        API_CODE_MISSING "is needed: %s{\"torque\": {\"arm\": 1}}; the pendulum "
                                         "has no harmonic drive of its own",
                        asked->tree.cart ? "{\"cart\": {}} or " : "{\"pivot\": {\"x\": 1}} or ");
}

static void read_drive(struct api_response *asked, const struct api_value *value,
                       struct api_problem *problem) {
    assert(asked->arm < 0 && !asked->own);
    if (!present(value)) {
        read_own(asked, value, problem);
        return;
    }
    if (!api_field_object(value, NULL, problem)) return;
    struct api_value pivot = api_value_member(value, "pivot");
    struct api_value torque = api_value_member(value, "torque");
    struct api_value cart = api_value_member(value, "cart");
    (void)api_value_only(value, drive_fields, problem);
    if (present(&pivot) + present(&torque) + present(&cart) != 1) {
        api_value_fault(value, problem,
                        API_CODE_CONFLICT "must have one of \"pivot\", \"torque\" and \"cart\": "
                                          "the responses to several drives can be added");
        return;
    }
    if (present(&pivot) && asked->tree.cart)
        api_value_fault(&pivot, problem,
                        API_CODE_NOT_APPLICABLE "is on a cart, which moves with the pendulum: "
                                                "drive the cart by {\"cart\": {\"amplitude\": 1}}");
    if (present(&pivot)) read_pivot(asked, &pivot, problem);
    if (present(&torque)) read_torque(asked, &torque, problem);
    if (present(&cart)) read_cart(asked, &cart, problem);
}

/* ---- frequencies */

static void fault_rows(const struct api_value *value, double rows, const struct api_limits *limits,
                       struct api_problem *problem) {
    api_value_fault(value, problem,
                    API_CODE_LIMIT
                    "asks for %.15g frequencies, more than the limit %s of %.0f: ask for fewer",
                    rows, api_limits_name(limits, &limits->samples), limits->samples);
}

static enum pend_status read_list(struct api_response *asked, const struct api_value *value,
                                  const struct api_limits *limits, struct api_problem *problem) {
    int count = 0;
    const double *list = api_value_numbers(value, &count);
    if (!list) {
        (void)api_field_numbers(value, 0, "", NULL, problem);
        return PEND_OK;
    }
    if (!count)
        api_value_fault(value, problem, API_CODE_WRONG_COUNT "must have at least one frequency");
    if (count > limits->samples) {
        fault_rows(value, count, limits, problem);
        return PEND_OK;
    }
    for (int i = 0; i < count; i++) {
        if (list[i] >= 0 && list[i] <= omega_most) continue;
        struct api_value item = api_value_item(value, i);
        api_value_fault(&item, problem,
                        API_CODE_OUT_OF_RANGE "must be from 0 to %g rad/s, got %.15g", omega_most,
                        list[i]);
    }
    if (!count || problem->status) return PEND_OK;
    asked->rows = count;
    asked->list = malloc((size_t)count * sizeof *list);
    if (!asked->list) return PEND_NO_MEMORY;
    memcpy(asked->list, list, (size_t)count * sizeof *list);
    return PEND_OK;
}

/* adds errors for invalid combinations of ends, count and scale of a range */
static void check_range(const struct api_response *asked, const struct api_value *value,
                        struct api_problem *problem) {
    struct api_value count = api_value_member(value, "count");
    assert(asked->from >= 0 && asked->to >= 0);
    if (asked->to < asked->from)
        api_value_fault(API_MEMBER(value, "stop"), problem,
                        API_CODE_ORDER "must not be below \"start\" (%.15g rad/s), got %.15g",
                        asked->from, asked->to);
    if (asked->rows == 1 && asked->from != asked->to)
        api_value_fault(&count, problem,
                        API_CODE_OUT_OF_RANGE
                        "must be at least 2 for the frequencies to begin at start and end at "
                        "stop, got 1");
    if (asked->logarithmic && !(asked->from > 0))
        api_value_fault(API_MEMBER(value, "start"), problem,
                        API_CODE_OUT_OF_RANGE
                        "must be greater than 0 on a logarithmic scale, got %.15g",
                        asked->from);
}

static void read_range(struct api_response *asked, const struct api_value *value,
                       const struct api_limits *limits, struct api_problem *problem) {
    static const char *const scales[] = {"linear", "logarithmic", NULL};
    struct api_value start = api_value_member(value, "start");
    struct api_value stop = api_value_member(value, "stop");
    struct api_value count = api_value_member(value, "count");
    struct api_value scale = api_value_member(value, "scale");
    if (!api_field_object(value, range_fields, problem)) return;
    int word = api_field_word(&scale, scales, &asked->logarithmic, problem), good = 1;
    if (word > 0 && !asked->logarithmic) api_value_usual(&scale);
    good &= api_field_needed(&start, problem) &&
            api_value_read_number(&start, 0, omega_most, "rad/s", &asked->from, problem) > 0;
    good &= api_field_needed(&stop, problem) &&
            api_value_read_number(&stop, 0, omega_most, "rad/s", &asked->to, problem) > 0;
    if (api_field_needed(&count, problem))
        (void)api_field_whole(&count, 1, 1000000000, &asked->rows, problem);
    if ((double)asked->rows > limits->samples)
        fault_rows(&count, (double)asked->rows, limits, problem);
    if (good) check_range(asked, value, problem);
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* lists the different frequencies of the pendulum's own harmonics */
static enum pend_status read_apart(struct api_response *asked) {
    const struct pend_terms *terms = asked->tree.loads.terms;
    asked->apart = 1;
    if (!terms || !terms->harmonics) return PEND_OK;
    asked->list = malloc((size_t)terms->harmonics * sizeof *asked->list);
    if (!asked->list) return PEND_NO_MEMORY;
    for (int i = 0; i < terms->harmonics; i++)
        asked->list[i] = fabs(asked->tree.value[terms->harmonic[i].at + 1]);
    qsort(asked->list, (size_t)terms->harmonics, sizeof *asked->list, ascending);
    for (int i = 0; i < terms->harmonics; i++)
        if (!i || asked->list[i] != asked->list[i - 1]) asked->list[asked->rows++] = asked->list[i];
    return PEND_OK;
}

static enum pend_status read_omega(struct api_response *asked, const struct api_value *value,
                                   const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    if (!present(value)) {
        if (asked->own) return read_apart(asked);
        api_value_fault(value, problem,
                        API_CODE_MISSING
                        "is needed: a list of angular frequencies, rad/s, or {\"start\", "
                        "\"stop\", \"count\"}");
        return PEND_OK;
    }
    if (api_value_kind(value) == API_ARRAY)
        return read_list(asked, value, reading->limits, problem);
    read_range(asked, value, reading->limits, problem);
    return PEND_OK;
}

/* ---- outputs */

/* true if the drive displaces the pivot */
static int shakes(const struct api_response *asked) {
    const struct pend_terms *terms = asked->tree.loads.terms;
    if (!asked->own) return asked->arm < 0;
    return terms && terms->harmonics && terms->harmonic[0].drives < 0;
}

static void read_output(struct api_response *asked, const struct api_value *value,
                        struct api_problem *problem) {
    struct api_value item = api_value_item(value, 0);
    if (!present(value)) {
        asked->output[API_RESPONSE_PHI] = 1;
        return;
    }
    if (api_value_kind(value) != API_ARRAY || !api_value_count(value))
        api_value_fault(value, problem,
                        API_CODE_WRONG_COUNT "must be an array of at least one name");
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        int output = 0;
        if (api_field_word(&item, api_response_outputs, &output, problem) <= 0) continue;
        if (asked->output[output])
            api_value_fault(&item, problem, API_CODE_DUPLICATE "\"%s\" is in the list already",
                            api_response_outputs[output]);
        if (output == API_RESPONSE_TRANSMISSIBILITY && asked->tree.tree && !shakes(asked))
            api_value_fault(&item, problem,
                            API_CODE_MISSING
                            "needs a shaken pivot: drive the pivot, or leave it out");
        if (output == API_RESPONSE_CART && asked->tree.tree && !asked->tree.cart)
            api_value_fault(
                &item, problem,
                API_CODE_NOT_APPLICABLE
                "is the position of a cart, but the pendulum has no cart: leave it out");
        asked->output[output] = 1;
    }
    if (api_value_count(value) == 1 && asked->output[API_RESPONSE_PHI]) api_value_usual(value);
}

static void read_poles(struct api_response *asked, const struct api_value *value,
                       const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    const struct pend_loads *loads = &asked->tree.loads;
    if (api_field_truth(value, &asked->poles, problem) <= 0) return;
    if (!asked->poles) api_value_usual(value);
    int loses = loads->terms && !pend_terms_conserve(loads->terms, loads->value);
    int most = loses ? API_POLES_DAMPED : API_POLES_ARMS;
    if (asked->poles && api_tree_stored(&asked->tree) > most)
        api_value_fault(value, problem,
                        API_CODE_LIMIT
                        "poles are found for at most %d arms, or %d without friction and drives, "
                        "but this pendulum has %d: leave it out",
                        API_POLES_DAMPED, API_POLES_ARMS, asked->tree.n);
    if (asked->poles) api_reading_check_json(reading, value, "poles are", "leave it out");
}

enum pend_status api_response_read(struct api_response *asked, const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(root, "initial");
    long rounded = 0;
    *asked = (struct api_response){.arm = -1};
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &asked->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (present(&initial) && status == PEND_OK)
        PEND_TRY(api_states_new(&asked->start, 1, api_tree_stored(&asked->tree)));
    api_states_read(asked->start, 0, &initial, &asked->tree, reading->limits, problem);
    read_drive(asked, API_MEMBER(root, "drive"), problem);
    PEND_TRY(read_omega(asked, API_MEMBER(root, "omega"), reading));
    read_output(asked, API_MEMBER(root, "output"), problem);
    read_poles(asked, API_MEMBER(root, "poles"), reading);
    (void)api_field_whole(API_MEMBER(root, "digits"), 1, 17, &rounded, problem);
    asked->digits = (int)rounded;
    return problem->status ? PEND_INVALID : PEND_OK;
}

void api_response_clear(struct api_response *asked) {
    free(asked->list);
    api_states_free(&asked->start);
    api_tree_clear(&asked->tree);
}

#include "api/op/varied.h"

#include <assert.h>
#include <string.h>

#include "api/read/terms_fields.h"

/* names after those of the arms' terms: in the order of enum pend_term_one, then the numbers of
 * harmonics */
static const char *const names[API_VARIED - PEND_TERM_OWN_ROWS] = {
    "drag_per_mass",    "pivot_acceleration_x", "pivot_acceleration_y", "cart_angle",
    "torque_amplitude", "torque_omega",         "torque_phase",         "pivot_x_amplitude",
    "pivot_x_omega",    "pivot_x_phase",        "pivot_y_amplitude",    "pivot_y_omega",
    "pivot_y_phase",
};

enum { ONES = PEND_TERM_OWN_ROWS, WAVES = PEND_TERM_OWN_ROWS + PEND_TERM_OWN_ONES };

const char *api_varied_name(int i) {
    assert(i >= 0 && i < API_VARIED);
    return i < ONES ? api_terms_varied((enum pend_term_row)i) : names[i - ONES];
}

/* Returns true if the name ("phi", "phid" or "mass") is also that of a number of a cart. O(1). */
static int target_of_cart(const char *name) {
    static const char *const of_cart[] = {
        "phi",          "phid",        "mass", "damping", "stiffness", "torque", "torque_amplitude",
        "torque_omega", "torque_phase"};
    assert(name);
    for (size_t i = 0; i < sizeof of_cart / sizeof *of_cart; i++)
        if (!strcmp(name, of_cart[i])) return 1;
    return 0;
}

int api_varied_of_arm(int i) { return i < ONES || (i >= WAVES && i < WAVES + 3); }

int api_varied_place(const struct api_tree *tree, int i, int arm, int harmonic) {
    const struct pend_terms *terms = tree->loads.terms;
    assert(i >= 0 && i < API_VARIED && harmonic >= 1);
    if (!terms || (api_varied_of_arm(i) && arm < 0)) return -1;
    if (i == PEND_TERM_AT_X || i == PEND_TERM_AT_Y)
        if (!terms->hung[arm]) return -1;
    if (i < ONES) return pend_terms_place(terms, (enum pend_term_row)i, arm);
    if (i < WAVES) return terms->one[i - ONES];
    static const int pivots[] = {0, PEND_DRIVE_PIVOT_X, PEND_DRIVE_PIVOT_Y};
    int what = (i - WAVES) / 3, drives = what ? pivots[what] : arm;
    for (int j = 0; j < terms->harmonics; j++)
        if (terms->harmonic[j].drives == drives && !--harmonic)
            return terms->harmonic[j].at + (i - WAVES) % 3;
    return -1;
}

static const char *const quantities[] = {"phi",    "theta", "phid",   "thetad",
                                         "length", "mass",  "gravity"};

static void target_arm(const struct api_value *value, const struct api_tree *tree, const char *name,
                       int of_arm, struct api_target *out, struct api_problem *problem) {
    if (!of_arm) {
        if (api_value_kind(value) != API_MISSING)
            api_value_fault(value, problem,
                            API_CODE_CONFLICT "cannot be combined with %s, which all arms share",
                            name);
        return;
    }
    const char *text = api_value_text(value);
    if (tree->cart && text && !strcmp(text, "cart")) {
        out->arm = 0; // a cart is the first stored arm
        return;
    }
    int arm = api_tree_read_arm(tree, value, problem);
    if (arm >= 0) out->arm = tree->tree->place[arm];
}

static void target_term(const struct api_value *value, const struct api_value *vary, int term,
                        const struct api_tree *tree, struct api_target *out,
                        struct api_problem *problem) {
    struct api_value field = api_value_member(value, "harmonic");
    long harmonic = 1;
    if (api_field_whole(&field, 1, 1000, &harmonic, problem) < 0) return;
    api_value_usual_number(&field, 1);
    if (!tree->tree || problem->status) return;
    out->place = api_varied_place(tree, term, out->arm, (int)harmonic);
    if (out->place < 0)
        api_value_fault(vary, problem,
                        API_CODE_UNKNOWN_NAME "varies a number that is absent in this pendulum: "
                                              "set it in \"pendulum\" to a value other than 0");
}

int api_target_read(struct api_target *target, const struct api_value *value,
                    const struct api_tree *tree, struct api_problem *problem) {
    struct api_value vary = api_value_member(value, "vary");
    const char *list[API_VARY_TERM + API_VARIED + 1];
    int chosen = 0;
    *target = (struct api_target){.arm = -1, .place = -1};
    for (int i = 0; i < API_VARY_TERM; i++) list[i] = quantities[i];
    for (int i = 0; i < API_VARIED; i++) list[API_VARY_TERM + i] = api_varied_name(i);
    list[API_VARY_TERM + API_VARIED] = NULL;
    if (!api_field_needed(&vary, problem) || api_field_word(&vary, list, &chosen, problem) < 0)
        return 0;
    int term = chosen - API_VARY_TERM;
    target->quantity = term >= 0 ? API_VARY_TERM : (enum api_quantity)chosen;
    target_arm(API_MEMBER(value, "arm"), tree, list[chosen],
               term >= 0 ? api_varied_of_arm(term) : chosen != API_VARY_GRAVITY, target, problem);
    if (tree->cart && target->arm == 0 && !target_of_cart(list[chosen]))
        api_value_fault(
            &vary, problem,
            API_CODE_UNKNOWN_NAME
            "is not a number of a cart, which has \"mass\", \"damping\", \"stiffness\", \"torque\" "
            "for the force along its rail, its position \"phi\" and its velocity \"phid\"");
    if (term >= 0) target_term(value, &vary, term, tree, target, problem);
    return 1;
}

struct pend_parameter api_target_parameter(const struct api_target *target) {
    static const enum pend_parameter_kind kinds[API_VARY_COUNT] = {
        [API_VARY_PHI] = PEND_PARAMETER_PHI,         [API_VARY_THETA] = PEND_PARAMETER_PHI,
        [API_VARY_PHID] = PEND_PARAMETER_RATE,       [API_VARY_THETAD] = PEND_PARAMETER_RATE,
        [API_VARY_LENGTH] = PEND_PARAMETER_LENGTH,   [API_VARY_MASS] = PEND_PARAMETER_MASS,
        [API_VARY_GRAVITY] = PEND_PARAMETER_GRAVITY, [API_VARY_TERM] = PEND_PARAMETER_TERM};
    enum pend_parameter_kind kind = kinds[target->quantity];
    int at = kind == PEND_PARAMETER_TERM ? target->place : target->arm;
    return (struct pend_parameter){kind, at < 0 ? 0 : at};
}

#include "api/read/method_json.h"

#include <math.h>

#include "core/integrate/pieces/pieces.h"

enum { METHODS = 15 };

static const struct pend_method *read_method(const struct api_value *value,
                                             struct api_problem *problem) {
    const char *names[METHODS + 1] = {0};
    int chosen = 0;
    for (int i = 0; i < METHODS && pend_method_at(i); i++) names[i] = pend_method_at(i)->name;
    int found = api_field_word(value, names, &chosen, problem);
    if (found > 0 && !chosen) api_value_usual(value);
    return found < 0 ? NULL : pend_method_at(chosen);
}

/* reads a setting that only methods with the flag support; returns true if it is present */
static int read_setting(const struct api_value *value, const struct pend_method *method,
                        unsigned flag, double least, double most, double *out,
                        struct api_problem *problem) {
    double x = 0;
    if (api_value_read_number(value, -INFINITY, INFINITY, "", &x, problem) <= 0 || !method)
        return 0;
    if (!(method->flags & flag))
        api_value_fault(value, problem,
                        API_CODE_NOT_APPLICABLE "has no meaning for method %s: leave it out",
                        method->name);
    else if (!(x >= least && x <= most))
        api_value_fault(value, problem,
                        API_CODE_OUT_OF_RANGE
                        "must be from %.15g to %.15g for method %s, got %.15g",
                        least, most, method->name, x);
    else
        *out = x;
    return 1;
}

/* the method in the requested precision; NULL if the method does not support it */
static const struct pend_method *read_precision(const struct api_value *value,
                                                const struct pend_method *method,
                                                struct api_problem *problem) {
    static const char *const words[] = {"double", "extended", NULL};
    int chosen = 0;
    int found = api_field_word(value, words, &chosen, problem);
    if (found > 0 && !chosen) api_value_usual(value);
    if (found < 0) return NULL;
    if (!chosen || !method) return method;
    if (!method->extended)
        api_value_fault(value, problem, API_CODE_UNSUPPORTED "\"%s\" needs method taylor, not %s",
                        words[chosen], method->name);
    return method->extended;
}

void api_method_read(struct api_method *method, const struct api_value *root,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem) {
    static const struct pend_method none = {.name = "", .flags = 0};
    struct api_value name = api_value_member(root, "method");
    struct api_value rtol = api_value_member(root, "rtol"), atol = api_value_member(root, "atol");
    *method = (struct api_method){.method = read_precision(API_MEMBER(root, "precision"),
                                                           read_method(&name, problem), problem)};
    const struct pend_method *known = method->method, *range = known ? known : &none;
    api_value_usual_number(&rtol, range->rtol_default);
    (void)read_setting(&rtol, known, PEND_METHOD_TOLERANCES, range->rtol_min, range->rtol_max,
                       &method->rtol, problem);
    // the default of each tolerance is the value of the other tolerance
    api_value_usual_number(
        &atol, pend_method_atol(range, method->rtol > 0 ? method->rtol : range->rtol_default));
    method->atol_given = read_setting(&atol, known, PEND_METHOD_TOLERANCES, range->atol_min,
                                      range->atol_max, &method->atol, problem);
    (void)read_setting(API_MEMBER(root, "step"), known, PEND_METHOD_FIXED_STEP, range->step_min,
                       range->step_max, &method->step, problem);
    method->accuracy = api_accuracy_read(root, problem);
    if (known && known->flags & PEND_METHOD_LINEAR) {
        api_tree_ideal(tree, &name, "method linear", problem);
        api_tree_modes_allowed(tree, &name, tree->n, "method linear", limits, problem);
    }
    int extended = known == pend_method_taylor.extended;
    if (known && !pend_pieces_method(known, tree->terms))
        api_value_fault(
            extended ? API_MEMBER(root, "precision") : &name, problem,
            extended ? API_CODE_UNSUPPORTED
                "dry friction without a \"speed\" and stops are computed in double precision: "
                "leave it out; an rtol of 1e-15 gives the most digits"
                     : API_CODE_UNSUPPORTED
                "motions in pieces, by tables, controllers, dry friction or stops, are computed "
                "by \"taylor\": leave it out; an rtol of 1e-15 gives the most digits");
    const struct pend_loads *loads = &tree->loads;
    if (known && known->flags & PEND_METHOD_CONSERVES && loads->terms &&
        !pend_terms_conserve(loads->terms, loads->value))
        api_value_fault(&name, problem,
                        API_CODE_UNSUPPORTED
                        "\"%s\" conserves the energy, also of springs, rods and bodies, so it does "
                        "not support friction, drag, torques or a moving pivot: use \"taylor\", or "
                        "\"rkf45\", \"rk8pd\", \"msadams\" or \"ode23\"",
                        known->name);
}

const char *api_method_advice(const struct api_method *method) {
    const struct pend_method *known = method->method;
    if (known->flags & PEND_METHOD_LINEAR) return "Use method taylor.";
    if (known->flags & PEND_METHOD_FIXED_STEP)
        return "Method taylor with precision extended stays accurate longer.";
    if (known == pend_method_taylor.extended) return "Use a smaller rtol or a shorter time.";
    if (known->extended)
        return "With a smaller rtol or precision extended it stays accurate longer.";
    if (known == &pend_method_radau) return "With a smaller rtol it stays accurate longer.";
    return "With a smaller rtol or method taylor it stays accurate longer.";
}

double api_accuracy_read(const struct api_value *root, struct api_problem *problem) {
    static const double usual = 1e-6, least = 1e-12, most = 1;
    struct api_value field = api_value_member(root, "accuracy");
    double accuracy = usual;
    api_value_usual_number(&field, usual);
    (void)api_value_read_number(&field, least, most, "", &accuracy, problem);
    return accuracy;
}

#include "api/op/fits_unknowns.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "api/op/varied.h"

static const double pi = 3.14159265358979323846;

static const char *const unknown_fields[] = {"vary", "arm",  "harmonic", "start",
                                             "low",  "high", "unit",     NULL};
static const char *const angle_units[] = {"rad", "deg", NULL};

/* where the pendulum or its start has the number */
static double target_value(const struct api_fit *fit, const struct api_target *target) {
    const struct pend_tree *tree = fit->tree.tree;
    switch (target->quantity) {
    case API_VARY_PHI:
    case API_VARY_THETA:
        return fit->start->phi[target->arm];
    case API_VARY_PHID:
    case API_VARY_THETAD:
        return fit->start->rate[target->arm];
    case API_VARY_LENGTH:
        return tree->len[target->arm];
    case API_VARY_MASS:
        return tree->mass[target->arm];
    case API_VARY_GRAVITY:
        return fit->tree.loads.gravity;
    case API_VARY_TERM:
        return fit->tree.value[target->place];
    default:
        break;
    }
    return 0;
}

static struct pend_parameter target_parameter(const struct api_target *target) {
    static const enum pend_parameter_kind kinds[] = {
        PEND_PARAMETER_PHI,    PEND_PARAMETER_PHI,  PEND_PARAMETER_RATE,    PEND_PARAMETER_RATE,
        PEND_PARAMETER_LENGTH, PEND_PARAMETER_MASS, PEND_PARAMETER_GRAVITY, PEND_PARAMETER_TERM};
    int term = target->quantity == API_VARY_TERM;
    int at = term ? target->place : target->arm;
    return (struct pend_parameter){kinds[target->quantity], at < 0 ? 0 : at};
}

/* 0 for what may not be negative */
static double target_least(const struct api_fit *fit, const struct api_target *target) {
    if (target->quantity == API_VARY_LENGTH || target->quantity == API_VARY_MASS) return 0;
    if (target->quantity != API_VARY_TERM) return -INFINITY;
    return pend_terms_fits(fit->tree.terms, target->place, -1) ? -INFINITY : 0;
}

/* start and bounds in the request's unit, of which the fit's is `scale` times, plus `shift` */
static void read_bounds(const struct api_value *item, double scale, double shift, int late,
                        struct pend_fit_unknown *u, struct api_problem *problem) {
    struct api_value start = api_value_member(item, "start"), low = api_value_member(item, "low"),
                     high = api_value_member(item, "high");
    double given;
    assert(scale > 0);
    // a start that is taken from the data is not known yet
    if (late) u->start = NAN;
    if (api_value_read_number(&start, -INFINITY, INFINITY, "", &given, problem) > 0)
        u->start = scale * given + shift;
    if (api_value_read_number(&low, -INFINITY, INFINITY, "", &given, problem) > 0)
        u->low = fmax(u->low, scale * given + shift);
    if (api_value_read_number(&high, -INFINITY, INFINITY, "", &given, problem) > 0)
        u->high = scale * given + shift;
    int inside = u->low < u->high && !(u->start < u->low) && !(u->start > u->high);
    if (inside) return;
    api_value_fault(item, problem,
                    API_CODE_OUT_OF_RANGE
                    "starts at %.6g, which must lie between its bounds %.6g and %.6g: give it "
                    "another \"start\"",
                    u->start - shift, u->low - shift, u->high - shift);
}

/* "length of arm 2" */
static void unknown_label(const struct api_fit *fit, const struct api_value *vary, int arm,
                          char label[API_FIT_LABEL]) {
    assert(arm < fit->tree.n);
    int at = snprintf(label, API_FIT_LABEL, "%s", api_value_text(vary));
    if (arm < 0) return;
    snprintf(label + at, API_FIT_LABEL - (size_t)at, " of arm %d", fit->tree.tree->order[arm] + 1);
}

static void read_unknown(struct api_fit *fit, const struct api_value *item,
                         struct api_problem *problem) {
    struct api_value unit = api_value_member(item, "unit"), vary = api_value_member(item, "vary");
    struct api_target target;
    int degrees = 0, faults = problem->count;
    if (!api_field_object(item, problem)) return;
    (void)api_value_only(item, unknown_fields, problem);
    if (!api_target_read(&target, item, &fit->tree, problem) || problem->count > faults) return;
    // behind as many faults as are told a further one is only counted elsewhere
    int term = target.quantity == API_VARY_TERM, all = target.quantity == API_VARY_GRAVITY;
    if (term ? target.place < 0 : !all && target.arm < 0) return;
    int angle = target.quantity <= API_VARY_THETAD;
    if (api_field_word(&unit, angle_units, &degrees, problem) > 0 && !angle)
        api_value_fault(&unit, problem,
                        API_CODE_NOT_APPLICABLE "is for angles and their rates: leave it out");
    // bounds of theta are those of phi + pi / 2
    double scale = degrees ? pi / 180 : 1, shift = target.quantity == API_VARY_THETA ? -pi / 2 : 0;
    struct pend_fit_unknown u = {.camera = -1, .by = target_parameter(&target)};
    u.start = target_value(fit, &target), u.low = target_least(fit, &target), u.high = INFINITY;
    read_bounds(item, scale, shift, fit->guessed && angle, &u, problem);
    unknown_label(fit, &vary, target.arm, fit->label[fit->unknowns]);
    fit->shift[fit->unknowns] = 0 - shift;
    fit->unknown[fit->unknowns++] = u;
}

void api_fit_read_unknowns(struct api_fit *fit, const struct api_value *list,
                           struct api_problem *problem) {
    int count = api_value_count(list);
    if (api_value_kind(list) != API_MISSING &&
        (api_value_kind(list) != API_ARRAY || count > API_FIT_UNKNOWNS - PEND_FIT_CAMERA)) {
        api_value_fault(list, problem,
                        API_CODE_WRONG_COUNT "must be an array of at most %d unknowns",
                        API_FIT_UNKNOWNS - PEND_FIT_CAMERA);
        return;
    }
    struct api_value item = api_value_item(list, 0);
    for (; fit->start && api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        read_unknown(fit, &item, problem);
}

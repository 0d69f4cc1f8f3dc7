#include "api/op/fit/fits_modes.h"

#include <assert.h>
#include <math.h>

static const double pi = 3.14159265358979323846;

static const char *const mode_fields[] = {"mode", "omega", "frequency", "period", "sigma", NULL};

static void read_mode(struct api_fit *fit, const struct api_value *item,
                      struct pend_fit_column *column, double *to, struct api_problem *problem) {
    struct api_value mode = api_value_member(item, "mode"), sigma = api_value_member(item, "sigma");
    long number = 1;
    int found = 0;
    double error = 0, x;
    *column = (struct pend_fit_column){.kind = PEND_FIT_MODE, .data = to};
    if (!api_field_object(item, problem)) return;
    (void)api_value_only(item, mode_fields, problem);
    if (api_field_needed(&mode, problem))
        (void)api_field_whole(&mode, 1, fit->tree.n, &number, problem);
    column->arm = (int)number - 1;
    (void)api_value_read_number(&sigma, 1e-12, 1e12, "", &error, problem);
    for (int i = 1; i <= 3; i++) {
        struct api_value value = api_value_member(item, mode_fields[i]);
        if (api_value_kind(&value) == API_MISSING) continue;
        if (found++)
            api_value_fault(
                &value, problem,
                API_CODE_CONFLICT
                "is one quantity too many: give only one of omega, frequency and period");
        if (api_value_read_number(&value, 1e-9, 1e9, "", &x, problem) <= 0) continue;
        // the ratio of the angular frequency to the given number, and the derivative
        double scale = i == 1 ? 1 : 2 * pi;
        *to = i == 3 ? scale / x : scale * x;
        column->sigma = error * (i == 3 ? scale / (x * x) : scale);
    }
    if (!found)
        api_value_fault(item, problem, API_CODE_MISSING "needs one of omega, frequency and period");
}

void api_fit_read_modes(struct api_fit *fit, const struct api_value *list, int first,
                        struct api_problem *problem) {
    assert(first >= 0 && first <= fit->columns);
    if (fit->tree.n > PEND_FIT_MODE_ARMS)
        api_value_fault(list, problem,
                        API_CODE_UNSUPPORTED
                        "modes can be data only for pendulums of at most %d arms",
                        PEND_FIT_MODE_ARMS);
    if (!fit->tree.terms && !(fit->tree.loads.gravity > 0))
        api_value_fault(list, problem,
                        API_CODE_NOT_APPLICABLE
                        "need a hanging pendulum: without gravity above 0 it does not swing");
    struct api_value item = api_value_item(list, 0);
    for (int c = first; c < fit->columns; c++, item = api_value_next(&item))
        read_mode(fit, &item, &fit->column[c], fit->data + (size_t)c * (size_t)fit->rows, problem);
}

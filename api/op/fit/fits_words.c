#include "api/op/fit/fits_words.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "api/json/json_out.h"

enum { WORDS_END = 600 };

/* relative error up to which a frequency counts as reached */
static const double words_met = 1e-6;

static const char *const ends[] = {[PEND_FIT_CONVERGED] = "converged",
                                   [PEND_FIT_STRANGE] = "converged",
                                   [PEND_FIT_STOPPED] = "no_minimum",
                                   [PEND_FIT_AWAY] = "no_minimum"},
                         *const models[] = {[PEND_FIT_ACCEPTED] = "accepted",
                                            [PEND_FIT_UNDECIDED] = "undecided",
                                            [PEND_FIT_REJECTED] = "rejected"};

/* a test rejects the model below the first p-value; above the second, chi-squared is too small to
 * be chance */
static const double words_level = 1e-3, words_small = 1 - 1e-6;

enum pend_status api_fit_write_direction(const struct api_fit *fit, const double direction[],
                                         struct api_buffer *out) {
    char text[400];
    size_t at = 0;
    int parts = 0, alike = 1;
    for (int j = 0; j < fit->unknowns; j++) {
        if (fabs(direction[j]) < 1e-3) continue;
        parts++;
        alike &= fabs(direction[j] - 1) < 1e-2;
    }
    assert(parts >= 1);
    const char *begin = parts == 1 ? "the data do not depend on "
                        : alike    ? "the data determine only the ratios of "
                                   : "the data do not distinguish ";
    at = (size_t)snprintf(text, sizeof text, "%s", begin);
    for (int j = 0, some = 0; j < fit->unknowns && at < sizeof text; j++) {
        if (fabs(direction[j]) < 1e-3) continue;
        const char *between = !some++ ? "" : some == parts ? " and " : ", ";
        at += (size_t)snprintf(text + at, sizeof text - at, "%s%s", between, fit->label[j]);
        if (parts > 1 && !alike && at < sizeof text)
            at += (size_t)snprintf(text + at, sizeof text - at, " (by %.3g)", direction[j]);
    }
    return api_out_text(out, NULL, text);
}

/* writes how long the motions follow the data if no minimum was found */
static int end_follows(const struct api_fit *fit, const struct pend_fit_result *r, char text[]) {
    int whole = 0;
    double last = fit->t[fit->rows - 1];
    for (int run = 0; run < fit->runs; run++) {
        double end = NAN;
        for (long i = fit->rows; i-- > 0 && isnan(end);)
            if (fit->of[i] == run) end = fit->t[i];
        whole += r->follows[run] == end;
    }
    if (fit->columns == fit->modes)
        return snprintf(text, WORDS_END,
                        "no minimum was found. A better start, more iterations, or fewer unknowns, "
                        "may help.");
    if (fit->runs > 1)
        return snprintf(text, WORDS_END,
                        "no minimum was found: %d of %d motions follow their data to the end, even "
                        "with start values fitted to each run alone. A better start for the others,"
                        " or fewer rows, may help.",
                        whole, fit->runs);
    int at = snprintf(text, WORDS_END, "no minimum was found");
    if (r->iterations >= fit->iterations)
        at += snprintf(text + at, WORDS_END - (size_t)at, " in %ld iterations", r->iterations);
    if (r->follows[0] < last)
        return at + snprintf(text + at, WORDS_END - (size_t)at,
                             ": the motion follows the data until t = %.6g s of %.6g s. Fewer rows,"
                             " or a better start, may help.",
                             r->follows[0], last);
    return at + snprintf(text + at, WORDS_END - (size_t)at,
                         ": the sum of squares still falls. The motion explains %.6g %% of the "
                         "variance. A better start%s, or fewer unknowns, may help.",
                         100 * fmax(r->explained, 0),
                         r->iterations >= fit->iterations ? ", more \"iterations\"" : "");
}

/* finds the mode whose frequency has the largest relative error; 0 if all errors are small */
static int end_mode(const struct api_fit *fit, const struct pend_fit_result *r, double *off,
                    double *asked) {
    int mode = 0;
    *off = *asked = 0;
    for (int c = fit->columns - fit->modes; c < fit->columns; c++) {
        const struct pend_fit_column *column = &fit->column[c];
        double wanted = column->data[0];
        double gap = r->residual[c] * pend_fit_sigma(column, 0) / wanted;
        if (!(fabs(gap) > fmax(words_met, fabs(*off)))) continue;
        mode = column->arm + 1, *off = gap, *asked = wanted;
    }
    return mode;
}

/* appends frequencies that are not reached, and whether the fit can be checked */
static int end_checked(const struct api_fit *fit, const struct pend_fit_result *r, char text[],
                       size_t bytes) {
    double off, asked;
    int mode = end_mode(fit, r, &off, &asked), at = 0, known = 1;
    for (int c = 0; c < fit->columns; c++) known &= pend_fit_known(&fit->column[c]);
    if (mode)
        at = snprintf(text, bytes,
                      ". Not all frequencies are reached: mode %d has %.6g rad/s, %.3g %% %s %.6g",
                      mode, asked * (1 + off), 100 * fabs(off), off > 0 ? "above" : "below", asked);
    if (r->p_value > words_small)
        at += snprintf(
            text + at, bytes - (size_t)at,
            ". Chi-squared is only %.3g per degree of freedom: the errors are smaller than sigma",
            r->chi_squared / (double)r->freedom);
    if (r->freedom > 0) return at;
    return at +
           snprintf(text + at, bytes - (size_t)at,
                    ". There are as many unknowns as measurements: the fit cannot be checked%s",
                    known ? "" : ", and has no standard errors");
}

/* appends the measurement with the largest residual, in sigmas if known, within one run */
static void end_farthest(const struct api_fit *fit, const struct pend_fit_result *r, char text[],
                         size_t bytes) {
    static const char *const names[] = {
        [PEND_FIT_PHI] = "the angle of arm", [PEND_FIT_X] = "x of arm", [PEND_FIT_Y] = "y of arm"};
    double most = 0;
    int known = pend_fit_known(&fit->column[0]), angle = fit->column[0].kind == PEND_FIT_PHI;
    // without sigmas, residuals of angles and positions cannot be compared
    for (int c = 1; c < fit->columns - fit->modes; c++)
        if (pend_fit_known(&fit->column[c]) != known ||
            (!known && angle != (fit->column[c].kind == PEND_FIT_PHI)))
            return;
    for (long i = 0; i < fit->rows && fit->runs == 1; i++)
        for (int c = 0; c < fit->columns - fit->modes; c++) {
            const struct pend_fit_column *column = &fit->column[c];
            double off = fabs(r->residual[i * fit->columns + c]);
            if (!(off > most) || (size_t)column->kind >= sizeof names / sizeof *names) continue;
            most = off;
            snprintf(text, bytes, " The farthest is %s %d at t = %.6g s, %.3g%s off.",
                     names[column->kind], column->arm + 1, fit->t[i], off,
                     known                          ? " sigma"
                     : column->kind == PEND_FIT_PHI ? " rad"
                                                    : "");
        }
}

/* writes which tests reject the model, and whether the errors are valid */
static int end_rejected(const struct pend_fit_result *r, char text[], size_t bytes) {
    int at = 0, tests = 0;
    double spread = r->chi_squared / (double)r->freedom;
    if (!(r->explained > 0.9))
        at += snprintf(text + at, bytes - (size_t)at, "%s it explains %.3g %% of the variance",
                       tests++ ? "," : ":", 100 * fmax(r->explained, 0));
    if (r->p_value < words_level)
        at += snprintf(text + at, bytes - (size_t)at,
                       "%s chi-squared is %.4g per degree of freedom (p = %.1g)",
                       tests++ ? "," : ":", spread, r->p_value);
    if (r->alike < words_level)
        at += snprintf(text + at, bytes - (size_t)at,
                       "%s consecutive residuals are correlated (Durbin-Watson %.2g; independent "
                       "noise gives 2)",
                       tests++ ? "," : ":", r->watson);
    if (tests == 1 && r->p_value < words_level && !r->outliers)
        at += snprintf(text + at, bytes - (size_t)at,
                       " while the residuals are independent: is sigma %.3g times as large?",
                       sqrt(spread));
    const char *end = text[at - 1] == '?' ? "" : ".";
    if (isinf(r->widened))
        return at + snprintf(text + at, bytes - (size_t)at, "%s The standard errors are not valid.",
                             end);
    if (!(r->widened >= 1.005)) return at + snprintf(text + at, bytes - (size_t)at, "%s", end);
    return at + snprintf(text + at, bytes - (size_t)at,
                         "%s Standard errors are increased, up to %.3g times.", end, r->widened);
}

static void end_minimum(const struct api_fit *fit, const struct pend_fit_result *r, char text[]) {
    int modes = fit->columns == fit->modes, strange = r->model == PEND_FIT_REJECTED;
    const char *begin = r->model == PEND_FIT_ACCEPTED ? "a minimum, whose motion follows the data"
                        : r->freedom < 1              ? "a minimum"
                        : r->explained > 0.9
                            ? "a minimum, with too few measurements to test the model"
                            : "a minimum, but the noise of the data is as large as the motion";
    if (modes)
        begin = strange
                    ? "no pendulum near the given start has these frequencies: this one comes "
                      "closest"
                    : "a minimum: the pendulum near the given start with the closest frequencies";
    else if (strange)
        begin = "a minimum, but the model is rejected";
    int at = snprintf(text, WORDS_END, "%s", begin);
    if (!strange || modes) {
        (void)end_checked(fit, r, text + at, (size_t)(WORDS_END - at));
        return;
    }
    at += end_rejected(r, text + at, (size_t)(WORDS_END - at));
    end_farthest(fit, r, text + at, (size_t)(WORDS_END - at));
    assert(at > 0 && at < WORDS_END);
}

enum pend_status api_fit_write_end(const struct api_fit *fit, const struct pend_fit_result *r,
                                   struct api_buffer *out) {
    char text[WORDS_END];
    assert((size_t)r->end < sizeof ends / sizeof *ends && fit->rows >= 1);
    if (r->end == PEND_FIT_STOPPED)
        (void)end_follows(fit, r, text);
    else if (r->end == PEND_FIT_AWAY)
        snprintf(text, sizeof text,
                 "no minimum was found: the sum of squares keeps falling as %s grows or shrinks "
                 "without limit, here to %.6g, where the data no longer determine it. Give it a "
                 "\"high\" and a \"low\", or leave it out.",
                 fit->label[r->away], r->value[r->away] + fit->shift[r->away]);
    else
        end_minimum(fit, r, text);
    PEND_TRY(api_out_text(out, "status", ends[r->end]));
    PEND_TRY(api_out_text(out, "model", models[r->model]));
    return api_out_text(out, "message", text);
}

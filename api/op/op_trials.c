/* POST /v1/trials: a law between two columns of a table of trials: a line y = a + b x, a power
 * y = a x^b, or the period of an ideal pendulum, 2 pi sqrt(l / g) / agm(1, cos(amplitude / 2))
 * (Gauss). Each is a straight line in suitable X and Y, so that least squares have a closed form.
 * Leaves to others: fits of motions (op/fit).
 * Invariant: trials without y are predicted and do not count. */
#include "api/op/op.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "api/json/json_out.h"
#include "core/modes/swing.h"

enum { LENGTH, MASS, AMPLITUDE, PERIOD, COLUMNS, MOST_TRIALS = 5000 };
enum { LINE, POWER, PENDULUM };

static const char *const fields[] = {"trials", "law", "x", "y", "sigma", "unit", NULL};
static const char *const columns[] = {"length", "mass", "amplitude", "period", NULL};
static const char *const laws[] = {"line", "power", "pendulum", NULL};
static const char *const names[][2] = {{"slope", "intercept"}, {"exponent", "factor"}, {"gravity"}};

struct trial {
    double number[COLUMNS]; /* m, kg, rad, s; NaN = not measured */
    double x, y, weight;    /* X, Y and 1 / (variance of Y); 0 = not measured */
    double slow;            /* agm(1, cos(amplitude / 2)), the ratio of a small swing's period to
                             * that of this swing */
};

/* Y = mean + slope (X - center); w: sum of the weights; xx: weighted sum of squares about the
 * center */
struct trials {
    int law, x, y;
    double sigma; /* standard deviation of y; 0 = unknown */
    long count, used;
    struct trial *trial;
    double center, mean, slope, w, xx, chi_squared;
};

static void trials_clear(void *state) { free(((struct trials *)state)->trial); }

static void trial_read(struct trials *trials, const struct api_value *item, double degree,
                       struct api_problem *problem) {
    static const char *const unit[] = {"m", "kg", "", "s"};
    struct trial *t = &trials->trial[trials->count++];
    double slope = 1;
    (void)api_field_object(item, NULL, problem);
    (void)api_value_only(item, columns, problem);
    for (int k = 0; k < COLUMNS; k++) {
        struct api_value value = api_value_member(item, columns[k]);
        t->number[k] = NAN;
        // null stands for an empty cell
        if (api_value_kind(&value) != API_NULL)
            (void)api_value_read_number(&value, 0, k == AMPLITUDE ? 3.14 / degree : 1e9, unit[k],
                                        &t->number[k], problem);
    }
    double x = t->number[trials->x], y = t->number[trials->y], wide = t->number[AMPLITUDE];
    t->slow = isnan(wide) ? 1 : pend_swing_slow(wide * degree);
    t->x = x, t->y = y;
    if (trials->law == POWER) t->x = log(x), t->y = log(y), slope = 1 / y;
    if (trials->law == PENDULUM) t->y = pow(y * t->slow, 2), slope = 2 * y * t->slow * t->slow;
    t->weight = isnan(y) ? 0 : pow(slope, -2);
    if (isnan(y)) t->y = 0;
    if (isfinite(t->x) && isfinite(t->y) && isfinite(t->weight)) return;
    api_value_fault(item, problem,
                    API_CODE_OUT_OF_RANGE
                    "needs %s, and %s or null; for a power or a pendulum they must be above 0",
                    columns[trials->x], columns[trials->y]);
}

static void trials_fit(struct trials *trials) {
    const struct trial *end = trials->trial + trials->count;
    double xy = 0;
    for (const struct trial *t = trials->trial; t < end; t++) {
        trials->used += t->weight > 0, trials->w += t->weight;
        // the line of a pendulum goes through the origin
        if (trials->law == PENDULUM || !(t->weight > 0)) continue;
        trials->center += (t->x - trials->center) * t->weight / trials->w;
        trials->mean += (t->y - trials->mean) * t->weight / trials->w;
    }
    for (const struct trial *t = trials->trial; t < end; t++) {
        trials->xx += t->weight * pow(t->x - trials->center, 2);
        xy += t->weight * (t->x - trials->center) * (t->y - trials->mean);
    }
    trials->slope = xy / trials->xx;
    for (const struct trial *t = trials->trial; t < end; t++)
        trials->chi_squared +=
            t->weight * pow(t->y - trials->mean - trials->slope * (t->x - trials->center), 2);
}

static enum pend_status trials_read(void *state, const struct api_reading *reading) {
    struct trials *trials = state;
    struct api_problem *problem = reading->problem;
    const struct api_value *root = reading->root;
    struct api_value list = api_value_member(root, "trials"), item = api_value_item(&list, 0),
                     law = api_value_member(root, "law"), x = api_value_member(root, "x"),
                     y = api_value_member(root, "y"), unit = api_value_member(root, "unit"),
                     sigma = api_value_member(root, "sigma");
    int count = api_value_count(&list), degrees = 0;
    trials->law = PENDULUM, trials->x = LENGTH, trials->y = PERIOD;
    (void)api_value_only(root, fields, problem);
    (void)api_field_word(&law, laws, &trials->law, problem);
    (void)api_field_word(&x, columns, &trials->x, problem);
    (void)api_field_word(&y, columns, &trials->y, problem);
    (void)api_field_word(&unit, api_field_angles, &degrees, problem);
    (void)api_value_read_number(&sigma, 1e-12, 1e12, "", &trials->sigma, problem);
    if (trials->law == PENDULUM && (trials->x != LENGTH || trials->y != PERIOD))
        api_value_fault(&law, problem, API_CODE_CONFLICT "needs x \"length\" and y \"period\"");
    if (api_value_kind(&list) != API_ARRAY || count < 1 || count > MOST_TRIALS)
        api_value_fault(&list, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d trials",
                        MOST_TRIALS);
    if (problem->status) return PEND_INVALID;
    trials->trial = calloc((size_t)count, sizeof *trials->trial);
    if (!trials->trial) return PEND_NO_MEMORY;
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        trial_read(trials, &item, degrees ? M_PI / 180 : 1, problem);
    trials_fit(trials);
    if (!problem->status && !isfinite(trials->slope))
        api_value_fault(&list, problem,
                        API_CODE_WRONG_COUNT "needs trials with %s that differ in %s",
                        columns[trials->y], columns[trials->x]);
    return problem->status ? PEND_INVALID : PEND_OK;
}

/* ---- writing */

static enum pend_status write_numbers(struct api_buffer *out, const char *const keys[],
                                      const double number[], int count) {
    PEND_TRY(api_buffer_text(out, "{"));
    for (int k = 0; k < count; k++) PEND_TRY(api_out_maybe(out, keys[k], number[k]));
    return api_buffer_text(out, "}");
}

static enum pend_status trials_run(void *state, const struct api_turn *turn, int *done,
                                   struct pend_error *error) {
    static const char *const keys[] = {"value", "error"}, *const each[] = {"fitted", "error",
                                                                           "residual"};
    const struct trials *r = state;
    struct api_buffer *out = turn->out;
    (void)error;
    assert(r->count >= 1 && !*done);
    *done = 1;
    int unknowns = r->law == PENDULUM ? 1 : 2;
    long freedom = r->used - unknowns;
    // without a sigma the variance comes from the residuals, if there are enough
    double scale = r->sigma > 0 ? r->sigma * r->sigma : r->chi_squared / (double)freedom;
    double slope_error = freedom < 0 || isnan(scale) ? NAN : sqrt(scale / r->xx);
    double mean_error = unknowns > 1 ? slope_error * sqrt(r->xx / r->w) : 0;
    double value[] = {r->slope, r->mean - r->slope * r->center};
    double off[] = {slope_error, hypot(mean_error, r->center * slope_error)};
    if (r->law == PENDULUM) value[0] = 4 * M_PI * M_PI / r->slope, off[0] *= value[0] / r->slope;
    if (r->law == POWER) value[1] = exp(value[1]), off[1] *= value[1];
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_open(out, "unknowns", '{'));
    for (int k = 0; k < unknowns; k++) {
        PEND_TRY(api_out_key(out, names[r->law][k]));
        PEND_TRY(write_numbers(out, keys, (double[]){value[k], off[k]}, 2));
    }
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(api_out_maybe(out, "chi_squared", r->chi_squared / r->sigma / r->sigma));
    PEND_TRY(api_out_whole(out, "degrees_of_freedom", freedom));
    PEND_TRY(api_out_open(out, "trials", '['));
    for (const struct trial *t = r->trial; t < r->trial + r->count; t++) {
        double x = t->x - r->center, y = r->mean + r->slope * x, by = 1;
        if (r->law == POWER) y = by = exp(y);
        if (r->law == PENDULUM) y = sqrt(y) / t->slow, by = 0.5 / (y * t->slow * t->slow);
        double number[] = {y, by * hypot(mean_error, slope_error * x), t->number[r->y] - y};
        PEND_TRY(api_out_comma(out));
        PEND_TRY(write_numbers(out, each, number, 3));
    }
    PEND_TRY(api_buffer_text(out, "]"));
    return api_turn_close(turn);
}

static double trials_bytes(const void *state) {
    (void)state;
    return API_OP_SMALL_BYTES + MOST_TRIALS * (sizeof(struct trial) + 160.0);
}

const struct api_op api_op_trials = {.name = "trials",
                                     .size = sizeof(struct trials),
                                     .body = 1,
                                     .read = trials_read,
                                     .run = trials_run,
                                     .bytes = trials_bytes,
                                     .clear = trials_clear};

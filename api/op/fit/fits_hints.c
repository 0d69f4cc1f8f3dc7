#include "api/op/fit/fits_hints.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_out.h"
#include "api/op/fit/fits_start.h"
#include "core/fit/fit_start.h"

static const double pi = 3.14159265358979323846;

/* A try is reported if it removes this fraction of the excess sum of squares, and explains this
 * fraction of the variance of the data; a value this many times its start suggests a wrong unit. */
static const double hints_taken = 0.7, hints_explained = 0.9, hints_far = 30;

enum { HINT_ITERATIONS = 40, HINT_TEXT = 400 };

/* changes of the data to try; from HINT_HELD on, each fixed number is released in turn */
enum hint {
    HINT_UNIT,
    HINT_ZERO,
    HINT_EXCHANGE, /* three pairs of arms */
    HINT_MIRROR = HINT_EXCHANGE + 3,
    HINT_AXES,
    HINT_CLOCKWISE,
    HINT_ROUND, /* one of the first three series of rates or accelerations */
    HINT_JOINTS = HINT_ROUND + 3,
    HINT_RATES,
    HINT_HELD
};

struct api_hints {
    const struct api_fit *fit;
    const struct pend_fit_result *result;
    struct api_fit tried; /* a copy with its own data and start */
    struct pend_fit *search;
    double *data, best, left,
        floor; /* fraction of the variance that remains; fraction due to noise */
    int next;
    long motions, most;
    char what[200], text[HINT_TEXT];
};

/* ---- tries: each changes the data of `tried` and describes the change; it returns 0 if the try
 * does not apply */

#define KIND(name) (1u << PEND_FIT_##name)

/* Multiplies series of these kinds by a number, counted from their zero: all, or the k-th (-1 =
 * all). Returns the last one + 1; 0 = none. */
static int hint_scale(struct api_hints *h, unsigned kinds, int k, double by) {
    const struct api_fit *fit = &h->tried;
    int last = 0;
    for (int c = 0; c < fit->columns; c++) {
        double *x = h->data + c * fit->rows, zero = fit->zero[c];
        if (!(kinds >> fit->column[c].kind & 1) || (k >= 0 && k--)) continue;
        for (long i = 0; i < fit->rows; i++) x[i] = (x[i] - zero) * by + zero;
        last = c + 1;
        if (k == -1) break;
    }
    return last;
}

/* angles in degrees that were read as rad, or the reverse */
static int hint_unit(struct api_hints *h) {
    const struct api_fit *fit = &h->tried;
    double low = INFINITY, high = -INFINITY;
    for (int c = 0; c < fit->columns; c++)
        for (long i = 0; i < fit->rows && fit->column[c].kind == PEND_FIT_PHI; i++) {
            double x = h->data[c * fit->rows + i] - fit->zero[c];
            low = fmin(low, x), high = fmax(high, x);
        }
    double most = fmax(-low, high);
    if (!(most > 7 || most < 0.06)) return 0;
    snprintf(h->what, sizeof h->what,
             "the angles range from %.4g to %.4g rad: are they in %s? Then", low, high,
             most > 7 ? "degrees" : "rad, not degrees");
    return hint_scale(h, KIND(PHI), -1, most > 7 ? pi / 180 : 180 / pi);
}

/* every angle with an unknown zero */
static int hint_zero(struct api_hints *h) {
    struct api_fit *fit = &h->tried;
    const struct pend_fit_problem problem = api_fit_problem(fit);
    double most = 0;
    for (int j = 0; j < fit->unknowns; j++)
        if (fit->unknown[j].camera >= PEND_FIT_CAMERA) return 0;
    for (int c = 0; c < fit->columns && fit->unknowns < API_FIT_UNKNOWNS; c++) {
        if (fit->column[c].kind != PEND_FIT_PHI || fit->column[c].zero != c + 1) continue;
        double mean = pend_fit_start_zero(&problem, c);
        if (fabs(mean) > fabs(most)) most = mean;
        fit->unknown[fit->unknowns++] =
            (struct pend_fit_unknown){PEND_FIT_CAMERA + c, {0}, NAN, -INFINITY, INFINITY, 0};
    }
    return fabs(most) > 0.005;
}

static int hint_exchange(struct api_hints *h, int pair) {
    struct api_fit *fit = &h->tried;
    int a = pair == 1 ? 1 : 0, b = pair == 0 ? 1 : 2, seen = 0;
    for (int c = 0; c < fit->columns - fit->modes; c++) {
        int *arm = &fit->column[c].arm;
        seen |= *arm == a ? 1 : *arm == b ? 2 : 0;
        *arm = *arm == a ? b : *arm == b ? a : *arm;
    }
    snprintf(h->what, sizeof h->what, "with arms %d and %d exchanged", a + 1, b + 1);
    return seen == 3;
}

static int hint_axes(struct api_hints *h) {
    struct api_fit *fit = &h->tried;
    unsigned seen = 0;
    for (int c = 0; c < fit->columns; c++) {
        enum pend_fit_kind *kind = &fit->column[c].kind;
        seen |= 1u << *kind;
        *kind = *kind == PEND_FIT_X ? PEND_FIT_Y : *kind == PEND_FIT_Y ? PEND_FIT_X : *kind;
    }
    snprintf(h->what, sizeof h->what, "with x and y exchanged");
    return (seen & KIND(X)) && (seen & KIND(Y));
}

/* data with the opposite sign: y, all angles, or one of the first three series of rates or
 * accelerations */
static int hint_round(struct api_hints *h, int which) {
    struct api_fit *fit = &h->tried;
    unsigned turns = KIND(RATE) | KIND(ALONG) | KIND(ACROSS);
    if (which == HINT_MIRROR) {
        fit->camera[PEND_FIT_ORIGIN_Y] *= -1;
        snprintf(h->what, sizeof h->what, "with y upwards instead of downwards");
        return hint_scale(h, KIND(Y), -1, -1);
    }
    int all = which == HINT_CLOCKWISE,
        c = hint_scale(h, all ? KIND(PHI) : turns, all ? -1 : which - HINT_ROUND, -1) - 1;
    if (c < 0 || (!all && fit->columns == 1)) return 0;
    if (all)
        snprintf(h->what, sizeof h->what, "with angles counted the other way round");
    else
        snprintf(h->what, sizeof h->what, "with the %s of arm %d counted the other way round",
                 fit->column[c].kind == PEND_FIT_RATE ? "angular velocity" : "acceleration",
                 fit->column[c].arm + 1);
    return 1;
}

/* angles relative to the parent arm instead of the vertical, or the reverse; or angular velocities
 * instead of angles */
static int hint_angles(struct api_hints *h, int rates) {
    struct api_fit *fit = &h->tried;
    int seen = 0, joint = 0;
    // a small swing and its rate look alike
    if (rates && h->left < 1 - hints_explained) return 0;
    for (int c = 0; c < fit->columns; c++) {
        struct pend_fit_column *column = &fit->column[c];
        if (column->kind != PEND_FIT_PHI) continue;
        if (!rates && api_tree_parent(&fit->tree, column->arm) < 0) continue;
        joint = column->joint;
        for (long i = 0; i < fit->rows; i++)
            h->data[c * fit->rows + i] -= joint && !rates ? pi / 2 : fit->zero[c];
        column->joint = !joint && !rates;
        if (rates) column->kind = PEND_FIT_RATE;
        seen = 1;
    }
    snprintf(h->what, sizeof h->what, "with %s",
             rates   ? "angular velocities instead of angles"
             : joint ? "angles from the vertical instead of from the parent arm"
                     : "angles from the parent arm (\"joint\") instead of from the vertical");
    return seen;
}

/* frees the i-th fixed number: first of the camera, then of the pendulum, then of the start;
 * returns -1 after the last, 0 if it is an unknown already or has no effect */
static int hint_held(struct api_hints *h, int which) {
    static const char *const names[] = {"length", "mass", "the start angle", "the start rate"};
    static const enum pend_parameter_kind kinds[] = {PEND_PARAMETER_LENGTH, PEND_PARAMETER_MASS,
                                                     PEND_PARAMETER_PHI, PEND_PARAMETER_RATE};
    struct api_fit *fit = &h->tried;
    int n = fit->tree.n, own = which - PEND_FIT_CAMERA - 1, is = which == PEND_FIT_SHIFT;
    struct pend_fit_unknown *u = &fit->unknown[fit->unknowns];
    *u = (struct pend_fit_unknown){.camera = -1, .low = -INFINITY, .high = INFINITY};
    if (own >= 4 * n || fit->unknowns + 1 >= API_FIT_UNKNOWNS) return -1;
    if (own < -1) {
        u->camera = which, u->start = fit->camera[which];
        if (!hint_scale(h, KIND(X) | KIND(Y), -1, 1)) return 0;
        snprintf(h->what, sizeof h->what, "%s", api_fit_camera_label((enum pend_fit_camera)which));
    } else if (own == -1) {
        u->by.kind = PEND_PARAMETER_GRAVITY, u->start = fit->tree.loads.gravity;
        snprintf(h->what, sizeof h->what, "gravity");
    } else {
        int k = own % n + fit->tree.cart;
        const double *from[] = {fit->tree.tree->len, fit->tree.tree->mass, fit->start->phi,
                                fit->start->rate};
        u->by = (struct pend_parameter){kinds[own / n], k}, u->start = from[own / n][k];
        if (own < 2 * n) u->low = 0, is |= !(u->start > 0);
        api_fit_label(fit, names[own / n], k, -1, h->what);
    }
    for (int j = 0; j < fit->unknowns; j++) {
        const struct pend_fit_unknown *other = &fit->unknown[j];
        int same = other->by.kind == u->by.kind && other->by.at == u->by.at;
        is |= other->camera == u->camera && (u->camera >= 0 || same);
    }
    fit->unknowns += !is;
    return !is;
}

/* ---- trying */

/* restores the request's data, start and initial unknowns; estimates from the data are repeated
 * after a change of the data */
static void hints_reset(struct api_hints *h) {
    const struct api_fit *fit = h->fit;
    struct api_states *start = h->tried.start;
    assert(start && start->n == fit->start->n);
    size_t states = (size_t)(fit->start->count * fit->start->n);
    h->tried = *fit, h->tried.start = start, h->tried.iterations = HINT_ITERATIONS;
    memcpy(h->data, fit->data, (size_t)(fit->rows * fit->columns) * sizeof *h->data);
    memcpy(start->phi, fit->start->phi, states * sizeof *start->phi);
    memcpy(start->rate, fit->start->rate, states * sizeof *start->rate);
    for (int c = 0; c < fit->columns; c++) h->tried.column[c].data = h->data + c * fit->rows;
}

/* prepares the next try; returns 0 if it does not apply, -1 after the last */
static int hints_put(struct api_hints *h) {
    int which = h->next++, some;
    assert(which >= 0);
    hints_reset(h);
    if (which == HINT_UNIT)
        some = hint_unit(h);
    else if (which == HINT_ZERO)
        some = hint_zero(h);
    else if (which < HINT_MIRROR)
        some = hint_exchange(h, which - HINT_EXCHANGE);
    else if (which < HINT_HELD)
        some = which == HINT_AXES    ? hint_axes(h)
               : which < HINT_JOINTS ? hint_round(h, which)
                                     : hint_angles(h, which == HINT_RATES);
    else
        return hint_held(h, which - HINT_HELD);
    if (!some) return 0;
    for (int j = 0; j < h->tried.unknowns; j++) {
        struct pend_fit_unknown *u = &h->tried.unknown[j];
        int start = u->camera < 0 && u->by.kind <= PEND_PARAMETER_RATE;
        if (start && h->fit->run[u->run].guessed) u->start = NAN;
    }
    return api_fit_guess(&h->tried) == PEND_OK;
}

static void hints_take(struct api_hints *h) {
    struct pend_fit_result r = pend_fit_result(h->search);
    assert(h->next > 0);
    int which = h->next - 1;
    double left = 1 - r.explained;
    double taken = (h->left - left) / (h->left - h->floor);
    // of two equally good hints keep the first; skip if the residual is already noise
    if (!(taken > h->best + 1e-3) || !(1 - left > hints_explained) || !(h->left > h->floor)) return;
    // an undetermined number cannot be the cause
    if (which >= HINT_HELD && !isfinite(r.error[h->tried.unknowns - 1])) return;
    h->best = taken;
    if (which == HINT_ZERO)
        snprintf(
            h->text, sizeof h->text,
            "is the zero of the angles shifted (an unknown \"zero\"), or are they theta instead "
            "of phi? They swing about %.4g degrees from the vertical: with the zero as an unknown "
            "the motion explains %.6g %%",
            r.value[h->fit->unknowns] * 180 / pi, 100 * (1 - left));
    else if (which >= HINT_HELD)
        snprintf(h->text, sizeof h->text,
                 "with %s as another unknown, here %.6g, the motion explains %.6g %%", h->what,
                 r.value[h->tried.unknowns - 1], 100 * r.explained);
    else
        snprintf(h->text, sizeof h->text, "%s the motion explains %.6g %%", h->what,
                 100 * (1 - left));
}

enum pend_status api_hints_step(struct api_hints *h, int *done) {
    struct pend_error error;
    int over = 0;
    assert(h->fit && h->data && h->most >= 0);
    *done = 0;
    if (!h->search) {
        int some = h->next < 0 || h->motions > h->most ? -1 : hints_put(h);
        *done = some < 0;
        if (some <= 0) return PEND_OK;
        struct pend_fit_problem problem = api_fit_problem(&h->tried);
        enum pend_status status = pend_fit_new(&h->search, &problem, &error);
        return status == PEND_NO_MEMORY ? status : PEND_OK;
    }
    enum pend_status status = pend_fit_step(h->search, &over, &error);
    if (status == PEND_NO_MEMORY) return status;
    if (!over && status == PEND_OK) return PEND_OK;
    if (status == PEND_OK) hints_take(h);
    h->motions += status == PEND_OK ? pend_fit_result(h->search).evaluations : HINT_ITERATIONS;
    pend_fit_free(&h->search);
    return PEND_OK;
}

enum pend_status api_hints_new(struct api_hints **hints, const struct api_fit *fit,
                               const struct pend_fit_result *result, long motions) {
    struct api_hints *h = *hints = calloc(1, sizeof *h);
    if (!h) return PEND_NO_MEMORY;
    int white = !(result->alike < 1e-3), known = 1;
    for (int c = 0; c < fit->columns; c++) known &= pend_fit_known(&fit->column[c]);
    h->fit = fit, h->result = result, h->best = hints_taken;
    h->most = result->evaluations > motions ? result->evaluations : motions;
    h->left = 1 - result->explained;
    // the variance of noise alone: differences of neighbours have twice that variance
    h->floor =
        h->left * (known ? (double)result->freedom / result->chi_squared : result->watson / 2);
    if (!(result->explained > hints_explained)) h->floor = 0;
    if (result->model == PEND_FIT_ACCEPTED || fit->columns == fit->modes || fit->loss ||
        fit->rows * fit->columns > API_HINT_NUMBERS ||
        (white && !known && result->explained > hints_explained) || result->explained > 1 - 1e-9)
        h->next = -1;
    h->data = malloc((size_t)(fit->rows * fit->columns) * sizeof *h->data);
    enum pend_status status = api_states_new(&h->tried.start, fit->start->count, fit->start->n);
    return h->data ? status : PEND_NO_MEMORY;
}

void api_hints_free(struct api_hints **hints) {
    struct api_hints *h = *hints;
    if (!h) return;
    pend_fit_free(&h->search);
    api_states_free(&h->tried.start);
    free(h->data);
    free(h);
    *hints = NULL;
}

/* ---- saying */

static long hints_outlier(const struct api_hints *h) {
    const struct api_fit *fit = h->fit;
    double most = 0;
    long row = 0;
    for (long i = 0; i < fit->rows; i++)
        for (int c = 0; c < fit->columns; c++) {
            double off = fabs(h->result->residual[i * fit->columns + c]) / h->result->spread[c];
            if (off > most) most = off, row = fit->row[i] + 1;
        }
    return row;
}

/* a length that differs by a factor of a unit */
static int hints_length(const struct api_hints *h) {
    for (int j = 0; j < h->fit->unknowns; j++) {
        const struct pend_fit_unknown *u = &h->fit->unknown[j];
        double times = h->result->value[j] / u->start;
        if (u->camera < 0 && u->by.kind == PEND_PARAMETER_LENGTH &&
            (times > hints_far || times < 1 / hints_far))
            return j;
    }
    return -1;
}

enum pend_status api_hints_write(const struct api_hints *h, struct api_buffer *out) {
    char text[HINT_TEXT];
    long count = h->result->outliers;
    enum pend_fit_kind kind = h->fit->column[0].kind;
    int far = hints_length(h), places = kind == PEND_FIT_X || kind == PEND_FIT_Y;
    PEND_TRY(api_out_open(out, "hints", '['));
    if (*h->text) PEND_TRY(api_out_text(out, NULL, h->text));
    if (count && !h->fit->loss) {
        snprintf(text, sizeof text,
                 "outliers: %ld, the farthest in row %ld: mistyped, or lost by the tracker? The "
                 "loss \"huber\" nearly ignores them",
                 count, hints_outlier(h));
        PEND_TRY(api_out_text(out, NULL, text));
    }
    if (h->result->twin >= 0) {
        snprintf(
            text, sizeof text,
            "%s may be %.4g s as well: the motion repeats itself. Give its \"guess\" or a \"low\" "
            "and a \"high\"",
            h->fit->label[h->result->twin], h->result->other);
        PEND_TRY(api_out_text(out, NULL, text));
    }
    if (far >= 0) {
        snprintf(text, sizeof text,
                 "the fit gives %s %.3g times its given value: are instants in s, not in ms or "
                 "frames, positions in m, and is gravity right?",
                 h->fit->label[far], h->result->value[far] / h->fit->unknown[far].start);
        PEND_TRY(api_out_text(out, NULL, text));
    }
    if (!*h->text && h->result->model == PEND_FIT_REJECTED && h->result->alike < 1e-3 &&
        h->result->explained > hints_explained)
        PEND_TRY(api_out_text(
            out, NULL,
            places ? "the residuals have a pattern: is the camera tilted, or its lens distorted "
                     "(\"tilt\", \"stretch\" and \"distortion\" of the camera as unknowns)? Or is "
                     "the friction of another kind?"
                   : "the residuals have a pattern: is the friction of another kind (damping, "
                     "friction_torque, drag, drag_quadratic), or is a fixed number wrong?"));
    return api_buffer_text(out, "]");
}

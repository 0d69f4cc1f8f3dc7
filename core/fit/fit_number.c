#include "core/fit/fit_number.h"

#include <complex.h>
#include <math.h>

#include "core/modes/swing.h"

#define BIT(what) (1u << PEND_DERIVED_##what)

static int is_place(enum pend_fit_kind kind) { return kind == PEND_FIT_X || kind == PEND_FIT_Y; }

static int is_force(enum pend_fit_kind kind) {
    return kind == PEND_FIT_ALONG || kind == PEND_FIT_ACROSS;
}

unsigned pend_fit_number_needs(enum pend_fit_kind kind) {
    if (kind == PEND_FIT_MODE) return 0;
    if (kind == PEND_FIT_CART) return 1u << FIT_CART;
    if (is_place(kind)) return BIT(Z_RE) | BIT(Z_IM);
    if (is_force(kind)) return BIT(PHI) | BIT(RATE) | BIT(ACC) | BIT(ZDD_RE) | BIT(ZDD_IM);
    return (kind == PEND_FIT_RATE ? 0 : BIT(PHI)) | (kind == PEND_FIT_PHI ? 0 : BIT(RATE));
}

int pend_fit_number_pace(int what) {
    if (what == PEND_DERIVED_ACC || what > FIT_CART) return -1;
    if (what == PEND_DERIVED_PHI || what == PEND_DERIVED_RATE || what == FIT_CART) return what + 1;
    return what < PEND_DERIVED_ZDD_RE ? what + PEND_DERIVED_ZD_RE - PEND_DERIVED_Z_RE : -1;
}

static void number_by(struct fit_number *number, int what, size_t at, double by) {
    number->seen += what < FIT_SEEN;
    number->what[number->terms] = what, number->at[number->terms] = at;
    number->by[number->terms++] = by;
}

/* an angle or a rate; if the column is relative to another arm, that arm's value is subtracted */
static void number_turn(const struct fit_seen *seen, const struct pend_fit_column *column,
                        size_t at, struct fit_number *number) {
    int what = column->kind == PEND_FIT_PHI ? PEND_DERIVED_PHI : PEND_DERIVED_RATE;
    int from = pend_fit_base(column, seen->problem->parent);
    number->value = seen->value[what][at];
    number_by(number, what, at, 1);
    if (from < 0) return;
    size_t base = at - (size_t)column->arm + (size_t)from;
    number->value -= seen->value[what][base];
    number_by(number, what, base, -1);
}

static void number_passage(const struct fit_seen *seen, double gate, size_t at,
                           struct fit_number *number) {
    double u = remainder(seen->value[PEND_DERIVED_PHI][at] - gate, 2 * M_PI), w = seen->swing;
    double v = seen->value[PEND_DERIVED_RATE][at], side = v < 0 ? -1 : 1;
    double square = fmax(v * v + w * w * u * u, 1e-300);
    number->value = -atan2(side * w * u, side * v) / w;
    number_by(number, PEND_DERIVED_PHI, at, -v / square);
    number_by(number, PEND_DERIVED_RATE, at, u / square);
}

/* a tip seen by a camera without tilt and distortion: origin + scale (a x + b y) */
static void number_place(const struct fit_seen *seen, int first, size_t at,
                         struct fit_number *number) {
    const double *camera = seen->camera;
    double scale = camera[PEND_FIT_SCALE], c = cos(camera[PEND_FIT_ROTATION]);
    double s = sin(camera[PEND_FIT_ROTATION]);
    double x = seen->value[PEND_DERIVED_Z_RE][at], y = seen->value[PEND_DERIVED_Z_IM][at];
    double a = first ? c : s, b = first ? -s : c, turn = first ? -s * x - c * y : c * x - s * y;
    number->value = camera[first ? PEND_FIT_ORIGIN_X : PEND_FIT_ORIGIN_Y] + scale * (a * x + b * y);
    number->lead = scale;
    number_by(number, PEND_DERIVED_Z_RE, at, a);
    number_by(number, PEND_DERIVED_Z_IM, at, b);
    number_by(number, FIT_CAMERA + PEND_FIT_SCALE, at, a * x + b * y);
    number_by(number, FIT_CAMERA + PEND_FIT_ROTATION, at, scale * turn);
    number_by(number, FIT_CAMERA + (first ? PEND_FIT_ORIGIN_X : PEND_FIT_ORIGIN_Y), at, 1);
}

/* ---- by differences */

/* as number_place, with tilt and lens; of: x, y, the camera's numbers */
static double number_lens(const struct pend_fit_problem *p, int first, const double from[]) {
    const double *of = from + 2;
    double x = from[0], y = (1 + of[PEND_FIT_STRETCH]) * from[1];
    double complex w = (x + I * y) / (1 + of[PEND_FIT_TILT_X] * x + of[PEND_FIT_TILT_Y] * y);
    double complex center = p->center[0] + I * p->center[1];
    double complex d = of[PEND_FIT_ORIGIN_X] + I * of[PEND_FIT_ORIGIN_Y] - center +
                       of[PEND_FIT_SCALE] * cexp(I * of[PEND_FIT_ROTATION]) * w;
    d = center + d * (1 + of[PEND_FIT_DISTORTION] * pow(cabs(d) / p->reach, 2));
    return first ? creal(d) : cimag(d);
}

/* The acceleration along the arm or across it, (z'' + i g) e^{-i phi} + out (i phi'' - phi'^2), at
 * the distance out beyond the tip; of: phi, phi', phi'', Re z'', Im z'', the arm's length, g */
static double number_acceleration(const struct pend_fit_column *column, const double of[]) {
    double out = column->at < 0 ? 0 : column->at - of[5];
    double complex z = (of[3] + I * (of[4] + (column->still ? 0 : of[6]))) * cexp(-I * of[0]) +
                       out * (I * of[2] - of[1] * of[1]);
    return column->kind == PEND_FIT_ALONG ? creal(z) : cimag(z);
}

/* cos amplitude = cos theta - theta'^2 / (2 omega^2) of one arm, or its period; of: phi, phi',
 * omega */
static double number_amplitude(const struct pend_fit_column *column, const double of[]) {
    double cosine = cos(of[0] + M_PI / 2) - pow(of[1] / fmax(of[2], 1e-9), 2) / 2;
    double most = acos(fmin(fmax(cosine, -1 + 1e-9), 1));
    if (column->kind == PEND_FIT_AMPLITUDE) return most;
    return 2 * M_PI / (of[2] * pend_swing_slow(most));
}

static double number_at(const struct fit_seen *seen, const struct pend_fit_column *column,
                        const double of[]) {
    enum pend_fit_kind kind = column->kind;
    return is_place(kind)   ? number_lens(seen->problem, kind == PEND_FIT_X, of)
           : is_force(kind) ? number_acceleration(column, of)
                            : number_amplitude(column, of);
}

/* a measurement whose derivatives are central differences */
static void number_differences(const struct fit_seen *seen, const struct pend_fit_column *column,
                               size_t at, struct fit_number *number) {
    static const double step = 1e-5;
    int place = is_place(column->kind), force = is_force(column->kind);
    unsigned needs = pend_fit_number_needs(column->kind);
    for (int i = 0; i < FIT_SEEN; i++)
        if (needs >> i & 1) number_by(number, i, at, 0);
    for (int i = 0; i < PEND_FIT_CAMERA && place; i++) number_by(number, FIT_CAMERA + i, at, 0);
    if (force) number_by(number, FIT_LENGTH, at, 0), number_by(number, FIT_GRAVITY, at, 0);
    if (!force && !place) number_by(number, FIT_OMEGA, 0, 0);
    double of[FIT_TERMS] = {0};
    for (int k = 0; k < number->terms; k++) {
        int what = number->what[k];
        of[k] = what < FIT_SEEN       ? seen->value[what][at]
                : what == FIT_LENGTH  ? seen->length[column->arm]
                : what == FIT_GRAVITY ? seen->gravity
                : what == FIT_OMEGA   ? seen->omega[0]
                                      : seen->camera[what - FIT_CAMERA];
    }
    number->value = number_at(seen, column, of);
    for (int k = 0; k < number->terms; k++) {
        double own = of[k], size = step * fmax(fabs(own), 1);
        of[k] = own + size, number->by[k] = number_at(seen, column, of);
        of[k] = own - size, number->by[k] -= number_at(seen, column, of);
        of[k] = own, number->by[k] /= 2 * size;
    }
}

void pend_fit_number(const struct fit_seen *seen, const struct pend_fit_column *column, double data,
                     size_t row, struct fit_number *number) {
    size_t at = row * (size_t)pend_fit_arms(seen->problem) + (size_t)column->arm;
    number->lead = 1, number->terms = number->seen = 0;
    if (column->kind == PEND_FIT_MODE)
        number_by(number, FIT_OMEGA, (size_t)column->arm, 1),
            number->value = seen->omega[column->arm];
    else if (column->kind == PEND_FIT_CART)
        number_by(number, FIT_CART, row, 1), number->value = seen->value[FIT_CART][row];
    else if (column->kind == PEND_FIT_PHI || column->kind == PEND_FIT_RATE)
        number_turn(seen, column, at, number);
    else if (column->kind == PEND_FIT_PASSAGE)
        number_passage(seen, data, at, number);
    else if (is_place(column->kind) && !seen->lens)
        number_place(seen, column->kind == PEND_FIT_X, at, number);
    else
        number_differences(seen, column, at, number);
    if (column->zero) number->value += seen->zero[column->zero - 1];
}

#include "core/fit/fit_start.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/fit/fit_constants.h"

/* the index of the column with a quantity of an arm, preferably without a shifted clock; -1 = not
 * measured */
static int start_column(const struct pend_fit_problem *p, int arm, enum pend_fit_kind kind) {
    int found = -1;
    for (int c = p->columns - 1; c >= 0; c--) {
        const struct pend_fit_column *column = &p->column[c];
        int better = found < 0 || !column->clock || p->column[found].clock;
        if (column->arm == arm && column->kind == kind && better) found = c;
    }
    return found;
}

/* the offset that the instrument of a column adds */
static double start_zero(const struct pend_fit_problem *p, int c) {
    return p->column[c].zero && p->zeros ? p->zero[p->column[c].zero - 1] : 0;
}

double pend_fit_start_zero(const struct pend_fit_problem *p, int zero) {
    double re = 0, im = 0, sum = 0, count = 0;
    assert(zero >= 0 && zero < p->zeros);
    for (int c = 0; c < p->columns; c++) {
        const struct pend_fit_column *column = &p->column[c];
        double rest = pend_fit_base(column, p->parent) >= 0 ? 0 : -M_PI / 2;
        for (long i = 0; i < p->rows && column->zero == zero + 1; i++) {
            double x = column->data[i];
            if (isnan(x)) continue;
            if (column->kind == PEND_FIT_RATE) sum += x, count++;
            if (column->kind == PEND_FIT_PHI) re += cos(x - rest), im += sin(x - rest);
        }
    }
    return count > 0 ? sum / count : atan2(im, re);
}

/* an arm's tip in camera units at a row, the pivot for arm -1, or the cart; returns 0 if not seen
 */
static int start_tip(const struct pend_fit_problem *p, int arm, long row, double *x, double *y) {
    *x = p->camera[PEND_FIT_ORIGIN_X], *y = p->camera[PEND_FIT_ORIGIN_Y];
    if (arm < 0) return 1;
    if (arm >= pend_fit_arms(p)) {
        *x += p->camera[PEND_FIT_SCALE] * pend_fit_start_angle(p, arm, row);
        return !isnan(*x);
    }
    int at = start_column(p, arm, PEND_FIT_X), beside = start_column(p, arm, PEND_FIT_Y);
    if (at < 0 || beside < 0) return 0;
    *x = p->column[at].data[row], *y = p->column[beside].data[row];
    return !isnan(*x) && !isnan(*y);
}

double pend_fit_start_angle(const struct pend_fit_problem *p, int arm, long row) {
    int c = start_column(p, arm, PEND_FIT_PHI);
    double x, y, to_x, to_y;
    int cart = start_column(p, arm, PEND_FIT_CART);
    assert(arm >= 0 && arm < p->n && row >= 0 && row < p->rows);
    if (arm >= pend_fit_arms(p)) return cart >= 0 ? p->column[cart].data[row] : NAN;
    if (c >= 0) {
        double seen = p->column[c].data[row] - start_zero(p, c);
        int from = pend_fit_base(&p->column[c], p->parent);
        return from >= 0 ? seen + pend_fit_start_angle(p, from, row) : seen;
    }
    if (!start_tip(p, p->parent[arm], row, &x, &y) || !start_tip(p, arm, row, &to_x, &to_y))
        return NAN;
    return atan2(to_y - y, to_x - x) - p->camera[PEND_FIT_ROTATION];
}

/* The angle of an arm if tips in between are not measured: the arms between two measured tips are
 * assumed to lie in one line. */
static double start_line(const struct pend_fit_problem *p, int arm, long row) {
    double x, y, to_x, to_y;
    int from = p->parent[arm], to = 0;
    if (p->n > FIT_LINE_ARMS || arm >= pend_fit_arms(p)) return NAN;
    while (!start_tip(p, from, row, &x, &y)) from = p->parent[from];
    for (; to < p->n; to++) {
        int k = to;
        while (k >= 0 && k != arm) k = p->parent[k];
        if (k == arm && start_tip(p, to, row, &to_x, &to_y))
            return atan2(to_y - y, to_x - x) - p->camera[PEND_FIT_ROTATION];
    }
    return NAN;
}

/* an arm's angle at a row, from its own tip or from a line of arms */
static double start_seen(const struct pend_fit_problem *p, int arm, long row) {
    double angle = pend_fit_start_angle(p, arm, row);
    int own = start_column(p, arm, PEND_FIT_PHI) >= 0;
    return isnan(angle) && !own ? start_line(p, arm, row) : angle;
}

void pend_fit_start_parabola(const struct pend_fit_problem *p, int arm, long row, double *phi,
                             double *rate) {
    double at = NAN, sums[5] = {0}, sides[3] = {0};
    long first = row, last = row, run = pend_fit_run(p, row);
    for (int left = FIT_BESIDE; left && first > 0;) left -= pend_fit_run(p, --first) == run;
    for (int left = FIT_BESIDE; left && last < p->rows - 1;) left -= pend_fit_run(p, ++last) == run;
    for (long i = first; i <= last; i++) {
        double angle = start_seen(p, arm, i), t = p->t[i] - p->t[row], power = 1;
        if (isnan(angle) || pend_fit_run(p, i) != run) continue;
        // each step takes the shorter way round
        at = isnan(at) ? angle : at + remainder(angle - at, 2 * M_PI);
        for (int k = 0; k < 5; k++, power *= t) {
            sums[k] += power;
            if (k < 3) sides[k] += power * at;
        }
    }
    double a = sums[0], b = sums[1], c = sums[2], d = sums[3], e = sums[4];
    double whole = a * (c * e - d * d) - b * (b * e - c * d) + c * (b * d - c * c);
    *phi = a > 0 ? sides[0] / a : 0, *rate = 0;
    if (!(fabs(whole) > 1e-12 * a * c * e)) return;
    *phi = (sides[0] * (c * e - d * d) - b * (sides[1] * e - d * sides[2]) +
            c * (sides[1] * d - c * sides[2])) /
           whole;
    *rate = (a * (sides[1] * e - d * sides[2]) - sides[0] * (b * e - c * d) +
             c * (b * sides[2] - c * sides[1])) /
            whole;
}

/* whether the first row is an outlier: its step to the next row is far longer than the others,
 * longer than on any parabola */
static int start_outlier(const struct pend_fit_problem *p, int arm, const long row[], int seen) {
    double step[FIT_FIRST] = {0}, most = 0;
    for (int i = 1; i < seen; i++) {
        double way = start_seen(p, arm, row[i]) - start_seen(p, arm, row[i - 1]);
        step[i] = fabs(remainder(way, 2 * M_PI));
        if (i > 1) most = fmax(most, step[i]);
    }
    return seen == FIT_FIRST && step[1] > fit_outlier * most;
}

/* Finds the first rows of a run in which an arm is measured; returns their number. */
static int start_rows(const struct pend_fit_problem *p, int run, int arm, long row[FIT_FIRST],
                      double *since) {
    int seen = 0, rows = 0;
    int own = start_column(p, arm, PEND_FIT_PHI) >= 0 || start_column(p, arm, PEND_FIT_X) >= 0;
    for (long i = 0; i < p->rows && (own || rows < FIT_LINE_ROWS) && seen < FIT_FIRST; i++) {
        if (pend_fit_run(p, i) != run) continue;
        if (!rows++) *since = p->t[i];
        if (!isnan(start_seen(p, arm, i))) row[seen++] = i;
    }
    return seen;
}

/* Computes angle and rate at the start of a run from measured rates of an arm. The angle is the
 * integral of the rate. The arm is assumed to hang midway between the first two turning points,
 * where the rate changes its sign. */
static int start_rates(const struct pend_fit_problem *p, int run, int arm, double *phi,
                       double *rate) {
    int c = start_column(p, arm, PEND_FIT_RATE), seen = 0, turns = 0;
    double angle = 0, low = 0, high = 0, before = 0, since = 0, turn[3] = {0};
    for (long i = 0; c >= 0 && i < p->rows && turns < 3; i++) {
        double now = p->column[c].data[i] - start_zero(p, c);
        if (pend_fit_run(p, i) != run || isnan(now)) continue;
        if (!seen++) {
            *rate = now;
        } else {
            angle += (now + before) / 2 * (p->t[i] - since);
            if ((now < 0) != (before < 0)) turn[turns++] = angle;
        }
        low = fmin(low, angle), high = fmax(high, angle), before = now, since = p->t[i];
    }
    // of three turning points the middle one counts twice, which cancels the effect of friction
    double middle = turns == 3 ? (turn[0] + 2 * turn[1] + turn[2]) / 4 : (low + high) / 2;
    if (seen) *phi = -M_PI / 2 - middle;
    return seen > 0;
}

/* Computes the start of a swing from the first passage or amplitude in the run, or from the
 * smallest acceleration along the arm, which belongs to a turning point. */
static enum pend_fit_started start_swing(const struct pend_fit_problem *p, int run, int arm,
                                         double *phi, double *rate) {
    static const enum pend_fit_kind kinds[] = {PEND_FIT_PASSAGE, PEND_FIT_ALONG, PEND_FIT_AMPLITUDE,
                                               PEND_FIT_PERIOD};
    double first = NAN, low = INFINITY, w = pend_fit_size(p, PEND_FIT_RATE, 1), phase = 0;
    int k = 0, c = -1;
    while (k < 4 && (c = start_column(p, arm, kinds[k])) < 0) k++;
    for (long i = 0; i < p->rows && c >= 0; i++) {
        double x = p->column[c].data[i];
        if (pend_fit_run(p, i) != run || isnan(x)) continue;
        if (isnan(first)) first = x;
        if (fabs(x) < low) low = fabs(x), phase = w * (pend_fit_start(p, run) - p->t[i]);
    }
    if (isnan(first)) return PEND_FIT_START_NONE;
    double wide = kinds[k] == PEND_FIT_AMPLITUDE ? first : fit_swing_rate;
    int along = kinds[k] == PEND_FIT_ALONG;
    if (along)
        wide = p->column[c].still ? 1 : fmax(acos(fmin(low / fabs(p->loads.gravity), 1)), 0.05);
    *phi = -M_PI / 2 + wide * cos(along * phase), *rate = -wide * w * sin(along * phase);
    if (kinds[k] == PEND_FIT_PASSAGE) *phi = first, *rate = wide * w;
    return k < 2 ? PEND_FIT_START_BOTH : PEND_FIT_START_ANGLE;
}

enum pend_fit_started pend_fit_start_state(const struct pend_fit_problem *p, int run, int arm,
                                           double *phi, double *rate) {
    double way[FIT_FIRST] = {0}, since = 0, bent = 0;
    long row[FIT_FIRST];
    int seen = start_rows(p, run, arm, row, &since);
    if (!seen && start_rates(p, run, arm, phi, rate)) return PEND_FIT_START_BOTH;
    if (!seen) return start_swing(p, run, arm, phi, rate);
    if (start_outlier(p, arm, row, seen)) memmove(row, row + 1, (size_t)--seen * sizeof *row);
    *phi = start_seen(p, arm, row[0]), *rate = 0;
    double last = *phi, begin = p->t[row[0]];
    for (int i = 1; i < seen; i++) {
        double angle = start_seen(p, arm, row[i]);
        way[i] = way[i - 1] + remainder(angle - last, 2 * M_PI), last = angle;
    }
    // adds the whole turns that the path from the first row to the last contains
    double whole = remainder(last - *phi, 2 * M_PI);
    whole += 2 * M_PI * rint((way[seen - 1] - whole) / (2 * M_PI));
    if (seen > 1) *rate = whole / (p->t[row[seen - 1]] - begin);
    for (int i = 1; i < seen; i++) bent = fmax(bent, fabs(way[i] - *rate * (p->t[row[i]] - begin)));
    // the rate at the start is unknown if it changes this much
    if (bent > fit_bent) pend_fit_start_parabola(p, arm, row[0], phi, rate);
    if (begin > since) *phi -= *rate * (begin - since);
    return PEND_FIT_START_BOTH;
}

/* adds up the squares of a column's turns in `seconds` over a run; counts the terms */
static double start_turns(const struct pend_fit_problem *p, int c, int run, double seconds,
                          long *count) {
    const double *data = p->column[c].data;
    double from = NAN, turned = 0, last = 0, sum = 0;
    for (long i = 0; i < p->rows; i++) {
        if (pend_fit_run(p, i) != run || isnan(data[i])) continue;
        if (!isnan(from)) turned += remainder(data[i] - last, 2 * M_PI);
        last = data[i];
        if (isnan(from)) from = p->t[i];
        if (!(p->t[i] - from >= seconds)) continue;
        sum += pow(turned * seconds / (p->t[i] - from), 2), ++*count;
        from = p->t[i], turned = 0;
    }
    return sum;
}

double pend_fit_start_turned(const struct pend_fit_problem *p, double seconds) {
    double most = 0;
    for (int c = 0; c < p->columns; c++) {
        double sum = 0;
        long count = 0;
        if (p->column[c].kind != PEND_FIT_PHI) continue;
        for (int run = 0; run < pend_fit_runs(p); run++)
            sum += start_turns(p, c, run, seconds, &count);
        if (count) most = fmax(most, sqrt(sum / (double)count));
    }
    return most;
}

/* The deviation of the middle one of five measurements from the cubic through the others, scaled so
 * that noise of size 1 gives a deviation of size 1. */
static double start_missed(const struct pend_fit_column *column, const double t[5],
                           const double value[5]) {
    double gap = 0, weights = 1;
    for (int i = 0; i < 5; i++) {
        double weight = 1, way = value[i] - value[2];
        for (int k = 0; k < 5; k++)
            if (k != 2 && k != i) weight *= (t[2] - t[k]) / (t[i] - t[k]);
        if (i == 2) continue;
        gap += weight * (column->kind == PEND_FIT_PHI ? remainder(way, 2 * M_PI) : way);
        weights += weight * weight;
    }
    return fabs(gap) / sqrt(weights);
}

/* the standard deviation of a column's noise; NaN if no five adjacent rows are measured */
static double start_noise(const struct pend_fit_problem *p, int c) {
    const struct pend_fit_column *column = &p->column[c];
    double sum = 0;
    long count = 0;
    for (int run = 0; run < pend_fit_runs(p); run++) {
        double t[5], value[5];
        int last = 0;
        for (long i = 0; i < p->rows; i++) {
            if (pend_fit_run(p, i) != run || isnan(column->data[i])) continue;
            memmove(t, t + 1, 4 * sizeof *t), memmove(value, value + 1, 4 * sizeof *value);
            t[4] = p->t[i], value[4] = column->data[i];
            if (++last >= 5) sum += start_missed(column, t, value), count++;
        }
    }
    // the mean magnitude of a normal distribution is sqrt(2 / pi) of its standard deviation
    return count ? sum / (double)count * sqrt(M_PI / 2) : NAN;
}

int pend_fit_start_noisy(const struct pend_fit_problem *p, const double residual[]) {
    int noisy = 0;
    for (int c = 0; c < p->columns; c++) {
        double sum = 0, noise = start_noise(p, c);
        // the angles of passages are given, not measured
        if (p->column[c].kind == PEND_FIT_PASSAGE) continue;
        long count = 0;
        for (long i = 0; i < p->rows; i++) {
            double r = residual[i * p->columns + c] * pend_fit_sigma(&p->column[c], i);
            if (!isnan(r)) sum += r * r, count++;
        }
        noisy |= sum > pow(fit_noisy * noise, 2) * (double)count;
    }
    return noisy;
}

/* ---- the camera */

/* the measured arm nearest to the pivot, and its distance along the arms; -1 = none */
static int start_nearest(const struct pend_fit_problem *p, double *reach) {
    int nearest = -1, least = p->n + 1;
    for (int arm = 0; arm < pend_fit_arms(p); arm++) {
        int depth = 0;
        double way = 0;
        if (start_column(p, arm, PEND_FIT_X) < 0 || start_column(p, arm, PEND_FIT_Y) < 0) continue;
        for (int k = arm; k >= 0 && k < pend_fit_arms(p); k = p->parent[k])
            way += p->length[k], depth++;
        if (depth < least) least = depth, nearest = arm, *reach = way;
    }
    return nearest;
}

/* sums over the positions, relative to their mean, that determine a circle */
struct start_sums {
    long count;
    double mean[2], lowest, far, uu, uv, vv, uw, vw; /* w = half of the square of (u, v) */
};

static void start_places(const struct pend_fit_problem *p, int arm, struct start_sums *s) {
    *s = (struct start_sums){.lowest = INFINITY};
    for (int pass = 0; pass < 2; pass++)
        for (long i = 0; i < p->rows; i++) {
            double x, y;
            if (!start_tip(p, arm, i, &x, &y)) continue;
            if (!pass) {
                s->mean[0] += x, s->mean[1] += y, s->count++;
                s->lowest = fmin(s->lowest, y), s->far = fmax(s->far, hypot(x, y));
                continue;
            }
            double u = x - s->mean[0] / (double)s->count, v = y - s->mean[1] / (double)s->count;
            double w = (u * u + v * v) / 2;
            s->uu += u * u, s->uv += u * v, s->vv += v * v, s->uw += u * w, s->vw += v * w;
        }
    for (int k = 0; k < 2 && s->count; k++) s->mean[k] /= (double)s->count;
}

int pend_fit_start_camera(const struct pend_fit_problem *p, double camera[PEND_FIT_CAMERA]) {
    struct start_sums s;
    double reach = 0, *origin = camera + PEND_FIT_ORIGIN_X;
    int arm = start_nearest(p, &reach), sought = isnan(origin[0]);
    if (arm < 0) return 0;
    start_places(p, arm, &s);
    double whole = s.uu * s.vv - s.uv * s.uv, size = s.uu + s.vv, radius = s.far;
    int round = s.count >= FIT_FIRST && whole > fit_circle_flat * size * size && sought;
    double a = round ? (s.uw * s.vv - s.vw * s.uv) / whole : 0;
    double b = round ? (s.vw * s.uu - s.uw * s.uv) / whole : 0;
    if (round) radius = sqrt(a * a + b * b + size / (double)s.count);
    if (isnan(camera[PEND_FIT_SCALE]))
        camera[PEND_FIT_SCALE] = radius > 0 && reach > 0 ? radius / reach : 1;
    if (!sought) return s.count > 0;
    origin[0] = s.mean[0] + a;
    origin[1] = round ? s.mean[1] + b : s.lowest + camera[PEND_FIT_SCALE] * reach;
    return s.count > 0;
}

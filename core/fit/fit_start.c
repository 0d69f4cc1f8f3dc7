#include "core/fit/fit_start.h"

#include <assert.h>
#include <math.h>

/* places that lie on less of a circle, as a part of their spread squared, tell none */
static const double start_flat = 1e-9;

/* rows whose pace is a rate, and places that tell a circle */
enum { START_ROWS = 5, START_PLACES = 5 };

/* arms and rows at most where an arm without tips of its own is looked for in a line with others */
enum { START_ARMS = 30, START_SOME = 64 };

/* the columns of an arm's quantity; -1 = it is not measured */
static int start_column(const struct pend_fit_problem *p, int arm, enum pend_fit_kind kind) {
    for (int c = 0; c < p->columns; c++)
        if (p->column[c].arm == arm && p->column[c].kind == kind) return c;
    return -1;
}

/* a tip as the camera has it at a row, or the pivot of arm -1; 0 if it was not seen */
static int start_tip(const struct pend_fit_problem *p, int arm, long row, double *x, double *y) {
    *x = p->camera[PEND_FIT_ORIGIN_X], *y = p->camera[PEND_FIT_ORIGIN_Y];
    if (arm < 0) return 1;
    int at = start_column(p, arm, PEND_FIT_X), beside = start_column(p, arm, PEND_FIT_Y);
    if (at < 0 || beside < 0) return 0;
    *x = p->column[at].data[row], *y = p->column[beside].data[row];
    return !isnan(*x) && !isnan(*y);
}

double pend_fit_start_angle(const struct pend_fit_problem *p, int arm, long row) {
    int c = start_column(p, arm, PEND_FIT_PHI);
    double x, y, to_x, to_y;
    assert(arm >= 0 && arm < p->n && row >= 0 && row < p->rows);
    if (c >= 0) return p->column[c].data[row];
    if (!start_tip(p, p->parent[arm], row, &x, &y) || !start_tip(p, arm, row, &to_x, &to_y))
        return NAN;
    return atan2(to_y - y, to_x - x) - p->camera[PEND_FIT_ROTATION];
}

/* The same where tips between are not measured: from the last joint that is to the first tip that
 * is, as if the arms on the way were in one line. */
static double start_line(const struct pend_fit_problem *p, int arm, long row) {
    double x, y, to_x, to_y;
    int from = p->parent[arm], to = 0;
    if (p->n > START_ARMS) return NAN;
    while (!start_tip(p, from, row, &x, &y)) from = p->parent[from];
    for (; to < p->n; to++) {
        int k = to;
        while (k >= 0 && k != arm) k = p->parent[k];
        if (k == arm && start_tip(p, to, row, &to_x, &to_y))
            return atan2(to_y - y, to_x - x) - p->camera[PEND_FIT_ROTATION];
    }
    return NAN;
}

int pend_fit_start_state(const struct pend_fit_problem *p, int run, int arm, double *phi,
                         double *rate) {
    double begin = NAN, last = 0, turned = 0, since = 0, late = 0, until = 0;
    int seen = 0, rows = 0;
    int own = start_column(p, arm, PEND_FIT_PHI) >= 0 || start_column(p, arm, PEND_FIT_X) >= 0;
    for (long i = 0; i < p->rows && (own || rows < START_SOME) && seen < START_ROWS; i++) {
        if (pend_fit_run(p, i) != run) continue;
        double angle = pend_fit_start_angle(p, arm, i);
        if (isnan(angle) && start_column(p, arm, PEND_FIT_PHI) < 0) angle = start_line(p, arm, i);
        if (!rows++) since = p->t[i];
        if (isnan(angle)) continue;
        if (seen++)
            turned += remainder(angle - last, 2 * M_PI);
        else
            begin = angle, late = p->t[i];
        last = angle, until = p->t[i];
    }
    if (!seen) return 0;
    // whole turns beside the shorter way from the first to the last
    double way = remainder(last - begin, 2 * M_PI);
    way += 2 * M_PI * rint((turned - way) / (2 * M_PI));
    *rate = until > late ? way / (until - late) : 0;
    *phi = late > since ? begin - *rate * (late - since) : begin;
    return 1;
}

/* ---- the camera */

/* the arm next to the pivot whose tip is measured, and the length of the way there; -1 = none is */
static int start_nearest(const struct pend_fit_problem *p, double *reach) {
    int nearest = -1, least = p->n + 1;
    for (int arm = 0; arm < p->n; arm++) {
        int depth = 0;
        double way = 0;
        if (start_column(p, arm, PEND_FIT_X) < 0 || start_column(p, arm, PEND_FIT_Y) < 0) continue;
        for (int k = arm; k >= 0; k = p->parent[k]) way += p->length[k], depth++;
        if (depth < least) least = depth, nearest = arm, *reach = way;
    }
    return nearest;
}

/* the sums of places about their mean that a circle needs */
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
    int round = s.count >= START_PLACES && whole > start_flat * size * size && sought;
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

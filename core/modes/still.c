#include "core/modes/still.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/linear_arms.h"
#include "core/modes/rest.h"

enum { WIDE = 8, SWEEPS = 16, SOLVES = 4, VECTORS = 32 };

/* relative to the largest eigenvalue: vectors with closer eigenvalues are orthogonalized */
static const double near = 1e-7;

struct still_factor {
    double pivot, lean[2]; /* D, a */
};

/* the form x^T T x at WIDE values of s, as a function of a joint's position and the arm's angle */
struct still_form {
    double xx[WIDE], xy[WIDE], yy[WIDE], leanx[WIDE], leany[WIDE], pivot[WIDE];
};

struct pend_still {
    const int *parent;
    int n, found; /* number of eigenvalues, and of vectors found so far */
    int bracketed;
    double *low, *high;   /* n brackets of the eigenvalues */
    double *load, *joint; /* load and joint velocities of a solution: n and 2 n numbers */
    double *back;         /* n: g plus the springs of all joints in which the arm turns */
    struct linear_arms arms;
    struct still_factor *factor;
    struct still_form *form;
};

/* computes, for each arm, g plus the springs of all its joints; a spring relative to the ground
 * belongs to one arm only */
static void still_fill(struct pend_still *s, const struct pend_loads *loads) {
    double pull[2];
    pend_rest_pull(loads, pull);
    for (int k = 0; k < s->n; k++) {
        struct linear_arm *arm = &s->arms.arm[k];
        s->back[k] = 0;
        if (k || !pend_terms_cart(loads->terms))
            s->back[k] -= pull[0] * arm->whole[1] - pull[1] * arm->whole[0];
        s->back[k] += arm->spring;
        if (arm->holder >= 0) s->back[arm->holder] += arm->spring;
        if (arm->holder < 0) arm->spring = 0;
    }
}

enum pend_status pend_still_new(struct pend_still **still, const struct pend_tree *tree,
                                const struct pend_loads *loads, const double phi[]) {
    assert(pend_tree_valid(tree));
    size_t n = (size_t)tree->n;
    struct pend_still *made = *still = calloc(1, sizeof *made);
    enum pend_status status = PEND_NO_MEMORY;
    if (made) {
        *made = (struct pend_still){.parent = tree->parent, .n = tree->n};
        status = pend_linear_arms_init(&made->arms, tree, loads, phi);
        made->low = malloc(6 * n * sizeof *made->low);
        made->factor = malloc(n * sizeof *made->factor);
        made->form = malloc(n * sizeof *made->form);
    }
    if (status || !made->low || !made->factor || !made->form) {
        pend_still_free(still);
        return PEND_NO_MEMORY;
    }
    made->high = made->low + n, made->load = made->low + 2 * n, made->joint = made->low + 3 * n;
    made->back = made->low + 5 * n;
    still_fill(made, loads);
    return PEND_OK;
}

void pend_still_free(struct pend_still **still) {
    struct pend_still *s = *still;
    if (!s) return;
    free(s->low), free(s->factor), free(s->form);
    pend_linear_arms_clear(&s->arms);
    free(s);
    *still = NULL;
}

/* ---- counting */

/* computes the forms of the arms without their sub-trees, at WIDE values of s */
static void still_alone(const struct pend_still *still, const double s[]) {
    for (int k = 0; k < still->n; k++) {
        const struct linear_arm *arm = &still->arms.arm[k];
        struct still_form *form = &still->form[k];
        for (int i = 0; i < WIDE; i++) {
            form->xx[i] = form->yy[i] = -s[i] * arm->mass;
            form->xy[i] = 0;
            form->leanx[i] = -s[i] * arm->moment[0];
            form->leany[i] = -s[i] * arm->moment[1];
            form->pivot[i] = still->back[k] - s[i] * arm->inertia;
        }
    }
}

/* eliminates arm k, whose form is complete, and adds the rest of the form to that of its parent */
static void still_join(const struct linear_arm *arm, struct still_form *restrict own,
                       struct still_form *restrict up) {
    double x = arm->place[0], y = arm->place[1], k = arm->spring;
    for (int i = 0; i < WIDE; i++) {
        double part = 1 / own->pivot[i], a = own->leanx[i], b = own->leany[i];
        double xx = own->xx[i] - a * a * part, xy = own->xy[i] - a * b * part;
        double yy = own->yy[i] - b * b * part, turn = k * part;
        // P e, and the coupling of w and x_p, which is k a / D
        double ex = xx * x + xy * y, ey = xy * x + yy * y;
        up->xx[i] += xx, up->xy[i] += xy, up->yy[i] += yy;
        up->leanx[i] += ex + turn * a;
        up->leany[i] += ey + turn * b;
        up->pivot[i] += x * ex + y * ey + 2 * turn * (a * x + b * y) - k * turn;
    }
}

/* replaces a pivot of 0 by the smallest number comparable with the terms of the arm */
static double still_pivot(const struct pend_still *still, int k, double pivot, double s) {
    if (pivot != 0) return pivot;
    return -0x1p-60 * (fabs(still->back[k]) + fabs(s) * still->arms.arm[k].inertia) - 0x1p-1000;
}

static void still_count(const struct pend_still *still, const double s[], int count[]) {
    still_alone(still, s);
    for (int i = 0; i < WIDE; i++) count[i] = 0;
    for (int k = still->n - 1; k >= 0; k--) {
        struct still_form *form = &still->form[k];
        for (int i = 0; i < WIDE; i++) {
            form->pivot[i] = still_pivot(still, k, form->pivot[i], s[i]);
            count[i] += form->pivot[i] < 0;
        }
        if (k) still_join(&still->arms.arm[k], form, &still->form[still->parent[k]]);
    }
}

int pend_still_below(struct pend_still *still, double s) {
    double all[WIDE];
    int count[WIDE];
    assert(still->n >= 1 && isfinite(s));
    for (int i = 0; i < WIDE; i++) all[i] = s;
    still_count(still, all, count);
    return count[0];
}

static void still_bracket(struct pend_still *still) {
    double low = -1, high = 1;
    while (high < 0x1p1000 && pend_still_below(still, high) < still->n) high *= 4;
    while (low > -high && pend_still_below(still, low) > 0) low *= 4;
    if (pend_still_below(still, 0) == 0) low = 0;
    for (int k = 0; k < still->n; k++) still->low[k] = low, still->high[k] = high;
    still->bracketed = 1;
}

static int still_narrow(const struct pend_still *still, int k) {
    double low = still->low[k], high = still->high[k], most = still->high[still->n - 1];
    // if no force restores the arms, all eigenvalues are 0, and the bracket has no relative width
    return high - low <= 0x1p-51 * fmax(fabs(low), fabs(high)) + 0x1p-70 * most + 0x1p-1000;
}

/* halves up to WIDE different brackets, starting at eigenvalue *from; returns 0 if none is left */
static int still_halve(struct pend_still *still, int *from) {
    int first[WIDE], count[WIDE], lanes = 0, k = *from;
    double middle[WIDE] = {0};
    for (; k < still->n && lanes < WIDE; k++) {
        if (still_narrow(still, k)) continue;
        if (lanes && still->low[first[lanes - 1]] == still->low[k] &&
            still->high[first[lanes - 1]] == still->high[k])
            continue;
        first[lanes] = k;
        middle[lanes++] = still->low[k] + (still->high[k] - still->low[k]) / 2;
    }
    *from = k;
    if (!lanes) return 0;
    still_count(still, middle, count);
    for (int i = 0; i < lanes; i++) {
        double low = still->low[first[i]], high = still->high[first[i]];
        for (int j = first[i]; j < still->n && still->low[j] == low && still->high[j] == high;
             j++) {
            if (j < count[i])
                still->high[j] = middle[i];
            else
                still->low[j] = middle[i];
            // skips brackets equal to the previous one before it changed
        }
    }
    return 1;
}

/* ---- vectors */

/* factorizes T at one value of s, in lane 0 of the forms */
static void still_factorize(const struct pend_still *still, double s) {
    double all[WIDE];
    for (int i = 0; i < WIDE; i++) all[i] = s;
    still_alone(still, all);
    for (int k = still->n - 1; k >= 0; k--) {
        struct still_form *form = &still->form[k];
        for (int i = 0; i < WIDE; i++) form->pivot[i] = still_pivot(still, k, form->pivot[i], s);
        still->factor[k] = (struct still_factor){form->pivot[0], {form->leanx[0], form->leany[0]}};
        if (k) still_join(&still->arms.arm[k], form, &still->form[still->parent[k]]);
    }
}

/* solves T x = load; overwrites load */
static void still_solve(const struct pend_still *still, double load[], double x[]) {
    double *push = still->joint;
    memset(push, 0, 2 * (size_t)still->n * sizeof *push);
    for (int k = still->n - 1; k > 0; k--) {
        const struct linear_arm *arm = &still->arms.arm[k];
        const struct still_factor *f = &still->factor[k];
        int p = still->parent[k];
        double part = load[k] / f->pivot;
        double px = push[2 * k] - f->lean[0] * part, py = push[2 * k + 1] - f->lean[1] * part;
        push[2 * p] += px, push[2 * p + 1] += py;
        load[p] += arm->place[0] * px + arm->place[1] * py + arm->spring * part;
    }
    double *joint = still->joint;
    for (int k = 0; k < still->n; k++) {
        const struct linear_arm *arm = &still->arms.arm[k];
        const struct still_factor *f = &still->factor[k];
        int p = still->parent[k];
        joint[2 * k] = p < 0 ? 0 : joint[2 * p] + arm->place[0] * x[p];
        joint[2 * k + 1] = p < 0 ? 0 : joint[2 * p + 1] + arm->place[1] * x[p];
        double rest = load[k] - f->lean[0] * joint[2 * k] - f->lean[1] * joint[2 * k + 1];
        x[k] = (rest + (arm->spring != 0 ? arm->spring * x[p] : 0)) / f->pivot;
    }
}

/* out = M x */
static void still_weigh(const struct pend_still *still, const double x[], double out[]) {
    double *joint = still->joint;
    for (int k = 0; k < still->n; k++) {
        const struct linear_arm *arm = &still->arms.arm[k];
        int p = still->parent[k];
        joint[2 * k] = p < 0 ? 0 : joint[2 * p] + arm->place[0] * x[p];
        joint[2 * k + 1] = p < 0 ? 0 : joint[2 * p + 1] + arm->place[1] * x[p];
    }
    // the momenta overwrite the velocities of the joints
    for (int k = 0; k < still->n; k++) {
        const struct linear_arm *arm = &still->arms.arm[k];
        double wx = joint[2 * k], wy = joint[2 * k + 1];
        out[k] = arm->moment[0] * wx + arm->moment[1] * wy + arm->inertia * x[k];
        joint[2 * k] = arm->mass * wx + arm->moment[0] * x[k];
        joint[2 * k + 1] = arm->mass * wy + arm->moment[1] * x[k];
    }
    for (int k = still->n - 1; k > 0; k--) {
        const struct linear_arm *arm = &still->arms.arm[k];
        int p = still->parent[k];
        out[p] += arm->place[0] * joint[2 * k] + arm->place[1] * joint[2 * k + 1];
        joint[2 * p] += joint[2 * k], joint[2 * p + 1] += joint[2 * k + 1];
    }
}

/* x^T K x: sums over gravity and all springs */
static double still_stiff(const struct pend_still *still, const double x[]) {
    double sum = 0;
    for (int k = 0; k < still->n; k++) {
        const struct linear_arm *arm = &still->arms.arm[k];
        sum += still->back[k] * x[k] * x[k];
        if (arm->spring != 0) sum -= 2 * arm->spring * x[k] * x[still->parent[k]];
    }
    return sum;
}

static double still_dot(int n, const double x[], const double y[]) {
    double sum = 0;
    for (int k = 0; k < n; k++) sum += x[k] * y[k];
    return sum;
}

/* makes x orthogonal to the modes close to mode j, and scales it to unit size; load becomes M x */
static void still_orthogonal(const struct pend_still *still, const double square[],
                             const double vector[], int j, double x[]) {
    int n = still->n;
    double most = fmax(fabs(square[0]), fabs(square[n - 1]));
    for (int pass = 0; pass < 2; pass++) {
        still_weigh(still, x, still->load);
        for (int i = j - 1; i >= 0 && square[j] - square[i] <= near * most; i--) {
            const double *other = vector + (size_t)i * (size_t)n;
            double part = still_dot(n, other, still->load);
            for (int k = 0; k < n; k++) x[k] -= part * other[k];
        }
    }
    still_weigh(still, x, still->load);
    double size = sqrt(still_dot(n, x, still->load));
    for (int k = 0; k < n; k++) x[k] /= size, still->load[k] /= size;
}

static void still_vector(const struct pend_still *still, const double square[], double vector[],
                         int j) {
    double *x = vector + (size_t)j * (size_t)still->n;
    assert(still->bracketed && j < still->n);
    still_factorize(still, square[j]);
    // a start with a component along every mode, and different for each mode
    unsigned long long seed = 0x9e3779b97f4a7c15ull * (unsigned long long)(j + 1);
    for (int k = 0; k < still->n; k++) {
        seed = seed * 6364136223846793005ull + 1442695040888963407ull;
        x[k] = (double)(seed >> 40) * 0x1p-24 + 0.5;
    }
    for (int i = 0; i < SOLVES; i++) {
        still_orthogonal(still, square, vector, j, x);
        still_solve(still, still->load, x);
        // if entries have overflowed, scale down first
        double most = 0;
        for (int k = 0; k < still->n; k++) most = fmax(most, fabs(x[k]));
        for (int k = 0; k < still->n; k++) x[k] /= most;
    }
    still_orthogonal(still, square, vector, j, x);
}

int pend_still_step(struct pend_still *still, double square[], double vector[]) {
    int from = 0;
    assert(still->found >= 0 && still->found < still->n && square != vector);
    if (!still->bracketed) still_bracket(still);
    if (!still->found) {
        for (int i = 0; i < SWEEPS && from < still->n; i++) still_halve(still, &from);
        // all brackets were visited, and all are narrow
        int wide = 0;
        for (int k = 0; k < still->n; k++) wide += !still_narrow(still, k);
        if (wide) return 0;
        for (int k = 0; k < still->n; k++)
            square[k] = still->low[k] + (still->high[k] - still->low[k]) / 2;
    }
    for (int i = 0; i < VECTORS && still->found < still->n; i++, still->found++)
        still_vector(still, square, vector, still->found);
    if (still->found < still->n) return 0;
    // the Rayleigh quotient has twice the digits of the vector, and no cancellation
    for (int j = 0; j < still->n; j++)
        square[j] = still_stiff(still, vector + (size_t)j * (size_t)still->n);
    return 1;
}

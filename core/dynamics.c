#include "core/dynamics.h"

#include <math.h>

/* Scratch, one value an arm in each array; the letters are those of core/README.md. */
struct dynamics_work {
    double *cosine, *sine;               /* of the angle to the parent */
    double *eff, *push, *bias;           /* S, h and f = h - S l phi'^2: lambda = S ar + h */
    double *inv;                         /* 1 / (m + q) */
    double *r, *bt;                      /* sums over the children */
    double *q_after, *r_after, *t_after; /* the same sums over the later siblings of an arm */
    /* sums of the way up; on the way down: acceleration of the tip, and sums over the siblings that came before */
    union {
        double *p;
        double *radial;
    };
    union {
        double *q;
        double *tangential;
    };
    union {
        double *bu;
        double *q_before;
    };
    union {
        double *det;
        double *r_before;
    };
    union {
        double *lift;
        double *t_before;
    };
};

enum { DYNAMICS_ARRAYS = 16, DYNAMICS_PAD = 8 };

static size_t dynamics_stride(int n) { return ((size_t)n + DYNAMICS_PAD - 1) / DYNAMICS_PAD * DYNAMICS_PAD; }

size_t pend_dynamics_work_bytes(int n) { return DYNAMICS_ARRAYS * dynamics_stride(n) * sizeof(double); }

static struct dynamics_work dynamics_view(void *work, int n) {
    size_t stride = dynamics_stride(n);
    double *at = work;
    struct dynamics_work w;
    double **array[DYNAMICS_ARRAYS] = {&w.cosine,  &w.sine,    &w.eff,     &w.push, &w.bias, &w.inv, &w.r,   &w.bt,
                                       &w.q_after, &w.r_after, &w.t_after, &w.p,    &w.q,    &w.bu,  &w.det, &w.lift};
    for (int i = 0; i < DYNAMICS_ARRAYS; i++) *array[i] = at + (size_t)i * stride;
    return w;
}

/* relative angles; the pivot's frame is at angle 0 */
static void dynamics_angles(const struct pend_tree *tree, const double phi[], const struct dynamics_work *w) {
    for (int k = 0; k < tree->n; k++) {
        double angle = k ? phi[k] - phi[tree->parent[k]] : phi[k];
        w->cosine[k] = cos(angle);
        w->sine[k] = sin(angle);
    }
}

/* adds what child c does to the sums of its parent p */
static void dynamics_join(const struct dynamics_work *w, int c, int p) {
    double C = w->cosine[c], Z = w->sine[c], S = w->eff[c], f = w->bias[c];
    double sp = w->p[p], sr = w->r[p], sq = w->q[p], bu = w->bu[p], bt = w->bt[p];
    w->q_after[c] = sq, w->r_after[c] = sr, w->t_after[c] = bt;
    w->lift[p] += f * (sq * C - sr * Z) + S * Z * (Z * bu - C * bt);
    w->det[p] += S * (sp * Z * Z - 2 * sr * Z * C + sq * C * C);
    w->p[p] = sp + S * C * C;
    w->r[p] = sr + S * C * Z;
    w->q[p] = sq + S * Z * Z;
    w->bu[p] = bu + f * C;
    w->bt[p] = bt + f * Z;
}

/* leaves to root: effective mass and force terms */
static void dynamics_up(const struct pend_tree *tree, const double rate[], const struct dynamics_work *w) {
    for (int k = 0; k < tree->n; k++) w->p[k] = w->q[k] = w->r[k] = w->bu[k] = w->bt[k] = w->det[k] = w->lift[k] = 0;
    for (int k = tree->n - 1; k >= 0; k--) {
        double m = tree->mass[k], inv = 1 / (m + w->q[k]);
        w->inv[k] = inv;
        w->eff[k] = (m * (m + w->p[k] + w->q[k]) + w->det[k]) * inv;
        w->push[k] = (m * w->bu[k] + w->lift[k]) * inv;
        w->bias[k] = w->push[k] - w->eff[k] * (tree->len[k] * rate[k] * rate[k]);
        if (k) dynamics_join(w, k, tree->parent[k]);
    }
}

/* compression of arm k, whose parent p has its radial acceleration already; adds k to the sums of p's arms so far */
static double dynamics_tension(const struct pend_tree *tree, const struct dynamics_work *w, int k, int p) {
    double C = w->cosine[k], Z = w->sine[k], S = w->eff[k], f = w->bias[k], ar = w->radial[p];
    double others_q = w->q_before[p] + w->q_after[k];
    double others_t = ar * (w->r_before[p] + w->r_after[k]) + (w->t_before[p] + w->t_after[k]);
    w->q_before[p] += S * Z * Z;
    w->r_before[p] += S * Z * C;
    w->t_before[p] += f * Z;
    return w->inv[p] * ((S * C * ar + f) * (tree->mass[p] + others_q) - S * Z * others_t);
}

/* root to leaves: compression first, then the accelerations it causes */
static void dynamics_down(const struct pend_tree *tree, double gravity, const struct dynamics_work *w, double acc[],
                          double force[]) {
    for (int k = 0; k < tree->n; k++) w->q_before[k] = w->r_before[k] = w->t_before[k] = 0;
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        double C = w->cosine[k], Z = w->sine[k];
        // gravity is a pivot that accelerates with i g
        double ar = p < 0 ? 0 : w->radial[p], at = p < 0 ? gravity : w->tangential[p];
        double lambda = p < 0 ? w->eff[k] * Z * gravity + w->bias[k] : dynamics_tension(tree, w, k, p);
        w->radial[k] = (lambda - w->push[k]) / w->eff[k];
        w->tangential[k] = -w->inv[k] * (w->r[k] * w->radial[k] + w->bt[k]);
        acc[k] = (w->tangential[k] + Z * ar - C * at) / tree->len[k];
        if (force) force[k] = lambda;
    }
}

void pend_dynamics(const struct pend_tree *tree, double gravity, const double phi[], const double rate[], void *work,
                   double acc[], double force[]) {
    struct dynamics_work w = dynamics_view(work, tree->n);
    dynamics_angles(tree, phi, &w);
    dynamics_up(tree, rate, &w);
    dynamics_down(tree, gravity, &w, acc, force);
}

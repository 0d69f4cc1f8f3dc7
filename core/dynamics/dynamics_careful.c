#include "core/dynamics/dynamics_careful.h"

#include <assert.h>
#include <limits.h>
#include <math.h>

#include "core/simd/kernel_sincos.h"

/* Scratch, one value per arm in each array; the letters are those of core/theory.md. */
struct dynamics_work {
    double *cosine, *sine; /* C, Z: cosine and sine of the angle to the parent */
    double *spin;          /* w = l phi'^2 */
    double *eff, *bias;    /* S, f: the force on the base along the arm is S times its acceleration,
                            * plus f */
    double *inv;           /* 1 / (m + q) */
    double *p, *q, *r, *t; /* sums over the children: S C^2, S Z^2, S C Z, f Z */
    double *q_after, *r_after, *t_after; /* the same sums over the later siblings */
    double *radial, *tangential;         /* acceleration of the tip, along and across its arm */
    double *tension;                     /* lambda */
};

enum { DYNAMICS_ARRAYS = sizeof(struct dynamics_work) / sizeof(double *), DYNAMICS_PAD = 8 };

static size_t dynamics_stride(int n) {
    return ((size_t)n + DYNAMICS_PAD - 1) / DYNAMICS_PAD * DYNAMICS_PAD;
}

size_t pend_dynamics_careful_bytes(int n) {
    assert(n >= 1);
    return DYNAMICS_ARRAYS * dynamics_stride(n) * sizeof(double);
}

static struct dynamics_work dynamics_view(void *work, int n) {
    double *a = work;
    size_t s = dynamics_stride(n);
    return (struct dynamics_work){a,          a + s,      a + 2 * s,  a + 3 * s,
                                  a + 4 * s,  a + 5 * s,  a + 6 * s,  a + 7 * s,
                                  a + 8 * s,  a + 9 * s,  a + 10 * s, a + 11 * s,
                                  a + 12 * s, a + 13 * s, a + 14 * s, a + 15 * s};
}

/* Sums over the children of one arm that were added so far. The angles between siblings are
 * measured from the heaviest of them; u and v stand for along and across the heaviest. */
struct dynamics_joint {
    double p, q, r;         /* S C^2, S Z^2, S C Z */
    double b, t;            /* f C, f Z */
    double area, lift;      /* D, H: sums over pairs of S_c S_d sin^2 and of S_c Z_c f_d sin, of the
                               angle between the two */
    double heaviest, angle; /* the largest S of the siblings, and the angle of that arm */
    double uu, uv, vv;      /* sums of S c^2, S c s, S s^2; c, s: of the angle to the heaviest */
    double fu, fv;          /* sums of f c and f s */
    double zu, zv;          /* sums of S Z c and S Z s */
};

/* Joints that still wait for children. Each is in the sub-tree of a child of the joint below it on
 * the stack, but not of the largest child. So the sizes of their sub-trees at least halve from one
 * to the next, and the stack needs no more entries than an int has bits. */
struct dynamics_stack {
    int count;
    struct dynamics_joint joint[sizeof(int) * CHAR_BIT + 1];
};

/* Cosine and sine of a - b, both accurate to the last digit. The difference is rounded; near a half
 * turn only this rounding error distinguishes two arms from aligned ones. The C library's sine and
 * cosine would not do, because their last bits differ between machines. */
static void dynamics_between(double a, double b, double *cosine, double *sine) {
    double angle = a - b, back = angle + b, lost = (a - back) - (b - (back - angle));
    _Alignas(64) double C[PEND_TURN_CAP], Z[PEND_TURN_CAP];
    pend_kernel_sincos_base(&angle, 1, C, Z);
    *cosine = C[0] - lost * Z[0];
    *sine = Z[0] + lost * C[0];
}

/* starts a joint with its first child c */
static struct dynamics_joint dynamics_first(const struct dynamics_work *w, int c, double phi) {
    double C = w->cosine[c], Z = w->sine[c], S = w->eff[c], f = w->bias[c];
    w->q_after[c] = w->r_after[c] = w->t_after[c] = 0;
    return (struct dynamics_joint){.p = S * C * C,
                                   .q = S * Z * Z,
                                   .r = S * C * Z,
                                   .b = f * C,
                                   .t = f * Z,
                                   .heaviest = S,
                                   .angle = phi,
                                   .uu = S,
                                   .fu = f,
                                   .zu = S * Z};
}

/* Adds child c to a joint. The increase of the sums over pairs is computed in the frame of the
 * heaviest child, where no large terms cancel. Differences of the sums p to t would lose it for
 * nearly aligned arms. */
static void dynamics_join(const struct dynamics_work *w, int c, double phi,
                          struct dynamics_joint *j) {
    double C = w->cosine[c], Z = w->sine[c], S = w->eff[c], f = w->bias[c];
    double x, y;
    dynamics_between(phi, j->angle, &x, &y);
    double vv = y * (j->uu * y - 2 * j->uv * x) + j->vv * x * x;
    double fv = x * j->fv - y * j->fu, zv = x * j->zv - y * j->zu;
    w->q_after[c] = j->q, w->r_after[c] = j->r, w->t_after[c] = j->t;
    j->area += S * vv;
    j->lift += f * zv - S * Z * fv;
    j->p += S * C * C, j->q += S * Z * Z, j->r += S * C * Z;
    j->b += f * C, j->t += f * Z;
    if (S > j->heaviest) {
        // c becomes the heaviest: rotate the sums into its frame
        double uu = x * (j->uu * x + 2 * j->uv * y) + j->vv * y * y;
        double uv = (j->vv - j->uu) * x * y + j->uv * (x - y) * (x + y);
        double fu = x * j->fu + y * j->fv, zu = x * j->zu + y * j->zv;
        j->heaviest = S, j->angle = phi;
        j->uu = uu + S, j->uv = uv, j->vv = vv;
        j->fu = fu + f, j->fv = fv;
        j->zu = zu + S * Z, j->zv = zv;
    } else {
        j->uu += S * x * x, j->uv += S * x * y, j->vv += S * y * y;
        j->fu += f * x, j->fv += f * y;
        j->zu += S * Z * x, j->zv += S * Z * y;
    }
}

/* leaves to root: effective masses and forces */
static void dynamics_up(const struct pend_tree *tree, double unit, const double phi[],
                        const double rate[], const struct dynamics_work *w) {
    static const struct dynamics_joint bare = {0};
    struct dynamics_stack stack;
    stack.count = 0;
    for (int k = tree->n - 1; k >= 0; k--) {
        const struct dynamics_joint *j = tree->end[k] > k + 1 ? &stack.joint[--stack.count] : &bare;
        double m = unit * tree->mass[k], inv = 1 / (m + j->q);
        w->spin[k] = tree->len[k] * rate[k] * rate[k];
        w->inv[k] = inv;
        w->eff[k] = m + (m * j->p + j->area) * inv;
        w->bias[k] = (m * j->b + j->lift) * inv - w->eff[k] * w->spin[k];
        w->p[k] = j->p, w->q[k] = j->q, w->r[k] = j->r, w->t[k] = j->t;
        if (k == 0) break;
        // in this sweep the last child comes first
        if (tree->end[k] == tree->end[tree->parent[k]]) {
            assert(stack.count < (int)(sizeof stack.joint / sizeof *stack.joint));
            stack.joint[stack.count++] = dynamics_first(w, k, phi[k]);
        } else {
            dynamics_join(w, k, phi[k], &stack.joint[stack.count - 1]);
        }
    }
}

/* computes the acceleration of the tip of arm k, from that of its base, (ar, at), in the frame of
 * the parent arm */
static void dynamics_tip(const struct pend_tree *tree, const struct dynamics_work *w, int k,
                         double ar, double at, double acc[]) {
    double C = w->cosine[k], Z = w->sine[k];
    double radial = C * ar + Z * at - w->spin[k],
           tangential = -w->inv[k] * (w->r[k] * radial + w->t[k]);
    w->radial[k] = radial;
    w->tangential[k] = tangential;
    acc[k] = (tangential + Z * ar - C * at) / tree->len[k];
}

/* Distributes the residual of the force balance at tip k over its children, in proportion to their
 * compliance. If heavy arms pull at a light joint, each tension is a small difference of large
 * terms, but the sum of the tensions is determined by the tension of arm k. */
static void dynamics_balance(const struct pend_tree *tree, const struct dynamics_work *w, double m,
                             int k) {
    double ar = w->radial[k], at = w->tangential[k];
    double er = w->tension[k] - m * ar, et = -m * at;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
        er -= w->cosine[c] * w->tension[c];
        et -= w->sine[c] * w->tension[c];
    }
    double scale = w->inv[k] / w->eff[k];
    double dr = ((m + w->q[k]) * er - w->r[k] * et) * scale,
           dt = ((m + w->p[k]) * et - w->r[k] * er) * scale;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c])
        w->tension[c] += w->eff[c] * (w->cosine[c] * dr + w->sine[c] * dt);
}

/* computes tensions and accelerations of the arms at tip k from those of arm k */
static void dynamics_children(const struct pend_tree *tree, const struct dynamics_work *w, double m,
                              int k, double acc[]) {
    double ar = w->radial[k], at = w->tangential[k], inv = w->inv[k];
    double q_before = 0, r_before = 0, t_before = 0;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
        double C = w->cosine[c], Z = w->sine[c], S = w->eff[c], f = w->bias[c];
        double q = q_before + w->q_after[c], r = r_before + w->r_after[c],
               t = t_before + w->t_after[c];
        w->tension[c] = inv * ((S * C * ar + f) * (m + q) - S * Z * (r * ar + t));
        q_before += S * Z * Z, r_before += S * Z * C, t_before += f * Z;
        dynamics_tip(tree, w, c, ar, at, acc);
    }
    dynamics_balance(tree, w, m, k);
}

void pend_dynamics_careful(const struct pend_tree *tree, const struct pend_loads *loads,
                           const double phi[], const double rate[], void *work, double acc[],
                           double force[]) {
    assert((size_t)work % 64 == 0 && isfinite(loads->gravity));
    assert(phi != acc && phi != force && acc != force);
    struct dynamics_work w = dynamics_view(work, tree->n);
    // the unit of mass is a power of 2 near the total, so that products of masses stay in range
    int exponent;
    frexp(tree->subtree_mass[0], &exponent);
    if (exponent < -1000) exponent = -1000;
    double unit = ldexp(1, -exponent);

    for (int k = 0; k < tree->n; k++)
        dynamics_between(phi[k], k ? phi[tree->parent[k]] : 0, &w.cosine[k], &w.sine[k]);
    dynamics_up(tree, unit, phi, rate, &w);

    // gravity is equivalent to a pivot with the acceleration i g
    w.tension[0] = w.eff[0] * w.sine[0] * loads->gravity + w.bias[0];
    dynamics_tip(tree, &w, 0, 0, loads->gravity, acc);
    for (int k = 0; k < tree->n; k++)
        if (tree->end[k] > k + 1) dynamics_children(tree, &w, unit * tree->mass[k], k, acc);
    if (force)
        for (int k = 0; k < tree->n; k++) force[k] = ldexp(w.tension[k], exponent);
}

#include "core/modes/lossy.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/base/rng.h"
#include "core/modes/linear_arms.h"
#include "core/modes/still.h"

enum {
    LOSSY_SWEEPS = 64,
    LOSSY_ROUNDS = 400,
    LOSSY_PATIENCE = 24,
    LOSSY_POLISHES = 12,
    LOSSY_SEED = 2
};

/* Tolerances. Relative: the change of a root that has converged; the imaginary part of a root that
 * counts as real; the residual of a shape, compared with the largest torque; the distance by which
 * refinement may move a root, large because of clusters. Absolute: the difference between sum 1 /
 * (z - p) and the value of a sweep at z. */
static const double settled = 1e-11, real_part = 1e-8, missed_most = 1e-9, moved_most = 0.3,
                    sum_missed = 1e-6;

struct dual {
    double complex v, d;
};

/* factors by which masses, damping and stiffness enter at p */
struct lossy_factors {
    struct dual mass, loss;
    double back;
};

struct lossy_node {
    struct dual form[3], cross[2], own, joint;
    double complex inverse;                /* inverse of the elimination pivot */
    double complex couple, push[2];        /* right-hand side of a solution: torque and force */
    double complex base[2], force[2], row; /* of a product: displacement, force, row */
    double size;                           /* size of the terms of `row` */
};

struct pend_lossy {
    struct linear_arms arms;
    struct pend_still *still;  /* NULL once the undamped modes are found */
    int n, round, at;          /* round of Aberth's method; next root to move, later to return */
    int moving;                /* number of roots that have not converged in this round */
    int fewest, patience;      /* the smallest value of `moving` so far, and the remaining rounds in
                                * which it must decrease */
    int zeros;                 /* number of roots that count as 0 */
    double least;              /* 1/s: a smaller root counts as 0 */
    double *square, *vector;   /* n values, n x n angles: the undamped modes */
    double complex *root;      /* 2 n roots */
    double complex *x, *y;     /* n each */
    unsigned char *still_root; /* 2 n flags: the root has converged */
    struct lossy_node *node;   /* n */
};

static struct dual dual_add(struct dual a, struct dual b) {
    return (struct dual){a.v + b.v, a.d + b.d};
}

static struct dual dual_sub(struct dual a, struct dual b) {
    return (struct dual){a.v - b.v, a.d - b.d};
}

static struct dual dual_mul(struct dual a, struct dual b) {
    return (struct dual){a.v * b.v, a.v * b.d + a.d * b.v};
}

static struct dual dual_scale(double r, struct dual a) { return (struct dual){r * a.v, r * a.d}; }

/* ---- the quadratic form at p */

static struct lossy_factors lossy_at(const struct pend_lossy *s, double complex p) {
    double drag_per_mass = s->arms.drag_per_mass;
    return (struct lossy_factors){
        {p * (p + 2 * drag_per_mass), 2 * (p + drag_per_mass)}, {p, 1}, 1};
}

/* mass and loss at p: mass m + loss b */
static struct dual lossy_weigh(const struct lossy_factors *f, double mass, double drag) {
    return dual_add(dual_scale(mass, f->mass), dual_scale(drag, f->loss));
}

static struct dual lossy_joint(const struct lossy_factors *f, const struct linear_arm *arm) {
    struct dual joint = dual_scale(arm->damper, f->loss);
    joint.v += f->back * arm->spring;
    return joint;
}

static struct dual lossy_turn(const struct lossy_factors *f, const struct linear_arm *arm) {
    struct dual turn = lossy_weigh(f, arm->inertia, arm->drag * arm->span);
    turn.v += f->back * arm->fall;
    return turn;
}

static struct dual lossy_cross(const struct lossy_factors *f, const struct linear_arm *arm, int i) {
    return lossy_weigh(f, arm->moment[i], arm->drag * arm->lever[i]);
}

/* adds the form of an arm to its parent, after elimination of the arm's angle */
static void lossy_pass(const struct linear_arm *arm, const struct lossy_node *node,
                       struct dual inverse, struct lossy_node *parent) {
    const struct dual none = {0, 0};
    struct dual x = node->cross[0], y = node->cross[1];
    struct dual give = arm->holder < 0 ? none : dual_mul(node->joint, inverse);
    struct dual xx = dual_sub(node->form[0], dual_mul(dual_mul(x, x), inverse));
    struct dual xy = dual_sub(node->form[1], dual_mul(dual_mul(x, y), inverse));
    struct dual yy = dual_sub(node->form[2], dual_mul(dual_mul(y, y), inverse));
    struct dual u = dual_mul(x, give), v = dual_mul(y, give);
    double px = arm->place[0], py = arm->place[1];
    struct dual ax = dual_add(dual_scale(px, xx), dual_scale(py, xy));
    struct dual ay = dual_add(dual_scale(px, xy), dual_scale(py, yy));
    struct dual own = dual_add(dual_scale(px, ax), dual_scale(py, ay));
    own = dual_add(own, dual_add(dual_scale(2 * px, u), dual_scale(2 * py, v)));
    own = dual_add(own, dual_mul(give, node->own));
    parent->form[0] = dual_add(parent->form[0], xx);
    parent->form[1] = dual_add(parent->form[1], xy);
    parent->form[2] = dual_add(parent->form[2], yy);
    parent->cross[0] = dual_add(parent->cross[0], dual_add(ax, u));
    parent->cross[1] = dual_add(parent->cross[1], dual_add(ay, v));
    parent->own = dual_add(parent->own, own);
}

/* eliminates all arms at p; returns the logarithmic derivative of the determinant */
static double complex lossy_factor(struct pend_lossy *s, double complex p) {
    const struct lossy_factors f = lossy_at(s, p);
    double complex sum = 0;
    for (int k = 0; k < s->n; k++) {
        const struct linear_arm *arm = s->arms.arm + k;
        struct dual weight = lossy_weigh(&f, arm->mass, arm->drag);
        struct lossy_node *node = s->node + k;
        node->form[0] = node->form[2] = weight;
        node->form[1] = (struct dual){0, 0};
        for (int i = 0; i < 2; i++) node->cross[i] = lossy_cross(&f, arm, i);
        node->own = lossy_turn(&f, arm);
        node->joint = lossy_joint(&f, arm);
    }
    for (int k = s->n - 1; k >= 0; k--) {
        const struct linear_arm *arm = s->arms.arm + k;
        struct lossy_node *node = s->node + k;
        struct dual pivot = dual_add(node->own, node->joint);
        // at a root the terms of the sum cancel up to rounding
        double parts = cabs(f.mass.v * arm->inertia) + fabs(arm->fall) + cabs(node->joint.v);
        if (cabs(pivot.v) <= 0x1p-60 * parts) pivot.v = 0x1p-60 * parts;
        struct dual inverse = {.v = 1 / pivot.v};
        inverse.d = -pivot.d * inverse.v * inverse.v;
        node->inverse = inverse.v;
        sum += pivot.d * inverse.v;
        if (arm->parent >= 0) lossy_pass(arm, node, inverse, s->node + arm->parent);
    }
    return sum;
}

/* solves form x = b with the computed factors; b and x may be the same array */
static void lossy_solve(const struct pend_lossy *s, const double complex b[], double complex x[]) {
    struct lossy_node *node = s->node;
    for (int k = 0; k < s->n; k++) {
        node[k].couple = b[k];
        node[k].push[0] = node[k].push[1] = 0;
    }
    for (int k = s->n - 1; k > 0; k--) {
        const struct linear_arm *arm = s->arms.arm + k;
        struct lossy_node *parent = node + arm->parent;
        double complex share = node[k].couple * node[k].inverse;
        if (arm->holder >= 0) parent->couple += share * node[k].joint.v;
        for (int i = 0; i < 2; i++) {
            double complex push = node[k].push[i] - share * node[k].cross[i].v;
            parent->push[i] += push;
            parent->couple += arm->place[i] * push;
        }
    }
    for (int k = 0; k < s->n; k++) {
        const struct linear_arm *arm = s->arms.arm + k;
        double complex sum = node[k].couple;
        for (int i = 0; i < 2; i++) {
            node[k].base[i] =
                arm->parent < 0 ? 0 : node[arm->parent].base[i] + arm->place[i] * x[arm->parent];
            sum -= node[k].cross[i].v * node[k].base[i];
        }
        if (arm->holder >= 0) sum += node[k].joint.v * x[arm->holder];
        x[k] = sum * node[k].inverse;
    }
}

/* multiplies a form, or its derivative if `derived`, by x; the rows of the product and the sizes of
 * their terms are stored in the nodes */
static void lossy_apply(const struct pend_lossy *s, double complex p, int derived,
                        const double complex x[]) {
    struct lossy_factors f = lossy_at(s, p);
    struct lossy_node *node = s->node;
    if (derived) {
        f.mass = (struct dual){f.mass.d, 0}, f.loss = (struct dual){f.loss.d, 0};
        f.back = 0;
    }
    for (int k = 0; k < s->n; k++) {
        const struct linear_arm *arm = s->arms.arm + k;
        double complex weight = lossy_weigh(&f, arm->mass, arm->drag).v;
        double complex own = lossy_turn(&f, arm).v * x[k];
        double complex bent = arm->holder < 0 ? x[k] : x[k] - x[arm->holder];
        bent *= lossy_joint(&f, arm).v;
        node[k].row = own + bent;
        node[k].couple = bent;
        node[k].size = cabs(own) + cabs(bent);
        for (int i = 0; i < 2; i++) {
            double complex cross = lossy_cross(&f, arm, i).v;
            node[k].base[i] =
                arm->parent < 0 ? 0 : node[arm->parent].base[i] + arm->place[i] * x[arm->parent];
            node[k].force[i] = weight * node[k].base[i] + cross * x[k];
            node[k].row += cross * node[k].base[i];
            node[k].size += cabs(cross * node[k].base[i]);
        }
    }
    for (int k = s->n - 1; k > 0; k--) {
        const struct linear_arm *arm = s->arms.arm + k;
        struct lossy_node *parent = node + arm->parent;
        if (arm->holder >= 0) parent->row -= node[k].couple;
        for (int i = 0; i < 2; i++) {
            parent->force[i] += node[k].force[i];
            parent->row += arm->place[i] * node[k].force[i];
            parent->size += cabs(arm->place[i] * node[k].force[i]);
        }
    }
}

/* the damping x^T C x of an undamped mode of unit mass norm */
static double lossy_loss(const struct pend_lossy *s, const double x[]) {
    double sum = 2 * s->arms.drag_per_mass;
    for (int k = 0; k < s->n; k++) {
        const struct linear_arm *arm = s->arms.arm + k;
        double square = 0, bent = arm->holder < 0 ? x[k] : x[k] - x[arm->holder];
        for (int i = 0; i < 2; i++) {
            double base = arm->parent < 0 ? 0
                                          : creal(s->node[arm->parent].base[i]) +
                                                arm->place[i] * x[arm->parent];
            double tip = base + arm->lever[i] * x[k];
            s->node[k].base[i] = base;
            square += tip * tip;
        }
        sum += arm->damper * bent * bent + arm->drag * square;
    }
    return sum;
}

/* initial roots: those of each undamped mode by itself, moved slightly apart and away from the real
 * axis */
static void lossy_guess(struct pend_lossy *s) {
    assert(s->n >= 1 && s->square && s->vector && s->root);
    double most = fmax(fabs(s->square[0]), fabs(s->square[s->n - 1])), null = s->n * 0x1p-52 * most;
    s->least = 1;
    s->fewest = 2 * s->n;
    s->patience = LOSSY_PATIENCE;
    for (int j = 0; j < s->n; j++) {
        double half = lossy_loss(s, s->vector + (size_t)j * (size_t)s->n) / 2;
        double own = sqrt(fabs(s->square[j]));
        if (fabs(s->square[j]) <= null)
            s->zeros += half * half > null ? 1 : 2;
        else
            s->least = fmin(s->least, 1e-15 * own * own / fmax(half, own));
        double complex off = csqrt(half * half - s->square[j]);
        for (int i = 0; i < 2; i++) {
            double complex root = -half + (i ? -off : off);
            double size = cabs(root) + sqrt(fabs(s->square[j])) + 1e-6 * half + 1e-9;
            double apart = 1e-3 * size;
            uint64_t at = 2 * (uint64_t)j + (uint64_t)i;
            s->root[at] = root + apart * pend_rng_normal(LOSSY_SEED, at, 0) +
                          apart * I * pend_rng_normal(LOSSY_SEED, at, 1);
        }
    }
}

/* ---- Aberth's rounds */

/* moves a root; returns non-zero if it has converged */
static int lossy_move(struct pend_lossy *s, int i) {
    assert(i >= 0 && i < 2 * s->n);
    double complex p = s->root[i], others = 0;
    double complex newton = 1 / lossy_factor(s, p);
    for (int j = 0; j < 2 * s->n; j++) {
        double complex gap = p - s->root[j];
        if (j == i || gap == 0) continue;
        others += conj(gap) / (creal(gap) * creal(gap) + cimag(gap) * cimag(gap));
    }
    double complex move = newton / (1 - newton * others);
    if (!isfinite(creal(move)) || !isfinite(cimag(move))) return 0;
    s->root[i] = p - move;
    return cabs(move) <= settled * cabs(p) || cabs(s->root[i]) <= s->least;
}

/* Sorts the roots. The smallest roots of neutral modes become 0, nearly real roots become real.
 * PEND_NOT_FINITE if the two sides of the real axis have different numbers of roots. */
static enum pend_status lossy_sort_out(struct pend_lossy *s) {
    int above = 0;
    assert(s->zeros >= 0 && s->zeros <= 2 * s->n);
    for (int zero = 0; zero < s->zeros; zero++) {
        int smallest = -1;
        for (int i = 0; i < 2 * s->n; i++)
            if (s->root[i] != 0 && (smallest < 0 || cabs(s->root[i]) < cabs(s->root[smallest])))
                smallest = i;
        if (smallest >= 0) s->root[smallest] = 0;
    }
    for (int i = 0; i < 2 * s->n; i++) {
        double complex *root = s->root + i;
        if (!isfinite(creal(*root)) || !isfinite(cimag(*root))) return PEND_NOT_FINITE;
        if (fabs(cimag(*root)) <= real_part * cabs(*root)) *root = creal(*root);
        above += (cimag(*root) > 0) - (cimag(*root) < 0);
    }
    return above ? PEND_NOT_FINITE : PEND_OK;
}

/* continues the rounds by some sweeps; sets `ready` once all roots have converged */
static enum pend_status lossy_go(struct pend_lossy *s, int *ready) {
    for (int sweep = 0; sweep < LOSSY_SWEEPS && !*ready; s->at++) {
        if (s->at == 2 * s->n) {
            // rounding errors keep repeated roots moving around their value
            if (s->moving < s->fewest) s->fewest = s->moving, s->patience = LOSSY_PATIENCE;
            *ready = !s->moving || !s->patience-- || s->round == LOSSY_ROUNDS;
            s->at = -1;
            s->moving = 0;
            s->round++;
            continue;
        }
        if (s->still_root[s->at]) continue;
        sweep++;
        s->still_root[s->at] = (unsigned char)lossy_move(s, s->at);
        s->moving += !s->still_root[s->at];
    }
    if (!*ready) return PEND_OK;
    s->round = -1;
    return lossy_sort_out(s);
}

/* y^T times the rows in the nodes */
static double complex lossy_product(const struct pend_lossy *s, const double complex y[]) {
    double complex sum = 0;
    for (int k = 0; k < s->n; k++) sum += y[k] * s->node[k].row;
    return sum;
}

/* the largest row of a product, relative to the row's largest term */
static double lossy_missed(const struct pend_lossy *s) {
    double most = 0, size = 0;
    for (int k = 0; k < s->n; k++) {
        most = fmax(most, cabs(s->node[k].row));
        size = fmax(size, s->node[k].size);
    }
    return size > 0 ? most / size : 0;
}

/* the initial shape of a root: that of the undamped mode, with a small change in every angle */
static void lossy_shape(struct pend_lossy *s, int i) {
    const double *mode = s->vector + (size_t)(i / 2) * (size_t)s->n;
    double most = 0;
    for (int k = 0; k < s->n; k++) most = fmax(most, fabs(mode[k]));
    for (int k = 0; k < s->n; k++)
        s->x[k] = mode[k] / most + 1e-3 * pend_rng_normal(LOSSY_SEED, (uint64_t)i, 2 + (uint32_t)k);
}

/* Improves root i and its shape. Stores the best root in *root and the best shape in x; returns
 * their residual. */
static double lossy_polish(struct pend_lossy *s, int i, double complex *root) {
    double complex p = s->root[i];
    double best = INFINITY;
    double complex *shape = s->y + s->n;
    lossy_shape(s, i);
    *root = p;
    for (int round = 0; round < LOSSY_POLISHES; round++) {
        lossy_apply(s, p, 1, s->x);
        for (int k = 0; k < s->n; k++) s->y[k] = s->node[k].row;
        // near a root the solution is large and parallel to the shape
        (void)lossy_factor(s, p);
        lossy_solve(s, s->y, s->y);
        double most = 0;
        for (int k = 0; k < s->n; k++) most = fmax(most, cabs(s->y[k]));
        if (!(most > 0) || !isfinite(most)) break;
        for (int k = 0; k < s->n; k++) s->y[k] /= most;
        lossy_apply(s, p, 1, s->y);
        double complex slope = lossy_product(s, s->y);
        lossy_apply(s, p, 0, s->y);
        double complex next = p - lossy_product(s, s->y) / slope;
        if (cimag(s->root[i]) == 0) next = creal(next);
        if (cabs(next - s->root[i]) <= moved_most * cabs(s->root[i])) p = next;
        lossy_apply(s, p, 0, s->y);
        double missed = lossy_missed(s);
        for (int k = 0; k < s->n; k++) s->x[k] = s->y[k];
        if (missed < best) {
            best = missed;
            *root = p;
            for (int k = 0; k < s->n; k++) shape[k] = s->y[k];
        } else if (best < 1e-14 * s->n) {
            break;
        }
    }
    for (int k = 0; k < s->n && best < INFINITY; k++) s->x[k] = shape[k];
    return best;
}

/* PEND_NOT_FINITE if the returned roots and their conjugates are not all of the roots */
static enum pend_status lossy_check(struct pend_lossy *s) {
    double largest = 0, smallest = INFINITY;
    for (int i = 0; i < 2 * s->n; i++) {
        double size = cabs(s->root[i]);
        largest = fmax(largest, size);
        if (size > 0) smallest = fmin(smallest, size);
    }
    for (int part = 0; part < 4 && largest > 0; part++) {
        // a point far from all roots but the few of growing modes
        double complex z = (2 + I) * smallest * pow(largest / smallest, part / 3.0);
        double complex sum = -lossy_factor(s, z);
        double size = cabs(sum);
        for (int i = 0; i < 2 * s->n; i++) {
            if (cimag(s->root[i]) < 0) continue;
            sum += 1 / (z - s->root[i]);
            size += 1 / cabs(z - s->root[i]);
            if (cimag(s->root[i]) > 0) sum += 1 / (z - conj(s->root[i]));
        }
        if (!(cabs(sum) <= sum_missed * size)) return PEND_NOT_FINITE;
    }
    return PEND_OK;
}

static enum pend_status lossy_give(struct pend_lossy *s, enum pend_lossy_stage *stage,
                                   double complex *root, double complex shape[]) {
    while (s->at < 2 * s->n && cimag(s->root[s->at]) < 0) s->at++;
    *stage = s->at < 2 * s->n ? PEND_LOSSY_MODE : PEND_LOSSY_DONE;
    if (*stage == PEND_LOSSY_DONE) return lossy_check(s);
    double missed = lossy_polish(s, s->at, root);
    s->root[s->at++] = *root;
    for (int k = 0; k < s->n; k++) shape[k] = s->x[k];
    return missed <= missed_most ? PEND_OK : PEND_NOT_FINITE;
}

PEND_VALIDATOR lossy_valid(const struct pend_lossy *s) {
    return s->n >= 1 && s->at >= 0 && s->at <= 2 * s->n && s->round >= -1 &&
           s->round <= LOSSY_ROUNDS + 1 && s->zeros <= 2 * s->n;
}

enum pend_status pend_lossy_step(struct pend_lossy *s, enum pend_lossy_stage *stage,
                                 double complex *root, double complex shape[]) {
    int ready = 0;
    assert(lossy_valid(s));
    *stage = PEND_LOSSY_UNDER_WAY;
    if (s->still) {
        if (!pend_still_step(s->still, s->square, s->vector)) return PEND_OK;
        pend_still_free(&s->still);
        lossy_guess(s);
        return PEND_OK;
    }
    return s->round < 0 ? lossy_give(s, stage, root, shape) : lossy_go(s, &ready);
}

enum pend_status pend_lossy_new(struct pend_lossy **lossy, const struct pend_tree *tree,
                                const struct pend_loads *loads, const double phi[]) {
    size_t n = (size_t)tree->n, bytes = n * (sizeof(double) + n * sizeof(double));
    struct pend_lossy *s = *lossy = calloc(1, sizeof *s);
    if (!s) return PEND_NO_MEMORY;
    s->n = tree->n;
    s->root = malloc(5 * n * sizeof *s->root);
    s->square = malloc(bytes);
    s->still_root = calloc(2 * n, 1);
    s->node = malloc(n * sizeof *s->node);
    enum pend_status status = pend_linear_arms_init(&s->arms, tree, loads, phi);
    if (status == PEND_OK) status = pend_still_new(&s->still, tree, loads, phi);
    if (status == PEND_OK && !(s->root && s->square && s->still_root && s->node))
        status = PEND_NO_MEMORY;
    if (status != PEND_OK) {
        pend_lossy_free(lossy);
        return status;
    }
    s->vector = s->square + n;
    s->x = s->root + 2 * n;
    s->y = s->root + 3 * n; // n more numbers hold the best shape
    return PEND_OK;
}

void pend_lossy_free(struct pend_lossy **lossy) {
    struct pend_lossy *s = *lossy;
    if (!s) return;
    pend_still_free(&s->still);
    pend_linear_arms_clear(&s->arms);
    free(s->root);
    free(s->square);
    free(s->still_root);
    free(s->node);
    free(s);
    *lossy = NULL;
}

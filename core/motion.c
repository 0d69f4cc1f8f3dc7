#include "core/motion.h"

#include <assert.h>
#include <limits.h>
#include <math.h>

struct motion_vector {
    double re, im;
};

/* Values of the arms that a sweep will come back to. Each lies in the sub-tree of a child of the one below it that is
 * not the largest, so the sizes of their sub-trees halve and there are at most as many as an int has bits. */
struct motion_stack {
    int count;
    struct motion_vector value[sizeof(int) * CHAR_BIT + 1];
};

static void motion_push(struct motion_stack *stack, struct motion_vector value) {
    assert(stack->count < (int)(sizeof stack->value / sizeof *stack->value));
    stack->value[stack->count++] = value;
}

/* root to leaves, before arm k: the value of its parent's tip; forgets the parent at its last child */
static struct motion_vector motion_base(const struct pend_tree *tree, int k, struct motion_stack *stack) {
    if (k == 0) return (struct motion_vector){0, 0};
    struct motion_vector base = stack->value[stack->count - 1];
    if (tree->end[k] == tree->end[tree->parent[k]]) stack->count--;
    return base;
}

/* root to leaves, after arm k: the value of its tip, kept where something hangs on it */
static struct motion_vector motion_tip(const struct pend_tree *tree, int k, struct motion_vector base,
                                       struct motion_vector arm, struct motion_stack *stack) {
    struct motion_vector tip = {base.re + arm.re, base.im + arm.im};
    if (tree->end[k] > k + 1) motion_push(stack, tip);
    return tip;
}

/* leaves to root: the sum over the children of arm k */
static struct motion_vector motion_children(const struct pend_tree *tree, int k, struct motion_stack *stack) {
    if (tree->end[k] == k + 1) return (struct motion_vector){0, 0};
    return stack->value[--stack->count];
}

/* leaves to root: adds what arm k brings to the sum of its parent, which its last child begins */
static void motion_join(const struct pend_tree *tree, int k, struct motion_vector value, struct motion_stack *stack) {
    if (k == 0) return;
    if (tree->end[k] == tree->end[tree->parent[k]]) {
        motion_push(stack, value);
    } else {
        stack->value[stack->count - 1].re += value.re;
        stack->value[stack->count - 1].im += value.im;
    }
}

/* l e^{i phi} */
static struct motion_vector motion_arm(const struct pend_tree *tree, const double phi[], int k) {
    return (struct motion_vector){tree->len[k] * cos(phi[k]), tree->len[k] * sin(phi[k])};
}

/* i phi' l e^{i phi} */
static struct motion_vector motion_turn(const struct pend_tree *tree, const double phi[], const double rate[], int k) {
    struct motion_vector arm = motion_arm(tree, phi, k);
    return (struct motion_vector){-rate[k] * arm.im, rate[k] * arm.re};
}

/* (i phi'' - phi'^2) l e^{i phi} */
static struct motion_vector motion_bend(const struct pend_tree *tree, const double phi[], const double rate[],
                                        const double acc[], int k) {
    struct motion_vector arm = motion_arm(tree, phi, k);
    double square = rate[k] * rate[k];
    return (struct motion_vector){-acc[k] * arm.im - square * arm.re, acc[k] * arm.re - square * arm.im};
}

/* writes the value of tip k: the arm's own on top of its parent's */
static void motion_write(const struct pend_tree *tree, int k, struct motion_vector arm, double re[], double im[]) {
    int p = tree->parent[k];
    re[k] = p < 0 ? arm.re : re[p] + arm.re;
    im[k] = p < 0 ? arm.im : im[p] + arm.im;
}

void pend_motion_position(const struct pend_tree *tree, const double phi[], double re[], double im[]) {
    for (int k = 0; k < tree->n; k++) motion_write(tree, k, motion_arm(tree, phi, k), re, im);
}

void pend_motion_velocity(const struct pend_tree *tree, const double phi[], const double rate[], double re[],
                          double im[]) {
    for (int k = 0; k < tree->n; k++) motion_write(tree, k, motion_turn(tree, phi, rate, k), re, im);
}

void pend_motion_acceleration(const struct pend_tree *tree, const double phi[], const double rate[], const double acc[],
                              double re[], double im[]) {
    for (int k = 0; k < tree->n; k++) motion_write(tree, k, motion_bend(tree, phi, rate, acc, k), re, im);
}

/* a sum and what its roundings lost (Neumaier) */
struct motion_sum {
    double sum, lost;
};

static void motion_add(struct motion_sum *s, double x) {
    double sum = s->sum + x;
    s->lost += fabs(s->sum) >= fabs(x) ? (s->sum - sum) + x : (x - sum) + s->sum;
    s->sum = sum;
}

struct pend_energy pend_motion_energy(const struct pend_tree *tree, double gravity, const double phi[],
                                      const double rate[]) {
    struct motion_sum kinetic = {0, 0}, moment = {0, 0};
    struct motion_stack stack = {.count = 0};
    for (int k = 0; k < tree->n; k++) {
        struct motion_vector arm = motion_arm(tree, phi, k), turn = {-rate[k] * arm.im, rate[k] * arm.re};
        struct motion_vector v = motion_tip(tree, k, motion_base(tree, k, &stack), turn, &stack);
        motion_add(&kinetic, tree->mass[k] * (v.re * v.re + v.im * v.im));
        // sum m_k Im z_k, arm by arm instead of tip by tip
        motion_add(&moment, tree->subtree_mass[k] * arm.im);
    }
    return (struct pend_energy){(kinetic.sum + kinetic.lost) / 2, gravity * (moment.sum + moment.lost)};
}

double pend_motion_energy_scale(const struct pend_tree *tree, double gravity, double kinetic) {
    double moment = 0;
    for (int k = 0; k < tree->n; k++) moment += tree->len[k] * tree->subtree_mass[k];
    return fabs(gravity) * moment + kinetic;
}

/* the part of v along arm k */
static double motion_along(const double phi[], int k, struct motion_vector v) {
    return cos(phi[k]) * v.re + sin(phi[k]) * v.im;
}

void pend_motion_force(const struct pend_tree *tree, double gravity, const double phi[], const double rate[],
                       const double acc[], double force[]) {
    struct motion_stack stack = {.count = 0};

    // leaves to root: m_p (z''_p - z'' of the base of arm k), summed over the sub-tree
    for (int k = tree->n - 1; k >= 0; k--) {
        double mass = tree->subtree_mass[k];
        struct motion_vector bend = motion_bend(tree, phi, rate, acc, k);
        struct motion_vector sum = motion_children(tree, k, &stack);
        sum.re += mass * bend.re;
        sum.im += mass * bend.im;
        force[k] = motion_along(phi, k, sum);
        motion_join(tree, k, sum, &stack);
    }

    // root to leaves: the base's own share, m_p (z'' of the base + i g)
    for (int k = 0; k < tree->n; k++) {
        struct motion_vector base = motion_base(tree, k, &stack);
        motion_tip(tree, k, base, motion_bend(tree, phi, rate, acc, k), &stack);
        base.im += gravity;
        force[k] += tree->subtree_mass[k] * motion_along(phi, k, base);
    }
}

#include "core/dynamics/kinematics.h"

#include <assert.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "core/base/isa.h"
#include "core/simd/kernel_sincos.h"
#include "core/tree/turns.h"

struct kinematics_vector {
    double re, im;
};

/* Values of arms that a sweep needs again. Each arm is in the sub-tree of a child of the arm below
 * it on the stack, but not of the largest child. So the sizes of their sub-trees at least halve
 * from one to the next, and the stack needs no more entries than an int has bits. */
struct kinematics_stack {
    int count;
    struct kinematics_vector value[sizeof(int) * CHAR_BIT + 1];
};

static void kinematics_push(struct kinematics_stack *stack, struct kinematics_vector value) {
    assert(stack->count < (int)(sizeof stack->value / sizeof *stack->value));
    stack->value[stack->count++] = value;
}

/* root to leaves, before arm k: returns the value of its parent's tip; the last child removes it
 * from the stack */
static struct kinematics_vector kinematics_base(const struct pend_tree *tree, int k,
                                                struct kinematics_stack *stack) {
    if (k == 0) return (struct kinematics_vector){0, 0};
    struct kinematics_vector base = stack->value[stack->count - 1];
    if (tree->end[k] == tree->end[tree->parent[k]]) stack->count--;
    return base;
}

/* root to leaves, after arm k: returns the value of its tip, and stores it for children */
static struct kinematics_vector kinematics_tip(const struct pend_tree *tree, int k,
                                               struct kinematics_vector base,
                                               struct kinematics_vector arm,
                                               struct kinematics_stack *stack) {
    struct kinematics_vector tip = {base.re + arm.re, base.im + arm.im};
    if (tree->end[k] > k + 1) kinematics_push(stack, tip);
    return tip;
}

/* leaves to root: adds the value of arm k to the sum of its parent; the last child, which comes
 * first, starts that sum */
static void kinematics_join(const struct pend_tree *tree, int k, struct kinematics_vector value,
                            struct kinematics_stack *stack) {
    if (k == 0) return;
    if (tree->end[k] == tree->end[tree->parent[k]]) {
        kinematics_push(stack, value);
    } else {
        stack->value[stack->count - 1].re += value.re;
        stack->value[stack->count - 1].im += value.im;
    }
}

/* e^{i phi} of the arms from `from` on, at most PEND_TURN_CAP of them */
struct kinematics_units {
    pend_sincos_fn *turn;
    int from, end;
    _Alignas(64) double re[PEND_TURN_CAP], im[PEND_TURN_CAP];
};

static void kinematics_units_begin(struct kinematics_units *units) {
    units->from = units->end = 0;
    units->turn = PEND_ISA_PICK(pend_kernel_sincos, pend_isa_best());
}

/* computes e^{i phi} of the arms from k on; n is the number of angles */
static void kinematics_units_fill(struct kinematics_units *units, int n, const double phi[],
                                  int k) {
    int count = n - k < PEND_TURN_CAP ? n - k : PEND_TURN_CAP, near = 1;
    for (int i = 0; i < count; i++) near &= fabs(phi[k + i]) <= 1e6;
    units->turn(phi + k, count, units->re, units->im);
    for (int i = 0; i < count && !near; i++) {
        // the vector kernels do not accept an angle as large as this
        if (!(fabs(phi[k + i]) <= 1e6))
            units->re[i] = cos(phi[k + i]), units->im[i] = sin(phi[k + i]);
    }
    units->from = k;
    units->end = k + count;
}

void pend_kinematics_units(int n, const double phi[], double re[], double im[]) {
    struct kinematics_units units;
    assert(n >= 1 && re != im && phi != re && phi != im);
    kinematics_units_begin(&units);
    for (int k = 0; k < n; k = units.end) {
        kinematics_units_fill(&units, n, phi, k);
        size_t bytes = (size_t)(units.end - k) * sizeof(double);
        memcpy(re + k, units.re, bytes);
        memcpy(im + k, units.im, bytes);
    }
}

/* l e^{i phi} of arm k, for arms visited in order from 0 */
static struct kinematics_vector kinematics_next(struct kinematics_units *units,
                                                const struct pend_tree *tree, const double phi[],
                                                int k) {
    if (k == units->end) kinematics_units_fill(units, tree->n, phi, k);
    double len = tree->len[k];
    return (struct kinematics_vector){len * units->re[k - units->from],
                                      len * units->im[k - units->from]};
}

/* (i phi'' - phi'^2) l e^{i phi} */
static struct kinematics_vector kinematics_bend(const struct pend_tree *tree, const double phi[],
                                                const double rate[], const double acc[], int k) {
    struct kinematics_vector arm = {tree->len[k] * cos(phi[k]), tree->len[k] * sin(phi[k])};
    double square = rate[k] * rate[k];
    return (struct kinematics_vector){-acc[k] * arm.im - square * arm.re,
                                      acc[k] * arm.re - square * arm.im};
}

/* stores the value of tip k: the arm's own value plus its parent's */
static void kinematics_write(const struct pend_tree *tree, int k, struct kinematics_vector arm,
                             double re[], double im[]) {
    int p = tree->parent[k];
    re[k] = p < 0 ? arm.re : re[p] + arm.re;
    im[k] = p < 0 ? arm.im : im[p] + arm.im;
}

void pend_kinematics_position(const struct pend_tree *tree, const double phi[], double re[],
                              double im[]) {
    assert(re != im && phi != re && phi != im);
    struct kinematics_units units;
    kinematics_units_begin(&units);
    for (int k = 0; k < tree->n; k++)
        kinematics_write(tree, k, kinematics_next(&units, tree, phi, k), re, im);
}

void pend_kinematics_velocity(const struct pend_tree *tree, const double phi[], const double rate[],
                              double re[], double im[]) {
    assert(re != im && phi != re && rate != re && phi != im && rate != im);
    struct kinematics_units units;
    kinematics_units_begin(&units);
    for (int k = 0; k < tree->n; k++) {
        struct kinematics_vector arm = kinematics_next(&units, tree, phi, k);
        kinematics_write(tree, k, (struct kinematics_vector){-rate[k] * arm.im, rate[k] * arm.re},
                         re, im);
    }
}

void pend_kinematics_acceleration(const struct pend_tree *tree, const double phi[],
                                  const double rate[], const double acc[], double re[],
                                  double im[]) {
    assert(re != im && acc != re && acc != im);
    for (int k = 0; k < tree->n; k++)
        kinematics_write(tree, k, kinematics_bend(tree, phi, rate, acc, k), re, im);
}

/* the energy of the state whose angles and rates are entries `from` to `end` - 1 */
static struct pend_energy kinematics_energy(struct kinematics_units *units,
                                            const struct pend_tree *tree,
                                            const struct pend_loads *loads, int from, int end,
                                            const double phi[], const double rate[]) {
    struct pend_sum kinetic = {0, 0}, moment = {0, 0};
    struct kinematics_stack stack;
    stack.count = 0;
    for (int k = 0; k < tree->n;) {
        if (from + k == units->end) kinematics_units_fill(units, end, phi, from + k);
        int next = units->end - from < tree->n ? units->end - from : tree->n;
        // no function call in this loop, so that all sums stay in registers
        for (; k < next; k++) {
            int i = from + k;
            double re = tree->len[k] * units->re[i - units->from],
                   im = tree->len[k] * units->im[i - units->from];
            struct kinematics_vector turn = {-rate[i] * im, rate[i] * re};
            struct kinematics_vector v =
                kinematics_tip(tree, k, kinematics_base(tree, k, &stack), turn, &stack);
            pend_sum_add(&kinetic, tree->mass[k] * (v.re * v.re + v.im * v.im));
            // sum m_k Im z_k, added up by arms instead of tips
            pend_sum_add(&moment, tree->subtree_mass[k] * im);
        }
    }
    return (struct pend_energy){(kinetic.high + kinetic.low) / 2,
                                loads->gravity * (moment.high + moment.low)};
}

void pend_kinematics_energies(const struct pend_tree *tree, const struct pend_loads *loads,
                              int count, const double phi[], const double rate[],
                              struct pend_energy energy[]) {
    assert(count >= 0 && isfinite(loads->gravity));
    struct kinematics_units units;
    kinematics_units_begin(&units);
    for (int i = 0; i < count; i++)
        energy[i] = kinematics_energy(&units, tree, loads, i * tree->n, count * tree->n, phi, rate);
}

struct pend_energy pend_kinematics_energy(const struct pend_tree *tree,
                                          const struct pend_loads *loads, const double phi[],
                                          const double rate[]) {
    struct pend_energy energy;
    pend_kinematics_energies(tree, loads, 1, phi, rate, &energy);
    return energy;
}

double pend_kinematics_energy_scale(const struct pend_tree *tree, const struct pend_loads *loads,
                                    double kinetic) {
    double moment = 0;
    for (int k = 0; k < tree->n; k++) moment += tree->len[k] * tree->subtree_mass[k];
    return fabs(loads->gravity) * moment + kinetic;
}

/* the component of v along arm k */
static double kinematics_along(const double phi[], int k, struct kinematics_vector v) {
    return cos(phi[k]) * v.re + sin(phi[k]) * v.im;
}

void pend_kinematics_force(const struct pend_tree *tree, const struct pend_loads *loads,
                           const double phi[], const double rate[], const double acc[],
                           double force[]) {
    assert(isfinite(loads->gravity));
    assert(force != phi && force != rate && force != acc);
    struct kinematics_stack stack;
    stack.count = 0;

    // leaves to root: m_p (z''_p - z'' of the base of arm k), summed over the sub-tree
    for (int k = tree->n - 1; k >= 0; k--) {
        double mass = tree->subtree_mass[k];
        struct kinematics_vector bend = kinematics_bend(tree, phi, rate, acc, k);
        struct kinematics_vector sum = {0, 0};
        if (tree->end[k] != k + 1) sum = stack.value[--stack.count];
        sum.re += mass * bend.re;
        sum.im += mass * bend.im;
        force[k] = kinematics_along(phi, k, sum);
        kinematics_join(tree, k, sum, &stack);
    }

    // root to leaves: adds the base's part, m_p (z'' of the base + i g)
    for (int k = 0; k < tree->n; k++) {
        struct kinematics_vector base = kinematics_base(tree, k, &stack);
        kinematics_tip(tree, k, base, kinematics_bend(tree, phi, rate, acc, k), &stack);
        base.im += loads->gravity;
        force[k] += tree->subtree_mass[k] * kinematics_along(phi, k, base);
    }
}

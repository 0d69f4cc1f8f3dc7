#include "core/integrate/pieces/balance.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/simd/kernel_sincos.h"

/* quantities of an arm: its direction, the acceleration and velocity of its joint, the force that
 * it exerts on the joint, and the force at its tip except that on the mass there */
struct balance_arm {
    double complex turn, acc, speed, force, tip;
    double torque;
};

size_t pend_balance_bytes(const struct pend_tree *tree) {
    return (size_t)tree->n * sizeof(struct balance_arm);
}

static double balance_get(const struct pend_loads *loads, enum pend_term_row row, int k) {
    return !loads->terms ? 0 : pend_terms_get(loads->terms, loads->value, row, k);
}

static double balance_one(const struct pend_loads *loads, enum pend_term_one one) {
    return loads->terms->one[one] < 0 ? 0 : loads->value[loads->terms->one[one]];
}

double complex pend_balance_turn(double phi) {
    _Alignas(64) double re[PEND_TURN_CAP], im[PEND_TURN_CAP];
    pend_kernel_sincos_base(&phi, 1, re, im);
    return re[0] + I * im[0];
}

double complex pend_balance_hangs(const struct pend_tree *tree, const struct pend_loads *loads,
                                  int k) {
    if (!loads->terms || !loads->terms->hung[k]) return tree->len[tree->parent[k]];
    return balance_get(loads, PEND_TERM_AT_X, k) + I * balance_get(loads, PEND_TERM_AT_Y, k);
}

double pend_balance_masses(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                           double complex *moment, double *inertia) {
    double l = tree->len[k], m = tree->mass[k], rod = balance_get(loads, PEND_TERM_ROD, k);
    double body = balance_get(loads, PEND_TERM_BODY, k);
    double complex c =
        balance_get(loads, PEND_TERM_CENTER_X, k) + I * balance_get(loads, PEND_TERM_CENTER_Y, k);
    *inertia = m * l * l + rod * l * l / 3 + body * creal(c * conj(c)) +
               balance_get(loads, PEND_TERM_INERTIA, k);
    *moment = m * l + rod * l / 2 + body * c;
    return m + rod + body;
}

/* the acceleration of a point at unit distance on an arm, relative to its joint */
static double complex balance_whirl(const struct pend_loads *loads, const struct pend_moving *s,
                                    int k) {
    double twice = 2 * balance_one(loads, PEND_TERM_DRAG_PER_MASS), w = s->rate[k];
    return I * (s->acc[k] + twice * w) - w * w;
}

/* root to leaves: directions, accelerations including gravity, and velocities */
static void balance_move(const struct pend_tree *tree, const struct pend_loads *loads,
                         const struct pend_moving *s, struct balance_arm arm[]) {
    double twice = 2 * balance_one(loads, PEND_TERM_DRAG_PER_MASS), t = s->time;
    struct at_vector v = pend_kinematics_pivot(loads, t, 1), a = pend_kinematics_pivot(loads, t, 2);
    double complex speed = v.x + I * v.y, acc = a.x + I * a.y;
    double complex rail = pend_balance_turn(balance_one(loads, PEND_TERM_RAIL));
    for (int k = 0; k < tree->n; k++) {
        struct balance_arm *own = &arm[k];
        int p = tree->parent[k];
        own->turn = pend_loads_cart(loads, k) ? rail : pend_balance_turn(s->phi[k]);
        own->speed = p < 0 ? speed : arm[p].speed;
        own->acc = p < 0 ? acc + twice * speed + I * loads->gravity : arm[p].acc;
        if (p < 0) continue;
        if (pend_loads_cart(loads, p)) {
            own->speed += rail * s->rate[p];
            own->acc += rail * (s->acc[p] + twice * s->rate[p]);
        } else {
            double complex way = pend_balance_hangs(tree, loads, k) * arm[p].turn;
            own->speed += I * s->rate[p] * way;
            own->acc += balance_whirl(loads, s, p) * way;
        }
    }
}

static double complex balance_air(const struct pend_tree *tree, const struct pend_loads *loads,
                                  const struct pend_moving *s, const struct balance_arm *own,
                                  int k) {
    if (loads->terms->row[PEND_TERM_DRAG] < 0 && loads->terms->row[PEND_TERM_DRAG_QUADRATIC] < 0)
        return 0;
    double complex v = own->speed + I * s->rate[k] * tree->len[k] * own->turn;
    double least = balance_get(loads, PEND_TERM_DRAG_SPEED, k);
    return -(balance_get(loads, PEND_TERM_DRAG, k) +
             balance_get(loads, PEND_TERM_DRAG_QUADRATIC, k) *
                 sqrt(creal(v * conj(v)) + least * least)) *
           v;
}

/* computes the force that arm k exerts on its joint, and its moment about the joint, both without
 * its children's contributions */
static void balance_own(const struct pend_tree *tree, const struct pend_loads *loads,
                        const struct pend_moving *s, struct balance_arm arm[], int k) {
    struct balance_arm *own = &arm[k];
    double complex moment, whirl = balance_whirl(loads, s, k);
    double inertia, mass = pend_balance_masses(tree, loads, k, &moment, &inertia), l = tree->len[k];
    if (pend_loads_cart(loads, k)) {
        double twice = 2 * balance_one(loads, PEND_TERM_DRAG_PER_MASS);
        own->force = mass * (own->acc + own->turn * (s->acc[k] + twice * s->rate[k]));
        own->torque = balance_get(loads, PEND_TERM_INERTIA, k) * s->acc[k];
        own->tip = 0;
        return;
    }
    double complex air = balance_air(tree, loads, s, own, k), u = own->turn;
    own->force = mass * own->acc + moment * u * whirl - air;
    own->torque = inertia * cimag(whirl) + cimag(conj(moment * u) * own->acc - conj(l * u) * air);
    own->tip = tree->mass[k] * (own->acc + l * u * whirl) - air;
}

/* the torque of springs, viscous and regularized dry friction, drives and inputs in joint k */
static double balance_given(const struct pend_tree *tree, const struct pend_loads *loads,
                            const struct pend_moving *s, int k) {
    int p = pend_terms_holder(loads->terms, tree->parent, k);
    double q = s->phi[k] - (p < 0 ? -M_PI_2 : s->phi[p]), r = s->rate[k] - (p < 0 ? 0 : s->rate[p]);
    if (pend_loads_cart(loads, k)) q = s->phi[k];
    double rise = balance_get(loads, PEND_TERM_INPUT_RATE, k),
           friction = balance_get(loads, PEND_TERM_FRICTION, k);
    double sum = balance_get(loads, PEND_TERM_TORQUE, k) + balance_get(loads, PEND_TERM_INPUT, k) +
                 rise * (s->time - balance_one(loads, PEND_TERM_PIECE));
    for (int i = 0; i < loads->terms->harmonics; i++) {
        const double *h = loads->value + loads->terms->harmonic[i].at;
        if (loads->terms->harmonic[i].drives == k) sum += h[0] * cos(h[1] * s->time + h[2]);
    }
    sum -= balance_get(loads, PEND_TERM_DAMPING, k) * r +
           balance_get(loads, PEND_TERM_STIFFNESS, k) * (q - balance_get(loads, PEND_TERM_REST, k));
    return friction > 0 ? sum - friction * tanh(r / balance_get(loads, PEND_TERM_FRICTION_SPEED, k))
                        : sum;
}

static void balance_put(const struct balance_arm *own, int cart, int k,
                        const struct bodies_forces *forces) {
    double complex joint = conj(own->turn) * own->force,
                   tip = cart ? joint : conj(own->turn) * own->tip;
    if (forces->joint_along) forces->joint_along[k] = creal(joint);
    if (forces->joint_across) forces->joint_across[k] = cimag(joint);
    if (forces->tip_along) forces->tip_along[k] = creal(tip);
    if (forces->tip_across) forces->tip_across[k] = cimag(tip);
}

void pend_balance(const struct pend_tree *tree, const struct pend_loads *loads,
                  const struct pend_moving *state, void *memory, double torque[],
                  const struct bodies_forces *forces) {
    struct balance_arm *arm = memory;
    assert(loads->terms && tree->n == loads->terms->n);
    balance_move(tree, loads, state, arm);
    for (int k = 0; k < tree->n; k++) balance_own(tree, loads, state, arm, k);
    for (int k = tree->n - 1; k >= 0; k--) {
        int p = tree->parent[k], holder = pend_terms_holder(loads->terms, tree->parent, k);
        if (pend_loads_cart(loads, k)) arm[k].torque += creal(conj(arm[k].turn) * arm[k].force);
        if (p >= 0) {
            arm[p].force += arm[k].force;
            if (!loads->terms->hung[k] || pend_loads_cart(loads, p)) arm[p].tip += arm[k].force;
            if (!pend_loads_cart(loads, p))
                arm[p].torque +=
                    cimag(conj(pend_balance_hangs(tree, loads, k) * arm[p].turn) * arm[k].force);
        }
        if (holder >= 0) arm[holder].torque += arm[k].torque;
        if (forces) balance_put(&arm[k], pend_loads_cart(loads, k), k, forces);
        if (torque) torque[k] = arm[k].torque - balance_given(tree, loads, state, k);
    }
}

#include "core/modes/linear_arms.h"

#include <assert.h>
#include <complex.h>
#include <stdlib.h>

#include "core/modes/rest.h"

/* i times a vector in the arm's frame, rotated into the fixed frame */
static void linear_lever(double complex turn, const double from[2], double to[2]) {
    double complex lever = I * turn * (from[0] + I * from[1]);
    to[0] = creal(lever);
    to[1] = cimag(lever);
}

/* e^{i phi} of an arm; the frame of a cart does not turn */
static double complex linear_turn(const struct pend_loads *loads, const double phi[], int k) {
    return !k && pend_terms_cart(loads->terms) ? 1 : cexp(I * phi[k]);
}

/* the constants of an arm without its sub-tree */
static void linear_alone(const struct pend_tree *tree, const struct pend_loads *loads,
                         const double phi[], int k, struct linear_arm *arm) {
    const struct pend_terms *terms = loads->terms;
    struct rest_body body = pend_rest_arm(tree, loads, k);
    double complex turn = linear_turn(loads, phi, k);
    double tip[2] = {tree->len[k], 0}, point[2] = {0, 0};
    // for a cart, the vector to the tip is the displacement of its point per unit of position: the
    // direction of the rail
    if (!k && pend_terms_cart(terms))
        tip[0] = body.moment[0] / body.mass, tip[1] = body.moment[1] / body.mass;
    *arm = (struct linear_arm){
        .parent = tree->parent[k],
        .holder = pend_terms_holder(terms, tree->parent, k),
        .mass = body.mass,
        .inertia = body.inertia,
        .drag = pend_rest_drag(tree, loads, k).mass,
        .span = tree->len[k] * tree->len[k],
        .spring = terms ? pend_terms_get(terms, loads->value, PEND_TERM_STIFFNESS, k) : 0,
        .damper = pend_rest_damper(loads, k)};
    linear_lever(turn, body.moment, arm->moment);
    linear_lever(turn, tip, arm->lever);
    if (k == 0) return;
    pend_rest_point(tree, loads, k, point);
    linear_lever(linear_turn(loads, phi, arm->parent), point, arm->place);
}

enum pend_status pend_linear_arms_init(struct linear_arms *arms, const struct pend_tree *tree,
                                       const struct pend_loads *loads, const double phi[]) {
    assert(pend_tree_valid(tree));
    size_t n = (size_t)tree->n;
    int drag_per_mass = loads->terms ? loads->terms->one[PEND_TERM_DRAG_PER_MASS] : -1;
    struct linear_arm *arm = malloc(n * sizeof *arm);
    struct rest_body *mass = malloc(2 * n * sizeof *mass);
    *arms = (struct linear_arms){tree->n, drag_per_mass < 0 ? 0 : loads->value[drag_per_mass], arm};
    if (!arm || !mass) {
        free(mass);
        return PEND_NO_MEMORY;
    }
    struct rest_body *drag = mass + n;
    double pull[2];
    pend_rest_pull(loads, pull);
    for (int k = 0; k < tree->n; k++) {
        linear_alone(tree, loads, phi, k, arm + k);
        mass[k] = pend_rest_arm(tree, loads, k);
        drag[k] = pend_rest_drag(tree, loads, k);
    }
    pend_rest_gather(tree, loads, mass);
    pend_rest_gather(tree, loads, drag);
    for (int k = 0; k < tree->n; k++) {
        double complex moment = mass[k].moment[0] + I * mass[k].moment[1];
        double complex turn = linear_turn(loads, phi, k);
        if (k || !pend_terms_cart(loads->terms))
            arm[k].fall = -creal(conj(pull[0] + I * pull[1]) * moment * turn);
        linear_lever(turn, mass[k].moment, arm[k].whole);
        linear_lever(turn, drag[k].moment, arm[k].wind);
        arm[k].whole_mass = mass[k].mass;
        arm[k].whole_inertia = mass[k].inertia, arm[k].wind_inertia = drag[k].inertia;
    }
    free(mass);
    return PEND_OK;
}

void pend_linear_arms_clear(struct linear_arms *arms) {
    free(arms->arm);
    arms->arm = NULL;
}

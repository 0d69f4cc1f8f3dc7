#include "core/modes/rest.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdlib.h>

enum { STEPS_MOST = 200 };
static const double angle_most = 0.5; /* rad, that a step moves an arm by at most */

/* of an arm while an equilibrium is looked for */
struct rest_node {
    struct rest_body body;
    double spring, torque; /* N m/rad; N m, constant */
    double slope, pivot;   /* the gradient, N m; the matrix's pivot, N m/rad */
};

static double rest_get(const struct pend_loads *loads, enum pend_term_row row, int k) {
    return loads->terms ? pend_terms_get(loads->terms, loads->value, row, k) : 0;
}

/* arm k is a cart */
static int rest_cart(const struct pend_loads *loads, int k) {
    return !k && pend_terms_cart(loads->terms);
}

struct rest_body pend_rest_arm(const struct pend_tree *tree, const struct pend_loads *loads,
                               int k) {
    assert(k >= 0 && k < tree->n);
    double l = tree->len[k], m = tree->mass[k], rod = rest_get(loads, PEND_TERM_ROD, k);
    double body = rest_get(loads, PEND_TERM_BODY, k), x = rest_get(loads, PEND_TERM_CENTER_X, k);
    double y = rest_get(loads, PEND_TERM_CENTER_Y, k);
    double own = rest_get(loads, PEND_TERM_INERTIA, k);
    if (rest_cart(loads, k)) {
        double rail = loads->value[loads->terms->one[PEND_TERM_RAIL]];
        return (struct rest_body){m, {m * sin(rail), -m * cos(rail)}, m};
    }
    return (struct rest_body){m + rod + body,
                              {m * l + rod * l / 2 + body * x, body * y},
                              m * l * l + rod * l * l / 3 + body * (x * x + y * y) + own};
}

struct rest_body pend_rest_drag(const struct pend_tree *tree, const struct pend_loads *loads,
                                int k) {
    assert(k >= 0 && k < tree->n);
    double l = tree->len[k], speed = rest_get(loads, PEND_TERM_DRAG_SPEED, k);
    double b =
        rest_get(loads, PEND_TERM_DRAG, k) + rest_get(loads, PEND_TERM_DRAG_QUADRATIC, k) * speed;
    return (struct rest_body){b, {b * l, 0}, b * l * l};
}

double pend_rest_damper(const struct pend_loads *loads, int k) {
    assert(k >= 0);
    double friction = rest_get(loads, PEND_TERM_FRICTION, k);
    double damper = rest_get(loads, PEND_TERM_DAMPING, k);
    // f tanh(r / s) is f r / s near 0
    return friction > 0 ? damper + friction / rest_get(loads, PEND_TERM_FRICTION_SPEED, k) : damper;
}

void pend_rest_point(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                     double point[2]) {
    assert(k > 0 && k < tree->n);
    int hung = loads->terms && loads->terms->hung[k];
    if (rest_cart(loads, tree->parent[k])) {
        double rail = loads->value[loads->terms->one[PEND_TERM_RAIL]];
        point[0] = sin(rail), point[1] = -cos(rail);
        return;
    }
    point[0] = hung ? rest_get(loads, PEND_TERM_AT_X, k) : tree->len[tree->parent[k]];
    point[1] = hung ? rest_get(loads, PEND_TERM_AT_Y, k) : 0;
}

void pend_rest_gather(const struct pend_tree *tree, const struct pend_loads *loads,
                      struct rest_body body[]) {
    assert(pend_tree_valid(tree));
    for (int k = tree->n - 1; k > 0; k--) {
        struct rest_body *parent = body + tree->parent[k];
        double point[2];
        pend_rest_point(tree, loads, k, point);
        parent->mass += body[k].mass;
        for (int i = 0; i < 2; i++) parent->moment[i] += point[i] * body[k].mass;
    }
}

void pend_rest_pull(const struct pend_loads *loads, double pull[2]) {
    const struct pend_terms *terms = loads->terms;
    int moves = terms && terms->one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0;
    pull[0] = moves ? loads->value[terms->one[PEND_TERM_PIVOT_ACCELERATION_X]] : 0;
    pull[1] = loads->gravity;
    if (moves) pull[1] += loads->value[terms->one[PEND_TERM_PIVOT_ACCELERATION_Y]];
}

/* the gradient of the potential energy, and the diagonal of its second derivative; returns the
 * gradient's largest entry over the largest of its parts */
static double rest_slopes(const struct pend_tree *tree, const struct pend_loads *loads,
                          const double phi[], struct rest_node node[]) {
    double most = 0, size = 0, pull[2];
    pend_rest_pull(loads, pull);
    for (int k = 0; k < tree->n; k++) {
        const struct rest_body *body = &node[k].body;
        double complex turn = rest_cart(loads, k) ? 1 : cexp(I * phi[k]);
        double complex part =
            conj(pull[0] + I * pull[1]) * ((body->moment[0] + I * body->moment[1]) * turn);
        node[k].slope = -cimag(part);
        node[k].pivot = node[k].spring - (rest_cart(loads, k) ? 0 : creal(part));
        size = fmax(size, hypot(pull[0], pull[1]) * hypot(body->moment[0], body->moment[1]));
    }
    for (int k = 0; k < tree->n; k++) {
        int p = pend_terms_holder(loads->terms, tree->parent, k);
        double from = p >= 0 ? phi[p] : rest_cart(loads, k) ? 0 : -M_PI_2;
        double bent = phi[k] - from - rest_get(loads, PEND_TERM_REST, k);
        double spring = node[k].spring * bent;
        node[k].slope += spring - node[k].torque;
        if (p >= 0) node[p].slope -= spring - node[k].torque;
        if (p >= 0) node[p].pivot += node[k].spring;
        size = fmax(size, fmax(fabs(spring), fabs(node[k].torque)));
    }
    for (int k = 0; k < tree->n; k++) most = fmax(most, fabs(node[k].slope));
    return size > 0 ? most / size : 0;
}

/* eliminates the arms from the leaves on, of the matrix whose only entries off the diagonal are the
 * springs'; returns true if all pivots are positive */
static int rest_eliminate(const struct pend_tree *tree, const struct pend_loads *loads,
                          struct rest_node node[]) {
    int positive = 1;
    assert(tree->parent[0] < 0);
    for (int k = tree->n - 1; k >= 0; k--) {
        struct rest_node *at = node + k;
        positive &= at->pivot > 0;
        if (at->pivot == 0) at->pivot = 0x1p-52 * (at->spring > 0 ? at->spring : 1);
        int p = pend_terms_holder(loads->terms, tree->parent, k);
        if (p < 0) continue;
        struct rest_node *parent = node + p;
        double ratio = at->spring / at->pivot;
        parent->pivot -= ratio * at->spring;
        parent->slope += ratio * at->slope;
    }
    return positive;
}

/* moves the angles by a step of Newton's method, whose factors are known; 0 if it is not finite */
static int rest_step(const struct pend_tree *tree, const struct pend_loads *loads,
                     struct rest_node node[], double phi[]) {
    double most = 0;
    for (int k = 0; k < tree->n; k++) {
        int p = pend_terms_holder(loads->terms, tree->parent, k);
        node[k].slope =
            (node[k].slope + (p < 0 ? 0 : node[k].spring * node[p].slope)) / node[k].pivot;
        if (!isfinite(node[k].slope)) return 0;
        if (!rest_cart(loads, k)) most = fmax(most, fabs(node[k].slope));
    }
    // what pulls on a cart does not depend on where anything is
    double part = most > angle_most ? angle_most / most : 1;
    for (int k = 0; k < tree->n; k++) phi[k] -= node[k].slope * (rest_cart(loads, k) ? 1 : part);
    return 1;
}

/* what the search needs of each arm; NULL if there is no memory */
static struct rest_node *rest_nodes(const struct pend_tree *tree, const struct pend_loads *loads) {
    size_t n = (size_t)tree->n;
    struct rest_node *node = malloc(n * sizeof *node);
    struct rest_body *body = malloc(n * sizeof *body);
    if (node && body) {
        for (int k = 0; k < tree->n; k++) body[k] = pend_rest_arm(tree, loads, k);
        pend_rest_gather(tree, loads, body);
        for (int k = 0; k < tree->n; k++)
            node[k] = (struct rest_node){.body = body[k],
                                         .spring = rest_get(loads, PEND_TERM_STIFFNESS, k),
                                         .torque = rest_get(loads, PEND_TERM_TORQUE, k)};
    } else {
        free(node);
        node = NULL;
    }
    free(body);
    return node;
}

enum pend_status pend_rest_find(const struct pend_tree *tree, const struct pend_loads *loads,
                                double phi[], int *stable, struct pend_error *error) {
    struct rest_node *node = rest_nodes(tree, loads);
    if (!node)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for an equilibrium of %d arms",
                         tree->n);
    int found = 0, goes = 1, positive = 0;
    for (int i = 0; i < STEPS_MOST && goes && !found; i++) {
        found = rest_slopes(tree, loads, phi, node) <= 0x1p-52 * (double)(tree->n + 4);
        positive = rest_eliminate(tree, loads, node);
        goes = found || rest_step(tree, loads, node, phi);
    }
    if (stable) *stable = positive;
    free(node);
    if (found) return PEND_OK;
    return pend_fail(error, PEND_NOT_FINITE, -1, 0,
                     "no equilibrium of the %d arms was found near this state: give another one",
                     tree->n);
}

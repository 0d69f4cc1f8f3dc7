#include "core/modes/rest.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdlib.h>

enum { STEPS_MOST = 200, FALLS_MOST = 1000, HALVINGS_MOST = 40 };
static const double angle_most = 0.5;   /* rad, the largest change of an angle in a step */
static const double least_pivot = 0.05; /* smallest elimination pivot when minimizing, relative to
                                         * its largest possible value */
static const double least_fall = 1e-4;  /* least accepted decrease, relative to the predicted one */

struct rest_node {
    struct rest_body body;
    double spring, torque; /* N m/rad; constant torque, N m */
    double slope, pivot;   /* gradient, N m; elimination pivot, N m/rad */
    double start, step;    /* rad */
};

static double rest_get(const struct pend_loads *loads, enum pend_term_row row, int k) {
    return loads->terms ? pend_terms_get(loads->terms, loads->value, row, k) : 0;
}

struct rest_body pend_rest_arm(const struct pend_tree *tree, const struct pend_loads *loads,
                               int k) {
    assert(k >= 0 && k < tree->n);
    double l = tree->len[k], m = tree->mass[k], rod = rest_get(loads, PEND_TERM_ROD, k);
    double body = rest_get(loads, PEND_TERM_BODY, k), x = rest_get(loads, PEND_TERM_CENTER_X, k);
    double y = rest_get(loads, PEND_TERM_CENTER_Y, k);
    double own = rest_get(loads, PEND_TERM_INERTIA, k);
    if (pend_loads_cart(loads, k)) {
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
    // for small r, f tanh(r / s) is f r / s
    return friction > 0 ? damper + friction / rest_get(loads, PEND_TERM_FRICTION_SPEED, k) : damper;
}

double pend_rest_beyond(const struct pend_loads *loads, int k, double rate, double speed) {
    double beyond = 0;
    assert(k >= 0 && rate >= 0 && speed >= 0);
    if (rest_get(loads, PEND_TERM_FRICTION, k) > 0)
        beyond = rate / rest_get(loads, PEND_TERM_FRICTION_SPEED, k);
    if (rest_get(loads, PEND_TERM_DRAG_QUADRATIC, k) > 0)
        beyond = fmax(beyond, speed / rest_get(loads, PEND_TERM_DRAG_SPEED, k));
    return beyond;
}

void pend_rest_point(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                     double point[2]) {
    assert(k > 0 && k < tree->n);
    int hung = loads->terms && loads->terms->hung[k];
    if (pend_loads_cart(loads, tree->parent[k])) {
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
        parent->inertia += (point[0] * point[0] + point[1] * point[1]) * body[k].mass;
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

/* the deflection of the spring of joint k, rad */
static double rest_bent(const struct pend_tree *tree, const struct pend_loads *loads,
                        const double phi[], int k) {
    int p = pend_terms_holder(loads->terms, tree->parent, k);
    double from = p >= 0 ? phi[p] : pend_loads_cart(loads, k) ? 0 : -M_PI_2;
    return phi[k] - from - rest_get(loads, PEND_TERM_REST, k);
}

/* The gradient of the potential energy, and the diagonal of its second derivative. Returns the
 * gradient's largest entry relative to the largest term, comparing forces on a cart and torques on
 * arms separately. The term of a spring counts with its angles, not their difference, because it
 * magnifies their rounding errors even if its deflection is 0. */
static double rest_slopes(const struct pend_tree *tree, const struct pend_loads *loads,
                          const double phi[], struct rest_node node[]) {
    double most[2] = {0, 0}, size[2] = {0, 0}, pull[2];
    pend_rest_pull(loads, pull);
    for (int k = 0; k < tree->n; k++) {
        const struct rest_body *body = &node[k].body;
        int cart = pend_loads_cart(loads, k);
        double complex turn = cart ? 1 : cexp(I * phi[k]);
        double complex part =
            conj(pull[0] + I * pull[1]) * ((body->moment[0] + I * body->moment[1]) * turn);
        node[k].slope = -cimag(part);
        node[k].pivot = node[k].spring - (cart ? 0 : creal(part));
        size[cart] =
            fmax(size[cart], hypot(pull[0], pull[1]) * hypot(body->moment[0], body->moment[1]));
    }
    for (int k = 0; k < tree->n; k++) {
        int p = pend_terms_holder(loads->terms, tree->parent, k), cart = pend_loads_cart(loads, k);
        double bent = rest_bent(tree, loads, phi, k), spring = node[k].spring * bent;
        double angles = fabs(phi[k]) + fabs(bent) + (p < 0 ? 0 : fabs(phi[p]));
        node[k].slope += spring - node[k].torque;
        if (p >= 0) node[p].slope -= spring - node[k].torque;
        if (p >= 0) node[p].pivot += node[k].spring;
        size[cart] = fmax(size[cart], fmax(node[k].spring * angles, fabs(node[k].torque)));
    }
    for (int k = 0; k < tree->n; k++) {
        int cart = pend_loads_cart(loads, k);
        most[cart] = fmax(most[cart], fabs(node[k].slope));
    }
    return fmax(size[0] > 0 ? most[0] / size[0] : 0, size[1] > 0 ? most[1] / size[1] : 0);
}

/* Eliminates the arms, from the leaves on, in the matrix of second derivatives, whose off-diagonal
 * entries are the springs. Returns true if all elimination pivots are positive. If `down`
 * (minimizing), replaces smaller ones by positive numbers. */
static int rest_eliminate(const struct pend_tree *tree, const struct pend_loads *loads, int down,
                          struct rest_node node[]) {
    int positive = 1;
    assert(tree->parent[0] < 0);
    for (int k = tree->n - 1; k >= 0; k--) {
        struct rest_node *at = node + k;
        positive &= at->pivot > 0;
        if (down && !pend_loads_cart(loads, k)) {
            double pull[2];
            pend_rest_pull(loads, pull);
            double most = at->spring +
                          hypot(pull[0], pull[1]) * hypot(at->body.moment[0], at->body.moment[1]);
            at->pivot = fmax(fabs(at->pivot), least_pivot * most);
        }
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

/* Computes Newton's step from the factors; returns 0 if it is not finite. `fall`: the decrease of
 * the potential energy along the step, to first order. */
static int rest_step(const struct pend_tree *tree, const struct pend_loads *loads,
                     struct rest_node node[], double *fall) {
    double most = 0;
    *fall = 0;
    for (int k = 0; k < tree->n; k++) {
        int p = pend_terms_holder(loads->terms, tree->parent, k);
        double right = node[k].slope;
        node[k].step = (right + (p < 0 ? 0 : node[k].spring * node[p].step)) / node[k].pivot;
        if (!isfinite(node[k].step)) return 0;
        // g (L D L^T)^-1 g, with the gradient g and the factors L D L^T
        *fall += right / node[k].pivot * right;
        if (!pend_loads_cart(loads, k)) most = fmax(most, fabs(node[k].step));
    }
    // a cart's step is not shortened: the force on the cart does not depend on its position
    double part = most > angle_most ? angle_most / most : 1;
    for (int k = 0; k < tree->n; k++) node[k].step *= pend_loads_cart(loads, k) ? 1 : part;
    *fall *= part;
    return 1;
}

/* the potential energy; also the sum of the sizes of its terms, which bounds its rounding error */
static double rest_height(const struct pend_tree *tree, const struct pend_loads *loads,
                          const double phi[], const struct rest_node node[], double *size) {
    double height = 0, pull[2];
    pend_rest_pull(loads, pull);
    *size = 0;
    for (int k = 0; k < tree->n; k++) {
        double complex moment = node[k].body.moment[0] + I * node[k].body.moment[1];
        double complex part = conj(pull[0] + I * pull[1]) * moment;
        double bent = rest_bent(tree, loads, phi, k);
        double fall =
            pend_loads_cart(loads, k) ? -cimag(part) * phi[k] : creal(part * cexp(I * phi[k]));
        double spring = node[k].spring / 2 * bent * bent, torque = -node[k].torque * bent;
        height += fall + spring + torque;
        *size += fabs(fall) + spring + fabs(torque);
    }
    return height;
}

/* takes a step, which `down` shortens until the potential energy decreases; 0 if it never does */
static int rest_move(const struct pend_tree *tree, const struct pend_loads *loads, int down,
                     struct rest_node node[], double phi[], double fall) {
    double size, part = 1, height = down ? rest_height(tree, loads, phi, node, &size) : 0;
    for (int k = 0; k < tree->n; k++) phi[k] -= node[k].step;
    if (!down) return 1;
    for (int i = 0; i < HALVINGS_MOST; i++) {
        double now = rest_height(tree, loads, phi, node, &size);
        if (now <= height - least_fall * part * fall + 0x1p-50 * size) return 1;
        part /= 2;
        for (int k = 0; k < tree->n; k++) phi[k] += part * node[k].step;
    }
    return 0;
}

/* searches for the equilibrium from phi; returns true if it is found */
static int rest_search(const struct pend_tree *tree, const struct pend_loads *loads, int down,
                       struct rest_node node[], double phi[], int *stable) {
    const int most = down ? FALLS_MOST : STEPS_MOST;
    int found = 0, goes = 1;
    for (int i = 0; i < most && goes && !found; i++) {
        double fall = 0;
        found = rest_slopes(tree, loads, phi, node) <= 0x1p-52 * (double)(tree->n + 4);
        *stable = rest_eliminate(tree, loads, down && !found, node);
        goes = found || (rest_step(tree, loads, node, &fall) &&
                         rest_move(tree, loads, down, node, phi, fall));
    }
    return found;
}

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

enum pend_status pend_rest_torques(const struct pend_tree *tree, const struct pend_loads *loads,
                                   const double phi[], double torque[], double size[]) {
    struct rest_node *node = rest_nodes(tree, loads);
    double pull[2];
    if (!node) return PEND_NO_MEMORY;
    (void)rest_slopes(tree, loads, phi, node);
    pend_rest_pull(loads, pull);
    for (int k = tree->n - 1; k >= 0; k--) {
        const struct rest_body *body = &node[k].body;
        int cart = pend_loads_cart(loads, k);
        double arm = cart ? body->mass : hypot(body->moment[0], body->moment[1]);
        int p = pend_terms_holder(loads->terms, tree->parent, k);
        torque[k] = node[k].slope;
        size[k] = hypot(pull[0], pull[1]) * arm + (cart ? 0 : node[k].spring);
        if (!(size[k] > 0)) size[k] = body->inertia;
        if (p >= 0) node[p].slope += torque[k];
    }
    free(node);
    return PEND_OK;
}

enum pend_status pend_rest_find(const struct pend_tree *tree, const struct pend_loads *loads,
                                double phi[], int *stable, struct pend_error *error) {
    struct rest_node *node = rest_nodes(tree, loads);
    if (!node)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for an equilibrium of %d arms",
                         tree->n);
    int positive = 0;
    for (int k = 0; k < tree->n; k++) node[k].start = phi[k];
    int found = rest_search(tree, loads, 0, node, phi, &positive);
    if (!found) {
        for (int k = 0; k < tree->n; k++) phi[k] = node[k].start;
        found = rest_search(tree, loads, 1, node, phi, &positive);
    }
    if (stable) *stable = positive;
    free(node);
    if (found) return PEND_OK;
    return pend_fail(error, PEND_NOT_FINITE, -1, 0,
                     "no equilibrium was found near this state, nor at lower energy: give another "
                     "state, or check that an equilibrium exists");
}

#include "core/dynamics/kinematics_at.h"

#include <assert.h>
#include <math.h>

#include "core/tree/rules.h"
#include "core/tree/turns.h"

/* (x + y i) times the unit vector of a direction; y is 0 unless the point lies beside the arm's
 * axis */
static struct at_vector at_turn(double x, double y, double direction) {
    if (x == 0 && y == 0) return (struct at_vector){0, 0};
    double c = cos(direction), s = sin(direction);
    return (struct at_vector){x * c - y * s, x * s + y * c};
}

struct at_vector pend_kinematics_pivot(const struct pend_loads *loads, double time, int order) {
    const struct pend_terms *terms = loads->terms;
    struct at_vector sum = {0, 0};
    int x = terms->one[PEND_TERM_PIVOT_ACCELERATION_X];
    if (x >= 0) {
        double part = order == 2 ? 1 : order ? time : time * time / 2;
        sum.x = loads->value[x] * part;
        sum.y = loads->value[terms->one[PEND_TERM_PIVOT_ACCELERATION_Y]] * part;
    }
    if (terms->one[PEND_TERM_PIVOT_TRACK] >= 0) {
        // the list describes one piece, but the instant may lie in an earlier piece
        double track[8] = {0};
        pend_rules_track(terms->rules, time, 1, track);
        sum.x += track[2 * order], sum.y += track[2 * order + 1];
    }
    for (int i = 0; i < terms->harmonics && terms->harmonic[i].drives < 0; i++) {
        const double *h = loads->value + terms->harmonic[i].at;
        double phase = h[1] * time + h[2], add = h[0] * cos(phase);
        if (order == 1) add = -h[0] * h[1] * sin(phase);
        if (order == 2) add *= -h[1] * h[1];
        if (terms->harmonic[i].drives == PEND_DRIVE_PIVOT_X)
            sum.x += add;
        else
            sum.y += add;
    }
    return sum;
}

/* the displacement x along the rail of a cart, as a vector */
static struct at_vector at_rail(const struct pend_loads *loads, double x) {
    assert(pend_terms_cart(loads->terms));
    return at_turn(x, 0, loads->value[loads->terms->one[PEND_TERM_RAIL]]);
}

/* the vector from the tip of arm k's parent to the attachment point of k, in the parent's frame */
static struct at_vector at_point(const struct pend_tree *tree, const struct pend_loads *loads,
                                 int k) {
    if (!loads->terms->hung[k]) return (struct at_vector){0, 0};
    return (struct at_vector){pend_terms_get(loads->terms, loads->value, PEND_TERM_AT_X, k) -
                                  tree->len[tree->parent[k]],
                              pend_terms_get(loads->terms, loads->value, PEND_TERM_AT_Y, k)};
}

void pend_kinematics_position_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                 double time, const double phi[], double re[], double im[]) {
    if (!loads->terms) {
        pend_kinematics_position(tree, phi, re, im);
        return;
    }
    struct at_vector pivot = pend_kinematics_pivot(loads, time, 0);
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        struct at_vector arm = at_turn(tree->len[k], 0, phi[k]), base = pivot;
        if (pend_loads_cart(loads, k)) arm = at_rail(loads, phi[k]);
        if (p >= 0) {
            struct at_vector back = at_point(tree, loads, k);
            back = at_turn(back.x, back.y, phi[p]);
            base = (struct at_vector){re[p] + back.x, im[p] + back.y};
        }
        re[k] = base.x + arm.x;
        im[k] = base.y + arm.y;
    }
}

static void at_velocities(const struct pend_tree *tree, const struct pend_loads *loads, double time,
                          const double phi[], const double rate[], double re[], double im[]) {
    struct at_vector pivot = pend_kinematics_pivot(loads, time, 1);
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        struct at_vector arm = at_turn(tree->len[k], 0, phi[k]), base = pivot;
        if (p >= 0) {
            struct at_vector back = at_point(tree, loads, k);
            back = at_turn(back.x, back.y, phi[p]);
            base = (struct at_vector){re[p] - rate[p] * back.y, im[p] + rate[p] * back.x};
        }
        if (pend_loads_cart(loads, k)) {
            base = at_rail(loads, rate[k]);
            arm = (struct at_vector){0, 0};
        }
        re[k] = base.x - rate[k] * arm.y;
        im[k] = base.y + rate[k] * arm.x;
    }
}

void pend_kinematics_velocity_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                 double time, const double phi[], const double rate[], double re[],
                                 double im[]) {
    if (loads->terms)
        at_velocities(tree, loads, time, phi, rate, re, im);
    else
        pend_kinematics_velocity(tree, phi, rate, re, im);
}

/* acceleration of a point of an arm due to the arm's rate and angular acceleration */
static struct at_vector at_bend(struct at_vector p, double rate, double acc) {
    double square = rate * rate;
    return (struct at_vector){-acc * p.y - square * p.x, acc * p.x - square * p.y};
}

void pend_kinematics_acceleration_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                     double time, const double phi[], const double rate[],
                                     const double acc[], double re[], double im[]) {
    if (!loads->terms) {
        pend_kinematics_acceleration(tree, phi, rate, acc, re, im);
        return;
    }
    struct at_vector pivot = pend_kinematics_pivot(loads, time, 2);
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        struct at_vector arm = at_bend(at_turn(tree->len[k], 0, phi[k]), rate[k], acc[k]);
        struct at_vector base = pivot;
        if (pend_loads_cart(loads, k)) arm = at_rail(loads, acc[k]);
        if (p >= 0) {
            struct at_vector back = at_point(tree, loads, k);
            back = at_bend(at_turn(back.x, back.y, phi[p]), rate[p], acc[p]);
            base = (struct at_vector){re[p] + back.x, im[p] + back.y};
        }
        re[k] = base.x + arm.x;
        im[k] = base.y + arm.y;
    }
}

/* largest number of point masses and bodies of which an arm consists */
enum { AT_POINTS = 3 };
struct at_mass {
    double mass, inertia;
    struct at_vector at;
};

/* fills in the masses of an arm; returns their number */
static int at_masses(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                     struct at_mass mass[]) {
    const struct pend_terms *terms = loads->terms;
    const double *value = loads->value;
    double l = tree->len[k];
    int count = 1;
    mass[0] = (struct at_mass){tree->mass[k], 0, {l, 0}};
    if (terms->row[PEND_TERM_ROD] >= 0) {
        double rod = pend_terms_get(terms, value, PEND_TERM_ROD, k);
        mass[count++] = (struct at_mass){rod, rod * l * l / 12, {l / 2, 0}};
    }
    if (terms->row[PEND_TERM_BODY] >= 0)
        mass[count++] = (struct at_mass){pend_terms_get(terms, value, PEND_TERM_BODY, k),
                                         pend_terms_get(terms, value, PEND_TERM_INERTIA, k),
                                         {pend_terms_get(terms, value, PEND_TERM_CENTER_X, k),
                                          pend_terms_get(terms, value, PEND_TERM_CENTER_Y, k)}};
    return count;
}

/* the energy of the spring of a joint */
static double at_spring(const struct pend_tree *tree, const struct pend_loads *loads,
                        const double phi[], int k) {
    double stiff = pend_terms_get(loads->terms, loads->value, PEND_TERM_STIFFNESS, k);
    int p = pend_terms_holder(loads->terms, tree->parent, k);
    double bent = p < 0 ? phi[k] + M_PI_2 : phi[k] - phi[p];
    if (pend_loads_cart(loads, k)) bent = phi[k];
    bent -= pend_terms_get(loads->terms, loads->value, PEND_TERM_REST, k);
    return stiff * bent * bent / 2;
}

/* unit vectors of the arms, and velocities or heights of their joints; rows of n numbers */
struct at_state {
    const double *rate;
    const double *cosine, *sine;
    double *x, *y;
};

/* attachment point of arm k > 0 relative to its parent's joint, in fixed axes; an arm on a cart is
 * attached at the cart's position */
static struct at_vector at_hang(const struct pend_tree *tree, const struct pend_loads *loads,
                                const struct at_state *state, int k) {
    int p = tree->parent[k];
    double x = tree->len[p], y = 0, c = state->cosine[p], s = state->sine[p];
    if (pend_loads_cart(loads, p)) return (struct at_vector){0, 0};
    if (loads->terms->hung[k]) {
        x = pend_terms_get(loads->terms, loads->value, PEND_TERM_AT_X, k);
        y = pend_terms_get(loads->terms, loads->value, PEND_TERM_AT_Y, k);
    }
    return (struct at_vector){x * c - y * s, x * s + y * c};
}

/* computes the velocities of the joints, and returns the kinetic energy */
static double at_kinetic(const struct pend_tree *tree, const struct pend_loads *loads,
                         struct at_vector pivot, const struct at_state *state) {
    struct pend_sum kinetic = {0, 0};
    struct at_mass mass[AT_POINTS];
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k], cart = pend_loads_cart(loads, k);
        struct at_vector base = p < 0 ? pivot : at_hang(tree, loads, state, k);
        double turning = cart ? 0 : state->rate[k], sum = 0;
        if (cart) base = at_rail(loads, state->rate[0]);
        if (p >= 0) {
            double w = state->rate[p];
            base = (struct at_vector){state->x[p] - w * base.y, state->y[p] + w * base.x};
        }
        int points = at_masses(tree, loads, k, mass);
        for (int i = 0; i < points; i++) {
            double x = mass[i].at.x, y = mass[i].at.y, c = state->cosine[k], s = state->sine[k];
            double vx = base.x - turning * (x * s + y * c);
            double vy = base.y + turning * (x * c - y * s);
            sum += mass[i].mass * (vx * vx + vy * vy);
            sum += mass[i].inertia * (turning * turning);
        }
        pend_sum_add(&kinetic, sum);
        state->x[k] = base.x, state->y[k] = base.y;
    }
    return (kinetic.high + kinetic.low) / 2;
}

/* computes the heights of the joints, and returns the potential energy */
static double at_potential(const struct pend_tree *tree, const struct pend_loads *loads,
                           double pivot, const double phi[], const struct at_state *state) {
    struct pend_sum potential = {0, 0};
    struct at_mass mass[AT_POINTS];
    double *height = state->y;
    int springs = loads->terms->row[PEND_TERM_STIFFNESS] >= 0;
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k], cart = pend_loads_cart(loads, k);
        double base = p < 0 ? pivot : height[p] + at_hang(tree, loads, state, k).y;
        if (cart) base = at_rail(loads, phi[0]).y;
        int points = at_masses(tree, loads, k, mass);
        for (int i = 0; i < points; i++) {
            double up = cart ? 0 : mass[i].at.x * state->sine[k] + mass[i].at.y * state->cosine[k];
            pend_sum_add(&potential, loads->gravity * mass[i].mass * (base + up));
        }
        height[k] = base;
        if (springs) pend_sum_add(&potential, at_spring(tree, loads, phi, k));
    }
    return potential.high + potential.low;
}

void pend_kinematics_energies_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                 int count, const double time[], const double phi[],
                                 const double rate[], double scratch[],
                                 struct pend_energy energy[]) {
    if (!loads->terms) {
        pend_kinematics_energies(tree, loads, count, phi, rate, energy);
        return;
    }
    assert(scratch && count >= 1);
    size_t n = (size_t)tree->n, rows = n * (size_t)count;
    double *cosine = scratch, *sine = scratch + rows, *x = sine + rows, *y = x + n;
    pend_kinematics_units((int)rows, phi, cosine, sine);
    for (int i = 0; i < count; i++) {
        const struct at_state state = {rate, cosine, sine, x, y};
        struct at_vector place = pend_kinematics_pivot(loads, time[i], 0),
                         speed = pend_kinematics_pivot(loads, time[i], 1);
        energy[i].kinetic = at_kinetic(tree, loads, speed, &state);
        energy[i].potential = at_potential(tree, loads, place.y, phi, &state);
        phi += n, rate += n, cosine += n, sine += n;
    }
}

struct pend_energy pend_kinematics_energy_at(const struct pend_tree *tree,
                                             const struct pend_loads *loads, double time,
                                             const double phi[], const double rate[],
                                             double scratch[]) {
    if (!loads->terms) return pend_kinematics_energy(tree, loads, phi, rate);
    struct pend_energy energy;
    pend_kinematics_energies_at(tree, loads, 1, &time, phi, rate, scratch, &energy);
    return energy;
}

double pend_kinematics_energy_scale_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                       double kinetic) {
    if (!loads->terms) return pend_kinematics_energy_scale(tree, loads, kinetic);
    double total = 0, reach = 0, springs = 0;
    for (int k = 0; k < tree->n; k++) {
        struct at_mass mass[AT_POINTS];
        int points = at_masses(tree, loads, k, mass);
        for (int i = 0; i < points; i++) total += mass[i].mass;
        reach = fmax(reach, tree->depth[k] * tree->len[k]);
        springs += pend_terms_get(loads->terms, loads->value, PEND_TERM_STIFFNESS, k) / 2;
    }
    return fabs(loads->gravity) * total * reach + springs + kinetic;
}

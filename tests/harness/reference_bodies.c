#include "tests/harness/reference_bodies.h"

#include <complex.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 3 };

/* a mass on an arm, at p in the arm's frame, with an inertia of its own */
struct reference_point {
    double mass, inertia;
    double complex at;
};

struct reference_bodies {
    const struct pend_tree *tree;
    const struct pend_loads *loads;
    const struct bodies_state *state;
    double complex *turn;   /* n: e^{i phi} */
    double complex *moves;  /* n x n: the derivative of joint k's place by phi_j */
    double complex *bend;   /* n: acceleration of joint k without phi'' */
    double complex *speed;  /* n: velocity of joint k */
    double complex *acc;    /* n: acceleration of joint k */
    double complex *force;  /* n: the force that the base exerts at joint k */
    double complex *tip;    /* n */
    double *matrix, *right; /* n x n; n */
};

static double bodies_number(const struct reference_bodies *b, enum pend_term_row row, int k) {
    return pend_terms_get(b->loads->terms, b->loads->value, row, k);
}

static double bodies_whole(const struct reference_bodies *b, enum pend_term_one one) {
    int at = b->loads->terms->one[one];
    return at < 0 ? 0 : b->loads->value[at];
}

static void bodies_points(const struct reference_bodies *b, int k, struct reference_point point[]) {
    double l = b->tree->len[k], rod = bodies_number(b, PEND_TERM_ROD, k);
    point[0] = (struct reference_point){b->tree->mass[k], 0, l};
    point[1] = (struct reference_point){rod, rod * l * l / 12, l / 2};
    point[2] = (struct reference_point){
        bodies_number(b, PEND_TERM_BODY, k), bodies_number(b, PEND_TERM_INERTIA, k),
        bodies_number(b, PEND_TERM_CENTER_X, k) + I * bodies_number(b, PEND_TERM_CENTER_Y, k)};
}

static double complex bodies_hangs_at(const struct reference_bodies *b, int k) {
    if (!b->loads->terms->hung[k]) return b->tree->len[b->tree->parent[k]];
    return bodies_number(b, PEND_TERM_AT_X, k) + I * bodies_number(b, PEND_TERM_AT_Y, k);
}

/* arm k is a cart: a point that moves along its rail */
static int bodies_cart(const struct reference_bodies *b, int k) {
    return !k && b->loads->terms->one[PEND_TERM_RAIL] >= 0;
}

static double complex bodies_rail(const struct reference_bodies *b) {
    return cexp(I * bodies_whole(b, PEND_TERM_RAIL));
}

/* the sum of the harmonics that drive something, differentiated `times` times */
static double bodies_driven(const struct reference_bodies *b, int drives, int times) {
    const struct pend_terms *terms = b->loads->terms;
    double sum = 0, time = b->state->time + b->state->late;
    for (int i = 0; i < terms->harmonics; i++) {
        const double *h = b->loads->value + terms->harmonic[i].at;
        if (terms->harmonic[i].drives == drives)
            sum += h[0] * pow(h[1], times) * cos(h[1] * time + h[2] + times * M_PI_2);
    }
    return sum;
}

/* torque of the joint of arm k on it */
static double bodies_torque(const struct reference_bodies *b, int k) {
    int p = b->tree->parent[k];
    if (p >= 0 && bodies_cart(b, p)) p = -1;
    double q = b->state->phi[k] - (p < 0 ? -M_PI_2 : b->state->phi[p]);
    if (bodies_cart(b, k)) q = b->state->phi[k];
    double r = b->state->rate[k] - (p < 0 ? 0 : b->state->rate[p]);
    double since = b->state->time + b->state->late - bodies_whole(b, PEND_TERM_PIECE);
    double torque = bodies_number(b, PEND_TERM_TORQUE, k) + bodies_driven(b, k, 0);
    torque += bodies_number(b, PEND_TERM_INPUT, k) + bodies_number(b, PEND_TERM_SLIDE, k);
    torque += bodies_number(b, PEND_TERM_INPUT_RATE, k) * since;
    torque -= bodies_number(b, PEND_TERM_DAMPING, k) * r;
    torque -= bodies_number(b, PEND_TERM_STIFFNESS, k) * (q - bodies_number(b, PEND_TERM_REST, k));
    double friction = bodies_number(b, PEND_TERM_FRICTION, k);
    if (friction > 0) torque -= friction * tanh(r / bodies_number(b, PEND_TERM_FRICTION_SPEED, k));
    return torque;
}

/* the air's force on the tip */
static double complex bodies_air(const struct reference_bodies *b, int k) {
    double complex v = b->speed[k] + I * b->tree->len[k] * b->turn[k] * b->state->rate[k];
    double e = bodies_number(b, PEND_TERM_DRAG_SPEED, k);
    double quadratic = bodies_number(b, PEND_TERM_DRAG_QUADRATIC, k);
    return -(bodies_number(b, PEND_TERM_DRAG, k) + quadratic * hypot(cabs(v), e)) * v;
}

/* places, velocities and accelerations of the joints, as far as they are known */
static void bodies_joints(const struct reference_bodies *b) {
    size_t n = (size_t)b->tree->n;
    double time = b->state->time + b->state->late;
    double complex jerk = bodies_whole(b, PEND_TERM_PIVOT_ACCELERATION_X) +
                          I * bodies_whole(b, PEND_TERM_PIVOT_ACCELERATION_Y);
    for (size_t k = 0; k < n; k++) b->turn[k] = cexp(I * b->state->phi[k]);
    b->speed[0] = bodies_driven(b, PEND_DRIVE_PIVOT_X, 1) +
                  I * bodies_driven(b, PEND_DRIVE_PIVOT_Y, 1) + jerk * time;
    b->bend[0] = bodies_driven(b, PEND_DRIVE_PIVOT_X, 2) +
                 I * bodies_driven(b, PEND_DRIVE_PIVOT_Y, 2) + jerk;
    for (size_t k = 1; k < n; k++) {
        size_t p = (size_t)b->tree->parent[k];
        double w = b->state->rate[p];
        double complex place = bodies_hangs_at(b, (int)k) * b->turn[p];
        memcpy(b->moves + k * n, b->moves + p * n, n * sizeof *b->moves);
        if (bodies_cart(b, (int)p)) {
            b->moves[k * n] = bodies_rail(b);
            b->speed[k] = bodies_rail(b) * w;
            b->bend[k] = 0;
            continue;
        }
        b->moves[k * n + p] += I * place;
        b->speed[k] = b->speed[p] + I * place * w;
        b->bend[k] = b->bend[p] - place * w * w;
    }
}

/* adds a point to the equations */
static void bodies_add(const struct reference_bodies *b, size_t k,
                       const struct reference_point *point, double complex extra) {
    size_t n = (size_t)b->tree->n;
    double gamma = bodies_whole(b, PEND_TERM_DRAG_PER_MASS), w = b->state->rate[k];
    double complex place = point->at * b->turn[k];
    double complex v = b->speed[k] + I * place * w;
    double complex known = b->bend[k] - place * w * w + I * b->loads->gravity + 2 * gamma * v;
    double complex force = extra - point->mass * known;
    for (size_t i = 0; i < n; i++) {
        double complex move = b->moves[k * n + i] + (i == k ? I * place : 0);
        b->right[i] += creal(conj(move) * force);
        for (size_t j = 0; j < n; j++) {
            double complex other = b->moves[k * n + j] + (j == k ? I * place : 0);
            b->matrix[i * n + j] += point->mass * creal(conj(move) * other);
        }
    }
    b->matrix[k * n + k] += point->inertia;
    b->right[k] -= 2 * gamma * point->inertia * w;
}

/* adds the mass of a cart, with what drag_per_mass does to it */
static void bodies_add_cart(const struct reference_bodies *b) {
    double gamma = bodies_whole(b, PEND_TERM_DRAG_PER_MASS), mass = b->tree->mass[0];
    double complex known = I * b->loads->gravity + 2 * gamma * bodies_rail(b) * b->state->rate[0];
    b->matrix[0] += mass;
    b->right[0] -= mass * creal(conj(bodies_rail(b)) * known);
}

static void bodies_equations(const struct reference_bodies *b) {
    size_t n = (size_t)b->tree->n;
    for (size_t k = 0; k < n; k++) {
        struct reference_point point[POINTS];
        int p = b->tree->parent[k];
        double torque = bodies_torque(b, (int)k);
        b->right[k] += torque;
        if (p >= 0 && !bodies_cart(b, p)) b->right[p] -= torque;
        if (bodies_cart(b, (int)k)) {
            bodies_add_cart(b);
            continue;
        }
        bodies_points(b, (int)k, point);
        for (int i = 0; i < POINTS; i++) bodies_add(b, k, &point[i], i ? 0 : bodies_air(b, (int)k));
    }
}

/* forces at joints and tips from the accelerations */
static void bodies_newton(const struct reference_bodies *b, const double acc[]) {
    size_t n = (size_t)b->tree->n;
    double gamma = bodies_whole(b, PEND_TERM_DRAG_PER_MASS);
    for (size_t k = 0; k < n; k++) {
        b->acc[k] = b->bend[k];
        for (size_t j = 0; j < n; j++) b->acc[k] += b->moves[k * n + j] * acc[j];
        b->force[k] = b->tip[k] = 0;
    }
    if (bodies_cart(b, 0))
        b->force[0] =
            b->tree->mass[0] *
            (I * b->loads->gravity + bodies_rail(b) * (acc[0] + 2 * gamma * b->state->rate[0]));
    for (size_t k = n; k-- > 0;) {
        struct reference_point point[POINTS];
        if (bodies_cart(b, (int)k)) break;
        double w = b->state->rate[k];
        bodies_points(b, (int)k, point);
        for (int i = 0; i < POINTS; i++) {
            double complex place = point[i].at * b->turn[k];
            double complex z = b->acc[k] + (I * acc[k] - w * w) * place;
            double complex v = b->speed[k] + I * place * w;
            double complex f = point[i].mass * (z + I * b->loads->gravity + 2 * gamma * v) -
                               (i ? 0 : bodies_air(b, (int)k));
            b->force[k] += f;
            if (!i) b->tip[k] += f;
        }
        int p = b->tree->parent[k];
        if (p < 0) continue;
        b->force[p] += b->force[k];
        if (!b->loads->terms->hung[k]) b->tip[p] += b->force[k];
    }
}

static void bodies_hand_out(const struct reference_bodies *b, const struct bodies_forces *forces) {
    if (bodies_cart(b, 0)) {
        b->turn[0] = bodies_rail(b);
        b->tip[0] = b->force[0];
    }
    for (int k = 0; k < b->tree->n; k++) {
        double complex joint = conj(b->turn[k]) * b->force[k], tip = conj(b->turn[k]) * b->tip[k];
        if (forces->joint_along) forces->joint_along[k] = creal(joint);
        if (forces->joint_across) forces->joint_across[k] = cimag(joint);
        if (forces->tip_along) forces->tip_along[k] = creal(tip);
        if (forces->tip_across) forces->tip_across[k] = cimag(tip);
    }
}

enum pend_status pend_reference_bodies(const struct pend_tree *tree, const struct pend_loads *loads,
                                       const struct bodies_state *state, double acc[],
                                       const struct bodies_forces *forces) {
    size_t n = (size_t)tree->n;
    double complex *block = calloc(2 * n * n + 7 * n, sizeof *block);
    if (!block) return PEND_NO_MEMORY;
    struct reference_bodies b = {.tree = tree, .loads = loads, .state = state};
    double complex **row[] = {&b.turn, &b.bend, &b.speed, &b.acc, &b.force, &b.tip};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) *row[i] = block + i * n;
    b.right = (double *)(block + 6 * n);
    b.moves = block + 7 * n;
    b.matrix = (double *)(b.moves + n * n);
    bodies_joints(&b);
    bodies_equations(&b);
    gsl_matrix_view matrix = gsl_matrix_view_array(b.matrix, n, n);
    gsl_vector_view right = gsl_vector_view_array(b.right, n), out = gsl_vector_view_array(acc, n);
    enum pend_status status = PEND_OK;
    if (gsl_linalg_cholesky_decomp1(&matrix.matrix) ||
        gsl_linalg_cholesky_solve(&matrix.matrix, &right.vector, &out.vector))
        status = PEND_NOT_FINITE;
    if (status == PEND_OK && forces) {
        bodies_newton(&b, acc);
        bodies_hand_out(&b, forces);
    }
    free(block);
    return status;
}

#include "tests/harness/quad_bodies.h"

#include <stdlib.h>
#include <string.h>

enum { COLUMNS = 10 };

struct pair {
    test_quad x, y;
};

static struct pair pair_of(test_quad x, test_quad y) { return (struct pair){x, y}; }

static struct pair pair_add(struct pair a, struct pair b) { return pair_of(a.x + b.x, a.y + b.y); }

static struct pair pair_scale(test_quad s, struct pair a) { return pair_of(s * a.x, s * a.y); }

static struct pair pair_turn(struct pair a, struct pair b) {
    return pair_of(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

/* i a */
static struct pair pair_left(struct pair a) { return pair_of(-a.y, a.x); }

static test_quad pair_dot(struct pair a, struct pair b) { return a.x * b.x + a.y * b.y; }

/* An arm: its properties, and its motion without phi''. */
struct quad_arm {
    test_quad mass, inertia; /* M, J about the joint */
    struct pair moment;      /* h u */
    struct pair turn, hangs; /* u; the arm's joint relative to its parent's joint */
    struct pair speed, rest; /* velocity of the joint, and its acceleration without phi'' */
    struct pair air;         /* the force of the air on the tip */
    test_quad torque;        /* all torques on the arm */
    struct pair joint, tip;  /* forces, in the axes */
};

struct quad_pendulum {
    const struct pend_tree *tree;
    const struct pend_loads *loads;
    const struct test_quad_state *state;
    struct quad_arm *arm;
    struct pair *moves; /* n x n: the derivative of joint k's position with respect to phi_j */
};

static test_quad quad_term(const struct quad_pendulum *q, enum pend_term_row row, int k) {
    return pend_terms_get(q->loads->terms, q->loads->value, row, k);
}

static test_quad quad_one(const struct quad_pendulum *q, enum pend_term_one one) {
    int at = q->loads->terms->one[one];
    return at < 0 ? 0 : q->loads->value[at];
}

/* arm k is a cart, which moves along r and does not turn */
static int quad_cart(const struct quad_pendulum *q, int k) {
    return !k && q->loads->terms->one[PEND_TERM_RAIL] >= 0;
}

static struct pair quad_rail(const struct quad_pendulum *q) {
    test_quad angle = quad_one(q, PEND_TERM_RAIL);
    return pair_of(test_quad_cos(angle), test_quad_sin(angle));
}

/* the drive of a coordinate or an arm, differentiated at most twice */
static test_quad quad_driven(const struct quad_pendulum *q, int drives, int times) {
    test_quad sum = 0;
    for (int i = 0; i < q->loads->terms->harmonics; i++) {
        const struct pend_harmonic *h = &q->loads->terms->harmonic[i];
        if (h->drives != drives) continue;
        test_quad size = q->loads->value[h->at], w = q->loads->value[h->at + 1];
        test_quad angle = w * q->state->time + q->loads->value[h->at + 2];
        if (times == 0) sum += size * test_quad_cos(angle);
        if (times == 1) sum -= size * w * test_quad_sin(angle);
        if (times == 2) sum -= size * w * w * test_quad_cos(angle);
    }
    return sum;
}

static struct pair quad_pivot(const struct quad_pendulum *q, int times) {
    struct pair push = pair_of(quad_one(q, PEND_TERM_PIVOT_ACCELERATION_X),
                               quad_one(q, PEND_TERM_PIVOT_ACCELERATION_Y));
    struct pair wave = pair_of(quad_driven(q, PEND_DRIVE_PIVOT_X, times),
                               quad_driven(q, PEND_DRIVE_PIVOT_Y, times));
    return pair_add(wave, pair_scale(times == 1 ? q->state->time : 1, push));
}

/* mass, moment and inertia of arm k */
static void quad_body(const struct quad_pendulum *q, int k) {
    struct quad_arm *a = &q->arm[k];
    test_quad l = q->tree->len[k], tip = q->tree->mass[k], rod = quad_term(q, PEND_TERM_ROD, k),
              body = quad_term(q, PEND_TERM_BODY, k);
    struct pair center =
        pair_of(quad_term(q, PEND_TERM_CENTER_X, k), quad_term(q, PEND_TERM_CENTER_Y, k));
    struct pair moment = pair_of(tip * l + rod * l / 2 + body * center.x, body * center.y);
    a->turn = pair_of(test_quad_cos(q->state->phi[k]), test_quad_sin(q->state->phi[k]));
    if (quad_cart(q, k)) a->turn = quad_rail(q);
    a->mass = tip + rod + body;
    a->moment = pair_turn(moment, a->turn);
    a->inertia = tip * l * l + rod * l * l / 3 + quad_term(q, PEND_TERM_INERTIA, k) +
                 body * pair_dot(center, center);
}

/* the attachment point of arm k, and the motion of its joint */
static void quad_joint(const struct quad_pendulum *q, int k) {
    struct quad_arm *a = &q->arm[k];
    size_t n = (size_t)q->tree->n, row = (size_t)k * n;
    int p = q->tree->parent[k];
    if (p < 0) {
        a->speed = quad_pivot(q, 1), a->rest = quad_pivot(q, 2);
        return;
    }
    struct pair at = pair_of(q->tree->len[p], 0);
    test_quad w = q->state->rate[p];
    if (q->loads->terms->hung[k])
        at = pair_of(quad_term(q, PEND_TERM_AT_X, k), quad_term(q, PEND_TERM_AT_Y, k));
    a->hangs = pair_turn(at, q->arm[p].turn);
    memcpy(q->moves + row, q->moves + (size_t)p * n, n * sizeof *q->moves);
    if (quad_cart(q, p)) {
        q->moves[row] = quad_rail(q);
        a->speed = pair_scale(w, quad_rail(q));
        return;
    }
    q->moves[row + (size_t)p] = pair_left(a->hangs);
    a->speed = pair_add(q->arm[p].speed, pair_scale(w, pair_left(a->hangs)));
    a->rest = pair_add(q->arm[p].rest, pair_scale(-w * w, a->hangs));
}

/* the torque of the joint of arm k on the arm */
static test_quad quad_torque(const struct quad_pendulum *q, int k) {
    int p = q->tree->parent[k];
    const test_quad quarter = test_quad_read("1.57079632679489661923132169163975144");
    if (p >= 0 && quad_cart(q, p)) p = -1;
    test_quad bend = q->state->phi[k] - (p < 0 ? -quarter : q->state->phi[p]);
    if (quad_cart(q, k)) bend = q->state->phi[k];
    test_quad swing = q->state->rate[k] - (p < 0 ? 0 : q->state->rate[p]);
    test_quad sum = quad_term(q, PEND_TERM_TORQUE, k) + quad_driven(q, k, 0);
    test_quad friction = quad_term(q, PEND_TERM_FRICTION, k);
    sum += quad_term(q, PEND_TERM_INPUT, k) + quad_term(q, PEND_TERM_SLIDE, k);
    sum += quad_term(q, PEND_TERM_INPUT_RATE, k) * (q->state->time - quad_one(q, PEND_TERM_PIECE));
    sum -= quad_term(q, PEND_TERM_DAMPING, k) * swing;
    sum -= quad_term(q, PEND_TERM_STIFFNESS, k) * (bend - quad_term(q, PEND_TERM_REST, k));
    if (friction > 0)
        sum -= friction * test_quad_tanh(swing / quad_term(q, PEND_TERM_FRICTION_SPEED, k));
    return sum;
}

/* the force of the air on the tip of arm k */
static struct pair quad_air(const struct quad_pendulum *q, int k) {
    struct pair reach = pair_scale(q->tree->len[k], q->arm[k].turn);
    struct pair v = pair_add(q->arm[k].speed, pair_scale(q->state->rate[k], pair_left(reach)));
    test_quad e = quad_term(q, PEND_TERM_DRAG_SPEED, k);
    test_quad size = test_quad_sqrt(pair_dot(v, v) + e * e);
    test_quad drag = quad_term(q, PEND_TERM_DRAG, k);
    return pair_scale(-drag - quad_term(q, PEND_TERM_DRAG_QUADRATIC, k) * size, v);
}

/* Lagrange's equations: the contribution of arm k to the mass matrix and to the right-hand side */
static void quad_add(const struct quad_pendulum *q, int k, test_quad matrix[], test_quad right[]) {
    const struct quad_arm *a = &q->arm[k];
    size_t n = (size_t)q->tree->n, own = (size_t)k;
    if (quad_cart(q, k)) {
        struct pair weight = pair_scale(a->mass, pair_of(0, q->loads->gravity));
        matrix[0] += a->mass;
        right[0] += a->torque - pair_dot(a->turn, weight);
        right[0] -= 2 * quad_one(q, PEND_TERM_DRAG_PER_MASS) * a->mass * q->state->rate[0];
        return;
    }
    const struct pair *moves = q->moves + own * n;
    test_quad w = q->state->rate[k], twice = 2 * quad_one(q, PEND_TERM_DRAG_PER_MASS);
    struct pair spin = pair_left(a->moment), lift = pair_of(0, q->loads->gravity);
    // the terms of the joint's acceleration without phi'', and of drag_per_mass
    struct pair known = pair_add(pair_add(a->rest, lift), pair_scale(twice, a->speed));
    struct pair force = pair_add(pair_scale(a->mass, known), pair_scale(-w * w, a->moment));
    force = pair_add(force, pair_scale(twice * w, spin));
    force = pair_add(force, pair_scale(-1, a->air));
    struct pair reach = pair_left(pair_scale(q->tree->len[k], a->turn));
    for (size_t i = 0; i < n; i++) {
        right[i] -= pair_dot(moves[i], force);
        for (size_t j = 0; j < n; j++) matrix[i * n + j] += a->mass * pair_dot(moves[i], moves[j]);
        test_quad mixed = pair_dot(moves[i], spin);
        matrix[i * n + own] += mixed, matrix[own * n + i] += mixed;
    }
    matrix[own * n + own] += a->inertia;
    right[own] += a->torque - pair_dot(spin, known) - twice * a->inertia * w;
    right[own] += pair_dot(reach, a->air);
}

/* the force at each joint is the rate of change of all momentum beyond it */
static void quad_newton(const struct quad_pendulum *q, const test_quad acc[]) {
    size_t n = (size_t)q->tree->n;
    test_quad twice = 2 * quad_one(q, PEND_TERM_DRAG_PER_MASS);
    struct pair lift = pair_of(0, q->loads->gravity);
    for (size_t k = 0; k < n; k++) {
        struct quad_arm *a = &q->arm[k];
        test_quad w = q->state->rate[k];
        if (quad_cart(q, (int)k)) {
            struct pair push = pair_scale(acc[0] + twice * w, a->turn);
            a->joint = pair_scale(a->mass, pair_add(push, lift));
            continue;
        }
        struct pair known = pair_add(pair_add(a->rest, lift), pair_scale(twice, a->speed));
        for (size_t j = 0; j < n; j++)
            known = pair_add(known, pair_scale(acc[j], q->moves[k * n + j]));
        struct pair turning = pair_of(-w * w, acc[k] + twice * w);
        struct pair reach = pair_scale(q->tree->len[k], a->turn), drag = pair_scale(-1, a->air);
        a->joint = pair_add(pair_scale(a->mass, known), pair_turn(turning, a->moment));
        a->joint = pair_add(a->joint, drag);
        a->tip = pair_scale(q->tree->mass[k], pair_add(known, pair_turn(turning, reach)));
        a->tip = pair_add(a->tip, drag);
    }
    for (size_t k = n; k-- > 1;) {
        struct quad_arm *up = &q->arm[q->tree->parent[k]];
        up->joint = pair_add(up->joint, q->arm[k].joint);
        if (!q->loads->terms->hung[k]) up->tip = pair_add(up->tip, q->arm[k].joint);
    }
}

static void quad_hand_out(const struct quad_pendulum *q, const struct test_quad_forces *forces) {
    if (quad_cart(q, 0)) q->arm[0].tip = q->arm[0].joint;
    for (int k = 0; k < q->tree->n; k++) {
        const struct quad_arm *a = &q->arm[k];
        forces->joint_along[k] = pair_dot(a->turn, a->joint);
        forces->joint_across[k] = pair_dot(pair_left(a->turn), a->joint);
        forces->tip_along[k] = pair_dot(a->turn, a->tip);
        forces->tip_across[k] = pair_dot(pair_left(a->turn), a->tip);
    }
}

void test_quad_bodies(const struct pend_tree *tree, const struct pend_loads *loads,
                      const struct test_quad_state *state, test_quad acc[],
                      const struct test_quad_forces *forces) {
    size_t n = (size_t)tree->n;
    struct quad_pendulum q = {.tree = tree, .loads = loads, .state = state};
    test_quad *matrix = calloc(n * n, sizeof *matrix);
    q.arm = calloc(n, sizeof *q.arm);
    q.moves = calloc(n * n, sizeof *q.moves);
    if (!matrix || !q.arm || !q.moves) abort();
    for (int k = 0; k < tree->n; k++) {
        quad_body(&q, k);
        quad_joint(&q, k);
        test_quad torque = quad_torque(&q, k);
        q.arm[k].torque = torque;
        int p = tree->parent[k];
        if (p >= 0 && !quad_cart(&q, p)) q.arm[p].torque -= torque;
        if (!quad_cart(&q, k)) q.arm[k].air = quad_air(&q, k);
        acc[k] = 0;
    }
    for (int k = 0; k < tree->n; k++) quad_add(&q, k, matrix, acc);
    test_quad_solve(tree->n, matrix, acc);
    if (forces) {
        quad_newton(&q, acc);
        quad_hand_out(&q, forces);
    }
    free(matrix);
    free(q.arm);
    free(q.moves);
}

/* y' of a state of 2 n numbers */
struct quad_flow {
    int n;
    test_quad_fn *accelerate;
    void *context;
};
static void quad_slope(const struct quad_flow *flow, const test_quad y[], test_quad time,
                       test_quad slope[]) {
    struct test_quad_state state = {y, y + flow->n, time};
    memcpy(slope, y + flow->n, (size_t)flow->n * sizeof *slope);
    flow->accelerate(flow->context, &state, slope + flow->n);
}

/* the modified midpoint rule over `span` in 2 `parts` parts; work: three states */
static void quad_midpoint(const struct quad_flow *flow, const test_quad y[], test_quad time,
                          test_quad span, int parts, test_quad end[], test_quad work[]) {
    size_t count = 2 * (size_t)flow->n;
    test_quad *before = work, *now = work + count, *slope = work + 2 * count;
    test_quad h = span / (2 * parts);
    memcpy(before, y, count * sizeof *y);
    quad_slope(flow, y, time, slope);
    for (size_t i = 0; i < count; i++) now[i] = y[i] + h * slope[i];
    for (int j = 1; j < 2 * parts; j++) {
        quad_slope(flow, now, time + j * h, slope);
        for (size_t i = 0; i < count; i++) {
            test_quad next = before[i] + 2 * h * slope[i];
            before[i] = now[i], now[i] = next;
        }
    }
    quad_slope(flow, now, time + span, slope);
    for (size_t i = 0; i < count; i++) end[i] = (now[i] + before[i] + h * slope[i]) / 2;
}

double test_quad_advance(int arms, test_quad_fn *accelerate, void *context, test_quad phi[],
                         test_quad rate[], test_quad time, test_quad span, int parts) {
    const struct quad_flow flow = {arms, accelerate, context};
    size_t n = (size_t)arms, count = 2 * n;
    test_quad *y = malloc((4 + COLUMNS) * count * sizeof *y), last = 0;
    if (!y) abort();
    test_quad *work = y + count, *table = work + 3 * count;
    memcpy(y, phi, n * sizeof *y);
    memcpy(y + n, rate, n * sizeof *y);
    for (int part = 0; part < parts; part++) {
        test_quad step = span / parts, worst = 0;
        for (int j = 0; j < COLUMNS; j++) {
            // row j of Neville's scheme in h^2; column i of the previous row is at index i
            test_quad *row = table + (size_t)j * count;
            quad_midpoint(&flow, y, time + part * step, step, j + 1, row, work);
            for (int i = j - 1; i >= 0; i--) {
                test_quad *left = table + (size_t)i * count, *right = left + count;
                test_quad ratio = (test_quad)(j + 1) / (i + 1), less = ratio * ratio - 1;
                for (size_t m = 0; m < count; m++) {
                    test_quad more = (right[m] - left[m]) / less;
                    left[m] = right[m] + more;
                    if (i == 0 && m < n && j == COLUMNS - 1 && test_quad_abs(more) > worst)
                        worst = test_quad_abs(more);
                }
            }
        }
        memcpy(y, table, count * sizeof *y);
        last += worst;
    }
    memcpy(phi, y, n * sizeof *y);
    memcpy(rate, y + n, n * sizeof *y);
    free(y);
    return (double)last;
}

/* a tree and its loads, for quad_real */
struct quad_real {
    const struct pend_tree *tree;
    const struct pend_loads *loads;
};
static void quad_real(void *context, const struct test_quad_state *state, test_quad acc[]) {
    const struct quad_real *real = context;
    test_quad_bodies(real->tree, real->loads, state, acc, NULL);
}

double test_quad_move(const struct pend_tree *tree, const struct pend_loads *loads, test_quad phi[],
                      test_quad rate[], test_quad time, test_quad span, int parts) {
    struct quad_real real = {tree, loads};
    return test_quad_advance(tree->n, quad_real, &real, phi, rate, time, span, parts);
}

#include "core/integrate/pieces/joints.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/integrate/pieces/balance.h"

/* relative rounding error of a torque or an acceleration */
static const double joints_slack = 1e-13;
/* s: after a rebound that would last less than this, the joint stays at the stop */
static const double joints_flight = 1e-6;
/* rad: a joint closer to a stop than this is at the stop */
static const double joints_near = 1e-14;

enum { JOINTS_IMPACTS = 10000 };

static const struct pend_loads *joints_loads(const struct pend_joints *j) {
    return &j->piece->problem->loads;
}

static int joints_holder(const struct pend_joints *j, int k) {
    return pend_terms_holder(joints_loads(j)->terms, j->tree->parent, k);
}

static double joints_sliding(const struct pend_joints *j, int k) {
    return j->piece->rules->sliding ? j->piece->rules->sliding[k] : 0;
}

static double joints_holding(const struct pend_joints *j, int k) {
    return j->piece->rules->holding ? j->piece->rules->holding[k] : 0;
}

/* ---- making */

static size_t joints_padded(size_t bytes) { return (bytes + 63) / 64 * 64; }

static size_t joints_lay(struct pend_joints *j, const struct pend_tree *tree,
                         const struct pend_terms *terms, char *base) {
    size_t n = (size_t)tree->n, used = 0;
    double **row[] = {&j->acc, &j->torque, &j->blow, &j->hit};
    signed char **flag[] = {&j->mode, &j->touch,      &j->forced,     &j->struck,
                            &j->try,  &j->was_forced, &j->was_struck, &j->side};
    unsigned char **mark[] = {&j->stopped, &j->holds};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++, used += joints_padded(n * 8))
        *row[i] = base ? (double *)(void *)(base + used) : NULL;
    for (size_t i = 0; i < sizeof flag / sizeof *flag; i++, used += joints_padded(n))
        *flag[i] = base ? (signed char *)(base + used) : NULL;
    for (size_t i = 0; i < sizeof mark / sizeof *mark; i++, used += joints_padded(n))
        *mark[i] = base ? (unsigned char *)(base + used) : NULL;
    j->zero = base ? (double *)(void *)(base + used) : NULL;
    used += joints_padded(3 * n * sizeof(double));
    j->list = base ? (double *)(void *)(base + used) : NULL;
    used += joints_padded((size_t)terms->count * sizeof(double));
    j->work = base ? base + used : NULL;
    used += joints_padded(pend_bodies_bytes(tree, terms));
    j->room = base ? base + used : NULL;
    return used + joints_padded(pend_balance_bytes(tree));
}

size_t pend_joints_bytes(const struct pend_tree *tree, const struct pend_terms *terms) {
    struct pend_joints sketch;
    return joints_lay(&sketch, tree, terms, NULL);
}

void pend_joints_init(struct pend_joints *j, struct pend_piece *piece, void *memory) {
    const struct pend_problem *problem = piece->problem;
    *j = (struct pend_joints){.piece = piece, .tree = problem->tree, .n = problem->tree->n};
    joints_lay(j, problem->tree, problem->loads.terms, memory);
}

double pend_joints_angle(const struct pend_joints *j, const double phi[], int k) {
    int p = joints_holder(j, k), cart = !k && pend_terms_cart(joints_loads(j)->terms);
    return p < 0 ? phi[k] + (cart ? 0 : M_PI_2) : phi[k] - phi[p];
}

/* whether a joint that can hold carries an arm with drag at its tip, whose torque would be lost */
static int joints_blown(const struct pend_joints *j, int k) {
    const struct pend_loads *loads = joints_loads(j);
    const struct pend_rules *rules = j->piece->rules;
    int holds = joints_holding(j, k) > 0 ||
                (rules->least && !(isinf(rules->least[k]) && isinf(rules->most[k])));
    return holds && joints_holder(j, k) >= 0 &&
           (pend_terms_get(loads->terms, loads->value, PEND_TERM_DRAG, k) != 0 ||
            pend_terms_get(loads->terms, loads->value, PEND_TERM_DRAG_QUADRATIC, k) != 0);
}

/* the message about a joint that starts beyond its stop */
static enum pend_status joints_beyond(const struct pend_joints *j, int k, double q,
                                      struct pend_error *error) {
    double low = j->piece->rules->least[k], high = j->piece->rules->most[k];
    int cart = !k && pend_terms_cart(joints_loads(j)->terms), arm = j->tree->order[k];
    double turned = q - 2 * M_PI * round((q - fmin(fmax(q, low), high)) / (2 * M_PI));
    char meant[64] = "", who[32] = "the cart";
    if (!cart && turned != q && turned >= low && turned <= high)
        snprintf(meant, sizeof meant, "; angles are not wrapped: did you mean %.12g?", turned);
    if (!cart) snprintf(who, sizeof who, "arm %d", arm + 1);
    return pend_fail(error, PEND_INVALID, cart ? -1 : arm, 0,
                     "%s starts %s its stop: its %s is %.12g and must be %s %.12g %s%s", who,
                     q < low ? "below" : "above",
                     cart                      ? "place"
                     : joints_holder(j, k) < 0 ? "angle theta"
                                               : "angle to the arm that carries it",
                     q, q < low ? "at least" : "at most", q < low ? low : high, cart ? "m" : "rad",
                     meant);
}

enum pend_status pend_joints_start(struct pend_joints *j, struct pend_error *error) {
    const struct pend_rules *rules = j->piece->rules;
    for (int k = 0; k < j->n; k++) {
        int arm = j->tree->order[k];
        j->mode[k] = PEND_JOINT_FREE;
        if (!joints_blown(j, k)) continue;
        return pend_fail(
            error, PEND_INVALID, arm, 0,
            "arm %d has drag and a joint that can stick (dry friction or a stop), which cannot be "
            "combined: give its friction a \"speed\", or use \"drag_per_mass\"",
            arm + 1);
    }
    for (int k = 0; rules->least && k < j->n; k++) {
        double q = pend_joints_angle(j, j->piece->phi, k), near = joints_near * (1 + fabs(q));
        if (q < rules->least[k] - near || q > rules->most[k] + near)
            return joints_beyond(j, k, q, error);
        if (rules->most[k] - q <= near) j->touch[k] = j->struck[k] = 1;
        if (q - rules->least[k] <= near) j->touch[k] = j->struck[k] = -1;
    }
    return PEND_OK;
}

/* ---- accelerations of the candidate modes */

/* computes the torques of sliding joints in the candidate modes */
static void joints_slide(const struct pend_joints *j) {
    int row = joints_loads(j)->terms->row[PEND_TERM_SLIDE];
    assert(row >= 0);
    for (int k = 0; k < j->n; k++) {
        int way = j->try[k];
        j->piece->value[row + k] = way == 1 || way == -1 ? -way * joints_sliding(j, k) : 0;
    }
}

void pend_joints_accelerations(struct pend_joints *j, const struct pend_stuck *stuck, double time,
                               const double phi[], const double rate[], double acc[]) {
    struct bodies_state state = {phi, NULL, rate, time, 0};
    if (!stuck) {
        pend_bodies_at(j->tree, joints_loads(j), &state, j->work, acc, NULL);
        return;
    }
    double *own = j->zero + j->n, *speed = own + j->n;
    for (int c = 0; c < stuck->tree->n; c++) {
        own[c] = phi[stuck->of[c]];
        speed[c] = stuck->still[stuck->of[c]] ? 0 : rate[stuck->of[c]];
    }
    state.phi = own, state.rate = speed;
    pend_bodies_at(stuck->tree, &stuck->loads, &state, stuck->work, speed, NULL);
    pend_stuck_spread(stuck, speed, acc);
}

/* computes accelerations, and torques of the holding joints */
static enum pend_status joints_look(struct pend_joints *j) {
    const struct pend_piece *piece = j->piece;
    struct pend_stuck *stuck = NULL;
    int any = 0;
    joints_slide(j);
    for (int k = 0; k < j->n; k++) any |= j->holds[k] = j->try[k] == PEND_JOINT_HOLDS;
    if (any) PEND_TRY(pend_stuck_new(&stuck, j->tree, joints_loads(j), j->holds, piece->phi, NULL));
    pend_joints_accelerations(j, stuck, piece->now, piece->phi, piece->rate, j->acc);
    pend_stuck_free(&stuck);
    const struct pend_moving moving = {piece->now, piece->phi, piece->rate, j->acc};
    if (any) pend_balance(j->tree, joints_loads(j), &moving, j->room, j->torque, NULL);
    return PEND_OK;
}

/* ---- impacts */

/* computes the changes of the rates due to a unit impulse at joint k; returns s^T M^-1 s */
static double joints_blow(struct pend_joints *j, int k) {
    const struct pend_loads *loads = joints_loads(j);
    const struct pend_terms *terms = loads->terms;
    memcpy(j->list, loads->value, (size_t)terms->count * sizeof(double));
    for (int r = PEND_TERM_DAMPING; r < PEND_TERM_ROWS; r++)
        for (int i = 0; i < j->n && terms->row[r] >= 0; i++)
            if (r != PEND_TERM_FRICTION_SPEED && r != PEND_TERM_DRAG_SPEED)
                j->list[terms->row[r] + i] = 0;
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (terms->one[i] >= 0 && i != PEND_TERM_RAIL) j->list[terms->one[i]] = 0;
    for (int i = 0; i < terms->harmonics; i++) j->list[terms->harmonic[i].at] = 0;
    j->list[terms->row[PEND_TERM_INPUT] + k] = 1;
    const struct pend_loads still = {0, terms, j->list};
    const struct bodies_state state = {j->piece->phi, NULL, j->zero, 0, 0};
    pend_bodies_at(j->tree, &still, &state, j->work, j->blow, NULL);
    return pend_joints_rate(j, j->blow, k);
}

/* sets the modes of joints that move and no longer touch a stop */
static void joints_moving(struct pend_joints *j) {
    for (int k = 0; k < j->n; k++) {
        double r = pend_joints_rate(j, j->piece->rate, k);
        if (r == 0) continue;
        j->touch[k] = 0;
        j->mode[k] = (signed char)(joints_sliding(j, k) > 0 ? (r > 0 ? 1 : -1) : PEND_JOINT_FREE);
    }
}

/* determines whether the bounce that follows an impact is too short to resolve */
static enum pend_status joints_last(struct pend_joints *j, int k, int side, int *last) {
    joints_moving(j);
    memcpy(j->try, j->mode, (size_t)j->n);
    PEND_TRY(joints_look(j));
    double a = side * pend_joints_rate(j, j->acc, k),
           v = fabs(pend_joints_rate(j, j->piece->rate, k));
    *last = a > 0 && 2 * v < joints_flight * a;
    return PEND_OK;
}

static enum pend_status joints_hit(struct pend_joints *j, int k) {
    double *rate = j->piece->rate, e = j->piece->rules->restitution[k];
    double r = pend_joints_rate(j, rate, k), part = 1, flown = j->piece->now - j->hit[k];
    int side = j->struck[k], p = joints_holder(j, k);
    if (e < 1 && side == j->side[k] && flown > 0 && flown < joints_flight) e = 0;
    int last = e == 0;
    j->hit[k] = j->piece->now, j->side[k] = (signed char)side;
    double d = joints_blow(j, k);
    for (int i = 0; i < j->n; i++) rate[i] -= (1 + e) * r / d * j->blow[i];
    if (!last) {
        PEND_TRY(joints_last(j, k, side, &last));
        double now = last ? pend_joints_rate(j, rate, k) : 0; // the rebound is removed
        for (int i = 0; i < j->n; i++) rate[i] -= now / d * j->blow[i];
    }
    if (last)
        rate[k] = p < 0 ? 0 : rate[p];
    else
        part = 1 - e * e;
    j->heat += r * r * part / (2 * d);
    joints_moving(j);
    if (last) j->touch[k] = (signed char)side;
    return PEND_OK;
}

enum pend_status pend_joints_impacts(struct pend_joints *j, struct pend_error *error) {
    double *rate = j->piece->rate, most = 0;
    for (int k = 0; k < j->n; k++) most = fmax(most, fabs(rate[k]));
    for (int tries = 0; j->piece->rules->least; tries++) {
        int hit = -1;
        for (int i = 0; i < j->n && hit < 0; i++) {
            int k = j->tree->place[i], p = joints_holder(j, k);
            if (!j->struck[k]) j->struck[k] = j->touch[k];
            double r = j->struck[k] * pend_joints_rate(j, rate, k);
            if (r > joints_slack * most) hit = k;
            // a joint at its stop with a rate within rounding is at rest there
            if (!r || fabs(r) > joints_slack * most) continue;
            rate[k] = p < 0 ? 0 : rate[p];
            j->touch[k] = j->struck[k];
        }
        if (hit < 0) return PEND_OK;
        if (tries == JOINTS_IMPACTS)
            return pend_fail(error, PEND_STEP_TOO_SMALL, j->tree->order[hit], j->piece->now,
                             "the impacts of %d arms do not end", j->n);
        PEND_TRY(joints_hit(j, hit));
    }
    return PEND_OK;
}

/* ---- modes of the joints at rest */

/* by how much a holding joint's torque exceeds its limit, N m; way: out, the direction of the
 * torque */
static double joints_over(const struct pend_joints *j, int k, double bound, int *way) {
    double h = j->torque[k], high = j->touch[k] < 0 ? INFINITY : bound,
           low = j->touch[k] > 0 ? -INFINITY : -bound;
    double over = fmax(h - high, low - h), size = fabs(h) + bound;
    *way = h > 0 ? -1 : 1;
    return over > joints_slack * size ? over : 0;
}

/* the acceleration of a released joint against its direction of motion, rad/s^2 */
static double joints_against(const struct pend_joints *j, int k) {
    int p = joints_holder(j, k);
    double a = pend_joints_rate(j, j->acc, k),
           size = fabs(j->acc[k]) + (p < 0 ? 0 : fabs(j->acc[p]));
    double against = -j->try[k] * a;
    return against > joints_slack * size ? against : 0;
}

static int joints_rests(const struct pend_joints *j, int k) {
    return pend_joints_rate(j, j->piece->rate, k) == 0 &&
           (joints_sliding(j, k) > 0 || joints_holding(j, k) > 0 || j->touch[k]);
}

/* changes one candidate mode; returns 0 if all are consistent */
static int joints_change(struct pend_joints *j, const double bound[]) {
    double over = 0, against = 0;
    int out = -1, in = -1, way = 0;
    for (int k = 0; k < j->n; k++) {
        int to, holds = j->try[k] == PEND_JOINT_HOLDS;
        if (!joints_rests(j, k) || (!holds && j->forced[k])) continue;
        double x = holds ? joints_over(j, k, bound ? bound[k] : 0, &to) : joints_against(j, k);
        if (holds && x > over) over = x, out = k, way = to;
        if (!holds && x > against) against = x, in = k;
    }
    if (in >= 0)
        j->try[in] = PEND_JOINT_HOLDS;
    else if (out >= 0)
        j->try[out] = (signed char)way;
    return in >= 0 || out >= 0;
}

/* determines the modes of the joints at rest for the given limits; *sorted: whether a consistent
 * answer was found */
static enum pend_status joints_try(struct pend_joints *j, const double bound[], int *sorted) {
    int most = 40;
    for (int k = 0; k < j->n; k++) {
        int rests = joints_rests(j, k);
        j->try[k] = rests ? PEND_JOINT_HOLDS : j->mode[k];
        if (rests && j->forced[k]) j->try[k] = j->forced[k];
        most += 20 * rests;
    }
    for (*sorted = 0; most-- > 0 && !*sorted;) {
        PEND_TRY(joints_look(j));
        *sorted = !joints_change(j, bound);
    }
    return PEND_OK;
}

enum pend_status pend_joints_sort(struct pend_joints *j, struct pend_error *error) {
    int sorted;
    joints_moving(j);
    PEND_TRY(joints_try(j, j->piece->rules->holding, &sorted));
    if (!sorted) PEND_TRY(joints_try(j, j->piece->rules->sliding, &sorted));
    if (!sorted)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, j->piece->now,
                         "the solver could not decide which joints stick and which slide");
    for (int k = 0; k < j->n; k++) {
        int rests = joints_rests(j, k), holds = rests && j->try[k] == PEND_JOINT_HOLDS;
        if (!rests) {
            if (pend_joints_rate(j, j->piece->rate, k) == 0) j->mode[k] = PEND_JOINT_FREE;
            continue;
        }
        if (!holds) j->touch[k] = 0;
        j->mode[k] = holds                      ? PEND_JOINT_HOLDS
                     : joints_sliding(j, k) > 0 ? j->try[k]
                                                : PEND_JOINT_FREE;
    }
    memcpy(j->try, j->mode, (size_t)j->n);
    memcpy(j->was_forced, j->forced, (size_t)j->n);
    memcpy(j->was_struck, j->struck, (size_t)j->n);
    memset(j->forced, 0, (size_t)j->n);
    memset(j->struck, 0, (size_t)j->n);
    for (int k = 0; k < j->n; k++) j->holds[k] = j->mode[k] == PEND_JOINT_HOLDS;
    joints_slide(j);
    return PEND_OK;
}

enum pend_status pend_joints_contract(const struct pend_joints *j, const double phi_low[],
                                      struct pend_stuck **stuck) {
    int any = 0;
    *stuck = NULL;
    for (int k = 0; k < j->n; k++) any |= j->holds[k];
    if (!any) return PEND_OK;
    return pend_stuck_new(stuck, j->tree, joints_loads(j), j->holds, j->piece->phi, phi_low);
}

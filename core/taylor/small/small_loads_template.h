/* The orders of a real pendulum of up to LANES arms: torques between arms, a pivot that moves, and
 * bodies. The recurrences are those of an ideal pendulum (small_template), with two more terms on
 * the right-hand side.
 * Leaves to others: the series of drives (loads_template), the inverse (small_invert_template,
 * small_bodies_template). Included once for each number of lanes.
 * Invariant: without torques an order costs two more additions than for an ideal pendulum.
 *
 * A torque on an arm is a force across it, so that the force in an arm is f u with a complex f =
 * lambda + i sigma, sigma known from order to order. The recurrences use the series F = f u in
 * fixed axes: sigma = Im (conj(u) F), so that for order k
 *     Im F_k = sigma_k - sum_{j>=1} (Re u_j Im F_{k-j} - Im u_j Re F_{k-j})
 * is known, at the cost of the sums with lambda, and Re F_k is the response of the tree. The lambda
 * = Re (conj(u) F) are not part of the recurrences and are computed afterwards.
 *
 * Drag per mass, -2 gamma m v, replaces phi'' by phi'' + 2 gamma phi', and likewise u'' and the
 * pivot's z''. Bodies cost no more per order: the term of their inertia, -J phi'' / l, is a force
 * across as well. Rods take 1.4 (one arm) to 1.7 times (6) the time of point masses; with the
 * general kernel 2.7 to 3.6 times. */

/* the address of the forces, or of the forces across the arms, in row i */
VEC_INLINE double *SMALL(forces)(const struct jets_system *s, int i, int span) {
    return (LANES == 8 ? s->force + (i - 1) * 8 : s->rate + i * 8 + LANES) + span * VEC_WIDTH;
}

#include "core/taylor/small/small_bodies_template.h"

/* The responses of all arms to the rate of one arm through friction, and the forces across the arms
 * due to rates (friction) and angles (springs). */
struct SMALL(joints) {
    struct SMALL(pair) friction[LANES], loss[LANES], spring[LANES];
    struct SMALL(pair) inertia; /* inertias: J over the arms' lengths, in the lanes of the forces */
};

/* forces across the arms due to the rates of arm a and its parent, by the torque -c (w_a - w_p) */
VEC_INLINE void SMALL(hold)(const struct jets_system *s, int a, double c,
                            struct SMALL(pair) column[LANES]) {
    int up = s->parent[a];
    const double *twist = s->loads->twist + a * LOADS_STRIDE;
    for (int p = FORCES; p < PARTS; p++) {
        PART torque = PART_(get)(twist + p * PART_WIDTH) * c;
        column[a].part[p] -= torque;
        if (up >= 0) column[up].part[p] += torque;
    }
}

VEC_INLINE void SMALL(join_arms)(const struct jets_system *s, const struct SMALL(table) * table,
                                 double unit, struct SMALL(joints) * joints) {
    const struct jets_loads *loads = s->loads;
    memset(joints, 0, offsetof(struct SMALL(joints), inertia));
    for (int a = 0; a < s->n && loads->losses; a++) {
        int p = s->parent[a];
        double c = pend_terms_get(loads->terms, loads->value, PEND_TERM_DAMPING, a) * unit;
        SMALL(hold)(s, a, c, joints->loss);
        for (int i = 0; i < PARTS; i++) {
            PART own = table->side[a].part[i] * (c * s->inv_len[a]);
            if (p >= 0) {
                own -= table->side[p].part[i] * (c * s->inv_len[p]);
                joints->friction[p].part[i] += own;
            }
            joints->friction[a].part[i] -= own;
        }
    }
    for (int a = 0; a < s->n && loads->springs; a++) {
        double c = pend_terms_get(loads->terms, loads->value, PEND_TERM_STIFFNESS, a);
        SMALL(hold)(s, a, c * (unit * unit), joints->spring);
    }
}

/* adds given torques and springs to the right-hand side of order k, which is divided by k + 1 */
VEC_INLINE void SMALL(give)(const struct jets_system *s, const struct SMALL(joints) * joints, int k,
                            struct SMALL(pair) * question) {
    const struct jets_loads *loads = s->loads;
    PART share = PART_(of)(s->share[k]);
    for (int p = 0; p < PARTS; p++)
        question->part[p] = PART_(fma)(
            share, PART_(get)(loads->given + k * LOADS_STRIDE + p * PART_WIDTH), question->part[p]);
    if (!joints || !loads->springs || !k) return;
    const double *rate = s->rate + (k - 1) * 8;
    share *= s->share[k - 1];
    for (int p = FORCES; p < PARTS; p++) {
        PART sum = rate[0] * joints->spring[0].part[p];
        for (int j = 1; j < LANES; j++)
            sum = PART_(fma)(PART_(of)(rate[j]), joints->spring[j].part[p], sum);
        question->part[p] = PART_(fma)(share, sum, question->part[p]);
    }
}

/* the rates of a pair in the lanes of part p of its forces */
VEC_INLINE PART SMALL(beside)(const struct SMALL(pair) * x, int p) {
    return SMALL(twice)(x->part[p - FORCES]);
}

/* subtracts the inertia of bodies times `rates` from the known forces across the arms */
VEC_INLINE void SMALL(resist)(const struct SMALL(joints) * joints, const struct SMALL(pair) * rates,
                              struct SMALL(pair) * forces) {
    for (int p = FORCES; p < PARTS; p++)
        forces->part[p] =
            PART_(fma)(-joints->inertia.part[p], SMALL(beside)(rates, p), forces->part[p]);
}

/* adds drag per mass to the right-hand side of order k > 0: 2 gamma u_{k+1} to Im T and to Re T,
 * and to Re T also -2 gamma phi'_k / (k + 1) */
VEC_INLINE void SMALL(haze)(const struct jets_system *s, int k, struct SMALL(pair) * question,
                            struct SMALL(pair) * minus_re) {
    PART share = PART_(of)(s->share[k]);
    for (int p = 0; p < TURNS; p++) {
        PART drag_per_mass = SMALL(factor)(s->loads->drag_per_mass, 0, p);
        const double *turn = s->turn_re + (k + 1) * 8 + p * PART_WIDTH;
        PART im = PART_(get)(s->turn_im + (turn - s->turn_re));
        PART more = im - share * PART_(get)(SMALL(motion)(s, k, p));
        question->part[p] = PART_(fma)(drag_per_mass, PART_(get)(turn), question->part[p]);
        minus_re->part[p] -= drag_per_mass * more;
    }
}

/* removes the part of drag per mass, 2 gamma Im u_{k+1}, from a response */
VEC_INLINE void SMALL(clear)(const struct jets_system *s, int k, struct SMALL(pair) * answer) {
    for (int p = 0; p < TURNS; p++) {
        const double *im = k ? s->turn_im + (k + 1) * 8 + p * PART_WIDTH : SMALL(motion)(s, 0, p);
        answer->part[p] -= SMALL(factor)(s->loads->drag_per_mass, 0, p) * PART_(get)(im);
    }
}

/* number `lane` of the rates of a pair, from the register or from memory */
#if PARTS == 1
#define SMALL_RATE(x, rate, lane) SMALL_BEAM(x, lane)
#else
#define SMALL_RATE(x, rate, lane) PART_(of)((rate)[lane])
#endif

/* the response of the tree to an order's right-hand side, to the pivot and to friction */
VEC_INLINE struct SMALL(pair)
    SMALL(respond)(const struct jets_system *s, const struct SMALL(table) * table,
                   const struct SMALL(joints) * joints, int k, int bodies,
                   const struct SMALL(pair) * question, const struct SMALL(pair) * motion) {
    const struct jets_loads *loads = s->loads;
    const double *rate = s->rate + k * 8;
    PART share = PART_(of)(s->share[k]);
    struct SMALL(pair) answer = SMALL(solve)(table, question);
    int dropped = bodies ? PARTS : TURNS;
    (void)rate, (void)motion;
    for (int p = 0; p < PARTS; p++) {
        PART sum = p < dropped ? PART_(get)(loads->drop + k * LOADS_STRIDE + p * PART_WIDTH)
                               : PART_(of)(0);
        if (joints && loads->losses) {
#define SMALL_TERM(sum, j)                                                                         \
    sum = PART_(fma)(SMALL_RATE(motion, rate, j), joints->friction[j].part[p], sum)
            SMALL_TERM(sum, 0);
#if LANES == 2
            SMALL_TERM(sum, 1);
#else
            PART odd = SMALL_RATE(motion, rate, 1) * joints->friction[1].part[p];
            SMALL_TERM(sum, 2);
            SMALL_TERM(odd, 3);
#if LANES == 8
            SMALL_TERM(sum, 4);
            SMALL_TERM(odd, 5);
            SMALL_TERM(sum, 6);
            SMALL_TERM(odd, 7);
#endif
            sum += odd;
#endif
#undef SMALL_TERM
        } else if (p >= dropped) {
            continue;
        }
        answer.part[p] = PART_(fma)(share, sum, answer.part[p]);
    }
    return answer;
}

/* computes the forces across the arms of order k from the right-hand side and the rates of order k,
 * and stores them next to the rates of order k + 1 */
VEC_INLINE void SMALL(cross)(const struct jets_system *s, const struct SMALL(joints) * joints,
                             int k, const struct SMALL(pair) * question,
                             const struct SMALL(pair) * motion, struct SMALL(pair) * across) {
    const struct jets_loads *loads = s->loads;
    const double *rate = s->rate + k * 8;
    *across = *motion;
    for (int p = FORCES; p < PARTS; p++) {
        size_t at = (size_t)k * LOADS_STRIDE + (size_t)p * PART_WIDTH;
        PART sum = PART_(of)(0);
        if (loads->losses) {
            sum = rate[0] * joints->loss[0].part[p];
            for (int j = 1; j < LANES; j++)
                sum = PART_(fma)(PART_(of)(rate[j]), joints->loss[j].part[p], sum);
            PART_(put)(loads->loss + at, sum);
        }
        sum = PART_(fma)(SMALL(factor)(0, k + 1, p), question->part[p], sum);
        if (PARTS == 1) sum = PART_(fma)(SMALL(factor)(1, 0, p), motion->part[p], sum);
        across->part[p] = sum;
        PART_(put)(loads->across + at + LOADS_STRIDE, sum);
    }
}

/* adds the sums with real parts of turns to the others, for forces; the rest are sums of rates */
VEC_INLINE void SMALL(fold)(struct SMALL(known) * x) {
    for (int p = FORCES; p < PARTS; p++) {
        x->im.part[p] = PART_(fma)(SMALL(factor)(0, 1, p), x->minus_re.part[p], x->im.part[p]);
        x->minus_re.part[p] *= SMALL(factor)(1, 0, p);
    }
}

/* in place, from the highest order down: lambda = Re (conj(u) F) */
static void SMALL(along)(const struct jets_system *s, int order) {
    const struct jets_loads *loads = s->loads;
    if (loads->bodies) SMALL(ends)(s, order, 1);
    for (int span = 0; span < SPANS; span++) {
        const double *across = loads->across + LANES + span * VEC_WIDTH;
        const double *re = s->turn_re + span * VEC_WIDTH, *im = s->turn_im + span * VEC_WIDTH;
        VEC first = VEC_(get)(s->rate + span * VEC_WIDTH);
        for (int k = order - 1; k > 0; k--) {
            VEC sum = VEC_(get)(SMALL(forces)(s, k + 1, span)), less = VEC_(of)(0);
            sum = VEC_(fma)(first, VEC_(get)(across + k * LOADS_STRIDE), sum);
            for (int j = 2; j <= k; j++) {
                sum = VEC_(fma)(VEC_(get)(im + j * 8),
                                VEC_(get)(across + (k + 1 - j) * LOADS_STRIDE), sum);
                less = VEC_(fma)(VEC_(get)(re + j * 8),
                                 VEC_(get)(SMALL(forces)(s, k + 1 - j, span)), less);
            }
            VEC_(put)(SMALL(forces)(s, k + 1, span), sum - less);
        }
    }
}

/* stores order k of the force that the pivot exerts, which is the force in the first arm */
VEC_INLINE void SMALL(pivot_force)(const struct jets_system *s, int k,
                                   const struct SMALL(pair) * question,
                                   const struct SMALL(pair) * answer) {
    const int lane = PARTS == 1 ? LANES : 0;
    s->loads->pivot_force_x[k] = (k + 1) * answer->part[FORCES][lane];
    s->loads->pivot_force_y[k] = (k + 1) * question->part[FORCES][lane];
}

/* computes the coefficients of an order from its right-hand side, and the force of the pivot */
VEC_INLINE void SMALL(order)(const struct jets_system *s, const struct SMALL(table) * table,
                             const struct SMALL(joints) * joints, int k, int bodies,
                             const struct SMALL(known) * known, struct SMALL(pair) * question,
                             struct SMALL(pair) * answer, struct SMALL(pair) * motion,
                             struct SMALL(pair) * across, struct SMALL(turn) * turn) {
    int hazy = bodies && s->loads->drag_per_mass != 0;
    struct SMALL(pair) real = known->minus_re;
    SMALL(give)(s, joints, k, question);
    if (hazy && k) SMALL(haze)(s, k, question, &real);
    if (bodies) SMALL(resist)(joints, &real, question);
    *answer = SMALL(respond)(s, table, joints, k, bodies, question, motion);
    if (bodies) SMALL(resist)(joints, answer, question);
    if (hazy) SMALL(clear)(s, k, answer);
    SMALL(keep)(s, k, known, answer, motion, turn);
    if (joints)
        SMALL(cross)(s, joints, k, question, motion, across);
    else
        *across = *motion;
    if (s->loads->moves && !joints) SMALL(pivot_force)(s, k, question, answer);
}

/* the table of responses of point masses */
VEC_INLINE void SMALL(points)(const struct jets_system *s, struct SMALL(table) * table) {
    struct SMALL(columns) columns;
    SMALL(invert)(s, &columns);
    for (int j = 0; j < LANES; j++) {
        table->pull[j] = SMALL(join)(&columns.force_side[j], &columns.force_pull[j]);
        table->side[j] = SMALL(join)(&columns.acc_side[j], &columns.acc_pull[j]);
    }
}

VEC_INLINE void SMALL(loaded)(const struct jets_system *s, double unit, int order, int couples,
                              int bodies) {
    struct SMALL(table) table;
    struct SMALL(joints) made, *joints = couples ? &made : NULL;
    if (bodies)
        SMALL(rigid)(s, order, &table, &made.inertia);
    else
        SMALL(points)(s, &table);
    if (couples) SMALL(join_arms)(s, &table, unit, joints);
    struct SMALL(start) start = SMALL(begin)(s, 0);
    struct SMALL(first)
        first = {SMALL(join)(&start.rate, &start.rate), SMALL(join)(&start.rate, &start.opposite),
                 SMALL(join)(&start.rate, &start.zero)};
    struct SMALL(known)
        known = {SMALL(join)(&start.zero, &start.zero), SMALL(join)(&start.square, &start.zero)};
    struct SMALL(known) next = {known.minus_re, known.minus_re}, now = next;
    struct SMALL(pair) question = known.im, motion = first.alone, across, answer;
    struct SMALL(turn) turn;
    _Alignas(64) double bent[2 * LANES] = {0};
    if (couples) loads_springs(s, unit, bent + LANES);
    for (int p = 0; p < PARTS; p++) {
        PART_(put)(SMALL(motion)(s, 0, p), first.alone.part[p]);
        question.part[p] += PART_(get)(bent + p * PART_WIDTH);
    }
    SMALL(order)(s, &table, joints, 0, bodies, &known, &question, &answer, &motion, &across, &turn);
    for (int k = 1; k < order; k += 2) {
        if (couples) SMALL(fold)(&next);
        SMALL(complete)(s, k - 1, &first, &known, &answer, &turn, &next, &question);
        known = next;
        if (k + 1 < order) SMALL(known)(s, k + 1, couples, &now, &next);
        SMALL(order)
        (s, &table, joints, k, bodies, &known, &question, &answer, &motion, &across, &turn);
        if (k + 1 == order) break;
        if (couples) SMALL(fold)(&now);
        SMALL(complete)(s, k, &first, &known, &answer, &turn, &now, &question);
        known = now;
        SMALL(arrive)(s, &turn, &motion, &across, couples, &next);
        SMALL(order)
        (s, &table, joints, k + 1, bodies, &known, &question, &answer, &motion, &across, &turn);
    }
}

/* the orders of a pendulum with loads */
static void SMALL(loaded_orders)(const struct jets_system *s, const double *value,
                                 const struct bodies_moment *now, int order) {
    struct jets_loads *loads = s->loads;
    loads_begin(s, value, now, order, LANES);
    loads->orders = order;
    if (loads->bodies) {
        SMALL(loaded)(s, now->unit, order, 1, 1);
        SMALL(ends)(s, 1, 0);
        return;
    }
    if (!loads->couples) {
        SMALL(loaded)(s, now->unit, order, 0, 0);
        loads->orders = 0;
        return;
    }
    SMALL(loaded)(s, now->unit, order, 1, 0);
    for (int k = 0; k < order; k++) {
        loads->pivot_force_x[k] = *SMALL(forces)(s, k + 1, 0);
        loads->pivot_force_y[k] = loads->across[(k + 1) * LOADS_STRIDE + LANES];
    }
}

/* the sum over the arms of the products of forces across and rates */
VEC_INLINE double SMALL(sum)(const struct jets_system *s, const VEC all[]) {
    double total = 0;
    for (int i = 0; i < SPANS; i++) {
        VEC part = all[i] * VEC_(get)(s->len + i * VEC_WIDTH);
        for (int lane = 0; lane < VEC_WIDTH; lane++) total += part[lane];
    }
    return total;
}

/* adds the power of the given torques for orders below `order`; given torques vanish from order
 * `orders` on */
VEC_INLINE void SMALL(effort)(const struct jets_system *s, int orders, int order, double *sum) {
    const double *forces = s->loads->given + LANES;
    for (int k = 0; k < order; k++) {
        VEC all[SPANS];
        for (int i = 0; i < SPANS; i++) {
            all[i] = VEC_(of)(0);
            for (int j = 0; j <= k && j < orders; j++)
                all[i] = VEC_(fma)(VEC_(get)(forces + j * LOADS_STRIDE + i * VEC_WIDTH),
                                   VEC_(get)(s->rate + (k - j) * 8 + i * VEC_WIDTH), all[i]);
        }
        sum[k] += SMALL(sum)(s, all);
    }
}

/* adds the heat of friction, whose forces are a symmetric form of the rates, so that products of
 * two orders are symmetric */
VEC_INLINE void SMALL(waste)(const struct jets_system *s, int order, double *sum) {
    const double *forces = s->loads->loss + LANES;
    for (int k = 0; k < order; k++) {
        VEC all[SPANS];
        for (int i = 0; i < SPANS; i++) {
            const double *force = forces + i * VEC_WIDTH, *rate = s->rate + i * VEC_WIDTH;
            all[i] = VEC_(of)(0);
            for (int j = 0; 2 * j < k; j++)
                all[i] = VEC_(fma)(VEC_(get)(force + j * LOADS_STRIDE),
                                   VEC_(get)(rate + (k - j) * 8), all[i]);
            all[i] += all[i];
            if (k % 2 == 0)
                all[i] = VEC_(fma)(VEC_(get)(force + k / 2 * LOADS_STRIDE),
                                   VEC_(get)(rate + k / 2 * 8), all[i]);
        }
        sum[k] -= SMALL(sum)(s, all);
    }
}

static void SMALL(power)(const struct jets_system *s, int order, double *work, double *heat) {
    const struct jets_loads *loads = s->loads;
    if (loads->losses) SMALL(waste)(s, order, heat);
    if (loads->drag_per_mass != 0) loads_haze(s, order, heat);
    int torques = jets_loads_torques(loads, order);
    if (torques) SMALL(effort)(s, torques, order, work);
    if (loads->moves && loads->bodies && loads->orders) SMALL(ends)(s, order, 0);
    if (loads->moves) loads_pivot_force(s, order, work);
}

#undef SMALL_RATE

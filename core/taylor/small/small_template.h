/* Series of trees of up to LANES arms, arms in lanes, the tree system of order 0 inverted once per
 * step.
 * Leaves to others: memory and angles (jets). Included once for each number of lanes.
 * Invariant: the stable sweeps compute the inverse, one unit right-hand side per lane. */
#define SMALL_PASTE2(a, b) a##b
#define SMALL_PASTE(a, b) SMALL_PASTE2(a, b)
#define SMALL(name) SMALL_PASTE(SMALL_PASTE(small, LANES), _##name)
/* arms are stored in one vector if the registers are wide enough, else in several, called spans */
#if LANES < KERNEL_WIDTH
#define VEC_WIDTH LANES
#else
#define VEC_WIDTH KERNEL_WIDTH
#endif
#define VEC SMALL_PASTE(lanes, VEC_WIDTH)
#define VEC_(name) SMALL_PASTE(VEC, _##name)
#define SPANS (LANES / VEC_WIDTH)

struct SMALL(arms) {
    VEC span[SPANS];
};

/* 1 in the lane of an arm, as part `span` of the arms */
VEC_INLINE VEC SMALL(unit)(int arm, int span) {
    VEC x = VEC_(of)(0);
    for (int i = 0; i < VEC_WIDTH; i++)
        if (span * VEC_WIDTH + i == arm) x[i] = 1;
    return x;
}

#include "core/taylor/small/small_invert_template.h"

/* The operands of the orders: rates in the lower half, forces in the upper one, as one vector if
 * the registers are wide enough, else in parts. A sum over the turns u has its real and imaginary
 * parts in separate vectors, [T | c] each. Real parts of turns are stored negated, which saves sign
 * changes. */
#if LANES == 2 && defined(__AVX2__)
#define PART_WIDTH 4
#elif LANES == 4 && defined(__AVX512F__)
#define PART_WIDTH 8
#elif LANES < KERNEL_WIDTH
#define PART_WIDTH LANES
#else
#define PART_WIDTH KERNEL_WIDTH
#endif
#define PART SMALL_PASTE(lanes, PART_WIDTH)
#define PART_(name) SMALL_PASTE(PART, _##name)
/* Number of parts of a pair; number of parts of the turns of all arms (twice the same turns if a
 * part holds a whole pair); index of the first part with forces. */
#define PARTS (2 * LANES / PART_WIDTH)
#define FORCES (PARTS > 1 ? PARTS / 2 : 0)
#define TURNS (PARTS > 1 ? PARTS / 2 : 1)

struct SMALL(pair) {
    PART part[PARTS];
};

/* the turns of all arms, one order */
struct SMALL(turn) {
    PART minus_re[TURNS], im[TURNS];
};

/* T and c: their negated real parts and their imaginary parts */
struct SMALL(known) {
    struct SMALL(pair) minus_re, im;
};

/* the address of the pair that consists of the rates of order j and the forces of order j - 1 */
VEC_INLINE double *SMALL(motion)(const struct jets_system *s, int j, int part) {
#if LANES == 8
    if (part >= PARTS / 2) return s->force + (j - 1) * 8 + (part - PARTS / 2) * PART_WIDTH;
#endif
    return s->rate + j * 8 + part * PART_WIDTH;
}

/* The address of the pair by which real parts of turns are multiplied: with torques in the joints
 * (`couples`) rates and forces across the arms, else the pair of SMALL(motion). */
VEC_INLINE double *SMALL(across)(const struct jets_system *s, int j, int part, int couples) {
    if (!couples || part < FORCES) return SMALL(motion)(s, j, part);
    return s->loads->across + j * LOADS_STRIDE + part * PART_WIDTH;
}

/* a pair from its halves */
VEC_INLINE struct SMALL(pair)
    SMALL(join)(const struct SMALL(arms) * rate, const struct SMALL(arms) * force) {
    struct SMALL(pair) pair;
#if PARTS == 1 && LANES == 2
    pair.part[0] = __builtin_shufflevector(rate->span[0], force->span[0], 0, 1, 2, 3);
#elif PARTS == 1
    pair.part[0] = __builtin_shufflevector(rate->span[0], force->span[0], 0, 1, 2, 3, 4, 5, 6, 7);
#else
    for (int p = 0; p < PARTS; p++)
        pair.part[p] = p < SPANS ? rate->span[p] : force->span[p - SPANS];
#endif
    return pair;
}

/* one number for all rates, another for all forces */
VEC_INLINE PART SMALL(factor)(double rate, double force, int part) {
#if PARTS == 1 && LANES == 2
    (void)part;
    return __builtin_shufflevector(PART_(of)(rate), PART_(of)(force), 0, 1, 6, 7);
#elif PARTS == 1
    (void)part;
    return __builtin_shufflevector(PART_(of)(rate), PART_(of)(force), 0, 1, 2, 3, 12, 13, 14, 15);
#else
    return PART_(of)(part < PARTS / 2 ? rate : force);
#endif
}

/* the rates of a pair, once for its rates and once for its forces, as the factor of turns */
VEC_INLINE PART SMALL(twice)(PART x) {
#if PARTS == 1 && LANES == 2
    return __builtin_shufflevector(x, x, 0, 1, 0, 1);
#elif PARTS == 1
    return __builtin_shufflevector(x, x, 0, 1, 2, 3, 0, 1, 2, 3);
#else
    return x;
#endif
}

/* sums of one part, for this order and the next; two of each, which halves the latency */
struct SMALL(sums) {
    PART now_re[2], now_im[2], next_re[2], next_im[2];
};

VEC_INLINE void SMALL(meet)(PART *minus_re, PART *im, const struct jets_system *s, int j, int i,
                            int part, int couples) {
    int at = j * 8 + part % TURNS * PART_WIDTH;
    PART motion = PART_(get)(SMALL(motion)(s, i, part));
    PART across = couples ? PART_(get)(SMALL(across)(s, i, part, couples)) : motion;
    *minus_re = PART_(fma)(PART_(get)(s->turn_re + at), across, *minus_re);
    *im = PART_(fma)(PART_(get)(s->turn_im + at), motion, *im);
}

/* adds the products, for orders k and k + 1, of coefficients known before order k - 2; each is
 * loaded once for both orders */
VEC_INLINE void SMALL(long_known)(const struct jets_system *s, int k, int part, int couples,
                                  struct SMALL(sums) * x) {
    enum { STRIDE = 8 };
    const double *re = s->turn_re + 4 * STRIDE + part % TURNS * PART_WIDTH;
    const double *im = s->turn_im + 4 * STRIDE + part % TURNS * PART_WIDTH;
    const double *motion = SMALL(motion)(s, k - 2, part);
    const double *across = SMALL(across)(s, k - 2, part, couples);
    int back = couples && part >= FORCES ? LOADS_STRIDE : STRIDE;
    PART m = PART_(get)(motion), c = couples ? PART_(get)(across) : m;
    for (int j = 4; j < k; j += 2, re += 2 * STRIDE, im += 2 * STRIDE) {
        PART ur = PART_(get)(re), ui = PART_(get)(im), vr = PART_(get)(re + STRIDE),
             vi = PART_(get)(im + STRIDE);
        x->next_re[0] = PART_(fma)(ur, c, x->next_re[0]);
        x->next_im[0] = PART_(fma)(ui, m, x->next_im[0]);
        m = PART_(get)(motion - STRIDE), c = couples ? PART_(get)(across - back) : m;
        x->now_re[0] = PART_(fma)(ur, c, x->now_re[0]);
        x->now_im[0] = PART_(fma)(ui, m, x->now_im[0]);
        x->next_re[1] = PART_(fma)(vr, c, x->next_re[1]);
        x->next_im[1] = PART_(fma)(vi, m, x->next_im[1]);
        motion -= 2 * STRIDE, across -= 2 * back;
        m = PART_(get)(motion), c = couples ? PART_(get)(across) : m;
        x->now_re[1] = PART_(fma)(vr, c, x->now_re[1]);
        x->now_im[1] = PART_(fma)(vi, m, x->now_im[1]);
    }
}

/* T and c of orders k and k + 1, k even and > 0, without the terms of the orders from k - 1 on; the
 * coefficients of order k - 2 are used last, because they are the newest */
VEC_INLINE void SMALL(known)(const struct jets_system *s, int k, int couples,
                             struct SMALL(known) * now, struct SMALL(known) * next) {
    for (int p = 0; p < PARTS; p++) {
        struct SMALL(sums) x;
        for (int i = 0; i < 2; i++)
            x.now_re[i] = x.now_im[i] = x.next_re[i] = x.next_im[i] = PART_(of)(0);
        if (k > 2) {
            SMALL(long_known)(s, k, p, couples, &x);
            SMALL(meet)(&x.now_re[0], &x.now_im[0], s, 3, k - 2, p, couples);
            SMALL(meet)(&x.now_re[1], &x.now_im[1], s, k, 1, p, couples);
            SMALL(meet)(&x.next_re[0], &x.next_im[0], s, 3, k - 1, p, couples);
            SMALL(meet)(&x.next_re[1], &x.next_im[1], s, k, 2, p, couples);
        }
        SMALL(meet)(&x.now_re[0], &x.now_im[0], s, 2, k - 1, p, couples);
        now->minus_re.part[p] = x.now_re[0] + x.now_re[1];
        now->im.part[p] = x.now_im[0] + x.now_im[1];
        next->minus_re.part[p] = x.next_re[0] + x.next_re[1];
        next->im.part[p] = x.next_im[0] + x.next_im[1];
    }
}

/* adds to the sums of order k + 2 the terms that became known in order k > 0: those with turns of
 * order k + 2, and those with the motion of order k + 1 */
VEC_INLINE void SMALL(arrive)(const struct jets_system *s, const struct SMALL(turn) * turn,
                              const struct SMALL(pair) * motion, const struct SMALL(pair) * across,
                              int couples, struct SMALL(known) * x) {
    for (int p = 0; p < PARTS; p++) {
        const double *second = s->turn_re + 2 * 8 + p % TURNS * PART_WIDTH;
        PART first = PART_(get)(SMALL(motion)(s, 1, p)), minus_re = PART_(get)(second);
        PART im = PART_(get)(s->turn_im + (second - s->turn_re));
        PART beside = couples ? PART_(get)(SMALL(across)(s, 1, p, couples)) : first;
        x->minus_re.part[p] = PART_(fma)(turn->minus_re[p % TURNS], beside, x->minus_re.part[p]);
        x->im.part[p] = PART_(fma)(turn->im[p % TURNS], first, x->im.part[p]);
        x->minus_re.part[p] = PART_(fma)(minus_re, across->part[p], x->minus_re.part[p]);
        x->im.part[p] = PART_(fma)(im, motion->part[p], x->im.part[p]);
    }
}

/* the derivatives of phi''/(k + 1) + T and of (lambda + c)/(k + 1) of all arms with respect to one
 * arm's T (pull) and its c / (k + 1) (side) */
struct SMALL(table) {
    struct SMALL(pair) pull[LANES], side[LANES];
};

/* number `lane` of a pair, in all lanes */
#if PARTS == 1 && LANES == 2
#define SMALL_BEAM(x, lane)                                                                        \
    __builtin_shufflevector((x)->part[0], (x)->part[0], lane, lane, lane, lane)
#elif PARTS == 1
#define SMALL_BEAM(x, lane)                                                                        \
    __builtin_shufflevector((x)->part[0], (x)->part[0], lane, lane, lane, lane, lane, lane, lane,  \
                            lane)
#else
#define SMALL_BEAM(x, lane) PART_(of)(beam[lane])
#endif

/* the response of the tree to the imaginary parts of T and of c / (k + 1) */
VEC_INLINE struct SMALL(pair)
    SMALL(solve)(const struct SMALL(table) * table, const struct SMALL(pair) * x) {
    struct SMALL(pair) answer;
#if PARTS > 1
    double beam[2 * LANES] __attribute__((aligned(64)));
    for (int p = 0; p < PARTS; p++) PART_(put)(beam + p * PART_WIDTH, x->part[p]);
#endif
    for (int p = 0; p < PARTS; p++) {
        PART even[2], odd[2];
        even[0] = SMALL_BEAM(x, 0) * table->pull[0].part[p];
        even[1] = SMALL_BEAM(x, LANES) * table->side[0].part[p];
#define SMALL_TERM(sum, j)                                                                         \
    do {                                                                                           \
        sum[0] = PART_(fma)(SMALL_BEAM(x, j), table->pull[j].part[p], sum[0]);                     \
        sum[1] = PART_(fma)(SMALL_BEAM(x, LANES + (j)), table->side[j].part[p], sum[1]);           \
    } while (0)
#if LANES == 2
        SMALL_TERM(even, 1);
        (void)odd;
        answer.part[p] = even[0] + even[1];
#else
        odd[0] = SMALL_BEAM(x, 1) * table->pull[1].part[p];
        odd[1] = SMALL_BEAM(x, LANES + 1) * table->side[1].part[p];
        SMALL_TERM(even, 2);
        SMALL_TERM(odd, 3);
#if LANES == 8
        SMALL_TERM(even, 4);
        SMALL_TERM(odd, 5);
        SMALL_TERM(even, 6);
        SMALL_TERM(odd, 7);
#endif
        answer.part[p] = (even[0] + odd[0]) + (even[1] + odd[1]);
#endif
#undef SMALL_TERM
    }
    return answer;
}

/* stores the coefficients of order k: rates of order k + 1, forces of order k, turns of order k +
 * 2 */
VEC_INLINE void SMALL(keep)(const struct jets_system *s, int k, const struct SMALL(known) * known,
                            const struct SMALL(pair) * answer, struct SMALL(pair) * motion,
                            struct SMALL(turn) * turn) {
    PART share = PART_(of)(s->share[k + 1]);
    for (int p = 0; p < PARTS; p++) {
        motion->part[p] =
            PART_(fma)(SMALL(factor)(1, k + 1, p), answer->part[p], known->minus_re.part[p]);
        PART_(put)(SMALL(motion)(s, k + 1, p), motion->part[p]);
    }
    for (int p = 0; p < TURNS; p++) {
        turn->minus_re[p] = share * SMALL(twice)(known->im.part[p]);
        turn->im[p] = share * SMALL(twice)(answer->part[p]);
        PART_(put)(s->turn_re + (k + 2) * 8 + p * PART_WIDTH, turn->minus_re[p]);
        PART_(put)(s->turn_im + (k + 2) * 8 + p * PART_WIDTH, turn->im[p]);
    }
}

/* pairs with rates of order 0 in one half; in the other the same, their negatives, or zeros */
struct SMALL(first) {
    struct SMALL(pair) same, opposite, alone;
};

/* T and c of order k + 1 from the terms already known and those that need order k. Only one
 * multiply-add separates the result of one order from the input of the next. u_1 is i phi'_0, and
 * u_{k+2} = i (turned + i Im T) / (k + 2). `question` is the imaginary part, with c divided by k +
 * 2: the next right-hand side. */
VEC_INLINE void SMALL(complete)(const struct jets_system *s, int k,
                                const struct SMALL(first) * first,
                                const struct SMALL(known) * known,
                                const struct SMALL(pair) * answer, const struct SMALL(turn) * turn,
                                struct SMALL(known) * next, struct SMALL(pair) * question) {
    PART share = PART_(of)(s->share[k + 1]);
    for (int p = 0; p < PARTS; p++) {
        PART same = first->same.part[p], scale = SMALL(factor)(1, s->share[k + 1], p);
        PART ready = scale * PART_(fma)(same, known->minus_re.part[p], next->im.part[p]);
        question->part[p] =
            PART_(fma)(answer->part[p], PART_(fma)(share, first->opposite.part[p], same), ready);
        next->minus_re.part[p] =
            PART_(fma)(turn->minus_re[p % TURNS], first->alone.part[p], next->minus_re.part[p]);
        next->im.part[p] = question->part[p];
    }
}

/* the rates of order 0, and their contribution to the first right-hand side */
struct SMALL(start) {
    struct SMALL(arms) zero, rate, opposite, square, pull, drop;
};

VEC_INLINE struct SMALL(start) SMALL(begin)(const struct jets_system *s, double gravity) {
    struct SMALL(start) x;
    double per_len = gravity * s->inv_len[0];
    for (int i = 0; i < SPANS; i++) {
        VEC rate = VEC_(get)(s->rate + i * VEC_WIDTH), root = SMALL(unit)(0, i);
        x.zero.span[i] = VEC_(of)(0);
        x.rate.span[i] = rate;
        x.opposite.span[i] = -rate;
        x.square.span[i] = rate * rate;
        // gravity is a pull on the root
        x.pull.span[i] = rate * rate - s->sine[0] * per_len * root;
        x.drop.span[i] = s->cosine[0] * per_len * root;
    }
    return x;
}

static void SMALL(orders)(const struct jets_system *s, double gravity, int order) {
    struct SMALL(columns) columns;
    struct SMALL(table) table;
    SMALL(invert)(s, &columns);
    // by reciprocity, the response of arm i to W_j is that of arm j to W_i; so is the acceleration
    // per W to the force per s
    for (int j = 0; j < LANES; j++) {
        table.pull[j] = SMALL(join)(&columns.force_side[j], &columns.force_pull[j]);
        table.side[j] = SMALL(join)(&columns.acc_side[j], &columns.acc_pull[j]);
    }
    if (s->answers) memcpy(s->answers, &table, sizeof table);
    struct SMALL(start) start = SMALL(begin)(s, gravity);
    struct SMALL(first)
        first = {SMALL(join)(&start.rate, &start.rate), SMALL(join)(&start.rate, &start.opposite),
                 SMALL(join)(&start.rate, &start.zero)};
    struct SMALL(known)
        known = {SMALL(join)(&start.zero, &start.zero), SMALL(join)(&start.square, &start.zero)};
    struct SMALL(known) next = {known.minus_re, known.minus_re}, now = next;
    struct SMALL(pair) question = SMALL(join)(&start.pull, &start.zero), motion;
    struct SMALL(pair) drop = SMALL(join)(&start.drop, &start.zero);
    struct SMALL(turn) turn;
    for (int p = 0; p < PARTS; p++) PART_(put)(SMALL(motion)(s, 0, p), first.alone.part[p]);
    struct SMALL(pair) answer = SMALL(solve)(&table, &question);
    for (int p = 0; p < PARTS; p++) answer.part[p] -= drop.part[p];
    SMALL(keep)(s, 0, &known, &answer, &motion, &turn);
    for (int k = 1; k < order; k += 2) {
        // the first of two orders, whose sums were computed together with those of the order before
        SMALL(complete)(s, k - 1, &first, &known, &answer, &turn, &next, &question);
        known = next;
        if (k + 1 < order) SMALL(known)(s, k + 1, 0, &now, &next);
        answer = SMALL(solve)(&table, &question);
        SMALL(keep)(s, k, &known, &answer, &motion, &turn);
        if (k + 1 == order) break;
        SMALL(complete)(s, k, &first, &known, &answer, &turn, &now, &question);
        known = now;
        SMALL(arrive)(s, &turn, &motion, &motion, 0, &next);
        answer = SMALL(solve)(&table, &question);
        SMALL(keep)(s, k + 1, &known, &answer, &motion, &turn);
    }
}

#include "core/taylor/small/small_spread_template.h"
#include "core/taylor/small/small_loads_template.h"

#undef SMALL_BEAM
#undef PART_WIDTH
#undef PART
#undef PART_
#undef PARTS
#undef TURNS
#undef FORCES

#undef SMALL_PASTE2
#undef SMALL_PASTE
#undef SMALL
#undef VEC_WIDTH
#undef VEC
#undef VEC_
#undef SPANS
#undef LANES

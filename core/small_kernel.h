/* Series of trees of up to LANES arms, arms in lanes, the tree system of order 0 inverted once a step.
 * Leaves to others: memory and angles (jets). Included once for each number of lanes.
 * Invariant: the inverse is built by the stable sweeps, one unit right-hand side a lane. */
#define SMALL_PASTE2(a, b) a##b
#define SMALL_PASTE(a, b) SMALL_PASTE2(a, b)
#define SMALL(name) SMALL_PASTE(SMALL_PASTE(small, LANES), _##name)
#define VEC SMALL_PASTE(lanes, LANES)
#define VEC_(name) SMALL_PASTE(VEC, _##name)

LANES_INLINE VEC SMALL(unit)(int lane) {
    VEC x = {0};
    x[lane] = 1;
    return x;
}

/* answers of arm j to a unit of inward pull W_i (first) or of force s_i across arm i (second) in lane i: force along
 * the arm, and acceleration across it; by reciprocity these rows are the columns that the orders need */
struct SMALL(columns) {
    VEC force_pull[LANES], force_side[LANES], acc_pull[LANES], acc_side[LANES];
};

/* sums over the children of an arm, and what the sweep up leaves, for all unit right-hand sides */
struct SMALL(node) {
    VEC push_pull, push_side, side_pull, side_side, sin, side; /* sums on the way up; side is g_t itself */
    VEC bias_pull, bias_side, late_pull, late_side, early_pull, early_side;
    VEC radial_pull, radial_side, tangential_pull, tangential_side;
};

LANES_INLINE void SMALL(up)(const struct jets_system *s, struct SMALL(node) node[]) {
    for (int k = 0; k < s->n; k++) {
        VEC zero = VEC_(of)(0);
        node[k].push_pull = node[k].push_side = node[k].side_pull = node[k].side_side = node[k].sin = zero;
        node[k].early_pull = node[k].early_side = zero;
        node[k].side = SMALL(unit)(k);
    }
    for (int k = s->n - 1; k >= 0; k--) {
        struct SMALL(node) *x = &node[k];
        x->push_side = VEC_(fma)(VEC_(of)(s->lean[k]), x->side, x->push_side - x->sin);
        x->bias_pull = x->push_pull - s->eff[k] * SMALL(unit)(k);
        x->bias_side = x->push_side;
        if (!k) break;
        struct SMALL(node) *up = &node[s->parent[k]];
        VEC Z = VEC_(of)(s->sine[k]), C = VEC_(of)(s->cosine[k]), kappa = VEC_(of)(s->kappa[k]);
        x->late_pull = up->side_pull;
        x->late_side = up->side_side;
        up->push_pull = VEC_(fma)(kappa, x->bias_pull, up->push_pull);
        up->push_side = VEC_(fma)(kappa, x->bias_side, up->push_side);
        up->side_pull = VEC_(fma)(Z, x->bias_pull, up->side_pull);
        up->side_side = VEC_(fma)(Z, x->bias_side, up->side_side);
        up->sin = VEC_(fma)(Z, SMALL(unit)(k), up->sin);
        up->side = up->side - C * SMALL(unit)(k);
    }
}

LANES_INLINE void SMALL(down)(const struct jets_system *s, struct SMALL(node) node[], struct SMALL(columns) * columns) {
    struct SMALL(node) pivot = {0};
    for (int k = 0; k < s->n; k++) {
        struct SMALL(node) *x = &node[k], *up = k ? &node[s->parent[k]] : &pivot;
        VEC Z = VEC_(of)(s->sine[k]), C = VEC_(of)(s->cosine[k]), tau = VEC_(of)(s->tau[k]);
        VEC stiff = VEC_(of)(s->eff[k] * s->kappa[k]), inv_eff = VEC_(of)(s->inv_eff[k]);
        VEC tension_pull = s->nu[k] * x->bias_pull, tension_side = s->nu[k] * x->bias_side;
        if (k) {
            // tension first, the siblings' part leaves k itself out
            tension_pull -= tau * (up->early_pull + x->late_pull);
            tension_side += tau * (up->side - (up->early_side + x->late_side));
            up->early_pull = VEC_(fma)(Z, x->bias_pull, up->early_pull);
            up->early_side = VEC_(fma)(Z, x->bias_side, up->early_side);
        }
        VEC kappa = VEC_(of)(s->kappa[k]);
        x->radial_pull = VEC_(fma)(kappa, up->radial_pull, (tension_pull - x->push_pull) * inv_eff);
        x->radial_side = VEC_(fma)(kappa, up->radial_side, (tension_side - x->push_side) * inv_eff);
        x->tangential_pull = -s->inv[k] * VEC_(fma)(VEC_(of)(s->sum_r[k]), x->radial_pull, x->side_pull);
        x->tangential_side = s->inv[k] * (x->side - VEC_(fma)(VEC_(of)(s->sum_r[k]), x->radial_side, x->side_side));
        columns->force_pull[k] = VEC_(fma)(stiff, up->radial_pull, tension_pull);
        columns->force_side[k] = VEC_(fma)(stiff, up->radial_side, tension_side);
        columns->acc_pull[k] = x->tangential_pull + Z * up->radial_pull - C * up->tangential_pull;
        columns->acc_side[k] = x->tangential_side + Z * up->radial_side - C * up->tangential_side;
    }
}

/* the columns in the units of the orders: pulls are l T, accelerations of angles */
LANES_INLINE void SMALL(scale)(const struct jets_system *s, struct SMALL(columns) * columns) {
    VEC inv_len = VEC_(get)(s->inv_len);
    for (int j = 0; j < s->n; j++) {
        VEC len = VEC_(of)(s->len[j]);
        columns->acc_side[j] *= inv_len;
        columns->force_side[j] *= inv_len * len;
        columns->force_pull[j] *= len;
    }
}

#if LANES == 8
/* coefficients of one order */
struct SMALL(order) {
    VEC re, im, rate, force;
};

/*
 * T and c of order k, and of order k + 1 but for the terms that order k is needed for, in one pass: what is loaded
 * serves both. Row -1 of the forces is zero.
 */
LANES_INLINE void SMALL(known)(const struct jets_system *s, int k, const struct SMALL(order) * first,
                               const struct SMALL(order) * newest, struct SMALL(order) * now,
                               struct SMALL(order) * next) {
    enum { STRIDE = 8 };
    const double *re = s->turn_re + 2 * STRIDE, *im = s->turn_im + 2 * STRIDE;
    const double *rate = s->rate + k * STRIDE, *force = s->force + (k - 1) * STRIDE;
    VEC x[8], w = newest->rate, f = newest->force;
    for (int i = 0; i < 8; i++) x[i] = VEC_(of)(0);
    // u_1 is imaginary
    x[1] = first->im * w;
    x[3] = first->im * f;
    for (int j = 2; j <= k + 1; j++, re += STRIDE, im += STRIDE) {
        VEC ur = VEC_(get)(re), ui = VEC_(get)(im);
        x[4] = VEC_(fma)(ur, w, x[4]);
        x[5] = VEC_(fma)(ui, w, x[5]);
        x[6] = VEC_(fma)(ur, f, x[6]);
        x[7] = VEC_(fma)(ui, f, x[7]);
        rate -= STRIDE, force -= STRIDE;
        w = VEC_(get)(rate), f = VEC_(get)(force);
        x[0] = VEC_(fma)(ur, w, x[0]);
        x[1] = VEC_(fma)(ui, w, x[1]);
        x[2] = VEC_(fma)(ur, f, x[2]);
        x[3] = VEC_(fma)(ui, f, x[3]);
    }
    *now = (struct SMALL(order)){x[0], x[1], x[2], x[3]};
    *next = (struct SMALL(order)){x[4], x[5], x[6], x[7]};
}

/* the terms of order k + 1 that the coefficients of order k are needed for */
LANES_INLINE void SMALL(complete)(const struct SMALL(order) * first, const struct SMALL(order) * newest,
                                  struct SMALL(order) * known) {
    known->re = VEC_(fma)(newest->re, first->rate, known->re);
    known->im = VEC_(fma)(newest->im, first->rate, VEC_(fma)(first->im, newest->rate, known->im));
    known->force = VEC_(fma)(first->im, newest->force, known->force);
}

/* the coefficients of order k from the known parts; lift and drop are gravity's, of the root */
LANES_INLINE void SMALL(solve)(const struct jets_system *s, const struct SMALL(columns) * columns, int k, VEC lift,
                               VEC drop, const struct SMALL(order) * known, struct SMALL(order) * newest) {
    double pull[LANES] __attribute__((aligned(64))), side[LANES] __attribute__((aligned(64)));
    VEC_(put)(pull, known->im - lift);
    VEC_(put)(side, known->force * s->share[k]);
    // by reciprocity the answer of arm i to W_j is that of arm j to W_i, and acceleration to W is force to s;
    // rate is (phi''_k + (k + 1) T) / (k + 1), force (lambda_k + c) / (k + 1)
    VEC zero = VEC_(of)(0), rate[2] = {-drop, zero}, force[2] = {zero, zero};
    for (int j = 0; j < LANES; j++) {
        VEC W = VEC_(of)(pull[j]), S = VEC_(of)(side[j]);
        rate[0] = VEC_(fma)(W, columns->force_side[j], rate[0]);
        rate[1] = VEC_(fma)(S, columns->acc_side[j], rate[1]);
        force[0] = VEC_(fma)(W, columns->force_pull[j], force[0]);
        force[1] = VEC_(fma)(S, columns->acc_pull[j], force[1]);
    }
    VEC turned = rate[0] + rate[1];
    newest->rate = turned - known->re;
    newest->force = VEC_(fma)(VEC_(of)(k + 1), force[0] + force[1], -known->rate);
    newest->re = -s->share[k + 1] * known->im;
    newest->im = s->share[k + 1] * turned;
}

LANES_INLINE void SMALL(keep)(const struct jets_system *s, int k, const struct SMALL(order) * x) {
    enum { STRIDE = 8 };
    VEC_(put)(s->rate + (k + 1) * STRIDE, x->rate);
    VEC_(put)(s->force + k * STRIDE, x->force);
    VEC_(put)(s->turn_re + (k + 2) * STRIDE, x->re);
    VEC_(put)(s->turn_im + (k + 2) * STRIDE, x->im);
}

static void SMALL(orders)(const struct jets_system *s, double gravity, int order) {
    enum { STRIDE = 8 };
    struct SMALL(node) node[LANES];
    struct SMALL(columns) columns = {0};
    SMALL(up)(s, node);
    SMALL(down)(s, node, &columns);
    SMALL(scale)(s, &columns);
    VEC zero = VEC_(of)(0), lift = zero, drop = zero;
    struct SMALL(order) first = {zero, VEC_(get)(s->rate), VEC_(get)(s->rate), zero}, newest = first;
    VEC_(put)(s->turn_re, VEC_(of)(1));
    VEC_(put)(s->turn_im, zero);
    VEC_(put)(s->turn_re + STRIDE, first.re);
    VEC_(put)(s->turn_im + STRIDE, first.im);
    // gravity is a pull on the root
    lift[0] = s->sine[0] * gravity * s->inv_len[0];
    drop[0] = s->cosine[0] * gravity * s->inv_len[0];
    for (int k = 0; k < order; k += 2) {
        struct SMALL(order) now, next;
        SMALL(known)(s, k, &first, &newest, &now, &next);
        SMALL(solve)(s, &columns, k, k ? zero : lift, k ? zero : drop, &now, &newest);
        SMALL(keep)(s, k, &newest);
        if (k + 1 == order) break;
        SMALL(complete)(&first, &newest, &next);
        SMALL(solve)(s, &columns, k + 1, zero, zero, &next, &newest);
        SMALL(keep)(s, k + 1, &newest);
    }
}

#else

/* re and im of a series side by side, and what is multiplied with both of them twice */
#if LANES == 2
#define BOTH lanes4
#define BOTH_(name) lanes4_##name
#define BOTH_LANE(i) i, i, i, i
#define BOTH_LOW 0, 1, 0, 1
#define BOTH_HIGH 2, 3, 2, 3
#define BOTH_JOIN 0, 1, 6, 7
#define VEC_TWICE 0, 1, 0, 1
#else
#define BOTH lanes8
#define BOTH_(name) lanes8_##name
#define BOTH_LANE(i) i, i, i, i, i, i, i, i
#define BOTH_LOW 0, 1, 2, 3, 0, 1, 2, 3
#define BOTH_HIGH 4, 5, 6, 7, 4, 5, 6, 7
#define BOTH_JOIN 0, 1, 2, 3, 12, 13, 14, 15
#define VEC_TWICE 0, 1, 2, 3, 0, 1, 2, 3
#endif

LANES_INLINE BOTH SMALL(twice)(VEC x) { return __builtin_shufflevector(x, x, VEC_TWICE); }

/* the columns, twice side by side; those of the force across bear 1 */
struct SMALL(twins) {
    BOTH rate_pull[LANES], rate_side[LANES], force_pull[LANES], force_side[LANES];
};

/* T and c: real parts in the lower half, imaginary ones in the upper */
struct SMALL(known) {
    BOTH T, c;
};

/* what an order brings, in registers: u_{k+2}, phi'_{k+1} and lambda_k, the last two twice */
struct SMALL(order) {
    BOTH turn, rate, force;
};

/* T and c of order k less the terms of the orders from k - 1 on, and the same of order k + 1: what is loaded serves
 * both. Two sums each, so that none waits for itself. Row -1 of the forces is zero. */
LANES_INLINE struct SMALL(known) SMALL(known)(const struct jets_system *s, int k, struct SMALL(known) * later) {
    enum { STRIDE = 8 };
    BOTH zero = BOTH_(of)(0);
    struct SMALL(known) now[2] = {{zero, zero}, {zero, zero}}, next[2] = {{zero, zero}, {zero, zero}};
    const double *turn = s->turn_re + 3 * STRIDE, *rate = s->rate + (k - 1) * STRIDE,
                 *force = s->force + (k - 2) * STRIDE;
    for (int j = 3; j < k; j += 2, turn += 2 * STRIDE, rate -= 2 * STRIDE, force -= 2 * STRIDE) {
        BOTH u = BOTH_(get)(turn), v = BOTH_(get)(turn + STRIDE);
        BOTH w = BOTH_(get)(rate - STRIDE), f = BOTH_(get)(force - STRIDE);
        next[0].T = BOTH_(fma)(u, BOTH_(get)(rate), next[0].T);
        next[0].c = BOTH_(fma)(u, BOTH_(get)(force), next[0].c);
        now[0].T = BOTH_(fma)(u, w, now[0].T);
        now[0].c = BOTH_(fma)(u, f, now[0].c);
        next[1].T = BOTH_(fma)(v, w, next[1].T);
        next[1].c = BOTH_(fma)(v, f, next[1].c);
        now[1].T = BOTH_(fma)(v, BOTH_(get)(rate - 2 * STRIDE), now[1].T);
        now[1].c = BOTH_(fma)(v, BOTH_(get)(force - 2 * STRIDE), now[1].c);
    }
    *later = (struct SMALL(known)){next[0].T + next[1].T, next[0].c + next[1].c};
    return (struct SMALL(known)){now[0].T + now[1].T, now[0].c + now[1].c};
}

/* adds to order k, and to the order after, the terms that order k - 1 is needed for */
LANES_INLINE void SMALL(join)(const struct jets_system *s, int k, BOTH first, const struct SMALL(order) * newest,
                              struct SMALL(known) * now, struct SMALL(known) * later) {
    enum { STRIDE = 8 };
    if (k) {
        BOTH u = BOTH_(get)(s->turn_re + 2 * STRIDE), w = BOTH_(get)(s->rate + (k - 1) * STRIDE);
        BOTH f = BOTH_(get)(s->force + (k - 2) * STRIDE), second = BOTH_(get)(s->rate + STRIDE);
        now->T = BOTH_(fma)(u, w, now->T);
        now->c = BOTH_(fma)(u, f, now->c);
        now->T = BOTH_(fma)(newest->turn, BOTH_(get)(s->rate), now->T);
        later->T = BOTH_(fma)(u, newest->rate, BOTH_(fma)(newest->turn, second, later->T));
        later->c = BOTH_(fma)(u, newest->force, BOTH_(fma)(newest->turn, BOTH_(get)(s->force), later->c));
    }
    now->T = BOTH_(fma)(first, newest->rate, now->T);
    now->c = BOTH_(fma)(first, newest->force, now->c);
}

/* phi''/(k + 1) + T and lambda + c over k + 1, each twice */
struct SMALL(answer) {
    BOTH turned, force;
};

/* what the tree answers to T and to c / (k + 1) */
LANES_INLINE struct SMALL(answer) SMALL(solve)(const struct SMALL(twins) * twins, BOTH T, BOTH c, BOTH start) {
    BOTH zero = BOTH_(of)(0), turned[2] = {start, zero}, force[2] = {zero, zero};
#define SMALL_TERM(j)                                                                                                  \
    do {                                                                                                               \
        BOTH pull = __builtin_shufflevector(T, T, BOTH_LANE(LANES + (j)));                                             \
        BOTH side = __builtin_shufflevector(c, c, BOTH_LANE(LANES + (j)));                                             \
        turned[0] = BOTH_(fma)(pull, twins->rate_pull[j], turned[0]);                                                  \
        turned[1] = BOTH_(fma)(side, twins->rate_side[j], turned[1]);                                                  \
        force[0] = BOTH_(fma)(pull, twins->force_pull[j], force[0]);                                                   \
        force[1] = BOTH_(fma)(side, twins->force_side[j], force[1]);                                                   \
    } while (0)
    SMALL_TERM(0);
    SMALL_TERM(1);
#if LANES > 2
    SMALL_TERM(2);
    SMALL_TERM(3);
#endif
#undef SMALL_TERM
    return (struct SMALL(answer)){turned[0] + turned[1], force[0] + force[1]};
}

/* the coefficients of order k, T whole and c over k + 1 */
LANES_INLINE struct SMALL(order) SMALL(keep)(const struct jets_system *s, int k, const struct SMALL(known) * known,
                                             const struct SMALL(answer) * answer) {
    enum { STRIDE = 8 };
    BOTH Tr = __builtin_shufflevector(known->T, known->T, BOTH_LOW);
    BOTH Ti = __builtin_shufflevector(known->T, known->T, BOTH_HIGH);
    BOTH cr = __builtin_shufflevector(known->c, known->c, BOTH_LOW);
    BOTH turn = __builtin_shufflevector(-Ti, answer->turned, BOTH_JOIN), order = BOTH_(of)(k + 1);
    struct SMALL(order)
        newest = {turn * s->share[k + 1], answer->turned - Tr, BOTH_(fma)(answer->force, order, -cr * order)};
    BOTH_(put)(s->rate + (k + 1) * STRIDE, newest.rate);
    BOTH_(put)(s->force + k * STRIDE, newest.force);
    BOTH_(put)(s->turn_re + (k + 2) * STRIDE, newest.turn);
    return newest;
}

/*
 * Adds to T and c of order k + 1 what order k brings; the way from the answer of one order to the next is but one
 * multiply-add long. u_1 is i phi'_0, and u_{k+2} = i (turned + i Im T) / (k + 2).
 */
LANES_INLINE struct SMALL(known)
    SMALL(complete)(const struct jets_system *s, int k, BOTH first, const struct SMALL(known) * known,
                    const struct SMALL(answer) * answer, const struct SMALL(known) * later) {
    BOTH zero = BOTH_(of)(0), share = BOTH_(of)(s->share[k + 1]);
    BOTH Tr = __builtin_shufflevector(known->T, known->T, BOTH_LOW),
         cr = __builtin_shufflevector(known->c, known->c, BOTH_LOW);
    BOTH Ti = __builtin_shufflevector(known->T, known->T, BOTH_HIGH);
    BOTH high = __builtin_shufflevector(zero, first, BOTH_JOIN), low = first - high;
    BOTH ready = BOTH_(fma)(-high, Tr, later->T) - low * Ti * share;
    BOTH scaled = later->c * share, lift = high * (share * (double)(k + 1));
    return (struct SMALL(known)){BOTH_(fma)(answer->turned, high + high * share, ready),
                                 BOTH_(fma)(answer->force, lift, BOTH_(fma)(-lift, cr, scaled))};
}

static void SMALL(orders)(const struct jets_system *s, double gravity, int order) {
    enum { STRIDE = 8 };
    struct SMALL(node) node[LANES];
    struct SMALL(columns) columns = {0};
    struct SMALL(twins) twins;
    SMALL(up)(s, node);
    SMALL(down)(s, node, &columns);
    SMALL(scale)(s, &columns);
    // by reciprocity the answer of arm i to W_j is that of arm j to W_i, and acceleration to W is force to s
    for (int j = 0; j < LANES; j++) {
        twins.rate_pull[j] = SMALL(twice)(columns.force_side[j]);
        twins.rate_side[j] = SMALL(twice)(columns.acc_side[j]);
        twins.force_pull[j] = SMALL(twice)(columns.force_pull[j]);
        twins.force_side[j] = SMALL(twice)(columns.acc_pull[j]);
    }
    BOTH zero = BOTH_(of)(0), first = SMALL(twice)(VEC_(get)(s->rate)), drop = zero;
    BOTH_(put)(s->rate, first);
    // gravity is a pull on the root
    drop[0] = drop[LANES] = -s->cosine[0] * gravity * s->inv_len[0];
    BOTH lift = zero;
    lift[LANES] = s->sine[0] * gravity * s->inv_len[0];
    BOTH turn = __builtin_shufflevector(zero, first, BOTH_JOIN);
    struct SMALL(order) newest = {turn, first, zero};
    BOTH_(put)(s->turn_re + STRIDE, turn);
    for (int k = 0; k < order; k += 2) {
        struct SMALL(known) later, known = SMALL(known)(s, k, &later);
        SMALL(join)(s, k, turn, &newest, &known, &later);
        known.c *= s->share[k];
        struct SMALL(answer) answer = SMALL(solve)(&twins, k ? known.T : known.T - lift, known.c, k ? zero : drop);
        newest = SMALL(keep)(s, k, &known, &answer);
        if (k + 1 == order) break;
        known = SMALL(complete)(s, k, first, &known, &answer, &later);
        answer = SMALL(solve)(&twins, known.T, known.c, zero);
        newest = SMALL(keep)(s, k + 1, &known, &answer);
    }
}

#undef BOTH
#undef BOTH_
#undef BOTH_LANE
#undef BOTH_LOW
#undef BOTH_HIGH
#undef BOTH_JOIN
#undef VEC_TWICE

#endif

#undef SMALL_PASTE2
#undef SMALL_PASTE
#undef SMALL
#undef VEC
#undef VEC_
#undef LANES

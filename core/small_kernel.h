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

#if LANES == 2
/* two arms, one on the other: what the sweeps come to, with one division */
LANES_INLINE void small_double(const struct jets_system *s, struct small2_columns *columns) {
    double m0 = s->mass[0], m1 = s->mass[1], C = s->cosine[1], Z = s->sine[1], light = 1 / m1;
    double hung = m1 * Z, inv = 1 / lanes1_fma(hung, Z, m0), share = inv * m0, lean = inv * hung * C;
    columns->acc_pull[0] = (lanes2){lean, inv * hung};
    columns->acc_side[0] = (lanes2){inv, -inv * C};
    columns->acc_pull[1] = (lanes2){-lanes1_fma(C, lean, Z), -lean};
    columns->acc_side[1] = (lanes2){-inv * C, lanes1_fma(C, inv * C, light)};
    columns->force_pull[0] = (lanes2){-share * (m0 + m1), -share * m1 * C};
    columns->force_side[0] = (lanes2){lean, -lanes1_fma(C, lean, Z)};
    columns->force_pull[1] = (lanes2){-share * m1 * C, -share * m1};
    columns->force_side[1] = (lanes2){inv * hung, -lean};
}
#endif

/* the inverse of the tree system */
LANES_INLINE void SMALL(invert)(const struct jets_system *s, struct SMALL(columns) * columns) {
    struct SMALL(node) node[LANES];
#if LANES == 2
    if (s->n == 2) {
        small_double(s, columns);
        SMALL(scale)(s, columns);
        return;
    }
#endif
    jets_factor(s);
    *columns = (struct SMALL(columns)){0};
    SMALL(up)(s, node);
    SMALL(down)(s, node, columns);
    SMALL(scale)(s, columns);
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
    struct SMALL(columns) columns;
    SMALL(invert)(s, &columns);
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

/* re and im of a series side by side, and what is multiplied with both of them twice: one vector where the registers
 * are as wide, else two */
#if LANES == 2 ? defined(__AVX2__) : defined(__AVX512F__)
#if LANES == 2
#define BOTH lanes4
#define BOTH_(name) lanes4_##name
#define BOTH_LANE(i) i, i, i, i
#define BOTH_LOW 0, 1, 0, 1
#define BOTH_HIGH 2, 3, 2, 3
#define BOTH_JOIN 0, 1, 6, 7
#else
#define BOTH lanes8
#define BOTH_(name) lanes8_##name
#define BOTH_LANE(i) i, i, i, i, i, i, i, i
#define BOTH_LOW 0, 1, 2, 3, 0, 1, 2, 3
#define BOTH_HIGH 4, 5, 6, 7, 4, 5, 6, 7
#define BOTH_JOIN 0, 1, 2, 3, 12, 13, 14, 15
#endif
LANES_INLINE BOTH SMALL(twice)(VEC x) { return __builtin_shufflevector(x, x, BOTH_LOW); }
LANES_INLINE BOTH SMALL(of)(double x) { return BOTH_(of)(x); }
LANES_INLINE BOTH SMALL(get)(const double *at) { return BOTH_(get)(at); }
LANES_INLINE void SMALL(put)(double *at, BOTH x) { BOTH_(put)(at, x); }
LANES_INLINE BOTH SMALL(fma)(BOTH x, BOTH y, BOTH z) { return BOTH_(fma)(x, y, z); }
LANES_INLINE BOTH SMALL(add)(BOTH x, BOTH y) { return x + y; }
LANES_INLINE BOTH SMALL(sub)(BOTH x, BOTH y) { return x - y; }
LANES_INLINE BOTH SMALL(mul)(BOTH x, BOTH y) { return x * y; }
LANES_INLINE BOTH SMALL(neg)(BOTH x) { return -x; }
LANES_INLINE BOTH SMALL(low)(BOTH x) { return __builtin_shufflevector(x, x, BOTH_LOW); }
LANES_INLINE BOTH SMALL(high)(BOTH x) { return __builtin_shufflevector(x, x, BOTH_HIGH); }
LANES_INLINE BOTH SMALL(join)(BOTH low, BOTH high) { return __builtin_shufflevector(low, high, BOTH_JOIN); }
#define BOTH_BEAM(x, j) __builtin_shufflevector(x, x, BOTH_LANE(LANES + (j)))
#else
struct SMALL(both) {
    VEC low, high;
};
#define BOTH struct SMALL(both)
LANES_INLINE BOTH SMALL(twice)(VEC x) { return (BOTH){x, x}; }
LANES_INLINE BOTH SMALL(of)(double x) { return SMALL(twice)(VEC_(of)(x)); }
LANES_INLINE BOTH SMALL(get)(const double *at) { return (BOTH){VEC_(get)(at), VEC_(get)(at + LANES)}; }
LANES_INLINE void SMALL(put)(double *at, BOTH x) {
    VEC_(put)(at, x.low);
    VEC_(put)(at + LANES, x.high);
}
LANES_INLINE BOTH SMALL(fma)(BOTH x, BOTH y, BOTH z) {
    return (BOTH){VEC_(fma)(x.low, y.low, z.low), VEC_(fma)(x.high, y.high, z.high)};
}
LANES_INLINE BOTH SMALL(add)(BOTH x, BOTH y) { return (BOTH){x.low + y.low, x.high + y.high}; }
LANES_INLINE BOTH SMALL(sub)(BOTH x, BOTH y) { return (BOTH){x.low - y.low, x.high - y.high}; }
LANES_INLINE BOTH SMALL(mul)(BOTH x, BOTH y) { return (BOTH){x.low * y.low, x.high * y.high}; }
LANES_INLINE BOTH SMALL(neg)(BOTH x) { return (BOTH){-x.low, -x.high}; }
LANES_INLINE BOTH SMALL(low)(BOTH x) { return SMALL(twice)(x.low); }
LANES_INLINE BOTH SMALL(high)(BOTH x) { return SMALL(twice)(x.high); }
LANES_INLINE BOTH SMALL(join)(BOTH low, BOTH high) { return (BOTH){low.low, high.high}; }
#if LANES == 2
#define BOTH_BEAM(x, j) SMALL(twice)(__builtin_shufflevector((x).high, (x).high, j, j))
#else
#define BOTH_BEAM(x, j) SMALL(twice)(__builtin_shufflevector((x).high, (x).high, j, j, j, j))
#endif
#endif

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

/* adds u times a rate and a force */
LANES_INLINE void SMALL(meet)(struct SMALL(known) * sum, BOTH u, BOTH rate, BOTH force) {
    sum->T = SMALL(fma)(u, rate, sum->T);
    sum->c = SMALL(fma)(u, force, sum->c);
}

/* T and c of order k less the terms of the orders from k - 1 on, and the same of order k + 1: what is loaded serves
 * both. Two sums each, so that none waits for itself. Row -1 of the forces is zero. */
LANES_INLINE struct SMALL(known) SMALL(known)(const struct jets_system *s, int k, struct SMALL(known) * later) {
    enum { STRIDE = 8 };
    BOTH zero = SMALL(of)(0);
    struct SMALL(known) now[2] = {{zero, zero}, {zero, zero}}, next[2] = {{zero, zero}, {zero, zero}};
    const double *turn = s->turn_re + 3 * STRIDE, *rate = s->rate + (k - 1) * STRIDE,
                 *force = s->force + (k - 2) * STRIDE;
    for (int j = 3; j < k; j += 2, turn += 2 * STRIDE, rate -= 2 * STRIDE, force -= 2 * STRIDE) {
        BOTH u = SMALL(get)(turn), v = SMALL(get)(turn + STRIDE);
        BOTH w = SMALL(get)(rate - STRIDE), f = SMALL(get)(force - STRIDE);
        SMALL(meet)(&next[0], u, SMALL(get)(rate), SMALL(get)(force));
        SMALL(meet)(&now[0], u, w, f);
        SMALL(meet)(&next[1], v, w, f);
        SMALL(meet)(&now[1], v, SMALL(get)(rate - 2 * STRIDE), SMALL(get)(force - 2 * STRIDE));
    }
    *later = (struct SMALL(known)){SMALL(add)(next[0].T, next[1].T), SMALL(add)(next[0].c, next[1].c)};
    return (struct SMALL(known)){SMALL(add)(now[0].T, now[1].T), SMALL(add)(now[0].c, now[1].c)};
}

/* adds to order k, and to the order after, the terms that order k - 1 is needed for */
LANES_INLINE void SMALL(arrive)(const struct jets_system *s, int k, BOTH first, const struct SMALL(order) * newest,
                                struct SMALL(known) * now, struct SMALL(known) * later) {
    enum { STRIDE = 8 };
    if (k) {
        BOTH u = SMALL(get)(s->turn_re + 2 * STRIDE);
        SMALL(meet)(now, u, SMALL(get)(s->rate + (k - 1) * STRIDE), SMALL(get)(s->force + (k - 2) * STRIDE));
        now->T = SMALL(fma)(newest->turn, SMALL(get)(s->rate), now->T);
        SMALL(meet)(later, newest->turn, SMALL(get)(s->rate + STRIDE), SMALL(get)(s->force));
        SMALL(meet)(later, u, newest->rate, newest->force);
    }
    SMALL(meet)(now, first, newest->rate, newest->force);
}

/* phi''/(k + 1) + T and lambda + c over k + 1, each twice */
struct SMALL(answer) {
    BOTH turned, force;
};

/* what the tree answers to T and to c / (k + 1) */
LANES_INLINE struct SMALL(answer) SMALL(solve)(const struct SMALL(twins) * twins, BOTH T, BOTH c, BOTH start) {
    BOTH zero = SMALL(of)(0), turned[2] = {start, zero}, force[2] = {zero, zero};
#define SMALL_TERM(j)                                                                                                  \
    do {                                                                                                               \
        BOTH pull = BOTH_BEAM(T, j), side = BOTH_BEAM(c, j);                                                           \
        turned[0] = SMALL(fma)(pull, twins->rate_pull[j], turned[0]);                                                  \
        turned[1] = SMALL(fma)(side, twins->rate_side[j], turned[1]);                                                  \
        force[0] = SMALL(fma)(pull, twins->force_pull[j], force[0]);                                                   \
        force[1] = SMALL(fma)(side, twins->force_side[j], force[1]);                                                   \
    } while (0)
    SMALL_TERM(0);
    SMALL_TERM(1);
#if LANES > 2
    SMALL_TERM(2);
    SMALL_TERM(3);
#endif
#undef SMALL_TERM
    return (struct SMALL(answer)){SMALL(add)(turned[0], turned[1]), SMALL(add)(force[0], force[1])};
}

/* the coefficients of order k, T whole and c over k + 1 */
LANES_INLINE struct SMALL(order) SMALL(keep)(const struct jets_system *s, int k, const struct SMALL(known) * known,
                                             const struct SMALL(answer) * answer) {
    enum { STRIDE = 8 };
    BOTH Tr = SMALL(low)(known->T), Ti = SMALL(high)(known->T), cr = SMALL(low)(known->c);
    BOTH turn = SMALL(join)(SMALL(neg)(Ti), answer->turned), order = SMALL(of)(k + 1);
    struct SMALL(order) newest = {SMALL(mul)(turn, SMALL(of)(s->share[k + 1])), SMALL(sub)(answer->turned, Tr),
                                  SMALL(fma)(answer->force, order, SMALL(neg)(SMALL(mul)(cr, order)))};
    SMALL(put)(s->rate + (k + 1) * STRIDE, newest.rate);
    SMALL(put)(s->force + k * STRIDE, newest.force);
    SMALL(put)(s->turn_re + (k + 2) * STRIDE, newest.turn);
    return newest;
}

/*
 * Adds to T and c of order k + 1 what order k brings; the way from the answer of one order to the next is but one
 * multiply-add long. u_1 is i phi'_0, and u_{k+2} = i (turned + i Im T) / (k + 2).
 */
LANES_INLINE struct SMALL(known)
    SMALL(complete)(const struct jets_system *s, int k, BOTH first, const struct SMALL(known) * known,
                    const struct SMALL(answer) * answer, const struct SMALL(known) * later) {
    BOTH share = SMALL(of)(s->share[k + 1]), Tr = SMALL(low)(known->T), cr = SMALL(low)(known->c);
    BOTH high = SMALL(join)(SMALL(of)(0), first), low = SMALL(sub)(first, high);
    BOTH back = SMALL(mul)(SMALL(mul)(low, SMALL(high)(known->T)), share);
    BOTH ready = SMALL(sub)(SMALL(fma)(SMALL(neg)(high), Tr, later->T), back);
    BOTH lift = SMALL(mul)(high, SMALL(of)(s->share[k + 1] * (double)(k + 1)));
    BOTH scaled = SMALL(fma)(SMALL(neg)(lift), cr, SMALL(mul)(later->c, share));
    return (struct SMALL(known)){SMALL(fma)(answer->turned, SMALL(add)(high, SMALL(mul)(high, share)), ready),
                                 SMALL(fma)(answer->force, lift, scaled)};
}

/* gravity's answers and pulls are of the root alone: x in the first lane of each half, or of the upper one */
LANES_INLINE BOTH SMALL(root)(double x) {
    VEC root = {x};
    return SMALL(twice)(root);
}

static void SMALL(orders)(const struct jets_system *s, double gravity, int order) {
    enum { STRIDE = 8 };
    struct SMALL(columns) columns;
    struct SMALL(twins) twins;
    SMALL(invert)(s, &columns);
    // by reciprocity the answer of arm i to W_j is that of arm j to W_i, and acceleration to W is force to s
    for (int j = 0; j < LANES; j++) {
        twins.rate_pull[j] = SMALL(twice)(columns.force_side[j]);
        twins.rate_side[j] = SMALL(twice)(columns.acc_side[j]);
        twins.force_pull[j] = SMALL(twice)(columns.force_pull[j]);
        twins.force_side[j] = SMALL(twice)(columns.acc_pull[j]);
    }
    BOTH zero = SMALL(of)(0), first = SMALL(twice)(VEC_(get)(s->rate)), turn = SMALL(join)(zero, first);
    SMALL(put)(s->rate, first);
    SMALL(put)(s->turn_re + STRIDE, turn);
    // gravity is a pull on the root
    BOTH drop = SMALL(root)(-s->cosine[0] * gravity * s->inv_len[0]);
    BOTH lift = SMALL(join)(zero, SMALL(root)(s->sine[0] * gravity * s->inv_len[0]));
    struct SMALL(order) newest = {turn, first, zero};
    for (int k = 0; k < order; k += 2) {
        struct SMALL(known) later, known = SMALL(known)(s, k, &later);
        SMALL(arrive)(s, k, turn, &newest, &known, &later);
        known.c = SMALL(mul)(known.c, SMALL(of)(s->share[k]));
        BOTH T = k ? known.T : SMALL(sub)(known.T, lift);
        struct SMALL(answer) answer = SMALL(solve)(&twins, T, known.c, k ? zero : drop);
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
#undef BOTH_BEAM

#endif

#undef SMALL_PASTE2
#undef SMALL_PASTE
#undef SMALL
#undef VEC
#undef VEC_
#undef LANES

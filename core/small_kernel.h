/* Series of trees of up to LANES arms, arms in lanes, the tree system of order 0 inverted once a step.
 * Leaves to others: memory and angles (jets). Included once for each number of lanes.
 * Invariant: the inverse is built by the stable sweeps, one unit right-hand side a lane. */
#define SMALL_PASTE2(a, b) a##b
#define SMALL_PASTE(a, b) SMALL_PASTE2(a, b)
#define SMALL(name) SMALL_PASTE(SMALL_PASTE(small, LANES), _##name)
#define VEC SMALL_PASTE(lanes, LANES)
#define VEC_FMA SMALL_PASTE(SMALL_PASTE(lanes, LANES), _fma)

LANES_INLINE VEC SMALL(of)(double x) { return (VEC){0} + x; }

LANES_INLINE VEC SMALL(get)(const double *at) { return *(const VEC *)(const void *)at; }

LANES_INLINE void SMALL(put)(double *at, VEC x) { *(VEC *)(void *)at = x; }

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
        VEC zero = SMALL(of)(0);
        node[k].push_pull = node[k].push_side = node[k].side_pull = node[k].side_side = node[k].sin = zero;
        node[k].early_pull = node[k].early_side = zero;
        node[k].side = SMALL(unit)(k);
    }
    for (int k = s->n - 1; k >= 0; k--) {
        struct SMALL(node) *x = &node[k];
        x->push_side = VEC_FMA(SMALL(of)(s->lean[k]), x->side, x->push_side - x->sin);
        x->bias_pull = x->push_pull - s->eff[k] * SMALL(unit)(k);
        x->bias_side = x->push_side;
        if (!k) break;
        struct SMALL(node) *up = &node[s->parent[k]];
        VEC Z = SMALL(of)(s->sine[k]), C = SMALL(of)(s->cosine[k]), kappa = SMALL(of)(s->kappa[k]);
        x->late_pull = up->side_pull;
        x->late_side = up->side_side;
        up->push_pull = VEC_FMA(kappa, x->bias_pull, up->push_pull);
        up->push_side = VEC_FMA(kappa, x->bias_side, up->push_side);
        up->side_pull = VEC_FMA(Z, x->bias_pull, up->side_pull);
        up->side_side = VEC_FMA(Z, x->bias_side, up->side_side);
        up->sin = VEC_FMA(Z, SMALL(unit)(k), up->sin);
        up->side = up->side - C * SMALL(unit)(k);
    }
}

LANES_INLINE void SMALL(down)(const struct jets_system *s, struct SMALL(node) node[], struct SMALL(columns) *columns) {
    struct SMALL(node) pivot = {0};
    for (int k = 0; k < s->n; k++) {
        struct SMALL(node) *x = &node[k], *up = k ? &node[s->parent[k]] : &pivot;
        VEC Z = SMALL(of)(s->sine[k]), C = SMALL(of)(s->cosine[k]), tau = SMALL(of)(s->tau[k]);
        VEC stiff = SMALL(of)(s->eff[k] * s->kappa[k]), inv_eff = SMALL(of)(s->inv_eff[k]);
        VEC tension_pull = s->nu[k] * x->bias_pull, tension_side = s->nu[k] * x->bias_side;
        if (k) {
            // tension first, the siblings' part leaves k itself out
            tension_pull -= tau * (up->early_pull + x->late_pull);
            tension_side += tau * (up->side - (up->early_side + x->late_side));
            up->early_pull = VEC_FMA(Z, x->bias_pull, up->early_pull);
            up->early_side = VEC_FMA(Z, x->bias_side, up->early_side);
        }
        VEC kappa = SMALL(of)(s->kappa[k]);
        x->radial_pull = VEC_FMA(kappa, up->radial_pull, (tension_pull - x->push_pull) * inv_eff);
        x->radial_side = VEC_FMA(kappa, up->radial_side, (tension_side - x->push_side) * inv_eff);
        x->tangential_pull = -s->inv[k] * VEC_FMA(SMALL(of)(s->sum_r[k]), x->radial_pull, x->side_pull);
        x->tangential_side = s->inv[k] * (x->side - VEC_FMA(SMALL(of)(s->sum_r[k]), x->radial_side, x->side_side));
        columns->force_pull[k] = VEC_FMA(stiff, up->radial_pull, tension_pull);
        columns->force_side[k] = VEC_FMA(stiff, up->radial_side, tension_side);
        columns->acc_pull[k] = x->tangential_pull + Z * up->radial_pull - C * up->tangential_pull;
        columns->acc_side[k] = x->tangential_side + Z * up->radial_side - C * up->tangential_side;
    }
}

/* the known parts of order k: T and c, as sums of two halves so that the additions overlap */
LANES_INLINE void SMALL(known)(const struct jets_system *s, int k, VEC *Tr, VEC *Ti, VEC *cr, VEC *ci) {
    enum { STRIDE = 8 };
    VEC T[4], c[4];
    for (int i = 0; i < 4; i++) T[i] = c[i] = SMALL(of)(0);
    // the newest coefficients, which are waited for, come last: j = 1 and j = k + 1
    const double *re = s->turn_re + 2 * STRIDE, *im = s->turn_im + 2 * STRIDE;
    const double *rate = s->rate + (k - 1) * STRIDE, *force = s->force + (k - 2) * STRIDE;
    int j = 2;
    for (; j < k; j += 2) {
        for (int i = 0; i < 2; i++) {
            VEC ur = SMALL(get)(re), ui = SMALL(get)(im), w = SMALL(get)(rate), f = SMALL(get)(force);
            T[2 * i] = VEC_FMA(ur, w, T[2 * i]);
            T[2 * i + 1] = VEC_FMA(ui, w, T[2 * i + 1]);
            c[2 * i] = VEC_FMA(ur, f, c[2 * i]);
            c[2 * i + 1] = VEC_FMA(ui, f, c[2 * i + 1]);
            re += STRIDE, im += STRIDE, rate -= STRIDE, force -= STRIDE;
        }
    }
    if (j == k) {
        VEC ur = SMALL(get)(re), ui = SMALL(get)(im), w = SMALL(get)(rate), f = SMALL(get)(force);
        T[0] = VEC_FMA(ur, w, T[0]);
        T[1] = VEC_FMA(ui, w, T[1]);
        c[0] = VEC_FMA(ur, f, c[0]);
        c[1] = VEC_FMA(ui, f, c[1]);
    }
    for (int i = 0; i < 2; i++) T[i] += T[i + 2], c[i] += c[i + 2];
    if (k) {
        // u_1 is imaginary
        VEC ui = SMALL(get)(s->turn_im + STRIDE);
        T[1] = VEC_FMA(ui, SMALL(get)(s->rate + k * STRIDE), T[1]);
        c[1] = VEC_FMA(ui, SMALL(get)(s->force + (k - 1) * STRIDE), c[1]);
    }
    VEC w = SMALL(get)(s->rate);
    *Tr = VEC_FMA(SMALL(get)(s->turn_re + (k + 1) * STRIDE), w, T[0]);
    *Ti = VEC_FMA(SMALL(get)(s->turn_im + (k + 1) * STRIDE), w, T[1]);
    *cr = c[0];
    *ci = c[1];
}

static void SMALL(orders)(const struct jets_system *s, double gravity, int order) {
    enum { STRIDE = 8 };
    struct SMALL(node) node[LANES];
    struct SMALL(columns) columns;
    SMALL(up)(s, node);
    SMALL(down)(s, node, &columns);
    VEC len = SMALL(get)(s->len), inv_len = SMALL(get)(s->inv_len), zero = SMALL(of)(0);
    // by reciprocity: the answer of arm i to W_j is that of arm j to W_i, and acceleration to W is force to s
    for (int j = 0; j < s->n; j++) {
        columns.acc_side[j] *= inv_len;
        columns.force_side[j] *= inv_len;
    }
    SMALL(put)(s->turn_re, SMALL(of)(1));
    SMALL(put)(s->turn_im, zero);
    SMALL(put)(s->turn_re + STRIDE, zero);
    SMALL(put)(s->turn_im + STRIDE, SMALL(get)(s->rate));
    VEC lift = zero, drop = zero;
    lift[0] = s->sine[0] * gravity;
    drop[0] = s->cosine[0] * gravity * s->inv_len[0];
    for (int k = 0; k < order; k++) {
        double share = s->share[k], turn_share = s->share[k + 1];
        VEC Tr, Ti, cr, ci;
        SMALL(known)(s, k, &Tr, &Ti, &cr, &ci);
        // phi''_k / (k + 1) and (lambda_k + c_r) / (k + 1); gravity is a pull on the root
        VEC pull = len * Ti - lift, side = ci * share;
        VEC rate[2] = {-Tr - drop, zero}, force[2] = {zero, zero};
        for (int j = 0; j < s->n; j++) {
            VEC W = SMALL(of)(pull[j]), S = SMALL(of)(side[j]);
            rate[0] = VEC_FMA(W, columns.force_side[j], rate[0]);
            rate[1] = VEC_FMA(S, columns.acc_side[j], rate[1]);
            force[0] = VEC_FMA(W, columns.force_pull[j], force[0]);
            force[1] = VEC_FMA(S, columns.acc_pull[j], force[1]);
        }
        VEC next = rate[0] + rate[1];
        SMALL(put)(s->rate + (k + 1) * STRIDE, next);
        SMALL(put)(s->force + k * STRIDE, VEC_FMA(SMALL(of)(k + 1), force[0] + force[1], -cr));
        SMALL(put)(s->turn_re + (k + 2) * STRIDE, -turn_share * Ti);
        SMALL(put)(s->turn_im + (k + 2) * STRIDE, turn_share * (next + Tr));
        lift = drop = zero;
    }
}

#undef SMALL_PASTE2
#undef SMALL_PASTE
#undef SMALL
#undef VEC
#undef VEC_FMA
#undef LANES

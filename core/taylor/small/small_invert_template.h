/* The inverse of the tree system of order 0 of a tree of up to LANES arms: the response of every
 * arm to a unit of every right-hand side. Leaves to others: the orders that multiply by it
 * (small_template, which includes this file once for each number of lanes). Invariant: built by the
 * stable sweeps, one unit right-hand side per lane. */

/* responses of arm j to a unit of inward pull W_i (first) or of force s_i across arm i (second) in
 * lane i: the force along arm j and the acceleration across it. By reciprocity these rows are the
 * columns that the orders need. */
struct SMALL(columns) {
    struct SMALL(arms) force_pull[LANES], force_side[LANES], acc_pull[LANES], acc_side[LANES];
};

/* sums over the children of an arm, and results of the sweep up, for the unit right-hand sides in
 * one vector */
struct SMALL(node) {
    VEC push_pull, push_side, side_pull, side_side, sin,
        side; /* sums of the sweep up; `side` is the known force across the arm */
    VEC bias_pull, bias_side, late_pull, late_side, early_pull, early_side;
    VEC radial_pull, radial_side, tangential_pull, tangential_side;
};

VEC_INLINE void SMALL(up)(const struct jets_system *s, int span, struct SMALL(node) node[]) {
    for (int k = 0; k < s->n; k++) {
        VEC zero = VEC_(of)(0);
        node[k].push_pull = node[k].push_side = node[k].side_pull = node[k].side_side =
            node[k].sin = zero;
        node[k].early_pull = node[k].early_side = zero;
        node[k].side = SMALL(unit)(k, span);
    }
    for (int k = s->n - 1; k >= 0; k--) {
        struct SMALL(node) *x = &node[k];
        x->push_side = VEC_(fma)(VEC_(of)(s->lean[k]), x->side, x->push_side - x->sin);
        x->bias_pull = x->push_pull - s->eff[k] * SMALL(unit)(k, span);
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
        up->sin = VEC_(fma)(Z, SMALL(unit)(k, span), up->sin);
        up->side = up->side - C * SMALL(unit)(k, span);
    }
}

VEC_INLINE void SMALL(down)(const struct jets_system *s, int span, struct SMALL(node) node[],
                            struct SMALL(columns) * columns) {
    struct SMALL(node) pivot = {0};
    for (int k = 0; k < s->n; k++) {
        struct SMALL(node) *x = &node[k], *up = k ? &node[s->parent[k]] : &pivot;
        VEC Z = VEC_(of)(s->sine[k]), C = VEC_(of)(s->cosine[k]), tau = VEC_(of)(s->tau[k]);
        VEC stiff = VEC_(of)(s->eff[k] * s->kappa[k]), inv_eff = VEC_(of)(s->inv_eff[k]);
        VEC tension_pull = s->nu[k] * x->bias_pull, tension_side = s->nu[k] * x->bias_side;
        if (k) {
            // tension is solved first; the sum over the siblings excludes k itself
            tension_pull -= tau * (up->early_pull + x->late_pull);
            tension_side += tau * (up->side - (up->early_side + x->late_side));
            up->early_pull = VEC_(fma)(Z, x->bias_pull, up->early_pull);
            up->early_side = VEC_(fma)(Z, x->bias_side, up->early_side);
        }
        VEC kappa = VEC_(of)(s->kappa[k]);
        x->radial_pull = VEC_(fma)(kappa, up->radial_pull, (tension_pull - x->push_pull) * inv_eff);
        x->radial_side = VEC_(fma)(kappa, up->radial_side, (tension_side - x->push_side) * inv_eff);
        x->tangential_pull =
            -s->inv[k] * VEC_(fma)(VEC_(of)(s->sum_r[k]), x->radial_pull, x->side_pull);
        x->tangential_side =
            s->inv[k] * (x->side - VEC_(fma)(VEC_(of)(s->sum_r[k]), x->radial_side, x->side_side));
        columns->force_pull[k].span[span] = VEC_(fma)(stiff, up->radial_pull, tension_pull);
        columns->force_side[k].span[span] = VEC_(fma)(stiff, up->radial_side, tension_side);
        columns->acc_pull[k].span[span] =
            x->tangential_pull + Z * up->radial_pull - C * up->tangential_pull;
        columns->acc_side[k].span[span] =
            x->tangential_side + Z * up->radial_side - C * up->tangential_side;
    }
}

/* converts the columns to units of the orders: pulls are l T, accelerations those of angles */
VEC_INLINE void SMALL(scale)(const struct jets_system *s, struct SMALL(columns) * columns) {
    for (int span = 0; span < SPANS; span++) {
        VEC inv_len = VEC_(get)(s->inv_len + span * VEC_WIDTH);
        for (int j = 0; j < s->n; j++) {
            VEC len = VEC_(of)(s->len[j]);
            columns->acc_side[j].span[span] *= inv_len;
            columns->force_side[j].span[span] *= inv_len * len;
            columns->force_pull[j].span[span] *= len;
        }
    }
}

#if LANES == 2
/* two arms in a chain: the result of the sweeps in closed form, with one division */
VEC_INLINE void small_double(const struct jets_system *s, struct small2_columns *columns) {
    double m0 = s->mass[0], m1 = s->mass[1], C = s->cosine[1], Z = s->sine[1], light = 1 / m1;
    double hung = m1 * Z, inv = 1 / lanes1_fma(hung, Z, m0), share = inv * m0,
           lean = inv * hung * C;
    columns->acc_pull[0].span[0] = (lanes2){lean, inv * hung};
    columns->acc_side[0].span[0] = (lanes2){inv, -inv * C};
    columns->acc_pull[1].span[0] = (lanes2){-lanes1_fma(C, lean, Z), -lean};
    columns->acc_side[1].span[0] = (lanes2){-inv * C, lanes1_fma(C, inv * C, light)};
    columns->force_pull[0].span[0] = (lanes2){-share * (m0 + m1), -share * m1 * C};
    columns->force_side[0].span[0] = (lanes2){lean, -lanes1_fma(C, lean, Z)};
    columns->force_pull[1].span[0] = (lanes2){-share * m1 * C, -share * m1};
    columns->force_side[1].span[0] = (lanes2){inv * hung, -lean};
}
#endif

/* the inverse of the tree system */
VEC_INLINE void SMALL(invert)(const struct jets_system *s, struct SMALL(columns) * columns) {
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
    for (int span = 0; span < SPANS && span * VEC_WIDTH < s->n; span++) {
        SMALL(up)(s, span, node);
        SMALL(down)(s, span, node, columns);
    }
    SMALL(scale)(s, columns);
}

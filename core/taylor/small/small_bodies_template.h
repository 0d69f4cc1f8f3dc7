/* The tree system of order 0 of a real pendulum of up to LANES bodies: the response of every arm to
 * a unit of every right-hand side, and the forces at the arms' ends. Leaves to others: its
 * factorization (bodies_factor_template, whose sweeps these are, several right-hand sides side by
 * side), the orders that multiply by it (small_loads_template). Included once for each number of
 * lanes.
 * Invariant: for any bodies and attachment points, an order costs two multiply-adds more than one
 * with torques between point masses.
 *
 * With G of bodies_template, F = G / l takes the place of the force at the tip of point masses:
 *     Im F_k = (tau_k - I phi''_k) / l - sum_{j>=1} (Re u_j Im F_{k-j} - Im u_j Re F_{k-j}),
 * and Re F_k, like phi'', is the tree's response to Im T and to torques. By reciprocity the
 * responses of an arm to units at all others equal those of the others to its own unit, up to
 * signs: with rho = Re G + I kr, d rho_i / d tau_j = -d chi_j / d kr_i, and d rho / d kr is
 * symmetric. */

/* right-hand sides, one per lane: kr and known moments about the joints, per arm; the pivot's
 * acceleration */
struct SMALL(asked) {
    PART pulled[LANES], moment[LANES], lift_x, lift_y;
};

/* responses: chi, Re G and the forces at the tips of the arms; the force at the first joint except
 * the part due to the pivot's acceleration */
struct SMALL(told) {
    PART chi[LANES], push[LANES], tip_x[LANES], tip_y[LANES], root_x, root_y;
};

/* results of the sweep from leaves to root: the forces on the bases; the moments over D; and the
 * moments on the parent before the arm's own is added, which include those of later siblings */
struct SMALL(climb) {
    PART x[LANES], y[LANES], answer[LANES], early[LANES];
};

/* adds to `moment` that of the force (x, y) of arm c on its parent */
VEC_INLINE PART SMALL(moment)(const struct bodies_system *b, int c, PART x, PART y, PART moment) {
    moment = PART_(fma)(PART_(of)(b->place_y[c]), x, moment);
    return PART_(fma)(PART_(of)(-b->place_x[c]), y, moment);
}

VEC_INLINE void SMALL(climb)(const struct bodies_system *b, const struct SMALL(asked) * asked,
                             struct SMALL(climb) * up) {
    int last = 0;
    do {
        PART kr = asked->pulled[last], m = asked->moment[last];
        up->x[last] = PART_(fma)(PART_(of)(b->lever_x[last]), m, b->draw_x[last] * kr);
        up->y[last] = PART_(fma)(PART_(of)(b->lever_y[last]), m, b->draw_y[last] * kr);
        up->answer[last] = up->early[last] = m;
    } while (++last < b->n);
    for (int c = b->n - 1; c > 0; c--) {
        int p = b->parent[c];
        PART ax = up->x[c], ay = up->y[c];
        PART x = PART_(fma)(PART_(of)(b->carry_xx[c]), ax, up->x[p]);
        PART y = PART_(fma)(PART_(of)(b->carry_xy[c]), ax, up->y[p]);
        up->early[c] = up->answer[p];
        up->x[p] = PART_(fma)(PART_(of)(b->carry_yx[c]), ay, x);
        up->y[p] = PART_(fma)(PART_(of)(b->carry_yy[c]), ay, y);
        up->answer[p] = SMALL(moment)(b, c, ax, ay, up->answer[p]);
    }
    for (int a = 0; a < b->n; a++) {
        PART m = up->answer[a] - b->twist[a] * asked->pulled[a];
        up->answer[a] = m * PART_(of)(b->inv_total[a]);
    }
}

/* values of the sweep from root to leaves: the base of each arm; the moments on each parent from
 * the children visited so far; the force at the current joint */
struct SMALL(joint) {
    PART base_x[LANES], base_y[LANES], late[LANES], x, y;
};

VEC_INLINE void SMALL(pull)(const struct bodies_system *b, int a, PART kr,
                            const struct SMALL(climb) * up, struct SMALL(joint) * j) {
    int p = b->parent[a];
    PART bx = j->base_x[p], by = j->base_y[p], chi = up->answer[p], m = up->early[a] + j->late[p];
    PART px = PART_(of)(b->place_x[a]), py = PART_(of)(b->place_y[a]);
    PART x = px * kr - py * chi, y = PART_(fma)(py, kr, px * chi);
    x = PART_(fma)(PART_(of)(b->carry_xx[a]), bx, x);
    y = PART_(fma)(PART_(of)(b->carry_yx[a]), bx, y);
    j->base_x[a] = PART_(fma)(PART_(of)(b->carry_xy[a]), by, x);
    j->base_y[a] = PART_(fma)(PART_(of)(b->carry_yy[a]), by, y);
    PART ax = up->x[a], ay = up->y[a];
    if (b->need & BODIES_SHAPE) {
        PART xy = PART_(of)(b->form_xy[a]);
        bx = j->base_x[a], by = j->base_y[a];
        j->x = PART_(fma)(PART_(of)(b->form_xx[a]), bx, PART_(fma)(xy, by, ax));
        j->y = PART_(fma)(xy, bx, PART_(fma)(PART_(of)(b->form_yy[a]), by, ay));
        return;
    }
    x = PART_(fma)(PART_(of)(b->sway_xx[a]), bx, b->sway_xy[a] * by);
    y = PART_(fma)(PART_(of)(b->sway_yx[a]), bx, b->sway_yy[a] * by);
    x = PART_(fma)(PART_(of)(b->keep_xx[a]), ax, PART_(fma)(PART_(of)(b->keep_xy[a]), ay, x));
    y = PART_(fma)(PART_(of)(b->keep_yx[a]), ax, PART_(fma)(PART_(of)(b->keep_yy[a]), ay, y));
    j->x = x + PART_(fma)(PART_(of)(b->swing_x[a]), kr, b->turn_x[a] * m);
    j->y = y + PART_(fma)(PART_(of)(b->swing_y[a]), kr, b->turn_y[a] * m);
    j->late[p] = SMALL(moment)(b, a, ax, ay, j->late[p]);
}

/* computes the force at the tip of arm a without its children's contributions, and adds the arm's
 * contribution to the force at its parent's tip */
VEC_INLINE void SMALL(tip)(const struct bodies_system *b, int a, PART kr,
                           const struct SMALL(joint) * j, struct SMALL(told) * to) {
    PART m = PART_(of)(b->mass[a]), l = PART_(of)(b->len[a]);
    to->tip_x[a] = j->x, to->tip_y[a] = j->y;
    if (!(b->need & BODIES_SHAPE)) return;
    to->tip_x[a] = m * PART_(fma)(l, kr, j->base_x[a]);
    to->tip_y[a] = m * PART_(fma)(l, to->chi[a], j->base_y[a]);
    if (!a || bodies_hung(b, a)) return;
    int p = b->parent[a];
    PART C = PART_(of)(b->cosine[a]), Z = PART_(of)(b->sine[a]);
    to->tip_x[p] += C * j->x - Z * j->y;
    to->tip_y[p] += PART_(fma)(Z, j->x, C * j->y);
}

/* root to leaves: accelerations and the values that follow from them; the forces at the tips too if
 * `tips` */
VEC_INLINE void SMALL(descend)(const struct bodies_system *b, const struct SMALL(asked) * asked,
                               const struct SMALL(climb) * up, int tips, struct SMALL(told) * to) {
    struct SMALL(joint) j;
    to->root_x = up->x[0], to->root_y = up->y[0];
    for (int a = 0; a < b->n; a++) {
        int p = b->parent[a];
        j.late[a] = PART_(of)(0);
        if (a) {
            SMALL(pull)(b, a, asked->pulled[p], up, &j);
        } else {
            PART x = asked->lift_x, y = asked->lift_y, xy = PART_(of)(b->form_xy[0]);
            j.base_x[0] = x, j.base_y[0] = y;
            j.x = PART_(fma)(PART_(of)(b->form_xx[0]), x, PART_(fma)(xy, y, up->x[0]));
            j.y = PART_(fma)(xy, x, PART_(fma)(PART_(of)(b->form_yy[0]), y, up->y[0]));
        }
        PART way = PART_(fma)(PART_(of)(b->lever_x[a]), j.base_x[a], b->lever_y[a] * j.base_y[a]);
        to->chi[a] = up->answer[a] - way;
        to->push[a] = PART_(fma)(PART_(of)(b->center_x[a]), j.x, b->center_y[a] * j.y);
        if (tips) SMALL(tip)(b, a, asked->pulled[a], &j, to);
        if (!a) continue;
        to->push[p] = PART_(fma)(PART_(of)(b->stem_x[a]), j.x, to->push[p]);
        to->push[p] = PART_(fma)(PART_(of)(b->stem_y[a]), j.y, to->push[p]);
    }
}

/* computes the table of responses and, in `drop`, the known effect of the pivot's acceleration */
VEC_INLINE void SMALL(rigid)(const struct jets_system *s, int order, struct SMALL(table) * table,
                             struct SMALL(pair) * inertia) {
    const struct jets_loads *loads = s->loads;
    const struct bodies_system *b = loads->bodies;
    const double C = s->cosine[0], Z = s->sine[0];
    bodies_factor(b);
    _Alignas(64) double unit[2 * LANES][2 * LANES] = {{0}}, scale[2 * LANES], own[2 * LANES] = {0};
    for (int i = 0; i < 2 * LANES; i++) unit[i][i] = 1;
    for (int i = 0; i < LANES; i++) {
        scale[i] = 1, scale[LANES + i] = -s->inv_len[i];
        if (i < s->n) own[LANES + i] = b->spread[i] * s->inv_len[i];
    }
    *table = (struct SMALL(table)){0};
    for (int p = 0; p < PARTS; p++) {
        struct SMALL(asked) asked = {.lift_x = PART_(of)(0), .lift_y = PART_(of)(0)};
        struct SMALL(climb) up;
        struct SMALL(told) told;
        int at = p * PART_WIDTH;
        PART by = PART_(get)(scale + at);
        for (int a = 0; a < s->n; a++) {
            asked.moment[a] = PART_(get)(unit[a] + at);
            asked.pulled[a] = PART_(get)(unit[LANES + a] + at);
        }
        SMALL(climb)(b, &asked, &up);
        SMALL(descend)(b, &asked, &up, 0, &told);
        for (int a = 0; a < s->n; a++) {
            table->pull[a].part[p] = by * told.push[a];
            table->side[a].part[p] = by * told.chi[a] * s->len[a];
        }
        PART fall_x = by * told.root_x, fall_y = by * told.root_y;
        for (int k = 0; k < (loads->moves ? order : 1); k++) {
            double x = loads->lift_x[k], y = loads->lift_y[k];
            PART drop = -(fall_x * (C * x + Z * y)) - fall_y * (C * y - Z * x);
            PART_(put)(loads->drop + k * LOADS_STRIDE + at, drop);
        }
        inertia->part[p] = PART_(get)(own + at);
    }
}

/* sets moments and pulls of the PART_WIDTH orders from k on, one order per lane */
VEC_INLINE void SMALL(recall)(const struct jets_system *s, int k, int order,
                              struct SMALL(asked) * asked) {
    const struct jets_loads *loads = s->loads;
    double C = s->cosine[0], Z = s->sine[0];
    PART x, y;
    memcpy(&x, loads->lift_x + k, sizeof x);
    memcpy(&y, loads->lift_y + k, sizeof y);
    asked->lift_x = C * x + Z * y;
    asked->lift_y = C * y - Z * x;
    for (int a = 0; a < s->n; a++) {
        double l = s->len[a], I = loads->bodies->spread[a];
        for (int i = 0; i < PART_WIDTH; i++) {
            int j = k + i < order ? k + i : order - 1, way = (j + 1) * (j + 2);
            const double *row = loads->across + (j + 1) * LOADS_STRIDE + LANES;
            double kr = -way * s->turn_re[(j + 2) * 8 + a], chi = way * s->turn_im[(j + 2) * 8 + a];
            if (loads->drag_per_mass != 0) {
                double re, im;
                loads_turn(s, a, j + 1, &re, &im);
                kr += (j + 1) * loads->drag_per_mass * re;
                chi += (j + 1) * loads->drag_per_mass * im;
            }
            asked->pulled[a][i] = kr;
            asked->moment[a][i] = l * row[a] + I * chi;
        }
    }
}

/* For orders below `order`: the force of the pivot and, in place of F, the forces at the tips in
 * fixed axes: along the arms, and across them if `across`. */
static void SMALL(ends)(const struct jets_system *s, int order, int across) {
    const struct jets_loads *loads = s->loads;
    const struct bodies_system *b = loads->bodies;
    for (int k = 0; k < order; k += PART_WIDTH) {
        struct SMALL(asked) asked;
        struct SMALL(climb) up;
        struct SMALL(told) told;
        SMALL(recall)(s, k, order, &asked);
        SMALL(climb)(b, &asked, &up);
        SMALL(descend)(b, &asked, &up, 1, &told);
        PART x = asked.lift_x, y = asked.lift_y;
        PART pivot_force_x = b->form_xx[0] * x + b->form_xy[0] * y + told.root_x;
        PART pivot_force_y = b->form_xy[0] * x + b->form_yy[0] * y + told.root_y;
        for (int i = 0; i < PART_WIDTH && k + i < order; i++) {
            double *row = loads->across + (k + i + 1) * LOADS_STRIDE + LANES;
            loads->pivot_force_x[k + i] = pivot_force_x[i];
            loads->pivot_force_y[k + i] = pivot_force_y[i];
            for (int a = 0; a < s->n && across; a++) row[a] = told.tip_y[a][i];
            for (int a = 0; a < s->n && (across || !(k + i)); a++)
                SMALL(forces)(s, k + i + 1, 0)[a] = told.tip_x[a][i];
        }
    }
}

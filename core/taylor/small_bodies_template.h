/* The tree system of order 0 of a real pendulum of up to LANES bodies: what every arm does for a
 * unit of every known part, and the forces at the arms' ends. Leaves to others: its factorization
 * (bodies_factor_template, whose sweeps these are, several right-hand sides side by side), the
 * orders that multiply by it (small_loads_template). Included once for each number of lanes.
 * Invariant: whatever the bodies are and wherever arms hang, an order costs two multiply-adds more
 * than one with torques between point masses.
 *
 * With G of bodies_template F = G / l stands where the force at the tip does among point masses:
 *     Im F_k = (tau_k - J phi''_k) / l - sum_{j>=1} (Re u_j Im F_{k-j} - Im u_j Re F_{k-j}),
 * and Re F_k is what the tree answers to Im T and to torques, as phi'' is. By reciprocity the
 * answers of an arm to the units of all others are those of all others to its own, but for signs:
 * with rho = Re G + J kr, d rho_i / d tau_j = -d chi_j / d kr_i, and d rho / d kr is symmetric. */

/* right-hand sides, one a lane: kr, and known moments about the joints; the pivot's acceleration */
struct SMALL(asked) {
    PART pulled[LANES], moment[LANES], lift_x, lift_y;
};

/* chi, Re G and forces at the tips of the arms; the force at the first joint without what the
 * pivot's acceleration adds to it */
struct SMALL(told) {
    PART chi[LANES], push[LANES], tip_x[LANES], tip_y[LANES], root_x, root_y;
};

/* what the arms ask of their bases, and their moments over D: leaves to root */
struct SMALL(climb) {
    PART x[LANES], y[LANES], answer[LANES];
};

VEC_INLINE void SMALL(climb)(const struct bodies_system *b, const struct SMALL(asked) * asked,
                             struct SMALL(climb) * up) {
    int last = 0;
    do {
        PART kr = asked->pulled[last], m = asked->moment[last];
        up->x[last] = PART_(fma)(PART_(of)(b->lever_x[last]), m, b->draw_x[last] * kr);
        up->y[last] = PART_(fma)(PART_(of)(b->lever_y[last]), m, b->draw_y[last] * kr);
        up->answer[last] = m - b->twist[last] * kr;
    } while (++last < b->n);
    for (int c = b->n - 1; c > 0; c--) {
        int p = b->parent[c];
        PART ax = up->x[c], ay = up->y[c];
        PART x = PART_(fma)(PART_(of)(b->carry_xx[c]), ax, up->x[p]);
        PART y = PART_(fma)(PART_(of)(b->carry_xy[c]), ax, up->y[p]);
        PART moment = PART_(fma)(PART_(of)(b->place_y[c]), ax, up->answer[p]);
        up->x[p] = PART_(fma)(PART_(of)(b->carry_yx[c]), ay, x);
        up->y[p] = PART_(fma)(PART_(of)(b->carry_yy[c]), ay, y);
        up->answer[p] = PART_(fma)(PART_(of)(-b->place_x[c]), ay, moment);
    }
    for (int a = 0; a < b->n; a++) up->answer[a] *= PART_(of)(b->inv_total[a]);
}

/* accelerations, and what follows from them: root to leaves, with the forces at the tips where
 * `tips` are wanted */
VEC_INLINE void SMALL(descend)(const struct bodies_system *b, const struct SMALL(asked) * asked,
                               const struct SMALL(climb) * up, int tips, struct SMALL(told) * to) {
    PART base_x[LANES], base_y[LANES];
    to->root_x = up->x[0], to->root_y = up->y[0];
    for (int a = 0; a < b->n; a++) {
        int p = b->parent[a];
        PART x = asked->lift_x, y = asked->lift_y;
        if (a) {
            PART px = PART_(of)(b->place_x[a]), py = PART_(of)(b->place_y[a]);
            x = px * asked->pulled[p] - py * up->answer[p];
            y = PART_(fma)(py, asked->pulled[p], px * up->answer[p]);
            x = PART_(fma)(PART_(of)(b->carry_xx[a]), base_x[p], x);
            y = PART_(fma)(PART_(of)(b->carry_yx[a]), base_x[p], y);
            x = PART_(fma)(PART_(of)(b->carry_xy[a]), base_y[p], x);
            y = PART_(fma)(PART_(of)(b->carry_yy[a]), base_y[p], y);
        }
        base_x[a] = x, base_y[a] = y;
        PART way = PART_(fma)(PART_(of)(b->lever_x[a]), x, b->lever_y[a] * y);
        to->chi[a] = up->answer[a] - way;
        to->push[a] = PART_(fma)(PART_(of)(b->moment_x[a]), x, b->moment_y[a] * y);
        if (tips) {
            to->tip_x[a] = b->mass[a] * PART_(fma)(PART_(of)(b->len[a]), asked->pulled[a], x);
            to->tip_y[a] = b->mass[a] * PART_(fma)(PART_(of)(b->len[a]), to->chi[a], y);
        }
        if (!a) continue;
        PART xy = PART_(of)(b->form_xy[a]);
        PART fx = PART_(fma)(PART_(of)(b->form_xx[a]), x, PART_(fma)(xy, y, up->x[a]));
        PART fy = PART_(fma)(xy, x, PART_(fma)(PART_(of)(b->form_yy[a]), y, up->y[a]));
        to->push[p] = PART_(fma)(PART_(of)(b->place_x[a]), fx, to->push[p]);
        to->push[p] = PART_(fma)(PART_(of)(b->place_y[a]), fy, to->push[p]);
        if (!tips || bodies_hung(b, a)) continue;
        PART C = PART_(of)(b->cosine[a]), Z = PART_(of)(b->sine[a]);
        to->tip_x[p] += C * fx - Z * fy;
        to->tip_y[p] += PART_(fma)(Z, fx, C * fy);
    }
}

/* the table of responses, and in the rows of drop what the pivot's acceleration does, as far as it
 * is known */
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
        if (i < s->n) own[LANES + i] = b->inertia[i] * s->inv_len[i];
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

/* the moments and the pulls of PART_WIDTH orders from order k on, one a lane */
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
        double l = s->len[a], J = loads->bodies->inertia[a];
        for (int i = 0; i < PART_WIDTH; i++) {
            int j = k + i < order ? k + i : order - 1, way = (j + 1) * (j + 2);
            const double *row = loads->across + (j + 1) * LOADS_STRIDE + LANES;
            double kr = -way * s->turn_re[(j + 2) * 8 + a], chi = way * s->turn_im[(j + 2) * 8 + a];
            if (loads->mist != 0) {
                double re, im;
                loads_turn(s, a, j + 1, &re, &im);
                kr += (j + 1) * loads->mist * re;
                chi += (j + 1) * loads->mist * im;
            }
            asked->pulled[a][i] = kr;
            asked->moment[a][i] = l * row[a] + J * chi;
        }
    }
}

/* The forces of the pivot, orders below `order`, and in the place of F those at the tips, in axes
 * that are fixed: along the arms, and across where `across` they are wanted. */
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
        PART haul_x = b->form_xx[0] * x + b->form_xy[0] * y + told.root_x;
        PART haul_y = b->form_xy[0] * x + b->form_yy[0] * y + told.root_y;
        for (int i = 0; i < PART_WIDTH && k + i < order; i++) {
            double *row = loads->across + (k + i + 1) * LOADS_STRIDE + LANES;
            loads->haul_x[k + i] = haul_x[i];
            loads->haul_y[k + i] = haul_y[i];
            for (int a = 0; a < s->n && across; a++) row[a] = told.tip_y[a][i];
            for (int a = 0; a < s->n && (across || !(k + i)); a++)
                SMALL(forces)(s, k + i + 1, 0)[a] = told.tip_x[a][i];
        }
    }
}

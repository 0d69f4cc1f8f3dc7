/* The tables of a tree of bodies in tiles, once a step: what every arm of a tile, and what the tile
 * tells others, is for a unit of each input. For one pendulum in doubles.
 * Leaves to others: the factorization (bodies_factor_template, whose sweeps these are, several
 * units side by side), the orders that multiply by the tables (tiles_orders_template).
 * Invariant: the tables are made by the stable sweeps; nothing is inverted.
 *
 * Without tiles a trajectory of a chain of bodies takes 39 % longer with 50 arms, 27 % with 100 and
 * 25 % with 200; rods and bodies on the arms of a chain have a quicker form
 * (core/taylor/large/rods).
 *
 * Lanes are units. By reciprocity the answers of the arms to one arm's unit are those of this arm
 * to all units: accelerations against moments and forces alike, and with the opposite sign where
 * one of the two is kr, a motion, or its Re G + J kr, which keeps it up. */
#ifndef PEND_TILES_TEMPLATE_H
#define PEND_TILES_TEMPLATE_H

#include "core/bodies/bodies_template.h"
#include "core/bodies/tiles.h"
#include "core/simd/vec8_template.h"

/* units in lanes, of the arms of a tile: what the arms ask of their bases, their moments, then over
 * D; kr, the acceleration of the base, chi, and Re G; moments on the parent but for the arm's, with
 * those of later siblings, and those of the children so far; of kids what they ask and these
 * moments */
struct tiles_probe {
    wide x[TILE_ARMS], y[TILE_ARMS], answer[TILE_ARMS], pulled[TILE_ARMS], base_x[TILE_ARMS],
        base_y[TILE_ARMS], chi[TILE_ARMS], push[TILE_ARMS], early[TILE_ARMS], late[TILE_ARMS];
    wide kid_x[TILE_ARMS / TILE_OUT], kid_y[TILE_ARMS / TILE_OUT], kid_early[TILE_ARMS / TILE_OUT];
};

/* the matrix of kid j, and what asked forces make of kids' outputs */
VEC_INLINE double *tiles_gain(const struct tiles *t, const struct tile *tile, int j) {
    return t->numbers + tile->gain + j * TILE_OUT * TILE_OUT;
}

VEC_INLINE double *tiles_mutual(const struct tiles *t, const struct tile *tile) {
    return tiles_gain(t, tile, tile->kids);
}

/* what the base of each kid accelerates with for the units */
struct tiles_told {
    wide x[TILE_ARMS / TILE_OUT], y[TILE_ARMS / TILE_OUT];
};

/* a moment on the parent of arm c, and what the arm's (x, y) that is asked adds to it */
VEC_INLINE wide tiles_moment(const struct bodies_system *s, int c, wide x, wide y, wide moment) {
    moment = wide_fma(wide_of(s->place_y[c]), x, moment);
    return wide_fma(wide_of(-s->place_x[c]), y, moment);
}

/* leaves to roots */
VEC_INLINE void tiles_climb(const struct bodies_system *s, const struct tile *tile,
                            struct tiles_probe *u) {
    int first = tile->first;
    for (int j = tile->kids - 1; j >= 0; j--) {
        int c = s->tiles->kid[tile->kid + j], p = s->parent[c] - first;
        u->kid_early[j] = u->answer[p];
        u->answer[p] = tiles_moment(s, c, u->kid_x[j], u->kid_y[j], u->answer[p]);
    }
    for (int i = tile->arms - 1; i > 0; i--) {
        int c = first + i, p = s->parent[c] - first;
        if (p < 0) continue;
        wide ax = u->x[i], ay = u->y[i];
        wide x = wide_fma(wide_of(s->carry_xx[c]), ax, u->x[p]);
        wide y = wide_fma(wide_of(s->carry_xy[c]), ax, u->y[p]);
        u->early[i] = u->answer[p];
        u->x[p] = wide_fma(wide_of(s->carry_yx[c]), ay, x);
        u->y[p] = wide_fma(wide_of(s->carry_yy[c]), ay, y);
        u->answer[p] = tiles_moment(s, c, ax, ay, u->answer[p]);
    }
    for (int i = 0; i < tile->arms; i++) {
        wide m = u->answer[i] - s->twist[first + i] * u->pulled[i];
        u->answer[i] = m * wide_of(s->inv_total[first + i]);
        u->late[i] = wide_of(0);
    }
}

/* the acceleration of the base of arm c from its parent's numbers, lane p */
VEC_INLINE void tiles_base(const struct bodies_system *s, int c, int p, struct tiles_probe *u,
                           wide *x, wide *y) {
    wide px = wide_of(s->place_x[c]), py = wide_of(s->place_y[c]);
    *x = px * u->pulled[p] - py * u->answer[p];
    *y = wide_fma(py, u->pulled[p], px * u->answer[p]);
    *x = wide_fma(wide_of(s->carry_xx[c]), u->base_x[p], *x);
    *y = wide_fma(wide_of(s->carry_yx[c]), u->base_x[p], *y);
    *x = wide_fma(wide_of(s->carry_xy[c]), u->base_y[p], *x);
    *y = wide_fma(wide_of(s->carry_yy[c]), u->base_y[p], *y);
}

/* the force at the joint of arm c, which asks (x, y), from the acceleration of its base */
VEC_INLINE void tiles_feel(const struct bodies_system *s, int c, wide base_x, wide base_y, wide x,
                           wide y, wide *force_x, wide *force_y) {
    wide xy = wide_of(s->form_xy[c]);
    *force_x = wide_fma(wide_of(s->form_xx[c]), base_x, wide_fma(xy, base_y, x));
    *force_y = wide_fma(xy, base_x, wide_fma(wide_of(s->form_yy[c]), base_y, y));
}

/* The force at the joint of arm c, which asks (x, y), joins the Re G of its parent, lane p; of
 * points it is formed anew, as bodies_hold has it. `early` are the moments on the parent with those
 * of later siblings. */
VEC_INLINE void tiles_pull(const struct bodies_system *s, int c, int p, wide x, wide y, wide early,
                           struct tiles_probe *u, wide *force_x, wide *force_y) {
    wide ax = u->base_x[p], ay = u->base_y[p], kr = u->pulled[p], m = early + u->late[p];
    wide fx = *force_x, fy = *force_y;
    if (!(s->need & BODIES_SHAPE)) {
        fx = wide_fma(wide_of(s->sway_xx[c]), ax, s->sway_xy[c] * ay);
        fy = wide_fma(wide_of(s->sway_yx[c]), ax, s->sway_yy[c] * ay);
        fx = wide_fma(wide_of(s->keep_xx[c]), x, wide_fma(wide_of(s->keep_xy[c]), y, fx));
        fy = wide_fma(wide_of(s->keep_yx[c]), x, wide_fma(wide_of(s->keep_yy[c]), y, fy));
        fx += wide_fma(wide_of(s->swing_x[c]), kr, s->turn_x[c] * m);
        fy += wide_fma(wide_of(s->swing_y[c]), kr, s->turn_y[c] * m);
    }
    u->late[p] = tiles_moment(s, c, x, y, u->late[p]);
    u->push[p] = wide_fma(wide_of(s->stem_x[c]), fx, u->push[p]);
    u->push[p] = wide_fma(wide_of(s->stem_y[c]), fy, u->push[p]);
    *force_x = fx, *force_y = fy;
}

/* roots to leaves */
VEC_INLINE void tiles_descend(const struct bodies_system *s, const struct tile *tile,
                              struct tiles_probe *u) {
    for (int i = 0; i < tile->arms; i++) {
        int c = tile->first + i, p = s->parent[c] - tile->first;
        if (p >= 0) tiles_base(s, c, p, u, &u->base_x[i], &u->base_y[i]);
        wide x = u->base_x[i], y = u->base_y[i];
        wide way = wide_fma(wide_of(s->lever_x[c]), x, s->lever_y[c] * y);
        u->chi[i] = u->answer[i] - way;
        wide fx, fy;
        tiles_feel(s, c, x, y, u->x[i], u->y[i], &fx, &fy);
        if (p >= 0) tiles_pull(s, c, p, u->x[i], u->y[i], u->early[i], u, &fx, &fy);
        u->push[i] = wide_fma(wide_of(s->center_x[c]), fx, u->push[i]);
        u->push[i] = wide_fma(wide_of(s->center_y[c]), fy, u->push[i]);
    }
}

/* units of row `row` of the inputs, one an arm, lanes from h on */
VEC_INLINE void tiles_units(const struct bodies_system *s, const struct tile *tile, int row, int h,
                            struct tiles_probe *u) {
    for (int i = 0; i < tile->arms; i++) {
        int a = tile->first + i;
        const double x[TILE_INPUTS] = {s->lever_x[a], s->draw_x[a]};
        const double y[TILE_INPUTS] = {s->lever_y[a], s->draw_y[a]};
        u->x[i] = wide_only(x[row], i, h);
        u->y[i] = wide_only(y[row], i, h);
        u->answer[i] = wide_only(row == 0, i, h);
        u->pulled[i] = wide_only(row == 1, i, h);
        u->push[i] = u->base_x[i] = u->base_y[i] = wide_of(0);
    }
    for (int j = 0; j < tile->kids; j++) u->kid_x[j] = u->kid_y[j] = wide_of(0);
}

/* units of outputs: accelerations of the roots' bases, and forces that kids ask, which are forces
 * and moments on what carries them */
VEC_INLINE void tiles_outer(const struct bodies_system *s, const struct tile *tile, int h,
                            struct tiles_probe *u) {
    const struct tiles *t = s->tiles;
    for (int i = 0; i < tile->arms; i++)
        u->x[i] = u->y[i] = u->answer[i] = u->pulled[i] = u->push[i] = u->base_x[i] = u->base_y[i] =
            wide_of(0);
    for (int r = 0; r < tile->roots; r++) {
        int i = t->root[tile->root + r] - tile->first;
        u->base_x[i] = wide_only(1, TILE_OUT * r, h);
        u->base_y[i] = wide_only(1, TILE_OUT * r + 1, h);
    }
    for (int j = 0; j < tile->kids; j++) {
        int c = t->kid[tile->kid + j], i = s->parent[c] - tile->first;
        int lane = TILE_OUT * (tile->roots + j);
        u->x[i] += wide_only(s->carry_xx[c], lane, h) + wide_only(s->carry_yx[c], lane + 1, h);
        u->y[i] += wide_only(s->carry_xy[c], lane, h) + wide_only(s->carry_yy[c], lane + 1, h);
        u->kid_x[j] = wide_only(1, lane, h), u->kid_y[j] = wide_only(1, lane + 1, h);
    }
}

/* the two sweeps; and the kids' bases, whose forces join the Re G of what carries them */
VEC_INLINE void tiles_sweep(const struct bodies_system *s, const struct tile *tile,
                            struct tiles_probe *u, struct tiles_told *told) {
    tiles_climb(s, tile, u);
    tiles_descend(s, tile, u);
    for (int j = 0; j < tile->kids; j++) {
        int c = s->tiles->kid[tile->kid + j], p = s->parent[c] - tile->first;
        wide x, y;
        tiles_base(s, c, p, u, &told->x[j], &told->y[j]);
        tiles_feel(s, c, told->x[j], told->y[j], u->kid_x[j], u->kid_y[j], &x, &y);
        tiles_pull(s, c, p, u->kid_x[j], u->kid_y[j], u->kid_early[j], u, &x, &y);
    }
}

/* output `out` of the units */
VEC_INLINE wide tiles_tell(const struct tiles *t, const struct tile *tile, int out,
                           const struct tiles_probe *u, const struct tiles_told *told) {
    int which = out % TILE_OUT, j = out / TILE_OUT - tile->roots;
    if (j >= 0) return which ? told->y[j] : told->x[j];
    int i = t->root[tile->root + out / TILE_OUT] - tile->first;
    return which ? u->y[i] : u->x[i];
}

/* the columns of the inputs, and the sways, from the units of moments (row 0) and of kr (row 1) */
VEC_INLINE void tiles_columns(const struct tiles *t, const struct tile *tile, int row, int h,
                              const struct tiles_probe *u, const struct tiles_told *told) {
    enum { STRIDE = TILE_ANSWERS + TILE_ARMS, ROWS = TILE_ARMS * STRIDE };
    double *to = t->numbers + tile->columns + row * TILE_ARMS + h;
    wide sign = wide_of(row ? -1 : 1);
    for (int i = 0; i < tile->arms; i++, to += STRIDE) {
        wide_put(to, sign * u->chi[i]);
        wide_put(to + ROWS, -sign * u->push[i]);
    }
    double *sway = t->numbers + tile->sway + row * TILE_ARMS + h;
    double *outputs = t->numbers + tile->columns + (row * TILE_ARMS + h) * STRIDE + TILE_ANSWERS;
    for (int out = 0; out < TILE_OUT * (tile->roots + tile->kids); out++) {
        wide all = tiles_tell(t, tile, out, u, told);
        wide_put(sway + out * TILE_ANSWERS, -sign * all);
        for (int lane = 0; lane < WIDE; lane++) outputs[lane * STRIDE + out] = all[lane];
    }
}

/* of units of outputs: the kids' gains, and what kids ask of each other */
VEC_INLINE void tiles_gains(const struct tiles *t, const struct tile *tile, int h,
                            const struct tiles_told *told) {
    int roots = TILE_OUT * tile->roots, asks = TILE_OUT * tile->kids;
    double *mutual = tiles_mutual(t, tile);
    for (int out = 0; out < asks; out++) {
        int j = out / TILE_OUT, root = 0;
        wide all = out % TILE_OUT ? told->y[j] : told->x[j];
        while (t->root[tile->root + root] != t->kid_root[tile->kid + j]) root++;
        double *gain = tiles_gain(t, tile, j) + out % TILE_OUT * TILE_OUT;
        for (int lane = 0; lane < WIDE; lane++) {
            int by = h + lane - roots, own = h + lane - TILE_OUT * root;
            if (by >= 0 && by < asks) mutual[by * asks + out] = all[lane];
            if (own == 0 || own == 1) gain[own] = all[lane];
        }
    }
}

/* all tables, after the factorization */
static void tiles_prepare(const struct bodies_system *s) {
    const struct tiles *t = s->tiles;
    for (const struct tile *tile = t->tile; tile < t->tile + t->count; tile++) {
        for (int h = 0; h < TILE_ARMS; h += WIDE) {
            struct tiles_probe u[TILE_INPUTS + 1];
            struct tiles_told told[TILE_INPUTS + 1];
            for (int row = 0; row < TILE_INPUTS; row++) {
                tiles_units(s, tile, row, h, &u[row]);
                tiles_sweep(s, tile, &u[row], &told[row]);
                tiles_columns(t, tile, row, h, &u[row], &told[row]);
            }
            if (!tile->kids) continue;
            tiles_outer(s, tile, h, &u[TILE_INPUTS]);
            tiles_sweep(s, tile, &u[TILE_INPUTS], &told[TILE_INPUTS]);
            tiles_gains(t, tile, h, &told[TILE_INPUTS]);
        }
    }
}

#endif

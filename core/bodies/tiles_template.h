/* The tables of a tree of bodies in tiles, once a step: what every arm of a tile, and what the tile
 * tells others, is for a unit of each input. For one pendulum in doubles.
 * Leaves to others: the factorization (bodies_factor_template, whose sweeps these are, several
 * units side by side), the orders that multiply by the tables (tiles_orders_template).
 * Invariant: the tables are made by the stable sweeps; nothing is inverted.
 *
 * Without tiles a trajectory of a chain of rods takes 39 % longer with 50 arms, 27 % with 100 and
 * 25 % with 200.
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
 * D; kr, the acceleration of the base, chi, and Re G */
struct tiles_probe {
    wide x[TILE_ARMS], y[TILE_ARMS], answer[TILE_ARMS], pulled[TILE_ARMS], base_x[TILE_ARMS],
        base_y[TILE_ARMS], chi[TILE_ARMS], push[TILE_ARMS];
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

/* leaves to roots */
VEC_INLINE void tiles_climb(const struct bodies_system *s, const struct tile *tile,
                            struct tiles_probe *u) {
    int first = tile->first;
    for (int i = tile->arms - 1; i > 0; i--) {
        int c = first + i, p = s->parent[c] - first;
        if (p < 0) continue;
        wide ax = u->x[i], ay = u->y[i];
        wide x = wide_fma(wide_of(s->carry_xx[c]), ax, u->x[p]);
        wide y = wide_fma(wide_of(s->carry_xy[c]), ax, u->y[p]);
        wide moment = wide_fma(wide_of(s->place_y[c]), ax, u->answer[p]);
        u->x[p] = wide_fma(wide_of(s->carry_yx[c]), ay, x);
        u->y[p] = wide_fma(wide_of(s->carry_yy[c]), ay, y);
        u->answer[p] = wide_fma(wide_of(-s->place_x[c]), ay, moment);
    }
    for (int i = 0; i < tile->arms; i++) u->answer[i] *= wide_of(s->inv_total[first + i]);
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

/* roots to leaves */
VEC_INLINE void tiles_descend(const struct bodies_system *s, const struct tile *tile,
                              struct tiles_probe *u) {
    for (int i = 0; i < tile->arms; i++) {
        int c = tile->first + i, p = s->parent[c] - tile->first;
        if (p >= 0) tiles_base(s, c, p, u, &u->base_x[i], &u->base_y[i]);
        wide x = u->base_x[i], y = u->base_y[i];
        wide way = wide_fma(wide_of(s->lever_x[c]), x, s->lever_y[c] * y);
        u->chi[i] = u->answer[i] - way;
        u->push[i] =
            wide_fma(wide_of(s->moment_x[c]), x, wide_fma(wide_of(s->moment_y[c]), y, u->push[i]));
        if (p < 0) continue;
        wide xy = wide_of(s->form_xy[c]);
        wide fx = wide_fma(wide_of(s->form_xx[c]), x, wide_fma(xy, y, u->x[i]));
        wide fy = wide_fma(xy, x, wide_fma(wide_of(s->form_yy[c]), y, u->y[i]));
        u->push[p] = wide_fma(wide_of(s->place_x[c]), fx, u->push[p]);
        u->push[p] = wide_fma(wide_of(s->place_y[c]), fy, u->push[p]);
    }
}

/* units of row `row` of the inputs, one an arm, lanes from h on */
VEC_INLINE void tiles_units(const struct bodies_system *s, const struct tile *tile, int row, int h,
                            struct tiles_probe *u) {
    for (int i = 0; i < tile->arms; i++) {
        int a = tile->first + i;
        const double x[TILE_INPUTS] = {s->lever_x[a], s->draw_x[a]};
        const double y[TILE_INPUTS] = {s->lever_y[a], s->draw_y[a]};
        const double answer[TILE_INPUTS] = {1, -s->twist[a]};
        u->x[i] = wide_only(x[row], i, h);
        u->y[i] = wide_only(y[row], i, h);
        u->answer[i] = wide_only(answer[row], i, h);
        u->pulled[i] = wide_only(row == 1, i, h);
        u->push[i] = u->base_x[i] = u->base_y[i] = wide_of(0);
    }
}

/* units of outputs: accelerations of the roots' bases, and forces that kids ask, which are forces
 * and moments on what carries them and parts of its Re G */
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
        u->answer[i] += wide_only(s->place_y[c], lane, h) - wide_only(s->place_x[c], lane + 1, h);
        u->push[i] += wide_only(s->place_x[c], lane, h) + wide_only(s->place_y[c], lane + 1, h);
    }
}

/* the two sweeps; and the kids' bases, whose forces without what they ask join the Re G of what
 * carries them */
VEC_INLINE void tiles_sweep(const struct bodies_system *s, const struct tile *tile,
                            struct tiles_probe *u, struct tiles_told *told) {
    tiles_climb(s, tile, u);
    tiles_descend(s, tile, u);
    for (int j = 0; j < tile->kids; j++) {
        int c = s->tiles->kid[tile->kid + j], p = s->parent[c] - tile->first;
        wide x, y, xy = wide_of(s->form_xy[c]);
        tiles_base(s, c, p, u, &x, &y);
        wide fx = wide_fma(wide_of(s->form_xx[c]), x, xy * y);
        wide fy = wide_fma(xy, x, wide_of(s->form_yy[c]) * y);
        u->push[p] = wide_fma(wide_of(s->place_x[c]), fx, u->push[p]);
        u->push[p] = wide_fma(wide_of(s->place_y[c]), fy, u->push[p]);
        told->x[j] = x, told->y[j] = y;
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

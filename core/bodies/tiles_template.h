/* The tables of a tree of bodies in tiles, once a step: what every arm of a tile, and what the tile
 * tells others, is for a unit of each input. For one pendulum in doubles.
 * Leaves to others: the factorization (bodies_factor_template, whose sweeps these are, several
 * units side by side), the orders that multiply by the tables (tiles_orders_template).
 * Invariant: the tables are made by the stable sweeps; nothing is inverted.
 *
 * Without tiles a series to order 20 of a chain of rods takes 9 % longer with 9 arms, 44 % with 16,
 * 30 % with 32, 7 % with 64. A chain of 16 rods takes 3.3 times the ideal one (before: 4.8).
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

/* numbers of a port: TILE_ROOT^2 of its gain, then TILE_LEAN */
enum { TILES_PORT_GAIN = TILE_ROOT * TILE_ROOT + TILE_LEAN };

VEC_INLINE double *tiles_port(const struct tiles *t, const struct tile *tile, int i) {
    return t->numbers + tile->gain + i * TILES_PORT_GAIN;
}

/* what makes of the ports' outputs what each of these is */
VEC_INLINE double *tiles_mutual(const struct tiles *t, const struct tile *tile) {
    return tiles_port(t, tile, tile->ports);
}

/* what the kids of a port add to its Re G, but for what they ask */
static void tiles_lean(const struct bodies_system *s, const struct tiles *t, int port,
                       double lean[TILE_LEAN]) {
    for (int i = 0; i < TILE_LEAN; i++) lean[i] = 0;
    for (int i = t->kid_first[port]; i < t->kid_first[port + 1]; i++) {
        int c = t->kid[i];
        double x = s->place_x[c], y = s->place_y[c];
        double gx = num_fma(s->form_xx[c], x, s->form_xy[c] * y);
        double gy = num_fma(s->form_xy[c], x, s->form_yy[c] * y);
        lean[0] += num_fma(gx, s->carry_xx[c], gy * s->carry_yx[c]);
        lean[1] += num_fma(gx, s->carry_xy[c], gy * s->carry_yy[c]);
        lean[2] += num_fma(gx, x, gy * y);
        lean[3] += num_sub(gy * x, gx * y);
    }
}

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

/* units of outputs: accelerations of the roots' bases, and what kids ask */
VEC_INLINE void tiles_outer(const struct tiles *t, const struct tile *tile, int h,
                            struct tiles_probe *u) {
    for (int i = 0; i < tile->arms; i++)
        u->x[i] = u->y[i] = u->answer[i] = u->pulled[i] = u->push[i] = u->base_x[i] = u->base_y[i] =
            wide_of(0);
    for (int lane = h; lane < h + WIDE; lane++) {
        int out = lane, port = (out - TILE_ROOT * tile->roots) / TILE_PORT;
        wide unit = wide_only(1, lane, h);
        if (out < TILE_ROOT * tile->roots) {
            int i = t->root[tile->root + out / TILE_ROOT] - tile->first;
            *(out % TILE_ROOT ? &u->base_y[i] : &u->base_x[i]) = unit;
        } else if (port < tile->ports) {
            int i = t->port[tile->port + port] - tile->first;
            int which = out - TILE_ROOT * tile->roots - TILE_PORT * port;
            *(which == 0 ? &u->x[i] : which == 1 ? &u->y[i] : &u->answer[i]) = unit;
        }
    }
}

/* the two sweeps */
VEC_INLINE void tiles_sweep(const struct bodies_system *s, const struct tiles *t,
                            const struct tile *tile, struct tiles_probe *u) {
    tiles_climb(s, tile, u);
    tiles_descend(s, tile, u);
    for (int j = 0; j < tile->ports; j++) {
        const double *lean = tiles_port(t, tile, j) + TILE_ROOT * TILE_ROOT;
        int i = t->port[tile->port + j] - tile->first;
        wide sum = wide_fma(wide_of(lean[0]), u->base_x[i], u->push[i]);
        sum = wide_fma(wide_of(lean[1]), u->base_y[i], sum);
        sum = wide_fma(wide_of(lean[2]), u->pulled[i], sum);
        u->push[i] = wide_fma(wide_of(lean[3]), u->answer[i], sum);
    }
}

/* output `out` of the units */
VEC_INLINE wide tiles_told(const struct tiles *t, const struct tile *tile, int out,
                           const struct tiles_probe *u) {
    if (out < TILE_ROOT * tile->roots) {
        int i = t->root[tile->root + out / TILE_ROOT] - tile->first;
        return out % TILE_ROOT ? u->y[i] : u->x[i];
    }
    out -= TILE_ROOT * tile->roots;
    int i = t->port[tile->port + out / TILE_PORT] - tile->first, which = out % TILE_PORT;
    return which == 0 ? u->base_x[i] : which == 1 ? u->base_y[i] : u->answer[i];
}

/* whether the answers to an output have the sign of its units */
VEC_INLINE int tiles_alike(const struct tile *tile, int out) {
    return out >= TILE_ROOT * tile->roots && (out - TILE_ROOT * tile->roots) % TILE_PORT == 2;
}

/* the columns of the inputs and the sways, from the units of moments (row 0) and of kr (row 1) */
VEC_INLINE void tiles_columns(const struct tiles *t, const struct tile *tile, int row, int h,
                              const struct tiles_probe *u) {
    size_t stride = (size_t)(TILE_ANSWERS + tile->outs), rows = TILE_ARMS * stride;
    double *to = t->numbers + tile->columns + row * TILE_ARMS + h;
    wide sign = wide_of(row ? -1 : 1);
    for (int i = 0; i < tile->arms; i++, to += stride) {
        wide_put(to, sign * u->chi[i]);
        wide_put(to + rows, -sign * u->push[i]);
    }
    double *sway = t->numbers + tile->sway + row * TILE_ARMS + h;
    int outs = TILE_ROOT * tile->roots + TILE_PORT * tile->ports;
    for (int out = 0; out < outs; out++) {
        wide told = sign * tiles_told(t, tile, out, u);
        wide_put(sway + out * TILE_ANSWERS, tiles_alike(tile, out) ? told : -told);
    }
}

/* of units of a row of inputs: the outputs behind the inputs' columns */
VEC_INLINE void tiles_outputs(const struct tiles *t, const struct tile *tile, int row, int h,
                              const struct tiles_probe *u) {
    size_t stride = (size_t)(TILE_ANSWERS + tile->outs);
    double *to = t->numbers + tile->columns + (size_t)(row * TILE_ARMS + h) * stride + TILE_ANSWERS;
    int outs = TILE_ROOT * tile->roots + TILE_PORT * tile->ports;
    for (int out = 0; out < outs; out++) {
        wide told = tiles_told(t, tile, out, u);
        for (int lane = 0; lane < WIDE; lane++)
            to[(size_t)lane * stride + (size_t)out] = told[lane];
    }
}

/* of units of outputs: the ports' gains, and what makes of their outputs what these are */
VEC_INLINE void tiles_gains(const struct tiles *t, const struct tile *tile, int h,
                            const struct tiles_probe *u) {
    int roots = TILE_ROOT * tile->roots, wide_ports = TILE_PORT * tile->ports;
    double *mutual = tiles_mutual(t, tile);
    for (int out = roots; out < roots + wide_ports; out++) {
        wide told = tiles_told(t, tile, out, u);
        int port = (out - roots) / TILE_PORT, which = (out - roots) % TILE_PORT;
        int own = TILE_ROOT * t->port_root[tile->port + port];
        for (int lane = 0; lane < WIDE; lane++) {
            int by = h + lane;
            if (by >= roots && by < roots + wide_ports)
                mutual[(out - roots) * wide_ports + by - roots] = told[lane];
            if ((by == own || by == own + 1) && which < 2)
                tiles_port(t, tile, port)[which * TILE_ROOT + by - own] = told[lane];
        }
    }
}

/* all tables, after the factorization */
static void tiles_prepare(const struct bodies_system *s) {
    const struct tiles *t = s->tiles;
    for (const struct tile *tile = t->tile; tile < t->tile + t->count; tile++) {
        struct tiles_probe u;
        for (int j = 0; j < tile->ports; j++)
            tiles_lean(s, t, tile->port + j, tiles_port(t, tile, j) + TILE_ROOT * TILE_ROOT);
        for (int h = 0; h < TILE_ARMS; h += WIDE) {
            for (int row = 0; row < TILE_INPUTS; row++) {
                tiles_units(s, tile, row, h, &u);
                tiles_sweep(s, t, tile, &u);
                tiles_columns(t, tile, row, h, &u);
                tiles_outputs(t, tile, row, h, &u);
            }
            if (tile->ports) {
                tiles_outer(t, tile, h, &u);
                tiles_sweep(s, t, tile, &u);
                tiles_gains(t, tile, h, &u);
            }
        }
    }
}

#endif

#include "core/derivatives/kernel_derivatives.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define NUMBER_TANGENT
#include "core/simd/number.h"

#include "core/bodies/bodies_template.h"
#include "core/taylor/taylor_order.h"
#include "core/tree/turns.h"

/* For real pendulums that ideal_loads.h does not support, eight derivatives take 2.5 to 2.9 times
 * as long as eight members of an ensemble (tests/bench/parts/bench_derivatives.c). The alternative,
 * finite differences, needs two more motions per parameter and loses half of the digits. */

static_assert((int)DERIVATIVES_PASS == (int)TANGENT_PARAMETERS &&
                  sizeof(num) == DERIVATIVES_LANES * sizeof(double),
              "a pass is laid out as its numbers are");
static_assert(offsetof(num, part) == DERIVATIVES_FIRST * sizeof(double), "so are derivatives");

enum {
    DERIVATIVES_VALUE = TANGENT_PARTS,
    DERIVATIVES_PARTS = TANGENT_PARTS + 1,
    DERIVATIVES_TRAILING = 4,
    DERIVATIVES_LEADING = 4,
    DERIVATIVES_AHEAD = 4 /* orders stored beyond those of a series: rotation factors need two
                           * more */
};

/* log2 of the size, relative to the motion, below which a derivative does not limit the step,
 * because its rounding error has no bound of its own */
static const double derivatives_floor = -40;

/* Distance from one order to the next, an odd number: orders at a distance of an even number of
 * cache lines would evict each other, which takes five times as long with eight arms. */
static size_t derivatives_stride(int n) { return (size_t)(n < 8 ? n : 8) | 1; }

static size_t derivatives_tile(int n, int order) {
    return derivatives_stride(n) * (size_t)(order + DERIVATIVES_AHEAD);
}

static size_t derivatives_room(int n, int order) {
    return (size_t)(n + 7) / 8 * derivatives_tile(n, order) | 1;
}

static size_t derivatives_count(const struct pend_terms *terms, int n, int order) {
    size_t series = derivatives_room(n, order);
    return 4 * series + bodies_numbers(terms, (size_t)n, series, order);
}

VEC_INLINE num *derivatives_number(double *at) { return (num *)(void *)at; }

static struct bodies_system derivatives_system(const struct derivatives_pass *pass, double *memory,
                                               int order) {
    int n = pass->tree->n;
    size_t series = derivatives_room(n, order);
    num *at = derivatives_number(memory);
    struct bodies_system s = {.n = n,
                              .stride = derivatives_stride(n),
                              .tile = derivatives_tile(n, order),
                              .parent = pass->tree->parent,
                              .terms = pass->terms,
                              .len = derivatives_number(pass->len),
                              .mass = derivatives_number(pass->mass),
                              .value = derivatives_number(pass->value),
                              .rate = at,
                              .force = at + series,
                              .turn_re = at + 2 * series,
                              .turn_im = at + 3 * series};
    bodies_lay(&s, (size_t)n, series, order, at + 4 * series);
    return s;
}

/* addresses of the series of a step */
struct derivatives_series {
    size_t stride, tile;
    const num *rate, *force;
};

static struct derivatives_series derivatives_found(const struct derivatives_pass *pass) {
    int n = pass->tree->n;
    const num *at = derivatives_number(pass->series);
    return (struct derivatives_series){.stride = derivatives_stride(n),
                                       .tile = derivatives_tile(n, pass->order),
                                       .rate = at,
                                       .force = at + derivatives_room(n, pass->order)};
}

/* computes the angles to the parents, their cosines and sines, and the rates per unit of time */
static void derivatives_start(const struct bodies_system *s, const num phi[], const num low[],
                              const num rate[], num unit) {
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(s->terms, s->parent, k);
        num d = p < 0 ? phi[k] : num_sub(phi[k], phi[p]);
        double x = phi[k].value, y = p < 0 ? 0 : phi[p].value, gap = x - y;
        double back = x - gap, rest = (x - (gap + back)) + (back - y);
        if (low) rest += low[k].value - (p < 0 ? 0 : low[p].value);
        num_turn(d, rest, &s->sine[k], &s->cosine[k]);
        s->bend[k] =
            tangent_with(d, p < 0 ? (gap + M_PI_2) + (rest + PEND_QUARTER_LOW) : gap + rest);
        s->rate[bodies_row(s, k)] = num_mul(rate[k], unit);
    }
    if (!pend_terms_cart(s->terms)) return;
    double place = phi[0].value + (low ? low[0].value : 0);
    bodies_cart_start(s, tangent_with(phi[0], place));
}

/* ---- the length of a step */

/* part p of the derivatives; as last part, the value, in every lane */
VEC_INLINE wide derivatives_part(const num *x, int p) {
    return p < TANGENT_PARTS ? x->part[p] : wide_of(x->value);
}

/* log2 of the largest coefficients of order j: a lane for each derivative, and an extra part for
 * the value */
static void derivatives_norm(const struct bodies_system *s, int j, wide norm[DERIVATIVES_PARTS]) {
    for (int p = 0; p < DERIVATIVES_PARTS; p++) {
        wide most = wide_of(0);
        for (int k = 0; k < s->n; k++)
            most = WIDE_(peak)(
                derivatives_part(&s->rate[bodies_row(s, k) + (size_t)j * s->stride], p), most);
        norm[p] = WIDE_(log2)(most) - (wide)((wide_mask)(most == 0) & (wide_mask)wide_of(1e4));
    }
}

/* applies the rule of step_template to each lane; a derivative counts as at least
 * 2^derivatives_floor of the value's motion */
static double derivatives_reach(const struct bodies_system *s, int order, double log_rtol,
                                double log_atol) {
    wide leading[DERIVATIVES_LEADING][DERIVATIVES_PARTS], reach = wide_of(10);
    double spread = (PEND_TAYLOR_LOG_CAP - log_rtol) / (order + 1), least = 10;
    for (int i = 0; i < DERIVATIVES_LEADING; i++) {
        derivatives_norm(s, i, leading[i]);
        wide floor = leading[i][DERIVATIVES_VALUE] + derivatives_floor;
        for (int p = 0; p < DERIVATIVES_PARTS; p++)
            leading[i][p] = WIDE_(max)(leading[i][p], floor) - log2(i + 1);
    }
    for (int j = order - DERIVATIVES_TRAILING + 1; j <= order; j++) {
        wide trailing[DERIVATIVES_PARTS];
        derivatives_norm(s, j, trailing);
        for (int p = 0; p < DERIVATIVES_PARTS; p++) {
            wide far = log_atol / (order + 2) - trailing[p] / (double)(j + 1);
            wide here = wide_of(-1e4);
            for (int i = 0; i < DERIVATIVES_LEADING; i++)
                here = WIDE_(max)(here, log_rtol / (order + 1 - i) +
                                            (leading[i][p] - trailing[p]) / (double)(j - i));
            here = WIDE_(max)(here, WIDE_(min)(far, here + spread));
            reach = WIDE_(min)(reach, here);
        }
    }
    for (int i = 0; i < WIDE; i++) least = fmin(least, reach[i]);
    return exp2(fmax(least, -60));
}

static int derivatives_finite(const struct bodies_system *s, int order) {
    wide bad = wide_of(0);
    for (int k = 0; k < s->n; k++)
        for (int j = 0; j <= order; j++)
            for (int p = 0; p < DERIVATIVES_PARTS; p++)
                bad += derivatives_part(&s->rate[bodies_row(s, k) + (size_t)j * s->stride], p) * 0;
    double sum = 0;
    for (int i = 0; i < WIDE; i++) sum += bad[i];
    return sum == 0;
}

static double derivatives_expand(const struct derivatives_pass *pass, double log_rtol,
                                 double log_atol) {
    struct bodies_system s = derivatives_system(pass, pass->series, pass->order);
    double sum = pass->start + pass->time, part = sum - pass->start;
    double late = (pass->start - (sum - part)) + (pass->time - part);
    num unit = num_of(pass->unit);
    num gravity = num_mul(*derivatives_number(pass->gravity), num_of(pass->unit * pass->unit));
    struct bodies_moment now = {unit, gravity, num_of(sum), num_of(late)};
    derivatives_start(&s, derivatives_number(pass->phi), derivatives_number(pass->phi_low),
                      derivatives_number(pass->rate), unit);
    bodies_orders(&s, &now, pass->order);
    if (!derivatives_finite(&s, pass->order)) return NAN;
    double reach = derivatives_reach(&s, pass->order, log_rtol, log_atol);
    return s.need & BODIES_FRICTION ? bodies_reach(&s, num_of(reach)).value : reach;
}

static void derivatives_press(const struct derivatives_pass *pass) {
    struct bodies_system s = derivatives_system(pass, pass->series, pass->order);
    bodies_forces(&s, pass->order);
}

/* ---- state inside a step */

/* adds a value to a sum of two doubles */
VEC_INLINE void derivatives_sum(double *high, double *low, double *from, double *from_low, int k,
                                num add) {
    num x = derivatives_number(from)[k];
    num more = num_add(add, derivatives_number(from_low)[k]);
    num total = num_add(x, more), part = num_sub(total, x);
    derivatives_number(high)[k] = total;
    derivatives_number(low)[k] = num_add(num_sub(x, num_sub(total, part)), num_sub(more, part));
}

/* of one arm: phi and unit phi' minus their start, unit^2 phi'' and unit^2 lambda */
struct derivatives_sums {
    num phi, rate, acc, force;
};

VEC_INLINE num derivatives_horner(num sum, double x, num c, double factor) {
    for (int p = 0; p < TANGENT_PARTS; p++)
        sum.part[p] = wide_fma(sum.part[p], wide_of(x), c.part[p] * factor);
    return tangent_with(sum, lanes1_fma(sum.value, x, c.value * factor));
}

VEC_INLINE struct derivatives_sums derivatives_at(const struct derivatives_series *s, int order,
                                                  int k, double x, const double share[], int all) {
    num zero = num_of(0);
    struct derivatives_sums sum = {zero, zero, zero, zero};
    size_t row = (size_t)(k / 8) * s->tile + (size_t)(k % 8);
    const num *rate = s->rate + row, *force = s->force + row;
    for (int j = order; j >= 1; j--) {
        num c = rate[(size_t)j * s->stride];
        sum.phi = derivatives_horner(sum.phi, x, c, share[j]);
        sum.rate = derivatives_horner(sum.rate, x, c, 1);
        if (!all) continue;
        sum.acc = derivatives_horner(sum.acc, x, c, j);
        sum.force = derivatives_horner(sum.force, x, force[(size_t)(j - 1) * s->stride], 1);
    }
    sum.phi = derivatives_horner(derivatives_horner(sum.phi, x, rate[0], 1), x, zero, 1);
    sum.rate = derivatives_horner(sum.rate, x, zero, 1);
    return sum;
}

static void derivatives_advance(const struct derivatives_pass *pass, double x) {
    struct derivatives_series s = derivatives_found(pass);
    for (int k = 0; k < pass->tree->n; k++) {
        struct derivatives_sums sum = derivatives_at(&s, pass->order, k, x, pass->share, 0);
        num rate = num_mul(sum.rate, num_of(1 / pass->unit));
        derivatives_sum(pass->end_phi, pass->end_low, pass->phi, pass->phi_low, k, sum.phi);
        derivatives_sum(pass->end_rate, pass->slow, pass->rate, pass->rate_low, k, rate);
    }
}

static void derivatives_values(const struct derivatives_pass *pass, double x,
                               const struct derivatives_view *view) {
    struct derivatives_series s = derivatives_found(pass);
    double inverse = 1 / pass->unit;
    int all = view->acc || view->force;
    for (int k = 0; k < pass->tree->n; k++) {
        struct derivatives_sums sum = derivatives_at(&s, pass->order, k, x, pass->share, all);
        const num *phi = derivatives_number(pass->phi), *low = derivatives_number(pass->phi_low);
        const num *rate = derivatives_number(pass->rate),
                  *slow = derivatives_number(pass->rate_low);
        derivatives_number(view->phi)[k] = num_add(phi[k], num_add(sum.phi, low[k]));
        num gain = num_mul(sum.rate, num_of(inverse)), square = num_of(inverse * inverse);
        derivatives_number(view->rate)[k] = num_add(rate[k], num_add(gain, slow[k]));
        if (view->acc) derivatives_number(view->acc)[k] = num_mul(sum.acc, square);
        if (view->force) derivatives_number(view->force)[k] = num_mul(sum.force, square);
    }
}

/* ---- quantities that follow from a state */

struct derivatives_vector {
    num x, y;
};

/* the pivot's position, or its time derivative of the given order */
static struct derivatives_vector derivatives_pivot(const struct bodies_system *s,
                                                   const struct bodies_moment *now, int order) {
    struct derivatives_vector sum = {num_of(0), num_of(0)};
    num t = now->time, half = num_mul(num_mul(t, t), num_of(0.5));
    num part = order == 2 ? num_of(1) : order ? t : half;
    sum.x = num_mul(part, bodies_one(s, PEND_TERM_PIVOT_ACCELERATION_X));
    sum.y = num_mul(part, bodies_one(s, PEND_TERM_PIVOT_ACCELERATION_Y));
    for (int y = 0; y < 2 && s->terms->one[PEND_TERM_PIVOT_TRACK] >= 0; y++) {
        const num *track = s->value + s->terms->one[PEND_TERM_PIVOT_TRACK] + y;
        num since = num_sub(t, bodies_one(s, PEND_TERM_PIECE)), add = num_of(0);
        for (int j = 3; j >= order; j--)
            add = num_fma(num_mul(add, since), num_of(1.0 / (j + 1 - order)), track[2 * j]);
        num *to = y ? &sum.y : &sum.x;
        *to = num_add(*to, add);
    }
    for (int i = 0; i < s->terms->harmonics && s->terms->harmonic[i].drives < 0; i++) {
        const struct pend_harmonic *h = &s->terms->harmonic[i];
        num *to = h->drives == PEND_DRIVE_PIVOT_X ? &sum.x : &sum.y;
        bodies_harmonic(s->value + h->at, s->share, now, order, 0, to, 1);
    }
    return sum;
}

/* x + i y rotated by u */
VEC_INLINE struct derivatives_vector derivatives_turn(num x, num y, struct derivatives_vector u) {
    return (struct derivatives_vector){num_sub(num_mul(x, u.x), num_mul(y, u.y)),
                                       num_fma(x, u.y, num_mul(y, u.x))};
}

/* the first or second time derivative of a rotating vector */
VEC_INLINE struct derivatives_vector derivatives_swing(struct derivatives_vector v, num rate,
                                                       num acc, int order) {
    if (!order) return v;
    if (order == 1)
        return (struct derivatives_vector){num_neg(num_mul(rate, v.y)), num_mul(rate, v.x)};
    num square = num_mul(rate, rate);
    return (struct derivatives_vector){num_neg(num_fma(acc, v.y, num_mul(square, v.x))),
                                       num_sub(num_mul(acc, v.x), num_mul(square, v.y))};
}

/* a displacement along the rail of a cart, in fixed axes */
static struct derivatives_vector derivatives_rail(const struct bodies_system *s, num way) {
    return (struct derivatives_vector){num_neg(num_mul(s->point_y[0], way)),
                                       num_mul(s->point_x[0], way)};
}

/* position, velocity or acceleration of the joint of arm k: on the pivot, on a cart, or on its
 * parent */
static struct derivatives_vector derivatives_joint(const struct bodies_system *s,
                                                   const struct derivatives_view *view, int order,
                                                   int k, struct derivatives_vector pivot) {
    const num *rate = derivatives_number(view->rate), *acc = derivatives_number(view->acc);
    int p = s->parent[k], cart = pend_terms_cart(s->terms);
    if (cart && !k) {
        const num *way = order == 2 ? acc : order ? rate : derivatives_number(view->phi);
        struct derivatives_vector moved = derivatives_rail(s, way ? way[0] : num_of(0));
        return (struct derivatives_vector){num_add(pivot.x, moved.x), num_add(pivot.y, moved.y)};
    }
    if (p < 0) return pivot;
    struct derivatives_vector base = {s->base_x[p], s->base_y[p]};
    if (cart && !p) return base;
    struct derivatives_vector up = {s->wind_x[p], s->wind_y[p]};
    up = derivatives_turn(s->point_x[k], s->point_y[k], up);
    up = derivatives_swing(up, rate[p], acc ? acc[p] : num_of(0), order);
    return (struct derivatives_vector){num_add(base.x, up.x), num_add(base.y, up.y)};
}

/* Positions, velocities or accelerations of all tips and joints, in fixed axes. The directions of
 * the arms are in wind, the joints in base; for a cart, tip and joint coincide. */
static void derivatives_tips(const struct bodies_system *s, const struct bodies_moment *now,
                             const struct derivatives_view *view, int order, num re[], num im[]) {
    const num *rate = derivatives_number(view->rate), *acc = derivatives_number(view->acc);
    struct derivatives_vector pivot = derivatives_pivot(s, now, order);
    for (int k = 0; k < s->n; k++) {
        struct derivatives_vector u = {s->wind_x[k], s->wind_y[k]};
        struct derivatives_vector base = derivatives_joint(s, view, order, k, pivot);
        num zero = num_of(0);
        s->base_x[k] = base.x, s->base_y[k] = base.y;
        struct derivatives_vector arm = derivatives_turn(s->len[k], zero, u);
        arm = derivatives_swing(arm, rate[k], acc ? acc[k] : zero, order);
        if (re) re[k] = num_add(base.x, arm.x);
        if (im) im[k] = num_add(base.y, arm.y);
    }
}

/* kinetic energy, from the joints' velocities in base: M |v|^2 / 2 + Re(conj(v) i h u) phi' + J
 * phi'^2 / 2; for a cart only the first term */
static num derivatives_kinetic(const struct bodies_system *s, const num rate[]) {
    num sum = num_of(0), half = num_of(0.5);
    for (int k = 0; k < s->n; k++) {
        struct derivatives_vector u = {s->wind_x[k], s->wind_y[k]};
        struct derivatives_vector h = derivatives_turn(s->moment_x[k], s->moment_y[k], u);
        num vx = s->base_x[k], vy = s->base_y[k], square = num_fma(vx, vx, num_mul(vy, vy));
        num across = num_sub(num_mul(vy, h.x), num_mul(vx, h.y));
        sum = num_fma(num_mul(half, s->body[k]), square, sum);
        if (!k && pend_terms_cart(s->terms)) continue;
        sum = num_fma(rate[k], across, sum);
        sum = num_fma(num_mul(half, s->inertia[k]), num_mul(rate[k], rate[k]), sum);
    }
    return sum;
}

/* potential energy of gravity and springs, from the positions of the joints in base */
static num derivatives_potential(const struct bodies_system *s, num gravity) {
    num sum = num_of(0), half = num_of(0.5);
    for (int k = 0; k < s->n; k++) {
        struct derivatives_vector u = {s->wind_x[k], s->wind_y[k]};
        struct derivatives_vector h = derivatives_turn(s->moment_x[k], s->moment_y[k], u);
        num bent = num_sub(s->bend[k], bodies_get(s, PEND_TERM_REST, k));
        num stiff = num_mul(half, bodies_get(s, PEND_TERM_STIFFNESS, k));
        if (!k && pend_terms_cart(s->terms)) h.y = num_of(0);
        sum = num_fma(gravity, num_fma(s->body[k], s->base_y[k], h.y), sum);
        sum = num_fma(stiff, num_mul(bent, bent), sum);
    }
    return sum;
}

/* computes accelerations and forces of the state, in the scratch memory that tips used */
static void derivatives_forces(const struct bodies_system *s, const struct bodies_moment *now,
                               const struct derivatives_view *view) {
    bodies_orders(s, now, 1);
    for (int k = 0; k < s->n; k++) {
        size_t row = bodies_row(s, k);
        if (view->acc) derivatives_number(view->acc)[k] = s->rate[row + s->stride];
        if (view->force) derivatives_number(view->force)[k] = s->tip_x[row];
        if (view->tip_across) derivatives_number(view->tip_across)[k] = s->tip_y[row];
        if (view->joint_along) derivatives_number(view->joint_along)[k] = s->reach_x[k];
        if (view->joint_across) derivatives_number(view->joint_across)[k] = s->reach_y[k];
    }
    if (!pend_terms_cart(s->terms)) return;
    // the force that the rail exerts on the cart, across the rail
    num c = num_neg(s->point_y[0]), z = s->point_x[0];
    num across = num_sub(num_mul(c, s->pivot_force_y[0]), num_mul(z, s->pivot_force_x[0]));
    if (view->joint_across) derivatives_number(view->joint_across)[0] = across;
}

/* writes the directions of the arms into wind */
static void derivatives_directions(const struct bodies_system *s, const num phi[]) {
    for (int k = 0; k < s->n; k++) num_turn(phi[k], 0, &s->wind_y[k], &s->wind_x[k]);
    if (pend_terms_cart(s->terms)) s->wind_x[0] = num_of(1), s->wind_y[0] = num_of(0);
}

static void derivatives_observe(const struct derivatives_pass *pass, double time, int dynamics,
                                const struct derivatives_view *view) {
    struct bodies_system s = derivatives_system(pass, pass->place, 1);
    num gravity = *derivatives_number(pass->gravity), zero = num_of(0);
    const num *phi = derivatives_number(view->phi), *rate = derivatives_number(view->rate);
    struct bodies_moment now = {num_of(1), gravity, num_of(time), zero};
    derivatives_start(&s, phi, NULL, rate, num_of(1));
    if (dynamics) derivatives_forces(&s, &now, view);
    for (int k = 0; k < s.n; k++) {
        bodies_point(&s, k);
        bodies_alone(&s, k);
    }
    derivatives_directions(&s, phi);
    if (view->z_re || view->potential) {
        derivatives_tips(&s, &now, view, 0, derivatives_number(view->z_re),
                         derivatives_number(view->z_im));
        if (view->potential)
            *derivatives_number(view->potential) = derivatives_potential(&s, gravity);
    }
    if (view->zd_re || view->kinetic) {
        derivatives_tips(&s, &now, view, 1, derivatives_number(view->zd_re),
                         derivatives_number(view->zd_im));
        if (view->kinetic) *derivatives_number(view->kinetic) = derivatives_kinetic(&s, rate);
    }
    if (view->zdd_re)
        derivatives_tips(&s, &now, view, 2, derivatives_number(view->zdd_re),
                         derivatives_number(view->zdd_im));
}

const struct derivatives_kernel KERNEL_NAME(pend_kernel_derivatives_) = {
    .count = derivatives_count,
    .expand = derivatives_expand,
    .press = derivatives_press,
    .advance = derivatives_advance,
    .values = derivatives_values,
    .observe = derivatives_observe,
};

#include "core/extended/kernel_quad.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/simd/vec_isa.h"
#include "core/taylor/taylor_order.h"

#define NUMBER_QUAD_DOUBLE
#include "core/taylor/jets_template.h"

/* the general kernel calls its arithmetic: put into every place, it would take minutes to compile
 */
#define QUAD_CALL(name) static __attribute__((noinline)) quad quad_call_##name(quad x, quad y)
QUAD_CALL(add) { return quad_add(x, y); }
QUAD_CALL(sub) { return quad_sub(x, y); }
QUAD_CALL(mul) { return quad_mul(x, y); }
QUAD_CALL(div) { return quad_div(x, y); }
static __attribute__((noinline)) quad quad_call_fma(quad x, quad y, quad z) {
    return quad_fma(x, y, z);
}
#undef num_add
#undef num_sub
#undef num_mul
#undef num_div
#undef num_fma
#define num_add quad_call_add
#define num_sub quad_call_sub
#define num_mul quad_call_mul
#define num_div quad_call_div
#define num_fma quad_call_fma
#include "core/bodies/bodies_template.h"
#include "core/taylor/jets_bodies.h"
#undef num_add
#undef num_sub
#undef num_mul
#undef num_div
#undef num_fma
#define num_add quad_add
#define num_sub quad_sub
#define num_mul quad_mul
#define num_div quad_div
#define num_fma quad_fma

enum {
#define X(name) QUAD_##name,
    JETS_ARRAYS(X)
#undef X
        QUAD_ARRAYS,
    QUAD_LEADING = 4,
    QUAD_TRAILING = 4
};

static size_t quad_rows(int n, int order) { return (size_t)n * (size_t)(order + 4); }

/* numbers of an ideal pendulum */
static size_t quad_ideal(int n, int order) {
    return 4 * quad_rows(n, order) + (size_t)QUAD_ARRAYS * (size_t)n;
}

static size_t quad_count(const struct pend_terms *terms, int n, int order) {
    size_t real = 0;
    if (terms)
        real = (size_t)terms->count + bodies_numbers(terms, (size_t)n, quad_rows(n, order), order);
    return 4 * (quad_ideal(n, order) + real);
}

/* a row of eight arms and their series follow each other, as jets_row has it: one tile an arm
 * group of eight */
static struct jets_system quad_view(const struct quad_series *q) {
    size_t n = (size_t)q->tree->n, rows = quad_rows(q->tree->n, q->order);
    num *at = (num *)(void *)q->numbers, *arrays = at + 4 * rows;
    struct jets_system s = {.n = q->tree->n,
                            .stride = n,
                            .tile = 8,
                            .parent = q->tree->parent,
                            .end = q->tree->end,
                            .rate = at,
                            .force = at + rows + n, // row -1 is zero
                            .turn_re = at + 2 * rows,
                            .turn_im = at + 3 * rows,
#define X(name) .name = arrays + (size_t)QUAD_##name * n,
                            JETS_ARRAYS(X)
#undef X
    };
    return s;
}

/* the same of a real pendulum, with the numbers of its terms, behind those of ideal ones */
static struct bodies_system quad_real(const struct quad_series *q, const struct jets_system *s) {
    const struct pend_terms *terms = q->loads.terms;
    num *value = (num *)(void *)q->numbers + quad_ideal(s->n, q->order);
    struct bodies_system b = jets_bodies(s, terms, value);
    for (int j = 0; j < terms->count; j++) value[j] = num_of(q->loads.value[j]);
    bodies_lay(&b, (size_t)s->n, quad_rows(s->n, q->order), q->order, value + terms->count);
    return b;
}

static num quad_get(const double *at, int k) {
    num x;
    memcpy(&x, at + 4 * (size_t)k, sizeof x);
    return x;
}

/* jets_learn with quotients to all digits */
static void quad_learn(const struct jets_system *s, int k) {
    for (int a = 0; a < s->n; a++) {
        size_t now = jets_row(s, a) + (size_t)k * s->stride, next = now + s->stride,
               after = next + s->stride;
        num gap = num_sub(num_mul(s->sine[a], s->from_radial[a]),
                          num_mul(s->cosine[a], s->from_tangential[a]));
        num acc = num_mul(num_add(gap, s->tangential[a]), s->inv_len[a]);
        acc = num_sub(acc, num_mul(num_of(k + 1), s->wind_re[a]));
        num rate = num_div(acc, num_of(k + 1));
        s->force[now] =
            num_sub(num_fma(s->stiff[a], s->from_radial[a], s->tension[a]), s->drag_re[a]);
        s->rate[next] = rate;
        s->turn_re[after] = num_neg(num_div(s->wind_im[a], num_of(k + 2)));
        s->turn_im[after] = num_div(num_add(rate, s->wind_re[a]), num_of(k + 2));
    }
}

/* ---- orders whose coefficients are small: convolutions of the first two doubles of every
 * number */

struct quad_pair {
    double high, low;
};

VEC_INLINE struct quad_pair pair_gather(const num *x, const num *y, struct quad_pair sum) {
    double rest, gap, product = quad_product(x->part[0], y->part[0], &rest);
    double high = quad_total(sum.high, product, &gap);
    rest += x->part[0] * y->part[1] + x->part[1] * y->part[0];
    return (struct quad_pair){high, sum.low + (gap + rest)};
}

VEC_INLINE num pair_num(struct quad_pair x) { return num_of2(x.high, x.low); }

/* jets_known in them */
static void quad_known(const struct jets_system *s, int k) {
    static const struct quad_pair none = {0, 0};
    size_t stride = s->stride;
    for (int a = 0; a < s->n; a++) {
        size_t row = jets_row(s, a), last = row + (size_t)k * stride;
        const num *re = s->turn_re + row + 2 * stride, *im = s->turn_im + row + 2 * stride;
        const num *rate = s->rate + last, *force = s->force + last - stride, *first = s->rate + row;
        // u_1 is imaginary
        struct quad_pair Tr = none, Ti = pair_gather(first, rate, none), cr = none,
                         ci = pair_gather(first, force, none);
        struct quad_pair next_Tr = none, next_Ti = none, next_cr = none, next_ci = none;
        for (int j = 2; j <= k + 1; j++, re += stride, im += stride) {
            next_Tr = pair_gather(re, rate, next_Tr);
            next_Ti = pair_gather(im, rate, next_Ti);
            next_cr = pair_gather(re, force, next_cr);
            next_ci = pair_gather(im, force, next_ci);
            rate -= stride, force -= stride;
            Tr = pair_gather(re, rate, Tr);
            Ti = pair_gather(im, rate, Ti);
            cr = pair_gather(re, force, cr);
            ci = pair_gather(im, force, ci);
        }
        jets_prepare(s, k, a, pair_num(Tr), pair_num(Ti), pair_num(cr), pair_num(ci));
        s->next_wind_re[a] = pair_num(next_Tr), s->next_wind_im[a] = pair_num(next_Ti);
        s->next_drag_re[a] = pair_num(next_cr), s->next_drag_im[a] = pair_num(next_ci);
    }
}

/* ---- the step */

static void quad_start(const struct quad_series *q, const struct jets_system *s) {
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(q->loads.terms, s->parent, k);
        num angle = quad_get(q->phi, k);
        if (p >= 0) angle = num_sub(angle, quad_get(q->phi, p));
        num_sincos(angle, &s->sine[k], &s->cosine[k]);
        s->len[k] = num_of(q->tree->len[k]);
        s->inv_len[k] = num_div(num_of(1), s->len[k]);
        s->mass[k] = num_of(q->tree->mass[k]);
        s->rate[k] = num_scale(quad_get(q->rate, k), q->unit);
        s->force[k - s->n] = num_of(0);
    }
}

/* the tree system of order 0 */
static void quad_factor(const struct jets_system *s) {
    jets_factor(s);
    for (int k = 0; k < s->n; k++) {
        s->stiff[k] = num_mul(s->eff[k], s->kappa[k]);
        s->weight[k] = num_mul(s->eff[k], s->len[k]);
        s->turn_re[jets_row(s, k) + s->stride] = num_of(0);
        s->turn_im[jets_row(s, k) + s->stride] = s->rate[jets_row(s, k)];
    }
}

/* binary logarithm of the largest coefficient of order j */
static double quad_norm(const struct jets_system *s, int j) {
    double norm = 0;
    for (int k = 0; k < s->n; k++)
        norm = fmax(norm, fabs(s->rate[jets_row(s, k) + (size_t)j * s->stride].part[0]));
    return norm > 0 ? log2(norm) : -1e4;
}

/* the step in units, by the rule of the taylor method */
static double quad_choose(const struct jets_system *s, int order, double log_rtol,
                          double log_atol) {
    double reach = 10, leading[QUAD_LEADING];
    for (int i = 0; i < QUAD_LEADING; i++) leading[i] = quad_norm(s, i) - log2(i + 1);
    for (int j = order - QUAD_TRAILING + 1; j <= order; j++) {
        double trailing = quad_norm(s, j),
               far = (log_atol - trailing * (order + 2) / (j + 1)) / (order + 2), here = -1e4;
        for (int i = 0; i < QUAD_LEADING; i++)
            here = fmax(here, log_rtol / (order + 1 - i) + (leading[i] - trailing) / (j - i));
        here = fmax(here, fmin(far, here + (PEND_TAYLOR_LOG_CAP - log_rtol) / (order + 1)));
        reach = fmin(reach, here);
    }
    return exp2(fmax(reach, -60));
}

/* all orders of an ideal pendulum */
static void quad_orders(const struct quad_series *q, const struct jets_system *s, num gravity) {
    quad_factor(s);
    for (int k = 0; k < q->order; k++) {
        if (k % 2)
            jets_complete(s, k);
        else if (k < q->precise)
            jets_known(s, k);
        else
            quad_known(s, k);
        jets_up(s);
        jets_down(s, k ? num_of(0) : gravity);
        quad_learn(s, k);
    }
}

/* all orders of a real pendulum */
static void quad_bodies(const struct quad_series *q, const struct jets_system *s, num gravity) {
    const num quarter = {{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110,
                          0x1.4cf98e804177dp-164}};
    struct bodies_system b = quad_real(q, s);
    struct bodies_moment now = {num_of(q->unit), gravity, num_of(q->start), num_of(q->time)};
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(b.terms, s->parent, k);
        num from = p < 0 ? num_neg(quarter) : quad_get(q->phi, p);
        b.bend[k] = num_sub(quad_get(q->phi, k), from);
        b.sine[k] = s->sine[k], b.cosine[k] = s->cosine[k];
    }
    if (pend_terms_cart(b.terms)) bodies_cart_start(&b, quad_get(q->phi, 0));
    bodies_orders(&b, &now, q->order);
    bodies_forces(&b, q->order);
}

static double quad_expand(const struct quad_series *q, double log_rtol, double log_atol) {
    struct jets_system s = quad_view(q);
    num gravity = num_scale(num_of(q->loads.gravity), q->unit * q->unit);
    quad_start(q, &s);
    if (q->loads.terms)
        quad_bodies(q, &s, gravity);
    else
        quad_orders(q, &s, gravity);
    double sum = 0;
    for (int j = 0; j <= q->order; j++)
        for (int k = 0; k < s.n; k++)
            sum += s.rate[jets_row(&s, k) + (size_t)j * s.stride].part[0] * 0;
    if (sum != 0) return NAN;
    double reach = quad_choose(&s, q->order, log_rtol, log_atol);
    if (!q->loads.terms) return reach;
    struct bodies_system b = quad_real(q, &s);
    return b.need & BODIES_GRIP ? bodies_reach(&b, num_of(reach)).part[0] : reach;
}

/* phi less its start, unit phi', unit^2 phi'' and unit^2 lambda of an arm, x units after the
 * start */
struct quad_sums {
    num phi, rate, acc, force;
};

static struct quad_sums quad_horner(const struct quad_series *q, const struct jets_system *s, int k,
                                    num x, int all) {
    struct quad_sums sum = {num_of(0), num_of(0), num_of(0), num_of(0)};
    for (int j = q->order; j >= 0; j--) {
        num c = s->rate[jets_row(s, k) + (size_t)j * s->stride];
        sum.phi = num_fma(sum.phi, x, num_div(c, num_of(j + 1)));
        sum.rate = num_fma(sum.rate, x, c);
        if (!all) continue;
        if (j) sum.acc = num_fma(sum.acc, x, num_mul(c, num_of(j)));
        if (j < q->order)
            sum.force = num_fma(sum.force, x, s->force[jets_row(s, k) + (size_t)j * s->stride]);
    }
    sum.phi = num_mul(sum.phi, x);
    return sum;
}

static void quad_advance(const struct quad_series *q, double time, double reached) {
    struct jets_system s = quad_view(q);
    num x = num_scale(num_of2(reached, -time), 1 / q->unit);
    for (int k = 0; k < s.n; k++) {
        struct quad_sums sum = quad_horner(q, &s, k, x, 0);
        num phi = num_add(quad_get(q->phi, k), sum.phi), rate = num_scale(sum.rate, 1 / q->unit);
        memcpy(q->phi_end + 4 * (size_t)k, &phi, sizeof phi);
        memcpy(q->rate_end + 4 * (size_t)k, &rate, sizeof rate);
    }
}

static void quad_at(const struct quad_series *q, double time, double t,
                    const struct quad_values *to) {
    struct jets_system s = quad_view(q);
    double inverse = 1 / q->unit;
    num x = num_scale(num_of2(t, -time), inverse),
        quarter = num_of2(0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54);
    for (int k = 0; k < s.n; k++) {
        struct quad_sums sum = quad_horner(q, &s, k, x, to->acc || to->force);
        num phi = num_add(quad_get(q->phi, k), sum.phi);
        to->phi[k] = phi.part[0];
        to->rate[k] = sum.rate.part[0] * inverse;
        if (to->acc) to->acc[k] = sum.acc.part[0] * (inverse * inverse);
        if (to->force) to->force[k] = sum.force.part[0] * (inverse * inverse);
        if (to->theta) to->theta[k] = num_add(phi, quarter).part[0];
    }
}

static void quad_power(const struct quad_series *q, double work[], double heat[]) {
    struct jets_system s = quad_view(q);
    struct bodies_system b = quad_real(q, &s);
    num given[BODIES_ORDERS], lost[BODIES_ORDERS];
    bodies_power(&b, num_of(q->unit), q->order, q->order, given, lost);
    for (int j = 0; j < q->order; j++) work[j] = given[j].part[0], heat[j] = lost[j].part[0];
}

const struct quad_kernel KERNEL_NAME(pend_kernel_quad_) = {
    .count = quad_count,
    .expand = quad_expand,
    .advance = quad_advance,
    .values = quad_at,
    .power = quad_power,
};

#include "core/integrate/methods/kernel_exchange.h"

/* Gauss-Legendre nodes of order 24 on 0 .. 1; the remaining lanes hold zeros */
enum { NODES = 12, LANES_OF_NODES = 16, PARTS = (NODES + WIDE - 1) / WIDE };

static const _Alignas(64) double nodes[LANES_OF_NODES] = {
    0.00921968287664037465, 0.04794137181476257166, 0.11504866290284765648, 0.20634102285669127635,
    0.31608425050090990312, 0.43738329574426554226, 0.56261670425573445774, 0.68391574949909009688,
    0.79365897714330872365, 0.88495133709715234352, 0.95205862818523742834, 0.99078031712335962535};
static const _Alignas(64) double weights[LANES_OF_NODES] = {
    0.02358766819325591360, 0.05346966299765921548, 0.08003916427167311317, 0.10158371336153296087,
    0.11674626826917740438, 0.12457352290670139250, 0.12457352290670139250, 0.11674626826917740438,
    0.10158371336153296087, 0.08003916427167311317, 0.05346966299765921548, 0.02358766819325591360};

struct at_nodes {
    wide part[PARTS];
};

static inline struct at_nodes nodes_of(double x) {
    struct at_nodes at;
    for (int p = 0; p < PARTS; p++) at.part[p] = wide_get(nodes + p * WIDE) * x;
    return at;
}

/* coefficient j of a series whose terms are `stride` apart, minus coefficient j of `from`, if that
 * is not NULL */
static inline wide nodes_term(const double *a, const double *from, int stride, int j) {
    return wide_of(a[j * stride] - (from ? from[j * stride] : 0));
}

/* sums a series of `order` terms; even and odd terms have separate sums, which are computed in
 * parallel */
static inline struct at_nodes nodes_sum(const struct at_nodes *x, const double *a,
                                        const double *from, int stride, int order) {
    struct at_nodes even, odd, square;
    wide top = order % 2 ? nodes_term(a, from, stride, order - 1) : wide_of(0);
    for (int p = 0; p < PARTS; p++) {
        square.part[p] = x->part[p] * x->part[p];
        even.part[p] = top, odd.part[p] = wide_of(0);
    }
    for (int j = order / 2 * 2 - 2; j >= 0; j -= 2) {
        wide low = nodes_term(a, from, stride, j), high = nodes_term(a, from, stride, j + 1);
        for (int p = 0; p < PARTS; p++) {
            even.part[p] = wide_fma(even.part[p], square.part[p], low);
            odd.part[p] = wide_fma(odd.part[p], square.part[p], high);
        }
    }
    for (int p = 0; p < PARTS; p++) even.part[p] = wide_fma(odd.part[p], x->part[p], even.part[p]);
    return even;
}

/* adds to the power a factor times the product of a and b */
static inline void nodes_add(struct at_nodes *power, double factor, const struct at_nodes *a,
                             const struct at_nodes *b) {
    for (int p = 0; p < PARTS; p++)
        power->part[p] = wide_fma(factor * a->part[p], b->part[p], power->part[p]);
}

/* The integral over the nodes' interval of length 1. The order of summation is the same for every
 * vector width. */
static inline double nodes_integral(const struct at_nodes *power) {
    double each[PARTS * WIDE], sum[4] = {0};
    for (int p = 0; p < PARTS; p++) {
        wide part = wide_get(weights + p * WIDE) * power->part[p];
        memcpy(each + p * WIDE, &part, sizeof part);
    }
    for (int i = 0; i < NODES; i += 4)
        for (int k = 0; k < 4; k++) sum[k] += each[i + k];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* fills in the friction of up to eight arms from the rates of their joints; returns its integral */
static double nodes_loss(const struct jets_system *s, double x, const double damping[], double unit,
                         int order) {
    struct at_nodes at = nodes_of(x), power = nodes_of(0);
    for (int k = 0; k < s->n; k++) {
        int p = s->parent[k];
        struct at_nodes slip =
            nodes_sum(&at, s->rate + k, p < 0 ? NULL : s->rate + p, PEND_JETS_PAD, order);
        nodes_add(&power, damping[k] * unit, &slip, &slip);
    }
    return nodes_integral(&power);
}

/* Computes the friction of eight arms of a larger tree, arms in lanes, node by node, and adds its
 * integral to that of each arm. */
static void nodes_tile(const struct jets_system *s, const double x[NODES], int tile, int order,
                       double sum[PEND_JETS_PAD]) {
    const struct jets_loads *loads = s->loads;
    for (int i = 0; i < PEND_JETS_PAD; i += WIDE) {
        int a = tile * PEND_JETS_PAD + i;
        const double *slip = loads->slips + jets_row(s, a);
        wide at[NODES], power = wide_of(0);
        for (int k = 0; k < NODES; k++) at[k] = wide_of(0);
        for (int j = order - 1; j >= 0; j--) {
            wide c = wide_get(slip + j * PEND_JETS_PAD);
            for (int k = 0; k < NODES; k++) at[k] = wide_fma(at[k], wide_of(x[k]), c);
        }
        for (int k = 0; k < NODES; k++) power = wide_fma(at[k] * at[k], wide_of(weights[k]), power);
        wide_put(sum + i, wide_fma(power, wide_get(loads->hold + a), wide_get(sum + i)));
    }
}

static double nodes_losses(const struct jets_system *s, double x, int order) {
    _Alignas(64) double sum[PEND_JETS_PAD] = {0};
    double place[NODES], all = 0;
    for (int k = 0; k < NODES; k++) place[k] = nodes[k] * x;
    for (int tile = 0; tile < s->tiles; tile++) nodes_tile(s, place, tile, order, sum);
    for (int i = 0; i < PEND_JETS_PAD; i++) all += sum[i];
    return all;
}

/* computes the torques, stored as forces across the arms */
static void nodes_effort(const struct jets_system *s, const struct at_nodes *x, int order,
                         struct at_nodes *power) {
    const double *force = s->loads->given + (s->n > 4 ? 8 : s->n > 2 ? 4 : 2);
    int orders = jets_loads_torques(s->loads, order);
    for (int k = 0; k < s->n; k++) {
        struct at_nodes rate = nodes_sum(x, s->rate + k, NULL, PEND_JETS_PAD, order);
        struct at_nodes pull = nodes_sum(x, force + k, NULL, LOADS_STRIDE, orders);
        nodes_add(power, s->len[k], &pull, &rate);
    }
}

/* the heat of sliding joints: a constant torque times the angle, with the opposite sign */
static double nodes_slides(const struct jets_system *s, const double slide[], double x, int order) {
    double lost = 0;
    for (int k = 0; k < s->n; k++) {
        double turned = 0;
        int p = s->parent[k];
        for (int j = order; j >= 0; j--) {
            size_t at = (size_t)j * PEND_JETS_PAD;
            double rate = s->rate[at + (size_t)k] - (p < 0 ? 0 : s->rate[at + (size_t)p]);
            turned = turned * x + rate * s->share[j];
        }
        lost -= slide[k] * turned * x;
    }
    return lost;
}

/* adds the power of the pivot's force, in fixed axes */
static void nodes_haul(const struct jets_system *s, const struct at_nodes *x, int order,
                       struct at_nodes *power) {
    const struct jets_loads *loads = s->loads;
    struct at_nodes along = nodes_sum(x, loads->pivot_force_x, NULL, 1, order);
    struct at_nodes across = nodes_sum(x, loads->pivot_force_y, NULL, 1, order);
    struct at_nodes up = nodes_sum(x, loads->slide_y, NULL, 1, order);
    double C = s->cosine[0], Z = s->sine[0];
    nodes_add(power, Z, &along, &up);
    nodes_add(power, C, &across, &up);
    const struct pend_terms *terms = loads->terms;
    int sideways = terms->one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0;
    for (int i = 0; i < terms->harmonics; i++)
        sideways |= terms->harmonic[i].drives == PEND_DRIVE_PIVOT_X;
    if (!sideways) return;
    struct at_nodes right = nodes_sum(x, loads->slide_x, NULL, 1, order);
    nodes_add(power, C, &along, &right);
    nodes_add(power, -Z, &across, &right);
}

static struct exchange_given exchange_given(const struct pend_jets *jets,
                                            const struct pend_loads *loads, double unit, int order,
                                            double x) {
    const struct jets_system *s = &jets->system;
    const struct pend_terms *terms = loads->terms;
    struct at_nodes at = nodes_of(x), power = nodes_of(0);
    struct exchange_given given = {0, 0};
    // forces are multiplied by unit^2, rates by unit
    double all = x / (unit * unit);
    int damping = terms->row[PEND_TERM_DAMPING], slide = terms->row[PEND_TERM_SLIDE],
        torques = jets_loads_torques(s->loads, order);
    if (damping >= 0 && s->n > PEND_JETS_PAD)
        given.heat = nodes_losses(s, x, order) * all;
    else if (damping >= 0)
        given.heat = nodes_loss(s, x, loads->value + damping, unit, order) * all;
    if (torques) nodes_effort(s, &at, order, &power);
    if (s->loads->moves) nodes_haul(s, &at, order, &power);
    if (torques || s->loads->moves) given.work = nodes_integral(&power) * all;
    if (slide < 0) return given;
    double lost = nodes_slides(s, loads->value + slide, x, order);
    given.work += lost, given.heat += lost;
    return given;
}

const struct exchange_kernel KERNEL_NAME(pend_kernel_exchange_) = {.given = exchange_given};

#include "core/extended/extended.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/extended/kernel_extended.h"
#include "core/taylor/taylor_order.h"

struct pend_extended {
    const struct pend_tree *tree;
    const struct extended_kernel *kernel;
    struct extended_motion motion;
    enum pend_extended_stage stage;
    long steps;
    double unit; /* s, unit of the last step's series */
};

enum { EXTENDED_ROWS = 8, EXTENDED_BYTES_CAP = 1 << 30 };

/* ---- orders */

/* The order above which one double per coefficient suffices: by then the terms of a step have
 * decreased by the ratio of a double's precision to the target. The terms of an exponential
 * decrease slowest, x^j / j!, with x such that the first neglected term is the target. */
static int extended_precise(double target, int order) {
    double bits = -log2(target), log_x = (lgamma(order + 2) / M_LN2 - bits) / (order + 1);
    int j = 1;
    while (j < order && lgamma(j + 1) / M_LN2 - j * log_x < bits - 53 + 4) j++;
    return j < order ? j : order;
}

/* ---- memory */

/* allocates `count` doubles of a block, a multiple of 64 bytes; if base is NULL, only counts
 * them */
static double *extended_take(char *base, size_t *used, size_t count) {
    double *piece = base ? (double *)(void *)(base + *used) : NULL;
    *used += (count + 7) / 8 * 8 * sizeof(double);
    return piece;
}

static size_t extended_place(struct pend_extended *e, char *base) {
    struct extended_motion *m = &e->motion;
    size_t used = 0;
    double **row[EXTENDED_ROWS] = {&m->from.phi, &m->from.phi_low, &m->from.rate, &m->from.rate_low,
                                   &m->to.phi,   &m->to.phi_low,   &m->to.rate,   &m->to.rate_low};
    extended_take(base, &used, sizeof *e / sizeof(double) + 1);
    for (int i = 0; i < EXTENDED_ROWS; i++) *row[i] = extended_take(base, &used, (size_t)m->n);
    m->share = extended_take(base, &used, (size_t)m->order + 2);
    m->series = extended_take(base, &used, e->kernel->series_count(m->terms, m->n, m->order));
    if (m->terms) m->value = extended_take(base, &used, (size_t)m->terms->count);
    return used;
}

enum pend_status pend_extended_new(struct pend_extended **extended, const struct pend_tree *tree,
                                   const struct pend_terms *terms, double rtol, double atol,
                                   enum pend_isa isa, struct pend_error *error) {
    *extended = NULL;
    if (!(rtol >= PEND_EXTENDED_RTOL_MIN && rtol <= 0.1))
        return pend_fail(error, PEND_INVALID, -1, 0, "rtol must be from %g to 0.1, got %g",
                         PEND_EXTENDED_RTOL_MIN, rtol);
    if (!(atol >= 0 && atol <= 1))
        return pend_fail(error, PEND_INVALID, -1, 0, "atol must be from 0 to 1, got %g", atol);
    // the first neglected term of a step, relative to the motion in the step: a hundredth of rtol,
    // but at least the last digit of the numbers
    double target = fmax(0.01 * rtol, 0x1p-106);
    int order = (int)ceil(6 - 0.45 * log(target));
    // this form uses four lanes, one for each of an arm's four sums
    if (isa > PEND_ISA_AVX2) isa = PEND_ISA_AVX2;
    struct pend_extended sketch = {
        .tree = tree,
        .kernel = PEND_ISA_PICK(pend_kernel_extended, isa),
        .stage = PEND_EXTENDED_STOPPED,
        .motion = {.n = tree->n,
                   .terms = terms,
                   .order = order,
                   .precise = extended_precise(target, order),
                   .parent = tree->parent,
                   .end = tree->end,
                   .len = tree->len,
                   .mass = tree->mass,
                   .log_rtol = log2(target),
                   .log_atol = atol > 0 ? log2(pend_taylor_atol(atol)) : -1e5}};
    size_t bytes = extended_place(&sketch, NULL);
    // the size that four lanes would need, so that every processor refuses the same trees
    size_t counted = bytes / (size_t)sketch.kernel->width * 4;
    if (counted > (size_t)EXTENDED_BYTES_CAP)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "32 digits are for smaller trees: the series of %d arms would take %zu "
                         "bytes, more than %d",
                         tree->n, counted, EXTENDED_BYTES_CAP);
    char *block = aligned_alloc(64, bytes);
    if (!block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "no memory for the series of %d arms: %zu bytes", tree->n, bytes);
    memset(block, 0, bytes);
    extended_place(&sketch, block);
    for (int j = 0; j < order + 2; j++) sketch.motion.share[j] = 1.0 / (j + 1);
    *extended = (struct pend_extended *)(void *)block;
    **extended = sketch;
    return PEND_OK;
}

PEND_VALIDATOR extended_valid(const struct pend_extended *e) {
    return e->motion.n == e->tree->n && e->motion.precise <= e->motion.order + 1 && e->steps >= 0;
}

void pend_extended_free(struct pend_extended **extended) {
    assert(!*extended || extended_valid(*extended));
    free(*extended);
    *extended = NULL;
}

int pend_extended_order(const struct pend_extended *e) { return e->motion.order; }

void pend_extended_value(struct pend_extended *e, const double value[]) {
    const struct extended_motion *m = &e->motion;
    if (m->terms) memcpy(m->value, value, (size_t)m->terms->count * sizeof *value);
}

void pend_extended_start(struct pend_extended *e, const struct pend_loads *loads,
                         const struct pend_extended_state *state, double start, double stop) {
    struct extended_motion *m = &e->motion;
    assert(extended_valid(e) && loads->terms == m->terms);
    // the end of the last step becomes the start of the next
    for (int k = 0; k < m->n; k++) {
        m->to.phi[k] = state->phi[k];
        m->to.phi_low[k] = state->phi_low ? state->phi_low[k] : 0;
        m->to.rate[k] = state->rate[k];
        m->to.rate_low[k] = state->rate_low ? state->rate_low[k] : 0;
    }
    pend_extended_value(e, loads->value);
    m->start = start, m->to.time = 0, m->stop = stop, m->gravity = loads->gravity;
    m->unit = copysign(pend_taylor_first_unit(m->n, loads, m->len, state->rate), stop);
    e->unit = m->unit, e->steps = 0;
    e->stage = stop == 0 ? PEND_EXTENDED_STOPPED : PEND_EXTENDED_UNDER_WAY;
}

void pend_extended_stop(struct pend_extended *e, double stop) {
    assert(extended_valid(e));
    double left = stop - e->motion.to.time;
    e->motion.stop = stop;
    e->motion.unit = copysign(e->motion.unit, left);
    if (left != 0 && e->stage == PEND_EXTENDED_STOPPED) e->stage = PEND_EXTENDED_UNDER_WAY;
}

enum pend_extended_stage pend_extended_step(struct pend_extended *e) {
    struct extended_motion *m = &e->motion;
    assert(extended_valid(e));
    struct extended_state swap = m->from;
    m->from = m->to, m->to = swap;
    e->unit = m->unit;
    int ends = e->kernel->step(m);
    e->steps++;
    if (ends) e->stage = ends & EXTENDED_BAD ? PEND_EXTENDED_FAILED : PEND_EXTENDED_STOPPED;
    return e->stage;
}

double pend_extended_time(const struct pend_extended *e) { return e->motion.to.time; }

void pend_extended_end(const struct pend_extended *e, const struct pend_extended_state *state) {
    const struct extended_state *to = &e->motion.to;
    size_t bytes = (size_t)e->motion.n * sizeof(double);
    assert(extended_valid(e) && state->phi != state->rate);
    memcpy(state->phi, to->phi, bytes);
    memcpy(state->rate, to->rate, bytes);
    if (state->phi_low) memcpy(state->phi_low, to->phi_low, bytes);
    if (state->rate_low) memcpy(state->rate_low, to->rate_low, bytes);
}

void pend_extended_carry(struct pend_extended *e, struct pend_checkpoint *checkpoint) {
    struct extended_motion *m = &e->motion;
    assert(extended_valid(e));
    /* the start of the last step; before the first step, the initial state */
    struct extended_state *start = e->steps ? &m->from : &m->to;
    long steps = e->steps;
    double unit = e->steps ? e->unit : m->unit;
    double *rows[] = {start->phi, start->phi_low, start->rate, start->rate_low};
    pend_checkpoint_counts(checkpoint, &steps, 1);
    pend_checkpoint_row(checkpoint, &unit, 1);
    pend_checkpoint_row(checkpoint, &m->stop, 1);
    pend_checkpoint_row(checkpoint, &start->time, 1);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        pend_checkpoint_row(checkpoint, rows[i], (size_t)m->n);
    if (!pend_checkpoint_puts(checkpoint)) return;
    m->unit = unit;
    if (!steps) return;
    // `start` holds the state before the first step
    e->stage = PEND_EXTENDED_UNDER_WAY;
    (void)pend_extended_step(e);
    e->steps = steps;
}

static double *extended_row(double *array, size_t base) { return array ? array + base : NULL; }

void pend_extended_at(const struct pend_extended *e, int count, const double t[],
                      const struct pend_extended_state *to, double acc[], double force[]) {
    assert(extended_valid(e) && count >= 0 && to->phi && to->rate);
    int width = e->kernel->width;
    for (int i = 0; i < count; i += width) {
        size_t base = (size_t)i * (size_t)e->motion.n;
        struct extended_values values = {.phi = to->phi + base,
                                         .phi_low = extended_row(to->phi_low, base),
                                         .rate = to->rate + base,
                                         .rate_low = extended_row(to->rate_low, base),
                                         .acc = extended_row(acc, base),
                                         .force = extended_row(force, base)};
        int some = count - i < width ? count - i : width;
        e->kernel->values(&e->motion, e->unit, some, t + i, &values);
    }
}

double pend_extended_power(const struct pend_extended *e, double work[], double heat[]) {
    assert(extended_valid(e) && e->motion.terms && e->steps > 0);
    e->kernel->power(&e->motion, e->unit, work, heat);
    return e->unit;
}

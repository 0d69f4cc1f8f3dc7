#include "core/modes/modes_values.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    VALUES_BATCH = 64, /* number of shifts tried at once */
    VALUES_LANES = 16, /* number of shifts that are counted at once; fewer take as long */
    VALUES_TRIES = 6   /* number of Laguerre steps before they alternate with bisection */
};

/* in trees deeper than VALUES_DEEP, the VALUES_SLOW smallest eigenvalues are polished if their
 * relative error is below VALUES_POLISH */
enum { VALUES_DEEP = 4000, VALUES_SLOW = 32 };
#define VALUES_POLISH 1e-9

/* One end of a span: a counted shift, and a bound of the nearest eigenvalue inside. */
struct span_end {
    double at;
    int below;   /* number of eigenvalues below `at` */
    int near;    /* non-zero if one eigenvalue inside dominates, so that hints converge to it */
    double hint; /* Laguerre's bound of the nearest eigenvalue on the inside; `at` if unknown */
    double step; /* distance to the hint, maybe below the last digit of `at`; infinite if unknown */
};

/* An interval that contains hi.below - lo.below > 0 of the requested eigenvalues. */
struct span {
    struct span_end lo, hi;
    double rest; /* relative contribution of the other eigenvalues to sum 1 / (shift - lambda_i)^2,
                  * estimated from the errors of hints; 0 at first */
    int tries;
};

struct pend_values {
    const struct pend_laplacian *laplacian;
    const struct pend_modes_kernel *kernel;
    int first, last; /* the requested eigenvalues inside have the numbers first .. last - 1 */
    double *value;
    int todo_count, polished;
    struct span todo[];
};

PEND_VALIDATOR values_valid(const struct pend_values *v) {
    int count = v->last - v->first;
    return v->first >= 0 && count >= 0 && v->last <= v->laplacian->n && v->todo_count >= 0 &&
           v->todo_count <= count + 2 * VALUES_BATCH && v->polished >= 0 && v->polished <= count;
}

int pend_values_below(const struct pend_laplacian *laplacian, double shift) {
    struct pend_modes_probe probe = {.shift = shift};
    PEND_ISA_PICK(pend_modes_kernel, pend_isa_best())->probe(laplacian, 1, &probe);
    return probe.below;
}

/* the end of a span at a probe: of the span above the probe (side 1) or below it (side -1) */
static struct span_end values_end(const struct pend_modes_probe *probe, int n, int side) {
    struct span_end end = {probe->shift, probe->below, 0, probe->shift, INFINITY};
    double rate = -side * probe->log_rate, bend = probe->log_bend;
    double root = sqrt(fmax(0, (n - 1.0) * (n * bend - rate * rate))), step = n / (rate + root);
    if (!(step > 0 && bend > 0 && isfinite(step) && isfinite(bend))) return end;
    end.hint = probe->shift + side * step;
    end.step = step;
    end.near = fabs(rate * step - 1) < 0.25 && fabs(bend * step * step - 1) < 0.25;
    return end;
}

/* for a span of one eigenvalue: the end with the better hint */
static const struct span_end *values_nearer(const struct span *span) {
    const struct span_end *lo = &span->lo, *hi = &span->hi;
    if (lo->near != hi->near) return lo->near ? lo : hi;
    return lo->step < hi->step ? lo : hi;
}

static double values_middle(double lo, double hi) {
    return lo > 0 && hi > 4 * lo ? sqrt(lo) * sqrt(hi) : lo + 0.5 * (hi - lo);
}

/* bounds of the eigenvalues inside: the hints, if they are consistent */
static void values_bounds(const struct span *span, double *lo, double *hi) {
    *lo = span->lo.hint > span->lo.at && span->lo.hint < span->hi.at ? span->lo.hint : span->lo.at;
    *hi = span->hi.hint < span->hi.at && span->hi.hint > span->lo.at ? span->hi.hint : span->hi.at;
    if (*lo <= *hi && !(*lo == span->hi.at || *hi == span->lo.at)) return;
    *lo = span->lo.at;
    *hi = span->hi.at;
}

/* stores all eigenvalues of a span as the same number, because they agree to round-off */
static void values_finish(struct pend_values *v, const struct span *span, double value) {
    assert(span->lo.at <= span->hi.at);
    value = fmin(fmax(value, span->lo.at), span->hi.at);
    for (int number = span->lo.below; number < span->hi.below; number++)
        if (number >= v->first && number < v->last) v->value[number - v->first] = value;
}

/* True if a span has converged: it is as narrow as round-off, or the estimated error of its
 * eigenvalue's hint, half the cube of the step times `rest`, is below round-off. */
static int values_converged(const struct span *span, double *value) {
    double round_off = DBL_EPSILON * span->hi.at;
    *value = values_middle(span->lo.at, span->hi.at);
    if (span->hi.at - span->lo.at <= 4 * round_off) return 1;
    if (span->hi.below - span->lo.below > 1) return 0;
    const struct span_end *end = values_nearer(span);
    double error = 5 * end->step * end->step * end->step * span->rest;
    *value = end->hint;
    return end->near && (end->step <= round_off || (span->rest > 0 && error <= 0.25 * round_off));
}

/* for a span of one eigenvalue: the next shift, a weighted mean of the hints of both ends or the
 * better one alone, or the middle if hints do not converge */
static double values_next(struct span *span) {
    double lo, hi;
    values_bounds(span, &lo, &hi);
    if (span->tries++ >= VALUES_TRIES && span->tries % 2)
        return values_middle(span->lo.at, span->hi.at);
    const struct span_end *end = values_nearer(span);
    if (end->hint <= span->lo.at || end->hint >= span->hi.at) return values_middle(lo, hi);
    /* both hints miss the eigenvalue by about the cubes of their steps */
    double share = span->lo.step / span->hi.step;
    share = isfinite(span->lo.step + span->hi.step) && lo <= hi ? 1 / (1 + share * share * share)
                                                                : end == &span->lo;
    double shift = share * lo + (1 - share) * hi;
    // if the hints cross because of round-off, the search of the span ends with one of them
    return shift > span->lo.at && shift < span->hi.at ? shift : end->hint;
}

/* evenly spaced shifts between two bounds, in the logarithm if the bounds are far apart */
static void values_space(double lo, double hi, int count, double shift[]) {
    double ratio = lo > 0 && hi > 4 * lo ? log(hi / lo) : 0;
    for (int i = 0; i < count; i++) {
        double part = (i + 1.0) / (count + 1.0);
        shift[i] = ratio > 0 ? lo * exp(part * ratio) : lo + part * (hi - lo);
    }
}

/* chooses the next shifts for a span of several eigenvalues, ascending; returns their number */
static int values_split(struct span *span, int room, double shift[]) {
    double lo, hi;
    int several = span->hi.below - span->lo.below;
    assert(several > 1);
    assert(room <= VALUES_LANES);
    values_bounds(span, &lo, &hi);
    if (span->tries++ >= VALUES_TRIES && span->tries % 2) lo = span->lo.at, hi = span->hi.at;
    if (room > 2 * several) room = 2 * several;
    if (hi - lo <= 4 * DBL_EPSILON * hi) {
        /* if all eigenvalues seem to be one number, count on both sides of it to confirm that */
        int count = 0;
        double below = lo * (1 - 6 * DBL_EPSILON), above = hi * (1 + 6 * DBL_EPSILON);
        if (below > span->lo.at) shift[count++] = below;
        if (above < span->hi.at && room > count) shift[count++] = above;
        if (count) return count;
        lo = span->lo.at;
        hi = span->hi.at;
    }
    if (room > 1)
        values_space(lo, hi, room, shift);
    else
        shift[0] = values_middle(lo, hi);
    return room;
}

/* updates the error estimate of a span's hints from a smaller span with one eigenvalue */
static void values_learn(const struct span *span, struct span *part) {
    const struct span_end *end = values_nearer(part), *old[2] = {&span->lo, &span->hi};
    for (int i = 0; end->near && i < 2; i++) {
        double off = fabs(old[i]->hint - end->hint) - 4 * DBL_EPSILON * end->at;
        double rest = 2 * off / (old[i]->step * old[i]->step * old[i]->step);
        if (rest > part->rest && isfinite(rest)) part->rest = rest;
    }
}

/* stores the smaller span between two counted ends */
static void values_file(struct pend_values *v, const struct span *whole, struct span span) {
    double value;
    if (span.hi.below <= span.lo.below || span.hi.below <= v->first || span.lo.below >= v->last)
        return;
    if (span.hi.below - span.lo.below < whole->hi.below - whole->lo.below) span.tries = 0;
    if (span.hi.below - span.lo.below == 1) values_learn(whole, &span);
    if (values_converged(&span, &value))
        values_finish(v, &span, value);
    else
        v->todo[v->todo_count++] = span;
}

/* splits a span at the counted shifts; keeps only the parts that contain requested eigenvalues */
static void values_cut(struct pend_values *v, const struct span *span, int count,
                       struct pend_modes_probe probe[]) {
    const struct pend_modes_probe *from = NULL;
    int n = v->laplacian->n, below = span->lo.below, most = span->hi.below;
    for (int i = 0; i < count; i++) {
        if (!(probe[i].shift > (from ? from->shift : span->lo.at) && probe[i].shift < span->hi.at))
            continue;
        /* counts rise with the shift; if round-off violates this, the previous count is used */
        if (probe[i].below < below) probe[i].below = below;
        if (probe[i].below > most) probe[i].below = most;
        if (probe[i].below > below) {
            struct span part = {from ? values_end(from, n, 1) : span->lo,
                                values_end(&probe[i], n, -1), span->rest, span->tries};
            values_file(v, span, part);
        }
        below = probe[i].below;
        from = &probe[i];
    }
    if (from && below == most) return;
    struct span part = {from ? values_end(from, n, 1) : span->lo, span->hi, span->rest,
                        span->tries};
    /* no double lies between the ends, so no shift can separate the eigenvalues */
    if (!from && count) {
        values_finish(v, &part, values_middle(part.lo.at, part.hi.at));
        return;
    }
    values_file(v, span, part);
}

/* One round: takes spans from the end of the list, counts at their next shifts, and puts the
 * smaller spans into the list. */
static void values_round(struct pend_values *v) {
    struct pend_modes_probe probe[VALUES_BATCH];
    struct span span[VALUES_BATCH];
    int count[VALUES_BATCH], spans = 0, probes = 0;
    int take = v->todo_count < VALUES_BATCH ? v->todo_count : VALUES_BATCH;
    int room = VALUES_LANES / take > 1 ? VALUES_LANES / take : 1;
    for (; spans < take; spans++) {
        struct span *s = &span[spans];
        double shift[VALUES_LANES];
        *s = v->todo[--v->todo_count];
        count[spans] = 1;
        if (s->hi.below - s->lo.below == 1)
            shift[0] = values_next(s);
        else
            count[spans] = values_split(s, room, shift);
        for (int i = 0; i < count[spans]; i++) probe[probes++].shift = shift[i];
    }
    assert(probes <= VALUES_BATCH);
    v->kernel->probe(v->laplacian, probes, probe);
    for (int i = 0, at = 0; i < spans; at += count[i++])
        values_cut(v, &span[i], count[i], probe + at);
}

/* One Newton step in extended precision from a value with a dozen correct digits. On a long path
 * the sums of the sweep grow by nearly the same amount from arm to arm, so that their round-off has
 * a bias. */
static double values_polish(const struct pend_laplacian *l, double value) {
    long double pull[PEND_LAPLACIAN_STACK + 1], rate[PEND_LAPLACIAN_STACK + 1], log_rate = 0;
    int top = 0;
    for (int k = l->n - 1; k >= 0; k--) {
        int leaf = l->turn[k] & PEND_TURN_LEAF, next = l->turn[k] & PEND_TURN_NEXT;
        long double spring = l->spring[k],
                    t = (leaf ? 0 : pull[top]) - (long double)value * l->mass[k];
        long double inverse = 1 / (t + spring + spring * 0x1p-70L), ratio = spring * inverse;
        long double slope = (leaf ? 0 : rate[top]) - l->mass[k];
        log_rate += slope * inverse;
        top += !next - !leaf;
        pull[top] = ratio * t + (next ? pull[top] : 0);
        rate[top] = ratio * ratio * slope + (next ? rate[top] : 0);
    }
    double step = (double)(1 / log_rate);
    return fabs(step) < VALUES_POLISH * value ? value - step : value;
}

enum pend_status pend_values_new(struct pend_values **values,
                                 const struct pend_laplacian *laplacian, int first, int count,
                                 double value[]) {
    assert(pend_laplacian_valid(laplacian));
    assert(first >= 0 && count >= 0 && count <= laplacian->n - first);
    /* every span has a requested value, and a round adds at most as many spans as shifts */
    struct pend_values *v = *values =
        malloc(sizeof *v + ((size_t)count + 2 * VALUES_BATCH) * sizeof *v->todo);
    if (!v) return PEND_NO_MEMORY;
    *v = (struct pend_values){laplacian, PEND_ISA_PICK(pend_modes_kernel, pend_isa_best()),
                              first,     first + count,
                              value,     0,
                              0};
    if (!count) return PEND_OK;
    v->todo[v->todo_count++] =
        (struct span){{laplacian->least, 0, 0, laplacian->least, INFINITY},
                      {laplacian->most, laplacian->n, 0, laplacian->most, INFINITY},
                      0,
                      0};
    v->todo[0].lo.below = pend_values_below(laplacian, laplacian->least);
    return PEND_OK;
}

int pend_values_step(struct pend_values *v) {
    assert(values_valid(v));
    if (v->todo_count) {
        values_round(v);
        assert(values_valid(v));
        return 0;
    }
    if (v->laplacian->depth < VALUES_DEEP || v->polished == v->last - v->first) return 1;
    if (v->first + v->polished >= VALUES_SLOW) return 1;
    v->value[v->polished] = values_polish(v->laplacian, v->value[v->polished]);
    v->polished++;
    return 0;
}

void pend_values_free(struct pend_values **values) {
    free(*values);
    *values = NULL;
}

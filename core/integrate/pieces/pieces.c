#include "core/integrate/pieces/pieces.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/pieces/rule.h"

/* in the order in which they change a state, and add to its inputs */
static const struct pend_rule *const rules[] = {&pend_rule_tables};
enum { RULES = sizeof rules / sizeof *rules };

struct pieces {
    const struct pend_method *inner;
    struct pend_problem problem; /* of the inner method: with the piece's numbers */
    struct pend_piece piece;
    void *stepper;
    double begun;     /* s, relative: when the piece began */
    double next;      /* s, in the time of the drives: its end as known beforehand */
    double reached;   /* s, relative */
    int ended;        /* the last step has reached the end of the piece */
    void *own[RULES]; /* what rules keep; NULL = the pendulum has no such rule */
};

PEND_VALIDATOR pieces_valid(const struct pieces *p) {
    return p->inner && p->stepper && p->piece.value == p->problem.loads.value &&
           (p->piece.way == 1 || p->piece.way == -1);
}

/* ---- the change between two pieces */

/* where the new piece ends, if no event ends it before */
static void pieces_look(struct pieces *p) {
    p->next = copysign(INFINITY, p->piece.way);
    for (int i = 0; i < RULES; i++) {
        if (!p->own[i] || !rules[i]->next) continue;
        double next = rules[i]->next(&p->piece, p->own[i]);
        p->next = p->piece.way > 0 ? fmin(p->next, next) : fmax(p->next, next);
    }
}

static enum pend_status pieces_change(struct pieces *p, struct pend_error *error) {
    const struct pend_terms *terms = p->problem.loads.terms;
    for (int i = 0; i < RULES; i++)
        if (p->own[i] && rules[i]->change) PEND_TRY(rules[i]->change(&p->piece, p->own[i], error));
    if (terms->row[PEND_TERM_INPUT] >= 0)
        pend_rules_inputs(p->piece.rules, terms, p->piece.now, p->piece.way, p->piece.value, 1);
    for (int i = 0; i < RULES; i++)
        if (p->own[i] && rules[i]->input) rules[i]->input(&p->piece, p->own[i]);
    pieces_look(p);
    p->ended = 0;
    return PEND_OK;
}

/* ---- the method */

static size_t pieces_padded(size_t bytes) { return (bytes + 63) / 64 * 64; }

/* places what the rules keep behind `base`; returns the bytes */
static size_t pieces_own(const struct pend_problem *problem, char *base, void *own[]) {
    size_t used = 0;
    for (int i = 0; i < RULES; i++) {
        own[i] = NULL;
        if (!rules[i]->has(problem->loads.terms->rules)) continue;
        own[i] = base ? base + used : NULL;
        used += pieces_padded(rules[i]->bytes ? rules[i]->bytes(problem) : 8);
    }
    return used;
}

static struct pieces *pieces_allocate(const struct pend_method *inner,
                                      const struct pend_problem *problem) {
    const struct pend_terms *terms = problem->loads.terms;
    void *own[RULES];
    size_t n = (size_t)problem->tree->n, head = pieces_padded(sizeof(struct pieces)),
           list = pieces_padded((size_t)terms->count * sizeof(double)),
           state = pieces_padded(2 * n * sizeof(double)), keep = pieces_own(problem, NULL, own);
    char *block = calloc(1, head + list + state + keep);
    if (!block) return NULL;
    struct pieces *p = (struct pieces *)(void *)block;
    double *value = (double *)(void *)(block + head);
    memcpy(value, problem->loads.value, (size_t)terms->count * sizeof *value);
    p->inner = inner;
    p->problem = *problem;
    p->problem.loads.value = value;
    p->piece = (struct pend_piece){.problem = &p->problem, .rules = terms->rules, .value = value};
    p->piece.phi = value + list / sizeof(double);
    p->piece.rate = p->piece.phi + n;
    memcpy(p->piece.phi, problem->phi, n * sizeof(double));
    memcpy(p->piece.rate, problem->rate, n * sizeof(double));
    pieces_own(problem, block + head + list + state, p->own);
    return p;
}

static void pieces_close(void **stepper) {
    struct pieces *p = *stepper;
    if (p && p->stepper) p->inner->close(&p->stepper);
    free(p);
    *stepper = NULL;
}

static enum pend_status pieces_open(void **stepper, const struct pend_method *inner,
                                    const struct pend_problem *problem, struct pend_error *error) {
    const struct pend_times *times = &problem->times;
    struct pieces *p = *stepper = pieces_allocate(inner, problem);
    if (!p) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a motion in pieces");
    double first = times->count ? pend_times_at(times, 0) : times->start;
    double last = times->count ? pend_times_at(times, times->count - 1) : first;
    p->piece.start = p->piece.now = first;
    p->piece.way = last < first ? -1 : 1;
    enum pend_status status =
        pend_rules_check(p->piece.rules, problem->tree->order, first, last, error);
    if (status == PEND_OK) status = pieces_change(p, error);
    if (status == PEND_OK) status = inner->open(&p->stepper, &p->problem, error);
    if (status != PEND_OK) pieces_close(stepper);
    assert(status != PEND_OK || pieces_valid(p));
    return status;
}

/* a new piece begins where the last step has ended */
static enum pend_status pieces_begin(struct pieces *p, struct pend_error *error) {
    const struct pend_points points = {.phi = p->piece.phi, .rate = p->piece.rate};
    p->inner->at(p->stepper, &p->reached, 1, &points);
    p->piece.now = p->next;
    p->begun = p->reached;
    return pieces_change(p, error);
}

static enum pend_status pieces_step(void *stepper, double limit, double *reached,
                                    struct pend_error *error) {
    struct pieces *p = stepper;
    assert(pieces_valid(p));
    if (p->ended) PEND_TRY(pieces_begin(p, error));
    double end = p->next - p->piece.start;
    // a knot that the start's rounding puts at the piece's beginning has no length of its own
    if (p->piece.way * (end - p->reached) <= 0) end = nextafter(p->reached, p->next);
    int within = p->piece.way * (limit - end) <= 0;
    PEND_TRY(p->inner->step(p->stepper, within ? limit : end, &p->reached, error));
    if (p->piece.way * (p->reached - end) > 0) {
        p->inner->cut(p->stepper, end);
        p->reached = end;
    }
    p->ended = p->reached == end;
    *reached = p->reached;
    return PEND_OK;
}

static void pieces_at(void *stepper, const double t[], int count,
                      const struct pend_points *points) {
    struct pieces *p = stepper;
    p->inner->at(p->stepper, t, count, points);
}

static struct pend_stepper_counts pieces_counts(const void *stepper) {
    const struct pieces *p = stepper;
    return p->inner->counts(p->stepper);
}

static void pieces_exchange(const void *stepper, const double t[], int count, double work[],
                            double heat[]) {
    const struct pieces *p = stepper;
    p->inner->exchange(p->stepper, t, count, work, heat);
}

static void pieces_series(const void *stepper, struct pend_series *series) {
    const struct pieces *p = stepper;
    p->inner->series(p->stepper, series);
}

static void pieces_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct pieces *p = stepper;
    size_t n = (size_t)p->problem.tree->n;
    pend_checkpoint_row(checkpoint, &p->piece.now, 1);
    pend_checkpoint_row(checkpoint, &p->begun, 1);
    pend_checkpoint_row(checkpoint, &p->next, 1);
    pend_checkpoint_row(checkpoint, &p->reached, 1);
    pend_checkpoint_int(checkpoint, &p->ended, 1);
    pend_checkpoint_row(checkpoint, p->piece.phi, n);
    pend_checkpoint_row(checkpoint, p->piece.rate, n);
    pend_checkpoint_row(checkpoint, p->piece.value, (size_t)p->problem.loads.terms->count);
    for (int i = 0; i < RULES; i++)
        if (p->own[i] && rules[i]->carry) rules[i]->carry(&p->piece, p->own[i], checkpoint);
    p->inner->carry(p->stepper, checkpoint);
}

/* ---- the methods */

/* a method around NAME */
#define PIECES(NAME, TEXT, SERIES, FLAGS)                                                          \
    static enum pend_status NAME##_open(void **stepper, const struct pend_problem *problem,        \
                                        struct pend_error *error) {                                \
        return pieces_open(stepper, &pend_method_##NAME, problem, error);                          \
    }                                                                                              \
    static const struct pend_method pieces_##NAME = {.name = TEXT,                                 \
                                                     .summary = "The motion in pieces.",           \
                                                     .flags = FLAGS,                               \
                                                     .open = NAME##_open,                          \
                                                     .step = pieces_step,                          \
                                                     .at = pieces_at,                              \
                                                     .counts = pieces_counts,                      \
                                                     .exchange = pieces_exchange,                  \
                                                     .series = SERIES,                             \
                                                     .carry = pieces_carry,                        \
                                                     .close = pieces_close}

enum {
    PIECES_TAYLOR =
        PEND_METHOD_TOLERANCES | PEND_METHOD_SERIES | PEND_METHOD_THETA | PEND_METHOD_TERMS
};

PIECES(taylor, "taylor", pieces_series, PIECES_TAYLOR);

const struct pend_method *pend_pieces_method(const struct pend_method *method,
                                             const struct pend_terms *terms) {
    if (!terms || !terms->rules) return method;
    return method == &pend_method_taylor ? &pieces_taylor : NULL;
}

struct pend_loads pend_pieces_loads(const struct pend_method *method, const void *stepper,
                                    const struct pend_loads *loads) {
    const struct pieces *p = stepper;
    return method->step == pieces_step ? p->problem.loads : *loads;
}

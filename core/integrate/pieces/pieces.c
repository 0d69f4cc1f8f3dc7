#include "core/integrate/pieces/pieces.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/pieces/control.h"
#include "core/integrate/pieces/pieces_work.h"

PEND_VALIDATOR pieces_valid(const struct pieces *p) {
    return p->inner && p->piece.value == p->problem.loads.value &&
           (p->piece.way == 1 || p->piece.way == -1);
}

/* ---- the change between two pieces */

static enum pend_status pieces_change(struct pieces *p, struct pend_error *error) {
    const struct pend_terms *terms = p->problem.loads.terms;
    struct pend_piece *piece = &p->piece;
    int n = p->problem.tree->n;
    if (p->joints) PEND_TRY(pend_joints_impacts(p->joints, error));
    if (p->control)
        pend_control_sample(p->problem.tree, &p->problem.loads, piece->start, piece->now,
                            piece->phi, piece->rate, p->control);
    p->next = pend_rules_piece(terms, piece->now, piece->way, piece->value, 1);
    if (p->control) {
        const struct pend_rules *all = piece->rules;
        double *input = piece->value + terms->row[PEND_TERM_INPUT];
        for (int i = 0; i < all->controllers; i++)
            input[all->controller[i].drives] += pend_control_output(all, n, i, p->control);
        p->next = fmin(p->next, pend_control_next(piece->rules, n, piece->start, p->control));
    }
    if (p->joints) PEND_TRY(pend_joints_sort(p->joints, error));
    p->ended = p->taken = 0;
    p->fresh = 1;
    return PEND_OK;
}

/* ---- the stepper of a piece */

/* closes the stepper; its steps, work and heat are kept */
static void pieces_leave(struct pieces *p) {
    double work = 0, heat = 0;
    struct pend_stepper_counts counts = p->inner->counts(p->stepper);
    if (counts.steps) p->inner->exchange(p->stepper, &p->reached, 1, &work, &heat);
    pend_sum_add(&p->work, work);
    pend_sum_add(&p->heat, heat);
    p->done.steps += counts.steps;
    p->done.rejected += counts.rejected;
    p->done.evaluations += counts.evaluations;
    p->inner->close(&p->stepper);
    pend_stuck_free(&p->stuck);
}

/* the state at the start of the piece, for a stepper of the contracted pendulum; its four rows go
 * to `to` */
static struct pend_start pieces_seat(const struct pieces *p, double *to) {
    struct pend_start start = {p->begun, p->piece.phi, p->low[0], p->piece.rate, p->low[1]};
    const double *from[] = {start.phi, start.phi_low, start.rate, start.rate_low};
    const struct pend_stuck *stuck = p->stuck;
    if (!stuck) return start;
    size_t n = (size_t)stuck->tree->n;
    for (size_t i = 0; i < 4; i++)
        for (size_t c = 0; c < n; c++)
            to[i * n + c] = i > 1 && stuck->still[stuck->of[c]] ? 0 : from[i][stuck->of[c]];
    return (struct pend_start){p->begun, to, to + n, to + 2 * n, to + 3 * n};
}

static enum pend_status pieces_enter(struct pieces *p, struct pend_error *error) {
    struct pend_problem problem = p->problem;
    if (p->joints) PEND_TRY(pend_joints_contract(p->joints, p->low[0], &p->stuck));
    struct pend_start start = pieces_seat(p, p->room);
    if (p->stuck) problem.tree = p->stuck->tree, problem.loads = p->stuck->loads;
    problem.phi = start.phi, problem.phi_low = start.phi_low;
    problem.rate = start.rate, problem.rate_low = start.rate_low;
    PEND_TRY(p->inner->open(&p->stepper, &problem, error));
    if (p->begun != 0) p->inner->put(p->stepper, &start);
    return PEND_OK;
}

/* whether the holding joints are those of the stepper's pendulum */
static int pieces_same(const struct pieces *p) {
    const struct pend_tree *tree = p->problem.tree;
    for (int k = 0; p->joints && k < tree->n; k++) {
        int holder = pend_terms_holder(p->problem.loads.terms, tree->parent, k), held = 0;
        if (p->stuck && holder < 0) held = p->stuck->still[k];
        if (p->stuck && holder >= 0) held = p->stuck->of[p->stuck->rep[k]] != k;
        if (held != p->joints->holds[k]) return 0;
    }
    return 1;
}

/* copies the state at the end of the last step; joints that came to rest are exactly at rest */
static void pieces_arrive(struct pieces *p) {
    size_t bytes = (size_t)p->problem.tree->n * sizeof(double);
    struct pend_start end = p->inner->end(p->stepper);
    double *rate = p->piece.rate;
    if (p->stuck) {
        pend_stuck_turn(p->stuck, end.phi, end.phi_low, p->piece.phi, p->low[0]);
        pend_stuck_spread(p->stuck, end.rate, rate);
        pend_stuck_spread(p->stuck, end.rate_low, p->low[1]);
    } else {
        memcpy(p->piece.phi, end.phi, bytes);
        memcpy(p->low[0], end.phi_low, bytes);
        memcpy(rate, end.rate, bytes);
        memcpy(p->low[1], end.rate_low, bytes);
    }
    for (int k = 0; p->joints && k < p->joints->n; k++) {
        int holder = pend_terms_holder(p->problem.loads.terms, p->problem.tree->parent, k);
        // what rests on a joint that stops stops too
        if (!p->joints->stopped[k] && !p->joints->holds[k]) continue;
        rate[k] = holder < 0 ? 0 : rate[holder];
        p->low[1][k] = holder < 0 ? 0 : p->low[1][holder];
        p->joints->stopped[k] = 0;
    }
}

static enum pend_status pieces_begin(struct pieces *p, struct pend_error *error) {
    double now = p->piece.start + p->reached;
    pieces_arrive(p);
    // rounding may put an event at or after the instant known in advance; it is moved before it
    if (p->ended == PIECES_EVENT && p->piece.way * (p->next - now) <= 0)
        now = nextafter(p->next, -INFINITY);
    p->piece.now = p->ended == PIECES_KNOWN ? p->next : now;
    p->stalled = p->reached == p->begun ? p->stalled + 1 : 0;
    p->begun = p->reached;
    if (p->stalled > PIECES_STALLED)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, p->reached,
                         "the joints switch between sticking, sliding and impacts without end, and "
                         "time does not advance");
    PEND_TRY(pieces_change(p, error));
    if (!pieces_same(p)) {
        pieces_leave(p);
        return pieces_enter(p, error);
    }
    if (p->stuck) pend_stuck_inputs(p->stuck, p->problem.loads.terms, p->piece.value);
    if (p->joints) {
        struct pend_start start = pieces_seat(p, p->room);
        p->inner->put(p->stepper, &start);
    }
    return PEND_OK;
}

/* ---- creation and release */

static size_t pieces_padded(size_t bytes) { return (bytes + 63) / 64 * 64; }

static size_t pieces_lay(struct pieces *p, const struct pend_problem *problem, char *base) {
    const struct pend_terms *terms = problem->loads.terms;
    size_t n = (size_t)problem->tree->n, used = pieces_padded(sizeof *p);
    double **row[] = {&p->piece.phi, &p->piece.rate, &p->low[0], &p->low[1]};
    p->piece.value = base ? (double *)(void *)(base + used) : NULL;
    used += pieces_padded((size_t)terms->count * sizeof(double));
    for (int i = 0; i < 4; i++, used += pieces_padded(n * sizeof(double)))
        *row[i] = base ? (double *)(void *)(base + used) : NULL;
    size_t control = pend_control_numbers(terms->rules, (int)n) * sizeof(double);
    p->control = base && control ? (double *)(void *)(base + used) : NULL;
    used += pieces_padded(control);
    if (!pend_rules_joints(terms->rules)) return used;
    size_t rows = 4 * PIECES_ROWS > 5 + PEND_JOINT_NODES ? 4 * PIECES_ROWS : 5 + PEND_JOINT_NODES;
    p->room = base ? (double *)(void *)(base + used) : NULL;
    used += pieces_padded(rows * n * sizeof(double));
    p->joints = base ? (struct pend_joints *)(void *)(base + used) : NULL;
    used += pieces_padded(sizeof *p->joints);
    if (base) pend_joints_init(p->joints, &p->piece, base + used);
    return used + pend_joints_bytes(problem->tree, terms);
}

static struct pieces *pieces_allocate(const struct pend_method *inner,
                                      const struct pend_problem *problem) {
    struct pieces sketch = {.inner = inner};
    size_t bytes = pieces_lay(&sketch, problem, NULL), n = (size_t)problem->tree->n;
    struct pieces *p = aligned_alloc(64, bytes);
    if (!p) return NULL;
    memset(p, 0, bytes);
    p->inner = inner;
    p->problem = *problem;
    p->piece = (struct pend_piece){.problem = &p->problem, .rules = problem->loads.terms->rules};
    pieces_lay(p, problem, (char *)p);
    memcpy(p->piece.value, problem->loads.value,
           (size_t)problem->loads.terms->count * sizeof(double));
    p->problem.loads.value = p->piece.value;
    memcpy(p->piece.phi, problem->phi, n * sizeof(double));
    memcpy(p->piece.rate, problem->rate, n * sizeof(double));
    if (problem->phi_low) memcpy(p->low[0], problem->phi_low, n * sizeof(double));
    if (problem->rate_low) memcpy(p->low[1], problem->rate_low, n * sizeof(double));
    return p;
}

static void pieces_close(void **stepper) {
    struct pieces *p = *stepper;
    if (p && p->stepper) p->inner->close(&p->stepper);
    if (p) pend_stuck_free(&p->stuck);
    free(p);
    *stepper = NULL;
}

static enum pend_status pieces_open_of(void **stepper, const struct pend_method *inner,
                                       const struct pend_problem *problem,
                                       struct pend_error *error) {
    const struct pend_times *times = &problem->times;
    struct pieces *p = *stepper = pieces_allocate(inner, problem);
    if (!p) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a motion in pieces");
    double first = times->count ? pend_times_at(times, 0) : times->start;
    double last = times->count ? pend_times_at(times, times->count - 1) : first;
    p->piece.start = p->piece.now = first;
    p->piece.way = last < first ? -1 : 1;
    p->way_most =
        PEND_JOINT_TURN / pend_terms_drive_rate(problem->loads.terms, problem->loads.value);
    enum pend_status status =
        pend_rules_check(p->piece.rules, problem->tree->order, first, last, error);
    if (status == PEND_OK && p->joints) status = pend_joints_start(p->joints, error);
    if (status == PEND_OK) status = pieces_change(p, error);
    if (status == PEND_OK) status = pieces_enter(p, error);
    if (status == PEND_NO_MEMORY)
        pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a motion in pieces");
    if (status != PEND_OK) pieces_close(stepper);
    assert(status != PEND_OK || pieces_valid(p));
    return status;
}

static enum pend_status pieces_open(void **stepper, const struct pend_problem *problem,
                                    struct pend_error *error) {
    return pieces_open_of(stepper, &pend_method_taylor, problem, error);
}

static enum pend_status pieces_open_extended(void **stepper, const struct pend_problem *problem,
                                             struct pend_error *error) {
    return pieces_open_of(stepper, pend_method_taylor.extended, problem, error);
}

/* ---- steps */

/* cuts the step if a joint ends the piece; returns whether one does */
static int pieces_event(struct pieces *p, double end) {
    const struct pend_joint_step step = {.method = p->inner,
                                         .stepper = p->stepper,
                                         .stuck = p->stuck,
                                         .fresh = p->fresh,
                                         .to = end,
                                         .start = p->piece.start,
                                         .room = p->room};
    double event = pend_joint_events(p->joints, &step);
    if (!(event <= end)) return 0;
    if (event < p->reached) p->inner->cut(p->stepper, event);
    p->reached = event;
    return 1;
}

static enum pend_status pieces_step(void *stepper, double limit, double *reached,
                                    struct pend_error *error) {
    struct pieces *p = stepper;
    assert(pieces_valid(p));
    if (p->ended) PEND_TRY(pieces_begin(p, error));
    double end = p->next - p->piece.start;
    // rounding may put the end of the piece at its start; then it gets the least length
    if (p->piece.way * (end - p->reached) <= 0) end = nextafter(p->reached, p->next);
    int within = p->piece.way * (limit - end) <= 0;
    double most = p->reached + p->way_most;
    if (p->control && p->taken++ == PIECES_STEPS)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, p->reached,
                         "the controllers whirl the pendulum ever faster, with more than %d steps "
                         "between two samples: give them a \"limit\"",
                         PIECES_STEPS);
    PEND_TRY(p->inner->step(p->stepper, within ? limit : end, &p->reached, error));
    if (p->stuck && p->reached > most) {
        p->inner->cut(p->stepper, most);
        p->reached = most;
    }
    if (p->joints && pieces_event(p, fmin(p->reached, end))) {
        p->ended = PIECES_EVENT;
    } else {
        if (p->piece.way * (p->reached - end) > 0) {
            p->inner->cut(p->stepper, end);
            p->reached = end;
        }
        p->ended = p->reached == end ? PIECES_KNOWN : 0;
    }
    p->fresh = 0;
    *reached = p->reached;
    return PEND_OK;
}

static struct pend_stepper_counts pieces_counts(const void *stepper) {
    const struct pieces *p = stepper;
    struct pend_stepper_counts counts = p->inner->counts(p->stepper);
    counts.steps += p->done.steps;
    counts.rejected += p->done.rejected;
    counts.evaluations += p->done.evaluations;
    return counts;
}

static void pieces_exchange(const void *stepper, const double t[], int count, double work[],
                            double heat[]) {
    const struct pieces *p = stepper;
    p->inner->exchange(p->stepper, t, count, work, heat);
    for (int i = 0; i < count && p->joints; i++) {
        work[i] = p->work.high + (p->work.low + work[i]);
        heat[i] = p->heat.high + (p->heat.low + heat[i] + p->joints->heat);
    }
}

static void pieces_series(const void *stepper, struct pend_series *series) {
    const struct pieces *p = stepper;
    p->inner->series(p->stepper, series);
}

/* saves or restores the joints' state, and the stepper of the contracted pendulum */
static void pieces_carry_joints(struct pieces *p, struct pend_checkpoint *checkpoint) {
    struct pend_joints *joints = p->joints;
    size_t n = (size_t)joints->n;
    signed char *flags[] = {joints->mode,       joints->touch,      joints->forced, joints->struck,
                            joints->was_forced, joints->was_struck, joints->side};
    struct pend_sum *sums[] = {&p->work, &p->heat};
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++)
        pend_checkpoint_part(checkpoint, flags[i], n);
    pend_checkpoint_row(checkpoint, joints->hit, n);
    pend_checkpoint_part(checkpoint, joints->stopped, n);
    pend_checkpoint_part(checkpoint, joints->holds, n);
    pend_checkpoint_row(checkpoint, &joints->heat, 1);
    for (int i = 0; i < 2; i++) pend_checkpoint_row(checkpoint, &sums[i]->high, 1);
    for (int i = 0; i < 2; i++) pend_checkpoint_row(checkpoint, &sums[i]->low, 1);
    pend_stepper_counts_carry(&p->done, checkpoint);
    if (!pend_checkpoint_puts(checkpoint)) return;
    for (size_t k = 0; k < n; k++) joints->holds[k] = joints->mode[k] == PEND_JOINT_HOLDS;
    p->inner->close(&p->stepper);
    pend_stuck_free(&p->stuck);
    if (pieces_enter(p, NULL) != PEND_OK) pend_checkpoint_refuse(checkpoint);
}

static void pieces_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct pieces *p = stepper;
    size_t n = (size_t)p->problem.tree->n;
    double *numbers[] = {&p->piece.now, &p->begun, &p->next, &p->reached},
           *rows[] = {p->piece.phi, p->piece.rate, p->low[0], p->low[1]};
    for (int i = 0; i < 4; i++) pend_checkpoint_row(checkpoint, numbers[i], 1);
    for (int i = 0; i < 4; i++) pend_checkpoint_row(checkpoint, rows[i], n);
    pend_checkpoint_int(checkpoint, &p->ended, PIECES_EVENT);
    pend_checkpoint_int(checkpoint, &p->fresh, 1);
    pend_checkpoint_int(checkpoint, &p->stalled, PIECES_STALLED);
    pend_checkpoint_row(checkpoint, p->piece.value, (size_t)p->problem.loads.terms->count);
    if (p->control)
        pend_checkpoint_row(checkpoint, p->control, pend_control_numbers(p->piece.rules, (int)n));
    if (p->joints) pieces_carry_joints(p, checkpoint);
    if (p->stepper) p->inner->carry(p->stepper, checkpoint);
}

/* ---- methods in pieces */

#define PIECES_COMMON                                                                              \
    .name = "taylor", .summary = "Power series of the motion, piece by piece.",                    \
    .step = pieces_step, .at = pend_pieces_at, .counts = pieces_counts,                            \
    .exchange = pieces_exchange, .carry = pieces_carry, .close = pieces_close

enum {
    PIECES_FLAGS =
        PEND_METHOD_TOLERANCES | PEND_METHOD_SERIES | PEND_METHOD_THETA | PEND_METHOD_TERMS
};

static const struct pend_method pieces_taylor = {PIECES_COMMON, .flags = PIECES_FLAGS,
                                                 .open = pieces_open, .series = pieces_series};

static const struct pend_method pieces_extended = {
    PIECES_COMMON, .flags = PIECES_FLAGS | PEND_METHOD_EXTENDED, .open = pieces_open_extended};

const struct pend_method *pend_pieces_method(const struct pend_method *method,
                                             const struct pend_terms *terms) {
    if (!terms || !terms->rules) return method;
    if (method == &pend_method_taylor) return &pieces_taylor;
    // joints would need roots, impulses and rigid bodies in 32 digits
    int known = method == pend_method_taylor.extended && pend_pieces_smooth(terms);
    return known ? &pieces_extended : NULL;
}

const char *pend_pieces_unestimated(const struct pend_terms *terms) {
    int smooth = pend_pieces_smooth(terms);
    if (smooth && !(terms && terms->rules && terms->rules->controllers)) return NULL;
    return smooth
               ? "errors are not estimated through controllers: compare with an rtol of 1e-15"
               : "errors are not estimated through joints that stick or hit a stop: compare with "
                 "an rtol of 1e-15";
}

enum pend_status pend_pieces_check_smooth(const struct pend_terms *terms, const char *what,
                                          struct pend_error *error) {
    if (terms && terms->rules && terms->rules->controllers)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "%s cannot be computed through controllers: leave \"control\" out", what);
    if (pend_pieces_smooth(terms)) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "%s cannot be computed through joints that stick or hit a stop: give dry "
                     "friction a \"speed\", and leave stops out",
                     what);
}

struct pend_loads pend_pieces_loads(const struct pend_method *method, const void *stepper,
                                    const struct pend_loads *loads) {
    const struct pieces *p = stepper;
    return method->step == pieces_step ? p->problem.loads : *loads;
}

int pend_pieces_struck(const struct pend_method *method, const void *stepper, int k) {
    const struct pieces *p = stepper;
    int event = method->step == pieces_step && p->joints && p->ended == PIECES_EVENT;
    return event ? p->joints->struck[k] : 0;
}

int pend_pieces_ends(const struct pend_method *method, const void *stepper) {
    const struct pieces *p = stepper;
    return method->step == pieces_step && p->ended;
}

const double *pend_pieces_control(const struct pend_method *method, const void *stepper) {
    const struct pieces *p = stepper;
    return method->step == pieces_step ? p->control : NULL;
}

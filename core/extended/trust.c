#include "core/extended/trust.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/extended/extended.h"
#include "core/integrate/run/run.h"

enum { TRUST_NUMBERS = 4096, TRUST_ROWS = 64 };

struct pend_trust {
    int n; /* number of arms without a cart: the columns of a row */
    int parted, cap;
    double tolerance, until;
    struct pend_run *run[2];
    int done[2], count[2]; /* number of rows of the block that each run has computed */
    int compared;          /* number of compared rows of the block */
    double *t[2], *phi[2];
};

/* both runs keep their rows within the block, and only computed rows are compared */
PEND_VALIDATOR trust_valid(const struct pend_trust *trust) {
    int most = trust->count[0] > trust->count[1] ? trust->count[0] : trust->count[1];
    return trust->n >= 1 && trust->cap >= 1 && most <= trust->cap && trust->compared >= 0 &&
           trust->compared <= trust->count[0] && trust->compared <= trust->count[1];
}

void pend_trust_free(struct pend_trust **trust) {
    assert(!*trust || trust_valid(*trust));
    for (int i = 0; *trust && i < 2; i++) pend_run_free(&(*trust)->run[i]);
    free(*trust);
    *trust = NULL;
}

enum pend_status pend_trust_new(struct pend_trust **trust, const struct pend_method *method,
                                const struct pend_problem *problem, double tolerance,
                                struct pend_error *error) {
    assert(pend_tree_valid(problem->tree) && tolerance > 0);
    int n = problem->tree->n - (pend_terms_cart(problem->loads.terms) ? 1 : 0);
    int cap = TRUST_NUMBERS / n;
    cap = cap < 1 ? 1 : cap > TRUST_ROWS ? TRUST_ROWS : cap;
    size_t rows = (size_t)cap * (1 + (size_t)n);
    struct pend_trust *made = *trust = calloc(1, sizeof *made + 2 * rows * sizeof(double));
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory to compare %d arms", n);
    *made = (struct pend_trust){
        .n = n, .cap = cap, .tolerance = tolerance, .until = pend_times_at(&problem->times, 0)};
    double *block = (double *)(made + 1);
    for (int i = 0; i < 2; i++) {
        made->t[i] = block + (size_t)i * rows;
        made->phi[i] = made->t[i] + cap;
    }
    // the more accurate run uses its own tolerances
    struct pend_problem own = *problem, exact;
    // keep whole turns, whose removal would cost digits
    own.no_turns = 1;
    exact = own;
    exact.rtol = exact.atol = exact.step = 0;
    exact.atol_given = 0;
    // a run in 32 digits is compared with another of a different order; the finer run counts as
    // exact
    if (method == pend_method_taylor.extended)
        exact.rtol = problem->rtol > 0 && problem->rtol < 1e-29 ? method->rtol_default
                                                                : PEND_EXTENDED_RTOL_MIN;
    enum pend_status status = pend_run_new(&made->run[0], method, &own, error);
    if (status == PEND_OK)
        status = pend_run_new(&made->run[1], pend_method_taylor.extended, &exact, error);
    if (status != PEND_OK) pend_trust_free(trust);
    return status;
}

static enum pend_status trust_fill(struct pend_trust *trust, int i, double work,
                                   struct pend_error *error) {
    int at = trust->count[i];
    struct pend_samples rows = {.cap = trust->cap - at,
                                .t = trust->t[i] + at,
                                .phi = trust->phi[i] + (size_t)at * (size_t)trust->n};
    if (rows.cap == 0 || trust->done[i]) return PEND_OK;
    enum pend_status status = pend_run_next(trust->run[i], &rows, work, &trust->done[i], error);
    trust->count[i] += (int)rows.count;
    return status;
}

/* compares the rows that both runs have; starts an empty block when one is full */
static void trust_compare(struct pend_trust *trust) {
    int count = trust->count[0] < trust->count[1] ? trust->count[0] : trust->count[1];
    for (; trust->compared < count && !trust->parted; trust->compared++) {
        size_t row = (size_t)trust->compared * (size_t)trust->n;
        for (int k = 0; k < trust->n; k++)
            if (!(fabs(trust->phi[0][row + k] - trust->phi[1][row + k]) <= trust->tolerance))
                trust->parted = 1;
        if (!trust->parted) trust->until = trust->t[0][trust->compared];
    }
    if (count < trust->cap) return;
    trust->count[0] = trust->count[1] = trust->compared = 0;
}

enum pend_status pend_trust_next(struct pend_trust *trust, double work, int *done,
                                 struct pend_error *error) {
    assert(trust_valid(trust) && work > 0);
    for (int i = 0; i < 2; i++) PEND_TRY(trust_fill(trust, i, work, error));
    trust_compare(trust);
    *done = trust->parted || (trust->done[0] && trust->done[1]);
    assert(trust_valid(trust));
    return PEND_OK;
}

double pend_trust_until(const struct pend_trust *trust) { return trust->until; }

double pend_trust_progress(const struct pend_trust *trust) {
    assert(trust_valid(trust));
    return fmin(pend_run_stats(trust->run[0]).progress, pend_run_stats(trust->run[1]).progress);
}

enum pend_status pend_trust_carry(struct pend_trust *trust, struct pend_checkpoint *checkpoint) {
    assert(trust_valid(trust));
    size_t rows = (size_t)trust->cap * (1 + (size_t)trust->n);
    pend_checkpoint_int(checkpoint, &trust->parted, 1);
    pend_checkpoint_row(checkpoint, &trust->until, 1);
    for (int i = 0; i < 2; i++) pend_checkpoint_int(checkpoint, &trust->done[i], 1);
    for (int i = 0; i < 2; i++) pend_checkpoint_int(checkpoint, &trust->count[i], trust->cap);
    pend_checkpoint_int(checkpoint, &trust->compared, trust->cap);
    for (int i = 0; i < 2; i++) {
        pend_checkpoint_row(checkpoint, trust->t[i], rows);
        PEND_TRY(pend_run_carry(trust->run[i], checkpoint));
    }
    int good = isfinite(trust->until) != 0;
    for (int i = 0; i < 2; i++) good = good && trust->compared <= trust->count[i];
    return good ? PEND_OK : PEND_INVALID;
}

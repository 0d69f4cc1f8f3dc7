#include "api/op/ensemble/held.h"

#include <assert.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "api/encode/encode.h"
#include "api/op/ensemble/ensemble.h"
#include "core/ensemble/ensemble.h"
#include "core/tree/turns.h"

struct api_held {
    struct api_ensemble *ensemble;
    struct pend_ensemble *work;
    int torque;    /* index of the first torque among the numbers of the terms */
    double *state; /* of the current step */
    const double *input;
    long failed;
};

static long held_row(const struct api_tree *tree) { return 2L * api_tree_stored(tree) + 1; }

/* the place of the angle of stored arm k in a row; *rate: of its rate */
static int held_place(const struct api_tree *tree, int k, int *rate) {
    int arm = tree->tree->order[k], n = tree->n;
    assert(arm >= 0 && arm <= n);
    *rate = arm < n ? n + arm : 2 * n + 1;
    return arm < n ? arm : 2 * n;
}

static int held_fetch(void *context, long i, struct pend_member *member) {
    const struct api_held *held = context;
    const struct api_tree *tree = &held->ensemble->tree;
    int n = api_tree_stored(tree), rate;
    const double *state = held->state + i * held_row(tree), *input = held->input + i * n;
    for (int k = 0; k < n; k++) {
        double x = state[held_place(tree, k, &rate)];
        struct pend_sum phi = k < tree->cart ? (struct pend_sum){x, 0} : pend_turns_hanging(x);
        member->phi[k] = phi.high, member->phi_low[k] = phi.low;
        member->rate[k] = state[rate];
        member->value[held->torque + k] = input[tree->tree->order[k]];
    }
    member->start = state[2 * n];
    return 0;
}

static int held_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct api_held *held = context;
    const struct api_tree *tree = &held->ensemble->tree;
    int n = api_tree_stored(tree), failed = outcome->status != PEND_OK, rate;
    double *state = held->state + i * held_row(tree);
    for (int k = 0; k < n; k++) {
        double phi = outcome->phi[k], low = outcome->phi_low ? outcome->phi_low[k] : 0;
        double x = k < tree->cart ? phi : pend_turns_theta(phi, low);
        state[held_place(tree, k, &rate)] = failed ? NAN : x;
        state[rate] = outcome->rate[k];
    }
    state[2 * n] += outcome->time;
    held->failed += failed;
    return 0;
}

/* reads the request; returns NULL if it is refused */
static struct api_ensemble *held_read(const char *body, size_t bytes) {
    struct api_limits limits;
    struct api_problem problem;
    struct api_json *document = NULL;
    struct api_ensemble *made = NULL;
    api_limits_init(&limits);
    api_problem_init(&problem);
    if (api_json_new(&document, body, bytes, (int)limits.depth, &problem) == PEND_OK) {
        struct api_value root = api_json_root(document);
        struct api_reading reading = {&api_op_ensembles,  &root,   NULL,
                                      &api_format_octets, &limits, &problem};
        if (api_ensemble_new(&made, &reading) != PEND_OK) made = NULL;
    }
    api_json_free(&document);
    api_problem_clear(&problem);
    return made;
}

struct api_held *api_held_new(const char *body, size_t bytes) {
    struct pend_error error;
    struct api_ensemble *e = held_read(body, bytes);
    struct api_held *held = e ? calloc(1, sizeof *held) : NULL;
    if (!held) {
        api_ensemble_free(&e);
        return NULL;
    }
    const struct pend_terms *terms = e->tree.loads.terms;
    struct pend_ensemble_problem problem = {.tree = e->tree.tree,
                                            .loads = e->tree.loads,
                                            .duration = e->duration,
                                            .rtol = e->rtol,
                                            .atol = e->atol,
                                            .step_cap = e->step_cap,
                                            .fetch = held_fetch,
                                            .deliver = held_deliver,
                                            .context = held};
    held->ensemble = e;
    held->torque = terms ? terms->row[PEND_TERM_TORQUE] : -1;
    if (held->torque >= 0 &&
        pend_ensemble_new(&held->work, &problem, pend_isa_best(), &error) == PEND_OK)
        return held;
    api_held_free(held);
    return NULL;
}

void api_held_free(struct api_held *held) {
    if (!held) return;
    pend_ensemble_free(&held->work);
    api_ensemble_free(&held->ensemble);
    free(held);
}

long api_held_step(struct api_held *held, long count, double state[], const double input[]) {
    int done = 0;
    enum pend_status status = PEND_OK;
    held->state = state, held->input = input, held->failed = 0;
    pend_ensemble_begin(held->work, 0, count);
    while (status == PEND_OK && !done) status = pend_ensemble_go(held->work, LONG_MAX, &done);
    return status == PEND_OK ? held->failed : -1;
}

/* Tests of core/bodies/bodies: the general kernel against the dense Lagrangian form.
 * Leaves to others: the series over a step (laws).
 * Invariant: residuals are relative to the largest component. */
#include "core/bodies/bodies.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/dynamics/dynamics.h"
#include "tests/harness/reference_bodies.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 8 };

/* phi'' and the four forces of a state, by either form */
struct answer {
    double acc[ARMS], force[4][ARMS];
};

static struct bodies_forces answer_forces(struct answer *a) {
    return (struct bodies_forces){a->force[0], a->force[1], a->force[2], a->force[3]};
}

static void answer_quick(const struct test_tree *t, const struct test_bodies *b, double time,
                         struct answer *a) {
    struct bodies_state state = {t->phi, NULL, t->rate, time, 0};
    struct bodies_forces forces = answer_forces(a);
    void *work = aligned_alloc(64, (pend_bodies_bytes(t->tree, b->terms) + 63) / 64 * 64);
    if (!work) abort();
    pend_bodies_at(t->tree, &b->loads, &state, work, a->acc, &forces);
    free(work);
}

static void answer_dense(const struct test_tree *t, const struct test_bodies *b, double time,
                         struct answer *a) {
    struct bodies_state state = {t->phi, NULL, t->rate, time, 0};
    struct bodies_forces forces = answer_forces(a);
    CHECK(pend_reference_bodies(t->tree, &b->loads, &state, a->acc, &forces) == PEND_OK);
}

/* the largest gaps of phi'' and of the forces */
static void answer_gap(int n, const struct answer *x, const struct answer *y, double *acc,
                       double *force) {
    double most = 0, gap = 0;
    *acc = fmax(*acc, test_gap(n, x->acc, y->acc));
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < n; k++) {
            most = fmax(most, fabs(y->force[i][k]));
            gap = fmax(gap, fabs(x->force[i][k] - y->force[i][k]));
        }
    *force = fmax(*force, gap / most);
}

TEST(bodies_agree_with_the_dense_form_on_all_small_trees) {
    unsigned long long seed = 1;
    for (unsigned what = 0; what <= 9; what++) {
        unsigned terms = what < 8 ? 1u << what : TEST_TERMS_ALL;
        if (what == 9) terms |= TEST_TERMS_PIECES;
        double acc = 0, force = 0;
        for (int n = 1; n <= (what >= 8 ? 7 : 5); n++) {
            int parent[ARMS];
            test_parents_first(n, parent);
            do {
                struct test_tree t;
                struct test_bodies b;
                struct answer quick, dense;
                double time = 100 * test_random(&seed) - 50;
                test_tree_init(&t, n, parent, 0.5, &seed);
                test_bodies_random(&b, t.tree, terms, &seed);
                answer_quick(&t, &b, time, &quick);
                answer_dense(&t, &b, time, &dense);
                answer_gap(n, &quick, &dense, &acc, &force);
                test_bodies_clear(&b);
                test_tree_clear(&t);
            } while (test_parents_next(n, parent));
        }
        char text[60];
        snprintf(text, sizeof text, "phi'' and forces with terms %#x", terms);
        CHECK_RESIDUAL(acc, 2e-13, text);
        CHECK_RESIDUAL(force, 4e-13, text);
    }
}

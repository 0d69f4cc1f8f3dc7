/* One evaluation of the accelerations and forces, by shape and size, against the paper's matrix form.
 * Leaves to others: integration (bench_trajectory).
 * Invariant: the same seed, the same trees. */
#include <stdlib.h>

#include "core/dynamics.h"
#include "core/reference.h"
#include "tests/bench/bench.h"

enum { ARMS_MOST = 4096 };

static double length[ARMS_MOST], mass[ARMS_MOST], phi[ARMS_MOST], rate[ARMS_MOST], acc[ARMS_MOST], force[ARMS_MOST];
static int parent[ARMS_MOST];

/* reach: how many arms back a parent may be; 1 makes a chain */
static struct pend_tree *tree_new(int n, int reach) {
    struct pend_tree *tree;
    srand(1);
    for (int i = 0; i < n; i++) {
        length[i] = 0.5 + rand() / (double)RAND_MAX;
        mass[i] = 0.5 + rand() / (double)RAND_MAX;
        phi[i] = 6 * (rand() / (double)RAND_MAX);
        rate[i] = rand() / (double)RAND_MAX;
        parent[i] = i == 0 ? -1 : i - 1 - rand() % (i < reach ? i : reach);
    }
    if (pend_tree_new(&tree, n, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    return tree;
}

static void evaluate(struct bench *bench, int n, int reach) {
    struct pend_tree *tree = tree_new(n, reach);
    void *work = aligned_alloc(64, (pend_dynamics_work_bytes(n) + 63) / 64 * 64);
    while (bench_go(bench, n)) pend_dynamics(tree, 9.81, phi, rate, work, acc, force);
    free(work);
    pend_tree_free(&tree);
}

BENCH(dynamics_four_arms, "arm") { evaluate(bench, 4, 4); }
BENCH(dynamics_chain_of_100, "arm") { evaluate(bench, 100, 1); }
BENCH(dynamics_random_tree_of_100, "arm") { evaluate(bench, 100, 100); }
BENCH(dynamics_random_tree_of_4096, "arm") { evaluate(bench, 4096, 4096); }

BENCH(matrix_form_random_tree_of_100, "arm") {
    struct pend_tree *tree = tree_new(100, 100);
    while (bench_go(bench, 100))
        if (pend_reference_dynamics(tree, 9.81, phi, rate, acc, force) != PEND_OK) bench_broken("matrix form");
    pend_tree_free(&tree);
}

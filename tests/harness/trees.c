#include "tests/harness/trees.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "tests/harness/test.h"

const char *test_tree_kind_name(enum test_tree_kind kind) {
    static const char *const name[TEST_TREE_KINDS] = {"attached",    "chain", "star", "binary",
                                                      "caterpillar", "broom", "limbs"};
    return name[kind];
}

static int parents_one(enum test_tree_kind kind, int n, int k, unsigned long long *seed) {
    switch (kind) {
    case TEST_TREE_CHAIN:
        return k - 1;
    case TEST_TREE_STAR:
        return 0;
    case TEST_TREE_BINARY:
        return (k - 1) / 2;
    case TEST_TREE_CATERPILLAR:
        return k < 2 ? 0 : k % 2 ? k - 1 : k - 2;
    case TEST_TREE_BROOM:
        return k < (n + 1) / 2 ? k - 1 : (n - 1) / 2;
    case TEST_TREE_LIMBS:
        return k - 1 - test_random_int(seed, k < 3 ? k : 3);
    default:
        return test_random_int(seed, k);
    }
}

void test_parents(enum test_tree_kind kind, int n, int parent[], unsigned long long *seed) {
    parent[0] = -1;
    for (int k = 1; k < n; k++) parent[k] = parents_one(kind, n, k, seed);
}

/* calloc that aborts, for memory without which a test cannot begin */
static void *trees_room(size_t count, size_t bytes) {
    void *room = calloc(count, bytes);
    if (!room) abort();
    return room;
}

void test_parents_shuffle(int n, int parent[], unsigned long long *seed) {
    int *name = trees_room(2 * (size_t)n, sizeof *name), *old = name + n;
    memcpy(old, parent, (size_t)n * sizeof *old);
    for (int i = 0; i < n; i++) {
        int j = test_random_int(seed, i + 1);
        name[i] = name[j];
        name[j] = i;
    }
    for (int i = 0; i < n; i++) parent[name[i]] = old[i] < 0 ? -1 : name[old[i]];
    free(name);
}

void test_parents_first(int n, int parent[]) {
    for (int k = 0; k < n; k++) parent[k] = k ? 0 : -1;
}

int test_parents_next(int n, int parent[]) {
    // an odometer whose digit k runs from 0 to k - 1
    for (int k = n - 1; k > 1; k--) {
        if (++parent[k] < k) return 1;
        parent[k] = 0;
    }
    return 0;
}

void test_tree_init(struct test_tree *t, int n, const int parent[], double spread,
                    unsigned long long *seed) {
    double *block = trees_room(4 * (size_t)n, sizeof *block);
    *t = (struct test_tree){n,
                            block,
                            block + n,
                            trees_room((size_t)n, sizeof *t->parent),
                            block + 2 * n,
                            block + 3 * n,
                            NULL};
    memcpy(t->parent, parent, (size_t)n * sizeof *parent);
    for (int i = 0; i < n; i++) {
        t->length[i] = pow(10, 0.3 * (2 * test_random(seed) - 1));
        t->mass[i] = pow(10, spread * (2 * test_random(seed) - 1));
        t->phi[i] = 3.141592653589793 * (2 * test_random(seed) - 1);
        t->rate[i] = 3 * (2 * test_random(seed) - 1);
    }
    test_tree_rebuild(t);
}

void test_tree_random(struct test_tree *t, enum test_tree_kind kind, int n, double spread,
                      unsigned long long *seed) {
    OWN_MEMORY int *parent = trees_room((size_t)n, sizeof *parent);
    test_parents(kind, n, parent, seed);
    test_parents_shuffle(n, parent, seed);
    test_tree_init(t, n, parent, spread, seed);
}

void test_tree_rebuild(struct test_tree *t) {
    pend_tree_free(&t->tree);
    if (pend_tree_new(&t->tree, t->n, t->length, t->mass, t->parent, NULL)) abort();
}

void test_tree_clear(struct test_tree *t) {
    free(t->length);
    free(t->parent);
    pend_tree_free(&t->tree);
    *t = (struct test_tree){0};
}

void test_tree_dynamics(const struct test_tree *t, const struct pend_loads *loads, double acc[],
                        double force[]) {
    static const unsigned long long signalling = 0x7ff4deadbeef0000ull;
    size_t bytes = pend_dynamics_work_bytes(t->n);
    OWN_MEMORY char *work = aligned_alloc(64, bytes);
    if (!work) abort();
    for (size_t at = 0; at < bytes; at += sizeof signalling)
        memcpy(work + at, &signalling, sizeof signalling);
    pend_dynamics(t->tree, loads, t->phi, t->rate, work, acc, force);
}

double test_gap(int n, const double a[], const double b[]) {
    double most = 0, gap = 0;
    for (int i = 0; i < n; i++) {
        double here = fabs(a[i] - b[i]);
        if (!(here <= gap)) gap = here;
        if (isnan(gap)) return gap;
        most = fmax(most, fabs(b[i]));
    }
    return gap > 0 ? gap / most : 0;
}

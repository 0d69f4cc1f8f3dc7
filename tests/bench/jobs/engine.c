/* The time that the engine alone needs for the map of flips that `make load T=members` computes as
 * a job: no request, no store, no thread. Leaves to others: the job (tests/load/jobs.py).
 * Invariant: the same members, tolerance and ends. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "tests/harness/ensembles.h"

struct map {
    long side;
    long flipped;
};

static int map_fetch(void *context, long i, struct pend_member *member) {
    const struct map *map = context;
    const double step = 6.0 / (double)(map->side - 1);
    member->phi[0] = -3 + step * (double)(i / map->side) - M_PI_2;
    member->phi[1] = -3 + step * (double)(i % map->side) - M_PI_2;
    return 0;
}

static int map_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct map *map = context;
    (void)i;
    map->flipped += isfinite(outcome->first);
    return outcome->status != PEND_OK;
}

/* usage: engine SIDE RTOL SHARE: runs one block of SIDE members in SHARE; prints the number of
 * members, seconds of processor time, and flips */
int main(int argc, char **argv) {
    struct map map = {.side = argc > 3 ? atol(argv[1]) : 1000};
    const double length[] = {1, 1}, mass[] = {1, 1};
    const int parent[] = {-1, 0};
    struct pend_tree *tree;
    struct pend_ensemble *work;
    long members = 0, share = argc > 3 ? atol(argv[3]) : 1;
    if (pend_tree_new(&tree, 2, length, mass, parent, NULL) != PEND_OK) return 1;
    struct pend_ensemble_problem problem = {.tree = tree,
                                            .loads.gravity = 9.81,
                                            .duration = 20,
                                            .rtol = argc > 3 ? atof(argv[2]) : 1e-9,
                                            .fetch = map_fetch,
                                            .deliver = map_deliver,
                                            .context = &map,
                                            .bound = M_PI,
                                            .until = PEND_UNTIL_FIRST,
                                            .spare = 1};
    if (pend_ensemble_new(&work, &problem, pend_isa_best(), NULL) != PEND_OK) return 1;
    clock_t begin = clock();
    for (long row = 0; row < map.side; row += share, members += map.side)
        if (test_ensemble_run(work, row * map.side, map.side) != PEND_OK) return 1;
    double seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    printf("{\"members\":%ld,\"seconds\":%.6f,\"flipped\":%ld}\n", members, seconds, map.flipped);
    pend_ensemble_free(&work);
    pend_tree_free(&tree);
    return 0;
}

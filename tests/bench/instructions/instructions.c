/* Runs each hot loop a few times, each from its own function, so that an instruction counter can
 * distinguish them.
 * Leaves to others: counting, and the limits of the counts (tests/rules/instructions.sh).
 * Invariant: the same work every time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/dynamics/dynamics.h"
#include "core/integrate/methods/method.h"
#include "core/tree/tree.h"

#define GRAVITY 9.81
static const struct pend_loads loads = {.gravity = GRAVITY};

static double random_number(unsigned long long *state) {
    unsigned long long x = (*state += 0x9e3779b97f4a7c15ull);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

static double *room(size_t bytes) {
    double *memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!memory) exit(1);
    return memory;
}

/* a tree in PEND_DYNAMICS_VEC states, arm by arm; the first n numbers are a single state */
struct subject {
    struct pend_tree *tree;
    double *phi, *rate, *acc, *force;
    void *work;
};

static void subject_init(struct subject *s, int n) {
    enum { LANES = PEND_DYNAMICS_VEC };
    unsigned long long seed = 7;
    size_t count = (size_t)n, bytes = LANES * count * sizeof(double),
           one = pend_dynamics_work_bytes(n);
    double *length = room(count * sizeof *length), *mass = room(count * sizeof *mass);
    int *parent = (int *)room(count * sizeof *parent);
    for (int i = 0; i < n; i++) {
        length[i] = pow(10, 0.6 * random_number(&seed) - 0.3);
        mass[i] = pow(10, 0.6 * random_number(&seed) - 0.3);
        parent[i] = i == 0 ? -1 : (int)(random_number(&seed) * i);
    }
    if (pend_tree_new(&s->tree, n, length, mass, parent, NULL)) exit(1);
    s->phi = room(bytes), s->rate = room(bytes), s->acc = room(bytes), s->force = room(bytes);
    s->work = room(one > pend_dynamics_vec_bytes(n) ? one : pend_dynamics_vec_bytes(n));
    for (int k = 0; k < LANES * n; k++)
        s->phi[k] = 6 * random_number(&seed), s->rate[k] = 2 * random_number(&seed);
    free(length);
    free(mass);
    free(parent);
}

static void subject_clear(struct subject *s) {
    pend_tree_free(&s->tree);
    free(s->phi);
    free(s->rate);
    free(s->acc);
    free(s->force);
    free(s->work);
}

#define COUNTED __attribute__((noinline)) void

COUNTED count_one(struct subject *s);
COUNTED count_one(struct subject *s) {
    pend_dynamics_for(PEND_ISA_AVX2, s->tree, &loads, s->phi, s->rate, s->work, s->acc, s->force);
}

COUNTED count_lanes(struct subject *s);
COUNTED count_lanes(struct subject *s) {
    pend_dynamics_vec_for(PEND_ISA_AVX2, s->tree, &loads, s->phi, s->rate, s->work, s->acc,
                          s->force);
}

/* steps of the Taylor method */
static void steps(const struct subject *s, int count) {
    struct pend_problem problem = {
        .tree = s->tree, .loads.gravity = GRAVITY, .phi = s->phi, .rate = s->rate};
    struct pend_error error;
    void *stepper;
    double reached;
    problem.times.count = 2, problem.times.span = 1000, problem.times.divisor = 1;
    problem.rtol = problem.atol = 1e-12;
    if (pend_method_taylor.open(&stepper, &problem, &error)) exit(1);
    for (int i = 0; i < count; i++)
        if (pend_method_taylor.step(stepper, 1000, &reached, &error)) exit(1);
    pend_method_taylor.close(&stepper);
}

COUNTED count_taylor_small(struct subject *s);
COUNTED count_taylor_small(struct subject *s) { steps(s, 100); }

COUNTED count_taylor_large(struct subject *s);
COUNTED count_taylor_large(struct subject *s) { steps(s, 10); }

int main(void) {
    static const struct {
        int n;
        void (*run)(struct subject *);
    } lines[] = {
        {1024, count_one},
        {128, count_lanes},
        {2, count_taylor_small},
        {200, count_taylor_large},
    };
    if (pend_isa_best() < PEND_ISA_AVX2) {
        printf("no avx2\n");
        return 0;
    }
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        struct subject s;
        subject_init(&s, lines[i].n);
        lines[i].run(&s);
        subject_clear(&s);
    }
}

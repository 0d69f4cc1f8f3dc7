#include "tests/harness/motions.h"

#include <math.h>
#include <stdlib.h>

static const double gravity = 9.81;

const char *test_motion_name(enum test_motion_kind kind) {
    static const char *const name[TEST_MOTION_KINDS] = {"chaotic", "regular", "damped", "stiff",
                                                        "stuck",   "driven",  "cart"};
    return name[kind];
}

static double between(double from, double to, unsigned long long *seed) {
    unsigned long long z = *seed += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return from + (to - from) * (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static double power(double from, double to, unsigned long long *seed) {
    return pow(10, between(from, to, seed));
}

static void draw_tree(struct test_motion *m, int n, int cart, unsigned long long *seed) {
    double length[TEST_MOTION_ARMS], mass[TEST_MOTION_ARMS];
    int parent[TEST_MOTION_ARMS];
    for (int k = 0; k < n; k++) {
        length[k] = k == 0 && cart ? 1 : power(-0.3, 0.3, seed);
        mass[k] = power(-0.3, 0.3, seed);
        parent[k] = k ? (int)between(0, k, seed) : -1;
    }
    if (pend_tree_new(&m->tree, n, length, mass, parent, NULL) != PEND_OK) abort();
}

/* terms without effect yet; `drives` of one harmonic, or its absence */
static void draw_terms(struct test_motion *m, int cart, const int *drives) {
    unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_DAMPING] = 1, [PEND_TERM_FRICTION] = 1},
                  ones[PEND_TERM_ONES] = {[PEND_TERM_RAIL] = (unsigned char)cart};
    int place[1], n = m->tree->n;
    if (pend_terms_new(&m->terms, n, rows, ones, drives != NULL, drives, place) != PEND_OK) abort();
    if (m->terms->count > TEST_MOTION_NUMBERS) abort();
    pend_terms_clear(m->terms, m->tree, m->value);
}

static void draw_start(struct test_motion *m, double angle, double rate, int cart,
                       unsigned long long *seed) {
    for (int k = 0; k < m->tree->n; k++) {
        m->phi[k] = between(-angle, angle, seed) - (k || !cart ? M_PI_2 : 0);
        m->rate[k] = between(-rate, rate, seed);
    }
}

static double *row(struct test_motion *m, enum pend_term_row of) {
    return m->value + m->terms->row[of];
}

/* critical damping of the joint for an arm and what it carries */
static double critical(const struct test_motion *m, int k) {
    double length = m->tree->len[k];
    return 2 * m->tree->subtree_mass[k] * length * sqrt(gravity * length);
}

static void draw_real(struct test_motion *m, enum test_motion_kind kind, unsigned long long *seed) {
    int cart = kind == TEST_MOTION_CART, n = kind == TEST_MOTION_STIFF ? 2 : 0;
    int drives = between(0, 1, seed) < 0.5 ? 0 : PEND_DRIVE_PIVOT_Y;
    draw_tree(m, n ? n : (int)between(1 + cart, 4, seed), cart, seed);
    draw_terms(m, cart, kind == TEST_MOTION_DRIVEN ? &drives : NULL);
    draw_start(m, kind == TEST_MOTION_STUCK ? 1.5 : 3, 1, cart, seed);
    for (int k = 0; k < m->tree->n; k++) {
        double *damping = row(m, PEND_TERM_DAMPING) + k, *dry = row(m, PEND_TERM_FRICTION) + k;
        *damping = critical(m, k) * (kind == TEST_MOTION_DAMPED   ? power(-1.5, 2, seed)
                                     : kind == TEST_MOTION_STUCK  ? power(-3, -1, seed)
                                     : kind == TEST_MOTION_DRIVEN ? power(-2, -0.5, seed)
                                     : kind == TEST_MOTION_CART   ? power(-2, 1, seed)
                                     : k                          ? power(-0.5, 1.5, seed)
                                                                  : power(-3, -1, seed));
        if (kind != TEST_MOTION_STUCK) continue;
        *dry = m->tree->subtree_mass[k] * m->tree->len[k] * gravity * power(-1.5, 0, seed);
        row(m, PEND_TERM_FRICTION_SPEED)[k] = power(-2, -0.5, seed);
    }
    if (kind == TEST_MOTION_DRIVEN) {
        double *drive = m->value + m->terms->harmonic[0].at;
        drive[0] = drives < 0 ? between(0.01, 0.1, seed) : critical(m, 0) * between(0.2, 2, seed);
        drive[1] = between(1, drives < 0 ? 20 : 6, seed);
    }
    m->span = power(0.7, kind == TEST_MOTION_STUCK ? 1.3 : 1.8, seed);
}

void test_motion_init(struct test_motion *motion, enum test_motion_kind kind, int i) {
    unsigned long long seed = 0x1000ull * (unsigned)kind + (unsigned)i;
    *motion = (struct test_motion){.terms = NULL};
    if (kind == TEST_MOTION_CHAOTIC) {
        draw_tree(motion, 2 + i % (TEST_MOTION_ARMS - 1), 0, &seed);
        draw_start(motion, M_PI, 1, 0, &seed);
        motion->span = between(5, 100, &seed);
    } else if (kind == TEST_MOTION_REGULAR) {
        int n = 1 + i % 3;
        draw_tree(motion, n, 0, &seed);
        draw_start(motion, n == 1 ? 3 : 0.4, 0, 0, &seed);
        motion->span = power(1.7, 3, &seed);
    } else {
        draw_real(motion, kind, &seed);
    }
}

int test_motion_arms(const struct test_motion *motion) {
    return motion->tree->n - pend_terms_cart(motion->terms);
}

struct pend_loads test_motion_loads(const struct test_motion *motion) {
    return (struct pend_loads){gravity, motion->terms, motion->terms ? motion->value : NULL};
}

void test_motion_clear(struct test_motion *motion) {
    pend_terms_free(&motion->terms);
    pend_tree_free(&motion->tree);
}

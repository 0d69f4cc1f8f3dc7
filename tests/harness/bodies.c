#include "tests/harness/bodies.h"

#include <math.h>
#include <stdlib.h>

#include "tests/harness/test.h"

static double between(double low, double high, unsigned long long *seed) {
    return low + (high - low) * test_random(seed);
}

static void row_fill(struct test_bodies *b, enum pend_term_row row, double low, double high,
                     unsigned long long *seed) {
    int at = b->terms->row[row];
    for (int k = 0; k < b->terms->n && at >= 0; k++) b->value[at + k] = between(low, high, seed);
}

/* ranges of random values; any other term's are from 0.05 to 0.5 */
static const struct {
    enum pend_term_row row;
    double low, high;
} usual[] = {{PEND_TERM_ROD, 0.3, 2},
             {PEND_TERM_BODY, 0.3, 2},
             {PEND_TERM_CENTER_X, -0.3, 1},
             {PEND_TERM_CENTER_Y, -0.3, 0.3},
             {PEND_TERM_INERTIA, 0.05, 0.3},
             {PEND_TERM_STIFFNESS, 0.5, 2},
             {PEND_TERM_REST, -1, 1},
             {PEND_TERM_FRICTION_SPEED, 0.3, 3},
             {PEND_TERM_TORQUE, -1, 1},
             {PEND_TERM_DRAG, 0, 0.3},
             {PEND_TERM_DRAG_QUADRATIC, 0, 0.3},
             {PEND_TERM_DRAG_SPEED, 0.3, 3},
             {PEND_TERM_INPUT, -1, 1},
             {PEND_TERM_INPUT_RATE, -1, 1},
             {PEND_TERM_SLIDE, -1, 1}};

static void fill_rows(struct test_bodies *b, unsigned long long *seed) {
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        double low = 0.05, high = 0.5;
        if (r == PEND_TERM_AT_X || r == PEND_TERM_AT_Y) continue; /* absent for some arms */
        for (size_t i = 0; i < sizeof usual / sizeof *usual; i++)
            if ((int)usual[i].row == r) low = usual[i].low, high = usual[i].high;
        row_fill(b, (enum pend_term_row)r, low, high, seed);
    }
}

static void fill(struct test_bodies *b, const struct pend_tree *tree, unsigned long long *seed) {
    fill_rows(b, seed);
    for (int k = 1; k < b->terms->n && b->terms->row[PEND_TERM_AT_X] >= 0; k++) {
        if (test_random(seed) < 0.4) continue;
        b->terms->hung[k] = 1;
        b->value[b->terms->row[PEND_TERM_AT_X] + k] =
            between(0.2, 1.2, seed) * tree->len[tree->parent[k]];
        b->value[b->terms->row[PEND_TERM_AT_Y] + k] = between(-0.3, 0.3, seed);
    }
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (b->terms->one[i] >= 0) b->value[b->terms->one[i]] = between(0.05, 0.5, seed);
    for (int i = 0; i < b->terms->harmonics; i++) {
        double *h = b->value + b->terms->harmonic[i].at;
        h[0] = between(0.05, 0.2, seed), h[1] = between(1, 9, seed), h[2] = between(-3, 3, seed);
    }
}

/* arm 0 becomes a cart, which has no body and no drag and whose arms hang at no tip */
static void fill_cart(struct test_bodies *b, const struct pend_tree *tree) {
    static const enum pend_term_row none[] = {
        PEND_TERM_ROD,     PEND_TERM_BODY, PEND_TERM_CENTER_X,      PEND_TERM_CENTER_Y,
        PEND_TERM_INERTIA, PEND_TERM_DRAG, PEND_TERM_DRAG_QUADRATIC};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++)
        if (b->terms->row[none[i]] >= 0) b->value[b->terms->row[none[i]]] = 0;
    for (int k = 1; k < tree->n; k++)
        if (!tree->parent[k]) b->terms->hung[k] = 0;
}

/* the bit of random pendulums that have a term; other terms act in the joints, as damping does */
static unsigned row_bit(enum pend_term_row row) {
    if (row <= PEND_TERM_AT_Y) return TEST_TERMS_RODS;
    if (row == PEND_TERM_STIFFNESS || row == PEND_TERM_REST) return TEST_TERMS_SPRINGS;
    if (row == PEND_TERM_FRICTION || row == PEND_TERM_FRICTION_SPEED) return TEST_TERMS_FRICTION;
    if (row == PEND_TERM_TORQUE) return TEST_TERMS_TORQUES;
    if (row >= PEND_TERM_INPUT) return TEST_TERMS_PIECES;
    return row >= PEND_TERM_DRAG ? TEST_TERMS_DRAG : TEST_TERMS_DAMPING;
}

void test_bodies_random(struct test_bodies *b, const struct pend_tree *tree, unsigned what,
                        unsigned long long *seed) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int drives[5], place[5], harmonics = 0;
    for (int r = 0; r < PEND_TERM_ROWS; r++) rows[r] = (what & row_bit((enum pend_term_row)r)) != 0;
    if (what & TEST_TERMS_DRAG_PER_MASS) ones[PEND_TERM_DRAG_PER_MASS] = 1;
    if (what & TEST_TERMS_PIECES) ones[PEND_TERM_PIECE] = 1;
    if (what & TEST_TERMS_CART) ones[PEND_TERM_RAIL] = 1;
    if (what & TEST_TERMS_TORQUES) {
        for (int i = 0; i < 2; i++) drives[harmonics++] = (int)(test_random(seed) * tree->n);
    }
    if (what & TEST_TERMS_PIVOT) {
        ones[PEND_TERM_PIVOT_ACCELERATION_X] = 1;
        drives[harmonics++] = PEND_DRIVE_PIVOT_Y;
        drives[harmonics++] = PEND_DRIVE_PIVOT_X;
        drives[harmonics++] = PEND_DRIVE_PIVOT_Y;
    }
    if (pend_terms_new(&b->terms, tree->n, rows, ones, harmonics, drives, place) != PEND_OK)
        abort();
    b->value = calloc((size_t)b->terms->count + 1, sizeof *b->value);
    if (!b->value) abort();
    pend_terms_clear(b->terms, tree, b->value);
    fill(b, tree, seed);
    if (what & TEST_TERMS_CART) fill_cart(b, tree);
    b->loads = (struct pend_loads){9.81, b->terms, b->value};
}

void test_bodies_clear(struct test_bodies *b) {
    pend_terms_free(&b->terms);
    free(b->value);
    b->value = NULL;
}

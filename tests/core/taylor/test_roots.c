/* Tests of roots: turning points at any distance, touching, pieces, extremes, on polynomials with
 * known roots. Leaves to others: series of real motions (test_ensemble).
 * Invariant: each polynomial is given by its roots, so that the right answer is known
 * beforehand. */
#include "core/taylor/roots.h"

#include <math.h>
#include <string.h>

#include "tests/harness/test.h"

/* scale times the product of (s - root), its constant term in base */
static struct roots_path from_roots(int count, const double root[], double scale) {
    struct roots_path path;
    memset(&path, 0, sizeof path);
    path.degree = count;
    double c[PEND_ROOTS_DEGREE + 1] = {scale};
    for (int i = 0; i < count; i++) {
        for (int j = i + 1; j > 0; j--) c[j] = c[j - 1] - root[i] * c[j];
        c[0] *= -root[i];
    }
    path.base = c[0];
    for (int j = 1; j <= count; j++) path.a[j] = c[j];
    return path;
}

TEST(roots_finds_a_pair_of_crossings_that_are_close) {
    double worst = 0;
    // from below: out at the first root, back at the second, the rest of the step inside
    for (double gap = 0.2; gap > 3e-6; gap /= 3) {
        for (double at = 0.01; at < 0.95; at += 0.0573) {
            double root[3] = {at, at + gap, 5};
            struct roots_path path = from_roots(3, root, 1);
            int way = 0;
            pend_roots_divide(&path);
            double s = pend_roots_next(&path, 0, -100, 0, &way);
            if (!CHECK(way == 1 && s < 1)) return;
            worst = fmax(worst, fabs(s - at) * gap);
            way = 0;
            s = pend_roots_next(&path, s, 0, 100, &way);
            if (at + gap > 1) continue;
            if (!CHECK(way == -1 && s > at)) return;
            worst = fmax(worst, fabs(s - at - gap) * gap);
            CHECK(pend_roots_next(&path, s, -100, 0, &way) == INFINITY);
        }
    }
    CHECK_RESIDUAL(worst, 1e-14, "place of a crossing, times the gap to the next");
}

TEST(roots_does_not_see_what_stays_below_by_little) {
    for (double at = 0.05; at < 1; at += 0.1) {
        double root[2] = {at, at};
        struct roots_path under = from_roots(2, root, -1), over = under;
        int way = 0;
        under.base -= 1e-13;
        over.base += 1e-13;
        pend_roots_divide(&under);
        pend_roots_divide(&over);
        CHECK(pend_roots_next(&under, 0, -100, 0, &way) == INFINITY && way == 0);
        CHECK(fabs(pend_roots_next(&over, 0, -100, 0, &way) - at) < 1e-6 && way == 1);
    }
}

TEST(roots_counts_all_pieces_of_a_wild_polynomial) {
    // Chebyshev's polynomial of degree d on [0, 1] turns d - 1 times and crosses every level inside
    // d times
    for (int d = 2; d <= 10; d++) {
        double root[PEND_ROOTS_DEGREE], worst = 0;
        for (int i = 0; i < d; i++) root[i] = 0.5 - 0.5 * cos(M_PI * (i + 0.5) / d);
        struct roots_path path = from_roots(d, root, 1);
        pend_roots_divide(&path);
        CHECK_INT(path.pieces, d);
        double s = 0;
        for (int i = 0; i < d; i++) {
            int way = 0, up = (i + d) % 2;
            // the sign left of the first root is that of (-1)^d
            s = pend_roots_next(&path, s, up ? -100 : 0, up ? 0 : 100, &way);
            if (!CHECK(way == (up ? 1 : -1))) return;
            worst = fmax(worst, fabs(s - root[i]));
        }
        CHECK(worst < 1e-7);
    }
}

TEST(roots_extremes_are_those_of_the_turning_points) {
    // s (1 - s)^2 is largest at 1/3 with 4/27, and 0 at both ends
    double root[3] = {0, 1, 1};
    struct roots_path path = from_roots(3, root, 1);
    pend_roots_divide(&path);
    struct roots_extremes found = pend_roots_extremes(&path);
    CHECK_RESIDUAL(fabs(found.most - 4.0 / 27), 1e-15, "largest value");
    CHECK(fabs(found.most_at - 1.0 / 3) < 1e-8 && fabs(found.least) < 1e-16);
    path = (struct roots_path){.degree = 1, .base = 2, .a = {0, -3}};
    pend_roots_divide(&path);
    found = pend_roots_extremes(&path);
    CHECK(found.most == 2 && found.most_at == 0 && found.least == -1 && found.least_at == 1);
}

TEST(roots_leaves_at_once_where_it_starts_outside) {
    struct roots_path path = {.degree = 2, .base = 1, .a = {0, 0.5, 0.1}};
    int way = 0;
    pend_roots_divide(&path);
    CHECK(pend_roots_next(&path, 0, -1, 1, &way) == 0 && way == 1);
    CHECK(pend_roots_next(&path, 0, 1, 3, &way) == INFINITY);
}

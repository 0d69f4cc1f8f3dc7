/* Tests of core/dynamics/dynamics: known motions, the interface's promises, and trees that break
 * less careful forms.
 * Leaves to others: agreement with the matrix form over all trees, symmetries, energy (laws).
 * Invariant: residuals are relative to the largest component. */
#include "core/dynamics/dynamics.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/quad.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

static const double DOWN = -1.5707963267948966;

TEST(dynamics_of_a_single_arm_are_the_textbooks) {
    unsigned long long seed = 1;
    double worst_acc = 0, worst_force = 0;
    for (int i = 0; i < 1000; i++) {
        OWN(test_tree, clear) t;
        double acc, force, g = 20 * test_random(&seed) - 5;
        test_tree_random(&t, TEST_TREE_CHAIN, 1, 2, &seed);
        test_tree_dynamics(&t, TEST_LOADS(g), &acc, &force);
        double l = t.length[0], m = t.mass[0], pull = m * l * t.rate[0] * t.rate[0],
               weight = m * g * sin(t.phi[0]);
        worst_acc = fmax(worst_acc, fabs(acc + g * cos(t.phi[0]) / l) / fabs(g / l));
        worst_force = fmax(worst_force, fabs(force - (weight - pull)) / (pull + fabs(m * g)));
    }
    CHECK_RESIDUAL(worst_acc, 1e-15, "phi'' = -g cos(phi) / l");
    CHECK_RESIDUAL(worst_force, 1e-15, "lambda = -m l phi'^2 + g m sin(phi)");
}

TEST(dynamics_of_a_hanging_tree_carry_the_weights) {
    unsigned long long seed = 2;
    double worst = 0, worst_acc = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        enum { N = 60 };
        double acc[N], force[N];
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)kind, N, 2, &seed);
        for (int k = 0; k < N; k++) t.phi[k] = DOWN, t.rate[k] = 0;
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        for (int k = 0; k < N; k++) {
            // lambda = -(g S^T m), arm by arm
            worst = fmax(worst, fabs(force[k] / (-9.81 * t.tree->subtree_mass[k]) - 1));
            worst_acc = fmax(worst_acc, fabs(acc[k]) * t.tree->len[k] / 9.81);
        }
    }
    CHECK_RESIDUAL(worst, 4e-15, "lambda = -(g S^T m) of hanging trees");
    CHECK_RESIDUAL(worst_acc, 1e-15, "a hanging tree rests, but for the last digit of pi/2");
}

TEST(dynamics_reproduce_the_papers_forces_for_one_tree_alone) {
    // of the six parent lists of four arms only [0 1 2 2] has the forces of the paper's example
    struct test_paper_row row[TEST_PAPER_ROWS];
    static const double length[] = {2, 1.5, 0.75, 1.25}, mass[] = {1, 1, 1, 0.1};
    int parent[4], alike = 0;
    REQUIRE(test_paper_read(row));
    test_parents_first(4, parent);
    do {
        struct test_tree t = {
            .n = 4, .length = (double *)length, .mass = (double *)mass, .parent = parent};
        double worst = 0, phi[4], rate[4], want[4], acc[4], force[4];
        test_tree_rebuild(&t);
        t.phi = phi, t.rate = rate;
        for (int i = 0; i < TEST_PAPER_ROWS; i++) {
            for (int k = 0; k < 4; k++) {
                int arm = t.tree->order[k];
                phi[k] = row[i].phi[arm], rate[k] = row[i].rate[arm], want[k] = row[i].force[arm];
            }
            test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
            worst = fmax(worst, test_gap(4, force, want));
        }
        if (worst < 0.1) {
            alike++;
            CHECK_RESIDUAL(worst, 2e-15, "lambda of the paper's example at all its instants");
            CHECK(parent[1] == 0 && parent[2] == 1 && parent[3] == 1);
        }
        pend_tree_free(&t.tree);
    } while (test_parents_next(4, parent));
    CHECK_INT(alike, 1);
}

/* accelerations of a double pendulum as in textbooks, with angles from hanging */
static void double_pendulum(const double l[2], const double m[2], double g, const double a[2],
                            const double w[2], double acc[2]) {
    double d = a[0] - a[1], den = 2 * m[0] + m[1] - m[1] * cos(2 * d);
    acc[0] = (-g * (2 * m[0] + m[1]) * sin(a[0]) - m[1] * g * sin(a[0] - 2 * a[1]) -
              2 * sin(d) * m[1] * (w[1] * w[1] * l[1] + w[0] * w[0] * l[0] * cos(d))) /
             (l[0] * den);
    acc[1] = 2 * sin(d) *
             (w[0] * w[0] * l[0] * (m[0] + m[1]) + g * (m[0] + m[1]) * cos(a[0]) +
              w[1] * w[1] * l[1] * m[1] * cos(d)) /
             (l[1] * den);
}

TEST(dynamics_of_a_double_pendulum_are_the_textbooks) {
    unsigned long long seed = 4;
    double worst = 0;
    for (int i = 0; i < 1000; i++) {
        OWN(test_tree, clear) t;
        double acc[2], force[2], book[2], angle[2];
        test_tree_init(&t, 2, (const int[]){-1, 0}, 0.3, &seed);
        for (int k = 0; k < 2; k++) angle[k] = t.phi[k] - DOWN;
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        double_pendulum(t.length, t.mass, 9.81, angle, t.rate, book);
        worst = fmax(worst, test_gap(2, acc, book));
    }
    CHECK_RESIDUAL(worst, 1e-13, "phi'' of double pendulums against the textbook's formula");
}

TEST(dynamics_keep_their_promises) {
    enum { N = 50 };
    unsigned long long seed = 5;
    double acc[N], force[N], alone[N], aliased[N];
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, N, 1, &seed);
    test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
    test_tree_dynamics(&t, TEST_LOADS(9.81), alone, NULL);
    CHECK_SAYING(!memcmp(acc, alone, sizeof acc),
                 "without forces the accelerations are other bits");

    // acc may be the same array as rate, the scratch may contain anything, nothing is allocated
    OWN_MEMORY void *work = aligned_alloc(64, pend_dynamics_work_bytes(N));
    REQUIRE(work);
    CHECK_INT(pend_dynamics_work_bytes(N) % 64, 0);
    memset(work, 0xff, pend_dynamics_work_bytes(N));
    memcpy(aliased, t.rate, sizeof aliased);
    long before = test_alloc_count();
    pend_dynamics(t.tree, TEST_LOADS(9.81), t.phi, aliased, work, aliased, alone);
    CHECK_INT(test_alloc_count(), before);
    CHECK_SAYING(!memcmp(acc, aliased, sizeof acc),
                 "with acc on top of rate the accelerations are other bits");
    CHECK_SAYING(!memcmp(force, alone, sizeof acc),
                 "with acc on top of rate the forces are other bits");
}

static int all_finite(int n, const double x[]) {
    for (int k = 0; k < n; k++)
        if (!isfinite(x[k])) return 0;
    return 1;
}

/* worst errors over trees */
struct worst {
    double acc, force;
};

static void worst_of(struct worst *worst, const struct test_tree *t) {
    double acc[64], force[64];
    test_quad exact_acc[64], exact_force[64];
    test_tree_dynamics(t, TEST_LOADS(9.81), acc, force);
    test_quad_dynamics(t->tree, TEST_LOADS(9.81), t->phi, t->rate, exact_acc, exact_force);
    double gap_acc = test_quad_gap(t->n, acc, exact_acc),
           gap_force = test_quad_gap(t->n, force, exact_force);
    if (!(gap_acc <= worst->acc)) worst->acc = gap_acc;
    if (!(gap_force <= worst->force)) worst->force = gap_force;
}

TEST(dynamics_bear_light_joints_between_heavy_arms_nearly_aligned) {
    unsigned long long seed = 6;
    struct worst worst = {0, 0};
    for (int digits = 0; digits <= 16; digits += 2)
        for (int i = 0; i < 300; i++) {
            OWN(test_tree, clear) t;
            int n = 2 + test_random_int(&seed, 7);
            test_tree_random(&t, i % 2 ? TEST_TREE_ATTACHED : TEST_TREE_LIMBS, n, 0, &seed);
            double line = 6 * test_random(&seed);
            for (int k = 0; k < n; k++) {
                t.mass[k] = test_random_int(&seed, 2) ? 1e8 : 1e-8;
                t.phi[k] = line + 2 * DOWN * test_random_int(&seed, 2) +
                           pow(10, -digits) * (test_random(&seed) - 0.5);
            }
            test_tree_rebuild(&t);
            worst_of(&worst, &t);
        }
    CHECK_RESIDUAL(worst.acc, 5e-11, "phi'' with masses of 1e-8 and 1e8, nearly aligned");
    CHECK_RESIDUAL(worst.force, 2e-12, "lambda with masses of 1e-8 and 1e8, nearly aligned");
}

TEST(dynamics_of_a_y_with_a_light_hub_are_finite_to_the_last_bit_of_alignment) {
    // two masses of 1e8 kg on a joint of 1e-8 kg, from half a turn apart down to one unit in the
    // last place, and aligned
    struct worst worst = {0, 0};
    unsigned long long seed = 7;
    for (double gap = 1; gap > 1e-17; gap /= 3)
        for (int fold = 0; fold < 4; fold++) {
            OWN(test_tree, clear) t;
            test_tree_init(&t, 3, (const int[]){-1, 0, 0}, 0, &seed);
            t.mass[0] = 1e-8, t.mass[1] = t.mass[2] = 1e8;
            test_tree_rebuild(&t);
            t.phi[0] = 0.3;
            t.phi[1] = t.phi[0] + (fold & 1) * 2 * DOWN + gap;
            t.phi[2] = t.phi[0] + (fold >> 1) * 2 * DOWN - gap;
            worst_of(&worst, &t);
        }
    CHECK_RESIDUAL(worst.acc, 1e-13, "phi'' of a Y with a hub of 1e-8 between 1e8");
    CHECK_RESIDUAL(worst.force, 1e-13, "lambda of a Y with a hub of 1e-8 between 1e8");
}

TEST(dynamics_bear_many_heavy_arms_in_two_directions_at_a_light_joint) {
    // heavy and light arms side by side, along two lines: only their motion across each line
    // matters
    struct worst worst = {0, 0};
    unsigned long long seed = 11;
    for (int digits = 0; digits <= 16; digits += 2)
        for (int i = 0; i < 300; i++) {
            OWN(test_tree, clear) t;
            int n = 4 + test_random_int(&seed, 4);
            double line[2] = {6 * test_random(&seed), 6 * test_random(&seed)};
            test_tree_random(&t, TEST_TREE_STAR, n, 0, &seed);
            for (int k = 0; k < n; k++) {
                int arm = t.tree->order[k];
                t.mass[arm] = k == 0 || test_random_int(&seed, 3) == 0
                                  ? 1e-8
                                  : 1e8 * (1 + test_random(&seed));
                t.phi[k] =
                    line[test_random_int(&seed, 2)] + pow(10, -digits) * (test_random(&seed) - 0.5);
            }
            test_tree_rebuild(&t);
            worst_of(&worst, &t);
        }
    CHECK_RESIDUAL(worst.acc, 1e-12, "phi'' of stars with arms of 1e-8 and 1e8 in two directions");
    CHECK_RESIDUAL(worst.force, 5e-8,
                   "lambda of stars with arms of 1e-8 and 1e8 in two directions");
}

TEST(dynamics_bear_the_smallest_masses_there_are) {
    // masses of a few units in the last place of the smallest double, against the same tree with a
    // few kilograms
    unsigned long long seed = 12;
    double acc[6], force[6], acc_tiny[6], force_tiny[6];
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, 6, 0, &seed);
    for (int k = 0; k < 6; k++) t.mass[k] = 1 + test_random_int(&seed, 9);
    test_tree_rebuild(&t);
    test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
    for (int k = 0; k < 6; k++) t.mass[k] = ldexp(t.mass[k], -1074);
    test_tree_rebuild(&t);
    test_tree_dynamics(&t, TEST_LOADS(9.81), acc_tiny, force_tiny);
    CHECK_RESIDUAL(test_gap(6, acc_tiny, acc), 1e-15, "phi'' with masses of a few times 5e-324");
}

TEST(dynamics_do_not_care_how_heavy_the_unit_of_mass_is) {
    static const double unit[] = {1e-300, 1e-160, 1e160, 1e290};
    unsigned long long seed = 8;
    double worst_acc = 0, worst_force = 0;
    for (int i = 0; i < 80; i++) {
        enum { N = 12 };
        double acc[N], force[N], acc_scaled[N], force_scaled[N];
        OWN(test_tree, clear) t;
        test_tree_random(&t, TEST_TREE_ATTACHED, N, 2, &seed);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        for (int k = 0; k < N; k++) t.mass[k] *= unit[i % 4];
        test_tree_rebuild(&t);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc_scaled, force_scaled);
        for (int k = 0; k < N; k++) force_scaled[k] /= unit[i % 4];
        worst_acc = fmax(worst_acc, test_gap(N, acc_scaled, acc));
        worst_force = fmax(worst_force, test_gap(N, force_scaled, force));
    }
    CHECK_RESIDUAL(worst_acc, 1e-13, "phi'' with masses near the ends of the doubles");
    CHECK_RESIDUAL(worst_force, 1e-13, "lambda with masses near the ends of the doubles");
}

TEST(dynamics_stay_finite_for_any_masses_and_angles) {
    unsigned long long seed = 9;
    int faulty = 0;
    for (int i = 0; i < 4000; i++) {
        double acc[32], force[32];
        OWN(test_tree, clear) t;
        int n = 1 + test_random_int(&seed, 32);
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, i % 2 ? 60 : 12, &seed);
        if (i % 3 == 0)
            for (int k = 0; k < n; k++) t.phi[k] = test_random_int(&seed, 4) * DOWN;
        if (i % 7 == 0)
            for (int k = 0; k < n; k++) t.phi[k] *= 1e15;
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        faulty += !all_finite(n, acc) || !all_finite(n, force);
    }
    CHECK_INT(faulty, 0);
}

TEST(dynamics_take_a_hundred_thousand_arms) {
    enum { N = 100000 };
    unsigned long long seed = 10;
    OWN_MEMORY double *acc = malloc(2 * N * sizeof *acc);
    REQUIRE(acc);
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)kind, N, 0.3, &seed);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, acc + N);
        CHECK_SAYING(all_finite(2 * N, acc), "%s of %d arms",
                     test_tree_kind_name((enum test_tree_kind)kind), N);
    }
}

/* eight states of a tree, and the results of each computed alone */
struct eight {
    int n;
    double *phi, *rate, *acc, *force; /* n by PEND_DYNAMICS_VEC */
    void *work;
};

static void eight_init(struct eight *e, int n) {
    size_t bytes = (size_t)n * PEND_DYNAMICS_VEC * sizeof(double);
    *e = (struct eight){.n = n,
                        .phi = aligned_alloc(64, 4 * bytes),
                        .work = aligned_alloc(64, pend_dynamics_vec_bytes(n))};
    if (!e->phi || !e->work) abort();
    memset(e->work, 0xff, pend_dynamics_vec_bytes(n));
    e->rate = e->phi + n * PEND_DYNAMICS_VEC;
    e->acc = e->rate + n * PEND_DYNAMICS_VEC;
    e->force = e->acc + n * PEND_DYNAMICS_VEC;
}

static void eight_clear(struct eight *e) {
    free(e->phi);
    free(e->work);
}

static void eight_fill(struct eight *e, int lane, const double phi[], const double rate[]) {
    for (int k = 0; k < e->n; k++) {
        e->phi[PEND_DYNAMICS_VEC * k + lane] = phi[k];
        e->rate[PEND_DYNAMICS_VEC * k + lane] = rate[k];
    }
}

TEST(dynamics_of_eight_states_are_those_of_each_to_the_bit) {
    unsigned long long seed = 13;
    enum { MOST = 100 };
    for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
        int other = 0;
        for (int i = 0; i < 210; i++) {
            OWN(test_tree, clear) t;
            OWN(eight, clear) e;
            double phi[8][MOST], rate[8][MOST], acc[MOST], force[MOST];
            int n = 1 + test_random_int(&seed, MOST);
            // with masses of 10^+-8 some of the eight states need the careful form
            test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, i % 2 ? 8 : 0.3,
                             &seed);
            eight_init(&e, n);
            for (int j = 0; j < 8; j++) {
                for (int k = 0; k < n; k++) {
                    phi[j][k] = t.phi[k] + (j % 3 ? test_random(&seed) : 0);
                    rate[j][k] = j % 2 ? t.rate[k] * test_random(&seed) : 0;
                }
                eight_fill(&e, j, phi[j], rate[j]);
            }
            OWN_MEMORY void *work = aligned_alloc(64, pend_dynamics_work_bytes(n));
            REQUIRE(work);
            long before = test_alloc_count();
            pend_dynamics_vec_for((enum pend_isa)isa, t.tree, TEST_LOADS(9.81), e.phi, e.rate,
                                  e.work, e.acc, e.force);
            CHECK_INT(test_alloc_count(), before);
            for (int j = 0; j < 8; j++) {
                pend_dynamics_for((enum pend_isa)isa, t.tree, TEST_LOADS(9.81), phi[j], rate[j],
                                  work, acc, force);
                for (int k = 0; k < n; k++)
                    other += acc[k] != e.acc[8 * k + j] || force[k] != e.force[8 * k + j];
            }
        }
        CHECK_INT(other, 0);
    }
}

TEST(dynamics_of_large_trees_have_the_bits_of_lanes) {
    const int n = 9001;
    unsigned long long seed = 17;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        OWN(test_tree, clear) t = {0};
        OWN(eight, clear) e = {0};
        int other = 0, moved = 0;
        double *acc = malloc(2 * (size_t)n * sizeof *acc), *force = acc + n;
        REQUIRE(acc);
        test_tree_random(&t, (enum test_tree_kind)kind, n, 0.3, &seed);
        eight_init(&e, n);
        for (int j = 0; j < 8; j++) eight_fill(&e, j, t.phi, t.rate);
        pend_dynamics_vec(t.tree, TEST_LOADS(9.81), e.phi, e.rate, e.work, e.acc, e.force);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        for (int k = 0; k < n; k++) {
            other += acc[k] != e.acc[8 * k + 3] || force[k] != e.force[8 * k + 3];
            moved += acc[k] != 0 && force[k] != 0;
        }
        CHECK_SAYING(other == 0, "%s of %d arms: %d differ",
                     test_tree_kind_name((enum test_tree_kind)kind), n, other);
        CHECK(moved > n / 2);
        free(acc);
    }
}

TEST(dynamics_of_many_states_are_those_of_each_to_the_bit) {
    enum { N = 9, MOST = 21 };
    unsigned long long seed = 16;
    static double phi[MOST][N], rate[MOST][N], acc[MOST][N], force[MOST][N];
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, N, 2, &seed);
    OWN_MEMORY void *work = aligned_alloc(64, (pend_dynamics_many_bytes(N) + 63) / 64 * 64);
    REQUIRE(work);
    for (int j = 0; j < MOST; j++)
        for (int k = 0; k < N; k++)
            phi[j][k] = 6 * test_random(&seed), rate[j][k] = test_random(&seed);
    for (int count = 0; count <= MOST; count++) {
        int other = 0;
        memset(acc, 0, sizeof acc);
        pend_dynamics_many(t.tree, TEST_LOADS(9.81), count, phi[0], rate[0], work, acc[0],
                           force[0]);
        for (int j = 0; j < count; j++) {
            double one_acc[N], one_force[N];
            pend_dynamics(t.tree, TEST_LOADS(9.81), phi[j], rate[j], work, one_acc, one_force);
            other += memcmp(acc[j], one_acc, sizeof one_acc) ||
                     memcmp(force[j], one_force, sizeof one_force);
        }
        CHECK_SAYING(!other, "%d of %d states differ", other, count);
        if (count < MOST) CHECK(acc[count][0] == 0);
    }
}

TEST(dynamics_of_a_lane_do_not_depend_on_its_place_or_neighbours) {
    enum { N = 30, BYTES = 8 * N * (int)sizeof(double) };
    unsigned long long seed = 14;
    OWN(test_tree, clear) t;
    OWN(eight, clear) e;
    test_tree_random(&t, TEST_TREE_LIMBS, N, 1, &seed);
    eight_init(&e, N);
    for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
        double acc[N], force[N];
        for (int place = 0; place < 8; place++) {
            // the neighbours are other states, and once not even finite numbers
            for (int k = 0; k < 8 * N; k++)
                e.phi[k] = place == 7 ? NAN : 6 * test_random(&seed), e.rate[k] = 1;
            eight_fill(&e, place, t.phi, t.rate);
            pend_dynamics_vec_for((enum pend_isa)isa, t.tree, TEST_LOADS(9.81), e.phi, e.rate,
                                  e.work, e.acc, e.force);
            int other = 0;
            for (int k = 0; k < N; k++) {
                if (!place) acc[k] = e.acc[8 * k], force[k] = e.force[8 * k];
                other |= acc[k] != e.acc[8 * k + place] || force[k] != e.force[8 * k + place];
            }
            CHECK_SAYING(!other, "lane %d gives other bits than lane 0", place);
        }
    }
}

TEST(dynamics_of_every_instruction_set_keep_the_digits) {
    unsigned long long seed = 15;
    enum { MOST = 150 };
    for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
        struct worst narrow = {0, 0}, wide = {0, 0};
        for (int i = 0; i < 140; i++) {
            OWN(test_tree, clear) t;
            double acc[MOST], force[MOST];
            test_quad exact_acc[MOST], exact_force[MOST];
            struct worst *worst = i % 2 ? &wide : &narrow;
            int n = 1 + test_random_int(&seed, i < 10 ? MOST : 20);
            test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, i % 2 ? 8 : 0.3,
                             &seed);
            OWN_MEMORY void *work = aligned_alloc(64, pend_dynamics_work_bytes(n));
            REQUIRE(work);
            pend_dynamics_for((enum pend_isa)isa, t.tree, TEST_LOADS(9.81), t.phi, t.rate, work,
                              acc, force);
            test_quad_dynamics(t.tree, TEST_LOADS(9.81), t.phi, t.rate, exact_acc, exact_force);
            worst->acc = fmax(worst->acc, test_quad_gap(n, acc, exact_acc));
            worst->force = fmax(worst->force, test_quad_gap(n, force, exact_force));
        }
        CHECK_RESIDUAL(narrow.acc, 2e-14, "phi'', masses of 10^+-0.3");
        CHECK_RESIDUAL(narrow.force, 2e-14, "lambda, masses of 10^+-0.3");
        CHECK_RESIDUAL(wide.acc, 5e-13, "phi'', masses of 10^+-8");
        CHECK_RESIDUAL(wide.force, 5e-13, "lambda, masses of 10^+-8");
    }
}

TEST(dynamics_of_long_chains_keep_the_digits) {
    unsigned long long seed = 17;
    enum { MOST = 150 };
    double worst_acc = 0, worst_force = 0;
    for (int i = 0; i < 12; i++) {
        OWN(test_tree, clear) t;
        double acc[MOST], force[MOST], other_acc[MOST], other_force[MOST];
        test_quad exact_acc[MOST], exact_force[MOST];
        int n = 128 + i;
        // random, near hanging, almost straight, and with very different masses
        test_tree_random(&t, TEST_TREE_CHAIN, n, i % 6 == 5 ? 4 : i % 2 ? 1 : 0.3, &seed);
        double spread = pow(10, -3 * (i % 3)), line = i % 2 ? DOWN : test_random(&seed);
        for (int k = 0; k < n && i % 4; k++) t.phi[k] = line + spread * (test_random(&seed) - 0.5);
        OWN_MEMORY void *work = aligned_alloc(64, pend_dynamics_work_bytes(n));
        REQUIRE(work);
        test_quad_dynamics(t.tree, TEST_LOADS(9.81), t.phi, t.rate, exact_acc, exact_force);
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            pend_dynamics_for((enum pend_isa)isa, t.tree, TEST_LOADS(9.81), t.phi, t.rate, work,
                              acc, force);
            worst_acc = fmax(worst_acc, test_quad_gap(n, acc, exact_acc));
            worst_force = fmax(worst_force, test_quad_gap(n, force, exact_force));
            if (isa == PEND_ISA_AVX512)
                CHECK_SAYING(!memcmp(acc, other_acc, sizeof acc[0] * (size_t)n) &&
                                 !memcmp(force, other_force, sizeof acc[0] * (size_t)n),
                             "avx2 and avx512 differ for a chain of %d", n);
            memcpy(other_acc, acc, sizeof acc);
            memcpy(other_force, force, sizeof force);
        }
    }
    CHECK_RESIDUAL(worst_acc, 1e-13, "phi'' of chains of 128 arms and more");
    CHECK_RESIDUAL(worst_force, 1e-13, "lambda of chains of 128 arms and more");
}

TEST(dynamics_have_the_same_bits_with_avx2_and_avx512) {
    if (pend_isa_best() < PEND_ISA_AVX512) {
        test_skip("this processor has no AVX-512");
        return;
    }
    unsigned long long seed = 18;
    enum { MOST = 300 };
    int other = 0;
    for (int i = 0; i < 400; i++) {
        OWN(test_tree, clear) t;
        double acc[2][MOST], force[2][MOST];
        int n = 1 + test_random_int(&seed, i % 4 ? 12 : MOST);
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, 0.5, &seed);
        OWN_MEMORY void *work = aligned_alloc(64, pend_dynamics_work_bytes(n));
        REQUIRE(work);
        for (int j = 0; j < 2; j++)
            pend_dynamics_for(j ? PEND_ISA_AVX512 : PEND_ISA_AVX2, t.tree, TEST_LOADS(9.81), t.phi,
                              t.rate, work, acc[j], force[j]);
        other += memcmp(acc[0], acc[1], sizeof(double) * (size_t)n) ||
                 memcmp(force[0], force[1], sizeof(double) * (size_t)n);
    }
    CHECK_INT(other, 0);
}

/* Tests of core/modes/response: against dense matrices, the equations of motion, and long runs.
 * Leaves to others: the equilibrium (test_rest), free modes (test_damped).
 * Invariant: all pendulums are random, from seeds. */
#include "core/modes/response.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/modes/damped.h"
#include "core/modes/modes.h"
#include "tests/harness/bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 7, LANES = PEND_RESPONSE_LANES };

/* everything except terms that move the pendulum in time */
enum { REAL = TEST_TERMS_ALL & ~TEST_TERMS_PIVOT };

/* the terms of test number i: every fourth pendulum has drag alone, every fourth is on a cart */
static unsigned real_terms(int i) {
    return i % 4 == 0 ? TEST_TERMS_DRAG_PER_MASS : i % 4 == 1 ? REAL | TEST_TERMS_CART : REAL;
}

/* the results for a few frequencies */
struct answer {
    double block[2 * PEND_RESPONSE_PARTS][LANES * ARMS];
    double *re[PEND_RESPONSE_PARTS], *im[PEND_RESPONSE_PARTS];
    unsigned char defined[LANES];
};

static void answer_init(struct answer *a) {
    for (int i = 0; i < PEND_RESPONSE_PARTS; i++) {
        a->re[i] = a->block[2 * i];
        a->im[i] = a->block[2 * i + 1];
    }
}

static double complex answer_at(const struct answer *a, int part, int at) {
    return a->re[part][at] + I * a->im[part][at];
}

static void hang(double phi[]) {
    for (int k = 0; k < ARMS; k++) phi[k] = -M_PI_2;
}

static struct pend_response *response_of(const struct test_tree *t, const struct pend_loads *l) {
    struct pend_response *r;
    struct pend_error error = {0};
    double phi[ARMS];
    hang(phi);
    CHECK_SAYING(pend_response_new(&r, t->tree, l, phi, &error) == PEND_OK, "%s", error.text);
    return r;
}

/* A x = b with pivoting, in long double complex numbers; both are overwritten */
static void dense_solve(int n, long double complex a[], long double complex b[]) {
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int j = i + 1; j < n; j++)
            if (cabsl(a[j * n + i]) > cabsl(a[best * n + i])) best = j;
        for (int j = 0; j < n && best != i; j++) {
            long double complex keep = a[i * n + j];
            a[i * n + j] = a[best * n + j];
            a[best * n + j] = keep;
        }
        long double complex keep = b[i];
        b[i] = b[best];
        b[best] = i == best ? b[best] : keep;
        for (int r = i + 1; r < n; r++) {
            long double complex ratio = a[r * n + i] / a[i * n + i];
            for (int j = i; j < n; j++) a[r * n + j] -= ratio * a[i * n + j];
            b[r] -= ratio * b[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) b[i] -= a[i * n + j] * b[j];
        b[i] /= a[i * n + i];
    }
}

/* the response to couples by M, C and K */
static void dense(const struct test_tree *t, const struct pend_loads *loads, const double rest[],
                  double omega, const double couple[], long double complex x[]) {
    double m[ARMS * ARMS], c[ARMS * ARMS], k[ARMS * ARMS];
    long double complex a[ARMS * ARMS];
    CHECK(pend_damped_matrices(t->tree, loads, rest, m, c, k) == PEND_OK);
    for (int i = 0; i < ARMS * ARMS; i++)
        a[i] = k[i] - (long double)omega * omega * m[i] + I * (long double)omega * c[i];
    for (int i = 0; i < ARMS; i++) x[i] = 0;
    for (int i = 0; i < ARMS; i++) {
        int holder = pend_terms_holder(loads->terms, t->tree->parent, i);
        x[i] += couple[i];
        if (holder >= 0) x[holder] -= couple[i];
    }
    dense_solve(ARMS, a, x);
}

TEST(response_is_what_dense_matrices_give) {
    unsigned long long seed = 1;
    double worst = 0;
    for (int i = 0; i < 40; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct answer a;
        double omega[LANES], couple[ARMS], none[ARMS] = {0};
        answer_init(&a);
        test_tree_random(&t, i % TEST_TREE_KINDS, ARMS, i % 3, &seed);
        test_bodies_random(&b, t.tree, real_terms(i), &seed);
        OWN(pend_response, free) *r = response_of(&t, &b.loads);
        if (!r) continue;
        for (int k = 0; k < ARMS; k++) couple[k] = 2 * test_random(&seed) - 1;
        for (int j = 0; j < LANES; j++) omega[j] = j ? pow(10, 3 * test_random(&seed) - 1) : 0;
        struct pend_response_drive drive = {.couple_re = couple, .couple_im = none};
        pend_response_at(r, LANES, omega, &drive, a.re, a.im, a.defined);
        for (int j = 0; j < LANES; j++) {
            long double complex x[ARMS];
            double most = 0, off = 0;
            dense(&t, &b.loads, pend_response_rest(r), omega[j], couple, x);
            CHECK(a.defined[j]);
            for (int k = 0; k < ARMS; k++) {
                most = fmax(most, (double)cabsl(x[k]));
                off = fmax(off, (double)cabsl(x[k] - answer_at(&a, 0, j * ARMS + k)));
            }
            worst = fmax(worst, off / most);
        }
    }
    CHECK_RESIDUAL(worst, 1e-12, "(K - w^2 M + i w C) x = f, relative");
}

/* the drive's harmonics in the list of terms, at the angle `psi` of their period, multiplied by
 * `size`; all others are 0 */
static void drive_terms(struct test_bodies *b, const struct pend_response_drive *drive, int arm,
                        double omega, double psi, double size) {
    int x = 0, y = 0, c = 0;
    for (int i = 0; i < b->terms->harmonics; i++) {
        const struct pend_harmonic *h = &b->terms->harmonic[i];
        double complex f = 0;
        if (h->drives == PEND_DRIVE_PIVOT_X && !x++)
            f = drive->pivot_re[0] + I * drive->pivot_im[0];
        if (h->drives == PEND_DRIVE_PIVOT_Y && !y++)
            f = drive->pivot_re[1] + I * drive->pivot_im[1];
        if (h->drives == arm && !c++) f = drive->couple_re[arm] + I * drive->couple_im[arm];
        b->value[h->at] = cabs(f) * size;
        b->value[h->at + 1] = omega;
        b->value[h->at + 2] = carg(f) + psi;
    }
    CHECK(c && (pend_terms_cart(b->terms) || (x && y)));
}

/* accelerations and forces of the full equations at a displacement */
static void full(const struct test_tree *t, const struct test_bodies *b, const double phi[],
                 const double rate[], double out[5][ARMS]) {
    struct bodies_state state = {phi, NULL, rate, 0, 0};
    struct bodies_forces forces = {out[1], out[2], out[3], out[4]};
    OWN_MEMORY void *work =
        aligned_alloc(64, (pend_bodies_bytes(t->tree, b->terms) + 63) / 64 * 64);
    if (!work) abort();
    pend_bodies_at(t->tree, &b->loads, &state, work, out[0], &forces);
}

TEST(response_obeys_the_equations_of_motion_with_a_shaken_pivot_and_a_couple) {
    static const int part[] = {PEND_RESPONSE_ANGLE, PEND_RESPONSE_JOINT_ALONG,
                               PEND_RESPONSE_JOINT_ACROSS, PEND_RESPONSE_TIP_ALONG,
                               PEND_RESPONSE_TIP_ACROSS};
    const double step = 1e-5;
    unsigned long long seed = 2;
    double worst[5] = {0};
    for (int i = 0; i < 20; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct answer a;
        double couple_re[ARMS] = {0}, couple_im[ARMS] = {0}, omega = 0.5 + 6 * test_random(&seed);
        answer_init(&a);
        test_tree_random(&t, TEST_TREE_LIMBS, ARMS, 0.3, &seed);
        int cart = i % 4 == 3;
        test_bodies_random(&b, t.tree, cart ? TEST_TERMS_CART_ALL : TEST_TERMS_ALL, &seed);
        int arm = b.terms->harmonic[b.terms->harmonics - 1].drives;
        couple_re[arm] = 1, couple_im[arm] = -0.5;
        struct pend_response_drive drive = {{0.3, -0.2}, {0.1, 0.4}, couple_re, couple_im};
        if (cart) drive = (struct pend_response_drive){{0}, {0}, couple_re, couple_im};
        OWN(pend_response, free) *r = response_of(&t, &b.loads);
        if (!r) continue;
        pend_response_at(r, 1, &omega, &drive, a.re, a.im, a.defined);
        for (int moment = 0; moment < 4; moment++) {
            double psi = moment * 1.3, side[2][5][ARMS];
            for (int s = 0; s < 2; s++) {
                double phi[ARMS], rate[ARMS], size = s ? -step : step;
                for (int k = 0; k < ARMS; k++) {
                    double complex x = size * answer_at(&a, 0, k) * cexp(I * psi);
                    phi[k] = pend_response_rest(r)[k] + creal(x);
                    rate[k] = creal(I * omega * x);
                }
                drive_terms(&b, &drive, arm, omega, psi, size);
                full(&t, &b, phi, rate, side[s]);
            }
            for (int q = 0; q < 5; q++) {
                for (int k = q ? cart : 0; k < ARMS; k++) {
                    double complex x = answer_at(&a, part[q], k) * cexp(I * psi);
                    double want = creal(q ? x : -omega * omega * x), size = q ? 100 : 10;
                    double got = (side[0][q][k] - side[1][q][k]) / (2 * step);
                    worst[q] = fmax(worst[q], fabs(got - want) / (size + fabs(want)));
                }
            }
        }
    }
    CHECK_RESIDUAL(worst[0], 1e-8, "phi'' of the response");
    for (int q = 1; q < 5; q++) CHECK_RESIDUAL(worst[q], 1e-8, "forces of the response");
}

TEST(response_is_where_long_runs_of_small_swings_end) {
    enum { COUNT = 40, N = 3 };
    const double omega = 2.5, size = 1e-6;
    unsigned long long seed = 5;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    struct answer a;
    OWN(test_record, clear) record = {0};
    double couple[ARMS] = {0}, worst = 0, most = 0;
    answer_init(&a);
    test_tree_random(&t, TEST_TREE_CHAIN, N, 0.2, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_ALL & ~TEST_TERMS_FRICTION & ~TEST_TERMS_TORQUES,
                       &seed);
    for (int i = 0; i < b.terms->harmonics; i++) b.value[b.terms->harmonic[i].at] = 0;
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (b.terms->one[i] >= 0) b.value[b.terms->one[i]] = i == PEND_TERM_DRAG_PER_MASS ? 0.4 : 0;
    for (int i = 0; i < b.terms->harmonics; i++) {
        double *h = b.value + b.terms->harmonic[i].at;
        h[1] = omega, h[2] = 0;
        h[0] = b.terms->harmonic[i].drives == PEND_DRIVE_PIVOT_X ? size : 0;
    }
    OWN(pend_response, free) *r = response_of(&t, &b.loads);
    REQUIRE(r);
    struct pend_response_drive drive = {{size, 0}, {0, 0}, couple, couple};
    pend_response_at(r, 1, &omega, &drive, a.re, a.im, a.defined);
    struct pend_problem problem = {.tree = t.tree,
                                   .loads = b.loads,
                                   .phi = pend_response_rest(r),
                                   .rate = couple,
                                   .rtol = 1e-13,
                                   .atol = 1e-16,
                                   .times = {.count = COUNT + 1, .span = 200, .divisor = COUNT}};
    test_record(&record, "taylor", &problem);
    CHECK_SAYING(record.status == PEND_OK, "%s", record.error.text);
    for (long i = COUNT / 2; i <= COUNT; i++) {
        double time = record.samples.t[i];
        for (int k = 0; k < N; k++) {
            double complex x = answer_at(&a, 0, k);
            double want = creal(x * cexp(I * omega * time));
            double got = record.samples.phi[i * N + t.tree->order[k]] - pend_response_rest(r)[k];
            worst = fmax(worst, fabs(got - want));
            most = fmax(most, cabs(x));
        }
    }
    CHECK_RESIDUAL(worst / most, 1e-6, "the end of a long run, in parts of its amplitude");
}

TEST(response_without_damping_is_not_defined_at_a_mode_and_is_beside_it) {
    unsigned long long seed = 3;
    for (int i = 0; i < 20; i++) {
        OWN(test_tree, clear) t;
        OWN(pend_modes, free) *modes = NULL;
        struct answer a;
        struct pend_error error = {0};
        double beside[LANES], couple[ARMS] = {1}, none[ARMS] = {0};
        answer_init(&a);
        test_tree_random(&t, i % TEST_TREE_KINDS, ARMS, 0.3, &seed);
        OWN(pend_response, free) *r = response_of(&t, TEST_LOADS(9.81));
        REQUIRE(r && pend_modes_new(&modes, t.tree, TEST_LOADS(9.81), 0, &error) == PEND_OK);
        struct pend_response_drive drive = {.couple_re = couple, .couple_im = none};
        // a star's modes among equal arms do not respond to the couple: the first and the last do
        double ends[] = {modes->omega[0], modes->omega[ARMS - 1]};
        pend_response_at(r, 2, ends, &drive, a.re, a.im, a.defined);
        CHECK_SAYING(!a.defined[0] && !a.defined[1], "tree %d is defined at a mode", i);
        CHECK(a.re[0][0] == 0 && a.im[0][ARMS] == 0);
        for (int j = 0; j < LANES; j++)
            beside[j] = ends[j % 2] * (1 + (j % 4 < 2 ? 1 : -1) * pow(10, -6 - j / 4 * 3));
        pend_response_at(r, LANES, beside, &drive, a.re, a.im, a.defined);
        for (int j = 0; j < LANES; j++) {
            CHECK(a.defined[j]);
            CHECK_SAYING(a.im[0][j * ARMS] == 0, "nothing damps, so nothing lags");
        }
    }
}

/* an arm that hangs on another one stops it at its own frequency: the pivot of the elimination is
 * 0, but the result is finite */
TEST(response_is_right_where_a_part_of_the_tree_is_in_resonance_by_itself) {
    const double length[] = {1, 0.25, 0.25}, mass[] = {1, 0.5, 0.5}, g = 4;
    const int parent[] = {-1, 0, 0};
    const double omega[] = {4, 4 * (1 + 1e-15), 4 * (1 + 1e-8), 4 * (1 - 1e-12)};
    double couple[ARMS] = {1}, none[ARMS] = {0}, phi[ARMS], worst = 0;
    struct test_tree t = {.n = 3};
    struct answer a;
    struct pend_response *r;
    struct pend_error error = {0};
    answer_init(&a);
    hang(phi);
    // the two small arms are equal: together they have the mode of opposite swings at this
    // frequency, which the couple does not drive; one of them alone has no such mode
    for (int n = 2; n <= 3; n++) {
        REQUIRE(pend_tree_new(&t.tree, n, length, mass, parent, NULL) == PEND_OK);
        REQUIRE(pend_response_new(&r, t.tree, TEST_LOADS(g), phi, &error) == PEND_OK);
        struct pend_response_drive drive = {.couple_re = couple, .couple_im = none};
        pend_response_at(r, 4, omega, &drive, a.re, a.im, a.defined);
        for (int j = 0; j < 4 && n == 2; j++) {
            CHECK(a.defined[j]);
            // couple + m l2 w^2 l1 x2 = K x1 - w^2 M x1, and x1 = (g - w^2 l2) x2 / w^2 l1
            long double w = omega[j], w2 = w * w, l = length[1];
            long double x2 = 1 / ((1.5L * g - w2 * 1.5L) * (g - w2 * l) / w2 - 0.5L * l * w2);
            worst = fmax(worst, fabs((double)(a.re[0][j * n + 1] / x2 - 1)));
            CHECK(fabs((double)(a.re[0][j * n] - (g - w2 * l) / w2 * x2)) < 1e-15);
        }
        pend_response_free(&r);
        pend_tree_free(&t.tree);
    }
    CHECK_RESIDUAL(worst, 1e-13, "an absorber at its frequency");
}

TEST(response_of_a_frequency_has_the_same_bits_in_any_company) {
    unsigned long long seed = 4;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    struct answer together, alone;
    double omega[LANES], couple[ARMS] = {0, 1}, none[ARMS] = {0};
    answer_init(&together);
    answer_init(&alone);
    test_tree_random(&t, TEST_TREE_ATTACHED, ARMS, 2, &seed);
    test_bodies_random(&b, t.tree, REAL, &seed);
    OWN(pend_response, free) *r = response_of(&t, &b.loads);
    REQUIRE(r);
    CHECK(pend_response_bytes(ARMS) > 1000);
    for (int j = 0; j < LANES; j++) omega[j] = pow(10, 4 * test_random(&seed) - 2);
    struct pend_response_drive drive = {{1, 2}, {3, 4}, couple, none};
    pend_response_at(r, LANES, omega, &drive, together.re, together.im, together.defined);
    for (int j = 0; j < LANES; j++) {
        pend_response_at(r, 1, omega + j, &drive, alone.re, alone.im, alone.defined);
        for (int i = 0; i < PEND_RESPONSE_PARTS; i++)
            CHECK(!memcmp(alone.re[i], together.re[i] + j * ARMS, ARMS * sizeof(double)) &&
                  !memcmp(alone.im[i], together.im[i] + j * ARMS, ARMS * sizeof(double)));
    }
}

TEST(response_survives_any_allocation_that_fails) {
    unsigned long long seed = 6;
    OWN(test_tree, clear) t;
    double phi[ARMS];
    hang(phi);
    test_tree_random(&t, TEST_TREE_CHAIN, ARMS, 0.3, &seed);
    int failed = 0;
    for (long i = 1;; i++) {
        struct pend_response *r;
        struct pend_error error = {0};
        test_alloc_fail(i, 0);
        enum pend_status status = pend_response_new(&r, t.tree, TEST_LOADS(9.81), phi, &error);
        test_alloc_faults_off();
        if (status == PEND_OK) {
            CHECK(pend_response_stable(r));
            pend_response_free(&r);
            break;
        }
        failed++;
        CHECK(status == PEND_NO_MEMORY && !r && error.text[0]);
    }
    CHECK_INT(failed, 7);
}

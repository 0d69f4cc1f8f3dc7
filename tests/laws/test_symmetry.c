/* Laws: the effect of a change of names, units, direction or sense of time on accelerations and
 * forces, and the lack of effect of a massless arm. Leaves to others: the values themselves
 * (test_matrix_form). Invariant: each law is tested on trees of every kind, and on a variant that
 * breaks it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/tree/tree.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { N = 60, TREES = 10 * TEST_TREE_KINDS };

static const double GRAVITY = 9.81;

/* accelerations and forces of one state, in the caller's order */
struct answer {
    double acc[N], force[N];
};

static struct answer answer_of(const struct test_tree *t, double gravity) {
    struct answer stored, answer = {{0}, {0}};
    test_tree_dynamics(t, TEST_LOADS(gravity), stored.acc, stored.force);
    for (int i = 0; i < t->n; i++) {
        answer.acc[i] = stored.acc[t->tree->place[i]];
        answer.force[i] = stored.force[t->tree->place[i]];
    }
    return answer;
}

/* scales the expected values */
static void answer_scale(struct answer *answer, double acc, double force) {
    for (int i = 0; i < N; i++) answer->acc[i] *= acc, answer->force[i] *= force;
}

static double answer_gap(int n, const struct answer *got, const struct answer *want) {
    return fmax(test_gap(n, got->acc, want->acc), test_gap(n, got->force, want->force));
}

static void tree_number(struct test_tree *t, int i, double spread, unsigned long long *seed) {
    test_tree_random(t, (enum test_tree_kind)(i % TEST_TREE_KINDS),
                     2 + test_random_int(seed, N - 1), spread, seed);
}

TEST(law_names_of_arms_do_not_matter) {
    unsigned long long seed = 1;
    double worst = 0, spoilt = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t, other;
        int name[N], parent[N];
        tree_number(&t, i, 0.3, &seed);
        // name: a random permutation, arm j becomes arm name[j]
        for (int j = 0; j < t.n; j++) {
            int k = test_random_int(&seed, j + 1);
            name[j] = name[k], name[k] = j;
        }
        for (int j = 0; j < t.n; j++) parent[name[j]] = t.parent[j] < 0 ? -1 : name[t.parent[j]];
        test_tree_init(&other, t.n, parent, 0, &seed);
        for (int j = 0; j < t.n; j++)
            other.length[name[j]] = t.length[j], other.mass[name[j]] = t.mass[j];
        test_tree_rebuild(&other);
        for (int j = 0; j < t.n; j++) {
            other.phi[other.tree->place[name[j]]] = t.phi[t.tree->place[j]];
            other.rate[other.tree->place[name[j]]] = t.rate[t.tree->place[j]];
        }
        struct answer want = answer_of(&t, GRAVITY), got = answer_of(&other, GRAVITY),
                      renamed = {{0}, {0}};
        for (int j = 0; j < t.n; j++) {
            renamed.acc[j] = got.acc[name[j]];
            renamed.force[j] = got.force[name[j]];
        }
        worst = fmax(worst, answer_gap(t.n, &renamed, &want));
        spoilt = fmax(spoilt, answer_gap(t.n, &got, &want));
    }
    CHECK_RESIDUAL(worst, 1e-13, "renaming the arms renames the answers");
    CHECK_SAYING(spoilt > 0.1, "answers under the wrong names go unseen");
}

TEST(law_units_of_length_mass_and_time_do_not_matter) {
    unsigned long long seed = 2;
    double worst[4] = {0}, spoilt = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t;
        double length = 3.7, mass = 0.013, time = 7.1;
        tree_number(&t, i, 1, &seed);
        struct answer base = answer_of(&t, GRAVITY), want = base, got;

        // lengths and gravity together: the same angles
        for (int j = 0; j < t.n; j++) t.length[j] *= length;
        test_tree_rebuild(&t);
        got = answer_of(&t, GRAVITY * length);
        answer_scale(&want, 1, length);
        worst[0] = fmax(worst[0], answer_gap(t.n, &got, &want));
        got = answer_of(&t, GRAVITY);
        spoilt = fmax(spoilt, answer_gap(t.n, &got, &want));
        for (int j = 0; j < t.n; j++) t.length[j] /= length;

        // masses: forces are proportional
        for (int j = 0; j < t.n; j++) t.mass[j] *= mass;
        test_tree_rebuild(&t);
        got = answer_of(&t, GRAVITY), want = base;
        answer_scale(&want, 1, mass);
        worst[1] = fmax(worst[1], answer_gap(t.n, &got, &want));
        for (int j = 0; j < t.n; j++) t.mass[j] /= mass;
        test_tree_rebuild(&t);

        // time: rates, then gravity, accelerations and forces with the square
        for (int k = 0; k < t.n; k++) t.rate[k] *= time;
        got = answer_of(&t, GRAVITY * time * time), want = base;
        answer_scale(&want, time * time, time * time);
        worst[2] = fmax(worst[2], answer_gap(t.n, &got, &want));

        // backwards: the same accelerations and forces, to the last bit
        for (int k = 0; k < t.n; k++) t.rate[k] /= -time;
        struct answer back = answer_of(&t, GRAVITY);
        for (int k = 0; k < t.n; k++) t.rate[k] = -t.rate[k];
        got = answer_of(&t, GRAVITY);
        worst[3] = fmax(worst[3], answer_gap(t.n, &back, &got));
    }
    CHECK_RESIDUAL(worst[0], 1e-13, "unit of length");
    CHECK_RESIDUAL(worst[1], 1e-13, "unit of mass");
    CHECK_RESIDUAL(worst[2], 1e-13, "unit of time");
    CHECK(worst[3] == 0);
    CHECK_SAYING(spoilt > 1e-3, "gravity in the old unit goes unseen");
}

TEST(law_without_gravity_no_direction_is_special) {
    unsigned long long seed = 3;
    double worst = 0, spoilt = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t;
        tree_number(&t, i, 0.3, &seed);
        struct answer want = answer_of(&t, 0), heavy = answer_of(&t, GRAVITY);
        double turn = 6 * test_random(&seed);
        for (int k = 0; k < t.n; k++) t.phi[k] += turn;
        struct answer got = answer_of(&t, 0), heavy_got = answer_of(&t, GRAVITY);
        worst = fmax(worst, answer_gap(t.n, &got, &want));
        spoilt = fmax(spoilt, answer_gap(t.n, &heavy_got, &heavy));
    }
    CHECK_RESIDUAL(worst, 1e-13, "turning a tree without gravity");
    CHECK_SAYING(spoilt > 0.1, "turning a tree with gravity goes unseen");
}

TEST(law_a_mirror_image_moves_as_the_mirror_image) {
    unsigned long long seed = 4;
    double worst = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t;
        tree_number(&t, i, 0.3, &seed);
        struct answer want = answer_of(&t, GRAVITY);
        answer_scale(&want, -1, 1);
        for (int k = 0; k < t.n; k++)
            t.phi[k] = 3.141592653589793 - t.phi[k], t.rate[k] = -t.rate[k];
        struct answer got = answer_of(&t, GRAVITY);
        worst = fmax(worst, answer_gap(t.n, &got, &want));
    }
    CHECK_RESIDUAL(worst, 1e-13, "phi -> pi - phi");
}

/* t with one more arm of the given mass, on arm `host` */
static void tree_join(struct test_tree *more, const struct test_tree *t, int host, double mass,
                      unsigned long long *seed) {
    int parent[N];
    memcpy(parent, t->parent, (size_t)t->n * sizeof *parent);
    parent[t->n] = host;
    test_tree_init(more, t->n + 1, parent, 0.3, seed);
    memcpy(more->length, t->length, (size_t)t->n * sizeof *t->length);
    memcpy(more->mass, t->mass, (size_t)t->n * sizeof *t->mass);
    more->mass[t->n] = mass;
    test_tree_rebuild(more);
    for (int j = 0; j < t->n; j++) {
        more->phi[more->tree->place[j]] = t->phi[t->tree->place[j]];
        more->rate[more->tree->place[j]] = t->rate[t->tree->place[j]];
    }
}

TEST(law_an_arm_that_weighs_nothing_changes_nothing) {
    unsigned long long seed = 5;
    double worst = 0, worst_guest = 0, spoilt = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t, more;
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS),
                         1 + test_random_int(&seed, N - 1), 0.3, &seed);
        struct answer want = answer_of(&t, GRAVITY);
        int host = test_random_int(&seed, t.n);
        tree_join(&more, &t, host, 1e-300, &seed);
        struct answer got = answer_of(&more, GRAVITY);
        worst = fmax(worst, answer_gap(t.n, &got, &want));
        worst_guest = fmax(worst_guest, fabs(got.force[t.n]));
        test_tree_clear(&more);
        tree_join(&more, &t, host, 1e-3, &seed);
        got = answer_of(&more, GRAVITY);
        spoilt = fmax(spoilt, answer_gap(t.n, &got, &want));
    }
    CHECK_RESIDUAL(worst, 1e-13, "joining an arm of 1e-300 kg");
    CHECK(worst_guest > 0 && worst_guest < 1e-295);
    CHECK_SAYING(spoilt > 1e-5, "joining an arm of 1e-3 kg goes unseen");
}

TEST(law_gravity_is_the_acceleration_of_the_pivot) {
    // results are affine in gravity: g enters as one known acceleration and nowhere else
    unsigned long long seed = 6;
    double worst = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t;
        tree_number(&t, i, 0.3, &seed);
        struct answer none = answer_of(&t, 0), one = answer_of(&t, 5), two = answer_of(&t, 10);
        for (int j = 0; j < t.n; j++) {
            one.acc[j] = 2 * one.acc[j] - none.acc[j];
            one.force[j] = 2 * one.force[j] - none.force[j];
        }
        worst = fmax(worst, answer_gap(t.n, &one, &two));
    }
    CHECK_RESIDUAL(worst, 1e-13, "answers are affine in gravity");
}

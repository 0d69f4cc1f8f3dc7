/* Tests of core/tree/presets: every preset builds, moves, and is what it says.
 * Leaves to others: integrating them (laws, wire).
 * Invariant: the presets that the contract names are there. */
#include "core/tree/presets.h"

#include <math.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

TEST(presets_of_the_contract_are_there) {
    static const char *const wanted[] = {"paper-four-arms",     "single",   "double", "triple",
                                         "non-standard-triple", "chain-10", "star",   "binary-4"};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++)
        CHECK_SAYING(pend_preset_find(wanted[i]) >= 0, "no preset is called %s", wanted[i]);
    CHECK(pend_preset_count() >= (int)(sizeof wanted / sizeof *wanted) + 3);
    CHECK_INT(pend_preset_find("nothing-like-it"), -1);
    CHECK_INT(pend_preset_find(""), -1);
}

/* lower-case words joined by hyphens, fit for a URL */
static int is_slug(const char *name) {
    return *name && strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789-") == strlen(name);
}

TEST(presets_build_without_a_fault_and_move) {
    for (int i = 0; i < pend_preset_count(); i++) {
        struct pend_preset p;
        struct test_tree t = {0};
        double acc[PEND_PRESET_ARMS], force[PEND_PRESET_ARMS], phi[PEND_PRESET_ARMS],
            rate[PEND_PRESET_ARMS];
        pend_preset_get(i, &p);
        CHECK_INT(pend_preset_find(p.name), i);
        CHECK_SAYING(is_slug(p.name), "%s is not fit for a URL", p.name);
        CHECK_SAYING(strlen(p.title) > 3 && strlen(p.description) > 40, "%s says too little",
                     p.name);
        t = (struct test_tree){.n = p.n, .length = p.length, .mass = p.mass, .parent = p.parent};
        REQUIRE(pend_tree_new(&t.tree, p.n, p.length, p.mass, p.parent, NULL) == PEND_OK);
        double liveliest = 0;
        for (int k = 0; k < p.n; k++) {
            CHECK_SAYING(p.parent[k] < k, "%s: arm %d comes before its parent", p.name, k);
            phi[k] = p.phi[t.tree->order[k]], rate[k] = p.rate[t.tree->order[k]];
            CHECK(isfinite(phi[k]) && isfinite(rate[k]));
        }
        t.phi = phi, t.rate = rate;
        test_tree_dynamics(&t, &p.loads, acc, force);
        for (int k = 0; k < p.n; k++) liveliest = fmax(liveliest, fabs(acc[k]) + fabs(rate[k]));
        CHECK_SAYING(liveliest > 0.1, "%s stays where it is", p.name);
        double samples = p.stop / p.step;
        CHECK_SAYING(samples >= 100 && samples <= 5000 && fabs(samples - round(samples)) < 1e-9,
                     "%s has %g samples", p.name, samples);
        pend_tree_free(&t.tree);
    }
}

static void preset_by_name(const char *name, struct pend_preset *p) {
    pend_preset_get(pend_preset_find(name), p);
}

TEST(preset_of_the_paper_is_the_papers_example) {
    struct pend_preset p;
    preset_by_name("paper-four-arms", &p);
    static const double length[] = {2, 1.5, 0.75, 1.25}, mass[] = {1, 1, 1, 0.1};
    static const int parent[] = {-1, 0, 1, 1};
    REQUIRE(p.n == 4);
    CHECK(!memcmp(p.length, length, sizeof length) && !memcmp(p.mass, mass, sizeof mass));
    CHECK(!memcmp(p.parent, parent, sizeof parent));
    for (int k = 0; k < 4; k++) CHECK(p.phi[k] == 0 && p.rate[k] == 0);
    CHECK(p.loads.gravity == 9.81 && p.stop == 5 && p.step == 0.01);
}

TEST(presets_have_the_shapes_of_their_names) {
    struct pend_preset p;
    preset_by_name("chain-10", &p);
    CHECK_INT(p.n, 10);
    for (int k = 0; k < p.n; k++) CHECK_INT(p.parent[k], k - 1);
    preset_by_name("star", &p);
    for (int k = 1; k < p.n; k++) CHECK_INT(p.parent[k], 0);
    preset_by_name("binary-4", &p);
    CHECK_INT(p.n, 15);
    for (int k = 1; k < p.n; k++) CHECK_INT(p.parent[k], (k - 1) / 2);
    preset_by_name("non-standard-triple", &p);
    CHECK(p.n == 3 && p.parent[1] == 0 && p.parent[2] == 0);
}

TEST(preset_two_to_one_has_frequencies_in_that_ratio) {
    struct pend_preset p;
    struct pend_tree *tree;
    double a[4];
    preset_by_name("two-to-one", &p);
    REQUIRE(pend_tree_new(&tree, p.n, p.length, p.mass, p.parent, NULL) == PEND_OK);
    test_quad_linearization(tree, p.loads.gravity, a, NULL);
    double trace = a[0] + a[3], det = a[0] * a[3] - a[1] * a[2],
           root = sqrt(trace * trace - 4 * det);
    CHECK_RESIDUAL(fabs(sqrt((trace + root) / (trace - root)) - 2), 1e-15, "frequencies as 2 to 1");
    pend_tree_free(&tree);
}

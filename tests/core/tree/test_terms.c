#include "core/tree/terms.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/tree/loads.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 3 };

static const double length[ARMS] = {1, 2, 3}, mass[ARMS] = {1, 1, 1}, bare_mass[ARMS] = {1, 0, 1};
static const int parent[ARMS] = {-1, 0, 1};

/* a chain with every term, and a list in which they have no effect */
static struct pend_terms *all_terms(struct pend_tree **tree, const double masses[],
                                    double **value) {
    unsigned char rows[PEND_TERM_ROWS], ones[PEND_TERM_ONES];
    static const unsigned char bare[ARMS] = {1, 1, 1};
    static const int drives[] = {2, PEND_DRIVE_PIVOT_X, 0, PEND_DRIVE_PIVOT_Y, 0};
    struct pend_terms *terms = NULL;
    int place[5];
    memset(rows, 1, sizeof rows);
    memset(ones, 1, sizeof ones);
    *value = NULL;
    if (!CHECK(pend_tree_new_bare(tree, ARMS, length, masses, bare, parent, NULL) == PEND_OK) ||
        !CHECK(pend_terms_new(&terms, ARMS, rows, ones, 5, drives, place) == PEND_OK))
        return NULL;
    *value = malloc((size_t)terms->count * sizeof **value);
    pend_terms_clear(terms, *tree, *value);
    return terms;
}

static void forget(struct pend_terms *terms, struct pend_tree *tree, double *value) {
    pend_terms_free(&terms);
    pend_tree_free(&tree);
    free(value);
}

TEST(terms_have_every_number_in_one_place) {
    struct pend_tree *tree;
    double *value;
    struct pend_terms *terms = all_terms(&tree, mass, &value);
    REQUIRE(terms && value);
    unsigned char *seen = calloc((size_t)terms->count, 1);
    CHECK(pend_terms_valid(terms));
    CHECK_INT(terms->count, ARMS * PEND_TERM_ROWS + PEND_TERM_ONES + 3 * 5);
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        for (int k = 0; k < ARMS; k++) {
            int place = pend_terms_place(terms, (enum pend_term_row)r, k);
            if (CHECK(place >= 0)) seen[place]++;
        }
    for (int i = 0; i < PEND_TERM_ONES; i++) seen[terms->one[i]]++;
    for (int h = 0; h < terms->harmonics; h++)
        for (int part = 0; part < 3; part++) seen[terms->harmonic[h].at + part]++;
    for (int i = 0; i < terms->count; i++) CHECK_INT(seen[i], 1);
    free(seen);
    forget(terms, tree, value);
}

TEST(terms_that_belong_together_are_laid_out_together) {
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
        struct pend_terms *terms;
        rows[r] = 1;
        REQUIRE(pend_terms_new(&terms, ARMS, rows, ones, 0, NULL, NULL) == PEND_OK);
        CHECK(terms->row[r] >= 0);
        CHECK((terms->row[PEND_TERM_BODY] < 0) == (terms->row[PEND_TERM_INERTIA] < 0));
        CHECK((terms->row[PEND_TERM_BODY] < 0) == (terms->row[PEND_TERM_CENTER_Y] < 0));
        CHECK((terms->row[PEND_TERM_STIFFNESS] < 0) == (terms->row[PEND_TERM_REST] < 0));
        CHECK((terms->row[PEND_TERM_FRICTION] < 0) == (terms->row[PEND_TERM_FRICTION_SPEED] < 0));
        CHECK((terms->row[PEND_TERM_DRAG_QUADRATIC] < 0) == (terms->row[PEND_TERM_DRAG_SPEED] < 0));
        CHECK_INT(pend_terms_place(terms, (enum pend_term_row)((r + 5) % PEND_TERM_ROWS), 0) < 0 ||
                      terms->count >= ARMS,
                  1);
        pend_terms_free(&terms);
        CHECK(!terms);
    }
}

TEST(harmonics_are_grouped_by_what_they_drive_and_keep_their_order) {
    enum { HARMONICS = 200 };
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int drives[HARMONICS], place[HARMONICS];
    unsigned long long seed = 5;
    OWN(pend_terms, free) *terms;
    for (int i = 0; i < HARMONICS; i++) drives[i] = test_random_int(&seed, ARMS + 2) - 2;
    REQUIRE(pend_terms_new(&terms, ARMS, rows, ones, HARMONICS, drives, place) == PEND_OK);
    CHECK(terms->harmonic[0].drives == PEND_DRIVE_PIVOT_Y);
    for (int h = 0; h < HARMONICS; h++) {
        const struct pend_harmonic *harmonic = &terms->harmonic[h];
        CHECK_INT(harmonic->drives, drives[place[h]]);
        CHECK_INT(harmonic->at, 3 * h);
        if (!h) continue;
        CHECK(harmonic[-1].drives < harmonic->drives ||
              (harmonic[-1].drives == harmonic->drives && place[h - 1] < place[h]));
    }
}

TEST(a_cleared_list_does_nothing) {
    struct pend_tree *tree;
    double *value;
    struct pend_terms *terms = all_terms(&tree, mass, &value);
    REQUIRE(terms && value);
    CHECK_INT(pend_terms_check(terms, tree, value, NULL, NULL), 0);
    CHECK(pend_terms_conserve(terms, value));
    for (int k = 0; k < ARMS; k++) {
        CHECK(pend_terms_get(terms, value, PEND_TERM_FRICTION_SPEED, k) == 1);
        CHECK(pend_terms_get(terms, value, PEND_TERM_AT_X, k) ==
              (tree->parent[k] < 0 ? 0 : tree->len[tree->parent[k]]));
    }
    forget(terms, tree, value);
}

struct seen {
    int count, row, one, arm, part;
    const char *text;
};

static void see(void *context, const struct pend_terms_fault *fault) {
    struct seen *seen = context;
    *seen = (struct seen){seen->count + 1, fault->row,  fault->one,
                          fault->arm,      fault->part, fault->text};
}

TEST(each_number_out_of_its_range_is_a_fault_of_its_own) {
    struct pend_tree *tree;
    double *value;
    struct pend_terms *terms = all_terms(&tree, mass, &value);
    REQUIRE(terms && value);
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        double *number = &value[pend_terms_place(terms, (enum pend_term_row)r, 1)], kept = *number;
        struct seen seen = {0};
        *number = NAN;
        CHECK_INT(pend_terms_check(terms, tree, value, see, &seen), 1);
        CHECK(seen.count == 1 && seen.row == r && seen.arm == 1 && seen.one == -1);
        CHECK_TEXT(seen.text, "must be a finite number");
        *number = -1;
        int signed_one = r == PEND_TERM_CENTER_X || r == PEND_TERM_CENTER_Y ||
                         r == PEND_TERM_AT_X || r == PEND_TERM_AT_Y || r == PEND_TERM_REST ||
                         r == PEND_TERM_TORQUE || r >= PEND_TERM_INPUT;
        CHECK_INT(pend_terms_check(terms, tree, value, see, &seen), !signed_one);
        *number = 0;
        int speed = r == PEND_TERM_FRICTION_SPEED || r == PEND_TERM_DRAG_SPEED;
        CHECK_INT(pend_terms_check(terms, tree, value, see, &seen), speed);
        *number = kept;
    }
    struct seen seen = {0};
    value[terms->harmonic[2].at + 1] = INFINITY;
    value[terms->one[PEND_TERM_DRAG_PER_MASS]] = -1;
    CHECK_INT(pend_terms_check(terms, tree, value, see, &seen), 2);
    CHECK(seen.row == -1 && seen.one == -1 && seen.arm == 2 && seen.part == 1);
    forget(terms, tree, value);
}

/* the middle arm has no mass at its tip */
TEST(an_arm_needs_an_inertia_about_its_joint) {
    static const struct {
        double rod, body, x, y, inertia;
        int good;
    } tries[] = {{0, 0, 0, 0, 0, 0}, {1, 0, 0, 0, 0, 1}, {0, 1, 0, 0, 0, 0}, {0, 1, 1, 0, 0, 1},
                 {0, 1, 0, 1, 0, 1}, {0, 1, 0, 0, 1, 1}, {0, 0, 1, 1, 1, 0}};
    struct pend_tree *tree;
    double *value;
    struct pend_terms *terms = all_terms(&tree, bare_mass, &value);
    REQUIRE(terms && value);
    for (size_t i = 0; i < sizeof tries / sizeof *tries; i++) {
        struct seen seen = {0};
        value[pend_terms_place(terms, PEND_TERM_ROD, 1)] = tries[i].rod;
        value[pend_terms_place(terms, PEND_TERM_BODY, 1)] = tries[i].body;
        value[pend_terms_place(terms, PEND_TERM_CENTER_X, 1)] = tries[i].x;
        value[pend_terms_place(terms, PEND_TERM_CENTER_Y, 1)] = tries[i].y;
        value[pend_terms_place(terms, PEND_TERM_INERTIA, 1)] = tries[i].inertia;
        CHECK_INT(pend_terms_check(terms, tree, value, see, &seen), !tries[i].good);
        if (!tries[i].good) CHECK(seen.arm == 1 && strstr(seen.text, "has no inertia"));
    }
    forget(terms, tree, value);
}

TEST(only_what_does_not_give_or_take_energy_keeps_it) {
    struct pend_tree *tree;
    double *value;
    struct pend_terms *terms = all_terms(&tree, mass, &value);
    REQUIRE(terms && value);
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        double *number = &value[pend_terms_place(terms, (enum pend_term_row)r, 1)], kept = *number;
        int takes = r == PEND_TERM_TORQUE || r == PEND_TERM_DAMPING || r == PEND_TERM_FRICTION ||
                    r == PEND_TERM_DRAG || r == PEND_TERM_DRAG_QUADRATIC || r >= PEND_TERM_INPUT;
        *number += 0.5;
        CHECK_INT(pend_terms_conserve(terms, value), !takes);
        *number = kept;
    }
    for (int i = 0; i < PEND_TERM_ONES; i++) {
        value[terms->one[i]] = 0.5;
        CHECK_INT(pend_terms_conserve(terms, value), i == PEND_TERM_RAIL || i == PEND_TERM_PIECE);
        value[terms->one[i]] = 0;
    }
    value[terms->harmonic[1].at + 1] = 3; // an omega without an amplitude
    CHECK(pend_terms_conserve(terms, value));
    value[terms->harmonic[1].at] = 3;
    CHECK(!pend_terms_conserve(terms, value));
    forget(terms, tree, value);
}

TEST(terms_without_memory_say_so) {
    unsigned char rows[PEND_TERM_ROWS] = {1}, ones[PEND_TERM_ONES] = {0};
    struct pend_terms *terms;
    test_alloc_fail(1, 1);
    CHECK(pend_terms_new(&terms, ARMS, rows, ones, 0, NULL, NULL) == PEND_NO_MEMORY);
    test_alloc_faults_off();
    CHECK(!terms);
}

/* closed forms: a bar on a spring oscillates at sqrt(3 k / (m l^2)); a damped one slows at c / J; a
 * spring between two arms acts on both inertias */
TEST(the_pace_of_terms_is_that_of_springs_friction_and_drives) {
    const double lengths[] = {2, 1}, masses[] = {1, 0.5};
    const int above[] = {-1, 0}, drives[] = {1, PEND_DRIVE_PIVOT_Y};
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    OWN(pend_tree, free) *tree;
    OWN(pend_terms, free) *terms = NULL;
    double value[40] = {0};
    int place[2];
    rows[PEND_TERM_ROD] = rows[PEND_TERM_STIFFNESS] = rows[PEND_TERM_DAMPING] = 1;
    ones[PEND_TERM_DRAG_PER_MASS] = 1;
    REQUIRE(pend_tree_new(&tree, 2, lengths, masses, above, NULL) == PEND_OK);
    REQUIRE(pend_terms_new(&terms, 2, rows, ones, 2, drives, place) == PEND_OK);
    REQUIRE(terms->count <= 40);
    pend_terms_clear(terms, tree, value);
    const struct pend_loads loads = {9.81, terms, value};
    CHECK(pend_loads_rate(&loads, tree) == 0);
    value[terms->row[PEND_TERM_ROD]] = 3;
    CHECK(pend_terms_inertia(terms, 2, 1, value, 0) == 8);
    value[terms->row[PEND_TERM_STIFFNESS]] = 32;
    CHECK(pend_loads_rate(&loads, tree) == 2);
    value[terms->row[PEND_TERM_STIFFNESS] + 1] = 8; // 1 / 8 + 1 / 0.5
    CHECK(fabs(pend_loads_rate(&loads, tree) - sqrt(17)) < 1e-15);
    value[terms->row[PEND_TERM_DAMPING] + 1] = 16;
    value[terms->one[PEND_TERM_DRAG_PER_MASS]] = 0.5;
    CHECK(fabs(pend_loads_rate(&loads, tree) - (sqrt(17) + 34 + 1)) < 1e-13);
    // the faster of two drives, unless it has no effect
    for (int i = 0; i < 2; i++) value[terms->harmonic[i].at + 1] = i ? -5 : 7;
    CHECK(pend_terms_drive_rate(terms, value) == 0);
    value[terms->harmonic[1].at] = 1e-9;
    CHECK(pend_terms_drive_rate(terms, value) == 5);
    value[terms->harmonic[0].at] = 1e-9;
    CHECK(pend_terms_drive_rate(terms, value) == 7);
}

/* Tests of core/tree/tree: the stored arrays, every detected error, and the matrices S and B.
 * Leaves to others: motion (test_dynamics, laws).
 * Invariant: trees come from literals or from harness/trees with a fixed seed. */
#include "core/tree/tree.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* errors in the order of their reports */
struct fault {
    enum pend_field field;
    int i, j;
    char text[200];
};

struct fault_list {
    int count;
    struct fault fault[64];
};

static void fault_note(void *context, enum pend_field field, int i, int j, const char *text) {
    struct fault_list *list = context;
    if (list->count < (int)(sizeof list->fault / sizeof *list->fault)) {
        struct fault *f = &list->fault[list->count];
        f->field = field, f->i = i, f->j = j;
        snprintf(f->text, sizeof f->text, "%s", text);
    }
    list->count++;
}

static int fault_seen(const struct fault_list *list, enum pend_field field, int i, int j) {
    for (int k = 0; k < list->count; k++)
        if (list->fault[k].field == field && list->fault[k].i == i && list->fault[k].j == j)
            return 1;
    return 0;
}

static enum pend_status try_tree(int n, const double length[], const double mass[],
                                 const int parent[], struct fault_list *list) {
    OWN(pend_tree, free) *tree = (struct pend_tree *)list;
    struct pend_fault_sink sink = {.report = fault_note, .context = list};
    list->count = 0;
    enum pend_status status = pend_tree_new(&tree, n, length, mass, parent, &sink);
    CHECK(status == PEND_OK ? pend_tree_valid(tree) : !tree);
    return status;
}

static enum pend_status try_path(int n, const double path[], int parent[],
                                 struct fault_list *list) {
    struct pend_fault_sink sink = {.report = fault_note, .context = list};
    list->count = 0;
    return pend_tree_parent_from_path(n, path, parent, &sink);
}

static void check_ints(const int got[], const int want[], int n, const char *what) {
    for (int i = 0; i < n; i++)
        CHECK_SAYING(got[i] == want[i], "%s[%d] is %d, expected %d", what, i, got[i], want[i]);
}

TEST(tree_stores_arms_depth_first_with_the_largest_sub_tree_last) {
    // the caller's arms: 3 at the pivot; 0, 1 and 5 on it; 2 and 4 on 0
    static const double length[] = {1, 2, 3, 4, 5, 6}, mass[] = {10, 20, 30, 40, 50, 60};
    static const int parent[] = {3, 3, 0, -1, 0, 3};
    OWN(pend_tree, free) *tree;
    REQUIRE(pend_tree_new(&tree, 6, length, mass, parent, NULL) == PEND_OK);
    check_ints(tree->order, (const int[]){3, 1, 5, 0, 2, 4}, 6, "order");
    check_ints(tree->place, (const int[]){3, 1, 4, 0, 5, 2}, 6, "place");
    check_ints(tree->parent, (const int[]){-1, 0, 0, 0, 3, 3}, 6, "parent");
    check_ints(tree->end, (const int[]){6, 2, 3, 6, 5, 6}, 6, "end");
    check_ints(tree->depth, (const int[]){1, 2, 2, 2, 3, 3}, 6, "depth");
    for (int k = 0; k < 6; k++)
        CHECK(tree->len[k] == length[tree->order[k]] && tree->mass[k] == mass[tree->order[k]]);
    CHECK(tree->subtree_mass[0] == 210 && tree->subtree_mass[3] == 90 &&
          tree->subtree_mass[2] == 60);
    CHECK(tree->length_total == 21);
    CHECK_INT(tree->n, 6);
    pend_tree_free(&tree);
    CHECK(!tree);
}

TEST(tree_keeps_ties_in_the_callers_order) {
    // four equal leaves on the first arm, then two equal chains on it
    static const double ones[] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
    static const int leaves[] = {-1, 0, 0, 0, 0}, chains[] = {-1, 0, 0, 1, 2};
    OWN(pend_tree, free) *tree;
    REQUIRE(pend_tree_new(&tree, 5, ones, ones, leaves, NULL) == PEND_OK);
    check_ints(tree->order, (const int[]){0, 1, 2, 3, 4}, 5, "order");
    pend_tree_free(&tree);
    REQUIRE(pend_tree_new(&tree, 5, ones, ones, chains, NULL) == PEND_OK);
    check_ints(tree->order, (const int[]){0, 1, 3, 2, 4}, 5, "order");
}

TEST(tree_accepts_every_parent_list_of_up_to_8_arms) {
    int count = 0, faulty = 0;
    unsigned long long seed = 11;
    for (int n = 1; n <= 8; n++) {
        int list[8];
        test_parents_first(n, list);
        do {
            int parent[8];
            struct test_tree t;
            memcpy(parent, list, sizeof parent);
            test_parents_shuffle(n, parent, &seed);
            test_tree_init(&t, n, parent, 1, &seed);
            faulty += !pend_tree_valid(t.tree);
            for (int k = 0; k < n; k++) {
                int p = parent[t.tree->order[k]];
                faulty += t.tree->parent[k] != (p < 0 ? -1 : t.tree->place[p]);
                faulty += t.tree->mass[k] != t.mass[t.tree->order[k]] ||
                          t.tree->len[k] != t.length[t.tree->order[k]];
            }
            test_tree_clear(&t);
            count++;
        } while (test_parents_next(n, list));
    }
    CHECK_INT(count, 5914);
    CHECK_INT(faulty, 0);
}

TEST(tree_takes_a_million_arms_of_any_kind) {
    int n = 1000000;
    OWN_MEMORY int *parent = malloc((size_t)n * sizeof *parent);
    OWN_MEMORY double *one = malloc((size_t)n * sizeof *one);
    REQUIRE(parent && one);
    for (int i = 0; i < n; i++) one[i] = 1;
    unsigned long long seed = 5;
    static const enum test_tree_kind kinds[] = {TEST_TREE_CHAIN, TEST_TREE_STAR,
                                                TEST_TREE_ATTACHED};
    for (int i = 0; i < 3; i++) {
        OWN(pend_tree, free) *tree;
        test_parents(kinds[i], n, parent, &seed);
        REQUIRE(pend_tree_new(&tree, n, one, one, parent, NULL) == PEND_OK);
        CHECK(pend_tree_valid(tree));
        CHECK(tree->subtree_mass[0] == n && tree->length_total == n);
        if (kinds[i] == TEST_TREE_CHAIN) CHECK_INT(tree->depth[n - 1], n);
    }
}

TEST(tree_valid_sees_damage) {
    static const double ones[] = {1, 1, 1, 1};
    static const int parent[] = {-1, 0, 0, 2};
    struct pend_tree *tree, damaged;
    REQUIRE(pend_tree_new(&tree, 4, ones, ones, parent, NULL) == PEND_OK);
    CHECK(pend_tree_valid(tree));
    damaged = *tree, damaged.parent = (const int[]){-1, 0, 2, 0};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.end = (const int[]){4, 3, 4, 4};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.depth = (const int[]){1, 2, 2, 2};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.order = (const int[]){0, 1, 2, 2};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.place = (const int[]){0, 1, 3, 2};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.len = (const double[]){1, 1, 0, 1};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.mass = (const double[]){1, NAN, 1, 1};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.subtree_mass = (const double[]){4, 1, 5, 1};
    CHECK(!pend_tree_valid(&damaged));
    damaged = *tree, damaged.n = 0;
    CHECK(!pend_tree_valid(&damaged));
    CHECK(!pend_tree_valid(NULL));
    pend_tree_free(&tree);
}

TEST(tree_needs_at_least_one_arm) {
    struct fault_list list;
    static const int count[] = {0, -1, -2147483647};
    for (int i = 0; i < 3; i++) {
        CHECK_INT(try_tree(count[i], NULL, NULL, NULL, &list), PEND_INVALID);
        CHECK_INT(list.count, 1);
        CHECK(fault_seen(&list, PEND_FIELD_COUNT, -1, -1));
        CHECK_INT(try_path(count[i], NULL, NULL, &list), PEND_INVALID);
        CHECK(fault_seen(&list, PEND_FIELD_COUNT, -1, -1));
    }
}

TEST(tree_reports_every_fault_at_once) {
    struct fault_list list;
    // values: 3 invalid lengths, 4 invalid masses; parents: 2 that are no arm, 1 arm on itself, a
    // cycle of 3, 2 roots too many
    static const double length[] = {1, 0, -1, NAN, 1, 1, 1, 1, 1, 1, 1};
    static const double mass[] = {INFINITY, 1, 1, 1, -INFINITY, -0.0, 1, 1, 1, 1, -2.5};
    static const int parent[] = {-1, 5, 1, 11, -2, 2, 6, -1, 0, -1, 2};
    CHECK_INT(try_tree(11, length, mass, parent, &list), PEND_INVALID);
    CHECK_INT(list.count, 13);
    for (int i = 1; i <= 3; i++) CHECK(fault_seen(&list, PEND_FIELD_LENGTH, i, -1));
    CHECK(fault_seen(&list, PEND_FIELD_MASS, 0, -1) && fault_seen(&list, PEND_FIELD_MASS, 4, -1));
    CHECK(fault_seen(&list, PEND_FIELD_MASS, 5, -1) && fault_seen(&list, PEND_FIELD_MASS, 10, -1));
    CHECK(fault_seen(&list, PEND_FIELD_PARENT, 3, -1) &&
          fault_seen(&list, PEND_FIELD_PARENT, 4, -1));
    CHECK(fault_seen(&list, PEND_FIELD_PARENT, 7, -1) &&
          fault_seen(&list, PEND_FIELD_PARENT, 9, -1));
    CHECK(fault_seen(&list, PEND_FIELD_PARENT, 6, -1) &&
          fault_seen(&list, PEND_FIELD_PARENT, 1, -1));
    // without a receiver the result is the same
    struct pend_tree *tree;
    CHECK_INT(pend_tree_new(&tree, 11, length, mass, parent, NULL), PEND_INVALID);
    CHECK(!tree);
}

TEST(tree_faults_say_what_was_wrong_and_what_would_be_right) {
    struct fault_list list;
    static const double good[] = {1, 1, 1, 1}, bad[] = {1, 1, -1.5, 1};
    CHECK_INT(try_tree(3, good, bad, (const int[]){-1, 0, 1}, &list), PEND_INVALID);
    CHECK_TEXT(list.fault[0].text, "must be a finite number greater than 0, got -1.5");
    CHECK_INT(try_tree(3, good, good, (const int[]){-1, 0, 3}, &list), PEND_INVALID);
    CHECK_TEXT(list.fault[0].text, "must be 0 (the pivot) or the number of an arm, 1 to 3");
    CHECK_INT(try_tree(3, good, good, (const int[]){1, -1, -1}, &list), PEND_INVALID);
    CHECK_TEXT(list.fault[0].text,
               "only one arm can hang from the pivot (0), and arm 2 already does");
    CHECK_INT(try_tree(2, good, good, (const int[]){-1, 1}, &list), PEND_INVALID);
    CHECK_TEXT(list.fault[0].text, "an arm cannot hang from itself");
    CHECK_INT(try_tree(4, good, good, (const int[]){-1, 3, 1, 2}, &list), PEND_INVALID);
    CHECK_TEXT(list.fault[0].text, "a cycle of 3 arms that never reaches the pivot: 2 > 4 > 3 > 2");
    CHECK_INT(list.count, 1);
}

TEST(tree_without_an_arm_at_the_pivot_has_a_cycle_too) {
    struct fault_list list;
    static const double good[] = {1, 1, 1, 1, 1};
    CHECK_INT(try_tree(5, good, good, (const int[]){1, 2, 0, 1, 3}, &list), PEND_INVALID);
    CHECK_INT(list.count, 2);
    CHECK(fault_seen(&list, PEND_FIELD_PARENT, -1, -1) &&
          fault_seen(&list, PEND_FIELD_PARENT, 0, -1));
}

TEST(tree_names_only_the_first_arms_of_a_long_cycle) {
    enum { N = 1000 };
    static double one[N];
    static int parent[N];
    struct fault_list list;
    for (int i = 0; i < N; i++) one[i] = 1, parent[i] = i ? i - 1 : -1;
    parent[100] = N - 1;
    CHECK_INT(try_tree(N, one, one, parent, &list), PEND_INVALID);
    CHECK_INT(list.count, 1);
    CHECK_TEXT(list.fault[0].text,
               "a cycle of 900 arms that never reaches the pivot: 101 > 1000 > 999 > 998 > 997 > "
               "996 > 995 > 994 > ... > 101");
}

TEST(tree_refuses_sums_that_are_not_finite) {
    struct fault_list list;
    static const double good[] = {1, 1}, huge[] = {1.5e308, 1.5e308};
    static const int parent[] = {-1, 0};
    CHECK_INT(try_tree(2, huge, good, parent, &list), PEND_INVALID);
    CHECK(list.count == 1 && fault_seen(&list, PEND_FIELD_LENGTH, -1, -1));
    CHECK_INT(try_tree(2, good, huge, parent, &list), PEND_INVALID);
    CHECK(list.count == 1 && fault_seen(&list, PEND_FIELD_MASS, -1, -1));
}

TEST(tree_takes_one_allocation_and_survives_its_failure) {
    static const double one[] = {1, 1, 1};
    static const int parent[] = {-1, 0, 0};
    static const double path[] = {1, 0, 0, 1, 1, 0, 1, 0, 1};
    struct pend_tree *tree = NULL;
    int got[3] = {7, 7, 7};
    long before = test_alloc_count();
    CHECK_INT(pend_tree_new(&tree, 3, one, one, parent, NULL), PEND_OK);
    CHECK_INT(test_alloc_count() - before, 1);
    pend_tree_free(&tree);
    for (int for_good = 0; for_good < 2; for_good++) {
        test_alloc_fail(1, for_good);
        CHECK_INT(pend_tree_new(&tree, 3, one, one, parent, NULL), PEND_NO_MEMORY);
        CHECK(!tree);
        test_alloc_fail(1, for_good);
        CHECK_INT(pend_tree_parent_from_path(3, path, got, NULL), PEND_NO_MEMORY);
        CHECK(got[0] == 7 && got[1] == 7 && got[2] == 7);
        test_alloc_faults_off();
    }
}

/* the path matrix of a parent list, by its definition */
static void path_of(int n, const int parent[], double path[]) {
    memset(path, 0, (size_t)(n * n) * sizeof *path);
    for (int i = 0; i < n; i++)
        for (int j = i; j >= 0; j = parent[j]) path[i * n + j] = 1;
}

TEST(tree_path_and_parents_are_inverse_to_each_other) {
    unsigned long long seed = 3;
    int wrong = 0;
    for (int n = 1; n <= 8; n++) {
        int list[8];
        test_parents_first(n, list);
        do {
            int parent[8], back[8];
            double path[64], stored[64];
            OWN(test_tree, clear) t;
            struct fault_list faults;
            memcpy(parent, list, sizeof parent);
            test_parents_shuffle(n, parent, &seed);
            path_of(n, parent, path);
            wrong += try_path(n, path, back, &faults) != PEND_OK || faults.count > 0;
            wrong += memcmp(back, parent, (size_t)n * sizeof *back) != 0;
            test_tree_init(&t, n, parent, 0, &seed);
            pend_tree_path(t.tree, stored);
            wrong += memcmp(stored, path, (size_t)(n * n) * sizeof *path) != 0;
        } while (test_parents_next(n, list));
    }
    CHECK_INT(wrong, 0);
}

TEST(tree_path_faults_name_the_wrong_entry) {
    struct fault_list list;
    int parent[4] = {9, 9, 9, 9};
    // the paper's S with one entry after another altered
    static const double paper[] = {1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 1, 0, 1, 1, 0, 1};
    static const struct {
        int i, j;
        double value;
        const char *text;
    } spoil[] = {
        {2, 2, 0, "must be 1: an arm is on the way to its own tip"},
        {3, 1, 0.5, "must be 0 or 1, got 0.5"},
        {0, 0, NAN, "must be 0 or 1, got nan"},
        {1, 0, -1, "must be 0 or 1, got -1"},
        {3, 0, 0, "must be 1: row 4 must be row 2 (its parent) with a 1 added in column 4"},
        {0, 2, 1,
         "must be 0: the other rows make arm 1 the one at the pivot, so no arm precedes it"},
        {1, 3, 1, "must be 0: row 2 must be row 1 (its parent) with a 1 added in column 2"},
    };
    for (size_t s = 0; s < sizeof spoil / sizeof *spoil; s++) {
        double path[16];
        memcpy(path, paper, sizeof path);
        path[spoil[s].i * 4 + spoil[s].j] = spoil[s].value;
        CHECK_INT(try_path(4, path, parent, &list), PEND_INVALID);
        CHECK_INT(list.count, 1);
        CHECK_SAYING(fault_seen(&list, PEND_FIELD_PATH, spoil[s].i, spoil[s].j),
                     "case %d blames (%d, %d)", (int)s, list.fault[0].i, list.fault[0].j);
        CHECK_TEXT(list.fault[0].text, spoil[s].text);
    }
    CHECK(parent[0] == 9 && parent[3] == 9);
}

TEST(tree_path_faults_come_all_at_once) {
    struct fault_list list;
    int parent[4];
    // two arms at the pivot, a wrong diagonal, and an entry other than 0 and 1
    static const double path[] = {1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 7, 1};
    CHECK_INT(try_path(4, path, parent, &list), PEND_INVALID);
    CHECK_INT(list.count, 3);
    CHECK(fault_seen(&list, PEND_FIELD_PATH, 1, 0) && fault_seen(&list, PEND_FIELD_PATH, 2, 2));
    CHECK(fault_seen(&list, PEND_FIELD_PATH, 3, 2));
    // matrices without any structure get a result too
    static const double zeros[9], ones[] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
    CHECK_INT(try_path(3, zeros, parent, &list), PEND_INVALID);
    CHECK(list.count >= 3);
    CHECK_INT(try_path(3, ones, parent, &list), PEND_INVALID);
    CHECK(list.count >= 1);
}

/* The effect of one flipped entry: 0 = the result is another tree's path matrix, 1 = that entry
 * alone is reported, 2 = one other entry is, whose change repairs the matrix as well, 3 = several
 * are, 4 = wrong: accepted although no path matrix. */
static int flip_outcome(int n, double path[], int i, int j) {
    struct fault_list list;
    int parent[8];
    double back[64];
    path[i * n + j] = 1 - path[i * n + j];
    enum pend_status status = try_path(n, path, parent, &list);
    if (status == PEND_OK) path_of(n, parent, back);
    int same = status == PEND_OK && !memcmp(back, path, (size_t)(n * n) * sizeof *back);
    path[i * n + j] = 1 - path[i * n + j];
    if (status == PEND_OK) return same && list.count == 0 ? 0 : 4;
    if (list.count > 1) return 3;
    return fault_seen(&list, PEND_FIELD_PATH, i, j) ? 1 : 2;
}

TEST(tree_path_blames_a_flipped_entry_of_every_small_tree) {
    unsigned long long seed = 9;
    long outcome[5] = {0};
    for (int n = 2; n <= 7; n++) {
        int list[8];
        test_parents_first(n, list);
        do {
            int parent[8];
            double path[64];
            memcpy(parent, list, sizeof parent);
            test_parents_shuffle(n, parent, &seed);
            path_of(n, parent, path);
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++) outcome[flip_outcome(n, path, i, j)]++;
        } while (test_parents_next(n, list));
    }
    long total = outcome[0] + outcome[1] + outcome[2] + outcome[3] + outcome[4];
    CHECK_INT(outcome[4], 0);
    CHECK(outcome[0] > 0);
    CHECK_SAYING(outcome[1] > total * 7 / 10,
                 "of %ld flips %ld give another tree, %ld are blamed alone, %ld on one other "
                 "entry, %ld on several",
                 total, outcome[0], outcome[1], outcome[2], outcome[3]);
    CHECK_SAYING(outcome[3] < total / 30, "%ld of %ld flips are blamed on several entries",
                 outcome[3], total);
}

TEST(tree_force_map_is_the_inverse_transpose_of_the_path) {
    unsigned long long seed = 21;
    int wrong = 0;
    double spoilt = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        enum { N = 40 };
        static double path[N * N], map[N * N];
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)kind, N, 1, &seed);
        pend_tree_path(t.tree, path);
        pend_tree_force_map(t.tree, map);
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++) {
                double product = 0, transposed = 0;
                for (int k = 0; k < N; k++) {
                    product += map[i * N + k] * path[j * N + k];
                    transposed += map[i * N + k] * path[k * N + j];
                }
                wrong += product != (i == j);
                spoilt += fabs(transposed - (i == j));
            }
    }
    CHECK_INT(wrong, 0);
    // B S in place of B S^T is far from I: the check can fail
    CHECK(spoilt > 100);
}

TEST(tree_path_has_no_eigenvalue_but_1) {
    // in stored order S is lower triangular with ones on the diagonal, so S - I is nilpotent
    unsigned long long seed = 22;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        enum { N = 24 };
        double path[N * N];
        OWN(test_tree, clear) t;
        int upper = 0, diagonal = 0;
        test_tree_random(&t, (enum test_tree_kind)kind, N, 1, &seed);
        pend_tree_path(t.tree, path);
        for (int k = 0; k < N; k++) {
            diagonal += path[t.tree->order[k] * N + t.tree->order[k]] == 1;
            for (int j = k + 1; j < N; j++)
                upper += path[t.tree->order[k] * N + t.tree->order[j]] != 0;
        }
        CHECK_INT(diagonal, N);
        CHECK_INT(upper, 0);
    }
}

/* counts the errors with texts and those without */
static void fault_count_words(void *context, enum pend_field field, int i, int j,
                              const char *text) {
    (void)field, (void)i, (void)j;
    ++((int *)context)[text ? 0 : 1];
}

TEST(tree_puts_only_so_many_faults_in_words) {
    double bad[5] = {0};
    int parent[5] = {-1, 0, 1, 2, 3}, count[2] = {0, 0};
    struct pend_fault_sink sink = {fault_count_words, count, 3};
    struct pend_tree *tree = NULL;
    CHECK_INT(pend_tree_new(&tree, 5, bad, bad, parent, &sink), PEND_INVALID);
    CHECK_INT(count[0], 3);
    CHECK_INT(count[1], 7);
}

/* The test harness: tests register themselves, failed checks are reported and the test continues,
 * numbers are checked on both sides.
 * Leaves to others: what is tested; starting servers (harness/server).
 * Invariant: a failed check fails its test; a test that checks nothing fails. */
#pragma once

#include <stddef.h>

#include "tests/harness/own.h"

struct test_case {
    const char *name, *file;
    void (*run)(void);
    struct test_case *next;
};

void test_register(struct test_case *test);

/** Defines a test; its name is a sentence: TEST(tree_rejects_a_cycle) { ... } */
#define TEST(name_)                                                                                \
    static void test_##name_(void);                                                                \
    static struct test_case case_##name_ = {#name_, __FILE__, test_##name_, NULL};                 \
    __attribute__((constructor)) static void register_##name_(void) {                              \
        test_register(&case_##name_);                                                              \
    }                                                                                              \
    static void test_##name_(void)

/* Each check prints the values if it fails, and returns non-zero if it passed; the test continues
 * in both cases. */
int test_check(int pass, const char *file, int line, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
int test_check_int(long long got, long long want, const char *what, const char *file, int line);
int test_check_text(const char *got, const char *want, const char *what, const char *file,
                    int line);
int test_check_residual(double residual, double tolerance, const char *what, const char *file,
                        int line);

#define CHECK(condition) test_check(!!(condition), __FILE__, __LINE__, "%s", #condition)
#define CHECK_SAYING(condition, ...) test_check(!!(condition), __FILE__, __LINE__, __VA_ARGS__)
#define CHECK_INT(got, want) test_check_int((got), (want), #got, __FILE__, __LINE__)
#define CHECK_TEXT(got, want) test_check_text((got), (want), #got, __FILE__, __LINE__)

/**
 * A numeric law: passes if residual <= tolerance and tolerance <= 1000 * residual (1e-18 stands in
 * for a smaller residual), so that a tolerance cannot become too loose. With TOL=0 in the
 * environment every residual is listed.
 */
#define CHECK_RESIDUAL(residual, tolerance, what)                                                  \
    test_check_residual((residual), (tolerance), (what), __FILE__, __LINE__)

/** Leaves the test if the condition fails, for a condition that everything after it needs. */
#define REQUIRE(condition)                                                                         \
    do {                                                                                           \
        if (!CHECK(condition)) return;                                                             \
    } while (0)

/** The number of this process among those that run tests side by side, from 0: for names of files.
 */
extern int test_lane;

/** Marks the running test as skipped and prints the reason; return from the test afterwards. */
void test_skip(const char *reason);

/**
 * Failing allocations: the count-th allocation from now (1 = the next) fails, once, or from there
 * on for good. test_alloc_faults_off ends it. test_alloc_count is the number of allocations since
 * the program began.
 */
void test_alloc_fail(long count, int for_good);
void test_alloc_faults_off(void);
long test_alloc_count(void);

/**
 * Disk failures: the count-th call from now (1 = the next) with which SQLite writes, syncs or cuts
 * a file fails with an errno, once, or from there on for good. Until test_disk_faults_off, which
 * returns how many there were, nothing is waited for.
 */
void test_disk_fail(long count, int for_good, int error);
long test_disk_faults_off(void);

/**
 * The stride of loops over thousands of failures. The release build runs all of such a loop, on
 * memory filled with garbage; the address sanitizer every third; the thread sanitizer every
 * sixteenth, because a single thread runs the loop.
 */
#if defined(__SANITIZE_THREAD__)
#define TEST_STRIDE 16
#elif defined(__SANITIZE_ADDRESS__)
#define TEST_STRIDE 3
#else
#define TEST_STRIDE 1
#endif

/** A reproducible random number in [0, 1) from a state owned by the test; splitmix64. */
double test_random(unsigned long long *state);
/** The same, an integer in [0, below). */
int test_random_int(unsigned long long *state, int below);
/** The same, with mean 0 and variance 1: a sum of two, and normal by Box and Muller. */
double test_noise(unsigned long long *state);
double test_gauss(unsigned long long *state);

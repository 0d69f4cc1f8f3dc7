#include "tests/harness/test.h"

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "core/base/isa.h"

static struct test_case *test_first, **test_last = &test_first;
/* a server's threads check too if a test wraps functions that they call */
static atomic_int test_checks, test_faults;
static int test_skipped, test_list_residuals;
static const char *test_running;
int test_lane;

/* What the processes share that run tests side by side. */
enum { LANES = 8 };
static struct test_share {
    atomic_int next;           /* the first wanted test that no process has taken */
    atomic_int ended[3];       /* tests that passed, failed, were skipped */
    atomic_int threads[LANES]; /* threads that were started in the running test, by its processes
                                * too */
    _Atomic(const struct test_case *) at[LANES]; /* the test that each runs; NULL = it has ended */
} * test_share;

/* the program's own calls come here (Makefile, WRAP) */
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *context);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *context);

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *context) {
    test_share->threads[test_lane]++;
    return __real_pthread_create(thread, attributes, run, context);
}

void test_register(struct test_case *test) {
    *test_last = test;
    test_last = &test->next;
}

int test_check(int pass, const char *file, int line, const char *format, ...) {
    test_checks++;
    if (pass) return 1;
    test_faults++;
    va_list arguments;
    va_start(arguments, format);
    printf("  %s:%d: ", file, line);
    vprintf(format, arguments);
    printf("\n");
    va_end(arguments);
    return 0;
}

int test_check_int(long long got, long long want, const char *what, const char *file, int line) {
    return test_check(got == want, file, line, "%s is %lld, expected %lld", what, got, want);
}

int test_check_text(const char *got, const char *want, const char *what, const char *file,
                    int line) {
    if (!got) got = "(null)";
    if (!want) want = "(null)";
    return test_check(!strcmp(got, want), file, line, "%s is \"%s\", expected \"%s\"", what, got,
                      want);
}

int test_check_residual(double residual, double tolerance, const char *what, const char *file,
                        int line) {
    if (test_list_residuals)
        printf("  %-60s residual %9.2e  tolerance %9.2e\n", what, residual, tolerance);
    if (!(residual <= tolerance))
        return test_check(0, file, line, "%s: residual %.3e is above the tolerance %.3e", what,
                          residual, tolerance);
    /* the size of a residual depends on the order of the sums, which differs between instruction
     * sets: tolerances are kept tight on the widest, and hold on all */
    if (pend_isa_best() == PEND_ISA_BASE) return test_check(1, file, line, "%s", what);
    return test_check(tolerance <= 1000 * fmax(residual, 1e-18), file, line,
                      "%s: tolerance %.3e is over 1000 times slacker than the residual %.3e", what,
                      tolerance, residual);
}

void test_skip(const char *reason) {
    test_skipped = 1;
    printf("skip %s: %s\n", test_running, reason);
}

double test_random(unsigned long long *state) {
    unsigned long long x = (*state += 0x9e3779b97f4a7c15ull);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

int test_random_int(unsigned long long *state, int below) {
    return (int)(test_random(state) * below);
}

double test_noise(unsigned long long *state) {
    return sqrt(6) * (test_random(state) + test_random(state) - 1);
}

double test_gauss(unsigned long long *state) {
    double size = sqrt(-2 * log(1 - test_random(state)));
    return size * cos(6.28318530717958647692 * test_random(state));
}

/* seconds of processor time of this program and of the programs that it started and that have
 * ended */
static double test_processor_seconds(void) {
    struct rusage own, ended;
    getrusage(RUSAGE_SELF, &own);
    getrusage(RUSAGE_CHILDREN, &ended);
    return (double)(own.ru_utime.tv_sec + own.ru_stime.tv_sec + ended.ru_utime.tv_sec +
                    ended.ru_stime.tv_sec) +
           1e-6 * (double)(own.ru_utime.tv_usec + own.ru_stime.tv_usec + ended.ru_utime.tv_usec +
                           ended.ru_stime.tv_usec);
}

/* runs one test and prints its result: 0 passed, 1 failed, 2 skipped */
static int test_run(const struct test_case *test) {
    struct timespec begin, end;
    atomic_store(&test_checks, 0);
    atomic_store(&test_faults, 0);
    test_skipped = 0;
    test_share->threads[test_lane] = 0;
    test_running = test->name;
    double worked = test_processor_seconds();
    clock_gettime(CLOCK_MONOTONIC, &begin);
    test->run();
    clock_gettime(CLOCK_MONOTONIC, &end);
    test_alloc_faults_off();
    if (test_skipped && !test_faults) return 2;
    if (!test_checks) printf("  %s checked nothing\n", test->name);
    int failed = test_faults || !test_checks;
    double seconds =
        (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    printf("%s %s (%.2f s, %.2f s of processors%s)\n", failed ? "FAIL" : "ok  ", test->name,
           seconds, test_processor_seconds() - worked,
           test_share->threads[test_lane] ? ", threads" : "");
    fflush(stdout);
    return failed;
}

/* whether this word selects the test: a part of its name or file, or its whole name after '=' */
static int test_meant(const struct test_case *test, const char *word) {
    if (word[0] == '=') return !strcmp(test->name, word + 1);
    return strstr(test->name, word) || strstr(test->file, word);
}

/* A test is wanted if a word selects it, or if no word selects any; but not if a word after '-'
 * selects it. */
static int test_wanted(const struct test_case *test, char **words, int count) {
    int named = 0, meant = 0;
    for (int i = 0; i < count; i++) {
        if (words[i][0] == '-') {
            if (test_meant(test, words[i] + 1)) return 0;
            continue;
        }
        named = 1;
        meant |= test_meant(test, words[i]);
    }
    return meant || !named;
}

/* whole names that no test has: each is printed and counts as failed, because a list of names could
 * outlive its tests */
static int test_unknown(char **words, int count) {
    int unknown = 0;
    for (int i = 0; i < count; i++) {
        const char *word = words[i] + (words[i][0] == '-');
        const struct test_case *test = test_first;
        if (word[0] != '=') continue;
        while (test && !test_meant(test, word)) test = test->next;
        if (test) continue;
        printf("FAIL %s: no test has this name\n", word + 1);
        unknown++;
    }
    return unknown;
}

/* runs the tests that no other process has taken */
static void test_lane_run(char **words, int count) {
    int place = 0, mine = test_share->next++;
    for (const struct test_case *test = test_first; test; test = test->next) {
        if (!test_wanted(test, words, count) || place++ != mine) continue;
        test_share->at[test_lane] = test;
        test_share->ended[test_run(test)]++;
        mine = test_share->next++;
    }
    test_share->at[test_lane] = NULL;
}

/* Runs the tests in this many processes. One that crashes, or in which a sanitizer found something
 * at the end, counts as one failure, and the others continue. */
static void test_lanes_run(int lanes, char **words, int count) {
    pid_t pid[LANES];
    fflush(stdout);
    for (int i = 0; i < lanes; i++) {
        pid[i] = fork();
        if (pid[i]) continue;
        test_lane = i;
        test_lane_run(words, count);
        exit(0);
    }
    for (int i = 0; i < lanes; i++) {
        int status = -1;
        int ended = pid[i] > 0 && waitpid(pid[i], &status, 0) == pid[i];
        const struct test_case *test = test_share->at[i];
        // a process that ends with 0 in the middle of a test has not reported it
        if (ended && !status && !test) continue;
        printf("FAIL %s ended its process: status %d\n", test ? test->name : "the end of all",
               status);
        test_share->ended[1]++;
    }
}

/* usage: run [PART-OF-A-NAME-OR-FILE | =NAME | -PART | -=NAME ...]; '-' excludes; the last line is
 * "N passed, N failed", with ", N skipped" if there were any. TEST_LANES is the number of processes
 * that run tests side by side, default 1: useful if most of them wait for servers. */
int main(int argc, char **argv) {
    const char *tolerance = getenv("TOL"), *wanted = getenv("TEST_LANES");
    int lanes = wanted ? atoi(wanted) : 1;
    test_share =
        mmap(NULL, sizeof *test_share, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (test_share == MAP_FAILED) return 1;
    test_share->ended[1] = test_unknown(argv + 1, argc - 1);
    test_list_residuals = tolerance && !strcmp(tolerance, "0");
    if (lanes > 1)
        test_lanes_run(lanes < LANES ? lanes : LANES, argv + 1, argc - 1);
    else
        test_lane_run(argv + 1, argc - 1);
    int passed = test_share->ended[0], failed = test_share->ended[1],
        skipped = test_share->ended[2];
    if (!passed && !failed && argc > 1)
        printf("no test has \"%s\" in its name or in its file's\n", argv[1]);
    printf("%d passed, %d failed", passed, failed);
    printf(skipped ? ", %d skipped\n" : "\n", skipped);
    return failed > 0 || passed + failed == 0;
}

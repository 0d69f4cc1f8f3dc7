/* Counting and failing allocations, by the linker's --wrap of malloc, calloc, realloc and
 * aligned_alloc.
 * Leaves to others: deciding which allocation fails (the test).
 * Invariant: with failures off every call goes straight through. */
#include <stdatomic.h>
#include <stddef.h>

#include "tests/harness/test.h"

void *__real_malloc(size_t bytes);
void *__real_calloc(size_t count, size_t bytes);
void *__real_realloc(void *old, size_t bytes);
void *__real_aligned_alloc(size_t alignment, size_t bytes);
void *__wrap_malloc(size_t bytes);
void *__wrap_calloc(size_t count, size_t bytes);
void *__wrap_realloc(void *old, size_t bytes);
void *__wrap_aligned_alloc(size_t alignment, size_t bytes);

static atomic_long alloc_count, alloc_fail_at;
static atomic_int alloc_for_good;

/* GSL leaks some memory if an allocation for a method or a workspace fails in the middle, which we
 * cannot repair. GSL has no frame pointers, so that a stack ends at the function that allocates:
 * those of a fit's workspace are trust_alloc, lm_alloc, qr_alloc and gsl_matrix_alloc, which
 * nothing of ours calls. A fit that is not freed is found by its own block. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
const char *__lsan_default_suppressions(void) {
    return "leak:msadams_alloc\nleak:gsl_eigen_\nleak:gsl_multifit_\nleak:trust_alloc\n"
           "leak:lm_alloc\nleak:qr_alloc\nleak:gsl_matrix_alloc\n";
}

void test_alloc_fail(long count, int for_good) {
    alloc_for_good = for_good;
    alloc_fail_at = alloc_count + count;
}

void test_alloc_faults_off(void) { alloc_fail_at = 0; }

long test_alloc_count(void) { return alloc_count; }

static int alloc_fails(void) {
    long number = ++alloc_count, fail_at = alloc_fail_at;
    return fail_at && (number == fail_at || (alloc_for_good && number > fail_at));
}

void *__wrap_malloc(size_t bytes) { return alloc_fails() ? NULL : __real_malloc(bytes); }
void *__wrap_calloc(size_t count, size_t bytes) {
    return alloc_fails() ? NULL : __real_calloc(count, bytes);
}
void *__wrap_realloc(void *old, size_t bytes) {
    return alloc_fails() ? NULL : __real_realloc(old, bytes);
}
void *__wrap_aligned_alloc(size_t alignment, size_t bytes) {
    return alloc_fails() ? NULL : __real_aligned_alloc(alignment, bytes);
}

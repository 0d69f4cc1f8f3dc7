/* A limit that the system enforces on the memory of a process: a separate group of cgroup v2.
 * Leaves to others: what is limited, and what limits it if no group can be created
 * (tests/wire/test_memory.c).
 * Invariant: a group that was created here is removed here; no other group of the machine is
 * changed. */
#pragma once

enum { TEST_FENCE_PATH = 700 };

struct test_fence {
    char path[TEST_FENCE_PATH]; /* directory of the group; "" = none */
};

/**
 * Creates an empty group whose processes get this many bytes of memory, without swap, and are
 * killed beyond that: below the group of this program, or below one above it, if the machine
 * permits that.
 *
 * reason  out: why there is none.
 *
 * Returns 1, or 0 if the machine has no cgroup v2, or none that is writable and delegates memory.
 */
int test_fence_open(struct test_fence *fence, long long bytes, char reason[200]);

/** Puts a process into the group: memory that it allocates from then on counts. Returns 0 with a
 * failed check. */
int test_fence_enter(const struct test_fence *fence, int pid);

/** The most bytes that the group has had; 0 if the system does not report it. */
double test_fence_peak(const struct test_fence *fence);

/** After its processes have ended: checks that none was killed for its memory, and removes the
 * group. No group is accepted. */
void test_fence_close(struct test_fence *fence);

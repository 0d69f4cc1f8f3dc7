/* A bound that the system keeps on the memory of a process: a group of cgroup v2 of its own.
 * Leaves to others: what is bounded, and what bounds it where no group can be made
 * (tests/wire/test_memory.c).
 * Invariant: a group that was made here is removed here; nothing else of the machine's groups is
 * changed. */
#pragma once

enum { TEST_FENCE_PATH = 700 };

struct test_fence {
    char path[TEST_FENCE_PATH]; /* of the group's directory; "" = there is none */
};

/**
 * Makes an empty group whose processes get so many bytes of memory, without swap, and are killed
 * beyond that: below the group of this program, or below one above it, where the machine lets it.
 *
 * reason  out: why there is none.
 *
 * Returns 1, or 0 where the machine has no cgroup v2, or none that may be written and that hands
 * memory on.
 */
int test_fence_open(struct test_fence *fence, long long bytes, char reason[200]);

/** Puts a process into the group: what it takes from then on counts. Returns 0 with a failed
 * check. */
int test_fence_enter(const struct test_fence *fence, int pid);

/** The most bytes that the group has had; 0 where the system does not say. */
double test_fence_peak(const struct test_fence *fence);

/** Once its processes have ended: checks that none was killed for its memory, and removes the
 * group. No group is accepted. */
void test_fence_close(struct test_fence *fence);

/* Memory accounts of the process by kind, and the allocator's own figures.
 * Leaves to others: limits (hold), the owners (exchange, inflight, response_body, part_run,
 * connection).
 * Invariant: added bytes are subtracted exactly once; accounting takes no lock. */
#pragma once

#include <assert.h>
#include <stdatomic.h>

/* kind, label of the metric */
#define SRV_MEMORY_LIST(X)                                                                         \
    X(SRV_MEMORY_CONNECTIONS, connections)   /* connections and event streams */                   \
    X(SRV_MEMORY_BODIES, bodies)             /* bodies of requests */                              \
    X(SRV_MEMORY_COMPUTATIONS, computations) /* operations, compression, unfinished answers */     \
    X(SRV_MEMORY_ANSWERS, answers)           /* complete answers, cached ones included */          \
    X(SRV_MEMORY_JOBS, jobs)                 /* parts of jobs being computed */

enum srv_memory_kind {
#define X(kind, label) kind,
    SRV_MEMORY_LIST(X)
#undef X
        SRV_MEMORY_KINDS
};

struct srv_memory {
    atomic_llong all, kind[SRV_MEMORY_KINDS]; /* bytes in total, and by kind */
    atomic_llong allocated; /* allocated bytes at the last query of the allocator */
    atomic_llong looked;    /* ns: time of that query */
};

/** Adds to the count of a kind; `bytes` may be negative. Any thread. */
static inline void srv_memory_add(struct srv_memory *memory, enum srv_memory_kind kind,
                                  long long bytes) {
    long long before = atomic_fetch_add_explicit(&memory->kind[kind], bytes, memory_order_relaxed);
    assert(before >= 0 && before + bytes >= 0);
    (void)before;
    atomic_fetch_add(&memory->all, bytes);
}

/** Returns the bytes of all kinds. Any thread. */
static inline long long srv_memory_all(const struct srv_memory *memory) {
    return atomic_load(&memory->all);
}

/** Configures the allocator; call it once, before the first thread starts. There are few arenas, so
 * that memory freed by one thread serves another and no address space is wasted; large blocks come
 * from the system, so that they are returned to it. */
void srv_memory_settle(int threads);

/** Reads the allocator's statistics, at most every tenth of a second, and returns free memory to
 * the system if there is much of it. Takes about ten microseconds, or a millisecond if much is
 * returned. Any thread. */
void srv_memory_look(struct srv_memory *memory);

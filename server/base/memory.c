#include "server/base/memory.h"

#include <malloc.h>

#include "server/base/clock.h"

enum {
    MEMORY_LOOK_MS = 100,
    MEMORY_FREE = 24 << 20, /* above so much free memory, some is returned to the system */
    MEMORY_LARGE = 4 << 20, /* blocks above this size come from the system, and are returned to it
                             * when freed */
    MEMORY_TRIM = 16 << 20  /* free memory at the end of the heap above this size is returned at
                             * once */
};

void srv_memory_settle(int threads) {
#ifdef M_ARENA_MAX
    mallopt(M_ARENA_MAX, threads + 2);
    mallopt(M_MMAP_THRESHOLD, MEMORY_LARGE);
    mallopt(M_TRIM_THRESHOLD, MEMORY_TRIM);
#else
    (void)threads;
#endif
}

void srv_memory_look(struct srv_memory *memory) {
    int64_t now = srv_clock_now();
    long long looked = atomic_load(&memory->looked);
    if (now - looked < MEMORY_LOOK_MS * 1000000LL) return;
    /* of several threads that call this at the same time, one queries the allocator */
    if (!atomic_compare_exchange_strong(&memory->looked, &looked, now)) return;
#if defined __GLIBC__ && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
    struct mallinfo2 info = mallinfo2();
    atomic_store(&memory->allocated, (long long)(info.uordblks + info.hblkhd));
    if (info.fordblks > MEMORY_FREE) malloc_trim(MEMORY_FREE / 4);
#endif
}

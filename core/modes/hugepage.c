#include "core/modes/hugepage.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

enum { ROOM_PAGE = 2 << 20, ROOM_LINE = 64 };

void *pend_hugepage(size_t bytes) {
    size_t unit = bytes >= 2 * ROOM_PAGE ? ROOM_PAGE : ROOM_LINE;
    if (bytes > SIZE_MAX / 2) return NULL;
    bytes = (bytes + unit - 1) / unit * unit;
    assert(bytes % unit == 0);
    void *room = aligned_alloc(unit, bytes ? bytes : unit);
#ifdef MADV_HUGEPAGE
    /* this call is only a hint: its failure has no effect */
    if (room && unit == ROOM_PAGE) (void)madvise(room, bytes, MADV_HUGEPAGE);
#endif
    return room;
}

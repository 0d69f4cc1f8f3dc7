/* The files that the server may open once it has started, and the ports it may reach: Landlock.
 * Leaves to others: which these are (server/walls), which system calls there are (calls).
 * Invariant: what is not named cannot be opened, made, renamed or run, whoever the process runs as.
 */
#ifndef SRV_FENCE_H
#define SRV_FENCE_H

#include "core/base/status.h"

enum { SRV_FENCE_PLACES = 48, SRV_FENCE_PATH = 512 };

/* What may be done below a place. */
enum srv_fence_use {
    SRV_FENCE_READ, /* reading, of files and directories */
    SRV_FENCE_WRITE /* that, and making, writing, renaming and removing files */
};

struct srv_fence {
    int count;
    int connects; /* non-zero: connections to other processes over TCP may be opened */
    struct srv_fence_place {
        enum srv_fence_use use;
        char path[SRV_FENCE_PATH];
    } place[SRV_FENCE_PLACES];
};

/** Adds a file, or a directory with all that is below it. One that is not there when the fence is
 * put up is passed over. A path that is too long, or one place too many, is passed over as well:
 * less is open then, and never more. */
void srv_fence_add(struct srv_fence *fence, enum srv_fence_use use, const char *path);

/** Adds the directory that a file lies in, so that the file may be made or replaced. */
void srv_fence_add_around(struct srv_fence *fence, enum srv_fence_use use, const char *file);

/**
 * Puts up the fence for this thread and those that it will start, for good. Files that are open
 * stay so. On kernels from 6.7 on it also forbids to bind ports, and to connect unless `connects`.
 *
 * Requires no_new_privs, or root's privileges.
 *
 * PEND_INVALID  the kernel has none; error says why, and nothing has changed.
 */
PEND_MUST_CHECK enum pend_status srv_fence_close(const struct srv_fence *fence,
                                                 struct pend_error *error);

#endif

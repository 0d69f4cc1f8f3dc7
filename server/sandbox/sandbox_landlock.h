/* Restricts the files that the server may open after its start, and the ports that it may reach
 * (Landlock).
 * Leaves to others: choosing the files (server/sandbox_setup), system calls (sandbox_seccomp).
 * Invariant: files that are not listed cannot be opened, created, renamed or executed, also by
 * root. */
#pragma once

#include "core/base/status.h"

enum { SRV_SANDBOX_PLACES = 48, SRV_SANDBOX_PATH = 512 };

/* The access allowed below a place. */
enum srv_sandbox_use {
    SRV_SANDBOX_READ, /* read files and directories */
    SRV_SANDBOX_WRITE /* also create, write, rename and remove files */
};

struct srv_sandbox_files {
    int count;
    int connects; /* non-zero: outgoing TCP connections are allowed */
    struct srv_sandbox_place {
        enum srv_sandbox_use use;
        char path[SRV_SANDBOX_PATH];
    } place[SRV_SANDBOX_PLACES];
};

/** Adds a file, or a directory with everything below it. A path that does not exist is ignored when
 * the restriction takes effect. A path that is too long, or beyond SRV_SANDBOX_PLACES, is ignored
 * too: access is then narrower, never wider. */
void srv_sandbox_add(struct srv_sandbox_files *files, enum srv_sandbox_use use, const char *path);

/** Adds the directory of a file, so that the file can be created or replaced. */
void srv_sandbox_add_around(struct srv_sandbox_files *files, enum srv_sandbox_use use,
                            const char *file);

/**
 * Restricts this thread and all threads that it starts, irrevocably. Open files stay open. From
 * Linux 6.7 on this also forbids binding ports, and connecting unless `connects` is set.
 *
 * Requires no_new_privs, or root's privileges.
 *
 * PEND_INVALID  the kernel does not support it; error says why, and nothing has changed.
 */
PEND_MUST_CHECK enum pend_status srv_sandbox_landlock(const struct srv_sandbox_files *files,
                                                      struct pend_error *error);

/* The files that the process of a webhook's message may read.
 * Leaves to others: keeping it to them (sandbox/fence).
 * Invariant: none of them holds a secret of the server or of its operator: of /etc only what names
 * and certificates are looked up by. */
#ifndef SRV_HOOK_FILES_H
#define SRV_HOOK_FILES_H

#include "server/sandbox/fence.h"

/**
 * Adds them to a fence: those that are there at this moment, since a file that is replaced later is
 * another one to a fence. Connections over TCP may be opened.
 *
 * authority  a file of certificates that are trusted, or "none": those of the system.
 */
void srv_hook_files(struct srv_fence *fence, const char *authority);

#endif

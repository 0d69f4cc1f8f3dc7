/* A recorded request, or that of a crate, computed again, without sockets: `pendulumd --replay
 * FILE`. Leaves to others: recording (work/recorder), the format of the file (work/recording),
 * crates (api/call/crate_read). Invariant: only the file decides the answer: a recording's own
 * limits hold, of a crate the largest; no clock and no cache. */
#ifndef SRV_REPLAY_H
#define SRV_REPLAY_H

/**
 * Computes the request of a file; its answer goes to standard output, and to standard error what
 * was asked, the status, and whether the answer has the recorded digest.
 *
 * A file that is an archive is a crate of GET /v1/jobs/{id}/crate: its results are compared with
 * those that are computed now.
 *
 * Returns the exit status: 0 where status and digest are the recorded ones, 1 where they are not,
 * or no answer was recorded, or the answer cannot be written; 2 where the file cannot be read or is
 * damaged.
 */
int srv_replay(const char *path);

#endif

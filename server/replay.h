/* A recorded request computed again, without sockets: `pendulumd --replay FILE`.
 * Leaves to others: recording (work/recorder), the format of the file (work/recording).
 * Invariant: only the file decides the answer: the recording's own limits hold; no clock and no
 * cache. */
#ifndef SRV_REPLAY_H
#define SRV_REPLAY_H

/**
 * Computes the request of a file; its answer goes to standard output, and to standard error what
 * was asked, the status, and whether the answer has the recorded digest.
 *
 * Returns the exit status: 0 where status and digest are the recorded ones, 1 where they are not,
 * or no answer was recorded, or the answer cannot be written; 2 where the file cannot be read or is
 * damaged.
 */
int srv_replay(const char *path);

#endif

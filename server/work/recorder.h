/* Files of the requests that reach an operation, for bug reports: option `--record DIR`.
 * Leaves to others: the format of a file (recording), computing an answer again (replay).
 * Invariant: at most SRV_RECORDER_FILES files of SRV_RECORDER_BYTES together; a file's name is a
 * number, and no byte of a request is part of it. */
#ifndef SRV_RECORDER_H
#define SRV_RECORDER_H

#include "server/work/exchange.h"
#include "server/work/recording.h"

enum {
    SRV_RECORDER_FILES = 1000,     /* that are in the directory when the recorder stops */
    SRV_RECORDER_BYTES = 256 << 20 /* the same, all files together */
};

struct srv_recorder;

/* One request whose answer is being computed. One thread at a time. */
struct srv_record;

/**
 * Opens the directory, and makes it where it is missing.
 *
 * directory  a file of it that is there already stays, and counts against the bounds.
 *
 * PEND_INVALID  it is no directory, or cannot be written; error says so.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_recorder_new(struct srv_recorder **recorder,
                                                  const char *directory, struct pend_error *error);

/** Frees a recorder; every record must have ended. NULL is accepted. */
void srv_recorder_free(struct srv_recorder **recorder);

/** True when the recorder's counts agree with its bounds; for assertions, under its lock. O(1). */
int srv_recorder_valid(const struct srv_recorder *recorder);

/**
 * Writes a request into a file of its own, mode 0600, before its answer is computed: so the file is
 * there even where the computation kills the process.
 *
 * exchange  its head and body are written, but of the header fields only those that say nothing of
 *           who asks: no Authorization, Cookie or client's key.
 * request   as api_call_open gets it.
 * limits    as api_call_new gets them.
 *
 * Returns NULL where the bounds are reached or the file cannot be written, which the log says once.
 * Writes to a disk: only for workers.
 */
struct srv_record *srv_recorder_begin(struct srv_recorder *recorder,
                                      const struct srv_exchange *exchange,
                                      const struct api_request *request,
                                      const struct api_limits *limits);

/** Adds bytes of the answer. A record that is NULL is left alone, here and below. */
void srv_record_add(struct srv_record *record, const void *data, size_t bytes);

/** Says that the answer is sent while it is computed. */
void srv_record_streams(struct srv_record *record);

/** Writes the status and the digest of what was added, and ends the record. `broken` = the
 * computation has failed after the head was sent. */
void srv_record_answer(struct srv_record **record, int status, int broken);

/** Removes the file and ends the record: the answer was there already. */
void srv_record_remove(struct srv_record **record);

/** Ends the record; its file says nothing of the answer. Writes nothing. */
void srv_record_end(struct srv_record **record);

#endif

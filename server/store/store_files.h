/* Files of results: the rows of a part as a Parquet file in a folder that processes share.
 * Leaves to others: the file's bytes (api/call/part), its record in the store (store_blobs), when
 * files are deleted (store_sweep).
 * Invariant: a file appears whole, under a name with its digest, so that writing it twice is
 * harmless. All functions may wait for a disk or a network: only threads of the storage call them.
 */
#pragma once

#include <dirent.h>
#include <stdatomic.h>

#include "server/base/log.h"
#include "server/store/store.h"

enum { SRV_FILES_URL = 256, SRV_FILES_LINK = 1024 };

struct srv_files {
    char url[SRV_FILES_URL]; /* file:///PATH, an existing folder */
    struct srv_log *log;     /* logs when the folder becomes unreachable, and when it is back */
    atomic_int away;
    DIR *walk;       /* the round over all folders; NULL = none */
    int64_t walk_ns; /* start of the next round */
};

/** Checks files->url. PEND_INVALID */
PEND_MUST_CHECK enum pend_status srv_files_check(const struct srv_files *files,
                                                 struct pend_error *error);

/** Writes the file of a part. SRV_STORED_FULL; SRV_STORED_AWAY, SRV_STORED_AGAIN: try again.
 * O(bytes) */
enum srv_stored srv_files_put(struct srv_files *files, const char *job, long part,
                              const struct api_raw_file *file, const void *data);

/** Reads the file of a part and appends its rows as raw records. SRV_STORED_NONE: it is lost;
 * SRV_STORED_DAMAGED: its bytes have changed; SRV_STORED_AWAY, SRV_STORED_BROKEN. O(bytes) */
enum srv_stored srv_files_get(struct srv_files *files, const char *job, long part,
                              const struct api_raw_file *file, struct api_buffer *out);

/** Deletes a job's files. SRV_STORED_AGAIN: some remain; SRV_STORED_AWAY */
enum srv_stored srv_files_drop(struct srv_files *files, const char *job);

/** Finds the next folder of a job in which nothing was written for `seconds`. Each call examines
 * some folders of a round, which begins every hour. Returns 0 if there is none now. Called by one
 * thread. */
int srv_files_old(struct srv_files *files, int64_t seconds, char job[SRV_ID_BYTES]);

/** Writes a link for other programs to the file of a part, or with NULL to all files of the job. */
void srv_files_link(const struct srv_files *files, const char *job, long part,
                    const struct api_raw_file *file, char link[SRV_FILES_LINK]);

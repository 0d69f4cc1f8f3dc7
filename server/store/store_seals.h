/* Seals: checksums that show whether a row came back from the database as it was written, and from
 * the place that it was written to.
 * Leaves to others: the rows themselves (store_rows), and the treatment of a damaged one.
 * Invariant: every row of a job, a chunk of results, a scene or an item of a room has a seal. No
 * secret goes into a seal: it detects accidents and exchanged rows, not a forger who can write
 * to the database. */
#ifndef SRV_STORE_SEALS_H
#define SRV_STORE_SEALS_H

#include "api/call/digest.h"
#include "server/store/store.h"

/* of a job's row: the seal of its request, then the seal of that with all of the row that never
 * changes */
enum { SRV_SEAL_JOB_BYTES = 2 * API_SEAL_BYTES };

/** Makes the seal of a job's row from its id, client, operation, parts, chained, created, title
 * and version, and from its request. O(bytes). */
void srv_seal_job(unsigned char seal[SRV_SEAL_JOB_BYTES], const struct srv_job *job,
                  const void *request, size_t bytes);

/** Returns whether a job's row is what was written, but for its request. O(1). */
int srv_seal_job_whole(const struct srv_job *job, const struct srv_value *seal);

/** Returns whether a job's request is what was written; `seal` is that of the row. O(bytes). */
int srv_seal_request_whole(const struct srv_value *seal, const void *request, size_t bytes);

/** Makes the seal of a chunk of results: of its bytes, its job, its part and its number in that.
 * O(bytes). */
void srv_seal_chunk(unsigned char seal[API_SEAL_BYTES], const char *job, long part, long chunk,
                    const void *data, size_t bytes);

/** Returns whether a chunk is what was written for this place. O(bytes). */
int srv_seal_chunk_whole(const struct srv_value *seal, const char *job, long part, long chunk,
                         const void *data, size_t bytes);

/** Makes the seal of a scene: of its id and its body. O(bytes). */
void srv_seal_scene(unsigned char seal[API_SEAL_BYTES], const char *id, const void *body,
                    size_t bytes);

/** Returns whether a scene is what was written. O(bytes). */
int srv_seal_scene_whole(const struct srv_value *seal, const char *id, const void *body,
                         size_t bytes);

/** Makes the seal of an item of a room: of the room's code, the item's name, who may read it, the
 * change that wrote it, its flag and its body. O(bytes). */
void srv_seal_item(unsigned char seal[API_SEAL_BYTES], const char *code, const char *name,
                   const int64_t number[3], const void *body, size_t bytes);

/** Returns whether an item is what was written. O(bytes). */
int srv_seal_item_whole(const struct srv_value *seal, const char *code, const char *name,
                        const int64_t number[3], const void *body, size_t bytes);

#endif

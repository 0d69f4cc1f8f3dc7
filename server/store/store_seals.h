/* Seals: checksums of rows and their positions, which show whether a row is unchanged.
 * Leaves to others: the rows (store_rows), and the treatment of damaged ones.
 * Invariant: every job, chunk of results, scene and room item has a seal. A seal has no secret: it
 * detects accidents and exchanged rows, not an attacker who can write to the database. */
#pragma once

#include "api/call/digest.h"
#include "server/store/store.h"

/* the seal of a job's row: the seal of its request, then that of all constant columns */
enum { SRV_SEAL_JOB_BYTES = 2 * API_SEAL_BYTES };

/** Computes the seal of a job's row from its id, client, operation, parts, chained, created, title
 * and version, and its request. O(bytes). */
void srv_seal_job(unsigned char seal[SRV_SEAL_JOB_BYTES], const struct srv_job *job,
                  const void *request, size_t bytes);

/** Returns non-zero if a job's row, without its request, is unchanged. O(1). */
int srv_seal_job_whole(const struct srv_job *job, const struct srv_value *seal);

/** Returns non-zero if a job's request is unchanged; `seal` is that of the row. O(bytes). */
int srv_seal_request_whole(const struct srv_value *seal, const void *request, size_t bytes);

/** Computes the seal of a chunk of results from its bytes, job, part and index. O(bytes). */
void srv_seal_chunk(unsigned char seal[API_SEAL_BYTES], const char *job, long part, long chunk,
                    const void *data, size_t bytes);

/** Returns non-zero if a chunk is unchanged and in its place. O(bytes). */
int srv_seal_chunk_whole(const struct srv_value *seal, const char *job, long part, long chunk,
                         const void *data, size_t bytes);

/** Computes the seal of a scene from its id and body. O(bytes). */
void srv_seal_scene(unsigned char seal[API_SEAL_BYTES], const char *id, const void *body,
                    size_t bytes);

/** Returns non-zero if a scene is unchanged. O(bytes). */
int srv_seal_scene_whole(const struct srv_value *seal, const char *id, const void *body,
                         size_t bytes);

/** Computes the seal of a room item from the room's code, the item's name, its readers, its change
 * number, flag and body. O(bytes). */
void srv_seal_item(unsigned char seal[API_SEAL_BYTES], const char *code, const char *name,
                   const int64_t number[3], const void *body, size_t bytes);

/** Returns non-zero if an item is unchanged. O(bytes). */
int srv_seal_item_whole(const struct srv_value *seal, const char *code, const char *name,
                        const int64_t number[3], const void *body, size_t bytes);

#include "server/store/store_rows.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static int seal_equals(const struct srv_value *field, const unsigned char *want, size_t bytes) {
    return field->kind == SRV_SQL_BYTES && field->bytes == bytes &&
           !memcmp(field->data, want, bytes);
}

/* --- jobs --- */

/* computes the seal of the row from that of the request */
static void seal_row(unsigned char seal[API_SEAL_BYTES], const struct srv_job *job,
                     const unsigned char request[API_SEAL_BYTES]) {
    char place[SRV_ID_BYTES + 2 * SRV_NAME_BYTES + SRV_TITLE_BYTES + SRV_VERSION_BYTES + 64];
    snprintf(place, sizeof place, "job %s of %s: %s in %ld%s by %s: %s", job->id, job->client,
             job->operation, job->parts, job->chained ? " chained" : "", job->version, job->title);
    api_seal(seal, place, (long)job->created, request, API_SEAL_BYTES);
}

void srv_seal_job(unsigned char seal[SRV_SEAL_JOB_BYTES], const struct srv_job *job,
                  const void *request, size_t bytes) {
    assert(job->parts >= 1 && job->created > 0 && (request || !bytes));
    api_seal(seal, "request", 0, request, bytes);
    seal_row(seal + API_SEAL_BYTES, job, seal);
}

int srv_seal_job_whole(const struct srv_job *job, const struct srv_value *seal) {
    unsigned char want[SRV_SEAL_JOB_BYTES];
    if (seal->kind != SRV_SQL_BYTES || seal->bytes != sizeof want) return 0;
    memcpy(want, seal->data, API_SEAL_BYTES);
    seal_row(want + API_SEAL_BYTES, job, want);
    return seal_equals(seal, want, sizeof want);
}

int srv_seal_request_whole(const struct srv_value *seal, const void *request, size_t bytes) {
    unsigned char want[API_SEAL_BYTES];
    if (seal->kind != SRV_SQL_BYTES || seal->bytes != SRV_SEAL_JOB_BYTES) return 0;
    api_seal(want, "request", 0, request, bytes);
    return !memcmp(seal->data, want, sizeof want);
}

/* --- chunks of results --- */

void srv_seal_chunk(unsigned char seal[API_SEAL_BYTES], const char *job, long part, long chunk,
                    const void *data, size_t bytes) {
    assert(part >= 0 && chunk >= 0 && bytes <= SRV_CHUNK_BYTES);
    char place[SRV_ID_BYTES + 64];
    snprintf(place, sizeof place, "results of job %s, part %ld", job, part);
    api_seal(seal, place, chunk, data, bytes);
}

int srv_seal_chunk_whole(const struct srv_value *seal, const char *job, long part, long chunk,
                         const void *data, size_t bytes) {
    unsigned char want[API_SEAL_BYTES];
    srv_seal_chunk(want, job, part, chunk, data, bytes);
    return seal_equals(seal, want, sizeof want);
}

/* --- scenes --- */

void srv_seal_scene(unsigned char seal[API_SEAL_BYTES], const char *id, const void *body,
                    size_t bytes) {
    char place[SRV_ID_BYTES + 16];
    snprintf(place, sizeof place, "scene %.*s", SRV_ID_BYTES, id);
    api_seal(seal, place, 0, body, bytes);
}

int srv_seal_scene_whole(const struct srv_value *seal, const char *id, const void *body,
                         size_t bytes) {
    unsigned char want[API_SEAL_BYTES];
    srv_seal_scene(want, id, body, bytes);
    return seal_equals(seal, want, sizeof want);
}

/* --- items of rooms --- */

void srv_seal_item(unsigned char seal[API_SEAL_BYTES], const char *code, const char *name,
                   const int64_t number[3], const void *body, size_t bytes) {
    char place[256];
    assert(body || !bytes);
    snprintf(place, sizeof place, "item %.100s of room %.16s, %lld %lld", name, code,
             (long long)number[1], (long long)number[2]);
    api_seal(seal, place, (long)number[0], body ? body : "", bytes);
}

int srv_seal_item_whole(const struct srv_value *seal, const char *code, const char *name,
                        const int64_t number[3], const void *body, size_t bytes) {
    unsigned char want[API_SEAL_BYTES];
    srv_seal_item(want, code, name, number, body, bytes);
    return seal_equals(seal, want, sizeof want);
}

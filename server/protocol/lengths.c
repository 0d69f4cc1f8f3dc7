#include "server/protocol/lengths.h"

#include <stdio.h>
#include <string.h>

#include "server/base/hash_table.h"

void srv_lengths_init(struct srv_lengths *lengths) {
    memset(lengths, 0, sizeof *lengths);
    pthread_mutex_init(&lengths->lock, NULL);
}

void srv_lengths_clear(struct srv_lengths *lengths) { pthread_mutex_destroy(&lengths->lock); }

/* the row of a tag: digests need no salt, because clients cannot choose them */
static size_t lengths_row(const char *etag) {
    return srv_hash_bytes(1, etag, strlen(etag)) % SRV_LENGTHS;
}

void srv_lengths_note(struct srv_lengths *lengths, const char *etag, long long bytes) {
    assert(strlen(etag) < SRV_ETAG_BYTES);
    size_t row = lengths_row(etag);
    if (!*etag || bytes < 0) return;
    pthread_mutex_lock(&lengths->lock);
    snprintf(lengths->row[row].etag, sizeof lengths->row[row].etag, "%s", etag);
    lengths->row[row].bytes = bytes;
    pthread_mutex_unlock(&lengths->lock);
}

long long srv_lengths_find(struct srv_lengths *lengths, const char *etag) {
    size_t row = lengths_row(etag);
    pthread_mutex_lock(&lengths->lock);
    long long bytes = *etag && !strcmp(lengths->row[row].etag, etag) ? lengths->row[row].bytes : -1;
    pthread_mutex_unlock(&lengths->lock);
    return bytes;
}

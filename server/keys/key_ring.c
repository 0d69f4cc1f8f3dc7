#include "server/keys/key_ring.h"

#include <assert.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/keys/key_file.h"

struct srv_key_ring {
    pthread_mutex_t lock; /* guards keys */
    struct srv_keys keys;
    struct stat seen; /* the state of the file at the last check */
    int missing;      /* the file did not exist */
    char path[];
};

enum pend_status srv_key_ring_new(struct srv_key_ring **ring, const char *path,
                                  struct pend_error *error) {
    size_t bytes = strlen(path) + 1;
    struct srv_key_ring *made = calloc(1, sizeof *made + bytes);
    *ring = NULL;
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    memcpy(made->path, path, bytes);
    srv_keys_init(&made->keys);
    pthread_mutex_init(&made->lock, NULL);
    *ring = made;
    enum pend_status status = srv_key_file_read(path, &made->keys, &made->seen, error);
    if (status != PEND_OK) srv_key_ring_free(ring);
    return status;
}

void srv_key_ring_free(struct srv_key_ring **ring) {
    struct srv_key_ring *gone = *ring;
    *ring = NULL;
    if (!gone) return;
    pthread_mutex_destroy(&gone->lock);
    srv_keys_clear(&gone->keys);
    free(gone);
}

/* Returns 1 if the file is unchanged. Replacing it or writing to it changes these numbers; after
 * two changes within one tick of the file system's clock the inode differs. */
static int ring_same(const struct stat *one, const struct stat *other) {
    return one->st_ino == other->st_ino && one->st_dev == other->st_dev &&
           one->st_size == other->st_size && one->st_mode == other->st_mode &&
           one->st_uid == other->st_uid && one->st_ctim.tv_sec == other->st_ctim.tv_sec &&
           one->st_ctim.tv_nsec == other->st_ctim.tv_nsec;
}

void srv_key_ring_look(struct srv_key_ring *ring, struct srv_log *log) {
    struct stat file;
    struct srv_keys keys;
    struct pend_error error = {.text = ""};
    int missing = stat(ring->path, &file) != 0;
    if (missing ? ring->missing : !ring->missing && ring_same(&file, &ring->seen)) return;
    ring->missing = missing;
    if (!missing) ring->seen = file;
    srv_keys_init(&keys);
    if (srv_key_file_read(ring->path, &keys, NULL, &error) != PEND_OK) {
        srv_log_message(log, "keys: the previous keys stay valid: %s", error.text);
        srv_log_audit_entry(log, &(struct srv_log_audit_entry){.id = "",
                                                               .who = "operator",
                                                               .role = "",
                                                               .what = "keys in force",
                                                               .outcome = "failed"});
        srv_keys_clear(&keys);
        return;
    }
    pthread_mutex_lock(&ring->lock);
    struct srv_keys old = ring->keys;
    ring->keys = keys;
    pthread_mutex_unlock(&ring->lock);
    srv_log_message(log, keys.count == 1 ? "keys: %d key is valid" : "keys: %d keys are valid",
                    keys.count);
    char count[16];
    snprintf(count, sizeof count, "%d", keys.count);
    srv_log_audit_entry(log, &(struct srv_log_audit_entry){.id = "",
                                                           .who = "operator",
                                                           .role = "",
                                                           .what = "keys in force",
                                                           .of = count,
                                                           .outcome = "done"});
    srv_keys_clear(&old);
}

static enum srv_key_verdict ring_judge(const struct srv_key *key, int64_t now) {
    if (!key) return SRV_KEY_UNKNOWN;
    if (key->revoked && key->revoked <= now) return SRV_KEY_REVOKED;
    return key->expires && key->expires <= now ? SRV_KEY_EXPIRED : SRV_KEY_GOOD;
}

int srv_key_ring_holds(struct srv_key_ring *ring, const char digest[API_DIGEST_BYTES],
                       int64_t now) {
    pthread_mutex_lock(&ring->lock);
    enum srv_key_verdict verdict = ring_judge(srv_keys_find(&ring->keys, digest), now);
    pthread_mutex_unlock(&ring->lock);
    return verdict == SRV_KEY_GOOD;
}

struct srv_key_found srv_key_ring_find(struct srv_key_ring *ring, const char *token, int64_t now) {
    struct srv_key_found found = {.verdict = SRV_KEY_BROKEN};
    assert(srv_keys_meant(token));
    if (!srv_keys_whole(token)) return found;
    srv_keys_digest(token, found.digest);
    pthread_mutex_lock(&ring->lock);
    const struct srv_key *key = srv_keys_find(&ring->keys, found.digest);
    found.verdict = ring_judge(key, now);
    if (key) {
        found.when = found.verdict == SRV_KEY_REVOKED ? key->revoked : key->expires;
        found.role = key->role;
        found.limits = srv_keys_limits(&ring->keys, key);
        memcpy(found.name, key->name, sizeof found.name);
    }
    pthread_mutex_unlock(&ring->lock);
    return found;
}

struct srv_limits srv_key_ring_role(struct srv_key_ring *ring, enum srv_role role) {
    pthread_mutex_lock(&ring->lock);
    struct srv_limits limits = srv_keys_role(&ring->keys, role);
    pthread_mutex_unlock(&ring->lock);
    return limits;
}

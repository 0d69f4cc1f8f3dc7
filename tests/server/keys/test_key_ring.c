/* Tests of server/keys/key_ring: the active keys, and reloading their file. */
#include "server/keys/key_ring.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/keys/key_file.h"
#include "tests/harness/test.h"

/* A file with four keys, and its ring. */
struct rig {
    char directory[64], path[96], good[SRV_KEY_TOKEN], expired[SRV_KEY_TOKEN],
        revoked[SRV_KEY_TOKEN], other[SRV_KEY_TOKEN];
    struct srv_key_ring *ring;
    struct srv_log *log;
};

static enum pend_status put(struct srv_keys *keys, const char *name, char token[SRV_KEY_TOKEN],
                            int64_t expires, int64_t revoked) {
    struct srv_key key = {
        .role = SRV_ROLE_TEACHER, .made = 1, .expires = expires, .revoked = revoked};
    if (!srv_keys_draw(token)) return PEND_INVALID;
    snprintf(key.name, sizeof key.name, "%s", name);
    srv_keys_digest(token, key.digest);
    srv_limits_unset(&key.limits);
    return srv_keys_add(keys, &key, NULL);
}

static enum pend_status fill(struct srv_keys *keys, void *context, struct pend_error *error) {
    struct rig *rig = context;
    (void)error;
    PEND_TRY(put(keys, "good", rig->good, 5000, 0));
    PEND_TRY(put(keys, "expired", rig->expired, 900, 0));
    return put(keys, "revoked", rig->revoked, 900, 800);
}

static enum pend_status more(struct srv_keys *keys, void *context, struct pend_error *error) {
    struct rig *rig = context;
    (void)error;
    keys->role[SRV_ROLE_PUPIL].value[SRV_LIMIT_JOBS] = 7;
    return put(keys, "other", rig->other, 0, 0);
}

static int rig_begin(struct rig *rig) {
    *rig = (struct rig){.directory = "/tmp/pendulumd-test-XXXXXX"};
    if (!CHECK(mkdtemp(rig->directory) != NULL)) return 0;
    snprintf(rig->path, sizeof rig->path, "%s/keys", rig->directory);
    return CHECK(srv_key_file_change(rig->path, 1, fill, rig, NULL) == PEND_OK) &&
           CHECK(srv_key_ring_new(&rig->ring, rig->path, NULL) == PEND_OK) &&
           CHECK(srv_log_new(&rig->log, -1, dup(STDERR_FILENO)) == PEND_OK);
}

static void rig_end(struct rig *rig) {
    srv_log_free(&rig->log);
    srv_key_ring_free(&rig->ring);
    unlink(rig->path);
    CHECK_INT(rmdir(rig->directory), 0);
}

static int verdict(struct rig *rig, const char *token, int64_t now) {
    return srv_key_ring_find(rig->ring, token, now).verdict;
}

TEST(each_key_has_its_verdict) {
    OWN(rig, end) rig;
    char none[SRV_KEY_TOKEN];
    REQUIRE(rig_begin(&rig) && srv_keys_draw(none));
    struct srv_key_found found = srv_key_ring_find(rig.ring, rig.good, 4999);
    CHECK_INT(found.verdict, SRV_KEY_GOOD);
    CHECK_TEXT(found.name, "good");
    CHECK_INT(found.role, SRV_ROLE_TEACHER);
    CHECK(found.limits.value[SRV_LIMIT_JOBS] == 100);
    CHECK_INT(verdict(&rig, rig.good, 5000), SRV_KEY_EXPIRED);
    found = srv_key_ring_find(rig.ring, rig.expired, 1000);
    CHECK(found.verdict == SRV_KEY_EXPIRED && found.when == 900);
    CHECK_INT(verdict(&rig, rig.expired, 899), SRV_KEY_GOOD);
    /* a revoked key is reported as revoked, also once it would have expired */
    found = srv_key_ring_find(rig.ring, rig.revoked, 1000);
    CHECK(found.verdict == SRV_KEY_REVOKED && found.when == 800);
    found = srv_key_ring_find(rig.ring, none, 1000);
    CHECK(found.verdict == SRV_KEY_UNKNOWN && !found.name[0]);
    none[10] ^= 1;
    CHECK_INT(verdict(&rig, none, 1000), SRV_KEY_BROKEN);
    CHECK_INT(verdict(&rig, "pdk_", 1000), SRV_KEY_BROKEN);
}

TEST(a_file_that_changes_is_in_force_and_one_that_is_wrong_is_not) {
    OWN(rig, end) rig;
    REQUIRE(rig_begin(&rig));
    srv_key_ring_look(rig.ring, rig.log);
    CHECK_INT(verdict(&rig, rig.good, 1000), SRV_KEY_GOOD);
    REQUIRE(srv_key_file_change(rig.path, 0, more, &rig, NULL) == PEND_OK);
    CHECK_INT(verdict(&rig, rig.other, 1000), SRV_KEY_UNKNOWN);
    CHECK(srv_key_ring_role(rig.ring, SRV_ROLE_PUPIL).value[SRV_LIMIT_JOBS] == 0);
    srv_key_ring_look(rig.ring, rig.log);
    CHECK_INT(verdict(&rig, rig.other, 1000), SRV_KEY_GOOD);
    CHECK(srv_key_ring_role(rig.ring, SRV_ROLE_PUPIL).value[SRV_LIMIT_JOBS] == 7);
    /* readable by others, malformed, missing: the previous keys stay active */
    CHECK(!chmod(rig.path, 0644));
    srv_key_ring_look(rig.ring, rig.log);
    CHECK_INT(verdict(&rig, rig.other, 1000), SRV_KEY_GOOD);
    FILE *file = fopen(rig.path, "w");
    REQUIRE(file != NULL);
    fputs("nonsense\n", file);
    fclose(file);
    CHECK(!chmod(rig.path, 0600));
    srv_key_ring_look(rig.ring, rig.log);
    CHECK_INT(verdict(&rig, rig.other, 1000), SRV_KEY_GOOD);
    CHECK(!unlink(rig.path));
    srv_key_ring_look(rig.ring, rig.log);
    CHECK_INT(verdict(&rig, rig.good, 1000), SRV_KEY_GOOD);
    /* restored */
    REQUIRE(srv_key_file_change(rig.path, 1, more, &rig, NULL) == PEND_OK);
    srv_key_ring_look(rig.ring, rig.log);
    CHECK_INT(verdict(&rig, rig.good, 1000), SRV_KEY_UNKNOWN);
    CHECK_INT(verdict(&rig, rig.other, 1000), SRV_KEY_GOOD);
}

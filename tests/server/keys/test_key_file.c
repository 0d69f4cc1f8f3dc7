/* Tests of server/keys/key_file: reading, and atomic replacement. */
#include "server/keys/key_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/harness/test.h"

static char directory[64], path[96];

static int begin(void) {
    snprintf(directory, sizeof directory, "/tmp/pendulumd-test-XXXXXX");
    if (!CHECK(mkdtemp(directory) != NULL)) return 0;
    snprintf(path, sizeof path, "%s/keys", directory);
    return 1;
}

static void end(void) {
    char fresh[128];
    snprintf(fresh, sizeof fresh, "%s.new", path);
    unlink(fresh);
    unlink(path);
    CHECK_INT(rmdir(directory), 0);
}

/* adds a key whose name is the context */
static enum pend_status add(struct srv_keys *keys, void *context, struct pend_error *error) {
    char token[SRV_KEY_TOKEN];
    struct srv_key key = {.role = SRV_ROLE_PUPIL, .made = 1};
    if (!srv_keys_draw(token)) return PEND_INVALID;
    snprintf(key.name, sizeof key.name, "%s", (const char *)context);
    srv_keys_digest(token, key.digest);
    srv_limits_unset(&key.limits);
    return srv_keys_add(keys, &key, error);
}

static int count(void) {
    OWN(srv_keys, clear) keys;
    struct pend_error error = {.text = ""};
    srv_keys_init(&keys);
    enum pend_status status = srv_key_file_read(path, &keys, NULL, &error);
    return status == PEND_OK ? keys.count : -1;
}

TEST(a_change_makes_a_file_that_nobody_else_reads) {
    struct stat file;
    struct pend_error error = {.text = ""};
    REQUIRE(begin());
    CHECK_INT(srv_key_file_change(path, 0, add, "one", &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "No such file") != NULL, "%s", error.text);
    mode_t mask = umask(0);
    CHECK_INT(srv_key_file_change(path, 1, add, "one", &error), PEND_OK);
    CHECK_INT(srv_key_file_change(path, 1, add, "two", &error), PEND_OK);
    umask(mask);
    CHECK(!stat(path, &file) && (file.st_mode & 07777) == 0600);
    CHECK_INT(count(), 2);
    /* a refused change, and a change that was interrupted, leave the file unchanged */
    CHECK_INT(srv_key_file_change(path, 0, add, "no name", &error), PEND_INVALID);
    char fresh[128];
    snprintf(fresh, sizeof fresh, "%s.new", path);
    int left = open(fresh, O_WRONLY | O_CREAT, 0600);
    REQUIRE(left >= 0);
    CHECK(write(left, "key", 3) == 3);
    close(left);
    CHECK_INT(count(), 2);
    CHECK_INT(srv_key_file_change(path, 0, add, "three", &error), PEND_OK);
    CHECK(access(fresh, F_OK) != 0);
    CHECK_INT(count(), 3);
    end();
}

TEST(keys_that_others_can_read_are_refused) {
    struct pend_error error = {.text = ""};
    REQUIRE(begin());
    CHECK_INT(srv_key_file_change(path, 1, add, "one", &error), PEND_OK);
    CHECK(!chmod(path, 0640));
    CHECK_INT(count(), -1);
    CHECK_INT(srv_key_file_change(path, 0, add, "two", &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "0640") && strstr(error.text, "0600"), "%s", error.text);
    CHECK(!chmod(path, 0400));
    CHECK_INT(count(), 1);
    end();
}

TEST(root_makes_keys_for_the_user_whose_directory_it_is) {
    struct pend_error error = {.text = ""};
    struct stat file;
    /* without root the owner is the user itself */
    uid_t owner = geteuid() ? geteuid() : 65534;
    gid_t group = geteuid() ? getegid() : 65534;
    REQUIRE(begin());
    CHECK(!chown(directory, owner, group));
    for (int i = 0; i < 2; i++) {
        CHECK_INT(srv_key_file_change(path, 1, add, "one", &error), PEND_OK);
        CHECK(!stat(path, &file) && file.st_uid == owner && file.st_gid == group);
        CHECK_INT(file.st_mode & 07777, 0600);
        CHECK_INT(count(), i + 1);
    }
    end();
}

/* replaces the file's directory by another one, after the file was read */
static enum pend_status add_and_move(struct srv_keys *keys, void *context,
                                     struct pend_error *error) {
    char aside[80];
    snprintf(aside, sizeof aside, "%s.aside", directory);
    CHECK(!rename(directory, aside) && !mkdir(directory, 0700));
    return add(keys, context, error);
}

TEST(a_change_stays_in_the_directory_that_it_began_in) {
    struct pend_error error = {.text = ""};
    struct stat file;
    char aside[80];
    for (int old = 0; old < 2; old++) {
        REQUIRE(begin());
        snprintf(aside, sizeof aside, "%s.aside", directory);
        if (old) CHECK_INT(srv_key_file_change(path, 1, add, "one", &error), PEND_OK);
        CHECK_INT(srv_key_file_change(path, 1, add_and_move, "two", &error), PEND_OK);
        CHECK(stat(path, &file) != 0);
        CHECK(!rmdir(directory) && !rename(aside, directory));
        CHECK_INT(count(), old + 1);
        end();
    }
}

TEST(changes_of_many_programs_at_once_are_all_there) {
    enum { PROGRAMS = 4, CHANGES = 10 };
    pid_t child[PROGRAMS];
    REQUIRE(begin());
    for (int i = 0; i < PROGRAMS; i++) {
        child[i] = fork();
        if (child[i]) continue;
        int bad = 0;
        for (int k = 0; k < CHANGES; k++)
            bad |= srv_key_file_change(path, 1, add, "many", NULL) != PEND_OK;
        _exit(bad);
    }
    for (int i = 0; i < PROGRAMS; i++) {
        int status = -1;
        CHECK(child[i] > 0 && waitpid(child[i], &status, 0) == child[i] && !status);
    }
    CHECK_INT(count(), PROGRAMS * CHANGES);
    end();
}

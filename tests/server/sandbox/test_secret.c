/* Tests of server/sandbox/secret: files that other users cannot read. */
#include "server/sandbox/secret.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/harness/test.h"

static enum pend_status reads(const char *path, size_t limit, struct pend_error *error) {
    OWN(api_buffer, clear) out;
    struct stat seen;
    api_buffer_init(&out, limit);
    enum pend_status status = srv_secret_read(path, &out, &seen, error);
    if (status == PEND_OK) CHECK(out.bytes == 6 && !memcmp(out.data, "secret", 6));
    if (status == PEND_OK) CHECK(seen.st_size == 6);
    return status;
}

TEST(a_secret_is_read_from_a_file_of_this_user_alone) {
    static const mode_t good[] = {0600, 0400, 0700}, bad[] = {0640, 0604, 0620, 0666, 0610};
    char path[] = "/tmp/pendulumd-test-XXXXXX";
    struct pend_error error = {.text = ""};
    int fd = mkstemp(path);
    REQUIRE(fd >= 0);
    CHECK(write(fd, "secret", 6) == 6);
    close(fd);
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        CHECK(!chmod(path, good[i]));
        CHECK_INT(reads(path, 100, &error), PEND_OK);
    }
    CHECK_INT(reads(path, 5, &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "longer") != NULL, "%s", error.text);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        CHECK(!chmod(path, bad[i]));
        CHECK_INT(reads(path, 100, &error), PEND_INVALID);
        CHECK_SAYING(strstr(error.text, "must have 0600") != NULL, "%s", error.text);
    }
    unlink(path);
    CHECK_INT(reads(path, 100, &error), PEND_INVALID);
    CHECK_INT(reads("/tmp", 100, &error), PEND_INVALID);
    CHECK_INT(reads("/dev/null", 100, &error), PEND_INVALID);
}

/* Tests of server/hooks/hook_keys: files of secrets, and whose signatures they make. */
#include "server/hooks/hook_keys.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/harness/test.h"

static enum pend_status keys_of(struct srv_hook_keys *keys, const char *text, int mode) {
    char path[] = "/tmp/pendulumd-test-XXXXXX";
    struct pend_error error = {.text = ""};
    int fd = mkstemp(path);
    CHECK(fd >= 0 && write(fd, text, strlen(text)) == (ssize_t)strlen(text));
    CHECK(!fchmod(fd, (mode_t)mode) && !close(fd));
    enum pend_status status = srv_hook_keys_read(keys, path, &error);
    CHECK((status == PEND_OK) == !error.text[0]);
    unlink(path);
    return status;
}

#define ONE "an-operators-secret-of-0123456789"
#define TWO "another-one-that-is-from-0123456789"

TEST(a_file_has_one_secret_or_two_and_nobody_else_reads_it) {
    static const char *const bad[] = {"", "\n\n", "short\n", ONE "\n" TWO "\n" ONE "\n",
                                      "an operator's secret with blanks 0123456789\n"};
    struct srv_hook_keys keys;
    CHECK(keys_of(&keys, ONE "\n", 0600) == PEND_OK && keys.count == 1);
    CHECK(keys_of(&keys, ONE "\r\n\n" TWO, 0600) == PEND_OK && keys.count == 2);
    CHECK_TEXT(keys.secret[0], ONE);
    CHECK_TEXT(keys.secret[1], TWO);
    CHECK(keys_of(&keys, ONE "\n", 0644) == PEND_INVALID);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_SAYING(keys_of(&keys, bad[i], 0600) == PEND_INVALID, "%s", bad[i]);
}

TEST(each_client_has_a_key_of_its_own_and_two_secrets_sign_twice) {
    struct srv_hook_keys keys, old;
    char anna[API_WEBHOOK_SECRET], bert[API_WEBHOOK_SECRET];
    char both[SRV_HOOK_SIGNATURES], before[SRV_HOOK_SIGNATURES], other[SRV_HOOK_SIGNATURES];
    REQUIRE(keys_of(&keys, ONE "\n" TWO "\n", 0600) == PEND_OK);
    REQUIRE(keys_of(&old, TWO "\n", 0600) == PEND_OK);
    srv_hook_keys_secret(&keys, "t:anna", anna);
    srv_hook_keys_secret(&keys, "t:bert", bert);
    CHECK(strcmp(anna, bert) != 0);
    srv_hook_keys_sign(&keys, "t:anna", "msg_1", "1", "{}", 2, both);
    srv_hook_keys_sign(&old, "t:anna", "msg_1", "1", "{}", 2, before);
    srv_hook_keys_sign(&old, "t:bert", "msg_1", "1", "{}", 2, other);
    const char *second = strchr(both, ' ');
    REQUIRE(second);
    CHECK_TEXT(second + 1, before);
    CHECK(strncmp(both, before, strlen(before)) != 0 && strcmp(other, before) != 0);
}

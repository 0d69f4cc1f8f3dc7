/* Tests of server/hooks/hook_files: what a process that is kept to them can read, and what not. */
#include "server/hooks/hook_files.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/sandbox/privileges.h"
#include "tests/harness/test.h"

enum { NO_FENCE = 77 };

/* errno of opening a file for reading, 0 where that goes */
static int opens(const char *path) {
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd >= 0) close(fd);
    return fd < 0 ? errno : 0;
}

/* in a process of its own, behind the fence: how many files of the second list it can read, and of
 * the first cannot */
static int behind(const char *authority, const char *const may[], const char *const may_not[]) {
    struct pend_error error;
    static struct srv_fence fence;
    int wrong = 0;
    srv_hook_files(&fence, authority);
    if (srv_privileges_drop(&error) != PEND_OK || srv_fence_close(&fence, &error) != PEND_OK)
        return NO_FENCE;
    for (int i = 0; may[i]; i++) {
        int reason = opens(may[i]);
        wrong += reason != 0 && reason != ENOENT;
    }
    for (int i = 0; may_not[i]; i++) wrong += opens(may_not[i]) != EACCES;
    return wrong;
}

TEST(the_process_of_a_message_reads_what_names_and_certificates_need_and_no_secret) {
    char directory[] = "/tmp/pendulumd-hook-files-XXXXXX", authority[80], secret[80];
    REQUIRE(mkdtemp(directory) != NULL);
    snprintf(authority, sizeof authority, "%s/ca.pem", directory);
    snprintf(secret, sizeof secret, "%s/webhooks", directory);
    FILE *one = fopen(authority, "w"), *other = fopen(secret, "w");
    CHECK(one && other && !fclose(one) && !fclose(other));
    const char *const may[] = {"/etc/hosts",
                               "/etc/nsswitch.conf",
                               "/etc/resolv.conf",
                               "/etc/gai.conf",
                               "/etc/ssl/certs",
                               "/etc/ssl/certs/ca-certificates.crt",
                               "/usr/lib/os-release",
                               authority,
                               NULL};
    /* all of them are there, and whoever runs the tests could read them before */
    const char *const may_not[] = {"/etc/passwd", "/etc", "/proc/self/environ",
                                   "/tmp",        secret, NULL};
    for (int i = 0; may_not[i]; i++) CHECK_INT(opens(may_not[i]), 0);
    int status = 0, pid = (int)fork();
    if (!pid) _exit(behind(authority, may, may_not));
    CHECK(pid > 0 && waitpid(pid, &status, 0) == pid && WIFEXITED(status));
    if (WEXITSTATUS(status) == NO_FENCE)
        test_skip("this kernel has no Landlock");
    else
        CHECK_INT(WEXITSTATUS(status), 0);
    unlink(authority), unlink(secret), rmdir(directory);
}

/* A daemon at a socket's path: who may connect, what a proxy reports, the socket of a crashed
 * daemon. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/wire/ask.h"

static int connects(struct test_client *client, const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    *client = (struct test_client){.fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    return CHECK(client->fd >= 0) &&
           CHECK(!connect(client->fd, (struct sockaddr *)&address, sizeof address));
}

static int asks(const char *path, const char *headers, struct test_reply *reply) {
    OWN(test_client, close) client;
    char text[256];
    snprintf(text, sizeof text, "GET /v1/presets HTTP/1.1\r\nHost: anything\r\n%s\r\n", headers);
    int status = 0;
    if (connects(&client, path) && CHECK(test_client_say(&client, text)))
        status = test_client_receive(&client, reply, 0, TEST_PATIENCE);
    return status;
}

TEST(a_path_is_listened_on_for_its_group_and_again_after_a_death) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", path[64], listen[80], text[1024];
    struct test_reply reply;
    struct stat file;
    REQUIRE(mkdtemp(directory) != NULL);
    snprintf(path, sizeof path, "%s/socket", directory);
    snprintf(listen, sizeof listen, "unix:%s", path);
    const char *const options[] = {
        "--listen", listen, "--trusted-proxy", "unix", "--max-requests-a-minute", "2", NULL};
    struct test_server *server = test_server_start(options);
    REQUIRE(server != NULL);
    CHECK(!stat(path, &file) && S_ISSOCK(file.st_mode) && (file.st_mode & 0777) == 0660);
    /* each client that the proxy reports has a quota of its own */
    for (int i = 0; i < 3; i++) {
        CHECK_INT(asks(path, "X-Forwarded-For: 192.0.2.1\r\n", &reply), i < 2 ? 200 : 429);
        test_reply_clear(&reply);
    }
    CHECK_INT(asks(path, "X-Forwarded-For: 192.0.2.2\r\n", &reply), 200);
    test_reply_clear(&reply);
    /* a second daemon does not replace the first one, but replaces one that crashed */
    CHECK_INT(test_server_run(options, text, sizeof text), 1);
    CHECK_SAYING(strstr(text, "in use") != NULL, "%s", text);
    test_server_signal(server, SIGKILL);
    CHECK_INT(test_server_wait(server), 128 + SIGKILL);
    test_server_drop(&server);
    server = test_server_start(options);
    REQUIRE(server != NULL);
    CHECK_INT(asks(path, "", &reply), 200);
    test_reply_clear(&reply);
    test_server_stop(&server);
    /* a file that is no socket is left unchanged */
    unlink(path);
    FILE *other = fopen(path, "w");
    REQUIRE(other && !fclose(other));
    CHECK_INT(test_server_run(options, text, sizeof text), 1);
    CHECK(!stat(path, &file) && S_ISREG(file.st_mode));
    unlink(path);
    CHECK(!rmdir(directory));
}

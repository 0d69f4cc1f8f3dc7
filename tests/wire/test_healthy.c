/* The command `pendulumd healthy` with a daemon: which address is queried, and the message for each
 * failure. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/wire/ask.h"

/* runs `pendulumd healthy` with up to four words; checks its exit status, and that its output
 * contains a word, or is empty if that is NULL */
static void tells(int status, const char *word, const char *const words[]) {
    const char *all[6] = {"healthy"};
    char text[1024];
    for (int i = 0; words[i]; i++) all[1 + i] = words[i];
    CHECK_INT(test_server_run(all, text, sizeof text), status);
    CHECK_SAYING(word ? strstr(text, word) != NULL : !text[0], "%s", text);
}

#define TELLS(status, word, ...) tells(status, word, (const char *const[]){__VA_ARGS__, NULL})

TEST(a_daemon_is_asked_how_it_is_where_its_options_say) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", path[80], listen[40], every[40], zero[40];
    REQUIRE(mkdtemp(directory) != NULL);
    snprintf(path, sizeof path, "unix:%s/socket", directory);
    /* one that accepts only a name of its own */
    const char *const options[] = {"--hosts", "example.org", NULL};
    const char *const by_path[] = {"--listen", path, NULL};
    struct test_server *server = test_server_start(options);
    REQUIRE(server != NULL);
    snprintf(listen, sizeof listen, "127.0.0.1:%d", test_server_port(server));
    snprintf(every, sizeof every, "*:%d", test_server_port(server));
    snprintf(zero, sizeof zero, "0.0.0.0:%d", test_server_port(server));
    TELLS(0, NULL, "--listen", listen);
    TELLS(0, NULL, "--listen", every);
    TELLS(0, NULL, "--listen", zero);
    /* probes have an address of their own, which takes precedence */
    TELLS(0, NULL, "--listen", "127.0.0.1:1", "--probe-listen", listen);
    TELLS(1, "no answer from 127.0.0.1:1", "--listen", listen, "--probe-listen", "127.0.0.1:1");
    test_server_stop(&server);
    TELLS(1, "no answer from", "--listen", listen);
    server = test_server_start(by_path);
    REQUIRE(server != NULL);
    TELLS(0, NULL, "--listen", path);
    test_server_stop(&server);
    TELLS(1, "no answer from", "--listen", path);
    TELLS(1, "no answer from", "--listen", "[::1]:1");
    unlink(path + strlen("unix:"));
    CHECK(!rmdir(directory));
}

TEST(what_is_asked_badly_or_answers_badly_is_not_healthy) {
    struct sockaddr_in address = {.sin_family = AF_INET};
    socklen_t bytes = sizeof address;
    char place[40];
    TELLS(2, "no-such-option", "--no-such-option", "1");
    TELLS(2, "HOST:PORT", "--listen", "nonsense");
    /* a server that accepts the connection and sends nothing is given up */
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    REQUIRE(fd >= 0 && !bind(fd, (struct sockaddr *)&address, bytes) && !listen(fd, 4) &&
            !getsockname(fd, (struct sockaddr *)&address, &bytes));
    snprintf(place, sizeof place, "127.0.0.1:%d", ntohs(address.sin_port));
    TELLS(1, "the status at 127.0.0.1", "--listen", place);
    close(fd);
}

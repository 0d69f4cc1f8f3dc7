#include "server/config/listen.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/harness/server.h"
#include "tests/harness/test.h"

TEST(port_0_takes_a_free_port_and_says_which) {
    char url[SRV_URL_BYTES];
    struct pend_error error;
    struct test_client client;
    int fd;
    REQUIRE(srv_listen_open("127.0.0.1:0", &fd, url, &error) == PEND_OK);
    CHECK(!strncmp(url, "http://127.0.0.1:", 17) && atoi(url + 17) > 0);
    CHECK(fcntl(fd, F_GETFD) & FD_CLOEXEC);
    CHECK(fcntl(fd, F_GETFL) & O_NONBLOCK);
    REQUIRE(test_client_open(&client, atoi(url + 17)));
    test_client_close(&client);
    close(fd);
}

TEST(names_and_every_address_can_be_listened_on) {
    static const char *const address[] = {"localhost:0", "*:0", "0.0.0.0:0"},
                             *const shown[] = {"http://localhost:", "http://", "http://0.0.0.0:"};
    for (int i = 0; i < 3; i++) {
        char url[SRV_URL_BYTES];
        struct pend_error error = {.text = ""};
        struct test_client client;
        int fd;
        if (!CHECK_SAYING(srv_listen_open(address[i], &fd, url, &error) == PEND_OK, "%s",
                          error.text))
            continue;
        CHECK_SAYING(!strncmp(url, shown[i], strlen(shown[i])), "%s", url);
        if (i) {
            CHECK(test_client_open(&client, atoi(strrchr(url, ':') + 1)));
            test_client_close(&client);
        }
        close(fd);
    }
}

TEST(what_cannot_be_listened_on_is_refused_with_the_reason) {
    char url[SRV_URL_BYTES], taken[64];
    struct pend_error error;
    int fd, other;
    CHECK(srv_listen_open("192.0.2.1:0", &fd, url, &error) == PEND_INVALID && fd == -1);
    CHECK_SAYING(strstr(error.text, "192.0.2.1:0: Cannot assign") != NULL, "%s", error.text);
    CHECK(srv_listen_open("no-such-host.invalid:0", &fd, url, &error) == PEND_INVALID && fd == -1);
    CHECK_SAYING(strstr(error.text, "no-such-host.invalid:0: ") != NULL, "%s", error.text);
    CHECK(srv_listen_open("8080", &fd, url, &error) == PEND_INVALID && fd == -1);
    REQUIRE(srv_listen_open("127.0.0.1:0", &other, url, &error) == PEND_OK);
    snprintf(taken, sizeof taken, "127.0.0.1:%s", strrchr(url, ':') + 1);
    CHECK(srv_listen_open(taken, &fd, url, &error) == PEND_INVALID && fd == -1);
    CHECK_SAYING(strstr(error.text, "Address already in use") != NULL, "%s", error.text);
    close(other);
}

TEST(a_settling_socket_lets_in_who_is_there_and_nobody_else) {
    char url[SRV_URL_BYTES];
    struct pend_error error;
    struct test_client there;
    int fd;
    REQUIRE(srv_listen_open("127.0.0.1:0", &fd, url, &error) == PEND_OK);
    int port = atoi(strrchr(url, ':') + 1);
    REQUIRE(test_client_open(&there, port));
    test_client_say(&there, "hello");
    if (!srv_listen_settle(fd)) {
        test_skip("this system lets only an administrator filter what a socket receives");
        test_client_close(&there);
        close(fd);
        return;
    }
    int late = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    CHECK(connect(late, (struct sockaddr *)&address, sizeof address) < 0);
    int taken = accept(fd, NULL, NULL);
    char text[8] = "";
    CHECK(taken >= 0 && recv(taken, text, sizeof text - 1, 0) == 5);
    CHECK_TEXT(text, "hello");
    test_sleep(0.05);
    CHECK(accept(fd, NULL, NULL) < 0);
    close(taken);
    close(late);
    test_client_close(&there);
    close(fd);
}

#include "server/healthy.h"

#include <assert.h>
#include <errno.h>
#include <netdb.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include "server/config/config_load.h"

enum { HEALTHY_SECONDS = 2, HEALTHY_HOST = 256 };

/* returns a connected socket of this family, or -1 with errno set; every step has a timeout */
static int healthy_connect(int family, const struct sockaddr *address, socklen_t bytes) {
    const struct timeval patience = {.tv_sec = HEALTHY_SECONDS};
    int fd = socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (!connect(fd, address, bytes)) return fd;
    int reason = errno;
    close(fd);
    errno = reason;
    return -1;
}

static int healthy_unix(const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    strcpy(address.sun_path, path);
    return healthy_connect(AF_UNIX, (const struct sockaddr *)&address, sizeof address);
}

/* connects to the listener at HOST:PORT; a wildcard address (*, 0.0.0.0, [::]) includes loopback */
static int healthy_internet(const char *address) {
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    struct addrinfo *list;
    char host[HEALTHY_HOST];
    const char *colon = strrchr(address, ':');
    size_t bytes = colon ? (size_t)(colon - address) : 0;
    int bracketed = bytes >= 2 && address[0] == '[' && address[bytes - 1] == ']';
    if (!colon || bytes >= sizeof host) {
        errno = EINVAL;
        return -1;
    }
    snprintf(host, sizeof host, "%.*s", (int)(bytes - 2 * (size_t)bracketed), address + bracketed);
    int every = !host[0] || !strcmp(host, "*") || !strcmp(host, "0.0.0.0") || !strcmp(host, "::");
    /* A null host gives the loopback addresses of both families. */
    if (getaddrinfo(every ? NULL : host, colon + 1, &hints, &list)) {
        errno = EADDRNOTAVAIL;
        return -1;
    }
    int fd = -1;
    for (const struct addrinfo *info = list; info && fd < 0; info = info->ai_next)
        fd = healthy_connect(info->ai_family, info->ai_addr, info->ai_addrlen);
    int reason = errno;
    freeaddrinfo(list);
    errno = reason;
    return fd;
}

/* sends the request and reads the status line; returns the status, 0 if there is none */
static int healthy_ask(int fd) {
    static const char request[] = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
                                  "Connection: close\r\n\r\n";
    char line[64] = "";
    size_t used = 0;
    int status = 0;
    assert(fd >= 0);
    if (send(fd, request, sizeof request - 1, MSG_NOSIGNAL) != (ssize_t)sizeof request - 1)
        return 0;
    while (used < sizeof line - 1 && !strchr(line, '\n')) {
        ssize_t got = recv(fd, line + used, sizeof line - 1 - used, 0);
        if (got <= 0) return 0;
        used += (size_t)got;
        line[used] = 0;
    }
    return sscanf(line, "HTTP/1.1 %3d ", &status) == 1 ? status : 0;
}

int srv_healthy_command(int argc, char *const argv[], char *const environment[]) {
    struct pend_error error = {.text = ""};
    struct srv_config config;
    assert(argc > 1);
    /* argv[1], the subcommand, takes the place of the program's name */
    if (srv_config_load(&config, argc - 1, argv + 1, environment, &error) != PEND_OK) {
        fprintf(stderr, "pendulumd healthy: %s\n", error.text);
        return 2;
    }
    int apart = strcmp(config.probe_listen, "none") != 0;
    const char *address = apart ? config.probe_listen : config.listen;
    int fd = strncmp(address, "unix:", 5) ? healthy_internet(address) : healthy_unix(address + 5);
    if (fd < 0) {
        fprintf(stderr, "pendulumd healthy: no answer from %s: %s\n", address, strerror(errno));
        return 1;
    }
    int status = healthy_ask(fd);
    close(fd);
    if (status != 200)
        fprintf(stderr, "pendulumd healthy: the status at %s is %d\n", address, status);
    return status == 200 ? 0 : 1;
}

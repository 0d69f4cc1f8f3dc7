#include "server/config/listen.h"

#include <assert.h>
#include <errno.h>
#include <linux/filter.h>
#include <netdb.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

enum { LISTEN_HOST = 256 };

struct listen_address {
    char host[LISTEN_HOST]; /* "" for every address */
    const char *port;
};

static enum pend_status listen_split(const char *address, struct listen_address *out,
                                     struct pend_error *error) {
    const char *colon = strrchr(address, ':');
    if (!colon || colon - address >= LISTEN_HOST)
        return pend_fail(error, PEND_INVALID, -1, 0, "cannot listen on %.100s: it is not HOST:PORT",
                         address);
    size_t bytes = (size_t)(colon - address);
    int bracketed = bytes >= 2 && address[0] == '[' && address[bytes - 1] == ']';
    snprintf(out->host, sizeof out->host, "%.*s", (int)(bytes - 2 * (size_t)bracketed),
             address + bracketed);
    if (!strcmp(out->host, "*")) out->host[0] = 0;
    out->port = colon + 1;
    return PEND_OK;
}

/* returns a bound and listening socket, or -1 with errno set */
static int listen_try(const struct addrinfo *info) {
    int on = 1, off = 0;
    int fd = socket(info->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) return -1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    /* [::] serves IPv4 too */
    if (info->ai_family == AF_INET6) setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
    if (!bind(fd, info->ai_addr, info->ai_addrlen) && !listen(fd, SOMAXCONN)) return fd;
    int reason = errno;
    close(fd);
    errno = reason;
    return -1;
}

/* writes the socket's address as a URL: the host as given, the port as bound */
static void listen_url(int fd, const char *host, char url[SRV_URL_BYTES]) {
    struct sockaddr_storage bound = {0};
    socklen_t bytes = sizeof bound;
    char number[64] = "", port[16] = "";
    getsockname(fd, (struct sockaddr *)&bound, &bytes);
    getnameinfo((struct sockaddr *)&bound, bytes, number, sizeof number, port, sizeof port,
                NI_NUMERICHOST | NI_NUMERICSERV);
    const char *shown = host[0] ? host : number;
    snprintf(url, SRV_URL_BYTES, strchr(shown, ':') ? "http://[%s]:%s" : "http://%s:%s", shown,
             port);
}

/* listens on every address: IPv6, which serves IPv4 too, or else IPv4 */
static int listen_every(const struct addrinfo *list) {
    for (int family = AF_INET6, turn = 0; turn < 2; family = AF_INET, turn++) {
        for (const struct addrinfo *info = list; info; info = info->ai_next) {
            int fd = info->ai_family == family ? listen_try(info) : -1;
            if (fd >= 0) return fd;
        }
    }
    return -1;
}

/* true if a stale socket exists at the path */
static int listen_stale(const struct sockaddr_un *address) {
    struct stat file;
    if (lstat(address->sun_path, &file) || !S_ISSOCK(file.st_mode)) return 0;
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    int refused = fd >= 0 && connect(fd, (const struct sockaddr *)address, sizeof *address) &&
                  errno == ECONNREFUSED;
    if (fd >= 0) close(fd);
    return refused;
}

/* returns a socket at a path, which this user and its group may connect to; -1 with errno set */
static int listen_unix(const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    strcpy(address.sun_path, path);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) return -1;
    int bound = !bind(fd, (struct sockaddr *)&address, sizeof address);
    if (!bound && errno == EADDRINUSE && listen_stale(&address) && !unlink(path))
        bound = !bind(fd, (struct sockaddr *)&address, sizeof address);
    if (bound && !chmod(path, 0660) && !listen(fd, SOMAXCONN)) return fd;
    int reason = errno;
    close(fd);
    errno = reason;
    return -1;
}

enum pend_status srv_listen_open(const char *address, int *fd, char url[SRV_URL_BYTES],
                                 struct pend_error *error) {
    struct listen_address parts;
    struct addrinfo hints = {.ai_family = AF_UNSPEC,
                             .ai_socktype = SOCK_STREAM,
                             .ai_flags = AI_PASSIVE},
                    *list;
    *fd = -1;
    if (!strncmp(address, "unix:", 5)) {
        snprintf(url, SRV_URL_BYTES, "%s", address);
        *fd = listen_unix(address + 5);
        return *fd >= 0 ? PEND_OK
                        : pend_fail(error, PEND_INVALID, -1, 0, "cannot listen on %.100s: %s",
                                    address, strerror(errno));
    }
    PEND_TRY(listen_split(address, &parts, error));
    int failed = getaddrinfo(parts.host[0] ? parts.host : NULL, parts.port, &hints, &list);
    if (failed)
        return pend_fail(error, PEND_INVALID, -1, 0, "cannot listen on %.100s: %s", address,
                         gai_strerror(failed));
    *fd = parts.host[0] ? listen_try(list) : listen_every(list);
    int reason = errno;
    freeaddrinfo(list);
    if (*fd < 0)
        return pend_fail(
            error, PEND_INVALID, -1, 0,
            "cannot listen on %.100s: %s; choose another port with --listen (make run LISTEN=)",
            address, strerror(reason));
    listen_url(*fd, parts.host, url);
    return PEND_OK;
}

int srv_listen_settle(int fd) {
    int domain = 0;
    socklen_t bytes = sizeof domain;
    assert(fd >= 0);
    /* clients of a Unix socket wait in its queue, and no filter can keep them out */
    if (getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &domain, &bytes) || domain == AF_UNIX) return 0;
    /* byte 13 of the TCP header holds the flags: SYN (2) without ACK (16) is dropped, all else
     * is kept */
    struct sock_filter drop_new[] = {
        BPF_STMT(BPF_LD | BPF_B | BPF_ABS, 13),       BPF_STMT(BPF_ALU | BPF_AND | BPF_K, 2 | 16),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 2, 0, 1), BPF_STMT(BPF_RET | BPF_K, 0),
        BPF_STMT(BPF_RET | BPF_K, UINT32_MAX),
    };
    struct sock_fprog program = {sizeof drop_new / sizeof *drop_new, drop_new};
    return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

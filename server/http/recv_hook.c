#include "server/http/recv_hook.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

static _Thread_local struct srv_recv_hooks *hooks_here;

void srv_recv_hooks_here(struct srv_recv_hooks *hooks) { hooks_here = hooks; }

int srv_recv_hooks_add(struct srv_recv_hooks *hooks, int fd, struct srv_recv_hook *hook) {
    assert(fd >= 0 && hook);
    if (fd >= hooks->fds) {
        int fds = fd < 512 ? 1024 : 2 * fd;
        struct srv_recv_hook **by_fd = realloc(hooks->by_fd, (size_t)fds * sizeof *by_fd);
        if (!by_fd) return 0;
        memset(by_fd + hooks->fds, 0, (size_t)(fds - hooks->fds) * sizeof *by_fd);
        hooks->by_fd = by_fd;
        hooks->fds = fds;
    }
    assert(fd < hooks->fds);
    hooks->by_fd[fd] = hook;
    return 1;
}

static struct srv_recv_hook *hook_at(int fd) {
    return hooks_here && fd >= 0 && fd < hooks_here->fds ? hooks_here->by_fd[fd] : NULL;
}

/* Passes received bytes to the strict reader. Returns how many of them libmicrohttpd may see; these
 * are moved to the front. */
static size_t hook_show(struct srv_recv_hook *hook, char *data, size_t bytes) {
    struct srv_http_strict *strict = &hook->strict;
    int within = srv_http_strict_within(strict);
    bytes = srv_http_strict_read(strict, data, bytes);
    assert(!strict->status || strict->detail);
    if (strict->status && !bytes) hook->refuses(hook);
    if (!within && srv_http_strict_within(strict)) hook->begins(hook);
    return bytes;
}

/* libmicrohttpd accepts some malformed messages and does not expose their bytes, so every read goes
 * through this function: a recv in the program replaces that of the C library for all shared
 * libraries. For a refused stream it reports that the client has closed it. */
ssize_t hook_recv(int fd, void *data, size_t bytes, int flags) __asm__("recv");

ssize_t hook_recv(int fd, void *data, size_t bytes, int flags) {
    struct srv_recv_hook *hook = hook_at(fd);
    if (hook && hook->strict.status) return 0;
    size_t held = 0, asked, shown;
    ssize_t got;
    /* If the strict reader removed bytes, read more to fill the buffer: libmicrohttpd takes a short
     * read for the end of the data. */
    do {
        asked = bytes - held;
        got = recvfrom(fd, (char *)data + held, asked, flags, NULL, NULL);
        if (!hook || got <= 0) return held ? (ssize_t)held : got;
        shown = hook_show(hook, (char *)data + held, (size_t)got);
        held += shown;
    } while (!hook->strict.status && (!held || (shown < (size_t)got && (size_t)got == asked)));
    return (ssize_t)held;
}

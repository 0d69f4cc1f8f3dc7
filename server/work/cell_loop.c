#include "server/work/cell_loop.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <unistd.h>

#include "api/call/relay_host.h"
#include "server/base/clock.h"

enum { CELL_LOOP_KEEP = 1 << 16 }; /* bytes of a question whose memory is kept for the next */

/* returns 0 at the end of the socket */
static int loop_read(int fd, void *data, size_t bytes) {
    for (char *at = data; bytes;) {
        ssize_t got = read(fd, at, bytes);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return 0;
        at += got;
        bytes -= (size_t)got;
    }
    return 1;
}

static int loop_write(int fd, const void *data, size_t bytes) {
    for (const char *at = data; bytes;) {
        ssize_t sent = write(fd, at, bytes);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return 0;
        at += sent;
        bytes -= (size_t)sent;
    }
    return 1;
}

/* the next question, in memory that is made larger for it; returns 0 at the end */
static int loop_question(int fd, char **message, size_t *room, size_t *bytes) {
    struct srv_cell_question question;
    if (!loop_read(fd, &question, sizeof question)) return 0;
    *bytes = (size_t)question.bytes;
    if (*bytes > *room || *room > CELL_LOOP_KEEP) {
        free(*message);
        *room = *bytes;
        *message = malloc(*room + !*room);
    }
    return *message && loop_read(fd, *message, *bytes);
}

void srv_cell_loop(int fd) {
    struct api_relay_host *host;
    char *message = NULL;
    size_t room = 0, bytes = 0;
    assert(fd >= 0);
    if (api_relay_host_new(&host, srv_clock_seconds) != PEND_OK) return;
    while (loop_question(fd, &message, &room, &bytes)) {
        struct api_buffer *out, *more;
        struct srv_cell_answer answer = {0};
        if (!api_relay_host_answer(host, message, bytes, &answer.told, &out, &more)) break;
        answer.out = out ? out->bytes : 0;
        answer.more = more ? more->bytes : 0;
        if (!loop_write(fd, &answer, sizeof answer) ||
            (out && !loop_write(fd, out->data, out->bytes)) ||
            (more && !loop_write(fd, more->data, more->bytes)))
            break;
    }
    api_relay_host_free(&host);
    free(message);
}

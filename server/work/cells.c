#include "server/work/cells.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/sandbox/spawn.h"
#include "server/work/cell_loop.h"
#include "server/work/zygote.h"

enum {
    CELLS_LOOK_MS = 20,    /* how often a wait looks whether it is still wanted */
    CELLS_PATIENCE_S = 10, /* beyond the seconds of a computation: reading and writing are not
                              computing */
    CELLS_MAKER_S = 60,    /* for the process that makes the others, on a machine that is busy */
    CELLS_ROOM = 64 << 20, /* memory of a process that is not its computation's to count */
    CELLS_VARIABLES = 8
};

struct srv_cells {
    struct srv_service *service;
    pthread_mutex_t lock; /* of orders */
    int fd;
    atomic_int lost;
};

/* --- the process that makes the others --- */

/* what a process may take, by the options that are in force */
static struct srv_zygote_rules cells_rules(const struct srv_cells *cells) {
    const struct srv_config *config = srv_service_config(cells->service);
    double most = config->limits.compute_seconds;
    if (config->job_seconds > most) most = config->job_seconds;
    return (struct srv_zygote_rules){.walls = config->walls,
                                     .bytes = (unsigned long long)config->held_bytes + CELLS_ROOM,
                                     .seconds = (unsigned long long)most + 6 * CELLS_PATIENCE_S};
}

static enum pend_status cells_greet(struct srv_cells *cells, char lack[SRV_CONFIG_TEXT],
                                    struct pend_error *error) {
    const struct srv_zygote_rules rules = cells_rules(cells);
    struct srv_zygote_hello hello = {.good = 0};
    struct iovec iov = {&hello, sizeof hello};
    struct msghdr message = {.msg_iov = &iov, .msg_iovlen = 1};
    if (send(cells->fd, &rules, sizeof rules, MSG_NOSIGNAL) != (ssize_t)sizeof rules ||
        srv_spawn_hear(cells->fd, &message) != (ssize_t)sizeof hello)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--isolate: the process that is to make others did not begin");
    hello.lack[sizeof hello.lack - 1] = 0;
    if (!hello.good)
        return pend_fail(error, PEND_INVALID, -1, 0, "--isolate: walls: %.190s", hello.lack);
    snprintf(lack, SRV_CONFIG_TEXT, "%s", hello.lack);
    return PEND_OK;
}

enum pend_status srv_cells_new(struct srv_cells **cells, struct srv_service *service,
                               char lack[SRV_CONFIG_TEXT], struct pend_error *error) {
    struct srv_cells *made = *cells = calloc(1, sizeof *made);
    lack[0] = 0;
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    made->service = service;
    made->fd = -1;
    pthread_mutex_init(&made->lock, NULL);
    int pid = srv_spawn("compute", &made->fd);
    enum pend_status status =
        pid > 0 ? cells_greet(made, lack, error)
                : pend_fail(error, PEND_INVALID, -1, 0, "--isolate: %s", strerror(errno));
    if (status != PEND_OK) srv_cells_free(cells);
    return status;
}

void srv_cells_free(struct srv_cells **cells) {
    struct srv_cells *gone = *cells;
    *cells = NULL;
    if (!gone) return;
    if (gone->fd >= 0) close(gone->fd);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

int srv_cells_lost(struct srv_cells *cells) {
    struct pollfd ear = {.fd = cells->fd};
    if (poll(&ear, 1, 0) > 0 && ear.revents & (POLLHUP | POLLERR)) atomic_store(&cells->lost, 1);
    return atomic_load(&cells->lost);
}

/* Gives an order, once there is room for it; returns 0 where orders are not taken any more. */
static int cells_say(struct srv_cells *cells, const struct srv_zygote_order *order) {
    const int64_t until = srv_clock_now() + srv_clock_span(CELLS_MAKER_S);
    struct pollfd ear = {.fd = cells->fd, .events = POLLOUT};
    while (!atomic_load(&cells->lost)) {
        ssize_t sent = send(cells->fd, order, sizeof *order, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent == (ssize_t)sizeof *order) return 1;
        if ((errno != EAGAIN && errno != EINTR) || srv_clock_now() > until) return 0;
        (void)poll(&ear, 1, CELLS_LOOK_MS);
    }
    return 0;
}

/* Gives an order and takes the answer, with the descriptor that may come with it. Returns 0 where
 * there is no answer, and will be none. */
static int cells_order(struct srv_cells *cells, struct srv_zygote_order order,
                       struct srv_zygote_told *told, int *fd) {
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control;
    struct iovec iov = {told, sizeof *told};
    struct msghdr message = {.msg_iov = &iov,
                             .msg_iovlen = 1,
                             .msg_control = control.room,
                             .msg_controllen = sizeof control.room};
    *fd = -1;
    pthread_mutex_lock(&cells->lock);
    int good =
        cells_say(cells, &order) && srv_spawn_hear(cells->fd, &message) == (ssize_t)sizeof *told;
    if (!good) atomic_store(&cells->lost, 1);
    pthread_mutex_unlock(&cells->lock);
    struct cmsghdr *head = good ? CMSG_FIRSTHDR(&message) : NULL;
    if (head && head->cmsg_type == SCM_RIGHTS) memcpy(fd, CMSG_DATA(head), sizeof *fd);
    return good;
}

/* Ends a process; how it ended is not asked for. An order that was lost would be a place lost among
 * those that there can be. */
static void cells_drop(struct srv_cells *cells, unsigned long long number) {
    const struct srv_zygote_order order = {.what = SRV_ZYGOTE_DROP, .number = number};
    if (!cells_say(cells, &order)) atomic_store(&cells->lost, 1);
}

/* --- one process --- */

/* how a process ended, and that it did, for the client, the log and the metrics */
static enum pend_status cell_crashed(struct srv_cell *cell, struct pend_error *error) {
    struct srv_service *service = cell->cells->service;
    struct srv_zygote_told told = {.pid = 0};
    char how[96] = "in a way that is not known";
    int none;
    close(cell->fd);
    cell->fd = -1;
    cell->crashed = 1;
    if (cells_order(cell->cells,
                    (struct srv_zygote_order){.what = SRV_ZYGOTE_END, .number = cell->number},
                    &told, &none) &&
        told.pid == cell->pid) {
        if (WIFSIGNALED(told.status))
            snprintf(how, sizeof how, "by signal %d (%s)", WTERMSIG(told.status),
                     strsignal(WTERMSIG(told.status)));
        else
            snprintf(how, sizeof how, "with status %d", WEXITSTATUS(told.status));
    }
    srv_metrics_count(&service->metrics.crashed, 1);
    srv_log_message(service->log, "process %d ended in the middle of a computation, %s", cell->pid,
                    how);
    return pend_fail(error, PEND_BUG, -1, 0,
                     "the process that computed this ended in the middle, %s; the server goes on",
                     how);
}

/* ends a process that takes too long, or whose answer nobody wants */
static enum pend_status cell_ended(struct srv_cell *cell, int wanted, struct pend_error *error) {
    struct srv_zygote_told told;
    int none;
    close(cell->fd);
    cell->fd = -1;
    (void)cells_order(cell->cells,
                      (struct srv_zygote_order){.what = SRV_ZYGOTE_END, .number = cell->number},
                      &told, &none);
    if (!wanted)
        return pend_fail(error, PEND_DEADLINE, -1, 0, "the computation was ended: nobody waits");
    return pend_fail(error, PEND_DEADLINE, -1, 0,
                     "the process that computed this did not answer for %.0f s and was ended",
                     cell->seconds);
}

/* waits until the socket can be read, or written; a failure ends the process */
static enum pend_status cell_wait(struct srv_cell *cell, short events, int64_t until,
                                  struct pend_error *error) {
    struct pollfd ear = {.fd = cell->fd, .events = events};
    for (;;) {
        int ready = poll(&ear, 1, CELLS_LOOK_MS);
        if (ready < 0 && errno != EINTR) return cell_crashed(cell, error);
        /* also where it always sends a little */
        if (srv_clock_now() > until) return cell_ended(cell, 1, error);
        if (ready > 0) return PEND_OK;
        if (cell->stop && cell->stop(cell->context)) return cell_ended(cell, 0, error);
    }
}

static enum pend_status cell_send(struct srv_cell *cell, const void *data, size_t bytes,
                                  int64_t until, struct pend_error *error) {
    for (const char *at = data; bytes;) {
        ssize_t sent = send(cell->fd, at, bytes, MSG_NOSIGNAL);
        if (sent < 0 && (errno == EAGAIN || errno == EINTR)) {
            PEND_TRY(cell_wait(cell, POLLOUT, until, error));
            continue;
        }
        if (sent <= 0) return cell_crashed(cell, error);
        at += sent;
        bytes -= (size_t)sent;
    }
    return PEND_OK;
}

static enum pend_status cell_receive(struct srv_cell *cell, void *data, size_t bytes, int64_t until,
                                     struct pend_error *error) {
    for (char *at = data; bytes;) {
        PEND_TRY(cell_wait(cell, POLLIN, until, error));
        ssize_t got = read(cell->fd, at, bytes);
        if (got < 0 && (errno == EAGAIN || errno == EINTR)) continue;
        if (got <= 0) return cell_crashed(cell, error);
        at += got;
        bytes -= (size_t)got;
    }
    return PEND_OK;
}

/* appends so many bytes that come; those that there is no room for end the process */
static enum pend_status cell_append(struct srv_cell *cell, struct api_buffer *out,
                                    unsigned long long bytes, int64_t until,
                                    struct pend_error *error) {
    if (!bytes) return PEND_OK;
    enum pend_status status = out ? PEND_LIMIT : PEND_BUG;
    if (out && bytes <= out->limit) status = api_buffer_room(out, (size_t)bytes);
    if (status != PEND_OK) {
        (void)cell_ended(cell, 0, error);
        return pend_fail(error, status, -1, 0, "%s", pend_status_text(status));
    }
    PEND_TRY(cell_receive(cell, out->data + out->bytes, (size_t)bytes, until, error));
    out->bytes += (size_t)bytes;
    return PEND_OK;
}

static enum pend_status cell_question(struct srv_cell *cell, const struct api_relay_ask *ask,
                                      int64_t until, struct pend_error *error) {
    struct {
        struct srv_cell_question question;
        struct api_relay_head head;
    } begin;
    const void *texts[API_RELAY_TEXTS];
    memset(&begin, 0, sizeof begin);
    api_relay_put(ask, &begin.head, texts);
    begin.question.bytes = sizeof begin.head;
    for (int i = 0; i < API_RELAY_TEXTS; i++) begin.question.bytes += begin.head.bytes[i];
    PEND_TRY(cell_send(cell, &begin, sizeof begin, until, error));
    for (int i = 0; i < API_RELAY_TEXTS; i++) {
        if (!begin.head.bytes[i]) continue;
        PEND_TRY(cell_send(cell, texts[i], (size_t)begin.head.bytes[i] - 1, until, error));
        PEND_TRY(cell_send(cell, "", 1, until, error));
    }
    return PEND_OK;
}

static enum pend_status cell_ask(void *context, const struct api_relay_ask *ask,
                                 struct api_relay_told *told, struct api_buffer *out,
                                 struct api_buffer *more, struct pend_error *error) {
    struct srv_cell *cell = context;
    struct srv_cell_answer answer;
    if (cell->fd < 0)
        return pend_fail(error, PEND_BUG, -1, 0, "the process that computed this has ended");
    int64_t until = srv_clock_now() + srv_clock_span(cell->seconds);
    PEND_TRY(cell_question(cell, ask, until, error));
    PEND_TRY(cell_receive(cell, &answer, sizeof answer, until, error));
    PEND_TRY(cell_append(cell, out, answer.out, until, error));
    PEND_TRY(cell_append(cell, more, answer.more, until, error));
    *told = answer.told;
    told->bytes += SRV_CELL_BYTES;
    return PEND_OK;
}

enum pend_status srv_cell_new(struct srv_cell **cell, struct srv_cells *cells, double seconds,
                              struct pend_error *error) {
    struct srv_zygote_told told = {.pid = 0};
    int fd = -1;
    assert(cells && seconds > 0);
    struct srv_cell *made = *cell = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    const struct srv_zygote_order order = {.what = SRV_ZYGOTE_NEW, .rules = cells_rules(cells)};
    if (!cells_order(cells, order, &told, &fd) || told.pid <= 0 || fd < 0) {
        if (told.pid > 0) cells_drop(cells, told.number);
        free(made);
        *cell = NULL;
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "the system has no process to spare for this computation");
    }
    fcntl(fd, F_SETFL, O_NONBLOCK);
    *made = (struct srv_cell){.cells = cells,
                              .relay = {cell_ask, made},
                              .fd = fd,
                              .pid = told.pid,
                              .number = told.number,
                              .seconds = seconds + CELLS_PATIENCE_S};
    return PEND_OK;
}

void srv_cell_free(struct srv_cell **cell) {
    struct srv_cell *gone = *cell;
    *cell = NULL;
    if (!gone) return;
    if (gone->fd >= 0) {
        close(gone->fd);
        cells_drop(gone->cells, gone->number);
    }
    free(gone);
}

#include "server/base/log.h"

#include <assert.h>
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "api/base/buffer.h"
#include "api/base/text.h"
#include "server/base/clock.h"
#include "server/base/condition.h"

enum {
    LOG_BYTES = 1 << 20,    /* maximum bytes of waiting lines per stream */
    LOG_PIECE = 4096,       /* bytes per write; a writable pipe accepts them without blocking
                             * (PIPE_BUF) */
    LOG_FILE = 1 << 17,     /* bytes per write to a file, which never blocks */
    LOG_NAP_MS = 20,        /* lines that arrive within this time are written together */
    LOG_PATIENCE_MS = 1000, /* longest wait for a reader when the log ends */
    LOG_TEXT = 1024         /* maximum bytes of a message */
};

/* Lines wait in `filling`; the thread swaps it with `writing` and writes that without the lock. */
struct log_stream {
    atomic_int fd; /* the descriptor to which the thread writes; -1 = lines are dropped */
    size_t piece;  /* bytes per write */
    struct api_buffer filling, writing;
    long dropped;
    int turning, turn; /* if `turning` is set, later lines go to the descriptor `turn` */
};

struct srv_log {
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t thread;
    int idle, stopping; /* idle: the thread waits for the first line */
    struct log_stream requests, audit, messages;
    struct srv_stamp stamp;
};

/* waits in short steps until the stream is writable; at shutdown only briefly */
static int log_writable(struct srv_log *log, int fd, int *patience) {
    for (;;) {
        int ready = poll(&(struct pollfd){.fd = fd, .events = POLLOUT}, 1, 100);
        if (ready > 0) return 1;
        if (ready < 0 && errno != EINTR) return 0;
        pthread_mutex_lock(&log->lock);
        int stopping = log->stopping;
        pthread_mutex_unlock(&log->lock);
        if (stopping && (*patience -= 100) <= 0) return 0;
    }
}

/* writes the contents of `writing`; lines that cannot be written are lost */
static void log_write(struct srv_log *log, struct log_stream *stream, int *patience) {
    const char *at = stream->writing.data;
    size_t left = stream->writing.bytes;
    while (left && stream->fd >= 0 && log_writable(log, stream->fd, patience)) {
        ssize_t wrote = write(stream->fd, at, left < stream->piece ? left : stream->piece);
        if (wrote < 0 && errno != EINTR && errno != EAGAIN) break;
        if (wrote < 0) continue;
        at += wrote;
        left -= (size_t)wrote;
    }
    stream->writing.bytes = 0;
}

#ifndef NDEBUG
/* true if the buffer contains only whole lines; called with the lock held */
static int log_stream_valid(const struct log_stream *stream) {
    const struct api_buffer *lines = &stream->filling;
    return lines->bytes <= LOG_BYTES && stream->dropped >= 0 &&
           (!lines->bytes || lines->data[lines->bytes - 1] == '\n');
}
#endif

/* swaps the buffers, so that the waiting lines can be written; called with the lock held */
static void log_swap(struct log_stream *stream, const char *before, const char *after) {
    assert(!stream->writing.bytes && log_stream_valid(stream));
    struct api_buffer full = stream->filling;
    stream->filling = stream->writing;
    stream->writing = full;
    if (!stream->dropped) return;
    stream->writing.limit += LOG_TEXT;
    if (api_buffer_format(&stream->writing, "%s%ld%s\n", before, stream->dropped, after) == PEND_OK)
        stream->dropped = 0;
    stream->writing.limit -= LOG_TEXT;
}

static int log_stream_empty(const struct log_stream *stream) {
    return !stream->turning && !stream->filling.bytes && !stream->dropped;
}

static int log_empty(const struct srv_log *log) {
    return log_stream_empty(&log->requests) && log_stream_empty(&log->audit) &&
           log_stream_empty(&log->messages);
}

/* redirects a stream; closes the old descriptor unless it is a standard stream */
static void log_stream_to(struct log_stream *stream, int fd) {
    struct stat file;
    int plain = fd >= 0 && !fstat(fd, &file) && S_ISREG(file.st_mode),
        old = atomic_exchange(&stream->fd, fd);
    stream->piece = plain ? LOG_FILE : LOG_PIECE;
    if (old > STDERR_FILENO && old != fd) close(old);
}

/* completes a redirection after the earlier lines were written; called by the thread, with the lock
 * held */
static void log_turned(struct log_stream *stream) {
    if (!stream->turning || (stream->filling.bytes && atomic_load(&stream->fd) >= 0)) return;
    log_stream_to(stream, stream->turn);
    stream->turning = 0;
}

static void *log_main(void *argument) {
    struct srv_log *log = argument;
    int patience = LOG_PATIENCE_MS, more = 1;
    pthread_mutex_lock(&log->lock);
    while (more) {
        log->idle = 1;
        while (log_empty(log) && !log->stopping)
            srv_condition_wait(&log->wake, &log->lock, SRV_CONDITION_NEVER);
        log->idle = 0;
        /* let some lines gather, unless a message is waiting */
        int64_t until = srv_clock_now() + (int64_t)LOG_NAP_MS * 1000000;
        while (!log->stopping && !log->messages.filling.bytes &&
               srv_condition_wait(&log->wake, &log->lock, until))
            continue;
        /* lines that wait for the first file must not be lost, so redirect before swapping */
        log_turned(&log->audit);
        log_swap(&log->requests, "{\"lost_lines\":", "}");
        log_swap(&log->audit, "{\"lost_lines\":", "}");
        log_swap(&log->messages, "", " messages were lost");
        pthread_mutex_unlock(&log->lock);
        log_write(log, &log->messages, &patience);
        log_write(log, &log->audit, &patience);
        log_write(log, &log->requests, &patience);
        pthread_mutex_lock(&log->lock);
        log_turned(&log->requests);
        log_turned(&log->audit);
        more = !log->stopping || (!log_empty(log) && patience > 0);
    }
    pthread_mutex_unlock(&log->lock);
    return NULL;
}

static void log_stream_init(struct log_stream *stream, int fd) {
    *stream = (struct log_stream){0};
    log_stream_to(stream, fd);
    api_buffer_init(&stream->filling, LOG_BYTES);
    api_buffer_init(&stream->writing, LOG_BYTES);
}

static void log_stream_clear(struct log_stream *stream) {
    log_stream_to(stream, -1);
    api_buffer_clear(&stream->filling);
    api_buffer_clear(&stream->writing);
}

enum pend_status srv_log_new(struct srv_log **log, int requests, int messages) {
    struct srv_log *made = *log = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    srv_condition_init(&made->wake);
    log_stream_init(&made->requests, requests);
    log_stream_init(&made->audit, -1);
    log_stream_init(&made->messages, messages);
    if (!pthread_create(&made->thread, NULL, log_main, made)) return PEND_OK;
    pthread_cond_destroy(&made->wake);
    pthread_mutex_destroy(&made->lock);
    free(made);
    *log = NULL;
    return PEND_NO_MEMORY;
}

void srv_log_turn(struct srv_log *log, enum srv_log_kind kind, int fd) {
    struct log_stream *stream = kind == SRV_LOG_AUDIT ? &log->audit : &log->requests;
    pthread_mutex_lock(&log->lock);
    /* close the descriptor of an earlier redirection that never took effect */
    if (stream->turning && stream->turn > STDERR_FILENO) close(stream->turn);
    stream->turning = 1;
    stream->turn = fd;
    pthread_cond_signal(&log->wake);
    pthread_mutex_unlock(&log->lock);
}

void srv_log_free(struct srv_log **log) {
    struct srv_log *gone = *log;
    *log = NULL;
    if (!gone) return;
    pthread_mutex_lock(&gone->lock);
    gone->stopping = 1;
    pthread_cond_signal(&gone->wake);
    pthread_mutex_unlock(&gone->lock);
    pthread_join(gone->thread, NULL);
    log_stream_clear(&gone->requests);
    log_stream_clear(&gone->audit);
    log_stream_clear(&gone->messages);
    pthread_cond_destroy(&gone->wake);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

/* number of bytes at the start of a text that JSON need not escape */
static size_t log_plain(const char *text) {
    size_t bytes = 0;
    while ((unsigned char)text[bytes] >= ' ' && (unsigned char)text[bytes] < 0x7f &&
           text[bytes] != '"' && text[bytes] != '\\')
        bytes++;
    return bytes;
}

/* appends a member; text without special characters is copied */
static enum pend_status log_text(struct api_buffer *out, const char *key, const char *text) {
    size_t before = strlen(key), bytes = log_plain(text);
    PEND_TRY(api_buffer_room(out, before + bytes + 2));
    char *at = out->data + out->bytes;
    memcpy(at, key, before);
    if (text[bytes]) {
        out->bytes += before;
        return api_text_quote(out, text, strlen(text));
    }
    at[before] = '"';
    memcpy(at + before + 1, text, bytes);
    at[before + 1 + bytes] = '"';
    out->bytes += before + bytes + 2;
    return PEND_OK;
}

/* appends value / unit with `decimals` >= 0 decimals; printf would take longer than the rest of the
 * line */
static enum pend_status log_number(struct api_buffer *out, const char *key, int64_t value,
                                   int decimals) {
    char digits[32], *at = digits + sizeof digits;
    uint64_t left = value > 0 ? (uint64_t)value : 0;
    for (int place = 0; left || place <= decimals; place++, left /= 10) {
        if (place == decimals && decimals) *--at = '.';
        *--at = (char)('0' + left % 10);
    }
    size_t before = strlen(key), bytes = (size_t)(digits + sizeof digits - at);
    PEND_TRY(api_buffer_room(out, before + bytes));
    memcpy(out->data + out->bytes, key, before);
    memcpy(out->data + out->bytes + before, at, bytes);
    out->bytes += before + bytes;
    return PEND_OK;
}

static enum pend_status log_line(struct srv_log *log, const struct srv_log_request *request) {
    struct api_buffer *out = &log->requests.filling;
    srv_clock_stamp(&log->stamp);
    PEND_TRY(log_text(out, "{\"time\":", log->stamp.text));
    PEND_TRY(log_text(out, ",\"id\":", request->id));
    PEND_TRY(log_text(out, ",\"client\":", request->client));
    if (request->token) PEND_TRY(log_text(out, ",\"token\":", request->token));
    PEND_TRY(log_text(out, ",\"method\":", request->method));
    PEND_TRY(log_text(out, ",\"target\":", request->target));
    PEND_TRY(log_number(out, ",\"status\":", request->status, 0));
    PEND_TRY(log_text(out, ",\"outcome\":", request->outcome));
    PEND_TRY(log_number(out, ",\"bytes_in\":", (int64_t)request->bytes_in, 0));
    PEND_TRY(log_number(out, ",\"bytes_out\":", (int64_t)request->bytes_out, 0));
    PEND_TRY(log_number(out, ",\"wait\":", request->wait / 1000, 6));
    PEND_TRY(log_number(out, ",\"compute\":", request->compute / 1000, 6));
    PEND_TRY(log_number(out, ",\"total\":", request->total / 1000, 6));
    PEND_TRY(log_number(out, ",\"steps\":", request->steps, 0));
    if (request->cache) PEND_TRY(log_text(out, ",\"cache\":", request->cache));
    if (request->trace) PEND_TRY(log_text(out, ",\"trace\":", request->trace));
    if (request->agent) PEND_TRY(log_text(out, ",\"agent\":", request->agent));
    return api_buffer_text(out, "}\n");
}

/* completes a line, with the lock held: a line that did not fit is removed and counted */
static void log_added(struct srv_log *log, struct log_stream *stream, size_t before,
                      enum pend_status status) {
    assert(before <= stream->filling.bytes);
    if (status != PEND_OK) {
        stream->filling.bytes = before;
        stream->dropped++;
    }
    assert(log_stream_valid(stream));
    if (log->idle) pthread_cond_signal(&log->wake);
    log->idle = 0;
}

void srv_log_request(struct srv_log *log, const struct srv_log_request *request) {
    if (atomic_load(&log->requests.fd) < 0) return;
    pthread_mutex_lock(&log->lock);
    size_t before = log->requests.filling.bytes;
    log_added(log, &log->requests, before, log_line(log, request));
    pthread_mutex_unlock(&log->lock);
}

static enum pend_status log_audit_line(struct srv_log *log,
                                       const struct srv_log_audit_entry *entry) {
    struct api_buffer *out = &log->audit.filling;
    srv_clock_stamp(&log->stamp);
    PEND_TRY(log_text(out, "{\"time\":", log->stamp.text));
    PEND_TRY(log_text(out, ",\"id\":", entry->id));
    PEND_TRY(log_text(out, ",\"who\":", entry->who));
    PEND_TRY(log_text(out, ",\"role\":", entry->role));
    PEND_TRY(log_text(out, ",\"what\":", entry->what));
    if (entry->of) PEND_TRY(log_text(out, ",\"of\":", entry->of));
    PEND_TRY(log_number(out, ",\"status\":", entry->status, 0));
    PEND_TRY(log_text(out, ",\"outcome\":", entry->outcome));
    return api_buffer_text(out, "}\n");
}

void srv_log_audit_entry(struct srv_log *log, const struct srv_log_audit_entry *entry) {
    pthread_mutex_lock(&log->lock);
    size_t before = log->audit.filling.bytes;
    /* an entry that arrives during a redirection goes to the new file */
    if ((log->audit.turning ? log->audit.turn : atomic_load(&log->audit.fd)) >= 0)
        log_added(log, &log->audit, before, log_audit_line(log, entry));
    pthread_mutex_unlock(&log->lock);
}

void srv_log_message(struct srv_log *log, const char *format, ...) {
    char text[LOG_TEXT];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (char *at = text; *at; at++)
        if ((unsigned char)*at < ' ' || *at == 0x7f) *at = '?';
    pthread_mutex_lock(&log->lock);
    size_t before = log->messages.filling.bytes;
    log_added(log, &log->messages, before, api_buffer_format(&log->messages.filling, "%s\n", text));
    pthread_mutex_unlock(&log->lock);
}

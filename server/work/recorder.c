#include "server/work/recorder.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "api/base/engine.h"

enum { RECORDER_NAME = 32, RECORDER_NUMBERS = 1000000 };

static const char recorder_ending[] = ".request";

struct srv_recorder {
    pthread_mutex_t lock;
    int directory; /* the open directory */
    int files;
    long long bytes;
    long number; /* the number of the last file */
    int stopped; /* the log was told why recording stopped */
};

struct srv_record {
    struct srv_recorder *recorder;
    char name[RECORDER_NAME];
    char seal[API_DIGEST_BYTES];
    struct api_digest_stream *answer;
    long long bytes; /* the size of all files in bytes */
    int streams;
};

/* The header fields that are written: those that can change a response or identify it in the log.
 * A list of fields to leave out would miss every field that is new. */
static const struct {
    enum srv_field_id id;
    const char *name;
} recorder_fields[] = {
    {SRV_CONTENT_TYPE, "Content-Type"},
    {SRV_CONTENT_ENCODING, "Content-Encoding"},
    {SRV_ACCEPT, "Accept"},
    {SRV_ACCEPT_ENCODING, "Accept-Encoding"},
    {SRV_IF_NONE_MATCH, "If-None-Match"},
    {SRV_PREFER, "Prefer"},
    {SRV_REQUEST_ID, "X-Request-Id"},
    {SRV_TRACE, "Traceparent"},
    {SRV_USER_AGENT, "User-Agent"},
};

static_assert(sizeof recorder_fields / sizeof *recorder_fields <= SRV_RECORDING_FIELDS,
              "every field that is written has room in a recording");

int srv_recorder_valid(const struct srv_recorder *recorder) {
    return recorder->directory >= 0 && recorder->files >= 0 && recorder->bytes >= 0 &&
           recorder->files <= SRV_RECORDER_FILES && recorder->number <= RECORDER_NUMBERS;
}

/* --- the directory --- */

/* Counts one file. Returns 0 if the name is not that of a recording. */
static int recorder_count(struct srv_recorder *recorder, const char *name) {
    struct stat about;
    char *end;
    long number = strtol(name, &end, 10);
    if (end == name || strcmp(end, recorder_ending) || number < 1 || number > RECORDER_NUMBERS)
        return 0;
    if (fstatat(recorder->directory, name, &about, AT_SYMLINK_NOFOLLOW)) return 0;
    if (recorder->files < SRV_RECORDER_FILES) recorder->files++;
    recorder->bytes += about.st_size;
    if (number > recorder->number) recorder->number = number;
    return 1;
}

/* Counts the recordings that exist already. Returns 0 if the directory cannot be read. */
static int recorder_look(struct srv_recorder *recorder) {
    int copy = openat(recorder->directory, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *directory = copy < 0 ? NULL : fdopendir(copy);
    if (!directory) {
        if (copy >= 0) close(copy);
        return 0;
    }
    for (struct dirent *entry; (entry = readdir(directory));)
        (void)recorder_count(recorder, entry->d_name);
    closedir(directory);
    return 1;
}

enum pend_status srv_recorder_new(struct srv_recorder **recorder, const char *directory,
                                  struct pend_error *error) {
    struct srv_recorder *made = *recorder = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    pthread_mutex_init(&made->lock, NULL);
    int missing = mkdir(directory, 0700) && errno != EEXIST;
    if (!missing) made->directory = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (missing || made->directory < 0 || !recorder_look(made) ||
        faccessat(made->directory, ".", W_OK | X_OK, AT_EACCESS)) {
        enum pend_status status = pend_fail(
            error, PEND_INVALID, -1, 0, "--record %.150s is no directory that can be written: %s",
            directory, strerror(errno));
        if (missing) made->directory = -1;
        srv_recorder_free(recorder);
        return status;
    }
    assert(srv_recorder_valid(made));
    return PEND_OK;
}

void srv_recorder_free(struct srv_recorder **recorder) {
    struct srv_recorder *gone = *recorder;
    *recorder = NULL;
    if (!gone) return;
    if (gone->directory >= 0) close(gone->directory);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

/* --- one file --- */

/* Reserves the number and the bytes of a new file. Returns 0 if the limits forbid it; the first
 * refusal sets *said for the log. */
static long recorder_reserve(struct srv_recorder *recorder, long long bytes, int *said) {
    pthread_mutex_lock(&recorder->lock);
    assert(srv_recorder_valid(recorder));
    int full = recorder->files >= SRV_RECORDER_FILES ||
               recorder->bytes + bytes > SRV_RECORDER_BYTES || recorder->number >= RECORDER_NUMBERS;
    long number = full ? 0 : ++recorder->number;
    *said = recorder->stopped;
    if (full) recorder->stopped = 1;
    if (!full) {
        recorder->files++;
        recorder->bytes += bytes;
    }
    assert(srv_recorder_valid(recorder));
    pthread_mutex_unlock(&recorder->lock);
    return number;
}

/* Returns the reservation of a file that was not written. */
static void recorder_give_back(struct srv_recorder *recorder, long long bytes) {
    pthread_mutex_lock(&recorder->lock);
    recorder->files--;
    recorder->bytes -= bytes;
    assert(srv_recorder_valid(recorder));
    pthread_mutex_unlock(&recorder->lock);
}

static int recorder_put(int fd, const char *data, size_t bytes) {
    while (bytes) {
        ssize_t put = write(fd, data, bytes);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return 0;
        data += put;
        bytes -= (size_t)put;
    }
    return 1;
}

/* Writes a new file. Returns 0 with errno set if that fails; then no file is left. */
static int recorder_file(const struct srv_record *record, const struct api_buffer *head,
                         const struct api_request *request) {
    int directory = record->recorder->directory;
    int fd =
        openat(directory, record->name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (fd < 0) return 0;
    int good = recorder_put(fd, head->data, head->bytes) &&
               recorder_put(fd, request->body, request->body_bytes);
    int why = errno;
    good = !close(fd) && good;
    if (!good) unlinkat(directory, record->name, 0);
    errno = why;
    return good;
}

/* Writes the head of an exchange's recording. */
static enum pend_status recorder_head(struct srv_record *record,
                                      const struct srv_exchange *exchange,
                                      const struct api_request *request,
                                      const struct api_limits *limits, struct api_buffer *head) {
    struct srv_recording recording = {.engine = api_engine_name,
                                      .method = exchange->method,
                                      .target = exchange->target,
                                      .request = *request,
                                      .limits = *limits};
    for (size_t i = 0; i < sizeof recorder_fields / sizeof *recorder_fields; i++) {
        const char *value = exchange->field[recorder_fields[i].id];
        if (!value) continue;
        recording.field[recording.fields].name = recorder_fields[i].name;
        recording.field[recording.fields++].value = value;
    }
    enum pend_status status = srv_recording_write_head(&recording, head);
    memcpy(record->seal, recording.seal, sizeof record->seal);
    return status;
}

/* Writes the request. Returns 0 if there is no file; the log is told why once. */
static int recorder_write(struct srv_record *record, const struct srv_exchange *exchange,
                          const struct api_request *request, const struct api_buffer *head) {
    struct srv_recorder *recorder = record->recorder;
    int said;
    record->bytes = (long long)(head->bytes + request->body_bytes) + SRV_RECORDING_ANSWER;
    long number = recorder_reserve(recorder, record->bytes, &said);
    snprintf(record->name, sizeof record->name, "%06ld%s", number, recorder_ending);
    if (number && recorder_file(record, head, request)) return 1;
    const char *why = number ? strerror(errno) : "its bounds of files and bytes are reached";
    if (number) recorder_give_back(recorder, record->bytes);
    if (!said) srv_log_message(exchange->service->log, "--record: a request is left out: %s", why);
    pthread_mutex_lock(&recorder->lock);
    recorder->stopped = 1;
    pthread_mutex_unlock(&recorder->lock);
    return 0;
}

struct srv_record *srv_recorder_begin(struct srv_recorder *recorder,
                                      const struct srv_exchange *exchange,
                                      const struct api_request *request,
                                      const struct api_limits *limits) {
    struct srv_record *record = calloc(1, sizeof *record);
    struct api_buffer head;
    assert(srv_exchange_valid(exchange));
    if (!record) return NULL;
    record->recorder = recorder;
    record->answer = api_digest_begin();
    api_buffer_init(&head, 2 * SRV_RECORDING_HEAD);
    if (!record->answer || recorder_head(record, exchange, request, limits, &head) != PEND_OK ||
        !recorder_write(record, exchange, request, &head))
        srv_record_end(&record);
    api_buffer_clear(&head);
    return record;
}

void srv_record_add(struct srv_record *record, const void *data, size_t bytes) {
    if (record) api_digest_add(record->answer, data, bytes);
}

void srv_record_streams(struct srv_record *record) {
    if (record) record->streams = 1;
}

void srv_record_answer(struct srv_record **record, int status, int broken) {
    struct srv_record *ended = *record;
    char line[SRV_RECORDING_ANSWER];
    if (!ended) return;
    assert(!broken || ended->streams);
    struct srv_recording_answer answer = {.status = status,
                                          .end = broken           ? SRV_RECORDING_BROKEN
                                                 : ended->streams ? SRV_RECORDING_STREAM
                                                                  : SRV_RECORDING_WHOLE};
    api_digest_end(&ended->answer, answer.digest);
    int bytes = srv_recording_write_answer(&answer, ended->seal, line);
    int fd = openat(ended->recorder->directory, ended->name,
                    O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
    /* A file without its last line is valid, and one that was cut is recognized as damaged. */
    if (fd >= 0) {
        (void)recorder_put(fd, line, (size_t)bytes);
        close(fd);
    }
    srv_record_end(record);
}

void srv_record_remove(struct srv_record **record) {
    if (!*record) return;
    unlinkat((*record)->recorder->directory, (*record)->name, 0);
    recorder_give_back((*record)->recorder, (*record)->bytes);
    srv_record_end(record);
}

void srv_record_end(struct srv_record **record) {
    struct srv_record *gone = *record;
    *record = NULL;
    if (!gone) return;
    api_digest_end(&gone->answer, NULL);
    free(gone);
}

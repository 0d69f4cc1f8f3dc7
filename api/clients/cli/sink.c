#include "api/clients/cli/sink.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "api/clients/cli/request.h"

static char *volatile unfinished; /* a temporary file that no later run can continue */

/* Removes the temporary file. Calls only functions that are safe in a signal handler. */
static void tidy(void) {
    char *path = unfinished;
    unfinished = NULL;
    if (path) unlink(path);
}

/* SA_RESETHAND has restored the default action, which ends the process. */
static void interrupted(int signal) {
    tidy();
    if (cli_scheduled) _exit(CLI_AGAIN);
    raise(signal);
}

static void tidy_at_end(void) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    struct sigaction action = {.sa_handler = interrupted, .sa_flags = SA_RESETHAND}, before;
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        if (sigaction(signals[i], NULL, &before) == 0 && before.sa_handler == SIG_DFL)
            sigaction(signals[i], &action, NULL);
    atexit(tidy);
}

PEND_VALIDATOR cli_sink_valid(const struct cli_sink *sink) {
    return (!sink->part || (sink->path && *sink->path)) && (sink->file || sink->have == 0) &&
           sink->have >= 0 && api_buffer_valid(&sink->text);
}

static int same_file(const struct stat *a, const struct stat *b) {
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* Opens and locks a file that contains the beginning of a download. Another process may rename or
 * remove it between open and flock: then opens the name again. */
static int open_kept(const char *part) {
    struct stat named, opened;
    for (;;) {
        int fd = open(part, O_RDWR | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (fd < 0) return -1;
        if (flock(fd, LOCK_EX | LOCK_NB) != 0)
            cli_die("%s: another process is downloading it", part);
        if (fstat(fd, &opened) == 0 && lstat(part, &named) == 0 && same_file(&opened, &named))
            return fd;
        close(fd);
    }
}

static int open_new(char *part) {
    int fd = mkostemp(part, O_CLOEXEC);
    if (fd < 0) return -1;
    unfinished = part;
    tidy_at_end();
    mode_t mask = umask(0);
    umask(mask);
    if (fchmod(fd, 0666 & ~mask) != 0) cli_die("%s: %s", part, strerror(errno));
    return fd;
}

/* Gives a file the owner and the mode of the file that it will replace. Only root can change the
 * owner; others keep at least the group, if they are its members. */
static void open_like(int fd, const struct stat *target) {
    int given = fchown(fd, target->st_uid, target->st_gid) == 0 ||
                fchown(fd, (uid_t)-1, target->st_gid) == 0;
    if (fchmod(fd, target->st_mode & (given ? 07777 : 0777)) != 0)
        cli_die("the file's mode: %s", strerror(errno));
}

/* The path of the file to replace, without symbolic links; to be freed. A file that nobody may
 * write is refused, even to root. */
static char *open_real(const char *path, const struct stat *target) {
    char *real = target ? realpath(path, NULL) : strdup(path);
    struct stat link;
    if (!real) cli_die("%s: %s", path, strerror(errno));
    if (!target && lstat(real, &link) == 0)
        cli_die("%s is a symbolic link to a file that does not exist", real);
    if (target && (access(real, W_OK) != 0 || !(target->st_mode & 0222)))
        cli_die("%s is read-only", real);
    return real;
}

/* Opens the temporary file for a regular file, which need not exist yet. */
static void open_part(struct cli_sink *sink, const struct stat *target, const char *kept) {
    char *real = open_real(sink->path, target);
    size_t size = strlen(real) + sizeof ".part-" + (kept ? strlen(kept) : sizeof "XXXXXX");
    sink->part = malloc(size);
    cli_need(sink->part != NULL);
    snprintf(sink->part, size, "%s.part-%s", real, kept ? kept : "XXXXXX");
    int fd = kept ? open_kept(sink->part) : open_new(sink->part);
    if (fd < 0 || !(sink->file = fdopen(fd, kept ? "ab" : "wb")))
        cli_die("%s: %s", real, strerror(errno));
    if (target) open_like(fd, target);
    sink->path = sink->real = real;
    if (fseeko(sink->file, 0, SEEK_END) == 0) sink->have = ftello(sink->file);
}

void cli_sink_open(struct cli_sink *sink, const char *path, const char *kept) {
    struct stat target, out;
    assert(!kept || *kept);
    *sink = (struct cli_sink){.path = path && !strcmp(path, "-") ? NULL : path};
    api_buffer_init(&sink->text, 1 << 30);
    if (!sink->path) {
        sink->file = stdout;
    } else if (*path) {
        int exists = stat(path, &target) == 0;
        if (!exists && errno != ENOENT) cli_die("%s: %s", path, strerror(errno));
        if (exists && fstat(STDOUT_FILENO, &out) == 0 && same_file(&target, &out)) {
            sink->file = stdout; /* "/dev/stdout", or the file to which the shell redirects */
        } else if (exists && !S_ISREG(target.st_mode)) {
            sink->file = fopen(path, "wb");
            if (!sink->file) cli_die("%s: %s", path, strerror(errno));
        } else {
            open_part(sink, exists ? &target : NULL, kept);
        }
    }
    assert(cli_sink_valid(sink));
}

void cli_sink_again(struct cli_sink *sink) {
    assert(cli_sink_valid(sink));
    sink->text.bytes = 0;
    if (sink->have == 0) return;
    /* what standard output contained before must not be removed, even from a file */
    if (!sink->part || fflush(sink->file) != 0 || ftruncate(fileno(sink->file), 0) != 0)
        cli_die("the answer was cut off after %lld bytes", sink->have);
    rewind(sink->file);
    sink->have = 0;
    assert(cli_sink_valid(sink));
}

void cli_sink_add(struct cli_sink *sink, const char *data, size_t bytes) {
    assert(cli_sink_valid(sink) && (data || bytes == 0));
    if (!sink->file) {
        cli_need(api_buffer_add(&sink->text, data, bytes) == PEND_OK);
        return;
    }
    if (fwrite(data, 1, bytes, sink->file) != bytes && errno == EPIPE) exit(128 + SIGPIPE);
    if (ferror(sink->file))
        cli_die("%s: %s", sink->path ? sink->path : "standard output", strerror(errno));
    sink->have += (long long)bytes;
    assert(cli_sink_valid(sink));
}

void cli_sink_close(struct cli_sink *sink) {
    assert(cli_sink_valid(sink) && (!sink->part || sink->file));
    int failed = sink->file && fflush(sink->file) != 0;
    /* renamed while locked, so that no other process continues a complete file */
    if (sink->part) failed |= fsync(fileno(sink->file)) != 0 || rename(sink->part, sink->path) != 0;
    if (failed) cli_die("%s: %s", sink->path ? sink->path : "standard output", strerror(errno));
    unfinished = NULL;
    if (sink->file && sink->file != stdout && fclose(sink->file) != 0)
        cli_die("%s: %s", sink->path, strerror(errno));
    free(sink->part);
    free(sink->real);
    api_buffer_clear(&sink->text);
}

void cli_progress(const char *format, ...) {
    static int shown;
    va_list arguments;
    if (!isatty(STDERR_FILENO) && !getenv("PENDULUM_PROGRESS")) return;
    if (!*format) {
        if (shown) fputc('\n', stderr);
        shown = 0;
        return;
    }
    va_start(arguments, format);
    fputc('\r', stderr);
    vfprintf(stderr, format, arguments);
    fputs("\033[K", stderr);
    va_end(arguments);
    shown = 1;
}

#include "api/clients/cli/sink.h"

#include <assert.h>
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "api/clients/cli/request.h"

static const char *unfinished; /* what is no use to a later process */

static void tidy(void) {
    if (unfinished) unlink(unfinished);
}

int cli_sink_valid(const struct cli_sink *sink) {
    return (!sink->part || (sink->path && *sink->path)) && (sink->file || sink->have == 0) &&
           sink->have >= 0 && api_buffer_valid(&sink->text);
}

void cli_sink_open(struct cli_sink *sink, const char *path, const char *kept) {
    assert(!kept || *kept);
    *sink = (struct cli_sink){.path = path};
    api_buffer_init(&sink->text, 1 << 30);
    if (!path) sink->file = stdout;
    if (!path || !*path) {
        assert(cli_sink_valid(sink));
        return;
    }
    size_t size = strlen(path) + sizeof ".part-" + (kept ? strlen(kept) : 0);
    sink->part = malloc(size);
    cli_need(sink->part != NULL);
    snprintf(sink->part, size, kept ? "%s.part-%s" : "%s.part", path, kept);
    sink->file = fopen(sink->part, kept ? "ab" : "wb");
    if (!sink->file) cli_die("%s: %s", sink->part, strerror(errno));
    if (!kept) {
        unfinished = sink->part;
        atexit(tidy);
    }
    if (fseeko(sink->file, 0, SEEK_END) == 0) sink->have = ftello(sink->file);
    assert(cli_sink_valid(sink));
}

void cli_sink_again(struct cli_sink *sink) {
    assert(cli_sink_valid(sink));
    sink->text.bytes = 0;
    if (sink->have == 0) return;
    if (fflush(sink->file) != 0 || ftruncate(fileno(sink->file), 0) != 0)
        cli_die("the answer broke off after %lld bytes", sink->have);
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
    if (fwrite(data, 1, bytes, sink->file) != bytes)
        cli_die("%s: %s", sink->part ? sink->part : "standard output", strerror(errno));
    sink->have += (long long)bytes;
    assert(cli_sink_valid(sink));
}

void cli_sink_close(struct cli_sink *sink) {
    assert(cli_sink_valid(sink) && (!sink->part || sink->file));
    int failed = sink->file && fflush(sink->file) != 0;
    if (sink->part) failed |= fclose(sink->file) != 0 || rename(sink->part, sink->path) != 0;
    if (failed) cli_die("%s: %s", sink->path ? sink->path : "standard output", strerror(errno));
    unfinished = NULL;
    free(sink->part);
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

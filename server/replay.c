#include "server/replay.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/engine.h"
#include "api/call/call.h"
#include "server/work/recorder.h"

/* An answer as it is computed. */
struct replay {
    struct api_call *call;
    struct api_buffer out;
    struct api_digest_stream *digest;
    struct srv_recording_answer answer;
    int written; /* all went to standard output */
};

static int replay_bad(const char *path, const char *why) {
    fprintf(stderr, "pendulumd: --replay %s: %s\n", path, why);
    return 2;
}

/* the whole file; 0, with the fault told, where it cannot be read
 */
static int replay_load(const char *path, struct api_buffer *file) {
    FILE *from = fopen(path, "re");
    if (!from) return !replay_bad(path, strerror(errno));
    enum pend_status status;
    size_t got = 0;
    do {
        status = api_buffer_room(file, 65536);
        if (status == PEND_OK) file->bytes += got = fread(file->data + file->bytes, 1, 65536, from);
    } while (status == PEND_OK && got);
    const char *why = status != PEND_OK ? "out of memory"
                      : ferror(from)    ? "it cannot be read"
                                        : NULL;
    fclose(from);
    return why ? !replay_bad(path, why) : 1;
}

/* the bytes of `out` go to standard output */
static void replay_write(struct replay *replay) {
    struct api_buffer *out = &replay->out;
    api_digest_add(replay->digest, out->data, out->bytes);
    if (out->bytes && fwrite(out->data, 1, out->bytes, stdout) != out->bytes) replay->written = 0;
    out->bytes = 0;
}

/* computes to the end; the bytes of what was a stream are written as they come */
static void replay_run(struct replay *replay, const struct api_request *request, int streams) {
    enum api_progress progress = api_call_open(replay->call, request, &replay->out);
    streams = streams && progress == API_MORE && api_call_streams(replay->call);
    if (streams) api_call_promise(replay->call);
    while (progress == API_MORE) {
        progress = api_call_run(replay->call, &replay->out);
        if (streams) replay_write(replay);
    }
    replay_write(replay);
    replay->answer.status = api_call_answer(replay->call).status;
    replay->answer.end = progress == API_BROKEN ? SRV_RECORDING_BROKEN
                         : streams              ? SRV_RECORDING_STREAM
                                                : SRV_RECORDING_WHOLE;
    if (fflush(stdout)) replay->written = 0;
}

/* says how the answer compares with the recorded one; returns the exit status */
static int replay_tell(const struct replay *replay, const struct srv_recording *recording) {
    const struct srv_recording_answer *now = &replay->answer, *then = &recording->answer;
    int same = now->status == then->status && !strcmp(now->digest, then->digest) &&
               (now->end == SRV_RECORDING_BROKEN) == (then->end == SRV_RECORDING_BROKEN);
    fprintf(stderr, "%s %s\nengine %s, recorded with %s\nstatus %d, digest %s\n", recording->method,
            recording->target, api_engine_name, recording->engine, now->status, now->digest);
    if (then->end == SRV_RECORDING_NONE)
        fprintf(stderr, "no answer was recorded: the process or the client left before, or the "
                        "server ended the computation\n");
    else if (same)
        fprintf(stderr, "the answer is the recorded one\n");
    else
        fprintf(stderr, "the answer is another: recorded were status %d, digest %s%s\n",
                then->status, then->digest,
                then->end == SRV_RECORDING_BROKEN ? ", and a computation that failed" : "");
    if (!replay->written) fprintf(stderr, "the answer could not be written\n");
    return same && replay->written ? 0 : 1;
}

/* computes the request of a recording; returns the exit status */
static int replay_recording(struct replay *replay, const char *path,
                            const struct api_buffer *file) {
    struct pend_error error = {.text = ""};
    struct srv_recording recording;
    if (file->bytes > SRV_RECORDER_BYTES)
        return replay_bad(path, "it is larger than any recorded request");
    if (srv_recording_read(&recording, file->data, file->bytes, &error) != PEND_OK)
        return replay_bad(path, error.text);
    if (api_call_new(&replay->call, &recording.limits) != PEND_OK)
        return replay_bad(path, "out of memory");
    api_buffer_init(&replay->out, (size_t)recording.limits.answer_bytes);
    replay_run(replay, &recording.request, recording.answer.end >= SRV_RECORDING_STREAM);
    api_digest_end(&replay->digest, replay->answer.digest);
    return replay_tell(replay, &recording);
}

int srv_replay(const char *path) {
    struct api_buffer file;
    struct replay replay = {.written = 1, .digest = api_digest_begin()};
    int status = 2;
    api_buffer_init(&file, SIZE_MAX / 2);
    api_buffer_init(&replay.out, 0);
    if (!replay.digest)
        status = replay_bad(path, "out of memory");
    else if (replay_load(path, &file))
        status = replay_recording(&replay, path, &file);
    api_digest_end(&replay.digest, NULL);
    api_call_free(&replay.call);
    api_buffer_clear(&replay.out);
    api_buffer_clear(&file);
    return status;
}

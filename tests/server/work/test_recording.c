#include "server/work/recording.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

/* a recording with a body, written with its answer */
static void recording_text(struct api_buffer *text, char seal[API_DIGEST_BYTES]) {
    static const char body[] = "{\"pendulum\":\n{}}";
    struct srv_recording made = {
        .engine = "0123456789abcdef",
        .method = "POST",
        .target = "/v1/trees?a=b",
        .request = {.op = API_OP_TREES,
                    .argument = "name",
                    .body = body,
                    .body_bytes = sizeof body - 1},
        .field = {{"Content-Type", "application/json"}, {"Accept", "a: b"}},
        .fields = 2};
    struct srv_recording_answer answer = {.end = SRV_RECORDING_STREAM, .status = 200};
    char line[SRV_RECORDING_ANSWER];
    api_limits_init(&made.limits);
    made.limits.arms = 7;
    memset(answer.digest, 'a', 64);
    answer.digest[64] = 0;
    api_buffer_init(text, 1 << 16);
    CHECK_INT(srv_recording_write_head(&made, text), PEND_OK);
    CHECK_INT(api_buffer_add(text, body, sizeof body - 1), PEND_OK);
    int bytes = srv_recording_write_answer(&answer, made.seal, line);
    CHECK(bytes > 0 && bytes < SRV_RECORDING_ANSWER);
    CHECK_INT(api_buffer_add(text, line, (size_t)bytes), PEND_OK);
    memcpy(seal, made.seal, API_DIGEST_BYTES);
}

/* reads a copy of a text; every byte of the copy that is read is the copy's */
static enum pend_status recording_of(struct srv_recording *read, char **copy, const char *text,
                                     size_t bytes, struct pend_error *error) {
    *error = (struct pend_error){.text = ""};
    *copy = malloc(bytes + !bytes);
    memcpy(*copy, text, bytes);
    return srv_recording_read(read, *copy, bytes, error);
}

TEST(a_recording_reads_back_as_it_was_written) {
    struct api_buffer text;
    struct srv_recording read;
    struct pend_error error;
    char seal[API_DIGEST_BYTES], *copy;
    recording_text(&text, seal);
    CHECK_INT(recording_of(&read, &copy, text.data, text.bytes, &error), PEND_OK);
    CHECK_TEXT(error.text, "");
    CHECK_TEXT(read.seal, seal);
    CHECK_TEXT(read.engine, "0123456789abcdef");
    CHECK_TEXT(read.method, "POST");
    CHECK_TEXT(read.target, "/v1/trees?a=b");
    CHECK_INT(read.request.op, API_OP_TREES);
    CHECK_TEXT(read.request.argument, "name");
    CHECK_TEXT(read.request.query, "a=b");
    CHECK_TEXT(read.request.content_type, "application/json");
    CHECK_TEXT(read.request.accept, "a: b");
    CHECK_INT((long long)read.request.body_bytes, 16);
    CHECK(!memcmp(read.request.body, "{\"pendulum\":\n{}}", 16));
    CHECK_INT((long long)read.limits.arms, 7);
    CHECK_INT(read.answer.end, SRV_RECORDING_STREAM);
    CHECK_INT(read.answer.status, 200);
    CHECK_INT((long long)strspn(read.answer.digest, "a"), 64);
    free(copy);
    api_buffer_clear(&text);
}

TEST(a_recording_that_differs_in_a_bit_or_is_cut_is_refused_with_words) {
    struct api_buffer text;
    struct srv_recording read;
    struct pend_error error;
    char seal[API_DIGEST_BYTES], *copy;
    recording_text(&text, seal);
    char *end = memchr(text.data, '\n', text.bytes);
    size_t answer = text.bytes;
    while (memcmp(text.data + answer - 8, "\nanswer ", 8)) answer--;
    answer -= 8;
    REQUIRE(end != NULL);
    for (size_t i = 0; i < text.bytes; i++) {
        text.data[i] ^= 1;
        enum pend_status status = recording_of(&read, &copy, text.data, text.bytes, &error);
        CHECK_SAYING(status == PEND_INVALID && error.text[0], "byte %zu is not missed", i);
        text.data[i] ^= 1;
        free(copy);
    }
    for (size_t cut = 0; cut < text.bytes; cut++) {
        enum pend_status status = recording_of(&read, &copy, text.data, cut, &error);
        /* the answer's line alone may be missing as a whole */
        CHECK_SAYING(cut == answer ? status == PEND_OK && read.answer.end == SRV_RECORDING_NONE
                                   : status == PEND_INVALID && error.text[0],
                     "the first %zu bytes are taken", cut);
        free(copy);
    }
    api_buffer_clear(&text);
}

/* a text of good seals whose head is not what a recorder writes */
static void recording_forge(struct api_buffer *text, const char *head) {
    char seal[API_DIGEST_BYTES];
    struct api_digest_stream *stream = api_digest_begin();
    REQUIRE(stream != NULL);
    api_digest_add(stream, head, strlen(head));
    api_digest_end(&stream, seal);
    api_buffer_init(text, 1 << 16);
    CHECK_INT(api_buffer_format(text, "pendulumd request 1 %zu 0 %s\n%s", strlen(head), seal, head),
              PEND_OK);
}

TEST(a_recording_whose_head_is_none_is_refused_whatever_its_seal) {
    static const char *const heads[] = {
        "",
        "\n",
        "x",
        "\n\n",
        "engine: a\n\n",
        "engine: a\noperation: nothing\nmethod: GET\ntarget: /\n\n",
        "engine: a\noperation: trees\nmethod: GET\n\n",
        "engine: a\noperation: trees\nmethod: GET\ntarget: /\nwhat: b\n\n",
        "engine: a\noperation: trees\nmethod: GET\ntarget: /\nlimit: max-arms\n\n",
        "engine: a\noperation: trees\nmethod: GET\ntarget: /\nlimit: max-arms 0\n\n",
        "engine: a\noperation: trees\nmethod: GET\ntarget: /\nlimit: max-arms nan\n\n",
        "engine: a\noperation: trees\nmethod: GET\ntarget: /\nlimit: max-none 1\n\n",
        "engine: a\noperation: trees\nmethod: GET\ntarget: /\nfield: b\n\n",
        "engine: a\noperation: trees\nmethod: GET\ntarget: /\nfield: b: 1\nfield: b: 1\nfield: b: "
        "1\n"
        "field: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: "
        "1\n"
        "field: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: 1\nfield: b: "
        "1\n\n",
    };
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        struct api_buffer text;
        struct srv_recording read;
        struct pend_error error;
        char *copy;
        recording_forge(&text, heads[i]);
        enum pend_status status = recording_of(&read, &copy, text.data, text.bytes, &error);
        CHECK_SAYING(status == PEND_INVALID && error.text[0], "head %zu is taken", i);
        free(copy);
        api_buffer_clear(&text);
    }
}

TEST(a_line_feed_in_a_text_is_not_written) {
    struct srv_recording made = {.engine = "a",
                                 .method = "GET",
                                 .target = "/v1/presets\nlimit: max-arms 1",
                                 .request = {.op = API_OP_PRESETS}};
    struct api_buffer text;
    api_limits_init(&made.limits);
    api_buffer_init(&text, 1 << 16);
    CHECK_INT(srv_recording_write_head(&made, &text), PEND_INVALID);
    CHECK_INT((long long)text.bytes, 0);
    api_buffer_clear(&text);
}

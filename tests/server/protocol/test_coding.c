/* Tests of server/protocol/coding, coding_gzip and coding_zstd: the choice, and that the output can
 * be decoded. */
#include "server/protocol/coding.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#include <zstd.h>

#include "tests/harness/test.h"

TEST(the_coding_a_client_likes_best_is_chosen) {
    static const struct {
        const char *accept;
        enum srv_coding coding;
    } asked[] = {
        {NULL, SRV_IDENTITY},
        {"", SRV_IDENTITY},
        {"identity", SRV_IDENTITY},
        {"br, deflate", SRV_IDENTITY},
        {"gzip", SRV_GZIP},
        {"GZIP", SRV_GZIP},
        {"gzip, deflate, br, zstd", SRV_ZSTD},
        {"gzip;q=1.0, zstd;q=0.5", SRV_GZIP},
        {"gzip;q=0.2,zstd;q=0.20", SRV_ZSTD},
        {"gzip;q=0", SRV_IDENTITY},
        {"gzip;q=0.000, *;q=0", SRV_IDENTITY},
        {"*", SRV_ZSTD},
        {"zstd;q=0, *", SRV_GZIP},
        {"gzipped, xgzip", SRV_IDENTITY},
        {"gzip;q=0.5, identity", SRV_IDENTITY},
        {"gzip ; q=0.5", SRV_GZIP},
        {"gzip;level=9", SRV_IDENTITY},
        {",,gzip,,", SRV_GZIP},
        {";q=1", SRV_IDENTITY},
    };
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++)
        CHECK_SAYING(srv_coding_choose(asked[i].accept) == asked[i].coding, "%s: %d",
                     asked[i].accept ? asked[i].accept : "none",
                     srv_coding_choose(asked[i].accept));
    CHECK(srv_coding_worth("application/json") && srv_coding_worth("text/csv; charset=utf-8"));
    CHECK(!srv_coding_worth("application/octet-stream") && !srv_coding_worth("application/x-npz") &&
          !srv_coding_worth(NULL));
}

/* decodes; returns the length, or a number above cap if that fails */
static size_t coding_undo(enum srv_coding coding, const struct api_buffer *in, char *to,
                          size_t cap) {
    if (coding == SRV_ZSTD) {
        ZSTD_DCtx *context = ZSTD_createDCtx();
        ZSTD_inBuffer from = {in->data, in->bytes, 0};
        ZSTD_outBuffer out = {to, cap, 0};
        size_t left = 1;
        while (from.pos < from.size && !ZSTD_isError(left)) {
            size_t before = from.pos + out.pos;
            left = ZSTD_decompressStream(context, &out, &from);
            if (from.pos + out.pos == before) break;
        }
        ZSTD_freeDCtx(context);
        return ZSTD_isError(left) ? cap + 1 : out.pos;
    }
    z_stream stream = {.next_in = (void *)in->data,
                       .avail_in = (uInt)in->bytes,
                       .next_out = (void *)to,
                       .avail_out = (uInt)cap};
    if (inflateInit2(&stream, 15 + 16) != Z_OK) return cap + 1;
    int result = inflate(&stream, Z_SYNC_FLUSH);
    inflateEnd(&stream);
    return result == Z_OK || result == Z_STREAM_END || result == Z_BUF_ERROR
               ? cap - stream.avail_out
               : cap + 1;
}

TEST(what_was_written_is_read_again_whole_and_in_pieces) {
    enum { BYTES = 700000 };
    char *text = malloc(BYTES), *back = malloc(BYTES + 1);
    unsigned long long random = 5;
    REQUIRE(text && back);
    for (int i = 0; i < BYTES; i++) text[i] = (char)('0' + test_random_int(&random, 10));
    for (int coding = SRV_GZIP; coding < SRV_CODINGS; coding++) {
        const struct srv_coding_row *row = srv_coding_at((enum srv_coding)coding);
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, 2 * BYTES);
        CHECK(srv_coding_whole((enum srv_coding)coding, text, BYTES, &out) == PEND_OK);
        CHECK_SAYING(out.bytes < 0.6 * BYTES, "%s: %zu bytes", row->name, out.bytes);
        CHECK(coding_undo((enum srv_coding)coding, &out, back, BYTES + 1) == BYTES &&
              !memcmp(text, back, BYTES));
        out.bytes = 0;
        void *state = row->begin();
        REQUIRE(state != NULL);
        for (int at = 0; at < BYTES;) {
            int piece = test_random_int(&random, 90000), flush = test_random_int(&random, 4) == 0;
            if (piece > BYTES - at) piece = BYTES - at;
            CHECK(row->write(state, text + at, (size_t)piece,
                             flush ? SRV_CODING_FLUSH : SRV_CODING_MORE, &out) == PEND_OK);
            at += piece;
            /* flushed bytes can be decoded without those that follow */
            if (flush)
                CHECK(coding_undo((enum srv_coding)coding, &out, back, BYTES + 1) == (size_t)at);
        }
        CHECK(row->write(state, "", 0, SRV_CODING_END, &out) == PEND_OK);
        CHECK(coding_undo((enum srv_coding)coding, &out, back, BYTES + 1) == BYTES &&
              !memcmp(text, back, BYTES));
        row->free(state);
        api_buffer_clear(&out);
        /* not enough space */
        api_buffer_init(&out, 1000);
        CHECK(srv_coding_whole((enum srv_coding)coding, text, BYTES, &out) == PEND_LIMIT);
    }
    free(text);
    free(back);
}

#include <zstd.h>

#include "server/protocol/coding.h"

enum {
    ZSTD_LEVEL = 1,   /* the best ratio on digits too (2.28), at 5 ms per megabyte */
    ZSTD_WINDOW = 18, /* 256 KiB, the size of a sent block */
    ZSTD_ROOM = 16384
};

static void *zstd_begin(void) {
    ZSTD_CCtx *context = ZSTD_createCCtx();
    if (!context) return NULL;
    ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, ZSTD_LEVEL);
    ZSTD_CCtx_setParameter(context, ZSTD_c_windowLog, ZSTD_WINDOW);
    return context;
}

static enum pend_status zstd_write(void *state, const void *data, size_t bytes,
                                   enum srv_coding_end end, struct api_buffer *out) {
    static const ZSTD_EndDirective directive[] = {ZSTD_e_continue, ZSTD_e_flush, ZSTD_e_end};
    ZSTD_inBuffer in = {data, bytes, 0};
    for (;;) {
        PEND_TRY(api_buffer_room(out, ZSTD_ROOM));
        ZSTD_outBuffer to = {out->data + out->bytes, out->cap - out->bytes, 0};
        size_t left = ZSTD_compressStream2(state, &to, &in, directive[end]);
        if (ZSTD_isError(left)) return PEND_NO_MEMORY;
        out->bytes += to.pos;
        if (end == SRV_CODING_MORE ? in.pos == in.size : !left) return PEND_OK;
    }
}

static void zstd_free(void *state) { ZSTD_freeCCtx(state); }

const struct srv_coding_row srv_coding_zstd = {"zstd",     1300000,   zstd_begin,
                                               zstd_write, zstd_free, NULL};

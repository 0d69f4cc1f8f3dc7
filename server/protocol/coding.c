#include "server/protocol/coding.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const struct srv_coding_row *const coding_table[SRV_CODINGS] = {
    [SRV_GZIP] = &srv_coding_gzip,
    [SRV_ZSTD] = &srv_coding_zstd,
};

static const char *const coding_texts[] = {"application/json", "application/x-ndjson",
                                           "application/problem+json", "text/"};

const struct srv_coding_row *srv_coding_at(enum srv_coding coding) {
    assert(coding >= SRV_IDENTITY && coding < SRV_CODINGS);
    return coding_table[coding];
}

/* the q-value in the parameters of an element, in thousandths; 1000 if absent, 0 if malformed */
static int coding_quality(const char *at, const char *end) {
    while (at < end && *at != ';') at++;
    if (at == end) return 1000;
    at++;
    while (at < end && (*at == ' ' || *at == '\t')) at++;
    if (end - at < 3 || (*at | 32) != 'q' || at[1] != '=') return 0;
    int quality = 0, unit = 1000;
    for (at += 2; at < end; at++) {
        if (*at == '.') continue;
        if (*at < '0' || *at > '9') break;
        quality += (*at - '0') * unit;
        unit /= 10;
    }
    return quality > 1000 ? 1000 : quality;
}

static int coding_named(const char *at, const char *end, const char *name) {
    size_t bytes = strlen(name);
    return (size_t)(end - at) >= bytes && !strncasecmp(at, name, bytes) &&
           (at + bytes == end || strchr("; \t", at[bytes]));
}

/* the q-value of every coding; 0 = not acceptable */
static void coding_qualities(const char *accept, int quality[SRV_CODINGS]) {
    int named[SRV_CODINGS] = {0}, any = 0;
    memset(quality, 0, SRV_CODINGS * sizeof *quality);
    for (const char *at = accept; at && *at;) {
        const char *end = at + strcspn(at, ",");
        while (at < end && (*at == ' ' || *at == '\t')) at++;
        for (int i = SRV_GZIP; i < SRV_CODINGS; i++) {
            if (!coding_named(at, end, coding_table[i]->name)) continue;
            quality[i] = coding_quality(at, end);
            named[i] = 1;
        }
        if (coding_named(at, end, "identity")) quality[SRV_IDENTITY] = coding_quality(at, end);
        if (coding_named(at, end, "*")) any = coding_quality(at, end);
        at = *end ? end + 1 : end;
    }
    for (int i = SRV_GZIP; i < SRV_CODINGS; i++)
        if (!named[i]) quality[i] = any;
}

enum srv_coding srv_coding_choose(const char *accept) {
    int quality[SRV_CODINGS], best = SRV_IDENTITY;
    coding_qualities(accept, quality);
    for (int i = SRV_GZIP; i < SRV_CODINGS; i++)
        if (quality[i] && quality[i] >= quality[best]) best = i;
    return best;
}

int srv_coding_accepts(const char *accept, enum srv_coding coding) {
    int quality[SRV_CODINGS];
    coding_qualities(accept, quality);
    return quality[coding] > 0;
}

int srv_coding_worth(const char *media_type) {
    for (size_t i = 0; i < sizeof coding_texts / sizeof *coding_texts; i++)
        if (media_type && !strncmp(media_type, coding_texts[i], strlen(coding_texts[i]))) return 1;
    return 0;
}

enum pend_status srv_coding_whole(enum srv_coding coding, const void *data, size_t bytes,
                                  struct api_buffer *out) {
    const struct srv_coding_row *row = coding_table[coding];
    assert(row);
    if (row->whole) return row->whole(data, bytes, out);
    void *state = row->begin();
    enum pend_status status =
        state ? row->write(state, data, bytes, SRV_CODING_END, out) : PEND_NO_MEMORY;
    if (state) row->free(state);
    return status;
}

#include "api/call/crate_read.h"

#include <assert.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "api/encode/zip64.h"
#include "api/json/json_in.h"

enum { READ_COMMENT = 65535, READ_DEPTH = 16 };

struct archive {
    const unsigned char *data;
    uint64_t bytes;
    uint64_t at, files; /* of the directory */
};

struct piece {
    const char *data;
    size_t bytes;
};

static uint64_t read_whole(const unsigned char *at, int bytes) {
    uint64_t x = 0;
    while (bytes-- > 0) x = x << 8 | at[bytes];
    return x;
}

static enum pend_status read_fails(struct pend_error *error, const char *why) {
    return pend_fail(error, PEND_INVALID, -1, 0, "%s", why);
}

int api_crate_looks(const void *data, size_t bytes) {
    return bytes >= 4 && !memcmp(data, "PK\3\4", 4);
}

/* finds the directory; 0 where there is none */
static int archive_open(struct archive *archive, const void *data, size_t bytes) {
    *archive = (struct archive){.data = data, .bytes = bytes};
    if (bytes < API_ZIP64_END_HEAD) return 0;
    size_t last = bytes - API_ZIP64_END_HEAD, first = last > READ_COMMENT ? last - READ_COMMENT : 0;
    while (last > first && read_whole(archive->data + last, 4) != API_ZIP64_END_SIGN) last--;
    const unsigned char *end = archive->data + last;
    if (read_whole(end, 4) != API_ZIP64_END_SIGN) return 0;
    archive->files = read_whole(end + 10, 2);
    archive->at = read_whole(end + 16, 4);
    if (archive->at != API_ZIP64_THERE) return 1;
    if (last < API_ZIP64_LOCATOR ||
        read_whole(end - API_ZIP64_LOCATOR, 4) != API_ZIP64_LOCATOR_SIGN)
        return 0;
    uint64_t at = read_whole(end - API_ZIP64_LOCATOR + 8, 8);
    if (bytes < API_ZIP64_END_WIDE || at > bytes - API_ZIP64_END_WIDE) return 0;
    if (read_whole(archive->data + at, 4) != API_ZIP64_END_WIDE_SIGN) return 0;
    archive->files = read_whole(archive->data + at + 32, 8);
    archive->at = read_whole(archive->data + at + 48, 8);
    return 1;
}

/* the numbers of a row that stand in its extra field of ZIP64; 0 where they do not */
static int row_large(const unsigned char *extra, size_t bytes, uint64_t *packed, uint64_t *length,
                     uint64_t *offset) {
    uint64_t *const number[] = {length, packed, offset};
    while (bytes >= 4) {
        size_t tag = read_whole(extra, 2), size = read_whole(extra + 2, 2), at = 4;
        if (size > bytes - 4) return 0;
        for (int i = 0; tag == 1 && i < 3; i++) {
            if (*number[i] != API_ZIP64_THERE) continue;
            if (at + 8 > size + 4) return 0;
            *number[i] = read_whole(extra + at, 8);
            at += 8;
        }
        if (tag == 1) return 1;
        extra += size + 4;
        bytes -= size + 4;
    }
    return 0;
}

/* the bytes of the file whose row of the directory this is; 0 where they are not there, or packed
 */
static int row_piece(const struct archive *archive, const unsigned char *row, struct piece *piece) {
    uint64_t packed = read_whole(row + 20, 4), length = read_whole(row + 24, 4),
             offset = read_whole(row + 42, 4);
    size_t name = read_whole(row + 28, 2), extra = read_whole(row + 30, 2);
    if ((packed == API_ZIP64_THERE || length == API_ZIP64_THERE || offset == API_ZIP64_THERE) &&
        !row_large(row + API_ZIP64_CENTRAL_HEAD + name, extra, &packed, &length, &offset))
        return 0;
    if (read_whole(row + 10, 2) || packed != length) return 0;
    if (archive->bytes < API_ZIP64_LOCAL_HEAD || offset > archive->bytes - API_ZIP64_LOCAL_HEAD)
        return 0;
    const unsigned char *local = archive->data + offset;
    uint64_t head = API_ZIP64_LOCAL_HEAD + read_whole(local + 26, 2) + read_whole(local + 28, 2);
    if (head > archive->bytes - offset || length > archive->bytes - offset - head) return 0;
    *piece = (struct piece){(const char *)local + head, (size_t)length};
    return read_whole(local, 4) == API_ZIP64_LOCAL_SIGN;
}

/* the bytes of a file; 0 where it is not there as it was written */
static int archive_find(const struct archive *archive, const char *name, struct piece *piece) {
    uint64_t at = archive->at;
    for (uint64_t i = 0; i < archive->files; i++) {
        if (archive->bytes < API_ZIP64_CENTRAL_HEAD || at > archive->bytes - API_ZIP64_CENTRAL_HEAD)
            return 0;
        const unsigned char *row = archive->data + at;
        size_t letters = read_whole(row + 28, 2);
        uint64_t more = letters + read_whole(row + 30, 2) + read_whole(row + 32, 2);
        if (read_whole(row, 4) != API_ZIP64_CENTRAL_SIGN ||
            more > archive->bytes - at - API_ZIP64_CENTRAL_HEAD)
            return 0;
        if (letters == strlen(name) && !memcmp(row + API_ZIP64_CENTRAL_HEAD, name, letters))
            return row_piece(archive, row, piece);
        at += API_ZIP64_CENTRAL_HEAD + more;
    }
    return 0;
}

/* the text of an entity's member; NULL where there is none */
static const char *graph_text(const struct api_value *graph, const char *id, const char *member) {
    for (struct api_value item = api_value_first(graph); api_value_kind(&item) != API_MISSING;
         item = api_value_next(&item)) {
        struct api_value own = api_value_member(&item, "@id"), wanted;
        const char *text = api_value_text(&own);
        if (!text || strcmp(text, id) != 0) continue;
        wanted = api_value_member(&item, member);
        if (api_value_kind(&wanted) != API_OBJECT) return api_value_text(&wanted);
        own = api_value_member(&wanted, "@id");
        return api_value_text(&own);
    }
    return NULL;
}

static int text_copy(char *to, size_t cap, const char *text) {
    return text && (size_t)snprintf(to, cap, "%s", text) < cap;
}

static enum api_op_id read_op(const char *name) {
    int op = 0;
    while (op < API_OP_COUNT && (!name || strcmp(api_op_at((enum api_op_id)op)->name, name))) op++;
    return (enum api_op_id)op;
}

/* whether the bytes have the digest that is said; `why` is told where they have another */
static enum pend_status read_same(const struct piece *piece, const char *digest, const char *why,
                                  struct pend_error *error) {
    char own[API_DIGEST_BYTES];
    struct api_digest_stream *stream = api_digest_begin();
    if (!stream) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    api_digest_add(stream, piece->data, piece->bytes);
    api_digest_end(&stream, own);
    return digest && !strcmp(own, digest) ? PEND_OK : read_fails(error, why);
}

/* takes what the graph says of the run */
static enum pend_status claim_read(struct api_crate_claim *claim, const struct archive *archive,
                                   const struct api_value *graph, struct pend_error *error) {
    struct piece request, results;
    const char *name = graph_text(graph, "#run", "result");
    const char *type = graph_text(graph, "#entry", "contentType");
    const struct api_format *format = NULL;
    *claim = (struct api_crate_claim){.request.op = read_op(graph_text(graph, "#entry", "name"))};
    if (!name || claim->request.op == API_OP_COUNT || !api_op_at(claim->request.op)->table)
        return read_fails(error, "its metadata name no run that this program knows");
    for (int i = 0; type && (format = api_format_at(i)) && strcmp(format->media_type, type); i++) {
    }
    if (!format) return read_fails(error, "its results have a form that this program cannot write");
    if (!archive_find(archive, api_crate_request, &request) ||
        !archive_find(archive, name, &results))
        return read_fails(error, "its request or its results are not in it, or packed: a crate is "
                                 "to be given as the server has sent it");
    PEND_TRY(read_same(&request, graph_text(graph, api_crate_request, "sha256"),
                       "its request is another than its metadata say: the digest differs", error));
    if (!text_copy(claim->digest, sizeof claim->digest, graph_text(graph, name, "sha256")))
        claim->digest[0] = 0;
    PEND_TRY(read_same(&results, claim->digest,
                       "its results are others than its metadata say: the digest differs", error));
    if (!text_copy(claim->version, sizeof claim->version,
                   graph_text(graph, "#pendulumd", "softwareVersion")))
        claim->version[0] = 0;
    claim->request.content_type = "application/json";
    claim->request.accept = format->media_type;
    claim->request.body = request.data;
    claim->request.body_bytes = request.bytes;
    claim->results = results.data;
    claim->results_bytes = results.bytes;
    return PEND_OK;
}

enum pend_status api_crate_read(struct api_crate_claim *claim, const void *data, size_t bytes,
                                struct pend_error *error) {
    struct archive archive;
    struct piece metadata;
    struct api_json *document = NULL;
    struct api_problem problem;
    *claim = (struct api_crate_claim){.digest = ""};
    if (!archive_open(&archive, data, bytes))
        return read_fails(error, "it is no whole archive: the end is missing");
    if (!archive_find(&archive, api_crate_metadata, &metadata))
        return read_fails(error, "it has no ro-crate-metadata.json, or that is packed");
    api_problem_init(&problem);
    enum pend_status status =
        api_json_new(&document, metadata.data, metadata.bytes, READ_DEPTH, &problem);
    api_problem_clear(&problem);
    if (status == PEND_NO_MEMORY) return pend_fail(error, status, -1, 0, "out of memory");
    if (status != PEND_OK) return read_fails(error, "its ro-crate-metadata.json is not JSON");
    struct api_value root = api_json_root(document), graph = api_value_member(&root, "@graph");
    status = claim_read(claim, &archive, &graph, error);
    api_json_free(&document);
    assert(status != PEND_OK || claim->request.body);
    return status;
}

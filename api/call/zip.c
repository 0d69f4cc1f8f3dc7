#include "api/call/zip.h"

#include <assert.h>
#include <libdeflate.h>
#include <string.h>

#include "api/base/octets.h"

enum {
    ZIP_LOCAL = 30, /* bytes of the heads without name and extra field */
    ZIP_CENTRAL = 46,
    ZIP_EXTRA_LOCAL = 20,
    ZIP_EXTRA_CENTRAL = 28,
    ZIP_DESCRIPTOR = 24,
    ZIP_END = 22,
    ZIP_END_64 = 56 + 20,
    ZIP_PLAIN = 20, /* the version that a reader needs: of a plain file, of one with ZIP64 */
    ZIP_LARGE = 45,
    ZIP_STREAMED = 1 << 3, /* the checksum stands behind the file */
    ZIP_DATE = 0x21        /* 1 January 1980: the same job gives the same bytes */
};

static const uint64_t zip_most = 0xffffffff; /* what 4 bytes hold, and what says "see there" */

static char *zip_whole32(char *at, uint64_t x) {
    return api_octets_whole(at, x < zip_most ? x : zip_most, 4);
}

static enum pend_status zip_append(struct api_zip *zip, const void *data, size_t bytes,
                                   struct api_buffer *out) {
    PEND_TRY(api_buffer_add(out, data, bytes));
    zip->written += bytes;
    return PEND_OK;
}

/* what the two heads of a file have in common, from the version to the length of the extra field */
static char *zip_facts(char *at, const struct api_zip_file *file, int version, int ended,
                       size_t extra) {
    uint64_t bytes = ended ? file->bytes : zip_most;
    at = api_octets_whole(at, (uint64_t)version, 2);
    at = api_octets_whole(at, file->streamed ? ZIP_STREAMED : 0, 2);
    at = api_octets_whole(at, 0, 2 + 2); /* stored; 0:00 */
    at = api_octets_whole(at, ZIP_DATE, 2);
    at = api_octets_whole(at, ended ? file->crc : 0, 4);
    at = zip_whole32(zip_whole32(at, bytes), bytes);
    at = api_octets_whole(at, strlen(file->name), 2);
    return api_octets_whole(at, extra, 2);
}

static struct api_zip_file *zip_new(struct api_zip *zip, const char *name) {
    assert(zip->files < API_ZIP_FILES && !zip->open && strlen(name) < API_ZIP_NAME);
    struct api_zip_file *file = &zip->file[zip->files++];
    *file = (struct api_zip_file){.offset = zip->written};
    strcpy(file->name, name);
    return file;
}

enum pend_status api_zip_add(struct api_zip *zip, const char *name, const void *data, size_t bytes,
                             struct api_buffer *out) {
    struct api_zip_file *file = zip_new(zip, name);
    char head[ZIP_LOCAL];
    assert(bytes < zip_most);
    file->bytes = bytes;
    file->crc = libdeflate_crc32(0, data, bytes);
    zip_facts(api_octets_whole(head, 0x04034b50, 4), file, ZIP_PLAIN, 1, 0);
    PEND_TRY(zip_append(zip, head, sizeof head, out));
    PEND_TRY(zip_append(zip, name, strlen(name), out));
    return zip_append(zip, data, bytes, out);
}

enum pend_status api_zip_begin(struct api_zip *zip, const char *name, struct api_buffer *out) {
    struct api_zip_file *file = zip_new(zip, name);
    char head[ZIP_LOCAL], extra[ZIP_EXTRA_LOCAL];
    file->streamed = zip->open = 1;
    zip_facts(api_octets_whole(head, 0x04034b50, 4), file, ZIP_LARGE, 0, sizeof extra);
    /* an extra field of ZIP64, whose lengths stand behind the file as well */
    memset(extra, 0, sizeof extra);
    api_octets_whole(api_octets_whole(extra, 1, 2), sizeof extra - 4, 2);
    PEND_TRY(zip_append(zip, head, sizeof head, out));
    PEND_TRY(zip_append(zip, name, strlen(name), out));
    return zip_append(zip, extra, sizeof extra, out);
}

void api_zip_pass(struct api_zip *zip, const void *data, size_t bytes) {
    assert(zip->open && zip->files >= 1);
    struct api_zip_file *file = &zip->file[zip->files - 1];
    file->crc = libdeflate_crc32(file->crc, data, bytes);
    file->bytes += bytes;
    zip->written += bytes;
}

enum pend_status api_zip_close(struct api_zip *zip, struct api_buffer *out) {
    assert(zip->open && zip->files >= 1);
    const struct api_zip_file *file = &zip->file[zip->files - 1];
    char text[ZIP_DESCRIPTOR], *at = api_octets_whole(text, 0x08074b50, 4);
    at = api_octets_whole(at, file->crc, 4);
    api_octets_whole(api_octets_whole(at, file->bytes, 8), file->bytes, 8);
    zip->open = 0;
    return zip_append(zip, text, sizeof text, out);
}

/* a file's row of the directory */
static enum pend_status zip_row(struct api_zip *zip, const struct api_zip_file *file,
                                struct api_buffer *out) {
    char head[ZIP_CENTRAL], extra[ZIP_EXTRA_CENTRAL], *at = head;
    int large = file->bytes >= zip_most || file->offset >= zip_most;
    char *end = api_octets_whole(extra, 1, 2) + 2;
    if (file->bytes >= zip_most)
        end = api_octets_whole(api_octets_whole(end, file->bytes, 8), file->bytes, 8);
    if (file->offset >= zip_most) end = api_octets_whole(end, file->offset, 8);
    size_t more = large ? (size_t)(end - extra) : 0;
    api_octets_whole(extra + 2, (uint64_t)(end - extra) - 4, 2);
    at = api_octets_whole(api_octets_whole(at, 0x02014b50, 4), ZIP_LARGE, 2);
    at = zip_facts(at, file, file->streamed ? ZIP_LARGE : ZIP_PLAIN, 1, more);
    at = api_octets_whole(at, 0, 2 + 2 + 2); /* no comment, disk 0, no inner attributes */
    zip_whole32(api_octets_whole(at, 0, 4), file->offset);
    PEND_TRY(zip_append(zip, head, sizeof head, out));
    PEND_TRY(zip_append(zip, file->name, strlen(file->name), out));
    return zip_append(zip, extra, more, out);
}

/* the end of a directory that 4 bytes cannot place */
static enum pend_status zip_end_64(struct api_zip *zip, uint64_t begin, struct api_buffer *out) {
    char text[ZIP_END_64], *at = api_octets_whole(text, 0x06064b50, 4);
    uint64_t here = zip->written, files = (uint64_t)zip->files;
    at = api_octets_whole(at, 44, 8); /* bytes of this record behind this number */
    at = api_octets_whole(api_octets_whole(at, ZIP_LARGE, 2), ZIP_LARGE, 2);
    at = api_octets_whole(at, 0, 4 + 4);
    at = api_octets_whole(api_octets_whole(at, files, 8), files, 8);
    at = api_octets_whole(api_octets_whole(at, here - begin, 8), begin, 8);
    at = api_octets_whole(api_octets_whole(at, 0x07064b50, 4), 0, 4);
    api_octets_whole(api_octets_whole(at, here, 8), 1, 4);
    return zip_append(zip, text, sizeof text, out);
}

enum pend_status api_zip_end(struct api_zip *zip, struct api_buffer *out) {
    uint64_t begin = zip->written, files = (uint64_t)zip->files;
    char text[ZIP_END], *at = api_octets_whole(text, 0x06054b50, 4);
    assert(!zip->open);
    for (int i = 0; i < zip->files; i++) PEND_TRY(zip_row(zip, &zip->file[i], out));
    uint64_t bytes = zip->written - begin;
    if (begin >= zip_most) PEND_TRY(zip_end_64(zip, begin, out));
    at = api_octets_whole(at, 0, 2 + 2); /* disk 0, of none more */
    at = api_octets_whole(api_octets_whole(at, files, 2), files, 2);
    at = zip_whole32(api_octets_whole(at, bytes, 4), begin);
    api_octets_whole(at, 0, 2);
    return zip_append(zip, text, sizeof text, out);
}

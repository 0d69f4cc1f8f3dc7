#include "api/call/zip.h"

#include <assert.h>
#include <libdeflate.h>
#include <string.h>

static enum pend_status zip_append(struct api_zip *zip, const void *data, size_t bytes,
                                   struct api_buffer *out) {
    PEND_TRY(api_buffer_add(out, data, bytes));
    zip->written += bytes;
    return PEND_OK;
}

/* appends a record that was written between `text` and `end` */
static enum pend_status zip_record(struct api_zip *zip, const char *text, const char *end,
                                   struct api_buffer *out) {
    return zip_append(zip, text, (size_t)(end - text), out);
}

static struct api_zip64_member *zip_new(struct api_zip *zip, const char *name) {
    assert(zip->files < API_ZIP_FILES && !zip->open && strlen(name) < API_ZIP64_NAME);
    struct api_zip64_member *file = &zip->file[zip->files++];
    *file = (struct api_zip64_member){.offset = zip->written};
    strcpy(file->name, name);
    return file;
}

enum pend_status api_zip_add(struct api_zip *zip, const char *name, const void *data, size_t bytes,
                             struct api_buffer *out) {
    struct api_zip64_member *file = zip_new(zip, name);
    char head[API_ZIP64_LOCAL];
    file->bytes = bytes;
    file->crc = libdeflate_crc32(0, data, bytes);
    PEND_TRY(zip_record(zip, head, api_zip64_local(head, file, API_ZIP64_MOST), out));
    return zip_append(zip, data, bytes, out);
}

enum pend_status api_zip_begin(struct api_zip *zip, const char *name, struct api_buffer *out) {
    struct api_zip64_member *file = zip_new(zip, name);
    char head[API_ZIP64_LOCAL];
    file->streamed = zip->open = 1;
    return zip_record(zip, head, api_zip64_local(head, file, API_ZIP64_MOST), out);
}

void api_zip_pass(struct api_zip *zip, const void *data, size_t bytes) {
    assert(zip->open && zip->files >= 1);
    struct api_zip64_member *file = &zip->file[zip->files - 1];
    file->crc = libdeflate_crc32(file->crc, data, bytes);
    file->bytes += bytes;
    zip->written += bytes;
}

enum pend_status api_zip_close(struct api_zip *zip, struct api_buffer *out) {
    assert(zip->open && zip->files >= 1);
    char text[API_ZIP64_BEHIND];
    zip->open = 0;
    return zip_record(zip, text, api_zip64_behind(text, &zip->file[zip->files - 1]), out);
}

enum pend_status api_zip_end(struct api_zip *zip, struct api_buffer *out) {
    uint64_t begin = zip->written;
    char row[API_ZIP64_CENTRAL], end[API_ZIP64_END];
    assert(!zip->open);
    for (int i = 0; i < zip->files; i++)
        PEND_TRY(zip_record(zip, row, api_zip64_central(row, &zip->file[i], API_ZIP64_MOST), out));
    uint64_t bytes = zip->written - begin;
    const char *at = api_zip64_end(end, zip->files, begin, bytes, API_ZIP64_MOST);
    return zip_record(zip, end, at, out);
}

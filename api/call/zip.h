/* An archive of files that are stored as they are, written while its bytes are sent.
 * Leaves to others: what the files hold (crate); the archive's records (encode/zip64); archives of
 * arrays (encode_npz).
 * Invariant: the archive's own bytes are counted as they are appended, so that every offset in its
 * directory is that of the whole, however often the caller takes bytes away between two calls. */
#ifndef API_ZIP_H
#define API_ZIP_H

#include "api/base/buffer.h"
#include "api/encode/zip64.h"

enum { API_ZIP_FILES = 8 };

struct api_zip {
    int files;        /* that were begun */
    int open;         /* the last of them is not complete */
    uint64_t written; /* bytes of the archive so far */
    struct api_zip64_member file[API_ZIP_FILES];
};

/**
 * Appends a whole file.
 *
 * zip   all zero before the first file; at most API_ZIP_FILES files.
 * name  shorter than API_ZIP64_NAME, of ASCII.
 *
 * Fails as api_buffer_room does. O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_zip_add(struct api_zip *zip, const char *name,
                                             const void *data, size_t bytes,
                                             struct api_buffer *out);

/** Appends the head of a file whose bytes come later. Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_zip_begin(struct api_zip *zip, const char *name,
                                               struct api_buffer *out);

/** Counts the next bytes of the open file, which the caller has appended itself. O(bytes). */
void api_zip_pass(struct api_zip *zip, const void *data, size_t bytes);

/** Appends what follows upon the last byte of the open file. Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_zip_close(struct api_zip *zip, struct api_buffer *out);

/** Appends the directory, the end of the archive. Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_zip_end(struct api_zip *zip, struct api_buffer *out);

#endif

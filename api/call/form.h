/* A request that comes as a form of files (RFC 7578, `curl -F request=@fit.json -F
 * csv=@track.csv`): the part `request` is its JSON, each part `csv` a table of text as it was
 * saved. Leaves to others: receiving the body (server), what the request means (op_fits).
 * Invariant: what is made is JSON as a client could have sent it itself, with the tables in
 * `data.csv`, or in the `csv` of the runs in `data.runs`, one each, in their order; nothing of a
 * form is passed over that is not told.
 */
#ifndef API_FORM_H
#define API_FORM_H

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/base/problem.h"

enum { API_FORM_BOUNDARY = 70, API_FORM_TABLES = 64 };

/**
 * Writes the JSON of a form.
 *
 * content_type  of the body: multipart/form-data with a boundary.
 * out           empty; grows to at most twice the limit of a body, which no form within it can pass
 *               whose tables have no control characters.
 *
 * A table that is not UTF-8 is read as ISO 8859-1, and a byte order mark is passed over.
 *
 * PEND_INVALID    problem says why: 400 for what is no such form, 422 for parts that it must not
 *                 have.
 * PEND_NO_MEMORY  O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_form_json(const char *content_type, const char *body,
                                               size_t bytes, const struct api_limits *limits,
                                               struct api_buffer *out, struct api_problem *problem);

#endif

/* A request as a multipart form (RFC 7578, `curl -F request=@fit.json -F csv=@track.csv`): the part
 * `request` is JSON, each part `csv` a text table as it was saved.
 * Leaves to others: receiving the body (server), the meaning of the request (op_fits).
 * Invariant: the result is JSON that the client could have sent itself, with the tables in
 * `data.csv` or, one each and in order, in the `csv` of the runs in `data.runs`; no part is
 * silently ignored. */
#pragma once

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/base/problem.h"

enum { API_FORM_BOUNDARY = 70, API_FORM_TABLES = 64 };

/**
 * Writes the JSON of a form.
 *
 * content_type  of the body: multipart/form-data with a boundary.
 * out           empty; grows to at most twice the limit of a body, enough for tables without
 *               control characters.
 *
 * Without a part `request`, the request is {}. Tables are read as in api_form_text.
 *
 * PEND_INVALID    problem says why: 400 if the form is malformed, 422 for unexpected parts.
 * PEND_NO_MEMORY  O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_form_json(const char *content_type, const char *body,
                                               size_t bytes, const struct api_limits *limits,
                                               struct api_buffer *out, struct api_problem *problem);

/**
 * Appends a table as a string of JSON: UTF-8 with or without a byte order mark, UTF-16 with one;
 * any other bytes are read as ISO 8859-1.
 *
 * number  number of the table, from 1, for the message.
 *
 * PEND_INVALID    the bytes are not text; problem has a 422.
 * PEND_NO_MEMORY  O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_form_text(const char *text, size_t bytes, int number,
                                               struct api_buffer *out, struct api_problem *problem);

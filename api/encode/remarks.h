/* Figures and warnings about a computation, in the forms that representations have a place for:
 * members of JSON, comments below a CSV table, fields of a header or a trailer.
 * Leaves to others: the figures themselves (op_*), sending fields (server).
 * Invariant: no text has a comma, a quote or a control character, so that none of these forms
 * needs an escape. */
#ifndef API_REMARKS_H
#define API_REMARKS_H

#include "api/encode/encode.h"

enum { API_REMARKS_FIELDS = 5, API_REMARKS_TEXT = 260 };

/* Fields of HTTP: X-Horizon, X-Trust-Until, X-Energy-Drift, X-Warning. */
struct api_remarks {
    int count;
    struct {
        const char *name; /* static */
        char value[API_REMARKS_TEXT];
    } field[API_REMARKS_FIELDS];
};

/** The names of all such fields, as the field Trailer lists them. */
extern const char api_remarks_names[];

/** Appends the member stats and, if there are warnings, the member warnings, after a comma as
 * api_out_comma says. */
PEND_MUST_CHECK enum pend_status api_remarks_json(const struct api_stats *stats,
                                                  struct api_buffer *out);

/** Appends a line of comment for each warning and for trust_until, if there are any. */
PEND_MUST_CHECK enum pend_status api_remarks_comments(const struct api_stats *stats,
                                                      struct api_buffer *out);

/** Writes the fields of the figures; none if stats is NULL. */
void api_remarks_fields(struct api_remarks *remarks, const struct api_stats *stats);

#endif

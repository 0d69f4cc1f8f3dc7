/* Statistics and warnings of a computation as JSON members, as comments below a CSV table, and as
 * HTTP header or trailer fields.
 * Leaves to others: computing them (op_*), sending fields (server).
 * Invariant: no text contains a comma, a quote or a control character, so none needs an escape. */
#pragma once

#include "api/encode/encode.h"

enum { API_STATS_FIELDS = 5, API_STATS_FIELD_TEXT = 260 };

/* HTTP fields: X-Horizon, X-Trust-Until, X-Energy-Drift, X-Warning. */
struct api_stats_headers {
    int count;
    struct {
        const char *name; /* static */
        char value[API_STATS_FIELD_TEXT];
    } field[API_STATS_FIELDS];
};

/** The names of all these fields, for the header field Trailer. */
extern const char api_stats_field_names[];

/** Appends the member `stats` and, if there are any, `warnings`, with a comma before them if
 * api_out_comma requires it. */
PEND_MUST_CHECK enum pend_status api_stats_json(const struct api_stats *stats,
                                                struct api_buffer *out);

/** Appends a comment line for each warning and for trust_until, if present. */
PEND_MUST_CHECK enum pend_status api_stats_comments(const struct api_stats *stats,
                                                    struct api_buffer *out);

/** Writes the HTTP fields of the statistics; no fields if stats is NULL. */
void api_stats_fields(struct api_stats_headers *stat_fields, const struct api_stats *stats);

/* The routes that read a whole room: its items, its answers as a table, and histograms of answers.
 * Leaves to others: the formats (api/class/class_json, class_table).
 * Invariant: a room is read page by page; other requests take their turn between pages. */
#pragma once

#include "server/work/exchange.h"

/** GET /v1/classes/{code}: the room, and the items that the client may read; ?since=VERSION: only
 * later items. */
void srv_class_reports_room(struct srv_exchange *exchange);

/** GET /v1/classes/{code}/table: all answers as CSV, for the teacher. */
void srv_class_reports_table(struct srv_exchange *exchange);

/** GET /v1/classes/{code}/histograms/{id}: the frequency of each answer to a question, for the
 * teacher. */
void srv_class_reports_histogram(struct srv_exchange *exchange);

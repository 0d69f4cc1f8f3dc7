/* The routes that read a whole room: what stands there, its answers as a table, and how often each
 * came.
 * Leaves to others: the form of each (api/class/class_json, class_table).
 * Invariant: a room is read a page at a time, between which others have their turn. */
#ifndef SRV_CLASS_REPORTS_H
#define SRV_CLASS_REPORTS_H

#include "server/work/exchange.h"

/** GET /v1/classes/{code}: the room, and the items that whoever asks may read; ?since=VERSION:
 * those that were written after it. */
void srv_class_reports_room(struct srv_exchange *exchange);

/** GET /v1/classes/{code}/table: all answers as CSV, for the teacher. */
void srv_class_reports_table(struct srv_exchange *exchange);

/** GET /v1/classes/{code}/histograms/{id}: how often each answer to a question came, for the
 * teacher. */
void srv_class_reports_histogram(struct srv_exchange *exchange);

#endif

/* The tables, version by version, and how a database gets them.
 * Leaves to others: the statements on them (store_statements), when it is time (store_call).
 * Invariant: tables are changed in one transaction, one process at a time; those of a newer
 * version are left alone.
 *
 * A part of a job is a row of the table `shards`, and its number the column `shard` of results:
 * parts were called shards when the tables were made, and another name is not worth a migration. */
#ifndef SRV_STORE_SCHEMA_H
#define SRV_STORE_SCHEMA_H

#include "server/store/sql.h"

enum { SRV_SCHEMA = 11 }; /* the newest version that this program knows */

/**
 * Makes the tables, or brings them to this version.
 *
 * SRV_STORED_BROKEN  they are of a newer version: the connection's complaint says so.
 * SRV_STORED_AWAY    the database cannot be reached yet.
 */
enum srv_stored srv_schema_settle(struct srv_sql *sql);

/** Says that the tables are of a newer version than this program knows. Returns
 * SRV_STORED_BROKEN. */
enum srv_stored srv_schema_newer(struct srv_sql *sql, int64_t version);

#endif

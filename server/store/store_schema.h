/* The tables and their creation.
 * Leaves to others: the statements on them (store_statements), when to create them (store_call).
 * Invariant: tables are created in one transaction, by one process at a time; tables of another
 * version are left unchanged. */
#pragma once

#include "server/store/sql.h"

enum { SRV_SCHEMA = 1 }; /* the schema version of this program */

/**
 * Creates the tables if they do not exist.
 *
 * SRV_STORED_BROKEN  they have another version; the connection's complaint says so.
 * SRV_STORED_AWAY    the database is unreachable.
 */
enum srv_stored srv_schema_settle(struct srv_sql *sql);

/** Sets the complaint that the tables have another version. Returns SRV_STORED_BROKEN. */
enum srv_stored srv_schema_other(struct srv_sql *sql, int64_t version);

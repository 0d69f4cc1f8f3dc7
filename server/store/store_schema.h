/* The tables, and how a database gets them.
 * Leaves to others: the statements on them (store_statements), when it is time (store_call).
 * Invariant: tables are made in one transaction, by one process at a time; those of another
 * version are left alone. */
#ifndef SRV_STORE_SCHEMA_H
#define SRV_STORE_SCHEMA_H

#include "server/store/sql.h"

enum { SRV_SCHEMA = 1 }; /* the version of the tables that this program knows */

/**
 * Makes the tables where there are none.
 *
 * SRV_STORED_BROKEN  they are of another version: the connection's complaint says so.
 * SRV_STORED_AWAY    the database cannot be reached yet.
 */
enum srv_stored srv_schema_settle(struct srv_sql *sql);

/** Says that the tables are of another version than this program knows. Returns
 * SRV_STORED_BROKEN. */
enum srv_stored srv_schema_other(struct srv_sql *sql, int64_t version);

#endif

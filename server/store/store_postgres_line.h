/* Connecting to PostgreSQL, and converting parameters and rows for libpq.
 * Leaves to others: statements, timeouts, lost connections (store_postgres).
 * Invariant: numbers are sent in binary, in network byte order. */
#pragma once

#include <libpq-fe.h>

#include "server/store/sql.h"

/* Parameters in libpq's form. */
struct srv_postgres_values {
    Oid type[SRV_SQL_PARAMETERS];
    const char *data[SRV_SQL_PARAMETERS];
    int bytes[SRV_SQL_PARAMETERS], binary[SRV_SQL_PARAMETERS];
    int64_t whole[SRV_SQL_PARAMETERS];
};

/** Converts the parameters of a statement; they point into the values. */
void srv_postgres_values(struct srv_postgres_values *out, const struct srv_value value[],
                         int count);

/** Reads the fields of a row; they are valid until the result is freed. */
void srv_postgres_fields(const PGresult *result, int row, struct srv_value field[], int count);

/** Connects. Keepalives detect a dead connection within about ten seconds, unless the url overrides
 * them. role: SRV_SQL_ bits, encoded in the application name. */
PGconn *srv_postgres_connect(const char *url, int role);

#define SRV_POSTGRES_SERVER                                                                        \
    "SELECT pg_backend_pid(), current_setting('max_connections')::int - "                          \
    "current_setting('superuser_reserved_connections')::int - (SELECT COUNT(*) FROM "              \
    "pg_stat_activity WHERE backend_type = 'client backend')"

/**
 * Reads and frees the answer to SRV_POSTGRES_SERVER.
 *
 * left  out: free connections of the database.
 *
 * Returns the server process of the connection; 0 without a reply. Behind a pooler PQbackendPID
 * differs.
 */
long srv_postgres_server(PGresult *result, long *left);

/** Returns non-zero if a second connection gets the same server process while the first is idle:
 * then a transaction pooler is in between. */
int srv_postgres_pooled(const char *url, int role, long server);

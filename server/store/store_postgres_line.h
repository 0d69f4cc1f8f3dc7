/* A connection to PostgreSQL before statements run on it, and what libpq is given and gives:
 * parameters and rows.
 * Leaves to others: statements, waiting, what is lost (store_postgres).
 * Invariant: numbers travel in binary, in the order of the network. */
#ifndef SRV_STORE_POSTGRES_LINE_H
#define SRV_STORE_POSTGRES_LINE_H

#include <libpq-fe.h>

#include "server/store/sql.h"

/* Parameters as libpq wants them. */
struct srv_postgres_values {
    Oid type[SRV_SQL_PARAMETERS];
    const char *data[SRV_SQL_PARAMETERS];
    int bytes[SRV_SQL_PARAMETERS], binary[SRV_SQL_PARAMETERS];
    int64_t whole[SRV_SQL_PARAMETERS];
};

/** Writes the parameters of a statement; they lend the values' data. */
void srv_postgres_values(struct srv_postgres_values *out, const struct srv_value value[],
                         int count);

/** Reads the fields of a row; they are valid as long as the result. */
void srv_postgres_fields(const PGresult *result, int row, struct srv_value field[], int count);

/** Connects; a connection that broke silently is noticed in about ten seconds, unless the url says
 * otherwise. role: bits of SRV_SQL_, told by the name under which the database lists it. */
PGconn *srv_postgres_connect(const char *url, int role);

#define SRV_POSTGRES_SERVER                                                                        \
    "SELECT pg_backend_pid(), current_setting('max_connections')::int - "                          \
    "current_setting('superuser_reserved_connections')::int - (SELECT COUNT(*) FROM "              \
    "pg_stat_activity WHERE backend_type = 'client backend')"

/**
 * Reads and frees the answer to SRV_POSTGRES_SERVER.
 *
 * left  out: the connections that the database has left.
 *
 * Returns the server process that runs the connection's statements, 0 for no answer. A pooler does
 * not know it when it accepts a connection: PQbackendPID differs.
 */
long srv_postgres_server(PGresult *result, long *left);

/** Whether a second connection is served by the same process while the first one rests: then a
 * pooler gives each transaction whichever process is free. */
int srv_postgres_pooled(const char *url, int role, long server);

#endif

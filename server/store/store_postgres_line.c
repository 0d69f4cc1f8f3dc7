#include "server/store/store_postgres_line.h"

#include <assert.h>
#include <endian.h>
#include <stdlib.h>
#include <string.h>

/* PostgreSQL's OIDs of the result types */
enum { TYPE_BYTEA = 17, TYPE_INT8 = 20, TYPE_TEXT = 25 };
#define CONNECT_S "5" /* connection timeout, s */

void srv_postgres_values(struct srv_postgres_values *out, const struct srv_value value[],
                         int count) {
    memset(out, 0, sizeof *out);
    for (int i = 0; i < count; i++) switch (value[i].kind) {
        case SRV_SQL_NULL:
            break;
        case SRV_SQL_WHOLE:
            out->whole[i] = (int64_t)htobe64((uint64_t)value[i].whole);
            out->type[i] = TYPE_INT8;
            out->data[i] = (const char *)&out->whole[i];
            out->bytes[i] = 8;
            out->binary[i] = 1;
            break;
        case SRV_SQL_STRING:
            out->type[i] = TYPE_TEXT;
            out->data[i] = value[i].data;
            break;
        case SRV_SQL_BYTES:
            out->type[i] = TYPE_BYTEA;
            out->data[i] = value[i].bytes ? value[i].data : "";
            out->bytes[i] = (int)value[i].bytes;
            out->binary[i] = 1;
            break;
        }
}

void srv_postgres_fields(const PGresult *result, int row, struct srv_value field[], int count) {
    for (int i = 0; i < count; i++) {
        struct srv_value *value = &field[i];
        const char *data = PQgetvalue(result, row, i);
        uint64_t whole;
        *value = (struct srv_value){0};
        if (PQgetisnull(result, row, i)) continue;
        if (PQftype(result, i) == TYPE_INT8) {
            memcpy(&whole, data, sizeof whole);
            value->kind = SRV_SQL_WHOLE;
            value->whole = (int64_t)be64toh(whole);
            continue;
        }
        value->kind = PQftype(result, i) == TYPE_BYTEA ? SRV_SQL_BYTES : SRV_SQL_STRING;
        value->data = data;
        value->bytes = (size_t)PQgetlength(result, row, i);
    }
}

PGconn *srv_postgres_connect(const char *url, int role) {
    static const char *const word[] = {"connect_timeout",
                                       "keepalives_idle",
                                       "keepalives_interval",
                                       "keepalives_count",
                                       "tcp_user_timeout",
                                       "application_name",
                                       "dbname",
                                       NULL};
    const char *const value[] = {CONNECT_S,
                                 "5",
                                 "2",
                                 "3",
                                 "10000",
                                 role == SRV_SQL_WORKS || role == (SRV_SQL_WORKS | SRV_SQL_ANSWERS)
                                     ? "pendulumd worker"
                                     : "pendulumd",
                                 url,
                                 NULL};
    return PQconnectdbParams(word, value, 1);
}

long srv_postgres_server(PGresult *result, long *left) {
    int good = PQresultStatus(result) == PGRES_TUPLES_OK;
    long server = good ? strtol(PQgetvalue(result, 0, 0), NULL, 10) : 0;
    *left = good ? strtol(PQgetvalue(result, 0, 1), NULL, 10) : 0;
    PQclear(result);
    return server;
}

int srv_postgres_pooled(const char *url, int role, long server) {
    PGconn *other = srv_postgres_connect(url, role);
    long left;
    assert(server > 0);
    int pooled = srv_postgres_server(PQexec(other, SRV_POSTGRES_SERVER), &left) == server;
    PQfinish(other);
    return pooled;
}

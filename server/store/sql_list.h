/* Rows of values that are gathered for one statement, as the arrays that PostgreSQL reads in its
 * binary form.
 * Leaves to others: the statements' dialect (sql), when they are sent (store_postgres).
 * Invariant: every column has as many values as the list has rows. */
#ifndef SRV_SQL_LIST_H
#define SRV_SQL_LIST_H

#include "server/store/sql.h"

/* Rows that wait; begins as {0}. */
struct srv_sql_list {
    const char *text;    /* the statement that they are for; NULL while the list is empty */
    const char *letters; /* in it: the types of its columns, see srv_sql_columns */
    int rows, columns;
    struct srv_sql_column {
        char *data; /* an array's head and its elements */
        size_t bytes, cap;
        int nulls; /* some element is NULL */
    } column[SRV_SQL_PARAMETERS];
};

/**
 * Adds a row; its values are copied. O(bytes of the values).
 *
 * text   a statement on rows of values, the same for every row of the list.
 * value  count of them, of the types that the statement names; count <= SRV_SQL_PARAMETERS.
 *
 * Returns 0 when memory is short: the list is empty then, as its row is not whole.
 */
int srv_sql_list_add(struct srv_sql_list *list, const char *text, const struct srv_value value[],
                     int count);

/**
 * The columns as parameters of one statement, each an array in binary form.
 *
 * data, bytes  out, one for each column; borrowed, and valid until a row is added.
 */
void srv_sql_list_arrays(struct srv_sql_list *list, const char *data[], int bytes[]);

/** True where every column has an array's head and room for what it holds, and the row's number
 * fits the bytes. O(columns). */
int srv_sql_list_valid(const struct srv_sql_list *list);

/** Removes all rows; their memory stays for the next ones. */
void srv_sql_list_empty(struct srv_sql_list *list);

/** Frees what the list holds. */
void srv_sql_list_free(struct srv_sql_list *list);

#endif

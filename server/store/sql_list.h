/* Collects rows of values for one statement as arrays in PostgreSQL's binary format.
 * Leaves to others: the statements' dialect (sql), when they are sent (store_postgres).
 * Invariant: every column has as many values as the list has rows. */
#pragma once

#include "server/store/sql.h"

/* Collected rows; initialized with {0}. */
struct srv_sql_list {
    const char *text;    /* their statement; NULL while the list is empty */
    const char *letters; /* the types of its columns, see srv_sql_columns */
    int rows, columns;
    struct srv_sql_column {
        char *data; /* header and elements of an array */
        size_t bytes, cap;
        int nulls; /* some element is NULL */
    } column[SRV_SQL_PARAMETERS];
};

/**
 * Adds a row; its values are copied. O(bytes of the values).
 *
 * text   a statement on rows of values, the same for every row of the list.
 * value  `count` values of the statement's types; count <= SRV_SQL_PARAMETERS.
 *
 * Returns 0 if memory is short; the list is then empty.
 */
int srv_sql_list_add(struct srv_sql_list *list, const char *text, const struct srv_value value[],
                     int count);

/**
 * Returns the columns as parameters of one statement, each an array in binary form.
 *
 * data, bytes  out, one for each column; borrowed, and valid until a row is added.
 */
void srv_sql_list_arrays(struct srv_sql_list *list, const char *data[], int bytes[]);

/** Removes all rows and keeps the memory for the next ones. */
void srv_sql_list_empty(struct srv_sql_list *list);
void srv_sql_list_free(struct srv_sql_list *list);

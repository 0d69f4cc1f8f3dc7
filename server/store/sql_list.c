#include "server/store/sql.h"

#include <arpa/inet.h>
#include <assert.h>
#include <endian.h>
#include <stdlib.h>
#include <string.h>

/* PostgreSQL's binary arrays: the number of dimensions, a NULL flag, the element type, the number
 * of elements and the first subscript; then each element after its length. All are 4-byte integers.
 */
enum { LIST_HEAD = 20, LIST_LENGTH = 4, LIST_FIRST = 4096 };

/* PostgreSQL's OIDs of the element types */
static uint32_t list_type(char letter) { return letter == 't' ? 25 : letter == 'w' ? 20 : 17; }

static void list_number(char *at, uint32_t number) {
    uint32_t order = htonl(number);
    memcpy(at, &order, sizeof order);
}

static int list_room(struct srv_sql_column *column, size_t bytes) {
    size_t cap = column->cap ? column->cap : LIST_FIRST;
    while (cap < column->bytes + bytes) cap *= 2;
    if (cap == column->cap) return 1;
    char *data = realloc(column->data, cap);
    if (!data) return 0;
    column->data = data;
    column->cap = cap;
    return 1;
}

static int list_put(struct srv_sql_column *column, const struct srv_value *value) {
    int64_t whole = (int64_t)htobe64((uint64_t)value->whole);
    int null = value->kind == SRV_SQL_NULL;
    const void *data = value->kind == SRV_SQL_WHOLE ? &whole : value->data;
    size_t bytes = null ? 0 : value->kind == SRV_SQL_WHOLE ? sizeof whole : value->bytes;
    if (!list_room(column, LIST_LENGTH + bytes)) return 0;
    list_number(column->data + column->bytes, null ? UINT32_MAX : (uint32_t)bytes);
    if (bytes) memcpy(column->data + column->bytes + LIST_LENGTH, data, bytes);
    column->bytes += LIST_LENGTH + bytes;
    column->nulls |= null;
    return 1;
}

PEND_VALIDATOR sql_list_valid(const struct srv_sql_list *list) {
    int good = list->columns >= 0 && list->columns <= SRV_SQL_PARAMETERS && list->rows >= 0;
    for (int i = 0; good && list->text && i < list->columns; i++) {
        const struct srv_sql_column *column = &list->column[i];
        good = column->bytes <= column->cap &&
               column->bytes >= LIST_HEAD + (size_t)list->rows * LIST_LENGTH;
    }
    return good && (list->text || !list->rows);
}

int srv_sql_list_add(struct srv_sql_list *list, const char *text, const struct srv_value value[],
                     int count) {
    assert(sql_list_valid(list) && count >= 0 && count <= SRV_SQL_PARAMETERS);
    assert(!list->text || (!strcmp(list->text, text) && list->columns == count));
    if (!list->text) {
        list->text = text;
        list->letters = srv_sql_columns(text);
        list->columns = count;
        for (int i = 0; i < count; i++) {
            list->column[i].bytes = 0;
            list->column[i].nulls = 0;
            if (!list_room(&list->column[i], LIST_HEAD)) return srv_sql_list_empty(list), 0;
            list->column[i].bytes = LIST_HEAD;
        }
    }
    for (int i = 0; i < count; i++)
        if (!list_put(&list->column[i], &value[i])) return srv_sql_list_empty(list), 0;
    list->rows++;
    assert(sql_list_valid(list));
    return 1;
}

void srv_sql_list_arrays(struct srv_sql_list *list, const char *data[], int bytes[]) {
    assert(list->text && list->rows > 0 && sql_list_valid(list));
    for (int i = 0; i < list->columns; i++) {
        struct srv_sql_column *column = &list->column[i];
        list_number(column->data, 1);
        list_number(column->data + 4, column->nulls != 0);
        list_number(column->data + 8, list_type(list->letters[i]));
        list_number(column->data + 12, (uint32_t)list->rows);
        list_number(column->data + 16, 1);
        data[i] = column->data;
        bytes[i] = (int)column->bytes;
    }
}

void srv_sql_list_empty(struct srv_sql_list *list) {
    list->text = NULL;
    list->rows = 0;
}

void srv_sql_list_free(struct srv_sql_list *list) {
    for (int i = 0; i < SRV_SQL_PARAMETERS; i++) free(list->column[i].data);
    *list = (struct srv_sql_list){0};
}

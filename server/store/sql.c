#include "server/store/sql.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

void srv_sql_complain(struct srv_sql *sql, const char *text) {
    assert(text && sql->driver);
    snprintf(sql->complaint, sizeof sql->complaint, "%.*s", (int)strcspn(text, "\n"), text);
}

/* the driver's word for a token such as "{now}"; NULL where it is none */
static const char *sql_word(const struct srv_sql_driver *driver, const char *token, size_t bytes) {
    const struct {
        const char *token, *word;
    } words[] = {{"{begin}", driver->begin},         {"{now}", driver->now},
                 {"{lock}", driver->lock},           {"{skip}", driver->skip},
                 {"{alone}", driver->alone},         {"{ring}", driver->ring},
                 {"{bytes}", driver->bytes},         {"{hot}", driver->hot},
                 {"{ring work}", driver->ring_work}, {"{ring stop}", driver->ring_stop},
                 {"{crowd}", driver->crowd},         {"{carries}", driver->carries}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i].token) == bytes && !memcmp(words[i].token, token, bytes))
            return words[i].word;
    return NULL;
}

enum { SQL_LIST_TEXT = 512 };

/* a sum of a client as it is with the changes that are not in its row yet, "{late jobs}", those
 * changes alone, "{pending jobs}", or their number, "{late}"; NULL where the token is none of these
 */
static const char *sql_late(const struct srv_sql_driver *driver, const char *token, size_t bytes,
                            char text[SQL_LIST_TEXT]) {
    int late = !strncmp(token, "{late", 5), name = late ? 6 : 9, length = (int)bytes - name - 1;
    if (!late && strncmp(token, "{pending ", 9) != 0) return NULL;
    const char *column = token + name;
    if (!driver->lists)
        snprintf(text, SQL_LIST_TEXT, "%s%.*s", late && length > 0 ? "clients." : "0",
                 late && length > 0 ? length : 0, column);
    else if (length < 0)
        snprintf(text, SQL_LIST_TEXT, "(SELECT COUNT(*) FROM changes WHERE name = clients.name)");
    else
        snprintf(text, SQL_LIST_TEXT,
                 "%s%.*s%sCAST(COALESCE((SELECT SUM(changes.%.*s) FROM changes WHERE changes.name "
                 "= clients.name AND changes.%.*s BETWEEN -9007199254740992 AND 9007199254740992), "
                 "0) AS BIGINT)%s",
                 late ? "(clients." : "", late ? length : 0, column, late ? " + " : "", length,
                 column, length, column, late ? ")" : "");
    return text;
}

/* where a statement names its rows of values among its tables, and what stands before and after
 * them */
static const struct {
    const char *token, *before, *after;
} sql_lists[] = {{"{from ", "FROM ", ""}, {"{using ", "USING ", ""}, {"{beside ", "", ","}};

enum { SQL_LISTS = sizeof sql_lists / sizeof *sql_lists };

const char *srv_sql_columns(const char *text) {
    const char *found = NULL;
    for (int i = 0; i < SQL_LISTS && !found; i++)
        if ((found = strstr(text, sql_lists[i].token))) found += strlen(sql_lists[i].token);
    return found;
}

/* adds to a text that is long enough for every statement there is */
static void sql_add(char text[SQL_LIST_TEXT], const char *more) {
    assert(strlen(text) + strlen(more) < SQL_LIST_TEXT);
    size_t bytes = strlen(text);
    snprintf(text + bytes, SQL_LIST_TEXT - bytes, "%s", more);
}

/* the rows of values as a table v of columns c1, c2, ...; nothing where statements run on one
 * row at a time */
static const char *sql_rows(const struct srv_sql_driver *driver, const char *token, size_t bytes,
                            char text[SQL_LIST_TEXT]) {
    char piece[32], names[SQL_LIST_TEXT] = "";
    int list = 0;
    while (list < SQL_LISTS &&
           strncmp(token, sql_lists[list].token, strlen(sql_lists[list].token)) != 0)
        list++;
    if (list == SQL_LISTS) return NULL;
    text[0] = '\0';
    if (!driver->lists) return text;
    const char *letters = token + strlen(sql_lists[list].token);
    int columns = (int)(token + bytes - 1 - letters);
    sql_add(text, sql_lists[list].before);
    for (int i = 0; i < columns; i++) {
        const char *type = letters[i] == 't' ? "text" : letters[i] == 'w' ? "bigint" : "bytea";
        snprintf(piece, sizeof piece, "%s$%d::%s[]", i ? ", " : "unnest(", i + 1, type);
        sql_add(text, piece);
        snprintf(piece, sizeof piece, "%sc%d", i ? ", " : "", i + 1);
        sql_add(names, piece);
    }
    sql_add(text, ") AS v(");
    sql_add(text, names);
    sql_add(text, ")");
    sql_add(text, sql_lists[list].after);
    return text;
}

/* a value of a row, or the rows themselves; NULL where the token is neither */
static const char *sql_list_word(const struct srv_sql_driver *driver, const char *token,
                                 size_t bytes, char text[SQL_LIST_TEXT]) {
    const char *late = sql_late(driver, token, bytes, text);
    if (late || token[1] < '0' || token[1] > '9')
        return late ? late : sql_rows(driver, token, bytes, text);
    snprintf(text, SQL_LIST_TEXT, "%s%.*s", driver->lists ? "v.c" : "$", (int)bytes - 2, token + 1);
    return text;
}

void srv_sql_spell(const struct srv_sql_driver *driver, const char *text, char out[SRV_SQL_TEXT]) {
    char list[SQL_LIST_TEXT];
    size_t bytes = 0;
    while (*text) {
        size_t token = *text == '{' ? strcspn(text, "}") + 1 : 0;
        const char *word = token ? sql_word(driver, text, token) : NULL;
        if (token && !word) word = sql_list_word(driver, text, token, list);
        const char *piece = word ? word : text;
        size_t length = word ? strlen(word) : 1;
        assert(bytes + length < SRV_SQL_TEXT);
        if (bytes + length >= SRV_SQL_TEXT) break;
        memcpy(out + bytes, piece, length);
        bytes += length;
        text += word ? token : 1;
    }
    out[bytes] = '\0';
}

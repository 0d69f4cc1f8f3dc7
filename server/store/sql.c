#include "server/store/sql.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

void srv_sql_complain(struct srv_sql *sql, const char *text) {
    assert(text && sql->driver);
    snprintf(sql->complaint, sizeof sql->complaint, "%.*s", (int)strcspn(text, "\n"), text);
}

/* Macros: {name argument} becomes the text, in which each % becomes the argument. */
static const struct {
    const char *name, *text;
} sql_shorts[] = {
    /* a job, as srv_row_job reads it */
    {"job", "jobs.id, jobs.client, jobs.operation, jobs.state, jobs.parts, jobs.done, "
            "jobs.created, jobs.started, jobs.finished, jobs.expires, {now}, jobs.bytes, "
            "jobs.message, jobs.begun, jobs.waiting, jobs.chained, jobs.held, jobs.title, "
            "jobs.version, jobs.seal"},
    /* a room, with the number and the bytes of the pupil whose token hash is $2 */
    {"class", "code, teacher, created, ends, version, shared, pupils, numbered, bytes, empty_ends, "
              "share, near, source, shut, COALESCE((SELECT number FROM class_pupils WHERE "
              "class_pupils.code = $1 AND who = $2), 0), COALESCE((SELECT class_pupils.bytes FROM "
              "class_pupils WHERE class_pupils.code = $1 AND who = $2), 0)"},
    /* a plausible count or change: an altered value must not overflow a sum */
    {"sane", "% BETWEEN 0 AND 9007199254740992"},
    {"bounded", "% BETWEEN -9007199254740992 AND 9007199254740992"},
    {"counted", "{sane bytes} AND {sane held} AND {sane parts} AND {sane begun} AND {sane waiting} "
                "AND state BETWEEN 0 AND 4"},
    {"sum", "CAST(COALESCE(SUM(%), 0) AS BIGINT)"},
    {"count", "{sum CASE WHEN % THEN 1 ELSE 0 END}"},
    /* pending changes of a client's sum; the sum including them */
    {"pending", "(SELECT {sum changes.%} FROM changes WHERE changes.name = clients.name AND "
                "{bounded changes.%})"},
    {"late", "(clients.% + {pending %})"},
    /* true for an invalid id, by which no statement can select the row */
    {"nameless", "(% IS NULL OR LENGTH(%) NOT BETWEEN 1 AND 26 OR CAST(% AS TEXT) <> %)"},
    /* srv_store_rank of a job with % parts left, relative to its creation: SRV_RANK_KNEE_US,
     * SRV_RANK_TIMES and SRV_RANK_MOST_S */
    {"rank", "(CASE WHEN part_us * (%) < 57142857 THEN 64 * part_us * (%) ELSE part_us * (%) + "
             "3600000000 END)"},
};

enum { SQL_SHORTS = sizeof sql_shorts / sizeof *sql_shorts, SQL_PIECE = 1024 };

/* the positions where a statement lists its rows of values, and the text around them */
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

struct sql_text {
    const struct srv_sql_driver *driver;
    size_t bytes;
    char *out;
};

static void sql_write(struct sql_text *to, const char *text, size_t length);

/* the rows of values as a table v of columns c1, c2, ... */
static void sql_rows(struct sql_text *to, int list, const char *letters, int columns) {
    char text[SQL_PIECE];
    int at = snprintf(text, sizeof text, "%sunnest(", sql_lists[list].before);
    for (int i = 0; i < columns; i++)
        at += snprintf(text + at, sizeof text - (size_t)at, "%s$%d::%s[]", i ? ", " : "", i + 1,
                       letters[i] == 't'   ? "text"
                       : letters[i] == 'w' ? "bigint"
                                           : "bytea");
    for (int i = 0; i < columns; i++)
        at += snprintf(text + at, sizeof text - (size_t)at, "%sc%d", i ? ", " : ") AS v(", i + 1);
    at += snprintf(text + at, sizeof text - (size_t)at, ")%s", sql_lists[list].after);
    sql_write(to, text, (size_t)at);
}

/* expands a macro; returns 0 if there is no macro of this name */
static int sql_short(struct sql_text *to, const char *token, size_t length) {
    char text[SQL_PIECE];
    size_t bytes = 0, name = strcspn(token, " }"), i = 0;
    while (i < SQL_SHORTS &&
           (strlen(sql_shorts[i].name) != name || memcmp(sql_shorts[i].name, token, name)))
        i++;
    if (i == SQL_SHORTS) return 0;
    size_t what = length > name ? length - name - 1 : 0;
    for (const char *at = sql_shorts[i].text; *at; at++) {
        size_t more = *at == '%' ? what : 1;
        assert(bytes + more < sizeof text);
        memcpy(text + bytes, *at == '%' ? token + name + 1 : at, more);
        bytes += more;
    }
    sql_write(to, text, bytes);
    return 1;
}

static void sql_token(struct sql_text *to, const char *token, size_t length) {
    const struct srv_sql_driver *driver = to->driver;
    for (const struct srv_sql_word *word = driver->words; word->token; word++)
        if (strlen(word->token) == length && !memcmp(word->token, token, length)) {
            sql_write(to, word->text, strlen(word->text));
            return;
        }
    for (int i = 0; i < SQL_LISTS; i++) {
        size_t name = strlen(sql_lists[i].token) - 1;
        if (strncmp(sql_lists[i].token + 1, token, name) != 0) continue;
        if (driver->lists) sql_rows(to, i, token + name, (int)(length - name));
        return;
    }
    if (sql_short(to, token, length)) return;
    assert(*token >= '0' && *token <= '9');
    sql_write(to, driver->lists ? "v.c" : "$", driver->lists ? 3 : 1);
    sql_write(to, token, length);
}

static void sql_write(struct sql_text *to, const char *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        size_t begin = i + 1;
        if (text[i] != '{') {
            assert(to->bytes + 1 < SRV_SQL_TEXT);
            to->out[to->bytes++] = text[i];
            continue;
        }
        for (int depth = 1; depth; depth += (text[i] == '{') - (text[i] == '}')) i++;
        sql_token(to, text + begin, i - begin);
    }
}

void srv_sql_spell(const struct srv_sql_driver *driver, const char *text, char out[SRV_SQL_TEXT]) {
    struct sql_text to = {driver, 0, out};
    sql_write(&to, text, strlen(text));
    out[to.bytes] = '\0';
}

#include "server/sql.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

void srv_sql_complain(struct srv_sql *sql, const char *text) {
    snprintf(sql->complaint, sizeof sql->complaint, "%.*s", (int)strcspn(text, "\n"), text);
}

/* the driver's word for a token such as "{now}"; NULL where it is none */
static const char *sql_word(const struct srv_sql_driver *driver, const char *token, size_t bytes) {
    const struct {
        const char *token, *word;
    } words[] = {{"{begin}", driver->begin}, {"{now}", driver->now},     {"{lock}", driver->lock},
                 {"{skip}", driver->skip},   {"{alone}", driver->alone}, {"{ring}", driver->ring},
                 {"{bytes}", driver->bytes}, {"{hot}", driver->hot}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i].token) == bytes && !memcmp(words[i].token, token, bytes)) return words[i].word;
    return NULL;
}

void srv_sql_spell(const struct srv_sql_driver *driver, const char *text, char out[SRV_SQL_TEXT]) {
    size_t bytes = 0;
    while (*text) {
        size_t token = *text == '{' ? strcspn(text, "}") + 1 : 0;
        const char *word = token ? sql_word(driver, text, token) : NULL;
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

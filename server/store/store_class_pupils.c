#include "server/store/store_class_pupils.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum srv_stored srv_row_class_code(void *context, const struct srv_value field[]) {
    struct srv_class_codes *codes = context;
    struct srv_row row = {field, NULL};
    if (codes->count == SQL_CLASSES_MOST) return SRV_STORED_DAMAGED;
    srv_row_word(&row, 1, codes->code[codes->count], SRV_CLASS_CODE, "code");
    codes->count += !row.flaw;
    return SRV_STORED;
}

enum srv_stored srv_store_class_codes(struct srv_store *store, const char *teacher,
                                      const char *after, struct srv_class_codes *codes) {
    codes->count = 0;
    SRV_STORED_TRY(srv_store_look(store));
    return srv_store_end(store,
                         SRV_RUN(store, SQL_CLASSES, srv_row_class_code, codes, teacher, after));
}

enum srv_stored srv_store_class_from(struct srv_store *store, const char *code, const char *source,
                                     int64_t *count) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_CLASS_PUPILS_FROM, srv_row_wholes, &row, code, source));
    *count = row.whole[0];
    return SRV_STORED;
}

enum srv_stored srv_store_class_comes(struct srv_store *store, const char *code, const char *source,
                                      int64_t *count) {
    SRV_STORED_TRY(srv_store_look(store));
    return srv_store_end(store, srv_store_class_from(store, code, source, count));
}

/* The numbers in use for a folded name; 1 = the name without a number. */
struct row_fold {
    const char *fold;
    size_t bytes;
    long most;
    unsigned char *taken;
};

static enum srv_stored row_fold(void *context, const struct srv_value field[]) {
    struct row_fold *row = context;
    char text[SRV_CLASS_FOLD];
    srv_row_text(&field[0], text, sizeof text);
    if (strncmp(text, row->fold, row->bytes)) return SRV_STORED;
    const char *rest = text + row->bytes;
    char *end;
    long number = *rest == '(' ? strtol(rest + 1, &end, 10) : !*rest;
    if (*rest && (*rest != '(' || strcmp(end, ")"))) return SRV_STORED;
    if (number > 0 && number <= row->most) row->taken[number] = 1;
    return SRV_STORED;
}

enum srv_stored srv_store_class_named(struct srv_store *store, const char *code, const char *fold,
                                      char body[], size_t *bytes, char kept[]) {
    struct row_fold row = {fold, strlen(fold), store->rules.class_pupils + 1, NULL};
    row.taken = calloc((size_t)row.most + 2, 1);
    if (!row.taken) return SRV_STORED_BROKEN;
    enum srv_stored stored = SRV_RUN(store, SQL_CLASS_FOLDS, row_fold, &row, code);
    long number = 1;
    while (number < row.most && row.taken[number]) number++;
    free(row.taken);
    SRV_STORED_TRY(stored);
    char mark[32] = "";
    assert(*bytes > 2 && *bytes < SRV_CLASS_NAMED - sizeof mark);
    if (number > 1) snprintf(mark, sizeof mark, " (%ld)", number);
    /* insert the number before the closing quote and brace */
    char *end = body + *bytes - 2;
    size_t marked = strlen(mark);
    memmove(end + marked, end, 2);
    memcpy(end, mark, marked);
    *bytes += marked;
    snprintf(kept, SRV_CLASS_FOLD, "%s%s", fold, *mark ? mark + 1 : "");
    return SRV_STORED;
}

int srv_store_class_range(const char **at, int64_t *from, int64_t *to) {
    char *end;
    *from = *to = strtoll(*at, &end, 10);
    if (end == *at) return 0;
    if (*end == '-') *to = strtoll(end + 1, &end, 10);
    *at = end + (*end == ',');
    return *from > 0;
}

enum srv_stored srv_store_class_mark(struct srv_store *store, const char *code, int64_t *version,
                                     int64_t *shared) {
    struct srv_row_wholes row = {.count = 2};
    SRV_STORED_TRY(srv_store_look(store));
    enum srv_stored stored = SRV_RUN(store, SQL_CLASS_MARK, srv_row_wholes, &row, code);
    if (stored == SRV_STORED && !row.rows) stored = SRV_STORED_NONE;
    *version = row.whole[0];
    *shared = row.whole[1];
    return srv_store_end(store, stored);
}

/* --- expiry of rooms --- */

enum srv_stored srv_store_class_erase(struct srv_store *store, const char *code) {
    assert(*code);
    SRV_STORED_TRY(SRV_POST(store, SQL_CLASS_ITEMS_REMOVE, code));
    SRV_STORED_TRY(SRV_POST(store, SQL_CLASS_PUPILS_REMOVE, code));
    store->tally.ring |= SRV_RING_ENDS;
    return SRV_POST(store, SQL_CLASS_REMOVE, code);
}

struct row_ended {
    int rows;
    char code[SRV_NAME_BYTES];
};

static enum srv_stored row_ended(void *context, const struct srv_value field[]) {
    struct row_ended *row = context;
    srv_row_text(&field[0], row->code, sizeof row->code);
    row->rows++;
    return SRV_STORED;
}

enum srv_stored srv_store_class_sweep(struct srv_store *store, int64_t now, int *more) {
    struct row_ended ended = {0};
    assert(now > 0);
    SRV_STORED_TRY(SRV_RUN(store, SQL_CLASS_ENDED, row_ended, &ended, now));
    if (!ended.rows) return SRV_STORED;
    /* an altered code matches no room */
    if (strlen(ended.code) != SRV_CLASS_CODE - 1) return SRV_POST(store, SQL_CLASSES_NAMELESS, now);
    *more = 1;
    return srv_store_class_erase(store, ended.code);
}

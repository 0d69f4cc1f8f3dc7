#include "server/store/store_classes.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct row_class {
    struct srv_class *room;
    const char *who;
    int rows, flaw;
};

static enum srv_stored row_class(void *context, const struct srv_value field[]) {
    struct row_class *found = context;
    struct srv_class *room = found->room;
    struct srv_row row = {field, NULL};
    char teacher[SRV_NAME_BYTES];
    int64_t *const whole[] = {&room->created, &room->ends,       &room->version,
                              &room->shared,  &room->pupils,     &room->numbered,
                              &room->bytes,   &room->empty_ends, &room->share};
    srv_row_word(&row, 1, room->code, sizeof room->code, "code");
    srv_row_word(&row, 1, teacher, sizeof teacher, "teacher");
    for (int i = 0; i < 9; i++) *whole[i] = srv_row_whole(&row, 0, SRV_ROW_MOST, "a number");
    srv_row_word(&row, 0, room->near, sizeof room->near, "near");
    srv_row_word(&row, 0, room->source, sizeof room->source, "source");
    room->shut = (int)srv_row_whole(&row, 0, 1, "shut");
    room->teacher = *found->who && !strcmp(teacher, found->who);
    room->pupil = srv_row_whole(&row, 0, SRV_ROW_MOST, "number");
    room->pupil_bytes = srv_row_whole(&row, 0, SRV_ROW_MOST, "bytes");
    int counted = room->shared <= room->version && room->pupils <= room->numbered &&
                  (!room->pupil || (room->pupil <= room->numbered && room->pupils > 0));
    found->flaw |= row.flaw || !counted;
    found->rows++;
    return SRV_STORED;
}

/* reads the room that a statement finds, unless it has expired */
static enum srv_stored class_find(struct srv_store *store, enum srv_statement id, const char *code,
                                  const char *who, struct srv_class *room) {
    struct row_class row = {.room = room, .who = who};
    int64_t now;
    assert(id == SQL_CLASS || id == SQL_CLASS_LOCK);
    *room = (struct srv_class){0};
    SRV_STORED_TRY(SRV_RUN(store, id, row_class, &row, code, who));
    if (!row.rows) return SRV_STORED_NONE;
    if (row.flaw) return SRV_STORED_DAMAGED;
    SRV_STORED_TRY(srv_store_now(store, &now));
    int empty = room->empty_ends && room->empty_ends <= now;
    return room->ends > now && !empty ? SRV_STORED : SRV_STORED_NONE;
}

/* Reads and locks a room; does not wait if another process has locked it, because two transactions
 * with one locked room each could deadlock. */
static enum srv_stored class_lock(struct srv_store *store, const struct srv_class_put *put,
                                  struct srv_class *room) {
    enum srv_stored stored = class_find(store, SQL_CLASS_LOCK, put->code, put->who, room);
    if (stored != SRV_STORED_NONE) return stored;
    stored = class_find(store, SQL_CLASS, put->code, put->who, room);
    return stored == SRV_STORED ? SRV_STORED_AGAIN : stored;
}

static enum srv_stored class_change(struct srv_store *store, const struct srv_class *room) {
    assert(room->shared <= room->version && room->pupils <= room->numbered && room->bytes >= 0);
    store->tally.ring |= SRV_RING_ENDS;
    return SRV_POST(store, SQL_CLASS_CHANGE, room->code, room->version, room->shared, room->pupils,
                    room->numbered, room->bytes, room->shut, room->empty_ends, room->share,
                    room->near);
}

static enum srv_stored class_refuse(struct srv_class_put *put, enum srv_class_why why) {
    assert(why != SRV_CLASS_FINE);
    put->why = why;
    return SRV_STORED_CLASH;
}

/* --- items --- */

struct class_there {
    const char *code;
    int rows;
    struct srv_class_item item; /* the item's body is malloc'ed */
};

/* reads an item of a room. SRV_STORED_DAMAGED: its checksum is wrong */
static enum srv_stored class_item(const struct srv_value field[], const char *code,
                                  struct srv_class_item *item) {
    struct srv_row row = {field, NULL};
    srv_row_word(&row, 1, item->name, sizeof item->name, "name");
    item->version = srv_row_whole(&row, 1, SRV_ROW_MOST, "version");
    item->reader = srv_row_whole(&row, SRV_CLASS_TEACHER, SRV_ROW_MOST, "reader");
    item->flag = srv_row_whole(&row, 0, SRV_ROW_MOST, "flag");
    item->changed = srv_row_whole(&row, 0, SRV_ROW_LATEST, "changed");
    item->body = row.next->data;
    item->bytes = row.next->bytes;
    const int64_t number[] = {item->version, item->reader, item->flag};
    int good = !row.flaw && row.next->kind == SRV_SQL_BYTES &&
               srv_seal_item_whole(row.next + 1, code, item->name, number, item->body, item->bytes);
    return good ? SRV_STORED : SRV_STORED_DAMAGED;
}

static enum srv_stored row_there(void *context, const struct srv_value field[]) {
    struct class_there *there = context;
    enum srv_stored stored = class_item(field, there->code, &there->item);
    const void *body = there->item.body;
    there->item.body = NULL;
    SRV_STORED_TRY(stored);
    void *copy = malloc(there->item.bytes + 1);
    if (!copy) return SRV_STORED_BROKEN;
    if (there->item.bytes) memcpy(copy, body, there->item.bytes);
    there->item.body = copy;
    there->rows++;
    return SRV_STORED;
}

/* the bytes counted for an item */
static int64_t class_weight(size_t bytes) { return SRV_CLASS_ITEM_BYTES + (int64_t)bytes; }

/* writes an item as the room's next change; the caller has checked the space */
static enum srv_stored class_write(struct srv_store *store, struct srv_class *room,
                                   const struct srv_class_item *item) {
    int64_t now;
    SRV_STORED_TRY(srv_store_now(store, &now));
    assert(*item->name && item->reader >= SRV_CLASS_TEACHER);
    room->version++;
    if (item->reader == SRV_CLASS_ALL) room->shared = room->version;
    const int64_t number[] = {room->version, item->reader, item->flag};
    unsigned char seal[API_SEAL_BYTES];
    srv_seal_item(seal, room->code, item->name, number, item->body, item->bytes);
    return SRV_POST(store, SQL_CLASS_ITEM_PUT, room->code, item->name, room->version, item->reader,
                    item->flag, now, srv_value_bytes(item->bytes ? item->body : "", item->bytes),
                    srv_value_bytes(seal, sizeof seal));
}

/* checks whether the room, and the item's pupil, may have `more` bytes */
static enum srv_stored class_room(const struct srv_store *store, struct srv_class_put *put,
                                  const struct srv_class *room, int64_t more) {
    assert(put->own == 0 || room->pupil > 0 || more > 0);
    /* an impossible sum */
    if (room->bytes + more < 0 || room->pupil_bytes + more < 0)
        return put->own || room->bytes + more < 0 ? SRV_STORED_DAMAGED : SRV_STORED;
    if (more <= 0) return SRV_STORED;
    if (room->bytes + more > store->rules.class_bytes)
        return class_refuse(put, SRV_CLASS_ROOM_FULL);
    if (put->own && room->pupil_bytes + more > SRV_CLASS_PUPIL_BYTES)
        return class_refuse(put, SRV_CLASS_PUPIL_FULL);
    const struct srv_sql_driver *driver = store->sql->driver;
    return driver->room && !driver->room(store->sql, (size_t)more) ? SRV_STORED_FULL : SRV_STORED;
}

/* checks that the item's base exists and accepts it */
static enum srv_stored class_base(struct srv_store *store, struct srv_class_put *put) {
    struct class_there base = {.code = put->code};
    if (!put->base || !put->body) return SRV_STORED;
    enum srv_stored stored = SRV_RUN(store, SQL_CLASS_ITEM, row_there, &base, put->code, put->base);
    free((void *)base.item.body);
    SRV_STORED_TRY(stored);
    if (!base.rows || !base.item.bytes) return class_refuse(put, SRV_CLASS_NO_BASE);
    if (base.item.flag & 1) return class_refuse(put, SRV_CLASS_CLOSED);
    if (put->fits && !put->fits(base.item.flag, put->flag))
        return class_refuse(put, SRV_CLASS_MISFIT);
    return SRV_STORED;
}

/* sets the rules for joining; returns non-zero if they change */
static int class_door(const struct srv_class_put *put, struct srv_class *room) {
    int other =
        (put->shut >= 0 && put->shut != room->shut) || (put->share && put->share != room->share);
    if (put->shut >= 0) room->shut = put->shut;
    if (put->share) room->share = put->share;
    return other;
}

/* replaces the existing item, unless both are equal */
static enum srv_stored class_replace(struct srv_store *store, struct srv_class_put *put,
                                     struct srv_class *room, const struct srv_class_item *item,
                                     const struct class_there *there) {
    int64_t was = there->rows ? class_weight(there->item.bytes) : 0,
            more = class_weight(item->bytes) - was;
    int same = there->rows
                   ? there->item.bytes == item->bytes && there->item.flag == item->flag &&
                         there->item.reader == item->reader &&
                         !memcmp(there->item.body, item->bytes ? item->body : "", item->bytes)
                   : !item->bytes;
    if (!class_door(put, room) && same) return SRV_STORED;
    SRV_STORED_TRY(class_room(store, put, room, more));
    /* readers of the old item must learn that it is gone */
    struct srv_class_item told = *item;
    if (!told.bytes && there->rows) told.reader = there->item.reader;
    SRV_STORED_TRY(class_write(store, room, &told));
    room->bytes += more;
    if (put->own && more) {
        room->pupil_bytes += more;
        SRV_STORED_TRY(
            SRV_POST(store, SQL_CLASS_PUPIL_BYTES, put->code, put->who, room->pupil_bytes));
    }
    return class_change(store, room);
}

static enum srv_stored class_put(struct srv_store *store, struct srv_class_put *put,
                                 struct srv_class *room) {
    struct class_there there = {.code = put->code};
    struct srv_class_item item = {.reader = put->own ? room->pupil : put->reader,
                                  .flag = put->flag,
                                  .body = put->body,
                                  .bytes = put->body ? put->bytes : 0};
    SRV_STORED_TRY(class_base(store, put));
    if (put->own)
        snprintf(item.name, sizeof item.name, "%s/%lld", put->name, (long long)room->pupil);
    else
        snprintf(item.name, sizeof item.name, "%s", put->name);
    enum srv_stored stored =
        SRV_RUN(store, SQL_CLASS_ITEM, row_there, &there, put->code, item.name);
    if (stored == SRV_STORED) stored = class_replace(store, put, room, &item, &there);
    free((void *)there.item.body);
    return stored;
}

/* --- pupils --- */

static enum srv_stored class_join(struct srv_store *store, struct srv_class_put *put,
                                  struct srv_class *room) {
    char body[SRV_CLASS_NAMED], fold[SRV_CLASS_FOLD];
    struct srv_class_item item = {.body = body, .bytes = put->bytes};
    if (room->pupil) return SRV_STORED;
    if (room->teacher) return class_refuse(put, SRV_CLASS_NO_PUPIL);
    if (room->shut) return class_refuse(put, SRV_CLASS_SHUT);
    if (room->pupils >= store->rules.class_pupils) return class_refuse(put, SRV_CLASS_CROWDED);
    int64_t from;
    SRV_STORED_TRY(srv_store_class_from(store, put->code, put->source, &from));
    int64_t quarter = store->rules.class_pupils / 4;
    int64_t usual = quarter > SRV_CLASS_SHARE ? quarter : SRV_CLASS_SHARE;
    if (from >= (room->share ? room->share : usual)) return class_refuse(put, SRV_CLASS_SHARED);
    memcpy(body, put->body, put->bytes);
    SRV_STORED_TRY(srv_store_class_named(store, put->code, put->fold, body, &item.bytes, fold));
    int64_t weight = class_weight(item.bytes);
    SRV_STORED_TRY(class_room(store, put, room, weight));
    room->pupils++;
    room->pupil = item.reader = ++room->numbered;
    room->pupil_bytes = weight;
    room->bytes += weight;
    room->empty_ends = 0;
    snprintf(item.name, sizeof item.name, "pupils/%lld", (long long)room->pupil);
    SRV_STORED_TRY(SRV_POST(store, SQL_CLASS_PUPIL_PUT, put->code, put->who, room->pupil, weight,
                            put->source, fold));
    SRV_STORED_TRY(class_write(store, room, &item));
    return class_change(store, room);
}

struct class_own {
    const char *code;
    int count;
    int64_t version; /* of the last one */
    struct srv_class_item item[SQL_CLASS_ITEMS_MOST];
    int64_t weight[SQL_CLASS_ITEMS_MOST];
};

static enum srv_stored row_own(void *context, const struct srv_value field[]) {
    struct class_own *own = context;
    if (own->count == SQL_CLASS_ITEMS_MOST) return SRV_STORED_DAMAGED;
    struct srv_class_item *item = &own->item[own->count];
    SRV_STORED_TRY(class_item(field, own->code, item));
    own->version = item->version;
    own->weight[own->count] = (int64_t)item->bytes;
    item->bytes = 0;
    own->count += own->weight[own->count] > 0;
    return SRV_STORED;
}

/* removes a pupil and all its items; readers see these as deleted */
static enum srv_stored class_dismiss(struct srv_store *store, struct srv_class *room,
                                     int64_t number) {
    struct srv_row_wholes gone = {.count = 1};
    SRV_STORED_TRY(
        SRV_RUN(store, SQL_CLASS_PUPIL_REMOVE, srv_row_wholes, &gone, room->code, number));
    if (!gone.rows) return SRV_STORED;
    int64_t before = room->version;
    struct class_own *own = calloc(1, sizeof *own);
    enum srv_stored stored = own ? SRV_STORED : SRV_STORED_BROKEN;
    if (own) own->code = room->code;
    for (int64_t seen = -1; stored == SRV_STORED && own->version > seen;) {
        seen = own->version;
        own->count = 0;
        stored = SRV_RUN(store, SQL_CLASS_ITEMS_OWN, row_own, own, room->code, number, seen);
        for (int i = 0; i < own->count && stored == SRV_STORED; i++) {
            room->bytes -= own->weight[i];
            stored = room->bytes < 0 ? SRV_STORED_DAMAGED : class_write(store, room, &own->item[i]);
        }
        /* skip items that were just written as deleted */
        if (own->version > before) break;
    }
    free(own);
    SRV_STORED_TRY(stored);
    if (!room->pupils) return SRV_STORED_DAMAGED;
    assert(room->version >= before);
    room->pupils--;
    /* so that the pupil's stream queries the store and finds that it has ended */
    room->shared = room->version;
    return class_change(store, room);
}

/* --- calls --- */

/* runs an operation in a locked room, after checking the client's permission */
static enum srv_stored
class_call(struct srv_store *store, struct srv_class_put *put, struct srv_class *room,
           enum srv_stored (*work)(struct srv_store *store, struct srv_class_put *put,
                                   struct srv_class *room)) {
    assert(put->code && put->who && *put->who && (put->body || !put->bytes));
    put->why = SRV_CLASS_FINE;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = class_lock(store, put, room);
    if (stored == SRV_STORED) stored = work(store, put, room);
    return srv_store_end(store, stored);
}

/* checks operations that only a teacher, or only a pupil, may do */
static enum srv_stored class_may(struct srv_class_put *put, const struct srv_class *room, int own) {
    if (!room->teacher && !room->pupil) return class_refuse(put, SRV_CLASS_STRANGER);
    if (own && !room->pupil) return class_refuse(put, SRV_CLASS_NO_PUPIL);
    return own || room->teacher ? SRV_STORED : class_refuse(put, SRV_CLASS_NO_TEACHER);
}

static enum srv_stored class_put_work(struct srv_store *store, struct srv_class_put *put,
                                      struct srv_class *room) {
    SRV_STORED_TRY(class_may(put, room, put->own));
    if (room->teacher && put->source) snprintf(room->near, sizeof room->near, "%s", put->source);
    if (!put->pupils) return class_put(store, put, room);
    int64_t from, to;
    for (const char *at = put->pupils; srv_store_class_range(&at, &from, &to);)
        for (; from <= to && from <= room->numbered; from++)
            SRV_STORED_TRY(class_dismiss(store, room, from));
    return SRV_STORED;
}

enum srv_stored srv_store_class_put(struct srv_store *store, struct srv_class_put *put,
                                    struct srv_class *room) {
    return class_call(store, put, room, class_put_work);
}

enum srv_stored srv_store_class_join(struct srv_store *store, struct srv_class_put *put,
                                     struct srv_class *room) {
    assert(put->body && put->bytes > 2 && put->source && put->fold);
    put->own = 1;
    return class_call(store, put, room, class_join);
}

static enum srv_stored class_end(struct srv_store *store, struct srv_class_put *put,
                                 struct srv_class *room) {
    if (!put->operates) SRV_STORED_TRY(class_may(put, room, 0));
    return srv_store_class_erase(store, put->code);
}

enum srv_stored srv_store_class_end(struct srv_store *store, struct srv_class_put *put,
                                    struct srv_class *room) {
    return class_call(store, put, room, class_end);
}

static enum srv_stored class_new(struct srv_store *store, const struct srv_class_new *made,
                                 struct srv_class *room, const char **full) {
    struct srv_class_codes known = {.count = 0};
    struct srv_row_wholes count = {.count = 3}, put = {.count = 1};
    int64_t now;
    /* the same call may have been committed although its reply was lost */
    if (store->unsure && class_find(store, SQL_CLASS, made->code, made->who, room) == SRV_STORED &&
        room->teacher)
        return SRV_STORED;
    if (made->key)
        SRV_STORED_TRY(
            SRV_RUN(store, SQL_CLASS_OF_KEY, srv_row_class_code, &known, made->who, made->key));
    if (known.count) {
        enum srv_stored stored = class_find(store, SQL_CLASS, known.code[0], made->who, room);
        /* an expired room that is not deleted yet has no teacher */
        if (stored != SRV_STORED_NONE) return stored;
        SRV_STORED_TRY(srv_store_class_erase(store, known.code[0]));
    }
    SRV_STORED_TRY(
        SRV_RUN(store, SQL_CLASS_COUNT, srv_row_wholes, &count, made->who, made->source));
    *full = count.whole[0] >= store->rules.classes ? "this server has"
            : count.whole[1] >= made->most         ? "you have"
            : count.whole[2] >= made->most_from    ? "your address has"
                                                   : NULL;
    if (*full) return SRV_STORED_QUOTA;
    SRV_STORED_TRY(srv_store_now(store, &now));
    SRV_STORED_TRY(SRV_RUN(store, SQL_CLASS_PUT, srv_row_wholes, &put, made->code, made->who,
                           made->key, now, now + made->span_us,
                           made->empty_us ? now + made->empty_us : 0, made->source));
    return put.rows ? class_find(store, SQL_CLASS, made->code, made->who, room) : SRV_STORED_CLASH;
}

enum srv_stored srv_store_class_new(struct srv_store *store, const struct srv_class_new *made,
                                    struct srv_class *room, const char **full) {
    assert(strlen(made->code) < SRV_CLASS_CODE && made->span_us > 0 && made->source);
    *full = NULL;
    SRV_STORED_TRY(srv_store_begin(store));
    return srv_store_end(store, class_new(store, made, room, full));
}

static enum srv_stored class_forget(struct srv_store *store, const char *client, int *count) {
    struct srv_class_codes in = {.count = 0};
    struct srv_class room;
    SRV_STORED_TRY(SRV_RUN(store, SQL_CLASS_OF, srv_row_class_code, &in, client));
    *count = in.count;
    if (!in.count) return SRV_STORED;
    const struct srv_class_put put = {.code = in.code[0], .who = client};
    enum srv_stored stored = class_lock(store, &put, &room);
    if (stored == SRV_STORED && !room.teacher) return class_dismiss(store, &room, room.pupil);
    /* an expired room that is not deleted yet is deleted too */
    return stored == SRV_STORED || stored == SRV_STORED_NONE
               ? srv_store_class_erase(store, put.code)
               : stored;
}

enum srv_stored srv_store_erase_classes(struct srv_store *store, const char *client, int *count) {
    *count = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    return srv_store_end(store, class_forget(store, client, count));
}

/* --- reading --- */

enum srv_stored srv_store_class(struct srv_store *store, const char *code, const char *who,
                                struct srv_class *room) {
    SRV_STORED_TRY(srv_store_look(store));
    return srv_store_end(store, class_find(store, SQL_CLASS, code, who, room));
}

struct class_taker {
    const char *code;
    srv_class_item_fn *take;
    void *context;
    int count, full;
    size_t bytes;
    int64_t version; /* of the last one */
};

static enum srv_stored row_taken(void *context, const struct srv_value field[]) {
    struct class_taker *taker = context;
    struct srv_class_item item;
    if (taker->full) return SRV_STORED;
    SRV_STORED_TRY(class_item(field, taker->code, &item));
    if (item.version <= taker->version) return SRV_STORED_DAMAGED;
    taker->bytes += item.bytes;
    taker->full = taker->bytes >= SRV_CLASS_PAGE_BYTES;
    taker->version = item.version;
    taker->count++;
    return taker->take(taker->context, &item);
}

static enum srv_stored class_items(struct srv_store *store, int64_t *since, int *more,
                                   const struct srv_class *room, struct class_taker *taker) {
    if (!room->teacher && !room->pupil) return SRV_STORED_CLASH;
    if (room->teacher)
        SRV_STORED_TRY(SRV_RUN(store, SQL_CLASS_ITEMS, row_taken, taker, room->code, *since));
    else
        SRV_STORED_TRY(
            SRV_RUN(store, SQL_CLASS_ITEMS_OF, row_taken, taker, room->code, *since, room->pupil));
    *more = taker->full || taker->count == SQL_CLASS_ITEMS_MOST;
    /* the room's row was read first, so there may be newer items than it counts */
    *since = *more || taker->version > room->version ? taker->version : room->version;
    return SRV_STORED;
}

enum srv_stored srv_store_class_items(struct srv_store *store, const char *code, const char *who,
                                      int64_t *since, int *more, struct srv_class *room,
                                      srv_class_item_fn *take, void *context) {
    assert(*since >= 0 && take);
    struct class_taker taker = {.code = code, .take = take, .context = context, .version = *since};
    *more = 0;
    SRV_STORED_TRY(srv_store_look(store));
    enum srv_stored stored = class_find(store, SQL_CLASS, code, who, room);
    if (stored == SRV_STORED) stored = class_items(store, since, more, room, &taker);
    return srv_store_end(store, stored);
}

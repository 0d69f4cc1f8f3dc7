/* Tests of server/store/store_classes: changes of a room are numbered without gaps, each reader
 * gets the items for it, limits are kept, and nothing remains of an expired room. */
#include "server/store/store_classes.h"

#include <stdio.h>
#include <string.h>

#include "server/store/store_rows.h"
#include "tests/server/ground.h"

enum { HOUR_S = 3600, ITEMS = 256 };

/* The items read from a room. */
struct found {
    int count;
    int64_t version[ITEMS];
    char name[ITEMS][SRV_CLASS_NAME], body[ITEMS][16];
};

static enum srv_stored take(void *context, const struct srv_class_item *item) {
    struct found *found = context;
    if (found->count == ITEMS) return SRV_STORED_BROKEN;
    found->version[found->count] = item->version;
    snprintf(found->name[found->count], SRV_CLASS_NAME, "%s", item->name);
    snprintf(found->body[found->count], 16, "%.*s", (int)item->bytes, (const char *)item->body);
    found->count++;
    return SRV_STORED;
}

/* everything that a client may read after a change, page by page */
static enum srv_stored read_all(struct srv_store *store, const char *who, int64_t since,
                                struct found *found) {
    struct srv_class room;
    int more = 1;
    found->count = 0;
    while (more) {
        enum srv_stored stored =
            srv_store_class_items(store, "ABCDEF", who, &since, &more, &room, take, found);
        if (stored != SRV_STORED) return stored;
    }
    CHECK_INT(since, room.version);
    return SRV_STORED;
}

static const char *body_of(const struct found *found, const char *name) {
    for (int i = 0; i < found->count; i++)
        if (!strcmp(found->name[i], name)) return found->body[i];
    return "nothing";
}

static struct srv_class_put item(const char *who, const char *name, const char *body, int own) {
    return (struct srv_class_put){.code = "ABCDEF",
                                  .who = who,
                                  .name = name,
                                  .own = own,
                                  .source = "5ee13",
                                  .fold = name,
                                  .shut = -1,
                                  .body = body,
                                  .bytes = body ? strlen(body) : 0};
}

static enum srv_stored put(struct srv_store *store, const char *who, const char *name,
                           const char *body, int own, enum srv_class_why why) {
    struct srv_class room;
    struct srv_class_put made = item(who, name, body, own);
    enum srv_stored stored = srv_store_class_put(store, &made, &room);
    CHECK_INT(made.why, why);
    return stored;
}

static enum srv_stored dismiss(struct srv_store *store, const char *numbers) {
    struct srv_class room;
    struct srv_class_put made = item("teacher", "", NULL, 0);
    made.pupils = numbers;
    return srv_store_class_put(store, &made, &room);
}

static enum srv_stored join(struct srv_store *store, const char *who, int64_t *pupil) {
    struct srv_class room;
    struct srv_class_put made = item(who, who, "{\"n\"}", 1);
    enum srv_stored stored = srv_store_class_join(store, &made, &room);
    *pupil = room.pupil;
    return stored;
}

/* a new room, limited by max-classes only */
static enum srv_stored make(struct srv_store *store, const char *code, const char *who,
                            const char *key, int64_t span_us, struct srv_class *room) {
    const char *full;
    const struct srv_class_new made = {code, who, key, "5ee13", span_us, 0, 1000, 1000};
    return srv_store_class_new(store, &made, room, &full);
}

static struct srv_store *begin(struct ground *ground, struct srv_class *room) {
    ground->rules.classes = 2;
    ground->rules.class_pupils = 3;
    ground->rules.class_bytes = 100000;
    struct srv_store *store = ground_open(ground);
    if (store)
        CHECK_INT(make(store, "ABCDEF", "teacher", NULL, (int64_t)HOUR_S * SECOND, room),
                  SRV_STORED);
    return store;
}

STORE_TEST(a_room_is_read_by_who_may) {
    struct srv_class room;
    struct found found;
    int64_t pupil;
    (void)store;
    OWN(srv_store, close) *own = begin(ground, &room);
    REQUIRE(own != NULL);
    CHECK(room.teacher && !room.pupil && !room.version && room.ends > room.created);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    CHECK_INT(pupil, 1);
    CHECK_INT(join(own, "bob", &pupil), SRV_STORED);
    CHECK_INT(pupil, 2);
    /* a repeated request */
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    CHECK_INT(pupil, 1);
    CHECK_INT(put(own, "teacher", "questions/q", "Q", 0, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(put(own, "ada", "stages", "A", 1, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(put(own, "bob", "stages", "B", 1, SRV_CLASS_FINE), SRV_STORED);
    struct srv_class_put hidden = item("teacher", "solutions/q", "S", 0);
    hidden.reader = SRV_CLASS_TEACHER;
    CHECK_INT(srv_store_class_put(own, &hidden, &room), SRV_STORED);
    CHECK_INT(room.version, 6);
    CHECK_INT(read_all(own, "teacher", 0, &found), SRV_STORED);
    CHECK_INT(found.count, 6);
    for (int i = 0; i < found.count; i++) CHECK_INT(found.version[i], i + 1);
    CHECK_INT(read_all(own, "ada", 0, &found), SRV_STORED);
    CHECK_INT(found.count, 3);
    CHECK_TEXT(body_of(&found, "stages/1"), "A");
    CHECK_TEXT(body_of(&found, "stages/2"), "nothing");
    CHECK_TEXT(body_of(&found, "solutions/q"), "nothing");
    CHECK_INT(read_all(own, "eve", 0, &found), SRV_STORED_CLASH);
    CHECK_INT(put(own, "eve", "stages", "E", 1, SRV_CLASS_STRANGER), SRV_STORED_CLASH);
    CHECK_INT(put(own, "ada", "questions/q", "E", 0, SRV_CLASS_NO_TEACHER), SRV_STORED_CLASH);
    CHECK_INT(put(own, "teacher", "stages", "E", 1, SRV_CLASS_NO_PUPIL), SRV_STORED_CLASH);
    /* an unchanged item is no change */
    CHECK_INT(put(own, "ada", "stages", "A", 1, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(read_all(own, "teacher", 6, &found), SRV_STORED);
    CHECK_INT(found.count, 0);
    CHECK_INT(put(own, "ada", "stages", "AA", 1, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(read_all(own, "teacher", 6, &found), SRV_STORED);
    CHECK(found.count == 1 && found.version[0] == 7);
}

static int fits(int64_t base, int64_t flag) { return base / 2 == flag; }

STORE_TEST(an_answer_needs_a_question_that_is_open_and_of_its_kind) {
    struct srv_class room;
    int64_t pupil;
    (void)store;
    OWN(srv_store, close) *own = begin(ground, &room);
    REQUIRE(own != NULL);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    struct srv_class_put answer = item("ada", "answers/q", "1", 1),
                         question = item("teacher", "questions/q", "Q", 0);
    answer.base = "questions/q";
    answer.fits = fits;
    answer.flag = 4;
    CHECK_INT(srv_store_class_put(own, &answer, &room), SRV_STORED_CLASH);
    CHECK_INT(answer.why, SRV_CLASS_NO_BASE);
    question.flag = 6;
    CHECK_INT(srv_store_class_put(own, &question, &room), SRV_STORED);
    CHECK_INT(srv_store_class_put(own, &answer, &room), SRV_STORED_CLASH);
    CHECK_INT(answer.why, SRV_CLASS_MISFIT);
    question.flag = 8;
    CHECK_INT(srv_store_class_put(own, &question, &room), SRV_STORED);
    CHECK_INT(srv_store_class_put(own, &answer, &room), SRV_STORED);
    question.flag = 9;
    CHECK_INT(srv_store_class_put(own, &question, &room), SRV_STORED);
    answer.body = "2";
    CHECK_INT(srv_store_class_put(own, &answer, &room), SRV_STORED_CLASH);
    CHECK_INT(answer.why, SRV_CLASS_CLOSED);
    /* a deleted question accepts no answer, and its answers stay */
    struct found found;
    CHECK_INT(put(own, "teacher", "questions/q", NULL, 0, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(srv_store_class_put(own, &answer, &room), SRV_STORED_CLASH);
    CHECK_INT(answer.why, SRV_CLASS_NO_BASE);
    CHECK_INT(read_all(own, "teacher", 0, &found), SRV_STORED);
    CHECK_TEXT(body_of(&found, "answers/q/1"), "1");
    CHECK_TEXT(body_of(&found, "questions/q"), "");
}

STORE_TEST(a_room_is_bounded) {
    static char large[SRV_CLASS_PUPIL_BYTES + 1];
    struct srv_class room;
    int64_t pupil;
    (void)store;
    memset(large, 'x', sizeof large - 1);
    OWN(srv_store, close) *own = begin(ground, &room);
    REQUIRE(own != NULL);
    CHECK_INT(make(own, "ABCDEF", "t", NULL, SECOND, &room), SRV_STORED_CLASH);
    CHECK_INT(make(own, "ABCDFF", "t", "key", SECOND, &room), SRV_STORED);
    CHECK_INT(make(own, "ABCDGF", "t", "key", SECOND, &room), SRV_STORED);
    CHECK_TEXT(room.code, "ABCDFF");
    CHECK_INT(make(own, "ABCDGF", "t", NULL, SECOND, &room), SRV_STORED_QUOTA);
    for (int i = 0; i < 3; i++) {
        const char who[] = {(char)('a' + i), 0};
        CHECK_INT(join(own, who, &pupil), SRV_STORED);
    }
    CHECK_INT(join(own, "d", &pupil), SRV_STORED_CLASH);
    CHECK_INT(join(own, "a", &pupil), SRV_STORED);
    /* a removed pupil frees its slot, and is no longer a member */
    CHECK_INT(put(own, "a", "stages", "A", 1, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(dismiss(own, "1"), SRV_STORED);
    CHECK_INT(dismiss(own, "1"), SRV_STORED);
    CHECK_INT(put(own, "a", "stages", "A", 1, SRV_CLASS_STRANGER), SRV_STORED_CLASH);
    CHECK_INT(join(own, "d", &pupil), SRV_STORED);
    CHECK_INT(pupil, 4);
    CHECK_INT(put(own, "teacher", "worksheets/w", large, 0, SRV_CLASS_ROOM_FULL), SRV_STORED_CLASH);
    srv_store_close(&own);
    ground->rules.class_bytes = 1 << 20;
    REQUIRE((own = ground_open(ground)) != NULL);
    CHECK_INT(put(own, "d", "handins/w", large, 1, SRV_CLASS_PUPIL_FULL), SRV_STORED_CLASH);
    CHECK_INT(put(own, "teacher", "worksheets/w", large, 0, SRV_CLASS_FINE), SRV_STORED);
    /* the bytes counted for a room are those of its items, after any changes */
    CHECK_INT(put(own, "teacher", "worksheets/w", "short", 0, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(ground_ask(ground, "SELECT bytes FROM classes WHERE code = 'ABCDEF'"),
              ground_ask(ground, "SELECT CAST(SUM(LENGTH(body) + 128) AS BIGINT) FROM class_items "
                                 "WHERE code = 'ABCDEF'"));
}

STORE_TEST(a_pupil_with_many_items_goes_with_all_of_them) {
    struct srv_class room;
    struct found found;
    int64_t pupil;
    char name[32];
    (void)store;
    OWN(srv_store, close) *own = begin(ground, &room);
    REQUIRE(own != NULL);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    for (int i = 0; i < 100; i++) {
        snprintf(name, sizeof name, "answers/q%d", i);
        CHECK_INT(put(own, "ada", name, "A", 1, SRV_CLASS_FINE), SRV_STORED);
    }
    CHECK_INT(read_all(own, "ada", 0, &found), SRV_STORED);
    CHECK_INT(found.count, 101);
    CHECK_INT(dismiss(own, "1"), SRV_STORED);
    CHECK_INT(read_all(own, "teacher", 101, &found), SRV_STORED);
    CHECK_INT(found.count, 101);
    for (int i = 0; i < found.count; i++) {
        CHECK_INT(found.version[i], 102 + i);
        CHECK_TEXT(found.body[i], "");
    }
    CHECK_INT(ground_ask(ground, "SELECT bytes FROM classes"), 101 * SRV_CLASS_ITEM_BYTES);
}

STORE_TEST(of_a_room_that_has_ended_nothing_is_left) {
    static const char left[] = "SELECT CAST((SELECT COUNT(*) FROM classes) + (SELECT COUNT(*) FROM "
                               "class_items) + (SELECT COUNT(*) FROM class_pupils) AS BIGINT)";
    struct srv_class room;
    struct srv_store_sweep sweep = {.more = 1};
    int64_t pupil, version, shared, looked = 0;
    (void)store;
    OWN(srv_store, close) *own = begin(ground, &room);
    REQUIRE(own != NULL);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    CHECK_INT(put(own, "teacher", "questions/q", "Q", 0, SRV_CLASS_FINE), SRV_STORED);
    CHECK_INT(srv_store_class_mark(own, "ABCDEF", &version, &shared), SRV_STORED);
    CHECK(version == 2 && shared == 2);
    struct srv_class_put end = item("ada", "", NULL, 0);
    CHECK_INT(srv_store_class_end(own, &end, &room), SRV_STORED_CLASH);
    CHECK_INT(end.why, SRV_CLASS_NO_TEACHER);
    CHECK_INT(ground_ask(ground, left), 4);
    end.who = "teacher";
    CHECK_INT(srv_store_class_end(own, &end, &room), SRV_STORED);
    CHECK_INT(ground_ask(ground, left), 0);
    CHECK_INT(srv_store_class(own, "ABCDEF", "teacher", &room), SRV_STORED_NONE);
    CHECK_INT(srv_store_class_mark(own, "ABCDEF", &version, &shared), SRV_STORED_NONE);
    /* an expired room is invisible at once, and is deleted by a sweep */
    CHECK_INT(make(own, "ABCDEF", "teacher", "k", SECOND, &room), SRV_STORED);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    ground_run(ground, "UPDATE classes SET ends = 1");
    CHECK_INT(srv_store_class(own, "ABCDEF", "teacher", &room), SRV_STORED_NONE);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED_NONE);
    CHECK_INT(ground_ask(ground, left), 3);
    while (sweep.more) REQUIRE(srv_store_sweep(own, &looked, &sweep) == SRV_STORED);
    CHECK_INT(ground_ask(ground, left), 0);
}

/* --- who comes from where, and how they are called --- */

/* joins with a fold and from an address; the body of the pupil's item, "" if none is written */
static const char *join_as(struct srv_store *store, const char *who, const char *source,
                           const char *fold, enum srv_class_why why) {
    static struct found found;
    struct srv_class room;
    struct srv_class_put made = item(who, fold, "{\"n\"}", 1);
    char name[SRV_CLASS_NAME];
    made.source = source;
    CHECK_INT(srv_store_class_join(store, &made, &room), why ? SRV_STORED_CLASH : SRV_STORED);
    CHECK_INT(made.why, why);
    CHECK_INT(read_all(store, "teacher", 0, &found), SRV_STORED);
    snprintf(name, sizeof name, "pupils/%lld", (long long)room.pupil);
    return why ? "" : body_of(&found, name);
}

static struct srv_store *begin_large(struct ground *ground) {
    struct srv_class room;
    struct srv_store *own = begin(ground, &room);
    srv_store_close(&own);
    ground->rules.class_pupils = 1000;
    return ground_open(ground);
}

STORE_TEST(names_that_look_alike_are_numbered) {
    (void)store;
    OWN(srv_store, close) *own = begin_large(ground);
    REQUIRE(own != NULL);
    CHECK_TEXT(join_as(own, "a", "5ee13", "anna", SRV_CLASS_FINE), "{\"n\"}");
    CHECK_TEXT(join_as(own, "b", "5ee13", "ann", SRV_CLASS_FINE), "{\"n\"}");
    CHECK_TEXT(join_as(own, "c", "5ee13", "anna", SRV_CLASS_FINE), "{\"n (2)\"}");
    /* a nickname that another got by its number gets a number too, and a number that is typed
     * counts as in use */
    CHECK_TEXT(join_as(own, "d", "5ee13", "anna(2)", SRV_CLASS_FINE), "{\"n (2)\"}");
    CHECK_TEXT(join_as(own, "e", "5ee13", "bob(2)", SRV_CLASS_FINE), "{\"n\"}");
    CHECK_TEXT(join_as(own, "f", "5ee13", "bob", SRV_CLASS_FINE), "{\"n\"}");
    CHECK_TEXT(join_as(own, "g", "5ee13", "bob", SRV_CLASS_FINE), "{\"n (3)\"}");
    CHECK_TEXT(join_as(own, "h", "5ee13", "anna", SRV_CLASS_FINE), "{\"n (3)\"}");
    /* a pupil that joins again keeps its name; a number is free when its pupil is removed */
    CHECK_TEXT(join_as(own, "h", "5ee13", "anna", SRV_CLASS_FINE), "{\"n (3)\"}");
    CHECK_INT(dismiss(own, "3"), SRV_STORED);
    CHECK_TEXT(join_as(own, "i", "5ee13", "anna", SRV_CLASS_FINE), "{\"n (2)\"}");
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(DISTINCT fold) AS BIGINT) FROM class_pupils"),
              8);
    CHECK_INT(
        ground_ask(ground, "SELECT bytes FROM classes"),
        ground_ask(ground, "SELECT CAST(SUM(LENGTH(body) + 128) AS BIGINT) FROM class_items"));
}

STORE_TEST(an_address_has_a_share_of_a_room_that_its_teacher_raises) {
    struct srv_class room;
    char who[16];
    (void)store;
    OWN(srv_store, close) *own = begin_large(ground);
    REQUIRE(own != NULL);
    ground_run(ground, "UPDATE classes SET share = 3");
    for (int i = 0; i < 4; i++) {
        snprintf(who, sizeof who, "p%d", i);
        (void)join_as(own, who, "5ee13", who, i < 3 ? SRV_CLASS_FINE : SRV_CLASS_SHARED);
    }
    (void)join_as(own, "other", "0a0a0", "other", SRV_CLASS_FINE);
    struct srv_class_put stage = item("teacher", "stages/class", "{}", 0);
    stage.share = 4;
    CHECK_INT(srv_store_class_put(own, &stage, &room), SRV_STORED);
    stage.share = 0;
    CHECK_INT(srv_store_class_put(own, &stage, &room), SRV_STORED);
    CHECK_INT(room.share, 4);
    CHECK_TEXT(room.near, "5ee13");
    (void)join_as(own, "p3", "5ee13", "p3", SRV_CLASS_FINE);
    (void)join_as(own, "p4", "5ee13", "p4", SRV_CLASS_SHARED);
    /* many are removed at once, and missing ones cost nothing */
    CHECK_INT(dismiss(own, "1-2,5,900-999999999"), SRV_STORED);
    CHECK_INT(srv_store_class(own, "ABCDEF", "teacher", &room), SRV_STORED);
    CHECK_INT(room.pupils, 2);
    (void)join_as(own, "p4", "5ee13", "p4", SRV_CLASS_FINE);
}

STORE_TEST(rooms_of_a_teacher_and_of_an_address_are_bounded_and_empty_ones_end) {
    struct srv_class room;
    const char *full;
    struct srv_store_sweep sweep = {.more = 1};
    int64_t pupil, looked = 0;
    (void)store;
    OWN(srv_store, close) *own = begin(ground, &room);
    REQUIRE(own != NULL);
    srv_store_close(&own);
    ground->rules.classes = 1000;
    REQUIRE((own = ground_open(ground)) != NULL);
    struct srv_class_new made = {
        "QRSTUF", "t", NULL, "0a0a0", 2 * (int64_t)HOUR_S * SECOND, (int64_t)HOUR_S * SECOND, 1, 2};
    CHECK_INT(srv_store_class_new(own, &made, &room, &full), SRV_STORED);
    CHECK_INT(room.empty_ends - room.created, (int64_t)HOUR_S * SECOND);
    made.code = "QRSTUG";
    CHECK_INT(srv_store_class_new(own, &made, &room, &full), SRV_STORED_QUOTA);
    CHECK_TEXT(full, "you have");
    made.who = "u";
    CHECK_INT(srv_store_class_new(own, &made, &room, &full), SRV_STORED);
    made.code = "QRSTUH";
    made.who = "v";
    CHECK_INT(srv_store_class_new(own, &made, &room, &full), SRV_STORED_QUOTA);
    CHECK_TEXT(full, "your address has");
    /* one of the two is joined, and outlives its first hour; the other is deleted */
    struct srv_class_put in = item("ada", "ada", "{\"n\"}", 1);
    in.code = "QRSTUF";
    CHECK_INT(srv_store_class_join(own, &in, &room), SRV_STORED);
    CHECK_INT(room.empty_ends, 0);
    ground_run(ground, "UPDATE classes SET empty_ends = 1 WHERE empty_ends > 0");
    int64_t version, shared;
    CHECK_INT(srv_store_class(own, "QRSTUF", "t", &room), SRV_STORED);
    CHECK_INT(srv_store_class(own, "QRSTUG", "u", &room), SRV_STORED_NONE);
    CHECK_INT(srv_store_class_mark(own, "QRSTUG", &version, &shared), SRV_STORED_NONE);
    while (sweep.more) REQUIRE(srv_store_sweep(own, &looked, &sweep) == SRV_STORED);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM classes"), 2);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    /* an erased client has no rooms, and is in none */
    int count = 1, erased = 0;
    for (; count; erased += count)
        CHECK_INT(srv_store_erase_classes(own, "ada", &count), SRV_STORED);
    CHECK_INT(erased, 2);
    CHECK_INT(srv_store_erase_classes(own, "t", &count), SRV_STORED);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM class_pupils"), 0);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM classes"), 1);
}

/* two processes on one store: a process that is blocked by the other says so, and no number is used
 * twice */
STORE_TEST(two_connections_number_the_changes_of_a_room_together) {
    struct srv_class room;
    struct found found;
    int64_t pupil;
    char body[16];
    (void)store;
    struct srv_store *own = begin(ground, &room), *other = ground_open(ground);
    REQUIRE(own != NULL && other != NULL);
    CHECK_INT(join(own, "ada", &pupil), SRV_STORED);
    CHECK_INT(join(other, "bob", &pupil), SRV_STORED);
    for (int i = 0; i < 20; i++) {
        snprintf(body, sizeof body, "%d", i);
        CHECK_INT(put(own, "ada", "stages", body, 1, SRV_CLASS_FINE), SRV_STORED);
        CHECK_INT(put(other, "bob", "stages", body, 1, SRV_CLASS_FINE), SRV_STORED);
    }
    CHECK_INT(read_all(other, "teacher", 0, &found), SRV_STORED);
    CHECK_INT(found.count, 4);
    CHECK(found.version[2] == 41 && found.version[3] == 42);
    srv_store_close(&other);
    srv_store_close(&own);
}

/* every column of every row of a room, altered: the room may be damaged or gone, nothing crashes,
 * and another room is unaffected */
STORE_TEST(an_altered_row_harms_its_room_alone) {
    static const char *const columns[] = {
        "classes.code",        "classes.teacher",     "classes.key",        "classes.created",
        "classes.ends",        "classes.version",     "classes.shared",     "classes.pupils",
        "classes.numbered",    "classes.bytes",       "classes.shut",       "class_pupils.code",
        "class_pupils.who",    "class_pupils.number", "class_pupils.bytes", "class_items.code",
        "class_items.name",    "class_items.version", "class_items.reader", "class_items.flag",
        "class_items.changed", "class_items.body",    "class_items.seal",   "classes.source",
        "classes.near",        "classes.empty_ends",  "classes.share",      "class_pupils.source",
        "class_pupils.fold"};
    static const char *const values[] = {"NULL",   "-1", "0", "2000000", "9223372036854775807",
                                         "'word'", "''"};
    struct srv_class room;
    struct found found;
    struct srv_store_sweep sweep;
    int64_t looked = 0;
    (void)store;
    OWN(srv_store, close) *own = begin(ground, &room);
    REQUIRE(own != NULL);
    ground->rules.classes = 1000;
    srv_store_close(&own);
    REQUIRE((own = ground_open(ground)) != NULL);
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    struct pend_error error;
    struct srv_sql *sql = NULL;
    REQUIRE(driver->open(&sql, ground->url, 0, &error) == PEND_OK);
    CHECK_INT(put(own, "teacher", "questions/q", "Q", 0, SRV_CLASS_FINE), SRV_STORED);
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++)
        for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
            char text[200], table[16];
            const char *column = strchr(columns[c], '.') + 1;
            snprintf(table, sizeof table, "%.*s", (int)(column - columns[c] - 1), columns[c]);
            struct srv_class_put in = item("t", "t", "{\"n\"}", 1), out = in, write = in;
            in.code = out.code = write.code = "WORDS";
            CHECK_INT(make(own, "WORDS", "t", "key", (int64_t)HOUR_S * SECOND, &room), SRV_STORED);
            in.who = write.who = "p";
            CHECK_INT(srv_store_class_join(own, &in, &room), SRV_STORED);
            snprintf(text, sizeof text, "UPDATE %s SET %s = %s WHERE code = 'WORDS'", table, column,
                     values[v]);
            (void)driver->run(sql, -1, "{begin}", NULL, 0, NULL, NULL);
            int bad = driver->run(sql, -1, text, NULL, 0, NULL, NULL) == SRV_STORED;
            (void)driver->run(sql, -1, bad ? "COMMIT" : "ROLLBACK", NULL, 0, NULL, NULL);
            int64_t since = 0, version, shared;
            int more;
            write.name = "stages";
            found.count = 0;
            enum srv_stored said[] = {
                srv_store_class(own, "WORDS", "p", &room),
                srv_store_class_mark(own, "WORDS", &version, &shared),
                srv_store_class_put(own, &write, &room),
                srv_store_class_items(own, "WORDS", "t", &since, &more, &room, take, &found),
                srv_store_class_join(own, &in, &room)};
            for (size_t i = 0; i < sizeof said / sizeof *said; i++)
                CHECK_SAYING(said[i] <= SRV_STORED_DAMAGED || said[i] == SRV_STORED_AGAIN,
                             "%s = %s: call %zu says %d", columns[c], values[v], i, (int)said[i]);
            for (int i = 0; i < found.count; i++) CHECK_TEXT(found.body[i], "{\"n\"}");
            out.pupils = "1";
            out.body = NULL;
            out.bytes = 0;
            out.own = 0;
            (void)srv_store_class_put(own, &out, &room);
            (void)srv_store_class_end(own, &out, &room);
            (void)driver->run(sql, -1,
                              "UPDATE classes SET ends = 1 WHERE code <> 'ABCDEF' OR code IS NULL",
                              NULL, 0, NULL, NULL);
            for (int i = 0; i < 3; i++)
                REQUIRE(srv_store_sweep(own, &looked, &sweep) == SRV_STORED);
            struct srv_row_wholes left = {.count = 1};
            (void)driver->run(sql, -1, "DELETE FROM class_items WHERE code <> 'ABCDEF'", NULL, 0,
                              NULL, NULL);
            (void)driver->run(sql, -1, "DELETE FROM class_pupils WHERE code <> 'ABCDEF'", NULL, 0,
                              NULL, NULL);
            (void)driver->run(sql, -1, "SELECT CAST(COUNT(*) AS BIGINT) FROM classes", NULL, 0,
                              srv_row_wholes, &left);
            CHECK_INT(left.whole[0], 1);
        }
    driver->close(sql);
    CHECK_INT(read_all(own, "teacher", 0, &found), SRV_STORED);
    CHECK(found.count == 1 && !strcmp(found.body[0], "Q"));
}

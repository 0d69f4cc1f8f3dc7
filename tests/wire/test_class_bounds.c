/* Limits against the abuse of classrooms, on both stores: guessed codes, crowds, clients that take
 * all rooms, names of others, and invalid keys. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/wire/place.h"

enum { PATH = 80, KEY = 160 };

/* A room and its teacher's token. */
struct room {
    char code[8], token[40];
};

/* a daemon that computes nothing, so that a job waits */
static struct test_server *serve(const struct place *place, const char *option, const char *value) {
    const char *const options[] = {"--store",   place->url, "--role", "api", "--trusted-proxy",
                                   "127.0.0.1", option,     value,    NULL};
    return test_server_start(options);
}

/* requests /v1/classes and the rest of a path from an address with further fields; returns the
 * status */
static int from(const struct test_server *server, const char *address, const char *method,
                const char *rest, const char *fields, const char *body, struct test_reply *reply) {
    char path[PATH + 512], headers[512];
    snprintf(path, sizeof path, "/v1/classes%s", rest);
    snprintf(headers, sizeof headers, "X-Forwarded-For: %s\r\n%s", address, fields);
    return test_request(server, reply, method, path, headers, body);
}

static int does(const struct test_server *server, const char *address, const char *method,
                const char *rest, const char *fields, const char *body) {
    OWN(test_reply, clear) reply;
    int status = from(server, address, method, rest, fields, body, &reply);
    if (status >= 400) ask_problem(&reply, status, NULL);
    return status;
}

/* creates a room; returns the status */
static int make(const struct test_server *server, const char *address, const char *fields,
                struct room *room) {
    OWN(test_reply, clear) reply;
    int status = from(server, address, "POST", "", fields, "{\"hours\":2}", &reply);
    *room = (struct room){.code = ""};
    if (status == 201) {
        cJSON *json = ask_json(&reply);
        const char *code = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "code")),
                   *token = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "token"));
        if (CHECK(code && strlen(code) == 6)) snprintf(room->code, sizeof room->code, "%s", code);
        if (token) snprintf(room->token, sizeof room->token, "%s", token);
        CHECK(cJSON_GetObjectItemCaseSensitive(json, "ends") != NULL);
        cJSON_Delete(json);
    }
    return status;
}

static int join(const struct test_server *server, const char *address, const char *code,
                const char *nickname) {
    char rest[PATH], body[160];
    snprintf(rest, sizeof rest, "/%s/pupils", code);
    snprintf(body, sizeof body, "{\"nickname\":\"%s\"}", nickname);
    return does(server, address, "POST", rest, "", body);
}

/* a request of a room's teacher; `rest` follows its path */
static int teaches(const struct test_server *server, const char *address, const struct room *room,
                   const char *method, const char *rest, const char *body,
                   struct test_reply *reply) {
    char path[PATH + 256], fields[80];
    snprintf(path, sizeof path, "/%s%s", room->code, rest);
    snprintf(fields, sizeof fields, "Class-Token: %s\r\n", room->token);
    return from(server, address, method, path, fields, body, reply);
}

static int teaches_from(const struct test_server *server, const char *address,
                        const struct room *room, const char *method, const char *rest,
                        const char *body) {
    OWN(test_reply, clear) reply;
    return teaches(server, address, room, method, rest, body, &reply);
}

static int teacher(const struct test_server *server, const struct room *room, const char *method,
                   const char *rest, const char *body) {
    return teaches_from(server, "203.0.113.1", room, method, rest, body);
}

/* --- guesses --- */

/* wrong codes from an address, one after the other; returns how many were answered 404 */
static int guess(const struct test_server *server, const char *address, int count, int first) {
    char code[8];
    int missed = 0;
    for (int i = first; i < first + count; i++) {
        snprintf(code, sizeof code, "ZZZ%c%c%c", 'A' + i / 24 / 24 % 8, 'P' + i / 24 % 11,
                 'P' + i % 11);
        int status = join(server, address, code, "Eve");
        CHECK(status == 404 || status == 429);
        missed += status == 404;
    }
    return missed;
}

/* a room whose teacher has an address */
static int make_from(const struct test_server *server, const char *address, struct room *room) {
    return CHECK_INT(make(server, address, "", room), 201);
}

static void guesses(struct place *place) {
    struct room room, made, taught, joined;
    char address[32];
    OWN(test_server, stop) *server = serve(place, NULL, NULL);
    if (!server || !make_from(server, "203.0.113.1", &room) ||
        !make_from(server, "203.0.113.1", &taught) || !make_from(server, "203.0.113.1", &joined) ||
        !make_from(server, "192.0.2.9", &made))
        return;
    /* from a school's address: some are told that there is no such room, the others to wait, too */
    double begun = test_clock();
    int missed = guess(server, "198.51.100.7", 200, 0);
    CHECK_SAYING(missed >= 30 && missed <= 31 + 0.5 * (test_clock() - begun), "%d", missed);
    CHECK_INT(join(server, "198.51.100.7", room.code, "Ada"), 201);
    /* of a network: each address has guessed less than it may */
    for (int i = 0; i < 20; i++) {
        snprintf(address, sizeof address, "198.51.100.%d", 100 + i);
        missed += guess(server, address, 10, 10 * i);
    }
    CHECK_SAYING(missed >= 120 && missed <= 122 + 2 * (test_clock() - begun), "%d", missed);
    missed = guess(server, "2001:db8:1:1::1", 20, 0) + guess(server, "2001:db8:2:1::1", 20, 0);
    CHECK_INT(missed, 40);
    CHECK_INT(join(server, "198.51.100.150", room.code, "Bob"), 201);
    /* a client that guesses faster than mistakes explain gets into rooms that know the address: one
     * was created there, a pupil joined another from it, the teacher of the third wrote from it */
    CHECK_INT(join(server, "192.0.2.9", joined.code, "Cleo"), 201);
    CHECK_INT(
        teaches_from(server, "192.0.2.9", &taught, "PUT", "/stages/class", "{\"frozen\":true}"),
        200);
    begun = test_clock();
    (void)guess(server, "192.0.2.9", 1500, 0);
    if (test_clock() - begun < 40) CHECK_INT(join(server, "192.0.2.9", room.code, "Dan"), 429);
    CHECK_INT(join(server, "192.0.2.9", made.code, "Dan"), 201);
    CHECK_INT(join(server, "192.0.2.9", joined.code, "Dan"), 201);
    CHECK_INT(join(server, "192.0.2.9", taught.code, "Dan"), 201);
}

TEST(a_right_code_gets_in_after_wrong_ones_which_alone_are_slowed) { place_on_both(guesses); }

/* --- names and crowds --- */

/* how often a text occurs in what the teacher reads */
static int reads(const struct test_server *server, const struct room *room, const char *rest,
                 const char *text) {
    OWN(test_reply, clear) reply;
    int count = 0;
    CHECK_INT(teaches(server, "203.0.113.1", room, "GET", rest, NULL, &reply), 200);
    for (const char *at = reply.body; at && (at = strstr(at, text)); at++) count++;
    return count;
}

static void names(struct place *place) {
    static const char *const anna[] = {"Anna", "Anna", "A\xe2\x80\x8bnna", "\xd0\x90nna",
                                       "\xef\xbc\xa1nna"};
    struct room room;
    struct test_reply reply;
    OWN(test_server, stop) *server = serve(place, NULL, NULL);
    if (!server || !CHECK_INT(make(server, "203.0.113.1", "", &room), 201)) return;
    for (int i = 0; i < 5; i++) CHECK_INT(join(server, "203.0.113.2", room.code, anna[i]), 201);
    CHECK_INT(join(server, "203.0.113.2", room.code, "\xe2\x80\x8b\xe2\x81\xa0"), 422);
    CHECK_INT(join(server, "203.0.113.2", room.code, "A\xe2\x80\xa8nna"), 422);
    CHECK_INT(join(server, "203.0.113.2", room.code, "A\xc2\x85nna"), 422);
    for (int i = 1; i < 5; i++) {
        char text[64];
        snprintf(text, sizeof text, "%s (%d)\"", anna[i], i + 1);
        CHECK_INT(reads(server, &room, "", text), 1);
    }
    CHECK_INT(teacher(server, &room, "PUT", "/questions/q", "{\"text\":\"q\",\"kind\":\"text\"}"),
              200);
    static const char who[] = "Class-Token: fedcba9876543210fedcba9876543210\r\n";
    char rest[PATH];
    snprintf(rest, sizeof rest, "/%s/pupils", room.code);
    CHECK_INT(does(server, "203.0.113.2", "POST", rest, who, "{\"nickname\":\"anna\"}"), 201);
    snprintf(rest, sizeof rest, "/%s/answers/q", room.code);
    CHECK_INT(does(server, "203.0.113.2", "PUT", rest, who, "{\"value\":\"a;=1\"}"), 200);
    CHECK_INT(reads(server, &room, "/table", "answers,q,,6,\"anna (6)\",\"a;'=1\","), 1);
    CHECK_INT(reads(server, &room, "/table?decimal=comma", "answers;q;;6;\"anna (6)\";\"a;'=1\";"),
              1);
    CHECK_INT(teaches(server, "203.0.113.1", &room, "GET", "/table?decimal=point", NULL, &reply),
              200);
    CHECK(reply.body && !strncmp(reply.body, "\xef\xbb\xbfitem,", 8));
    test_reply_clear(&reply);
    CHECK_INT(teacher(server, &room, "GET", "/table?decimal=dot", NULL), 422);
}

TEST(a_nickname_that_looks_like_another_is_numbered_wherever_it_is_read) { place_on_both(names); }

static void crowds(struct place *place) {
    struct room room;
    OWN(test_server, stop) *server = serve(place, "--max-class-pupils", "100");
    if (!server || !CHECK_INT(make(server, "203.0.113.1", "", &room), 201)) return;
    for (int i = 0; i < 40; i++) CHECK_INT(join(server, "198.51.100.1", room.code, "Anna"), 201);
    CHECK_INT(join(server, "198.51.100.1", room.code, "Anna"), 429);
    CHECK_INT(join(server, "198.51.100.2", room.code, "Bo"), 201);
    /* the teacher lets more in, which remains when the class's stage is written without it */
    CHECK_INT(teacher(server, &room, "PUT", "/stages/class", "{\"address_share\":0}"), 422);
    CHECK_INT(teacher(server, &room, "PUT", "/stages/class", "{\"address_share\":41}"), 200);
    CHECK_INT(teacher(server, &room, "PUT", "/stages/class", "{\"frozen\":true}"), 200);
    CHECK_INT(join(server, "198.51.100.1", room.code, "Cleo"), 201);
    CHECK_INT(join(server, "198.51.100.1", room.code, "Dan"), 429);
    /* many are removed by one request, all others stay */
    static const char *const bad[] = {"/pupils/",    "/pupils/0",    "/pupils/3-", "/pupils/-3",
                                      "/pupils/5-3", "/pupils/1,,2", "/pupils/01", "/pupils/x"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_SAYING(teacher(server, &room, "DELETE", bad[i], NULL) == 404, "%s", bad[i]);
    CHECK_INT(teacher(server, &room, "DELETE", "/pupils/1-40,77", NULL), 204);
    CHECK_INT(reads(server, &room, "", "\"nickname\":"), 2);
    CHECK_INT(reads(server, &room, "", "\"pupils\":2,"), 1);
    CHECK_INT(join(server, "198.51.100.1", room.code, "Eli"), 201);
}

TEST(an_address_has_a_share_of_a_room_and_many_pupils_go_at_once) { place_on_both(crowds); }

/* --- rooms, keys --- */

/* a directory for a file of keys, for either store */
static int keys_begin(char file[128]) {
    static char directory[] = "/tmp/pendulumd-bounds-XXXXXX";
    strcpy(strrchr(directory, '-'), "-XXXXXX");
    if (!CHECK(mkdtemp(directory) != NULL)) return 0;
    snprintf(file, 128, "%s/keys", directory);
    return 1;
}

static void keys_end(char file[128]) {
    unlink(file);
    *strrchr(file, '/') = 0;
    rmdir(file);
}

/* creates a key; returns its header field */
static void key(const char *file, const char *name, const char *role, const char *quota,
                char field[KEY]) {
    char text[512];
    const char *const words[] = {
        "keys", "add", "--keys", file, "--name", name, "--role", role, quota ? "--quota" : NULL,
        quota,  NULL};
    CHECK_INT(test_server_run(words, text, sizeof text), 0);
    text[strcspn(text, "\n")] = 0;
    snprintf(field, KEY, "Authorization: Bearer %.63s\r\n", text);
}

static void bounds(struct place *place) {
    struct room room[24];
    char file[128], root[KEY], lab[KEY], rest[PATH], text[512];
    struct test_reply reply;
    if (!keys_begin(file)) return;
    key(file, "root", "operator", NULL, root);
    key(file, "lab", "teacher", "rooms=2", lab);
    struct test_server *server = serve(place, "--keys", file);
    if (!server) return;
    /* by address, by key, and for a client without one */
    for (int i = 0; i < 20; i++) CHECK_INT(make(server, "198.51.100.1", "", &room[i]), 201);
    CHECK_INT(make(server, "198.51.100.1", "", &room[20]), 429);
    CHECK_INT(make(server, "198.51.100.2", "", &room[20]), 201);
    CHECK_INT(make(server, "198.51.100.1", lab, &room[21]), 201);
    CHECK_INT(make(server, "198.51.100.1", lab, &room[22]), 201);
    CHECK_INT(make(server, "198.51.100.3", lab, &room[23]), 429);
    /* a teacher's list has its rooms, an operator's all, a client without a token has none */
    CHECK_INT(from(server, "198.51.100.1", "GET", "", lab, NULL, &reply), 200);
    CHECK(strstr(reply.body, room[21].code) && strstr(reply.body, room[22].code) &&
          !strstr(reply.body, room[0].code) && !strstr(reply.body, "address_mark") &&
          !strstr(reply.body, "empty_ends"));
    test_reply_clear(&reply);
    CHECK_INT(from(server, "198.51.100.1", "GET", "", root, NULL, &reply), 200);
    CHECK(strstr(reply.body, room[0].code) && strstr(reply.body, room[21].code) &&
          strstr(reply.body, "\"role\":\"operator\"") && strstr(reply.body, "address_mark") &&
          strstr(reply.body, "empty_ends"));
    test_reply_clear(&reply);
    CHECK_INT(does(server, "198.51.100.1", "GET", "", "", NULL), 401);
    CHECK_INT(does(server, "198.51.100.1", "GET", "?after=1", root, NULL), 422);
    /* an operator ends any room, and a teacher none of another */
    snprintf(rest, sizeof rest, "/%s", room[0].code);
    CHECK_INT(does(server, "198.51.100.1", "DELETE", rest, lab, NULL), 404);
    CHECK_INT(does(server, "198.51.100.1", "DELETE", rest, root, NULL), 204);
    CHECK_INT(join(server, "198.51.100.9", room[0].code, "Ada"), 404);
    /* an erased client has no rooms */
    CHECK_INT(test_request(server, &reply, "DELETE", "/v1/clients/key:lab", root, NULL), 204);
    test_reply_clear(&reply);
    CHECK_INT(join(server, "198.51.100.9", room[21].code, "Ada"), 404);
    CHECK_INT(join(server, "198.51.100.9", room[1].code, "Ada"), 201);
    const char *const none[] = {"keys",      "role",    "--keys",  file, "--role",
                                "anonymous", "--quota", "rooms=0", NULL};
    CHECK_INT(test_server_run(none, text, sizeof text), 0);
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.05))
        if (make(server, "198.51.100.4", "", &room[0]) == 401) break;
    CHECK_INT(make(server, "198.51.100.4", "", &room[0]), 401);
    CHECK_INT(make(server, "198.51.100.4", lab, &room[0]), 201);
    stop_after_deaths(&server);
    keys_end(file);
}

TEST(rooms_are_bounded_and_an_operator_lists_and_ends_them) { place_on_both(bounds); }

/* whether a stream ends by itself; `text` receives its contents */
static int ends(struct test_client *client, char text[], size_t cap) {
    size_t bytes = 0;
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end && bytes + 1 < cap;) {
        struct pollfd look = {client->fd, POLLIN, 0};
        if (poll(&look, 1, 50) <= 0) continue;
        ssize_t got = recv(client->fd, text + bytes, cap - 1 - bytes, 0);
        if (got <= 0) return 1;
        bytes += (size_t)got;
        text[bytes] = 0;
    }
    return 0;
}

/* waits until this many streams and waits are open; an operator's key reads the metrics */
static int streams(const struct test_server *server, const char *root, int count) {
    char line[64];
    int there = 0;
    snprintf(line, sizeof line, "\npendulumd_event_streams %d\n", count);
    for (double end = test_clock() + TEST_PATIENCE; !there && test_clock() < end;
         test_sleep(0.02)) {
        OWN(test_reply, clear) reply;
        CHECK_INT(test_request(server, &reply, "GET", "/metrics", root, NULL), 200);
        there = reply.body && strstr(reply.body, line) != NULL;
    }
    return CHECK_SAYING(there, "%s", line);
}

/* streams and waits of one key when it becomes invalid; those of another continue */
static void revoked(struct place *place, const char *action, const char *const when[2]) {
    struct room room, other;
    char file[128], root[KEY], lab[KEY], id[ID + 1], text[4096] = "", says[1024];
    struct test_client heard = {0}, waits = {0}, goes_on = {0};
    if (!keys_begin(file)) return;
    key(file, "root", "operator", NULL, root);
    key(file, "lab", "teacher", NULL, lab);
    struct test_server *server = serve(place, "--keys", file);
    if (!server) return;
    CHECK_INT(make(server, "198.51.100.1", lab, &room), 201);
    CHECK_INT(make(server, "198.51.100.1", root, &other), 201);
    snprintf(says, sizeof says, "%s%s", ASYNC, lab);
    CHECK_INT(submit(server, "/v1/trajectories", says, ask_long(1), id), 202);
    int port = test_server_port(server);
    REQUIRE(test_client_open(&heard, port) && test_client_open(&waits, port) &&
            test_client_open(&goes_on, port));
    snprintf(says, sizeof says, "GET /v1/classes/%s/events HTTP/1.1\r\nHost: x\r\n%s\r\n",
             room.code, lab);
    CHECK(test_client_say(&heard, says));
    snprintf(says, sizeof says, "GET /v1/jobs/%s?wait=60 HTTP/1.1\r\nHost: x\r\n%s\r\n", id, lab);
    CHECK(test_client_say(&waits, says));
    snprintf(says, sizeof says, "GET /v1/classes/%s/events HTTP/1.1\r\nHost: x\r\n%s\r\n",
             other.code, root);
    CHECK(test_client_say(&goes_on, says));
    CHECK(streams(server, root, 3));
    const char *const words[] = {"keys", action,  "--keys", file, "--name",
                                 "lab",  when[0], when[1],  NULL};
    CHECK_INT(test_server_run(words, text, sizeof text), 0);
    text[0] = 0;
    CHECK(ends(&heard, text, sizeof text));
    CHECK(streams(server, root, 1));
    /* no later change was sent */
    CHECK_INT(join(server, "198.51.100.1", room.code, "Secret"), 201);
    CHECK(strstr(text, "200 OK") && !strstr(text, "Secret"));
    text[0] = 0;
    CHECK(ends(&waits, text, sizeof text));
    CHECK_SAYING(!strstr(text, "\"status\""), "%s", text);
    struct pollfd look = {goes_on.fd, POLLRDHUP, 0};
    CHECK_INT(poll(&look, 1, 0), 0);
    test_client_close(&heard);
    test_client_close(&waits);
    test_client_close(&goes_on);
    stop_after_deaths(&server);
    keys_end(file);
}

static void revoked_key(struct place *place) {
    revoked(place, "revoke", (const char *const[]){NULL, NULL});
}

static void expired_key(struct place *place) {
    revoked(place, "expire", (const char *const[]){"--expires", "1s"});
}

TEST(streams_end_when_their_key_is_revoked) { place_on_both(revoked_key); }

TEST(streams_end_when_their_key_expires) { place_on_both(expired_key); }

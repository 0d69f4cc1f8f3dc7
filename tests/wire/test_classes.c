/* A class at work, on both stores: a lesson with a teacher's mistakes, several processes, restarts,
 * and malicious pupils. */
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "tests/wire/place.h"

#define SCENE(angle)                                                                               \
    "{\"request\":{\"pendulum\":" ASK_DOUBLE ",\"initial\":{\"theta\":[" angle                     \
    ",0]},\"times\":{\"start\":0,\"stop\":1,\"count\":11}}}"

enum { CODE = 6, TOKEN = 40, HEARD = 1 << 18 };

/* A member of a room. */
struct member {
    char path[32]; /* /v1/classes/CODE */
    char token[TOKEN];
    int pupil;
};

static struct test_server *serve(const struct place *place) {
    const char *const options[] = {"--store", place->url, NULL};
    return test_server_start(options);
}

/* a member's request for the rest of the room's path */
static int as(const struct test_server *server, const struct member *who, const char *method,
              const char *rest, const char *body, struct test_reply *reply) {
    char path[160], header[TOKEN + 40] = "";
    snprintf(path, sizeof path, "%s%s", who->path, rest);
    if (*who->token) snprintf(header, sizeof header, "Authorization: Bearer %s\r\n", who->token);
    return test_request(server, reply, method, path, header, body);
}

/* the same, of which only the status is used */
static int does(const struct test_server *server, const struct member *who, const char *method,
                const char *rest, const char *body) {
    OWN(test_reply, clear) reply;
    int status = as(server, who, method, rest, body, &reply);
    if (status >= 400) ask_problem(&reply, status, NULL);
    return status;
}

static void member_read(const struct test_reply *reply, struct member *who) {
    cJSON *json = ask_json(reply);
    const char *code = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "code")),
               *token = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "token"));
    const cJSON *pupil = cJSON_GetObjectItemCaseSensitive(json, "pupil");
    if (CHECK(code && strlen(code) == CODE))
        snprintf(who->path, sizeof who->path, "/v1/classes/%s", code);
    if (token) snprintf(who->token, sizeof who->token, "%s", token);
    who->pupil = pupil ? pupil->valueint : 0;
    cJSON_Delete(json);
}

static int open_room(const struct test_server *server, struct member *teacher) {
    OWN(test_reply, clear) reply;
    *teacher = (struct member){.path = "/v1/classes"};
    int status = as(server, teacher, "POST", "", "{\"hours\":1}", &reply);
    if (CHECK_INT(status, 201)) member_read(&reply, teacher);
    return status == 201;
}

static int join(const struct test_server *server, const struct member *teacher,
                const char *nickname, struct member *who) {
    OWN(test_reply, clear) reply;
    char body[160];
    *who = (struct member){.pupil = 0};
    memcpy(who->path, teacher->path, sizeof who->path);
    snprintf(body, sizeof body, "{\"nickname\":\"%s\"}", nickname);
    int status = as(server, who, "POST", "/pupils", body, &reply);
    if (status == 201) member_read(&reply, who);
    return status;
}

/* how often a text occurs in what a member reads */
static int reads(const struct test_server *server, const struct member *who, const char *rest,
                 const char *text) {
    OWN(test_reply, clear) reply;
    int count = 0;
    CHECK_INT(as(server, who, "GET", rest, NULL, &reply), 200);
    for (const char *at = reply.body; (at = strstr(at, text)); at++) count++;
    return count;
}

/* --- events --- */

/* A member that listens. */
struct ear {
    struct test_client client;
    size_t bytes;
    char text[HEARD];
};

static int ear_open(struct ear *ear, const struct test_server *server, const struct member *who,
                    const char *last) {
    char text[512];
    memset(ear, 0, sizeof *ear);
    if (!test_client_open(&ear->client, test_server_port(server))) return 0;
    snprintf(text, sizeof text,
             "GET %s/events HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer %s\r\n%s%s%s\r\n",
             who->path, who->token, last ? "Last-Event-ID: " : "", last ? last : "",
             last ? "\r\n" : "");
    return test_client_say(&ear->client, text);
}

/* reads until a text has arrived */
static int ear_hear(struct ear *ear, const char *text) {
    double end = test_clock() + TEST_PATIENCE;
    while (test_clock() < end && ear->bytes < HEARD - 1) {
        struct pollfd look = {ear->client.fd, POLLIN, 0};
        if (strstr(ear->text, text)) return 1;
        if (poll(&look, 1, 50) <= 0) continue;
        ssize_t got = recv(ear->client.fd, ear->text + ear->bytes, HEARD - 1 - ear->bytes, 0);
        if (got <= 0) break;
        ear->bytes += (size_t)got;
    }
    return strstr(ear->text, text) != NULL;
}

static struct ear ear[3];

/* --- a lesson --- */

/* questions and answers, with the mistakes of a teacher */
static void lesson_asks(const struct test_server *server, const struct member *teacher,
                        const struct member pupil[3]) {
    CHECK_INT(does(server, teacher, "PUT", "/questions/swing",
                   "{\"text\":\"How long is a swing?\",\"kind\":\"number\",\"unit\":\"s\"}"),
              200);
    CHECK_INT(does(server, teacher, "PUT", "/solutions/swing", "{\"value\":2.006}"), 200);
    CHECK_INT(does(server, &pupil[0], "PUT", "/answers/swing", "{\"value\":2}"), 200);
    CHECK_INT(does(server, &pupil[1], "PUT", "/answers/swing", "{\"value\":3}"), 200);
    CHECK_INT(does(server, &pupil[1], "PUT", "/answers/swing", "{\"value\":2}"), 200);
    CHECK_INT(does(server, &pupil[2], "PUT", "/answers/swing", "{\"value\":\"two\"}"), 422);
    CHECK_INT(does(server, &pupil[2], "PUT", "/answers/tide", "{\"value\":1}"), 409);
    CHECK_INT(reads(server, teacher, "/histograms/swing", "{\"value\":2,\"count\":2}"), 1);
    CHECK_INT(does(server, &pupil[0], "GET", "/histograms/swing", NULL), 403);
    CHECK_INT(does(server, &pupil[0], "GET", "/table", NULL), 403);
    CHECK_INT(reads(server, &pupil[0], "", "2.006"), 0);
    /* the wrong question is removed, and returns with its answers */
    CHECK_INT(does(server, teacher, "DELETE", "/questions/swing", NULL), 204);
    CHECK_INT(does(server, &pupil[2], "PUT", "/answers/swing", "{\"value\":1}"), 409);
    CHECK_INT(does(server, teacher, "PUT", "/questions/swing",
                   "{\"text\":\"How long is a swing?\",\"kind\":\"number\",\"closed\":true}"),
              200);
    CHECK_INT(does(server, &pupil[2], "PUT", "/answers/swing", "{\"value\":1}"), 409);
    CHECK_INT(does(server, teacher, "PUT", "/solutions/swing", "{\"value\":2.006,\"shown\":true}"),
              200);
    CHECK_INT(reads(server, &pupil[0], "", "2.006"), 1);
    CHECK_INT(reads(server, teacher, "/table", "\r\nanswers,swing,,"), 2);
    CHECK_INT(reads(server, teacher, "/table", "questions,swing,,,,\"How long is a swing?\""), 1);
}

static void lesson_hands_in(const struct test_server *server, const struct member *teacher,
                            const struct member pupil[3]) {
    CHECK_INT(does(server, &pupil[0], "PUT", "/handins/sheet", "{\"answers\":[]}"), 409);
    CHECK_INT(does(server, teacher, "PUT", "/worksheets/sheet", "{\"title\":\"S\",\"steps\":[]}"),
              422);
    CHECK_INT(does(server, teacher, "PUT", "/worksheets/sheet",
                   "{\"title\":\"S\",\"steps\":[{\"id\":\"a\",\"text\":\"Look.\"},{\"id\":\"b\","
                   "\"question\":{\"kind\":\"text\"},\"needs\":\"answer\"}]}"),
              200);
    for (int i = 0; i < 2; i++)
        CHECK_INT(does(server, &pupil[0], "PUT", "/handins/sheet",
                       "{\"answers\":[{\"step\":\"b\",\"value\":\"=1\",\"scene\":" SCENE(
                           "1") "}],\"done\":true}"),
                  200);
    CHECK_INT(reads(server, teacher, "/table", "handins,sheet,b,1,\"Ada\",\"'=1\","), 1);
}

static void a_lesson(struct place *place) {
    struct member teacher, pupil[3];
    OWN(test_server, stop) *server = serve(place);
    if (!server || !open_room(server, &teacher)) return;
    static const char *const names[] = {"Ada", "<script>alert(1)</script>", "Z\xc3\xb6\xc3\xab"};
    for (int i = 0; i < 3; i++) {
        CHECK_INT(join(server, &teacher, names[i], &pupil[i]), 201);
        CHECK_INT(pupil[i].pupil, i + 1);
    }
    /* the teacher's two tabs, and a pupil, receive the changes */
    CHECK(ear_open(&ear[0], server, &teacher, NULL) && ear_open(&ear[1], server, &teacher, "3") &&
          ear_open(&ear[2], server, &pupil[0], NULL));
    CHECK_INT(does(server, &teacher, "PUT", "/stages/class",
                   "{\"scene\":" SCENE("1") ",\"frozen\":true,\"release\":{\"number\":1}}"),
              200);
    CHECK_INT(does(server, &pupil[1], "PUT", "/stages/own",
                   "{\"scene\":" SCENE("2") ",\"state\":\"stuck\"}"),
              200);
    for (int i = 0; i < 3; i++)
        CHECK(ear_hear(&ear[i], "\"name\":\"stages/class\",\"version\":4,"));
    for (int i = 0; i < 2; i++) CHECK(ear_hear(&ear[i], "\"name\":\"stages/2\",\"version\":5,"));
    CHECK(strstr(ear[0].text, "pupils/1") && !strstr(ear[1].text, "pupils/1"));
    lesson_asks(server, &teacher, pupil);
    lesson_hands_in(server, &teacher, pupil);
    CHECK_INT(does(server, &teacher, "PUT", "/stages/class", "{\"open\":false}"), 200);
    CHECK_INT(join(server, &teacher, "late", &(struct member){.pupil = 0}), 403);
    CHECK_INT(does(server, &teacher, "DELETE", "/stages/class", NULL), 204);
    CHECK_INT(does(server, &pupil[0], "DELETE", "/stages/class", NULL), 403);
    /* one pupil is removed, one leaves, the room is erased: what each receives */
    CHECK_INT(does(server, &teacher, "DELETE", "/pupils/2", NULL), 204);
    CHECK_INT(does(server, &pupil[1], "GET", "", NULL), 404);
    CHECK_INT(reads(server, &teacher, "/table", "script"), 0);
    CHECK(ear_hear(&ear[0], "\"name\":\"pupils/2\""));
    CHECK_INT(does(server, &pupil[0], "DELETE", "", NULL), 403);
    CHECK_INT(does(server, &teacher, "DELETE", "", NULL), 204);
    for (int i = 0; i < 3; i++) {
        CHECK(ear_hear(&ear[i], "event: end\ndata: {}\n\n"));
        test_client_close(&ear[i].client);
    }
    CHECK(!strstr(ear[2].text, "stages/2") && !strstr(ear[2].text, "pupils/2"));
    CHECK_INT(does(server, &teacher, "GET", "", NULL), 404);
}

TEST(a_lesson_goes_through_with_the_mistakes_of_a_teacher) { place_on_both(a_lesson); }

/* --- what dies meanwhile, and what comes twice --- */

static void two_processes(struct place *place) {
    struct member teacher, pupil;
    struct test_reply reply;
    char last[32], wanted[64];
    struct test_server *server = serve(place), *other = serve(place);
    if (!server || !other || !open_room(server, &teacher)) goto out;
    CHECK_INT(join(other, &teacher, "Ada", &pupil), 201);
    CHECK(ear_open(&ear[0], server, &teacher, NULL));
    CHECK(ear_hear(&ear[0], "pupils/1"));
    CHECK_INT(does(other, &pupil, "PUT", "/stages/own", "{\"state\":\"done\"}"), 200);
    CHECK(ear_hear(&ear[0], "\"name\":\"stages/1\",\"version\":2,"));
    test_client_close(&ear[0].client);
    /* killed at once; a client that reconnects to the other process has missed nothing */
    for (int life = 0; life < 3; life++) {
        const char *state = life % 2 ? "{\"state\":\"done\"}" : "{\"state\":\"stuck\"}";
        CHECK_INT(does(server, &pupil, "PUT", "/stages/own", state), 200);
        test_server_signal(server, SIGKILL);
        test_server_wait(server);
        test_server_drop(&server);
        if (!(server = serve(place))) break;
        snprintf(last, sizeof last, "%d", 2 + life);
        snprintf(wanted, sizeof wanted, "\"name\":\"stages/1\",\"version\":%d,", 3 + life);
        CHECK(ear_open(&ear[0], life ? server : other, &teacher, last));
        CHECK(ear_hear(&ear[0], wanted));
        CHECK(!strstr(ear[0].text, "pupils/1"));
        test_client_close(&ear[0].client);
    }
    CHECK_INT(as(other, &teacher, "GET", "?since=4", NULL, &reply), 200);
    CHECK(strstr(reply.body, "\"version\":5,") && !strstr(reply.body, "pupils/1"));
    test_reply_clear(&reply);
out:
    stop_after_deaths(&server);
    stop_after_deaths(&other);
}

TEST(a_class_loses_nothing_when_a_process_dies) { place_on_both(two_processes); }

static void twice(struct place *place) {
    struct member teacher = {.path = "/v1/classes", .token = "0123456789abcdef0123456789abcdef"},
                  again = teacher, pupil = {.token = "fedcba9876543210fedcba9876543210"};
    OWN(test_server, stop) *server = serve(place);
    if (!server) return;
    for (int i = 0; i < 2; i++) {
        OWN(test_reply, clear) reply;
        struct member *who = i ? &again : &teacher;
        CHECK_INT(test_request(server, &reply, "POST", "/v1/classes",
                               "Authorization: Bearer 0123456789abcdef0123456789abcdef\r\n"
                               "Idempotency-Key: lesson\r\n",
                               "{}"),
                  201);
        member_read(&reply, who);
    }
    CHECK_TEXT(again.path, teacher.path);
    memcpy(pupil.path, teacher.path, sizeof pupil.path);
    for (int i = 0; i < 2; i++) {
        OWN(test_reply, clear) reply;
        CHECK_INT(as(server, &pupil, "POST", "/pupils", "{\"nickname\":\"Ada\"}", &reply), 201);
        CHECK(strstr(reply.body, "\"pupil\":1,") && !strstr(reply.body, "token\""));
        test_reply_clear(&reply);
        CHECK_INT(as(server, &pupil, "PUT", "/stages/own", "{\"state\":\"done\"}", &reply), 200);
        CHECK_TEXT(reply.body, "{\"version\":2}");
    }
    CHECK_INT(does(server, &teacher, "POST", "/pupils", "{\"nickname\":\"T\"}"), 403);
    /* if Authorization is used for something else, a room's token has a field of its own */
    OWN(test_reply, clear) reply = {0};
    char path[80];
    snprintf(path, sizeof path, "%s/pupils", teacher.path);
    static const char both[] = "Authorization: Bearer 0123456789abcdef0123456789abcdef\r\n"
                               "Class-Token: 00112233445566778899aabbccddeeff\r\n";
    for (int i = 0; i < 2; i++) {
        CHECK_INT(test_request(server, &reply, "POST", path, both, "{\"nickname\":\"Bob\"}"), 201);
        CHECK(strstr(reply.body, "\"pupil\":2,") != NULL);
        test_reply_clear(&reply);
    }
    CHECK_INT(test_request(server, &reply, "GET", teacher.path, "Class-Token: x\r\n", NULL), 401);
    ask_problem(&reply, 401, NULL);
}

TEST(what_a_class_sends_twice_is_done_once) { place_on_both(twice); }

/* --- pupils who mean no good --- */

/* codes are guessed until the address is told to wait; members of the room are not */
static void guesses(struct test_server *server, const struct member *pupil) {
    struct member guess = {.pupil = 0};
    struct test_reply reply;
    int missed = 0, status = 404;
    for (; missed < 100 && status == 404; missed++) {
        snprintf(guess.path, sizeof guess.path, "/v1/classes/ZZ%c%cZ", 'A' + missed / 8,
                 '2' + missed % 8);
        status = as(server, &guess, "POST", "/pupils", "{\"nickname\":\"Eve\"}", &reply);
        if (status == 429) CHECK(test_reply_header(&reply, "Retry-After") != NULL);
        test_reply_clear(&reply);
    }
    CHECK_INT(status, 429);
    CHECK_SAYING(missed >= 28 && missed < 60, "%d guesses", missed);
    CHECK_INT(does(server, pupil, "PUT", "/stages/own", "{\"state\":\"done\"}"), 200);
}

TEST(a_pupil_who_means_no_good_is_bounded) {
    struct member teacher, pupil, eve = {.pupil = 0};
    static char large[1 << 20];
    struct place place;
    if (!place_begin(&place, 0)) return;
    const char *const options[] = {"--store", place.url, "--max-class-pupils", "5", NULL};
    struct test_server *server = test_server_start(options);
    if (!server || !open_room(server, &teacher)) goto out;
    CHECK_INT(join(server, &teacher, "Ada", &pupil), 201);
    memcpy(eve.path, teacher.path, sizeof eve.path);
    CHECK_INT(does(server, &eve, "GET", "", NULL), 401);
    strcpy(eve.token, "0123456789abcdef0123456789abcdef");
    static const char *const closed[] = {"", "/events", "/table", "/histograms/q", "?since=1"};
    for (size_t i = 0; i < sizeof closed / sizeof *closed; i++)
        CHECK_INT(does(server, &eve, "GET", closed[i], NULL), 404);
    CHECK_INT(does(server, &eve, "DELETE", "", NULL), 404);
    CHECK_INT(does(server, &eve, "PUT", "/stages/own", "{}"), 404);
    CHECK_INT(does(server, &pupil, "PUT", "/pupils/1", "{}"), 404);
    CHECK_INT(does(server, &pupil, "PUT", "/stages/2", "{}"), 404);
    CHECK_INT(does(server, &pupil, "PUT", "/answers/a%2Fb", "{\"value\":1}"), 404);
    CHECK_INT(does(server, &pupil, "GET", "?since=x", NULL), 422);
    CHECK_INT(does(server, &pupil, "PUT", "/stages/own", "{\"html\":1}"), 422);
    memset(large, ' ', sizeof large - 1);
    memcpy(large, "{\"value\":1}", 11);
    CHECK_INT(does(server, &pupil, "PUT", "/answers/q", large), 413);
    /* the number of pupils is limited, and the teacher frees a slot */
    CHECK_INT(join(server, &teacher, "a\\nb", &eve), 422);
    for (int i = 0; i < 4; i++) CHECK_INT(join(server, &teacher, "Eve", &eve), 201);
    CHECK_INT(join(server, &teacher, "Eve", &(struct member){.pupil = 0}), 429);
    CHECK_INT(does(server, &teacher, "DELETE", "/pupils/5", NULL), 204);
    CHECK_INT(join(server, &teacher, "Bob", &eve), 201);
    /* a client that writes without a pause is told to wait, and nobody else is */
    int status = 200, writes = 0;
    for (; writes < 200 && status == 200; writes++)
        status = does(server, &eve, "PUT", "/stages/own",
                      writes % 2 ? "{\"state\":\"done\"}" : "{\"state\":\"stuck\"}");
    CHECK_INT(status, 429);
    CHECK(writes > 40);
    guesses(server, &pupil);
out:
    test_server_stop(&server);
    place_end(&place);
}

/* a complete stream, for comparing replies with the API's description */
TEST(a_stream_of_a_room_is_whole_when_the_room_is_gone) {
    struct member teacher;
    struct test_reply reply;
    OWN(place, end) place;
    char path[80];
    if (!place_begin(&place, 0)) return;
    OWN(test_server, stop) *server = serve(&place);
    if (server && open_room(server, &teacher)) {
        CHECK_INT(does(server, &teacher, "PUT", "/stages/class", "{\"frozen\":true}"), 200);
        CHECK(ear_open(&ear[0], server, &teacher, NULL));
        CHECK(ask_await(server, "pendulumd_event_streams", 1, 1));
        CHECK_INT(does(server, &teacher, "DELETE", "", NULL), 204);
        CHECK_INT(test_client_receive(&ear[0].client, &reply, 0, TEST_PATIENCE), 200);
        snprintf(path, sizeof path, "%s/events", teacher.path);
        test_reply_record(&reply, "GET", path);
        CHECK(strstr(reply.body, "event: end\ndata: {}\n\n") != NULL);
        test_reply_clear(&reply);
        test_client_close(&ear[0].client);
        CHECK_INT(ask(server, &reply, "/v1/classes", "{\"hours\":0}"), 422);
        ask_problem(&reply, 422, "/hours");
        test_reply_clear(&reply);
    }
}

TEST(a_server_that_keeps_nothing_has_no_rooms) {
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    CHECK_INT(ask(server, &reply, "/v1/classes", "{}"), 404);
    ask_problem(&reply, 404, NULL);
}

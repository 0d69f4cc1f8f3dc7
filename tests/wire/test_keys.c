/* Keys and roles through a daemon's socket: `pendulumd keys` creates them, each invalid key has its
 * status and sentence, each role its limits. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/wire/place.h"

enum { KEY = 64, FIELD = 128 };

/* A store, a file of keys beside it, and a daemon. */
struct keyed {
    struct place place;
    char file[128];
    struct test_server *server;
};

/* runs `pendulumd keys ACTION --keys FILE` with up to six further words; `text` receives its
 * output */
static int command(const struct keyed *keyed, const char *action, const char *const words[],
                   char text[], size_t cap) {
    const char *all[12] = {"keys", action, "--keys", keyed->file};
    for (int i = 0; words[i]; i++) all[4 + i] = words[i];
    return test_server_run(all, text, cap);
}

#define COMMAND(keyed, action, text, ...)                                                          \
    command(keyed, action, (const char *const[]){__VA_ARGS__, NULL}, text, sizeof text)

/* creates a key and its header field */
static int make(const struct keyed *keyed, const char *name, const char *role, const char *quota,
                char field[FIELD]) {
    char text[1024];
    int status = COMMAND(keyed, "add", text, "--name", name, "--role", role,
                         quota ? "--quota" : NULL, quota);
    text[strcspn(text, "\n")] = 0;
    snprintf(field, FIELD, "Authorization: Bearer %.63s\r\n", text);
    return CHECK_INT(status, 0) && CHECK_INT(strlen(text), 42);
}

static int keyed_begin(struct keyed *keyed) {
    char text[4096], first[FIELD];
    if (!place_begin(&keyed->place, 0)) return 0;
    snprintf(keyed->file, sizeof keyed->file, "%s/keys", keyed->place.directory);
    if (!make(keyed, "root", "operator", NULL, first)) return 0;
    CHECK_INT(COMMAND(keyed, "list", text, NULL), 0);
    CHECK_SAYING(strstr(text, "root operator good") != NULL, "%s", text);
    const char *const options[] = {"--store",
                                   keyed->place.url,
                                   "--keys",
                                   keyed->file,
                                   "--trusted-proxy",
                                   "127.0.0.1",
                                   "--role-header",
                                   "X-Roles",
                                   "--client-header",
                                   "X-Account",
                                   "--job-part-seconds",
                                   "1",
                                   NULL};
    keyed->server = test_server_start(options);
    return CHECK(keyed->server != NULL);
}

static void keyed_end(struct keyed *keyed) {
    stop_after_deaths(&keyed->server);
    unlink(keyed->file);
    place_end(&keyed->place);
}

/* waits until the server's log contains a word */
static int says(struct keyed *keyed, const char *word) {
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.02))
        if (strstr(test_server_log(keyed->server), word)) return 1;
    return CHECK_SAYING(0, "it does not say %s but: %s", word, test_server_log(keyed->server));
}

/* sends a request with a key; checks status, sentence and WWW-Authenticate of the answer */
static void refused(struct keyed *keyed, const char *path, const char *field, int status,
                    const char *sentence, const char *asks) {
    OWN(test_reply, clear) reply;
    int get = !strcmp(path, "/metrics") || !strcmp(path, "/v1/jobs");
    CHECK_INT(test_request(keyed->server, &reply, get ? "GET" : "POST", path, field,
                           get ? NULL : ASK_LITTLE),
              status);
    ask_problem(&reply, status, NULL);
    CHECK_SAYING(strstr(reply.body, sentence) != NULL, "%s: %s", sentence, reply.body);
    const char *told = test_reply_header(&reply, "WWW-Authenticate");
    CHECK_SAYING(told && strstr(told, asks) && !strncmp(told, "Bearer realm=", 13), "%s: %s", asks,
                 told ? told : "nothing");
}

static int status_of(const struct keyed *keyed, const char *path, const char *field,
                     const char *body) {
    OWN(test_reply, clear) reply;
    return test_request(keyed->server, &reply, body ? "POST" : "GET", path, field, body);
}

TEST(each_bad_key_has_its_status_and_its_sentence) {
    OWN(keyed, end) keyed;
    char good[FIELD], field[FIELD], text[1024];
    REQUIRE(keyed_begin(&keyed));
    REQUIRE(make(&keyed, "lab", "batch", "requests=50", good));
    /* it is active without a signal */
    REQUIRE(says(&keyed, "keys: 2 keys are valid"));
    CHECK_INT(status_of(&keyed, "/v1/trees", good, ASK_LITTLE), 200);
    /* truncated by a letter, and with another letter */
    snprintf(field, sizeof field, "%.*s\r\n", (int)strlen(good) - 3, good);
    refused(&keyed, "/v1/trees", field, 401, "malformed", "invalid_token");
    snprintf(field, sizeof field, "%s", good);
    field[40] = field[40] == 'q' ? 'r' : 'q';
    refused(&keyed, "/v1/trees", field, 401, "malformed", "invalid_token");
    /* expired, then valid again, then revoked, then removed */
    CHECK_INT(COMMAND(&keyed, "expire", text, "--name", "lab", "--expires", "2020-02-29"), 0);
    test_server_signal(keyed.server, SIGHUP);
    REQUIRE(says(&keyed, "reload: 0 options"));
    refused(&keyed, "/v1/trees", good, 401, "the key lab has expired, at 2020-02-29T00:00:00Z",
            "error_description=\"the key has expired\"");
    refused(&keyed, "/metrics", good, 401, "expired", "invalid_token");
    CHECK_INT(COMMAND(&keyed, "expire", text, "--name=lab", "--expires=never"), 0);
    for (int i = 0; i < 400 && status_of(&keyed, "/v1/trees", good, ASK_LITTLE) != 200; i++)
        test_sleep(0.05);
    CHECK_INT(status_of(&keyed, "/v1/trees", good, ASK_LITTLE), 200);
    CHECK_INT(COMMAND(&keyed, "revoke", text, "--name", "lab"), 0);
    for (int i = 0; i < 400 && status_of(&keyed, "/v1/trees", good, ASK_LITTLE) == 200; i++)
        test_sleep(0.05);
    refused(&keyed, "/v1/trees", good, 401, "the key lab was revoked", "the key was revoked");
    CHECK_INT(COMMAND(&keyed, "remove", text, "--name", "lab"), 0);
    REQUIRE(says(&keyed, "keys: 1 key is valid"));
    refused(&keyed, "/v1/trees", good, 401, "this key is unknown to this server", "invalid_token");
    /* a secret of the client's own is still valid, and anonymous */
    CHECK_INT(status_of(&keyed, "/v1/trees", "Authorization: Bearer abcdefghijklmnopqrstuv\r\n",
                        ASK_LITTLE),
              200);
}

TEST(each_role_may_what_it_may) {
    OWN(keyed, end) keyed;
    char pupil[FIELD], batch[FIELD], operator[FIELD], text[1024], id[ID + 1], headers[2 * FIELD];
    REQUIRE(keyed_begin(&keyed));
    REQUIRE(make(&keyed, "7b", "pupil", NULL, pupil));
    REQUIRE(make(&keyed, "night", "batch", "jobs=1,bytes=8M", batch));
    REQUIRE(make(&keyed, "ops", "operator", NULL, operator));
    REQUIRE(says(&keyed, "keys: 4 keys are valid"));
    /* metrics are for operators */
    refused(&keyed, "/metrics", "", 401, "needs a key of the role operator", "Bearer realm");
    refused(&keyed, "/metrics", pupil, 403, "your role is pupil", "insufficient_scope");
    refused(&keyed, "/metrics", batch, 403, "your role is batch", "scope=\"operator\"");
    CHECK_INT(status_of(&keyed, "/metrics", operator, NULL), 200);
    /* jobs are for teachers and other clients with a key */
    snprintf(headers, sizeof headers, ASYNC "%s", pupil);
    refused(&keyed, "/v1/lyapunov", headers, 403, "may not post jobs", "scope=\"teacher\"");
    refused(&keyed, "/v1/lyapunov", ASYNC, 401, "may not post jobs", "Bearer realm");
    refused(&keyed, "/v1/lyapunov", ASYNC "Authorization: Bearer abcdefghijklmnopqrstuv\r\n", 401,
            "may not post jobs", "Bearer realm");
    static const char longer[] =
        "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":20000,\"count\":5}}";
    snprintf(headers, sizeof headers, ASYNC "%s", batch);
    char first[ID + 1];
    CHECK_INT(submit(keyed.server, "/v1/trajectories", headers, longer, first), 202);
    struct test_reply reply;
    CHECK_INT(job_get(keyed.server, &reply, first, "", ""), 200);
    CHECK_SAYING(strstr(reply.body, "\"owner\":\"key\"") != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    CHECK_INT(submit(keyed.server, "/v1/trajectories", headers, longer, id), 429);
    /* a list and a deletion by another key of the same name, and by no key */
    REQUIRE(make(&keyed, "night", "batch", NULL, headers));
    REQUIRE(says(&keyed, "keys: 5 keys are valid"));
    snprintf(text, sizeof text, "/v1/jobs/%s", first);
    CHECK_INT(test_request(keyed.server, &reply, "DELETE", text, pupil, NULL), 403);
    test_reply_clear(&reply);
    CHECK_INT(test_request(keyed.server, &reply, "DELETE", text, "", NULL), 401);
    test_reply_clear(&reply);
    CHECK_INT(test_request(keyed.server, &reply, "GET", "/v1/jobs", headers, NULL), 200);
    CHECK_SAYING(strstr(reply.body, first) != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    CHECK_INT(test_request(keyed.server, &reply, "DELETE", text, headers, NULL), 200);
    test_reply_clear(&reply);
    /* the limits of a role change while the server runs; 0 requests are none */
    CHECK_INT(COMMAND(&keyed, "role", text, "--role", "anonymous", "--quota", "requests=0"), 0);
    for (int i = 0; i < 400 && status_of(&keyed, "/v1/trees", "", ASK_LITTLE) == 200; i++)
        test_sleep(0.05);
    refused(&keyed, "/v1/trees", "", 401, "may not send requests", "Bearer realm");
    CHECK_INT(status_of(&keyed, "/healthz", "", NULL), 200);
    CHECK_INT(status_of(&keyed, "/v1/trees", pupil, ASK_LITTLE), 200);
}

TEST(a_proxys_word_gives_an_account_its_role) {
    OWN(keyed, end) keyed;
    REQUIRE(keyed_begin(&keyed));
    CHECK_INT(
        status_of(&keyed, "/metrics", "X-Account: anna\r\nX-Roles: staff, operator\r\n", NULL),
        200);
    refused(&keyed, "/metrics", "X-Account: anna\r\nX-Roles: teacher,operator\r\n", 403,
            "your role is teacher", "insufficient_scope");
    refused(&keyed, "/metrics", "X-Account: anna\r\n", 403, "your role is pupil", "scope");
    refused(&keyed, "/metrics", "X-Roles: operator\r\n", 401, "operator", "Bearer realm");
}

TEST(limits_of_a_role_are_kept_to) {
    OWN(keyed, end) keyed;
    OWN(test_reply, clear) reply = {0};
    char slow[FIELD], small[FIELD], tired[FIELD];
    REQUIRE(keyed_begin(&keyed));
    REQUIRE(make(&keyed, "slow", "pupil", "requests=0.05", slow));
    REQUIRE(make(&keyed, "small", "pupil", "memory=1M", small));
    REQUIRE(make(&keyed, "tired", "pupil", "compute=0.001", tired));
    REQUIRE(says(&keyed, "keys: 4 keys are valid"));
    /* three a minute */
    for (int i = 0; i < 4; i++) {
        CHECK_INT(test_request(keyed.server, &reply, "POST", "/v1/trees", slow, ASK_LITTLE),
                  i < 3 ? 200 : 429);
        const char *limit = test_reply_header(&reply, "RateLimit-Limit"),
                   *again = test_reply_header(&reply, "Retry-After");
        CHECK_TEXT(limit ? limit : "", "3");
        if (i == 3) {
            CHECK_SAYING(strstr(reply.body, "of the role pupil of 3 per minute") && again &&
                             atoi(again) >= 1 && atoi(again) <= 20,
                         "%s %s", reply.body, again ? again : "");
        }
        test_reply_clear(&reply);
    }
    /* an answer of more than a megabyte that does not stream */
    static const char large[] =
        "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":100,\"count\":100001}}";
    char headers[2 * FIELD];
    snprintf(headers, sizeof headers, "Accept: application/x-npz\r\n%s", small);
    CHECK_INT(test_request(keyed.server, &reply, "POST", "/v1/trajectories", headers, large), 422);
    CHECK_SAYING(strstr(reply.body, "1048576") != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    /* a client that has computed for longer than a millisecond waits */
    CHECK_INT(test_request(keyed.server, &reply, "POST", "/v1/trajectories", tired, ask_long(10)),
              200);
    test_reply_clear(&reply);
    int status = 200;
    for (int i = 0; i < 100 && status == 200; i++) {
        if (i) test_reply_clear(&reply);
        status = test_request(keyed.server, &reply, "POST", "/v1/trees", tired, ASK_LITTLE);
    }
    CHECK_INT(status, 429);
    CHECK_SAYING(strstr(reply.body, "0.001 seconds per minute") &&
                     test_reply_header(&reply, "Retry-After"),
                 "%s", reply.body);
}

TEST(the_command_says_what_is_wrong) {
    struct keyed keyed;
    char text[4096], field[FIELD];
    REQUIRE(place_begin(&keyed.place, 0));
    snprintf(keyed.file, sizeof keyed.file, "%s/keys", keyed.place.directory);
    CHECK_INT(COMMAND(&keyed, "list", text, NULL), 1);
    CHECK_SAYING(strstr(text, "No such file") != NULL, "%s", text);
    CHECK_INT(COMMAND(&keyed, "add", text, "--name", "lab", "--role", "king"), 1);
    CHECK_SAYING(strstr(text, "king") != NULL, "%s", text);
    CHECK_INT(COMMAND(&keyed, "add", text, "--name", "l b", "--role", "pupil"), 1);
    CHECK_INT(COMMAND(&keyed, "add", text, "--name", "lab", "--role", "pupil", "--quota", "jobs=x"),
              1);
    CHECK(access(keyed.file, F_OK) != 0);
    REQUIRE(make(&keyed, "lab", "pupil", NULL, field));
    CHECK_INT(COMMAND(&keyed, "revoke", text, "--name", "lob"), 1);
    CHECK_SAYING(strstr(text, "no key 'lob'") != NULL, "%s", text);
    CHECK_INT(COMMAND(&keyed, "revoke", text, "--nam", "lab"), 2);
    CHECK_INT(COMMAND(&keyed, "revoke", text, "--name"), 2);
    CHECK_INT(COMMAND(&keyed, "melt", text, NULL), 2);
    CHECK_INT(COMMAND(&keyed, "--help", text, NULL), 0);
    CHECK_SAYING(strstr(text, "keys add") && strstr(text, "WHEN"), "%s", text);
    /* a key is nowhere but where it was printed */
    char kept[2048] = "";
    FILE *file = fopen(keyed.file, "r");
    REQUIRE(file != NULL);
    size_t bytes = fread(kept, 1, sizeof kept - 1, file);
    fclose(file);
    field[strcspn(field, "\r")] = 0;
    CHECK(bytes > 64 && !strstr(kept, field + 22) && strstr(kept, "digest="));
    /* a server does not start with keys that others can read, or that are malformed */
    const char *const options[] = {"--keys",  keyed.file, "--listen", "127.0.0.1:0",
                                   "--store", "none",     NULL};
    CHECK(!chmod(keyed.file, 0644));
    CHECK_INT(test_server_run(options, text, sizeof text), 1);
    CHECK_SAYING(strstr(text, "0644") != NULL, "%s", text);
    unlink(keyed.file);
    CHECK_INT(test_server_run(options, text, sizeof text), 1);
    place_end(&keyed.place);
}

/* the contents of a file, truncated to fit */
static void file_text(const char *path, char text[], size_t cap) {
    FILE *file = fopen(path, "r");
    text[0] = 0;
    if (!CHECK_SAYING(file != NULL, "%s", path)) return;
    size_t bytes = fread(text, 1, cap - 1, file);
    text[bytes] = 0;
    fclose(file);
}

/* waits until a file contains a word, and reads it */
static int file_says(const char *path, const char *word, char text[], size_t cap) {
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.02)) {
        file_text(path, text, cap);
        if (strstr(text, word)) return 1;
    }
    return CHECK_SAYING(0, "it does not say %s but: %s", word, text);
}

TEST(deeds_are_accounted_for_without_bodies_and_addresses_as_far_as_wanted) {
    OWN(keyed, end) keyed;
    char audit[128], log[128], text[16384], teacher[FIELD], headers[2 * FIELD], id[ID + 1];
    struct test_reply reply;
    REQUIRE(place_begin(&keyed.place, 0));
    snprintf(keyed.file, sizeof keyed.file, "%s/keys", keyed.place.directory);
    snprintf(audit, sizeof audit, "%s/audit", keyed.place.directory);
    snprintf(log, sizeof log, "%s/log", keyed.place.directory);
    REQUIRE(make(&keyed, "anna", "teacher", NULL, teacher));
    const char *const options[] = {
        "--store", keyed.place.url, "--keys", keyed.file,     "--audit-log", audit, "--log",
        log,       "--access-log",  "on",     "--log-client", "none",        NULL};
    keyed.server = test_server_start(options);
    REQUIRE(keyed.server != NULL);
    CHECK_INT(status_of(&keyed, "/v1/trees", teacher, ASK_LITTLE), 200);
    snprintf(headers, sizeof headers, ASYNC "%s", teacher);
    CHECK_INT(submit(keyed.server, "/v1/lyapunov", headers,
                     "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1}", id),
              202);
    CHECK_INT(status_of(&keyed, "/metrics", "", NULL), 401);
    CHECK_INT(status_of(&keyed, "/metrics", teacher, NULL), 403);
    snprintf(text, sizeof text, "/v1/jobs/%s", id);
    CHECK_INT(test_request(keyed.server, &reply, "DELETE", text, "", NULL), 401);
    test_reply_clear(&reply);
    CHECK_INT(test_request(keyed.server, &reply, "DELETE", text, teacher, NULL), 200);
    test_reply_clear(&reply);
    REQUIRE(file_says(audit, "\"status\":200", text, sizeof text));
    test_server_signal(keyed.server, SIGHUP);
    REQUIRE(file_says(audit, "reload of options", text, sizeof text));
    CHECK_SAYING(strstr(text, "\"who\":\"key:anna\",\"role\":\"teacher\",\"what\":\"POST "
                              "/v1/lyapunov\",\"of\":\"/v1/jobs/") != NULL,
                 "%s", text);
    CHECK(strstr(text, "\"status\":202,\"outcome\":\"done\"") != NULL);
    CHECK(strstr(text, "\"who\":\"-\",\"role\":\"anonymous\",\"what\":\"GET "
                       "/metrics\",\"status\":401,\"outcome\":\"refused\"") != NULL);
    CHECK(strstr(text, "GET /metrics\",\"status\":403,\"outcome\":\"refused\"") != NULL);
    CHECK(strstr(text, "DELETE /v1/jobs/{id}") && strstr(text, id));
    /* mere computations need no audit entry */
    CHECK_SAYING(!strstr(text, "/v1/trees") && !strstr(text, "duration"), "%s", text);
    int lines = 0;
    for (const char *at = text; (at = strchr(at, '\n')); at++) lines++;
    CHECK_INT(lines, 6);
    /* no log has an address */
    CHECK(!strstr(text, "127.0.0.1"));
    REQUIRE(file_says(log, "DELETE", text, sizeof text));
    CHECK_SAYING(!strstr(text, "127.0.0.1") && strstr(text, "\"client\":\"-\"") &&
                     strstr(text, "key:anna"),
                 "%s", text);
    unlink(audit);
    unlink(log);
}

/* the port in the log after a word */
static int port_behind(struct test_server *server, const char *word) {
    const char *line = strstr(test_server_log(server), word);
    return CHECK(line != NULL) ? atoi(line + strlen(word)) : 0;
}

static int probe(int port, const char *request, struct test_reply *reply) {
    OWN(test_client, close) client;
    int status = 0;
    if (test_client_open(&client, port) && CHECK(test_client_say(&client, request)))
        status = test_client_receive(&client, reply, 0, TEST_PATIENCE);
    return status;
}

TEST(probes_and_metrics_have_an_address_of_their_own) {
    OWN(keyed, end) keyed;
    OWN(test_reply, clear) reply = {0};
    OWN(test_client, close) held = {.fd = -1};
    char first[FIELD];
    REQUIRE(place_begin(&keyed.place, 0));
    snprintf(keyed.file, sizeof keyed.file, "%s/keys", keyed.place.directory);
    REQUIRE(make(&keyed, "root", "operator", NULL, first));
    const char *const options[] = {"--keys",      keyed.file,          "--probe-listen",
                                   "127.0.0.1:0", "--max-connections", "1",
                                   "--hosts",     "example.org",       NULL};
    keyed.server = test_server_start(options);
    REQUIRE(keyed.server != NULL);
    int port = port_behind(keyed.server, "probes and metrics on http://127.0.0.1:");
    /* others may have only one connection; probes need none of them, no key and no host name */
    REQUIRE(test_client_open(&held, test_server_port(keyed.server)));
    CHECK_INT(probe(port, "GET /metrics HTTP/1.1\r\nHost: any\r\n\r\n", &reply), 200);
    CHECK(strstr(reply.body, "pendulumd_requests_total") != NULL);
    test_reply_clear(&reply);
    CHECK_INT(probe(port, "GET /readyz HTTP/1.1\r\nHost: any\r\n\r\n", &reply), 200);
    test_reply_clear(&reply);
    CHECK_INT(probe(port, "GET /v1/presets HTTP/1.1\r\nHost: any\r\n\r\n", &reply), 404);
    ask_problem(&reply, 404, NULL);
    CHECK_SAYING(strstr(reply.body, "--probe-listen") != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    CHECK_INT(probe(port, "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", &reply), 400);
}

TEST(where_the_store_is_may_stand_in_a_file_of_its_own) {
    OWN(place, end) place;
    char path[128], text[1024];
    REQUIRE(place_begin(&place, 0));
    snprintf(path, sizeof path, "%s/url", place.directory);
    FILE *file = fopen(path, "w");
    REQUIRE(file != NULL);
    fprintf(file, "%s\n", place.url);
    fclose(file);
    CHECK(!chmod(path, 0600));
    const char *const options[] = {"--store", "none", "--store-file", path, NULL};
    struct test_server *server = test_server_start(options);
    struct test_reply reply;
    if (server) {
        CHECK_INT(test_request(server, &reply, "GET", "/readyz?need=jobs", "", NULL), 200);
        test_reply_clear(&reply);
    }
    test_server_stop(&server);
    CHECK(!chmod(path, 0644));
    CHECK_INT(test_server_run(options, text, sizeof text), 2);
    CHECK_SAYING(strstr(text, "0600") != NULL, "%s", text);
    /* a value that is not a store is not quoted: it may be a password */
    file = fopen(path, "w");
    REQUIRE(file != NULL);
    fputs("mysql://user:secret@host", file);
    fclose(file);
    CHECK(!chmod(path, 0600));
    CHECK_INT(test_server_run(options, text, sizeof text), 2);
    CHECK_SAYING(strstr(text, "must be none, sqlite") && !strstr(text, "secret"), "%s", text);
    unlink(path);
}

static int erases(const struct test_server *server, const char *name, const char *field) {
    OWN(test_reply, clear) reply;
    char path[128];
    snprintf(path, sizeof path, "/v1/clients/%s", name);
    int status = test_request(server, &reply, "DELETE", path, field, NULL);
    if (status >= 400) ask_problem(&reply, status, NULL);
    return status;
}

#define TOKEN_A "Authorization: Bearer abcdefghijklmnopqrstuv\r\n"
#define TOKEN_B "Authorization: Bearer zyxwvutsrqponmlkjihgfe\r\n"

/* jobs of two clients, one of which is being computed, and a scene of each and one of both */
static void erasure(struct place *place) {
    struct test_reply reply;
    char done[ID + 1], running[ID + 1], others[ID + 1], path[64];
    static const char lyapunov[] = "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1}",
                      endless[] = "{\"pendulum\":" ASK_DOUBLE
                                  ",\"times\":{\"start\":0,\"stop\":20000000,\"count\":5}}",
                      scene[] = "{\"title\":\"both\",\"request\":{\"pendulum\":" ASK_DOUBLE
                                ",\"times\":[0,1]}}";
    const char *const options[] = {
        "--store",       place->url,          "--keep-seconds", "3600", "--max-job-steps",
        "1000000000000", "--max-job-seconds", "10000000",       NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    if (!server) return;
    CHECK_INT(submit(server, "/v1/lyapunov", ASYNC TOKEN_A, lyapunov, done), 202);
    CHECK_INT(submit(server, "/v1/lyapunov", ASYNC TOKEN_B, lyapunov, others), 202);
    char word[WORDS];
    job_wait(server, done, word);
    job_wait(server, others, word);
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC TOKEN_A, endless, running), 202);
    char first[128] = "";
    CHECK_INT(test_request(server, &reply, "POST", "/v1/scenes", TOKEN_A, scene), 201);
    snprintf(first, sizeof first, "%s", test_reply_header(&reply, "Location"));
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/scenes", TOKEN_B, scene), 201);
    test_reply_clear(&reply);
    /* clients that may not, and names that cannot exist */
    CHECK_INT(erases(server, "me", ""), 401);
    CHECK_INT(erases(server, "key:anna", TOKEN_A), 403);
    CHECK_INT(erases(server, "me", TOKEN_A), 204);
    CHECK_INT(job_get(server, &reply, done, "", TOKEN_A), 404);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, running, "", TOKEN_A), 404);
    test_reply_clear(&reply);
    /* the running job is cancelled, and the sums are those of the other client alone */
    CHECK(ask_await(server, "pendulumd_workers_busy", 0, 0));
    CHECK(ask_await(server, "pendulumd_jobs{state=\"successful\"}", 1, 1));
    CHECK(ask_await(server, "pendulumd_jobs{state=\"running\"}", 0, 0));
    CHECK(ask_await(server, "pendulumd_jobs{state=\"dismissed\"}", 0, 0));
    CHECK_INT(job_get(server, &reply, others, "/results", ""), 200);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "GET", first, "", NULL), 200);
    test_reply_clear(&reply);
    CHECK_INT(erases(server, "me", TOKEN_A), 204);
    CHECK_INT(erases(server, "me", TOKEN_B), 204);
    CHECK_INT(test_request(server, &reply, "GET", first, "", NULL), 404);
    test_reply_clear(&reply);
    snprintf(path, sizeof path, "/v1/jobs");
    CHECK_INT(test_request(server, &reply, "GET", path, TOKEN_B, NULL), 200);
    CHECK_SAYING(strstr(reply.body, "\"jobs\":[]") != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    CHECK(ask_await(server, "pendulumd_store_bytes", 0, 0));
}

TEST(what_is_kept_of_a_client_is_erased_and_nothing_else) { place_on_both(erasure); }

TEST(an_operator_erases_what_is_kept_of_others) {
    OWN(keyed, end) keyed;
    struct test_reply reply;
    char operator[FIELD], teacher[FIELD], headers[2 * FIELD], text[1024], id[ID + 1], by[ID + 1];
    REQUIRE(keyed_begin(&keyed));
    REQUIRE(make(&keyed, "ops", "operator", NULL, operator));
    REQUIRE(make(&keyed, "anna", "teacher", NULL, teacher));
    REQUIRE(says(&keyed, "keys: 3 keys are valid"));
    static const char body[] = "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1}";
    snprintf(headers, sizeof headers, ASYNC "%s", teacher);
    CHECK_INT(submit(keyed.server, "/v1/lyapunov", headers, body, id), 202);
    CHECK_INT(submit(keyed.server, "/v1/lyapunov", ASYNC "X-Account: bob\r\nX-Roles: teacher\r\n",
                     body, by),
              202);
    CHECK_INT(erases(keyed.server, "account:bob", teacher), 403);
    CHECK_INT(erases(keyed.server, "account:bob", ""), 401);
    CHECK_INT(erases(keyed.server, "bob", operator), 404);
    CHECK_INT(erases(keyed.server, "key:", operator), 404);
    CHECK_INT(erases(keyed.server, "key:anna", operator), 204);
    CHECK_INT(job_get(keyed.server, &reply, id, "", ""), 404);
    test_reply_clear(&reply);
    CHECK_INT(job_get(keyed.server, &reply, by, "", ""), 200);
    test_reply_clear(&reply);
    CHECK_INT(erases(keyed.server, "account:bob", operator), 204);
    CHECK_INT(job_get(keyed.server, &reply, by, "", ""), 404);
    test_reply_clear(&reply);
    CHECK_INT(COMMAND(&keyed, "list", text, NULL), 0);
}

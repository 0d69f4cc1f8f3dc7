/* Sweeps as jobs: a map of flips as a picture and as arrays, trees of random masses, members
 * that fail. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/wire/ask.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SIDE "40" /* everything takes longer */
#define PART "0.001"
#else
#define SIDE "160"
#define PART "0.02"
#endif
#define AXIS(arm) "{\"vary\":\"theta\",\"arm\":" arm ",\"start\":-3,\"stop\":3,\"count\":" SIDE "}"

enum { PATH = 96 };

/* a daemon with a separate store, in parts of some milliseconds */
struct sweep {
    struct test_server *server;
    char directory[40];
};

static int sweep_begin(struct sweep *sweep, const char *steps) {
    char store[64];
    snprintf(sweep->directory, sizeof sweep->directory, "/tmp/pendulumd-test-XXXXXX");
    if (!CHECK(mkdtemp(sweep->directory) != NULL)) return 0;
    snprintf(store, sizeof store, "sqlite:%s/store.db", sweep->directory);
    const char *const options[] = {"--store",
                                   store,
                                   "--workers",
                                   "2",
                                   "--job-part-seconds",
                                   PART,
                                   "--cache-bytes",
                                   "0",
                                   "--max-steps",
                                   steps,
                                   "--max-job-steps",
                                   steps,
                                   NULL};
    sweep->server = test_server_start(options);
    return sweep->server != NULL;
}

static void sweep_end(struct sweep *sweep) {
    char command[64];
    test_server_stop(&sweep->server);
    snprintf(command, sizeof command, "rm -rf '%s'", sweep->directory);
    CHECK(!system(command));
}

static double reply_number(const struct test_reply *reply, const char *name) {
    cJSON *json = ask_json(reply);
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    double value = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    cJSON_Delete(json);
    return value;
}

/* submits, and watches the job to its end; the path of its results, and how many different values
 * of progress were seen */
static int sweep_run(const struct sweep *sweep, const char *body, char path[PATH]) {
    struct test_reply reply;
    double last = -1, progress = 0;
    int steps = 0;
    CHECK_INT(test_request(sweep->server, &reply, "POST", "/v1/ensembles",
                           "Prefer: respond-async\r\n", body),
              202);
    const char *location = test_reply_header(&reply, "Location");
    snprintf(path, PATH, "%s", location ? location : "/nowhere");
    test_reply_clear(&reply);
    for (double end = test_clock() + TEST_PATIENCE; progress < 100 && test_clock() < end;
         test_sleep(0.002)) {
        CHECK_INT(test_request(sweep->server, &reply, "GET", path, "", NULL), 200);
        progress = reply_number(&reply, "progress");
        CHECK(progress >= last);
        steps += progress > last;
        last = progress;
        test_reply_clear(&reply);
    }
    CHECK(progress == 100);
    strncat(path, "/results", PATH - strlen(path) - 1);
    return steps;
}

/* the results in a representation that may not be text; it is not recorded */
static int sweep_fetch(const struct sweep *sweep, struct test_reply *reply, const char *path,
                       const char *accept) {
    OWN(test_client, close) client;
    char text[256];
    *reply = (struct test_reply){0};
    if (!test_client_open(&client, test_server_port(sweep->server))) return 0;
    snprintf(text, sizeof text,
             "GET %s HTTP/1.1\r\nHost: x\r\nConnection: close\r\nAccept: %s\r\n\r\n", path, accept);
    test_client_say(&client, text);
    return test_client_receive(&client, reply, 0, TEST_PATIENCE);
}

static unsigned png_whole(const char *at) {
    const unsigned char *byte = (const unsigned char *)at;
    return (unsigned)byte[0] << 24 | (unsigned)byte[1] << 16 | (unsigned)byte[2] << 8 | byte[3];
}

TEST(a_map_of_flips_is_a_job_with_progress_a_picture_and_arrays) {
    static const char body[] = "{\"pendulum\":" ASK_DOUBLE
                               ",\"duration\":20,\"rtol\":1e-9,\"observables\":[\"first_flip\"],"
                               "\"grid\":[" AXIS("1") "," AXIS(
                                   "2") "],\"picture\":{\"of\":\"first_flip\",\"scale\":\"log\"}}";
    const unsigned side = (unsigned)atoi(SIDE);
    OWN(sweep, end) sweep;
    OWN(test_reply, clear) reply = {0};
    char path[PATH];
    REQUIRE(sweep_begin(&sweep, "1000000000"));
    /* a slow reader, on a busy machine, sees little of it */
    int steps = 0;
    for (int i = 0; i < 6 && steps < 3; i++) steps = sweep_run(&sweep, body, path);
    CHECK_SAYING(steps >= 3, "its progress was told %d times", steps);
    CHECK_INT(sweep_fetch(&sweep, &reply, path, "image/png"), 200);
    CHECK(reply.body_bytes > 100 && !memcmp(reply.body, "\x89PNG\r\n\x1a\n", 8));
    if (reply.body_bytes > 24)
        CHECK(png_whole(reply.body + 16) == side && png_whole(reply.body + 20) == side);
    test_reply_clear(&reply);
    CHECK_INT(sweep_fetch(&sweep, &reply, path, "application/x-npz"), 200);
    /* four columns of doubles: member, status, time, arm */
    CHECK(reply.body_bytes > 4 * 8 * side * side && !memcmp(reply.body, "PK\3\4", 4));
}

/* calls `row` for every line of a CSV except the first, with its numbers; returns their count */
static int csv_rows(const char *text, int columns, void (*row)(const double value[], void *context),
                    void *context) {
    int rows = 0;
    for (const char *line = strchr(text, '\n'); line && line[1];
         line = strchr(line + 1, '\n'), rows++) {
        double value[16] = {0};
        char *at = (char *)line + 1;
        for (int i = 0; i < columns; i++, at += *at == ',') value[i] = strtod(at, &at);
        row(value, context);
    }
    return rows;
}

struct spread {
    double least, most, drift;
    int failed;
};

/* member, status, length x 2, mass x 2, gravity, energy drift */
static void spread_row(const double value[], void *context) {
    struct spread *spread = context;
    spread->failed += value[1] != 0;
    spread->least = fmin(spread->least, value[4]);
    spread->most = fmax(spread->most, value[4]);
    spread->drift = fmax(spread->drift, fabs(value[7]));
}

TEST(ten_thousand_trees_of_varied_masses_are_a_job) {
    static const char body[] =
        "{\"pendulum\":" ASK_DOUBLE ",\"initial\":{\"theta\":[1,2]},\"duration\":2,\"observables\":"
        "[\"parameters\",\"energy_drift\"],\"random\":{\"count\":10000,\"seed\":7,\"draw\":[{"
        "\"vary\":\"mass\",\"arm\":1,\"distribution\":\"uniform\",\"low\":0.5,\"high\":2},{"
        "\"vary\":\"mass\",\"arm\":2,\"distribution\":\"normal\",\"mean\":1,\"deviation\":0.05}]}}";
    OWN(sweep, end) sweep;
    OWN(test_reply, clear) reply = {0};
    struct spread spread = {.least = INFINITY};
    char path[PATH];
    REQUIRE(sweep_begin(&sweep, "1000000000"));
    sweep_run(&sweep, body, path);
    CHECK_INT(sweep_fetch(&sweep, &reply, path, "text/csv"), 200);
    CHECK_INT(csv_rows(reply.body, 8, spread_row, &spread), 10000);
    CHECK_INT(spread.failed, 0);
    CHECK(spread.least >= 0.5 && spread.least < 0.51 && spread.most <= 2 && spread.most > 1.99);
    CHECK_SAYING(spread.drift > 0 && spread.drift < 1e-9, "energy drifts by %g", spread.drift);
}

/* at most four rows */
static void member_row(const double value[], void *context) {
    double(**at)[6] = context;
    memcpy(*at, value, sizeof **at);
    ++*at;
}

TEST(members_that_fail_are_told_and_others_stand) {
    /* a start beyond doubles, one that needs more steps than are allowed, and two good ones */
    static const char body[] =
        "{\"pendulum\":" ASK_DOUBLE ",\"duration\":5,\"states\":[{\"theta\":[2,2.5]},{\"theta\":[0,"
        "0],\"thetad\":[1e200,0]},{\"theta\":[0,0],\"thetad\":[1000000,0]},{\"theta\":[3,1]}],"
        "\"observables\":[\"final\"]}";
    static const char good[] = "{\"pendulum\":" ASK_DOUBLE
                               ",\"duration\":5,\"states\":[{\"theta\":[2,2.5]},{\"theta\":[3,1]}],"
                               "\"observables\":[\"final\"]}";
    OWN(sweep, end) sweep;
    struct test_reply reply, right;
    char path[PATH];
    double all[4][6] = {{0}}, alone[2][6] = {{0}};
    REQUIRE(sweep_begin(&sweep, "100000"));
    sweep_run(&sweep, body, path);
    CHECK_INT(sweep_fetch(&sweep, &reply, path, "text/csv"), 200);
    CHECK_INT(
        test_request(sweep.server, &right, "POST", "/v1/ensembles", "Accept: text/csv\r\n", good),
        200);
    double(*at)[6] = all, (*other)[6] = alone;
    CHECK_INT(csv_rows(reply.body, 6, member_row, &at), 4);
    CHECK_INT(csv_rows(right.body, 6, member_row, &other), 2);
    /* 2: the step would be too small, 3: too many steps */
    CHECK(all[0][1] == 0 && all[1][1] == 2 && all[2][1] == 3 && all[3][1] == 0);
    CHECK(fabs(all[0][2]) > 0.1 && !memcmp(&all[0][1], &alone[0][1], 5 * sizeof(double)));
    CHECK(fabs(all[3][2]) > 0.1 && !memcmp(&all[3][1], &alone[1][1], 5 * sizeof(double)));
    test_reply_clear(&right);
    test_reply_clear(&reply);
    CHECK_INT(sweep_fetch(&sweep, &reply, path, "application/json"), 200);
    CHECK(strstr(reply.body, "\"members\":4,\"failed\":2,") != NULL);
    test_reply_clear(&reply);
}

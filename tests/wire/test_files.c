/* Results of jobs as files in a folder: the same bytes as from the database, a manifest, files that
 * are lost or altered, and their deletion. */
#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/wire/place.h"

#define CSV "Accept: text/csv\r\n"
#define TOKEN "Authorization: Bearer 0123456789abcdef0123456789abcdef\r\n"

#define MEMBERS                                                                                    \
    "{\"pendulum\":" ASK_DOUBLE ",\"duration\":2,\"observables\":[\"final\",\"first_flip\"],"      \
    "\"random\":{\"count\":3000,\"seed\":5,\"draw\":[{\"vary\":\"theta\",\"arm\":1,"               \
    "\"distribution\":\"uniform\",\"low\":-3,\"high\":3}]}}"

/* a motion whose parts follow each other */
#define MOTION                                                                                     \
    "{\"pendulum\":" ASK_DOUBLE ",\"initial\":{\"theta\":[2,2]},\"times\":{\"start\":0,"           \
    "\"stop\":400,\"step\":0.01},\"output\":[\"phi\"]}"

/* a folder for files, beside a store */
struct folder {
    char path[64], option[96];
};

static int folder_begin(struct folder *folder) {
    snprintf(folder->path, sizeof folder->path, "/tmp/pendulumd-files-XXXXXX");
    if (!CHECK(mkdtemp(folder->path) != NULL)) return 0;
    snprintf(folder->option, sizeof folder->option, "file://%s", folder->path);
    return 1;
}

static void folder_end(const struct folder *folder) {
    char command[96];
    snprintf(command, sizeof command, "rm -rf '%s'", folder->path);
    CHECK(!system(command));
}

/* names below a path */
static int folder_count(const char *path) {
    DIR *opened = opendir(path);
    int count = -2; /* . and .. */
    while (opened && readdir(opened)) count++;
    if (opened) closedir(opened);
    return opened ? count : 0;
}

static void answers_same(const struct test_server *server, const char *id, const char *path,
                         const char *body) {
    struct test_reply whole, read;
    CHECK_INT(test_request(server, &whole, "POST", path, CSV, body), 200);
    for (int again = 0; again < 2; again++) {
        CHECK_INT(job_get(server, &read, id, "/results", CSV), 200);
        CHECK(read.body_bytes == whole.body_bytes &&
              !memcmp(read.body, whole.body, read.body_bytes));
        test_reply_clear(&read);
    }
    CHECK_INT(job_get(server, &read, id, "/results", CSV "Range: bytes=1000-2999\r\n"), 206);
    CHECK(read.body_bytes == 2000 && !memcmp(read.body, whole.body + 1000, 2000));
    test_reply_clear(&read);
    test_reply_clear(&whole);
}

/* the manifest of a job; the path of its second file */
static void manifest_of(const struct test_server *server, const char *id, int rows,
                        char path[256]) {
    struct test_reply reply;
    struct stat found;
    path[0] = 0;
    if (!CHECK_INT(job_get(server, &reply, id, "/results?manifest=true", ""), 200)) return;
    cJSON *json = ask_json(&reply), *file;
    const cJSON *files = cJSON_GetObjectItemCaseSensitive(json, "files");
    CHECK(cJSON_GetArraySize(files) > 1);
    int part = 0;
    cJSON_ArrayForEach(file, files) {
        const char *href = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(file, "href"));
        const char *digest = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(file, "sha256"));
        rows -= (int)cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(file, "rows"));
        if (!CHECK(href && digest && strlen(digest) == 64 && !strncmp(href, "file:///", 8))) break;
        char digits[17];
        snprintf(digits, sizeof digits, "%.16s", digest);
        CHECK(strstr(href, digits) != NULL && !stat(href + 7, &found) &&
              found.st_size ==
                  cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(file, "bytes")));
        if (++part == 2) snprintf(path, 256, "%s", href + 7);
    }
    CHECK_INT(rows, 0);
    cJSON_Delete(json);
    test_reply_clear(&reply);
}

/* results with a file at fault: a problem that says so, or a download that is cut off where the
 * fault is found after its head */
static void faulty(const struct test_server *server, const char *id, const char *said) {
    struct test_reply reply;
    int status = job_get(server, &reply, id, "/results", CSV);
    CHECK(!status || status == 503);
    CHECK(!status || (reply.body && strstr(reply.body, said) != NULL));
    test_reply_clear(&reply);
}

/* lost and altered files end in a problem; the file that comes back is good again */
static void faults_of(const struct test_server *server, const char *id, const char *path) {
    char aside[300];
    struct test_reply reply;
    snprintf(aside, sizeof aside, "%s.aside", path);
    CHECK(!rename(path, aside));
    faulty(server, id, "lost");
    CHECK(!rename(aside, path));
    int file = open(path, O_RDWR);
    char byte = 0;
    CHECK(pread(file, &byte, 1, 1000) == 1);
    for (int bit = 0; bit < 8; bit++) {
        char wrong = (char)(byte ^ (1 << bit));
        CHECK(pwrite(file, &wrong, 1, 1000) == 1);
        faulty(server, id, "damaged");
    }
    CHECK(pwrite(file, &byte, 1, 1000) == 1);
    close(file);
    CHECK_INT(job_get(server, &reply, id, "/results", CSV), 200);
    test_reply_clear(&reply);
}

/* waits until no job has files */
static void files_gone(const struct folder *folder) {
    double end = test_clock() + TEST_PATIENCE;
    while (folder_count(folder->path) && test_clock() < end) test_sleep(0.05);
    CHECK_INT(folder_count(folder->path), 0);
}

static void files_read(struct place *place) {
    struct folder folder;
    struct test_reply reply;
    char id[ID + 1], other[ID + 1], word[WORDS], path[256];
    if (!folder_begin(&folder)) return;
    struct test_server *server = place_serve(place, "all", "0.003", "--results", folder.option);
    if (!CHECK(server != NULL)) return;
    CHECK_INT(submit(server, "/v1/ensembles", ASYNC TOKEN, MEMBERS, id), 202);
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC TOKEN, MOTION, other), 202);
    job_wait(server, id, word);
    CHECK_TEXT(word, "successful");
    job_wait(server, other, word);
    CHECK_TEXT(word, "successful");
    answers_same(server, id, "/v1/ensembles", MEMBERS);
    answers_same(server, other, "/v1/trajectories", MOTION);
    manifest_of(server, other, 40001, path);
    manifest_of(server, id, 3000, path);
    if (path[0]) faults_of(server, id, path);
    stop_after_deaths(&server);
    /* a process without the option says what is missing */
    server = place_serve(place, "api", "0.01", NULL, NULL);
    CHECK_INT(job_get(server, &reply, id, "/results", CSV), 503);
    CHECK(reply.body && strstr(reply.body, "--results") != NULL);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/results?manifest=true", ""), 409);
    test_reply_clear(&reply);
    test_server_stop(&server);
    /* a folder that is older than results are kept, of no job, and one of yesterday */
    struct timespec old[2] = {{.tv_sec = 1000000000}, {.tv_sec = 1000000000}};
    char lost[2][128];
    for (int i = 0; i < 2; i++) {
        snprintf(lost[i], sizeof lost[i], "%s/job=%d123456789abcdefghjkmnpqrs", folder.path, i);
        CHECK(!mkdir(lost[i], 0700) && (i || !utimensat(AT_FDCWD, lost[i], old, 0)));
    }
    server = place_serve(place, "all", "0.01", "--results", folder.option);
    for (double end = test_clock() + TEST_PATIENCE; !access(lost[0], F_OK) && test_clock() < end;)
        test_sleep(0.05);
    CHECK(access(lost[0], F_OK) && !access(lost[1], F_OK) && !rmdir(lost[1]));
    CHECK_INT(test_request(server, &reply, "DELETE", "/v1/clients/me", TOKEN, NULL), 204);
    test_reply_clear(&reply);
    files_gone(&folder);
    test_server_stop(&server);
    folder_end(&folder);
}

TEST(results_in_files_are_those_of_the_database) { place_on_both(files_read); }

TEST(a_folder_that_goes_away_is_waited_for) {
    struct place place;
    struct folder folder;
    char id[ID + 1], word[WORDS], aside[96];
    if (!place_begin(&place, 0) || !folder_begin(&folder)) return;
    struct test_server *server = place_serve(&place, "all", "0.003", "--results", folder.option);
    if (!CHECK(server != NULL)) return;
    /* who runs as root could write to a folder without rights: it is renamed */
    snprintf(aside, sizeof aside, "%s.aside", folder.path);
    CHECK(!rename(folder.path, aside));
    CHECK_INT(submit(server, "/v1/ensembles", ASYNC TOKEN, MEMBERS, id), 202);
    test_sleep(0.5);
    struct test_reply reply;
    CHECK_INT(job_get(server, &reply, id, "", ""), 200);
    CHECK(reply.body && strstr(reply.body, "\"running\"") != NULL);
    test_reply_clear(&reply);
    CHECK(!rename(aside, folder.path));
    job_wait(server, id, word);
    CHECK_TEXT(word, "successful");
    answers_same(server, id, "/v1/ensembles", MEMBERS);
    char said[256];
    snprintf(said, sizeof said, "/v1/jobs/%s", id);
    CHECK_INT(test_request(server, &reply, "DELETE", said, TOKEN, NULL), 200);
    test_reply_clear(&reply);
    files_gone(&folder);
    stop_after_deaths(&server);
    place_end(&place);
    folder_end(&folder);
}

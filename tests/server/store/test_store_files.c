/* Tests of store_files: files of parts in a folder. */
#include "server/store/store_files.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "api/call/digest.h"
#include "tests/harness/test.h"

static const char job[] = "0123456789abcdefghjkmnpqrs";

/* a place in a new folder, and a log that nobody reads */
struct given {
    struct srv_log *log;
    struct srv_files files;
    const char *path;
};

static void given_begin(struct given *given) {
    struct pend_error error;
    *given = (struct given){.files.url = "file:///tmp/pendulumd-files-XXXXXX"};
    given->path = given->files.url + 7;
    REQUIRE(mkdtemp(given->files.url + 7) != NULL);
    REQUIRE(srv_log_new(&given->log, -1, dup(STDERR_FILENO)) == PEND_OK);
    given->files.log = given->log;
    REQUIRE(srv_files_check(&given->files, &error) == PEND_OK);
}

static void given_end(struct given *given) {
    char command[96];
    srv_log_free(&given->log);
    snprintf(command, sizeof command, "rm -rf '%.64s'", given->path);
    CHECK(!system(command));
}

/* a file of one row of one number, as the Parquet writer makes it; its digest is computed */
static struct api_raw_file file_of(const char *data, size_t bytes) {
    struct api_raw_file file = {.rows = 0, .width = 1, .bytes = bytes};
    api_digest_bytes(file.digest, data, bytes);
    return file;
}

TEST(a_file_is_written_once_read_whole_and_deleted) {
    struct given given;
    struct api_buffer rows;
    char link[SRV_FILES_LINK];
    given_begin(&given);
    struct api_raw_file file = file_of("PAR1 and more", 13);
    api_buffer_init(&rows, 1 << 20);
    CHECK_INT(srv_files_get(&given.files, job, 6, &file, &rows), SRV_STORED_NONE);
    for (int twice = 0; twice < 2; twice++)
        CHECK_INT(srv_files_put(&given.files, job, 6, &file, "PAR1 and more"), SRV_STORED);
    CHECK_INT(srv_files_get(&given.files, job, 6, &file, &rows), SRV_STORED);
    srv_files_link(&given.files, job, 6, &file, link);
    CHECK_SAYING(strstr(link, "/part-00007-") && !access(link + 7, R_OK), "%s", link);
    /* a file that is there stays, because somebody may read it */
    struct stat before, after;
    CHECK(!stat(link + 7, &before) && (before.st_mode & 0777) == 0640);
    CHECK_INT(srv_files_put(&given.files, job, 6, &file, "PAR1 and more"), SRV_STORED);
    CHECK(!stat(link + 7, &after) && after.st_ino == before.st_ino);
    /* of another length, and with other bytes; writing it again repairs it */
    CHECK(!truncate(link + 7, 12));
    CHECK_INT(srv_files_get(&given.files, job, 6, &file, &rows), SRV_STORED_DAMAGED);
    FILE *other = fopen(link + 7, "w");
    REQUIRE(other && fputs("PAR1 and mOre", other) > 0 && !fclose(other));
    CHECK_INT(srv_files_get(&given.files, job, 6, &file, &rows), SRV_STORED_DAMAGED);
    CHECK_INT(srv_files_put(&given.files, job, 6, &file, "PAR1 and more"), SRV_STORED);
    CHECK_INT(srv_files_get(&given.files, job, 6, &file, &rows), SRV_STORED);
    CHECK_INT(srv_files_drop(&given.files, job), SRV_STORED);
    CHECK_INT(srv_files_get(&given.files, job, 6, &file, &rows), SRV_STORED_NONE);
    CHECK_INT(srv_files_drop(&given.files, job), SRV_STORED);
    api_buffer_clear(&rows);
    given_end(&given);
}

TEST(a_folder_that_is_gone_is_away) {
    struct given given;
    struct api_raw_file file = file_of("PAR1", 4);
    given_begin(&given);
    CHECK(!rmdir(given.path));
    CHECK_INT(srv_files_put(&given.files, job, 0, &file, "PAR1"), SRV_STORED_AWAY);
    /* its files are neither lost nor deleted */
    CHECK_INT(srv_files_get(&given.files, job, 0, &file, NULL), SRV_STORED_AWAY);
    CHECK_INT(srv_files_drop(&given.files, job), SRV_STORED_AWAY);
    CHECK(!mkdir(given.path, 0700));
    CHECK_INT(srv_files_put(&given.files, job, 0, &file, "PAR1"), SRV_STORED);
    given_end(&given);
}

TEST(a_file_that_does_not_fit_leaves_no_folder) {
    struct given given;
    struct api_raw_file file = file_of("PAR1", 4);
    struct rlimit no = {0}, any;
    char link[SRV_FILES_LINK];
    given_begin(&given);
    srv_files_link(&given.files, job, 0, NULL, link);
    CHECK(!getrlimit(RLIMIT_FSIZE, &any) && signal(SIGXFSZ, SIG_IGN) != SIG_ERR);
    no.rlim_max = any.rlim_max;
    CHECK(!setrlimit(RLIMIT_FSIZE, &no));
    CHECK(srv_files_put(&given.files, job, 0, &file, "PAR1") != SRV_STORED);
    CHECK(!setrlimit(RLIMIT_FSIZE, &any) && access(link + 7, F_OK));
    CHECK_INT(srv_files_put(&given.files, job, 0, &file, "PAR1"), SRV_STORED);
    given_end(&given);
}

TEST(what_others_put_into_the_folder_neither_blocks_nor_leads_out) {
    struct given given;
    struct api_raw_file file = file_of("PAR1", 4);
    char link[SRV_FILES_LINK], found[SRV_ID_BYTES], path[SRV_FILES_LINK + 8];
    given_begin(&given);
    srv_files_link(&given.files, "../../x", 0, NULL, link);
    CHECK_TEXT(link + strlen(given.files.url), "/job=..");
    CHECK_INT(srv_files_put(&given.files, job, 0, &file, "PAR1"), SRV_STORED);
    srv_files_link(&given.files, job, 0, &file, link);
    CHECK(!unlink(link + 7) && !mkfifo(link + 7, 0600));
    CHECK_INT(srv_files_get(&given.files, job, 0, &file, NULL), SRV_STORED_DAMAGED);
    CHECK(!unlink(link + 7) && !symlink("/etc/passwd", link + 7));
    CHECK_INT(srv_files_get(&given.files, job, 0, &file, NULL), SRV_STORED_DAMAGED);
    CHECK_INT(srv_files_put(&given.files, job, 0, &file, "PAR1"), SRV_STORED);
    snprintf(path, sizeof path, "%s.d", link + 7);
    CHECK(!mkdir(path, 0700));
    CHECK_INT(srv_files_drop(&given.files, job), SRV_STORED);
    CHECK(access(link + 7, F_OK) && !access(path, F_OK));
    /* the folder that stays is found once it is old, in one round an hour */
    CHECK(!srv_files_old(&given.files, 60, found));
    given.files.walk_ns = 0;
    CHECK(srv_files_old(&given.files, -60, found));
    CHECK_TEXT(found, job);
    CHECK(!srv_files_old(&given.files, -60, found) && !given.files.walk);
    CHECK(!srv_files_old(&given.files, -60, found));
    given_end(&given);
}

TEST(a_place_that_cannot_be_used_is_refused) {
    static const char *const wrong[] = {"file:///nowhere/at/all", "file://relative", "ftp://x/y",
                                        "file:///etc/passwd"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct srv_files files = {0};
        struct pend_error error = {.text = ""};
        snprintf(files.url, sizeof files.url, "%s", wrong[i]);
        CHECK(srv_files_check(&files, &error) == PEND_INVALID);
        CHECK_SAYING(strstr(error.text, wrong[i]) != NULL, "%s", error.text);
    }
}

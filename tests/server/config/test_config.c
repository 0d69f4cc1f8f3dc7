#include "server/config/config_load.h"

#include "server/reload.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/harness/test.h"

/* loads from words of a command line, separated by blanks, and up to two variables */
static enum pend_status config_of(struct srv_config *config, const char *line, const char *one,
                                  const char *two, struct pend_error *error) {
    char copy[1024], *argv[32] = {(char *)"pendulumd"},
                     *environment[] = {(char *)one, (char *)two, NULL};
    int argc = 1;
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok(copy, " "); word && argc < 32; word = strtok(NULL, " "))
        argv[argc++] = word;
    if (!one) environment[0] = environment[1], environment[1] = NULL;
    *error = (struct pend_error){.text = ""};
    return srv_config_load(config, argc, argv, environment, error);
}

/* a file with the text, for --config; path receives its name */
static void config_file(char path[64], const char *text) {
    strcpy(path, "/tmp/pendulumd-test-XXXXXX");
    int fd = mkstemp(path);
    size_t bytes = strlen(text);
    CHECK(fd >= 0 && write(fd, text, bytes) == (ssize_t)bytes);
    close(fd);
}

TEST(the_defaults_are_those_of_the_table) {
    struct srv_config config;
    struct pend_error error;
    REQUIRE(config_of(&config, "", NULL, NULL, &error) == PEND_OK);
    CHECK_INT(config.task, SRV_CONFIG_SERVE);
    CHECK_TEXT(config.listen, "127.0.0.1:8080");
    CHECK_TEXT(config.file, "");
    CHECK_INT((long long)config.workers, 0);
    CHECK_INT((long long)config.queue, 256);
    CHECK_INT((long long)config.held_bytes, 1 << 30);
    CHECK_INT((long long)config.access_log, SRV_CONFIG_AUTO);
    CHECK_INT((long long)config.least_rate, 16384);
    struct api_limits limits;
    api_limits_init(&limits);
    for (int i = 0; api_limits_row(i); i++)
        CHECK_INT((long long)*api_limits_value(&config.limits, i),
                  (long long)*api_limits_value(&limits, i));
}

TEST(every_option_can_be_set_in_all_three_places) {
    struct srv_option row;
    for (int i = 0; srv_config_row(i, &row); i++) {
        if (!row.sample || !strcmp(row.name, "config")) continue;
        struct srv_config config, again;
        struct pend_error error;
        char line[128], variable[128] = "PENDULUMD_", text[128], path[64];
        const char *value = row.start;
        for (size_t k = 0; k <= strlen(row.name); k++)
            variable[10 + k] =
                row.name[k] == '-' ? '_' : (char)(row.name[k] & (row.name[k] >= 'a' ? ~32 : ~0));
        snprintf(variable + strlen(variable), 64, "=%s", value);
        snprintf(line, sizeof line, "--%s %s", row.name, value);
        CHECK_SAYING(config_of(&config, line, NULL, NULL, &error) == PEND_OK, "%s: %s", line,
                     error.text);
        CHECK_SAYING(config_of(&again, "", variable, NULL, &error) == PEND_OK && !again.warning[0],
                     "%s: %s%s", variable, error.text, again.warning);
        CHECK(!memcmp(&config, &again, sizeof config));
        snprintf(text, sizeof text, "%s = %s\n", row.name, value);
        config_file(path, text);
        snprintf(line, sizeof line, "--config=%s", path);
        CHECK_SAYING(config_of(&again, line, NULL, NULL, &error) == PEND_OK, "%s: %s", text,
                     error.text);
        unlink(path);
    }
}

TEST(later_places_win) {
    struct srv_config config;
    struct pend_error error;
    char path[64], line[128], variable[128];
    config_file(path, "# three of them\nmax-queue = 5\n\n  max-arms=6 # six\nworkers = 7\n");
    snprintf(line, sizeof line, "--workers 9 --config %s", path);
    REQUIRE(config_of(&config, line, "PENDULUMD_MAX_ARMS=8", "PENDULUMD_WORKERS=8", &error) ==
            PEND_OK);
    CHECK_INT((long long)config.queue, 5);
    CHECK_INT((long long)config.limits.arms, 8);
    CHECK_INT((long long)config.workers, 9);
    /* the environment can name the file, and the command line another one */
    snprintf(variable, sizeof variable, "PENDULUMD_CONFIG=%s", path);
    REQUIRE(config_of(&config, "", variable, NULL, &error) == PEND_OK);
    CHECK_INT((long long)config.queue, 5);
    REQUIRE(config_of(&config, "--config /dev/null", variable, NULL, &error) == PEND_OK);
    CHECK_INT((long long)config.queue, 256);
    REQUIRE(config_of(&config, "--max-queue 3 --max-queue=4", NULL, NULL, &error) == PEND_OK);
    CHECK_INT((long long)config.queue, 4);
    unlink(path);
}

TEST(bytes_take_a_unit) {
    struct srv_config config;
    struct pend_error error;
    REQUIRE(config_of(&config, "--max-body-bytes 2K --max-held-bytes 3G --max-answer-bytes 4m",
                      NULL, NULL, &error) == PEND_OK);
    CHECK_INT((long long)config.limits.body_bytes, 2048);
    CHECK_INT((long long)config.held_bytes, 3ll << 30);
    CHECK_INT((long long)config.limits.answer_bytes, 4 << 20);
}

TEST(a_bad_value_is_refused_by_name) {
    static const struct {
        const char *line, *variable, *word;
    } bad[] = {
        {"--nope 1", NULL, "--nope"},
        {"nope", NULL, "'nope'"},
        {"-w 3", NULL, "'-w'"},
        {"--", NULL, "--"},
        {"--workers", NULL, "--workers needs a value"},
        {"--workers -1", NULL, "--workers must be a whole number from 0 to 1024, got '-1'"},
        {"--workers 1.5", NULL, "--workers"},
        {"--workers 1025", NULL, "--workers"},
        {"--workers 2x", NULL, "--workers"},
        {"--workers=", NULL, "--workers"},
        {"--workers 2K", NULL, "--workers"},
        {"--max-arms 0", NULL, "--max-arms must be a whole number from 1 to 10000000, got '0'"},
        {"--max-arms 1e3", NULL, "--max-arms"},
        {"--max-body-bytes 1000", NULL, "--max-body-bytes"},
        {"--max-body-bytes K", NULL, "--max-body-bytes"},
        {"--max-body-bytes 2T", NULL, "--max-body-bytes"},
        {"--drain-seconds nan", NULL, "--drain-seconds must be a number from 0 to 86400"},
        {"--drain-seconds inf", NULL, "--drain-seconds"},
        {"--drain-seconds 1.2.3", NULL, "--drain-seconds"},
        {"--drain-seconds .", NULL, "--drain-seconds"},
        {"--access-log yes", NULL, "on, off or auto"},
        {"--allow-root auto", NULL, "--allow-root must be on or off, got 'auto'"},
        {"--allow-root auto", NULL, "--allow-root must be on or off"},
        {"--listen 8080", NULL, "--listen must be HOST:PORT"},
        {"--listen :8080", NULL, "--listen"},
        {"--listen localhost:", NULL, "--listen"},
        {"--listen localhost:65536", NULL, "--listen"},
        {"--listen localhost:http", NULL, "--listen"},
        {"--listen ::1:8080", NULL, "brackets"},
        {"--listen []:8080", NULL, "--listen"},
        {"--role boss", NULL, "--role must be all, api or worker"},
        {"--store sqlite:", NULL, "--store must be none, sqlite"},
        {"--store /tmp/x", NULL, "--store must be none, sqlite"},
        {"--store mysql://secret@host", NULL, "--store must be none, sqlite"},
        {"--job-lease-seconds 0", NULL, "--job-lease-seconds must be"},
        {"--cache-bytes lots", NULL, "--cache-bytes must be a whole number"},
        {"--help=html", NULL, "--help"},
        {"--version=2", NULL, "--version takes no value"},
        {"--config /nonexistent/file", NULL, "/nonexistent/file: No such file"},
        {"--config /", NULL, "config /: Is a directory"},
        {"", "PENDULUMD_WORKERS=many", "PENDULUMD_WORKERS must be"},
        {"", "PENDULUMD_HELP=1", "PENDULUMD_HELP belongs on the command line"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct srv_config config;
        struct pend_error error;
        enum pend_status status = config_of(&config, bad[i].line, bad[i].variable, NULL, &error);
        CHECK_SAYING(status == PEND_INVALID, "'%s' is accepted", bad[i].line);
        CHECK_SAYING(strstr(error.text, bad[i].word) != NULL, "'%s' says: %s", bad[i].line,
                     error.text);
    }
}

TEST(who_may_frame_the_embed_view_is_anybody_nobody_or_origins) {
    static const char *const good[] = {"*", "none", "https://a.example", "https://*.a.example:8443",
                                       "http://[::1]:8080,https://b.example"};
    static const char *const bad[] = {"a.example",
                                      "https://",
                                      "https://a.example;script-src",
                                      "'self'",
                                      "*,none",
                                      "none,https://a.example",
                                      "https://a.example,",
                                      "https://a.example/path",
                                      "ftp://a.example",
                                      "data:",
                                      ","};
    struct srv_config config;
    struct pend_error error;
    char line[128];
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        snprintf(line, sizeof line, "--frame-ancestors %s", good[i]);
        CHECK_SAYING(config_of(&config, line, NULL, NULL, &error) == PEND_OK, "%s is refused",
                     line);
        CHECK_TEXT(config.frame_ancestors, good[i]);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(line, sizeof line, "--frame-ancestors %s", bad[i]);
        CHECK_SAYING(config_of(&config, line, NULL, NULL, &error) == PEND_INVALID, "%s is taken",
                     line);
        CHECK(strstr(error.text, "frame-ancestors") && strstr(error.text, "https://example.org"));
    }
}

TEST(a_bad_file_is_refused_with_its_line) {
    static const struct {
        const char *text, *word;
    } bad[] = {
        {"max-queue = 1\nnope = 2\n", ":2: there is no option 'nope'"},
        {"\n\nmax-queue\n", ":3: must be 'name = value'"},
        {"max-queue = many\n", ":1: max-queue must be a whole number"},
        {"config = /dev/null\n", ":1: config: a file cannot name another"},
        {"help = 1\n", ":1: help belongs on the command line"},
        {"= 3\n", ":1: there is no option ''"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct srv_config config;
        struct pend_error error;
        char path[64], line[128];
        config_file(path, bad[i].text);
        snprintf(line, sizeof line, "--config %s", path);
        CHECK_SAYING(config_of(&config, line, NULL, NULL, &error) == PEND_INVALID,
                     "'%s' is accepted", bad[i].text);
        CHECK_SAYING(strstr(error.text, bad[i].word) != NULL, "'%s' says: %s", bad[i].text,
                     error.text);
        unlink(path);
    }
}

TEST(a_file_may_lack_its_last_newline_but_not_have_endless_lines) {
    struct srv_config config;
    struct pend_error error;
    char path[64], line[128], text[3000];
    config_file(path, "max-queue = 11");
    snprintf(line, sizeof line, "--config %s", path);
    CHECK(config_of(&config, line, NULL, NULL, &error) == PEND_OK);
    CHECK_INT((long long)config.queue, 11);
    unlink(path);
    memset(text, ' ', sizeof text - 1);
    text[sizeof text - 1] = 0;
    config_file(path, text);
    snprintf(line, sizeof line, "--config %s", path);
    CHECK(config_of(&config, line, NULL, NULL, &error) == PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "too long") != NULL, "%s", error.text);
    unlink(path);
}

TEST(a_drain_that_is_shorter_than_a_computation_gives_a_warning) {
    struct srv_config config;
    struct pend_error error = {.text = ""};
    CHECK(config_of(&config, "", NULL, NULL, &error) == PEND_OK && !config.warning[0]);
    CHECK(config.drain_seconds > config.limits.compute_seconds);
    CHECK(config_of(&config, "--drain-seconds 30", NULL, NULL, &error) == PEND_OK);
    CHECK_SAYING(strstr(config.warning, "drain-seconds is 30, less than max-compute-seconds of 60"),
                 "%s", config.warning);
    CHECK(config_of(&config, "--max-compute-seconds 600", NULL, NULL, &error) == PEND_OK &&
          config.warning[0]);
    /* a worker process answers no computation */
    CHECK(config_of(&config, "--role worker --drain-seconds 5", NULL, NULL, &error) == PEND_OK &&
          !config.warning[0]);
}

TEST(a_variable_that_names_no_option_gives_a_warning) {
    struct srv_config config;
    struct pend_error error;
    REQUIRE(config_of(&config, "", "PENDULUMD_LISTN=x", "PENDULUM_LISTEN=y", &error) == PEND_OK);
    CHECK_TEXT(config.warning, "PENDULUMD_LISTN is not an option and is ignored");
    REQUIRE(config_of(&config, "", "PENDULUMD_MAX_QUEUE=2", NULL, &error) == PEND_OK);
    CHECK_TEXT(config.warning, "");
    CHECK_INT((long long)config.queue, 2);
}

TEST(help_and_version_are_tasks) {
    struct srv_config config;
    struct pend_error error;
    CHECK(config_of(&config, "--help", NULL, NULL, &error) == PEND_OK &&
          config.task == SRV_CONFIG_HELP);
    CHECK(config_of(&config, "--version", NULL, NULL, &error) == PEND_OK &&
          config.task == SRV_CONFIG_VERSION);
    CHECK(config_of(&config, "--help=markdown", NULL, NULL, &error) == PEND_OK &&
          config.task == SRV_CONFIG_TABLE);
    CHECK(config_of(&config, "--version --config /nonexistent", NULL, NULL, &error) == PEND_OK);
}

TEST(the_help_tells_every_option_and_the_limits) {
    OWN(api_buffer, clear) text;
    struct srv_option row;
    api_buffer_init(&text, 65536);
    REQUIRE(srv_config_help(&text) == PEND_OK && api_buffer_add(&text, "", 1) == PEND_OK);
    int rows = 0;
    for (; srv_config_row(rows, &row); rows++) {
        char name[80];
        snprintf(name, sizeof name, "\n  --%s ", row.name);
        CHECK_SAYING(strstr(text.data, name) && strstr(text.data, row.meaning), "no %s", row.name);
    }
    for (int i = 0; api_limits_row(i); i++)
        CHECK(strstr(text.data, api_limits_row(i)->name) != NULL);
    CHECK(rows > 20);
}

TEST(the_readme_has_the_table_of_options) {
    OWN(api_buffer, clear) table = {0};
    static char readme[131072];
    FILE *file = fopen("docker/README.md", "re");
    if (!file) {
        test_skip("this is not the top of the source tree");
        return;
    }
    readme[fread(readme, 1, sizeof readme - 1, file)] = 0;
    fclose(file);
    api_buffer_init(&table, 65536);
    REQUIRE(srv_config_table(&table) == PEND_OK && api_buffer_add(&table, "", 1) == PEND_OK);
    CHECK_SAYING(strstr(readme, table.data) != NULL,
                 "docker/README.md does not have the table that build/release/pendulumd "
                 "--help=markdown prints");
}

TEST(the_readme_names_what_a_reload_may_change) {
    static char readme[131072];
    struct srv_option row;
    FILE *file = fopen("server/README.md", "re");
    if (!file) {
        test_skip("this is not the top of the source tree");
        return;
    }
    readme[fread(readme, 1, sizeof readme - 1, file)] = 0;
    fclose(file);
    char *text = strstr(readme, "\nSIGHUP reads them again");
    REQUIRE(text != NULL);
    *strstr(text, "another one that has changed") = 0;
    for (int i = 0; srv_config_row(i, &row); i++) {
        char quoted[64];
        snprintf(quoted, sizeof quoted, "`%s`", row.name);
        int limit = i >= 0 && !strstr(text, quoted) && srv_reload_may(row.name);
        const struct api_limit_row *of_requests;
        for (int k = 0; limit && (of_requests = api_limits_row(k)); k++)
            limit = strcmp(of_requests->name, row.name) != 0;
        int of_jobs = !strncmp(row.name, "max-job-", 8);
        CHECK_SAYING(of_jobs || !limit, "%s may change, and server/README.md does not say so",
                     row.name);
        CHECK_SAYING(!strstr(text, quoted) || srv_reload_may(row.name), "%s wants a restart",
                     row.name);
    }
}

#include "server/base/config.h"

#include <ctype.h>
#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/hosts.h"

/* What a value may be. */
enum config_kind {
    CONFIG_FLAG,    /* no value: asks for a task */
    CONFIG_LISTEN,  /* HOST:PORT */
    CONFIG_TEXT,    /* anything */
    CONFIG_WHOLE,   /* a whole number */
    CONFIG_BYTES,   /* a whole number, or one with K, M or G behind it */
    CONFIG_SECONDS, /* a number */
    CONFIG_SWITCH,  /* on, off or auto */
    CONFIG_HOSTS,   /* *, auto or a list of hosts */
    CONFIG_ROLE,    /* all, api or worker */
    CONFIG_STORE    /* none, sqlite, sqlite:PATH or postgresql://... */
};

struct config_row {
    struct srv_option option;
    enum config_kind kind;
    size_t offset; /* in struct srv_config: of a text or a double */
    double least, most;
};

enum { CONFIG_LINE = 1024 };

/* clang-format off */
#define FIELD(name) offsetof(struct srv_config, name)
static const struct config_row config_table[] = {
    {{"listen", "HOST:PORT", "127.0.0.1:8080", "where to serve; port 0 takes a free one, [::1]:8080 is IPv6, *:8080 every address"},
     CONFIG_LISTEN, FIELD(listen), 0, 0},
    {{"config", "FILE", "", "a file with lines 'name = value', the names as in this list; # begins a comment"},
     CONFIG_TEXT, FIELD(file), 0, 0},
    {{"workers", "N", "0", "threads that compute; 0 = one a processor"},
     CONFIG_WHOLE, FIELD(workers), 0, 1024},
    {{"role", "ROLE", "all", "what this process does: all, api = it answers but computes no jobs, worker = it computes jobs and nothing else"},
     CONFIG_ROLE, FIELD(role), 0, 0},
    {{"until-idle-seconds", "S", "0", "a process that computes jobs ends when it found nothing to compute for so long, as batch schedulers want it; 0 = never"},
     CONFIG_SECONDS, FIELD(until_idle_seconds), 0, 86400},
    {{"store", "URL", "sqlite", "where jobs are kept: sqlite:PATH, sqlite = a file in the user's state directory, postgresql://..., or none"},
     CONFIG_STORE, FIELD(store), 0, 0},
    {{"cache-bytes", "BYTES", "64M", "memory for answers that can be given again; 0 = none"},
     CONFIG_BYTES, FIELD(cache_bytes), 0, 1e15},
    {{"compress-above", "BYTES", "4K", "answers of text that are larger are compressed for clients that accept it; 0 = none is"},
     CONFIG_BYTES, FIELD(compress_above), 0, 1e15},
    {{"hosts", "LIST", "auto", "names it answers to, others get 421: * = any, hosts like example.org, *.example.org or [::1]:8080, or auto = this machine's names where it listens on loopback and trusts no proxy, else any"},
     CONFIG_HOSTS, FIELD(hosts), 0, 0},
    {{"cors-origins", "LIST", "*", "web pages of other origins that may read answers: * = all may compute, none, or origins like https://example.org, which may have jobs and scenes too"},
     CONFIG_TEXT, FIELD(cors_origins), 0, 0},
    {{"trusted-proxy", "LIST", "none", "networks like 10.0.0.0/8 of proxies that may say who the client is"},
     CONFIG_TEXT, FIELD(trusted_proxy), 0, 0},
    {{"client-header", "NAME", "X-Forwarded-For", "the header field in which a trusted proxy says it: this, Forwarded, or one whose value is the client's key"},
     CONFIG_TEXT, FIELD(client_header), 0, 0},
    {{"max-connections", "N", "4096", "open connections; one more is answered 503"},
     CONFIG_WHOLE, FIELD(connections), 1, 100000},
    {{"max-client-connections", "N", "0", "open connections of one client that is no trusted proxy; one more is answered 429; 0 = a quarter of max-connections"},
     CONFIG_WHOLE, FIELD(client_connections), 0, 100000},
    {{"max-queue", "N", "256", "requests that wait for a worker; one more is answered 503"},
     CONFIG_WHOLE, FIELD(queue), 1, 1000000},
    {{"max-client-queue", "N", "128", "requests of one client that wait for a worker; one more is answered 429"},
     CONFIG_WHOLE, FIELD(client_queue), 1, 1000000},
    {{"max-wait-seconds", "S", "30", "time that a request may wait for a worker; then it is answered 503"},
     CONFIG_SECONDS, FIELD(wait_seconds), 0.1, 86400},
    {{"max-requests-a-minute", "N", "0", "requests of one client that compute, list, store or delete; one more is answered 429; 0 = any number"},
     CONFIG_WHOLE, FIELD(requests_a_minute), 0, 1000000},
    {{"max-address-clients", "N", "64", "clients with tokens of their own that all of one address or account together are worth: so many times a client's requests a minute, jobs, bytes and scenes, and 16 times so many of them may keep jobs"},
     CONFIG_WHOLE, FIELD(address_clients), 1, 1000000},
        {{"max-held-bytes", "BYTES", "1G", "memory of all connections, bodies, computations, answers, jobs and the cache; what finds none is answered 503"},
     CONFIG_BYTES, FIELD(held_bytes), 1048576, 1e15},
    {{"max-client-held-bytes", "BYTES", "0", "of that what one client may hold; more is answered 429; 0 = a quarter, or 32 MiB beyond max-answer-bytes, half at most"},
     CONFIG_BYTES, FIELD(client_held_bytes), 0, 1e15},
    {{"header-seconds", "S", "10", "time for a request's line and headers, from the first byte to the last"},
     CONFIG_SECONDS, FIELD(header_seconds), 0.1, 3600},
    {{"body-seconds", "S", "30", "time for a request's body, and one second more for every least-rate bytes that came"},
     CONFIG_SECONDS, FIELD(body_seconds), 0.1, 3600},
    {{"send-seconds", "S", "30", "time for the client to take an answer, and one second more for every least-rate bytes of it"},
     CONFIG_SECONDS, FIELD(send_seconds), 0.1, 3600},
    {{"idle-seconds", "S", "60", "time that an open connection may be silent, in whole seconds"},
     CONFIG_WHOLE, FIELD(idle_seconds), 1, 86400},
    {{"least-rate", "BYTES", "16K", "bytes a second that a client must manage on average"},
     CONFIG_BYTES, FIELD(least_rate), 1, 1e12},
    {{"drain-seconds", "S", "65", "time for requests to finish after SIGTERM; more than max-compute-seconds, or a drain may cut a computation short"},
     CONFIG_SECONDS, FIELD(drain_seconds), 0, 86400},
    {{"drain-idle-seconds", "S", "5", "time that silent connections of proxies are kept after SIGTERM, for a request that is just being sent on one"},
     CONFIG_SECONDS, FIELD(drain_idle_seconds), 0, 3600},
    {{"access-log", "on/off/auto", "auto", "one JSON line a request; auto = where they do not go to a terminal"},
     CONFIG_SWITCH, FIELD(access_log), 0, 0},
    {{"log", "FILE", "-", "where the lines of requests go; - = standard output; a file is opened anew at SIGHUP and SIGUSR1"},
     CONFIG_TEXT, FIELD(log), 0, 0},
    {{"record", "DIR", "none", "each request that is computed is written into a file of its own there, without what says who asks, for --replay; up to 1000 files or 256 MiB; none = no request is"},
     CONFIG_TEXT, FIELD(record), 0, 0},
    {{"replay", "FILE", "none", "computes a recorded request again and ends: the answer goes to standard output; exit status 0 where it is the recorded one, 1 where it is not, 2 where the file is damaged"},
     CONFIG_TEXT, FIELD(replay), 0, 0},
    {{"job-part-seconds", "S", "1", "computation after which a part of a job is kept: what a crash repeats at most"},
     CONFIG_SECONDS, FIELD(job_part_seconds), 0.001, 3600},
    {{"job-lease-seconds", "S", "15", "time after which a worker that is not heard of loses its part of a job to another"},
     CONFIG_SECONDS, FIELD(job_lease_seconds), 0.5, 3600},
    {{"max-event-streams", "N", "256", "open streams of jobs' events, a quarter of them of one client; one more is answered 503 or 429"},
     CONFIG_WHOLE, FIELD(event_streams), 1, 100000},
    {{"max-client-jobs", "N", "10000", "jobs of one client that have not ended; one more is answered 429"},
     CONFIG_WHOLE, FIELD(client_jobs), 1, 1e9},
    {{"max-client-bytes", "BYTES", "4G", "what is kept for jobs of one client: rows, requests, results; beyond it jobs fail and new ones are answered 429"},
     CONFIG_BYTES, FIELD(client_bytes), 65536, 1e15},
    {{"max-store-bytes", "BYTES", "16G", "what is kept for jobs of all clients; beyond it jobs fail and new ones are answered 429"},
     CONFIG_BYTES, FIELD(store_bytes), 65536, 1e15},
    {{"keep-seconds", "S", "604800", "time that a job and its results are kept after its end"},
     CONFIG_SECONDS, FIELD(keep_seconds), 1, 1e9},
    {{"max-client-scenes", "N", "10000", "scenes of one client, which are kept for ever; one more is answered 429"},
     CONFIG_WHOLE, FIELD(client_scenes), 1, 1e9},
    {{"max-client-scene-bytes", "BYTES", "64M", "scenes of one client together; one more is answered 429"},
     CONFIG_BYTES, FIELD(client_scene_bytes), 65536, 1e15},
    {{"max-store-scene-bytes", "BYTES", "1G", "scenes of all clients together; one more is answered 429"},
     CONFIG_BYTES, FIELD(store_scene_bytes), 65536, 1e15},
    {{"max-scene-bytes", "BYTES", "256K", "a scene, without blanks; a larger one is answered 413"},
     CONFIG_BYTES, FIELD(scene_bytes), 1024, 1e9},
    {{"max-job-members", "N", "100000000", "members of an ensemble that is a job"},
     CONFIG_WHOLE, FIELD(job_members), 1, 1e9},
    {{"max-job-samples", "N", "20000000", "instants of a trajectory, or states of a request, that is a job"},
     CONFIG_WHOLE, FIELD(job_samples), 1, 1e9},
    {{"max-job-steps", "N", "10000000000", "integration steps of a trajectory, or of one part of another job"},
     CONFIG_WHOLE, FIELD(job_steps), 100, 1e12},
    {{"max-job-seconds", "S", "86400", "computation of a job as it is estimated, and of any part of it"},
     CONFIG_SECONDS, FIELD(job_seconds), 1, 1e7},
    {{"help", NULL, "", "prints this list and ends; --help=markdown prints it as a table"},
     CONFIG_FLAG, 0, 0, 0},
    {{"version", NULL, "", "prints the version and ends"},
     CONFIG_FLAG, 0, 0, 0},
};
/* clang-format on */

enum { CONFIG_OWN = sizeof config_table / sizeof *config_table };

/* the row of a limit, made from its line in api/base/limits.h; offset is its number there */
static struct config_row config_limit(const struct api_limit_row *limit, int i) {
    int bytes = !strcmp(limit->unit, "bytes"), seconds = !strcmp(limit->unit, "s");
    struct config_row row = {.kind = bytes     ? CONFIG_BYTES
                                     : seconds ? CONFIG_SECONDS
                                               : CONFIG_WHOLE,
                             .offset = (size_t)i,
                             .least = limit->least,
                             .most = limit->most};
    row.option = (struct srv_option){limit->name,
                                     bytes     ? "BYTES"
                                     : seconds ? "S"
                                               : "N",
                                     "", limit->meaning};
    snprintf(row.option.start, sizeof row.option.start, "%.15g", limit->start);
    return row;
}

/* row i of the whole table; 0 beyond its end */
static int config_at(int i, struct config_row *row) {
    if (i < CONFIG_OWN) {
        *row = config_table[i];
        return 1;
    }
    const struct api_limit_row *limit = api_limits_row(i - CONFIG_OWN);
    if (limit) *row = config_limit(limit, i - CONFIG_OWN);
    return limit != NULL;
}

/* the row of a name, its number in *i; 0 if there is none */
static int config_find(const char *name, size_t bytes, int *i, struct config_row *row) {
    for (*i = 0; config_at(*i, row); ++*i)
        if (strlen(row->option.name) == bytes && !memcmp(row->option.name, name, bytes)) return 1;
    return 0;
}

int srv_config_row(int i, struct srv_option *row) {
    struct config_row found;
    if (!config_at(i, &found)) return 0;
    *row = found.option;
    return 1;
}

static double *config_number(struct srv_config *config, const struct config_row *row, int i) {
    if (i >= CONFIG_OWN) return api_limits_value(&config->limits, (int)row->offset);
    return (double *)((char *)config + row->offset);
}

/* where the value of option i is, and how many bytes it takes; 0 bytes for what has none */
static char *config_value(struct srv_config *config, int i, size_t *bytes) {
    struct config_row row;
    *bytes = 0;
    if (!config_at(i, &row) || row.kind == CONFIG_FLAG) return NULL;
    int number = row.kind == CONFIG_WHOLE || row.kind == CONFIG_BYTES || row.kind == CONFIG_SECONDS;
    *bytes = number || row.kind == CONFIG_SWITCH ? sizeof(double) : SRV_CONFIG_TEXT;
    return *bytes == sizeof(double) ? (char *)config_number(config, &row, i)
                                    : (char *)config + row.offset;
}

void srv_config_take(struct srv_config *config, const struct srv_config *from, int i) {
    size_t bytes;
    char *to = config_value(config, i, &bytes);
    if (bytes) memcpy(to, config_value((struct srv_config *)from, i, &bytes), bytes);
}

int srv_config_same(const struct srv_config *one, const struct srv_config *other, int i) {
    size_t bytes;
    const char *first = config_value((struct srv_config *)one, i, &bytes);
    const char *second = config_value((struct srv_config *)other, i, &bytes);
    if (bytes == sizeof(double)) return !memcmp(first, second, bytes);
    return !bytes || !strcmp(first, second);
}

/* Where a value was found, for messages: "--workers", "PENDULUMD_WORKERS", "pendulumd.conf:3:
 * workers". */
struct config_place {
    char text[SRV_CONFIG_TEXT + 64];
};

static enum pend_status config_wrong(const struct config_place *place, const char *value,
                                     const char *right, struct pend_error *error) {
    return pend_fail(error, PEND_INVALID, -1, 0, "%.80s must be %.110s, got '%.40s'", place->text,
                     right, value);
}

/* a decimal number with nothing before or behind it; digits and one point only, so that nan, 0x10
 * and 1e3 are refused
 */
static int config_read(const char *text, size_t bytes, int whole, double *out) {
    char copy[32];
    size_t points = 0, digits = 0;
    for (size_t i = 0; i < bytes; i++) {
        points += text[i] == '.';
        digits += isdigit((unsigned char)text[i]) != 0;
    }
    if (!digits || digits + points != bytes || points > !whole || bytes >= sizeof copy) return 0;
    memcpy(copy, text, bytes);
    copy[bytes] = 0;
    *out = strtod(copy, NULL);
    return 1;
}

static double config_unit(char c) {
    c = (char)toupper((unsigned char)c);
    return c == 'K' ? 1024.0 : c == 'M' ? 1024.0 * 1024 : c == 'G' ? 1024.0 * 1024 * 1024 : 1;
}

static enum pend_status config_set_number(double *out, const struct config_row *row,
                                          const struct config_place *place, const char *value,
                                          struct pend_error *error) {
    size_t bytes = strlen(value);
    double unit = row->kind == CONFIG_BYTES && bytes ? config_unit(value[bytes - 1]) : 1,
           number = 0;
    int good = config_read(value, bytes - (unit > 1), row->kind != CONFIG_SECONDS, &number);
    number *= unit;
    if (good && number >= row->least && number <= row->most) {
        *out = number;
        return PEND_OK;
    }
    char right[120];
    snprintf(right, sizeof right, "a %snumber%s from %.15g to %.15g",
             row->kind == CONFIG_SECONDS ? "" : "whole ",
             row->kind == CONFIG_BYTES ? " (K, M or G may follow)" : "", row->least, row->most);
    return config_wrong(place, value, right, error);
}

/* HOST:PORT with a port from 0 to 65535; whether the host exists is seen when it is bound */
static int config_listen_good(const char *value) {
    const char *colon = strrchr(value, ':');
    double port;
    if (!colon || colon == value || !config_read(colon + 1, strlen(colon + 1), 1, &port) ||
        port > 65535)
        return 0;
    if (value[0] == '[') return colon[-1] == ']' && colon - value > 2;
    return !memchr(value, ':', (size_t)(colon - value));
}

static enum pend_status config_set_text(char *out, const struct config_row *row,
                                        const struct config_place *place, const char *value,
                                        struct pend_error *error) {
    if (row->kind == CONFIG_LISTEN && !config_listen_good(value))
        return config_wrong(
            place, value, "HOST:PORT with a port from 0 to 65535, an IPv6 host in brackets", error);
    if (!*value || strlen(value) >= SRV_CONFIG_TEXT)
        return config_wrong(place, value, "a text of 1 to 255 bytes", error);
    strcpy(out, value);
    return PEND_OK;
}

/* what is wrong with it is told without the value: it may hold a password */
static enum pend_status config_set_store(char *out, const struct config_row *row,
                                         const struct config_place *place, const char *value,
                                         struct pend_error *error) {
    int good = !strcmp(value, "none") || !strcmp(value, "sqlite") ||
               (!strncmp(value, "sqlite:", 7) && value[7]) || !strncmp(value, "postgresql://", 13);
    if (!good || strlen(value) >= SRV_CONFIG_TEXT)
        return pend_fail(
            error, PEND_INVALID, -1, 0,
            "%.80s must be none, sqlite, sqlite:PATH or postgresql://..., of less than 256 bytes",
            place->text);
    return config_set_text(out, row, place, value, error);
}

static enum pend_status config_set_switch(double *out, const struct config_place *place,
                                          const char *value, struct pend_error *error) {
    int automatic = !strcmp(value, "auto");
    if (!automatic && strcmp(value, "on") && strcmp(value, "off"))
        return config_wrong(place, value, "on, off or auto", error);
    *out = automatic ? SRV_CONFIG_AUTO : !strcmp(value, "on");
    return PEND_OK;
}

/* sets one option; i is the row's number */
static enum pend_status config_set(struct srv_config *config, const struct config_row *row, int i,
                                   const struct config_place *place, const char *value,
                                   struct pend_error *error) {
    switch (row->kind) {
    case CONFIG_LISTEN:
    case CONFIG_TEXT:
        return config_set_text((char *)config + row->offset, row, place, value, error);
    case CONFIG_WHOLE:
    case CONFIG_BYTES:
    case CONFIG_SECONDS:
        return config_set_number(config_number(config, row, i), row, place, value, error);
    case CONFIG_SWITCH:
        return config_set_switch(config_number(config, row, i), place, value, error);
    case CONFIG_HOSTS:
        if (!srv_hosts_good(value))
            return config_wrong(
                place, value,
                "*, auto, or hosts like example.org, *.example.org, 192.0.2.1, [::1]:8080", error);
        return config_set_text((char *)config + row->offset, row, place, value, error);
    case CONFIG_ROLE:
        if (strcmp(value, "all") && strcmp(value, "api") && strcmp(value, "worker"))
            return config_wrong(place, value, "all, api or worker", error);
        return config_set_text((char *)config + row->offset, row, place, value, error);
    case CONFIG_STORE:
        return config_set_store((char *)config + row->offset, row, place, value, error);
    case CONFIG_FLAG:
        break;
    }
    return pend_fail(error, PEND_INVALID, -1, 0, "%.80s belongs on the command line", place->text);
}

static enum pend_status config_defaults(struct srv_config *config) {
    struct config_row row;
    struct config_place place;
    *config = (struct srv_config){.task = SRV_CONFIG_SERVE};
    for (int i = 0; config_at(i, &row); i++) {
        if (row.kind == CONFIG_FLAG || !row.option.start[0]) continue;
        snprintf(place.text, sizeof place.text, "the default of %s", row.option.name);
        PEND_TRY(config_set(config, &row, i, &place, row.option.start, NULL));
    }
    return PEND_OK;
}

/* cuts blanks from both ends, in place */
static char *config_trim(char *text) {
    while (isspace((unsigned char)*text)) text++;
    size_t bytes = strlen(text);
    while (bytes && isspace((unsigned char)text[bytes - 1])) bytes--;
    text[bytes] = 0;
    return text;
}

static enum pend_status config_line(struct srv_config *config, char *line, int number,
                                    const char *path, struct pend_error *error) {
    line[strcspn(line, "#")] = 0;
    char *name = config_trim(line), *equals = strchr(name, '=');
    struct config_place place;
    struct config_row row;
    int i;
    if (!*name) return PEND_OK;
    snprintf(place.text, sizeof place.text, "%.48s:%d:", path, number);
    if (!equals)
        return pend_fail(error, PEND_INVALID, -1, 0, "%s must be 'name = value'", place.text);
    *equals = 0;
    name = config_trim(name);
    if (!config_find(name, strlen(name), &i, &row))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "%s there is no option '%.60s'; --help lists them", place.text, name);
    snprintf(place.text, sizeof place.text, "%.48s:%d: %s", path, number, name);
    if (row.offset == FIELD(file) && row.kind == CONFIG_TEXT)
        return pend_fail(error, PEND_INVALID, -1, 0, "%s: a file cannot name another file",
                         place.text);
    return config_set(config, &row, i, &place, config_trim(equals + 1), error);
}

static enum pend_status config_load_file(struct srv_config *config, const char *path,
                                         struct pend_error *error) {
    char line[CONFIG_LINE];
    enum pend_status status = PEND_OK;
    FILE *file = fopen(path, "re");
    if (!file)
        return pend_fail(error, PEND_INVALID, -1, 0, "config %.120s: %s", path, strerror(errno));
    for (int number = 1; status == PEND_OK && fgets(line, sizeof line, file); number++) {
        int whole = strchr(line, '\n') || feof(file);
        status = whole ? config_line(config, line, number, path, error)
                       : pend_fail(error, PEND_INVALID, -1, 0, "%.120s:%d: the line is too long",
                                   path, number);
    }
    if (status == PEND_OK && ferror(file))
        status = pend_fail(error, PEND_INVALID, -1, 0, "config %.120s: %s", path, strerror(errno));
    fclose(file);
    return status;
}

/* LISTEN of PENDULUMD_LISTEN=... as an option's name: listen; returns where the value begins,
 * NULL if it is none */
static const char *config_variable(const char *entry, char name[64]) {
    static const char prefix[] = "PENDULUMD_";
    size_t i = 0;
    if (strncmp(entry, prefix, sizeof prefix - 1)) return NULL;
    const char *at = entry + sizeof prefix - 1;
    for (; *at && *at != '=' && i < 63; at++)
        name[i++] = *at == '_' ? '-' : (char)tolower((unsigned char)*at);
    name[i] = 0;
    return *at == '=' ? at + 1 : NULL;
}

/* sets what the environment sets; with only_file nothing but the option config */
static enum pend_status config_load_environment(struct srv_config *config,
                                                char *const environment[], int only_file,
                                                struct pend_error *error) {
    for (int e = 0; environment && environment[e]; e++) {
        struct config_place place;
        struct config_row row;
        char name[64];
        int i;
        const char *value = config_variable(environment[e], name);
        if (!value) continue;
        int length = (int)(value - 1 - environment[e]),
            found = config_find(name, strlen(name), &i, &row);
        if (!found && !config->warning[0])
            snprintf(config->warning, sizeof config->warning,
                     "%.*s names no option and is not looked at", length, environment[e]);
        if (!found || (only_file && strcmp(name, "config"))) continue;
        snprintf(place.text, sizeof place.text, "%.*s", length, environment[e]);
        PEND_TRY(config_set(config, &row, i, &place, value, error));
    }
    return PEND_OK;
}

/* the task a flag asks for */
static enum pend_status config_flag(struct srv_config *config, const char *name, const char *value,
                                    struct pend_error *error) {
    int help = !strcmp(name, "help");
    if (value && !(help && !strcmp(value, "markdown")))
        return pend_fail(error, PEND_INVALID, -1, 0, "--%s takes no value%s", name,
                         help ? " but markdown" : "");
    if (config->task == SRV_CONFIG_SERVE)
        config->task = !help ? SRV_CONFIG_VERSION : value ? SRV_CONFIG_TABLE : SRV_CONFIG_HELP;
    return PEND_OK;
}

/* sets what the command line sets; with only_file nothing but the option config */
static enum pend_status config_load_arguments(struct srv_config *config, int argc,
                                              char *const argv[], int only_file,
                                              struct pend_error *error) {
    for (int a = 1; a < argc; a++) {
        struct config_place place;
        struct config_row row;
        int i;
        /* as every program has them */
        if (!strcmp(argv[a], "-h") || !strcmp(argv[a], "-V")) {
            config->task = argv[a][1] == 'h' ? SRV_CONFIG_HELP : SRV_CONFIG_VERSION;
            continue;
        }
        const char *name = argv[a] + 2, *equals = strchr(argv[a], '=');
        if (strncmp(argv[a], "--", 2))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "'%.60s' is no option: options begin with --, and --help lists them",
                             argv[a]);
        size_t bytes = equals ? (size_t)(equals - name) : strlen(name);
        if (!config_find(name, bytes, &i, &row))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "there is no option '%.60s'; --help lists them", argv[a]);
        snprintf(place.text, sizeof place.text, "--%s", row.option.name);
        if (row.kind == CONFIG_FLAG) {
            PEND_TRY(config_flag(config, row.option.name, equals ? equals + 1 : NULL, error));
            continue;
        }
        if (!equals && a + 1 == argc)
            return pend_fail(error, PEND_INVALID, -1, 0, "%s wants a value: %s", place.text,
                             row.option.sample);
        const char *value = equals ? equals + 1 : argv[++a];
        if (only_file && strcmp(row.option.name, "config")) continue;
        PEND_TRY(config_set(config, &row, i, &place, value, error));
    }
    return PEND_OK;
}

/* values that are good each by itself and odd together */
static void config_weigh(struct srv_config *config) {
    if (config->warning[0] || !srv_config_answers(config) ||
        config->drain_seconds >= config->limits.compute_seconds)
        return;
    snprintf(config->warning, sizeof config->warning,
             "drain-seconds is %.15g, less than max-compute-seconds of %.15g: a longer computation "
             "is cut short when this "
             "process is told to end; it is to be larger",
             config->drain_seconds, config->limits.compute_seconds);
}

enum pend_status srv_config_load(struct srv_config *config, int argc, char *const argv[],
                                 char *const environment[], struct pend_error *error) {
    PEND_TRY(config_defaults(config));
    /* the file comes before the others, but they name it */
    PEND_TRY(config_load_environment(config, environment, 1, error));
    PEND_TRY(config_load_arguments(config, argc, argv, 1, error));
    if (config->task != SRV_CONFIG_SERVE) return PEND_OK;
    if (config->file[0]) PEND_TRY(config_load_file(config, config->file, error));
    PEND_TRY(config_load_environment(config, environment, 0, error));
    PEND_TRY(config_load_arguments(config, argc, argv, 0, error));
    if (strcmp(config->replay, "none")) config->task = SRV_CONFIG_REPLAY;
    config_weigh(config);
    return PEND_OK;
}

int srv_config_answers(const struct srv_config *config) {
    return strcmp(config->role, "worker") != 0;
}

int srv_config_works(const struct srv_config *config) { return strcmp(config->role, "api") != 0; }

static double config_wider(double of_requests, double of_jobs) {
    return of_requests > of_jobs ? of_requests : of_jobs;
}

struct api_limits srv_config_job_limits(const struct srv_config *config) {
    struct api_limits limits = config->limits;
    limits.of_jobs = 1;
    limits.members = config_wider(limits.members, config->job_members);
    limits.samples = config_wider(limits.samples, config->job_samples);
    limits.steps = config_wider(limits.steps, config->job_steps);
    limits.compute_seconds = config_wider(limits.compute_seconds, config->job_seconds);
    return limits;
}

#include "server/config/config_load.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/job_json.h"
#include "server/config/hosts.h"
#include "server/sandbox/secret.h"

enum {
    LOAD_LINE = 1024, /* bytes of a line of the file */
    LOAD_UNIX = 104   /* bytes of a socket's path with its NUL */
};

/* The place of a value, for messages: "--workers", "PENDULUMD_WORKERS", "pendulumd.conf:3:
 * workers". */
struct load_place {
    char text[SRV_CONFIG_TEXT + 64];
};

static enum pend_status load_wrong(const struct load_place *place, const char *value,
                                   const char *right, struct pend_error *error) {
    return pend_fail(error, PEND_INVALID, -1, 0, "%.80s must be %.110s, got '%.40s'", place->text,
                     right, value);
}

/* parses a decimal number: digits and one point only, so that nan, 0x10 and 1e3 are refused */
static int load_read(const char *text, size_t bytes, int whole, double *out) {
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

static double load_unit(char c) {
    c = (char)toupper((unsigned char)c);
    return c == 'K' ? 1024.0 : c == 'M' ? 1024.0 * 1024 : c == 'G' ? 1024.0 * 1024 * 1024 : 1;
}

static enum pend_status load_set_number(double *out, const struct srv_option *row,
                                        const struct load_place *place, const char *value,
                                        struct pend_error *error) {
    size_t bytes = strlen(value);
    double unit = row->kind == SRV_OPTION_BYTES && bytes ? load_unit(value[bytes - 1]) : 1,
           number = 0;
    int good = load_read(value, bytes - (unit > 1), row->kind != SRV_OPTION_SECONDS, &number);
    number *= unit;
    if (good && number >= row->least && number <= row->most) {
        *out = number;
        return PEND_OK;
    }
    char right[120];
    snprintf(right, sizeof right, "a %snumber%s from %.15g to %.15g",
             row->kind == SRV_OPTION_SECONDS ? "" : "whole ",
             row->kind == SRV_OPTION_BYTES ? " (K, M or G may follow)" : "", row->least, row->most);
    return load_wrong(place, value, right, error);
}

/* HOST:PORT with a port from 0 to 65535, or unix:PATH; whether the host or the directory exists is
 * seen when it is bound */
static int load_listen_good(const char *value) {
    if (!strncmp(value, "unix:", 5)) return value[5] && strlen(value + 5) < LOAD_UNIX;
    const char *colon = strrchr(value, ':');
    double port;
    if (!colon || colon == value || !load_read(colon + 1, strlen(colon + 1), 1, &port) ||
        port > 65535)
        return 0;
    if (value[0] == '[') return colon[-1] == ']' && colon - value > 2;
    return !memchr(value, ':', (size_t)(colon - value));
}

/* *, none, or origins separated by commas; only characters of an origin are valid, since the list
 * becomes part of a header */
static int load_frames_good(const char *list) {
    static const char host[] = "abcdefghijklmnopqrstuvwxyz0123456789-.:*[]";
    if (strlen(list) >= SRV_CONFIG_TEXT) return 0;
    if (!strcmp(list, "*") || !strcmp(list, "none")) return 1;
    for (;;) {
        list += strspn(list, " ");
        size_t scheme = strcspn(list, ":");
        if ((scheme != 5 || strncmp(list, "https", 5)) && (scheme != 4 || strncmp(list, "http", 4)))
            return 0;
        list += scheme;
        if (strncmp(list, "://", 3)) return 0;
        size_t bytes = strspn(list + 3, host);
        if (!bytes) return 0;
        list += 3 + bytes;
        list += strspn(list, " ");
        if (!*list) return 1;
        if (*list++ != ',') return 0;
    }
}

/* returns the valid words of a kind, if the value is not one of them; NULL if the value is valid or
 * the kind has no words */
static const char *load_word_right(enum srv_option_kind kind, const char *value) {
    if (kind == SRV_OPTION_ROLE && strcmp(value, "all") && strcmp(value, "api") &&
        strcmp(value, "worker"))
        return "all, api or worker";
    if (kind == SRV_OPTION_CLIENT && strcmp(value, "full") && strcmp(value, "network") &&
        strcmp(value, "none"))
        return "full, network or none";
    return NULL;
}

/* describes the valid texts of a kind if the value is invalid; NULL if it is valid */
static const char *load_text_right(enum srv_option_kind kind, const char *value) {
    const char *right = load_word_right(kind, value);
    int64_t us;
    if (right) return right;
    if (kind == SRV_OPTION_LISTEN && !load_listen_good(value))
        return "HOST:PORT with a port from 0 to 65535, an IPv6 host in brackets, or unix:PATH";
    if (kind == SRV_OPTION_HOSTS && !srv_hosts_good(value))
        return "*, auto, or hosts like example.org, *.example.org, 192.0.2.1, [::1]:8080";
    if (kind == SRV_OPTION_INSTANT && strcmp(value, "none") && !api_job_instant(value, &us))
        return "none, or an instant like 2027-01-31T00:00:00Z";
    if (kind == SRV_OPTION_FRAMES && !load_frames_good(value))
        return "*, none, or origins like https://example.org, https://*.example.org";
    return *value && strlen(value) < SRV_CONFIG_TEXT ? NULL : "a text of 1 to 255 bytes";
}

static enum pend_status load_set_text(char *out, const struct srv_option *row,
                                      const struct load_place *place, const char *value,
                                      struct pend_error *error) {
    const char *right = load_text_right(row->kind, value);
    if (right) return load_wrong(place, value, right, error);
    strcpy(out, value);
    return PEND_OK;
}

/* the message does not quote the value, which may contain a password */
static enum pend_status load_set_store(char *out, const struct srv_option *row,
                                       const struct load_place *place, const char *value,
                                       struct pend_error *error) {
    int good = !strcmp(value, "none") || !strcmp(value, "sqlite") ||
               (!strncmp(value, "sqlite:", 7) && value[7]) || !strncmp(value, "postgresql://", 13);
    if (!good || strlen(value) >= SRV_CONFIG_TEXT)
        return pend_fail(
            error, PEND_INVALID, -1, 0,
            "%.80s must be none, sqlite, sqlite:PATH or postgresql://..., of less than 256 bytes",
            place->text);
    return load_set_text(out, row, place, value, error);
}

/* sets a switch; `auto` is valid only if the sample in its row contains it */
static enum pend_status load_set_switch(double *out, const struct srv_option *row,
                                        const struct load_place *place, const char *value,
                                        struct pend_error *error) {
    int may = strstr(row->sample, "auto") != NULL, automatic = may && !strcmp(value, "auto");
    if (!automatic && strcmp(value, "on") && strcmp(value, "off"))
        return load_wrong(place, value, may ? "on, off or auto" : "on or off", error);
    *out = automatic ? SRV_CONFIG_AUTO : !strcmp(value, "on");
    return PEND_OK;
}

static enum pend_status load_set(struct srv_config *config, const struct srv_option *row, int i,
                                 const struct load_place *place, const char *value,
                                 struct pend_error *error) {
    size_t bytes;
    void *out = srv_config_value(config, i, &bytes);
    switch (row->kind) {
    case SRV_OPTION_LISTEN:
    case SRV_OPTION_FILE:
    case SRV_OPTION_TEXT:
    case SRV_OPTION_HOSTS:
    case SRV_OPTION_FRAMES:
    case SRV_OPTION_INSTANT:
    case SRV_OPTION_ROLE:
    case SRV_OPTION_CLIENT:
        return load_set_text(out, row, place, value, error);
    case SRV_OPTION_WHOLE:
    case SRV_OPTION_BYTES:
    case SRV_OPTION_SECONDS:
        return load_set_number(out, row, place, value, error);
    case SRV_OPTION_SWITCH:
        return load_set_switch(out, row, place, value, error);
    case SRV_OPTION_STORE:
        return load_set_store(out, row, place, value, error);
    case SRV_OPTION_FLAG:
        break;
    }
    return pend_fail(error, PEND_INVALID, -1, 0, "%.80s belongs on the command line", place->text);
}

static enum pend_status load_defaults(struct srv_config *config) {
    struct srv_option row;
    struct load_place place;
    *config = (struct srv_config){.task = SRV_CONFIG_SERVE};
    for (int i = 0; srv_config_row(i, &row); i++) {
        if (row.kind == SRV_OPTION_FLAG || !row.start[0]) continue;
        snprintf(place.text, sizeof place.text, "the default of %s", row.name);
        PEND_TRY(load_set(config, &row, i, &place, row.start, NULL));
    }
    return PEND_OK;
}

/* cuts blanks from both ends, in place */
static char *load_trim(char *text) {
    while (isspace((unsigned char)*text)) text++;
    size_t bytes = strlen(text);
    while (bytes && isspace((unsigned char)text[bytes - 1])) bytes--;
    text[bytes] = 0;
    return text;
}

static enum pend_status load_line(struct srv_config *config, char *line, int number,
                                  const char *path, struct pend_error *error) {
    line[strcspn(line, "#")] = 0;
    char *name = load_trim(line), *equals = strchr(name, '=');
    struct load_place place;
    struct srv_option row;
    int i;
    if (!*name) return PEND_OK;
    snprintf(place.text, sizeof place.text, "%.48s:%d:", path, number);
    if (!equals)
        return pend_fail(error, PEND_INVALID, -1, 0, "%s must be 'name = value'", place.text);
    *equals = 0;
    name = load_trim(name);
    if (!srv_config_find(name, strlen(name), &i, &row))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "%s there is no option '%.60s'; --help lists them", place.text, name);
    snprintf(place.text, sizeof place.text, "%.48s:%d: %s", path, number, name);
    if (row.kind == SRV_OPTION_FILE)
        return pend_fail(error, PEND_INVALID, -1, 0, "%s: a file cannot name another file",
                         place.text);
    return load_set(config, &row, i, &place, load_trim(equals + 1), error);
}

static enum pend_status load_file(struct srv_config *config, const char *path,
                                  struct pend_error *error) {
    char line[LOAD_LINE];
    enum pend_status status = PEND_OK;
    FILE *file = fopen(path, "re");
    if (!file)
        return pend_fail(error, PEND_INVALID, -1, 0, "config %.120s: %s", path, strerror(errno));
    for (int number = 1; status == PEND_OK && fgets(line, sizeof line, file); number++) {
        int whole = strchr(line, '\n') || feof(file);
        status = whole ? load_line(config, line, number, path, error)
                       : pend_fail(error, PEND_INVALID, -1, 0, "%.120s:%d: the line is too long",
                                   path, number);
    }
    if (status == PEND_OK && ferror(file))
        status = pend_fail(error, PEND_INVALID, -1, 0, "config %.120s: %s", path, strerror(errno));
    fclose(file);
    return status;
}

/* converts PENDULUMD_LISTEN=... to the option's name, listen; returns the value, NULL if the
 * variable has another form */
static const char *load_variable(const char *entry, char name[64]) {
    static const char prefix[] = "PENDULUMD_";
    size_t i = 0;
    if (strncmp(entry, prefix, sizeof prefix - 1)) return NULL;
    const char *at = entry + sizeof prefix - 1;
    for (; *at && *at != '=' && i < 63; at++)
        name[i++] = *at == '_' ? '-' : (char)tolower((unsigned char)*at);
    name[i] = 0;
    return *at == '=' ? at + 1 : NULL;
}

/* applies the environment; only_file: only the option config */
static enum pend_status load_environment(struct srv_config *config, char *const environment[],
                                         int only_file, struct pend_error *error) {
    for (int e = 0; environment && environment[e]; e++) {
        struct load_place place;
        struct srv_option row;
        char name[64];
        int i;
        const char *value = load_variable(environment[e], name);
        if (!value) continue;
        int length = (int)(value - 1 - environment[e]),
            found = srv_config_find(name, strlen(name), &i, &row);
        if (!found && !config->warning[0])
            snprintf(config->warning, sizeof config->warning,
                     "%.*s is not an option and is ignored", length, environment[e]);
        if (!found || (only_file && strcmp(name, "config"))) continue;
        snprintf(place.text, sizeof place.text, "%.*s", length, environment[e]);
        PEND_TRY(load_set(config, &row, i, &place, value, error));
    }
    return PEND_OK;
}

static enum pend_status load_flag(struct srv_config *config, const char *name, const char *value,
                                  struct pend_error *error) {
    int help = !strcmp(name, "help");
    if (value && !(help && !strcmp(value, "markdown")))
        return pend_fail(error, PEND_INVALID, -1, 0, "--%s takes no value%s", name,
                         help ? " but markdown" : "");
    if (config->task == SRV_CONFIG_SERVE)
        config->task = !help ? SRV_CONFIG_VERSION : value ? SRV_CONFIG_TABLE : SRV_CONFIG_HELP;
    return PEND_OK;
}

/* applies the command line; only_file: only the option config */
static enum pend_status load_arguments(struct srv_config *config, int argc, char *const argv[],
                                       int only_file, struct pend_error *error) {
    for (int a = 1; a < argc; a++) {
        struct load_place place;
        struct srv_option row;
        int i;
        /* the short options that every program has */
        if (!strcmp(argv[a], "-h") || !strcmp(argv[a], "-V")) {
            config->task = argv[a][1] == 'h' ? SRV_CONFIG_HELP : SRV_CONFIG_VERSION;
            continue;
        }
        const char *name = argv[a] + 2, *equals = strchr(argv[a], '=');
        if (strncmp(argv[a], "--", 2))
            return pend_fail(
                error, PEND_INVALID, -1, 0,
                "'%.60s' is not an option: options begin with --, and --help lists them", argv[a]);
        size_t bytes = equals ? (size_t)(equals - name) : strlen(name);
        if (!srv_config_find(name, bytes, &i, &row))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "there is no option '%.60s'; --help lists them", argv[a]);
        snprintf(place.text, sizeof place.text, "--%s", row.name);
        if (row.kind == SRV_OPTION_FLAG) {
            PEND_TRY(load_flag(config, row.name, equals ? equals + 1 : NULL, error));
            continue;
        }
        if (!equals && a + 1 == argc)
            return pend_fail(error, PEND_INVALID, -1, 0, "%s needs a value: %s", place.text,
                             row.sample);
        const char *value = equals ? equals + 1 : argv[++a];
        if (only_file && strcmp(row.name, "config")) continue;
        PEND_TRY(load_set(config, &row, i, &place, value, error));
    }
    return PEND_OK;
}

/* warns about values that are valid alone but contradict each other */
static void load_weigh(struct srv_config *config) {
    if (config->warning[0] || !srv_config_answers(config) ||
        config->drain_seconds >= config->limits.compute_seconds)
        return;
    snprintf(config->warning, sizeof config->warning,
             "drain-seconds is %.15g, less than max-compute-seconds of %.15g: a longer computation "
             "is cut short when this process stops; set a larger value",
             config->drain_seconds, config->limits.compute_seconds);
}

/* reads the store's url from a file; messages do not quote it, because it may contain a password */
static enum pend_status load_store_file(struct srv_config *config, struct pend_error *error) {
    struct api_buffer text;
    struct srv_option row;
    struct load_place place;
    int i;
    char value[SRV_CONFIG_TEXT] = "";
    api_buffer_init(&text, SRV_CONFIG_TEXT - 1);
    enum pend_status status = srv_secret_read(config->store_file, &text, NULL, error);
    if (text.data && status == PEND_OK) memcpy(value, text.data, text.bytes);
    if (text.data) explicit_bzero(text.data, text.bytes);
    api_buffer_clear(&text);
    PEND_TRY(status);
    snprintf(place.text, sizeof place.text, "the text of %.200s", config->store_file);
    srv_config_find("store", 5, &i, &row);
    status = load_set_store(config->store, &row, &place, load_trim(value), error);
    explicit_bzero(value, sizeof value);
    return status;
}

enum pend_status srv_config_load(struct srv_config *config, int argc, char *const argv[],
                                 char *const environment[], struct pend_error *error) {
    PEND_TRY(load_defaults(config));
    /* the file has the lowest priority, but its path comes from the environment or arguments */
    PEND_TRY(load_environment(config, environment, 1, error));
    PEND_TRY(load_arguments(config, argc, argv, 1, error));
    if (config->task != SRV_CONFIG_SERVE) return PEND_OK;
    if (config->file[0]) PEND_TRY(load_file(config, config->file, error));
    PEND_TRY(load_environment(config, environment, 0, error));
    PEND_TRY(load_arguments(config, argc, argv, 0, error));
    if (strcmp(config->store_file, "none")) PEND_TRY(load_store_file(config, error));
    load_weigh(config);
    return PEND_OK;
}

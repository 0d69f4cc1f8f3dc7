#include "server/keys_command.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "server/keys/key_file.h"

enum { COMMAND_OPTIONS = 5, COMMAND_QUOTA = 256 };

static const char command_usage[] =
    "pendulumd keys add    --keys FILE --name NAME --role ROLE [--quota LIST] [--expires WHEN]\n"
    "pendulumd keys list   --keys FILE\n"
    "pendulumd keys revoke --keys FILE --name NAME\n"
    "pendulumd keys expire --keys FILE --name NAME [--expires WHEN]\n"
    "pendulumd keys remove --keys FILE --name NAME\n"
    "pendulumd keys role   --keys FILE --role ROLE --quota LIST\n"
    "\n"
    "add creates FILE if it does not exist, and prints the key, which is stored nowhere else.\n"
    "NAME  owner of the key: A-Z a-z 0-9 . _ -; revoke, expire and remove also take the first "
    "eight\n"
    "      digits that list shows. Several keys of one name are one client.\n"
    "ROLE  pupil, teacher, batch or operator; for role also anonymous.\n"
    "LIST  requests=N a second, compute=S seconds a minute, memory=BYTES, bytes=BYTES stored for\n"
    "      jobs, jobs=N open ones, priority=0 to 3 levels behind others, rooms=N of classes,\n"
    "      separated by commas; none = no limit. Limits that are left out are those of the role.\n"
    "WHEN  2026-01-31, 2026-01-31T09:30:00Z, 90d (s, m, h, d, w), never or now; without it a new\n"
    "      key does not expire, and expire means now.\n"
    "FILE may be set in the environment as PENDULUMD_KEYS. A server that runs with --keys FILE\n"
    "reads it again within a second.\n";

struct command {
    const char *keys, *name, *role, *quota, *expires;
    char token[SRV_KEY_TOKEN]; /* out: a new key */
    int changed;               /* out: number of changed keys */
    int64_t now;
};

/* --- changes of the file --- */

static enum pend_status command_limits(const struct command *command, struct srv_limits *limits,
                                       struct pend_error *error) {
    char list[COMMAND_QUOTA], *rest = list;
    if (!command->quota) return PEND_OK;
    if (strlen(command->quota) >= sizeof list)
        return pend_fail(error, PEND_INVALID, -1, 0, "the list of --quota is too long");
    snprintf(list, sizeof list, "%s", command->quota);
    for (char *one; (one = strsep(&rest, ","));) PEND_TRY(srv_limits_read(limits, one, error));
    return PEND_OK;
}

static enum pend_status command_when(const struct command *command, const char *text,
                                     int64_t *instant, struct pend_error *error) {
    if (srv_keys_instant(text, command->now, instant)) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "--expires must be 2026-01-31, 2026-01-31T09:30:00Z, a span such as 90d, "
                     "never or now, got '%.40s'",
                     text);
}

static enum pend_status command_add(struct srv_keys *keys, void *context,
                                    struct pend_error *error) {
    struct command *command = context;
    struct srv_key key = {.made = command->now};
    const char *role = command->role ? command->role : "";
    srv_limits_unset(&key.limits);
    key.role = srv_role_of(role, strlen(role));
    if (key.role <= SRV_ROLE_ANONYMOUS)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--role must be pupil, teacher, batch or operator, got '%.40s'", role);
    if (!command->name || !srv_keys_named(command->name))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--name must be 1 to %d of A-Z, a-z, 0-9, '.', '_' and '-', got '%.40s'",
                         SRV_KEY_NAME - 1, command->name ? command->name : "");
    snprintf(key.name, sizeof key.name, "%s", command->name);
    PEND_TRY(command_limits(command, &key.limits, error));
    if (command->expires) PEND_TRY(command_when(command, command->expires, &key.expires, error));
    if (!srv_keys_draw(command->token))
        return pend_fail(error, PEND_INVALID, -1, 0, "the system has no random numbers");
    srv_keys_digest(command->token, key.digest);
    command->changed = 1;
    return srv_keys_add(keys, &key, error);
}

/* the next key from i on that the command refers to; the number of keys if there is none */
static int command_next(const struct command *command, const struct srv_keys *keys, int i) {
    while (i < keys->count && !srv_keys_means(&keys->key[i], command->name)) i++;
    return i;
}

static enum pend_status command_named(const struct command *command, const struct srv_keys *keys,
                                      struct pend_error *error) {
    if (command->name && command_next(command, keys, 0) < keys->count) return PEND_OK;
    return command->name
               ? pend_fail(error, PEND_INVALID, -1, 0,
                           "there is no key '%.40s'; pendulumd keys list shows them", command->name)
               : pend_fail(error, PEND_INVALID, -1, 0, "--name is missing");
}

static enum pend_status command_revoke(struct srv_keys *keys, void *context,
                                       struct pend_error *error) {
    struct command *command = context;
    PEND_TRY(command_named(command, keys, error));
    for (int i = 0; (i = command_next(command, keys, i)) < keys->count; i++) {
        if (!keys->key[i].revoked) keys->key[i].revoked = command->now;
        command->changed++;
    }
    return PEND_OK;
}

static enum pend_status command_expire(struct srv_keys *keys, void *context,
                                       struct pend_error *error) {
    struct command *command = context;
    int64_t when;
    PEND_TRY(command_named(command, keys, error));
    PEND_TRY(command_when(command, command->expires ? command->expires : "now", &when, error));
    for (int i = 0; (i = command_next(command, keys, i)) < keys->count; i++) {
        keys->key[i].expires = when;
        command->changed++;
    }
    return PEND_OK;
}

static enum pend_status command_remove(struct srv_keys *keys, void *context,
                                       struct pend_error *error) {
    struct command *command = context;
    PEND_TRY(command_named(command, keys, error));
    for (int i = 0; (i = command_next(command, keys, i)) < keys->count;) {
        keys->count--;
        memmove(&keys->key[i], &keys->key[i + 1], (size_t)(keys->count - i) * sizeof *keys->key);
        command->changed++;
    }
    return PEND_OK;
}

static enum pend_status command_role(struct srv_keys *keys, void *context,
                                     struct pend_error *error) {
    struct command *command = context;
    const char *word = command->role ? command->role : "";
    enum srv_role role = srv_role_of(word, strlen(word));
    if (role == SRV_ROLE_NONE)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--role must be anonymous, pupil, teacher, batch or operator, got '%.40s'",
                         word);
    if (!command->quota) return pend_fail(error, PEND_INVALID, -1, 0, "--quota is missing");
    return command_limits(command, &keys->role[role], error);
}

/* --- list --- */

static const char *command_state(const struct srv_key *key, int64_t now) {
    if (key->revoked && key->revoked <= now) return "revoked";
    return key->expires && key->expires <= now ? "expired" : "good";
}

static void command_show(const struct srv_keys *keys, int64_t now) {
    char made[SRV_KEY_TIME], expires[SRV_KEY_TIME], limits[SRV_LIMITS_TEXT];
    for (int role = SRV_ROLE_ANONYMOUS; role < SRV_ROLE_COUNT; role++) {
        struct srv_limits all = srv_keys_role(keys, (enum srv_role)role);
        srv_limits_write(&all, limits);
        printf("role %-9s%s\n", srv_role_word((enum srv_role)role), limits);
    }
    for (int i = 0; i < keys->count; i++) {
        const struct srv_key *key = &keys->key[i];
        srv_keys_time(key->made, made);
        srv_keys_time(key->expires, expires);
        srv_limits_write(&key->limits, limits);
        printf("key  %.*s %s %s %s made=%s expires=%s%s\n", SRV_KEY_ID, key->digest, key->name,
               srv_role_word(key->role), command_state(key, now), made, expires, limits);
    }
}

static enum pend_status command_list(const struct command *command, struct pend_error *error) {
    struct srv_keys keys;
    srv_keys_init(&keys);
    enum pend_status status = srv_key_file_read(command->keys, &keys, NULL, error);
    if (status == PEND_OK) command_show(&keys, command->now);
    srv_keys_clear(&keys);
    return status;
}

/* --- the command line --- */

static int command_wrong(const char *subject, const char *verdict) {
    fprintf(stderr, "pendulumd keys: %.60s %s; see pendulumd keys --help\n", subject, verdict);
    return 2;
}

/* parses the options after the action; returns 0, or the exit status */
static int command_read(struct command *command, int argc, char *const argv[]) {
    static const char *const names[COMMAND_OPTIONS] = {"keys", "name", "role", "quota", "expires"};
    const char **const values[COMMAND_OPTIONS] = {&command->keys, &command->name, &command->role,
                                                  &command->quota, &command->expires};
    for (int a = 3; a < argc; a++) {
        const char *equals = strchr(argv[a], '=');
        size_t bytes = equals ? (size_t)(equals - argv[a]) : strlen(argv[a]);
        int i = 0;
        while (i < COMMAND_OPTIONS && (strncmp(argv[a], "--", 2) || strlen(names[i]) + 2 != bytes ||
                                       memcmp(argv[a] + 2, names[i], bytes - 2)))
            i++;
        if (i == COMMAND_OPTIONS) return command_wrong(argv[a], "is not an option");
        if (!equals && a + 1 == argc) return command_wrong(argv[a], "needs a value");
        *values[i] = equals ? equals + 1 : argv[++a];
    }
    if (!command->keys) command->keys = getenv("PENDULUMD_KEYS");
    return command->keys ? 0 : command_wrong("--keys FILE", "is missing");
}

static const struct {
    const char *word;
    enum pend_status (*change)(struct srv_keys *keys, void *context, struct pend_error *error);
    int make;
} command_actions[] = {{"add", command_add, 1},       {"list", NULL, 0},
                       {"revoke", command_revoke, 0}, {"expire", command_expire, 0},
                       {"remove", command_remove, 0}, {"role", command_role, 1}};

static int command_run(struct command *command, int action) {
    assert(command->keys && command->now > 0);
    struct pend_error error = {.text = ""};
    enum pend_status status =
        command_actions[action].change
            ? srv_key_file_change(command->keys, command_actions[action].make,
                                  command_actions[action].change, command, &error)
            : command_list(command, &error);
    if (status != PEND_OK) {
        fprintf(stderr, "pendulumd keys: %s\n", error.text);
        return 1;
    }
    if (command->token[0])
        printf("%s\n", command->token);
    else if (command->changed)
        printf(command->changed == 1 ? "%d key has changed\n" : "%d keys have changed\n",
               command->changed);
    return fflush(stdout) ? 1 : 0;
}

int srv_keys_command(int argc, char *const argv[]) {
    enum { ACTIONS = sizeof command_actions / sizeof *command_actions };
    struct command command = {.now = (int64_t)time(NULL)};
    int action = 0;
    if (argc < 3 || !strcmp(argv[2], "--help") || !strcmp(argv[2], "-h")) {
        fputs(command_usage, argc < 3 ? stderr : stdout);
        return argc < 3 ? 2 : 0;
    }
    while (action < ACTIONS && strcmp(command_actions[action].word, argv[2])) action++;
    if (action == ACTIONS) return command_wrong(argv[2], "is not a command");
    int bad = command_read(&command, argc, argv);
    return bad ? bad : command_run(&command, action);
}

#include "server/sandbox_setup.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/config/state_dir.h"
#include "server/sandbox/privileges.h"
#include "server/sandbox/sandbox_landlock.h"
#include "server/sandbox/sandbox_seccomp.h"

enum pend_status srv_sandbox_root(const struct srv_config *config, struct pend_error *error) {
    if (geteuid() || config->allow_root == 1) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "the server does not need root: start it as another user, as "
                     "docker/pendulumd.service does, or with --allow-root on");
}

static void sandbox_variable(struct srv_sandbox_files *files, enum srv_sandbox_use use,
                             const char *name) {
    const char *value = getenv(name);
    if (value && value[0]) srv_sandbox_add(files, use, value);
}

/* adds files that libpq reads: in the user's home, and those that its environment variables name */
static void sandbox_database(struct srv_sandbox_files *files) {
    static const char *const own[] = {"/.pgpass", "/.pg_service.conf", "/.postgresql"};
    static const char *const names[] = {"PGPASSFILE", "PGSERVICEFILE", "PGSYSCONFDIR", "PGSSLCERT",
                                        "PGSSLKEY",   "PGSSLROOTCERT", "PGSSLCRL"};
    const char *home = getenv("HOME");
    char path[SRV_SANDBOX_PATH];
    for (size_t i = 0; home && i < sizeof own / sizeof *own; i++)
        if (snprintf(path, sizeof path, "%s%s", home, own[i]) < SRV_SANDBOX_PATH)
            srv_sandbox_add(files, SRV_SANDBOX_READ, path);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        sandbox_variable(files, SRV_SANDBOX_READ, names[i]);
    files->connects = 1;
}

static enum pend_status sandbox_store(struct srv_sandbox_files *files,
                                      const struct srv_config *config, struct pend_error *error) {
    char url[SRV_CONFIG_TEXT];
    if (!strcmp(config->store, "none")) return PEND_OK;
    PEND_TRY(srv_state_url(config->store, url, error));
    if (strncmp(url, "sqlite:", 7)) {
        sandbox_database(files);
        return PEND_OK;
    }
    srv_sandbox_add_around(files, SRV_SANDBOX_WRITE, url + 7);
    /* SQLite sorts and large transactions use temporary files */
    sandbox_variable(files, SRV_SANDBOX_WRITE, "SQLITE_TMPDIR");
    sandbox_variable(files, SRV_SANDBOX_WRITE, "TMPDIR");
    srv_sandbox_add(files, SRV_SANDBOX_WRITE, "/var/tmp");
    srv_sandbox_add(files, SRV_SANDBOX_WRITE, "/tmp");
    return PEND_OK;
}

/* adds all places that the options name, and files that the C library reads */
static enum pend_status sandbox_places(struct srv_sandbox_files *files,
                                       const struct srv_config *config, struct pend_error *error) {
    static const char *const system[] = {"/etc", "/usr", "/lib", "/lib64", "/proc", "/sys", "/run"};
    for (size_t i = 0; i < sizeof system / sizeof *system; i++)
        srv_sandbox_add(files, SRV_SANDBOX_READ, system[i]);
    srv_sandbox_add(files, SRV_SANDBOX_READ, "/dev/urandom");
    srv_sandbox_add(files, SRV_SANDBOX_WRITE, "/dev/null");
    PEND_TRY(sandbox_store(files, config, error));
    if (!strncmp(config->results, "file://", 7))
        srv_sandbox_add(files, SRV_SANDBOX_WRITE, config->results + 7);
    if (strcmp(config->log, "-")) srv_sandbox_add_around(files, SRV_SANDBOX_WRITE, config->log);
    if (strcmp(config->audit_log, "-") && strcmp(config->audit_log, "none"))
        srv_sandbox_add_around(files, SRV_SANDBOX_WRITE, config->audit_log);
    /* the server reads these files again, and they may be replaced meanwhile */
    const char *const again[] = {config->keys, config->store_file};
    for (size_t i = 0; i < sizeof again / sizeof *again; i++)
        if (strcmp(again[i], "none")) srv_sandbox_add_around(files, SRV_SANDBOX_READ, again[i]);
    if (config->file[0]) srv_sandbox_add_around(files, SRV_SANDBOX_READ, config->file);
    return PEND_OK;
}

static enum pend_status sandbox_files(const struct srv_config *config, struct pend_error *error) {
    struct srv_sandbox_files *files = calloc(1, sizeof *files);
    if (!files) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    enum pend_status status = sandbox_places(files, config, error);
    if (status == PEND_OK) status = srv_sandbox_landlock(files, error);
    free(files);
    return status;
}

enum pend_status srv_sandbox_enter(const struct srv_config *config, char lack[SRV_CONFIG_TEXT],
                                   struct pend_error *error) {
    size_t used = 0;
    lack[0] = 0;
    if (!config->sandbox) return PEND_OK;
    for (int layer = 0; layer < 3; layer++) {
        struct pend_error why = {.text = ""};
        enum pend_status status = layer == 0   ? srv_privileges_drop(&why)
                                  : layer == 1 ? sandbox_files(config, &why)
                                               : srv_sandbox_seccomp(&why);
        if (status == PEND_OK) continue;
        if (config->sandbox != SRV_CONFIG_AUTO || status == PEND_NO_MEMORY)
            return pend_fail(error, status, -1, 0, "sandbox: %.200s", why.text);
        if (used + 1 < SRV_CONFIG_TEXT)
            used += (size_t)snprintf(lack + used, SRV_CONFIG_TEXT - used, "%s%.110s",
                                     used ? "; " : "", why.text);
    }
    return PEND_OK;
}

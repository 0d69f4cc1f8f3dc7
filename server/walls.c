#include "server/walls.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/sandbox/calls.h"
#include "server/sandbox/fence.h"
#include "server/sandbox/privileges.h"
#include "server/config/state_dir.h"

enum pend_status srv_walls_root(const struct srv_config *config, struct pend_error *error) {
    if (geteuid() || config->allow_root == 1) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "this is root, and the server needs no right of root: start it as another "
                     "user, as docker/pendulumd.service does, or with --allow-root on");
}

static void walls_variable(struct srv_fence *fence, enum srv_fence_use use, const char *name) {
    const char *value = getenv(name);
    if (value && value[0]) srv_fence_add(fence, use, value);
}

/* what libpq reads of its user's home, beside what its own variables name */
static void walls_database(struct srv_fence *fence) {
    static const char *const files[] = {"/.pgpass", "/.pg_service.conf", "/.postgresql"};
    static const char *const names[] = {"PGPASSFILE", "PGSERVICEFILE", "PGSYSCONFDIR", "PGSSLCERT",
                                        "PGSSLKEY",   "PGSSLROOTCERT", "PGSSLCRL"};
    const char *home = getenv("HOME");
    char path[SRV_FENCE_PATH];
    for (size_t i = 0; home && i < sizeof files / sizeof *files; i++)
        if (snprintf(path, sizeof path, "%s%s", home, files[i]) < SRV_FENCE_PATH)
            srv_fence_add(fence, SRV_FENCE_READ, path);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        walls_variable(fence, SRV_FENCE_READ, names[i]);
    fence->connects = 1;
}

/* where the jobs are, and what SQLite writes beside them */
static enum pend_status walls_store(struct srv_fence *fence, const struct srv_config *config,
                                    struct pend_error *error) {
    char url[SRV_CONFIG_TEXT];
    if (!strcmp(config->store, "none")) return PEND_OK;
    PEND_TRY(srv_state_url(config->store, url, error));
    if (strncmp(url, "sqlite:", 7)) {
        walls_database(fence);
        return PEND_OK;
    }
    srv_fence_add_around(fence, SRV_FENCE_WRITE, url + 7);
    /* a sort or a large transaction has a file of its own */
    walls_variable(fence, SRV_FENCE_WRITE, "SQLITE_TMPDIR");
    walls_variable(fence, SRV_FENCE_WRITE, "TMPDIR");
    srv_fence_add(fence, SRV_FENCE_WRITE, "/var/tmp");
    srv_fence_add(fence, SRV_FENCE_WRITE, "/tmp");
    return PEND_OK;
}

/* every place that the options name, and what the C library looks into */
static enum pend_status walls_places(struct srv_fence *fence, const struct srv_config *config,
                                     struct pend_error *error) {
    static const char *const system[] = {"/etc", "/usr", "/lib", "/lib64", "/proc", "/sys", "/run"};
    for (size_t i = 0; i < sizeof system / sizeof *system; i++)
        srv_fence_add(fence, SRV_FENCE_READ, system[i]);
    srv_fence_add(fence, SRV_FENCE_READ, "/dev/urandom");
    srv_fence_add(fence, SRV_FENCE_WRITE, "/dev/null");
    PEND_TRY(walls_store(fence, config, error));
    if (strcmp(config->log, "-")) srv_fence_add_around(fence, SRV_FENCE_WRITE, config->log);
    if (strcmp(config->audit_log, "-") && strcmp(config->audit_log, "none"))
        srv_fence_add_around(fence, SRV_FENCE_WRITE, config->audit_log);
    /* these are read again, and may be replaced meanwhile */
    const char *const again[] = {config->keys, config->store_file};
    for (size_t i = 0; i < sizeof again / sizeof *again; i++)
        if (strcmp(again[i], "none")) srv_fence_add_around(fence, SRV_FENCE_READ, again[i]);
    if (config->file[0]) srv_fence_add_around(fence, SRV_FENCE_READ, config->file);
    return PEND_OK;
}

static enum pend_status walls_fence(const struct srv_config *config, struct pend_error *error) {
    struct srv_fence *fence = calloc(1, sizeof *fence);
    if (!fence) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    enum pend_status status = walls_places(fence, config, error);
    if (status == PEND_OK) status = srv_fence_close(fence, error);
    free(fence);
    return status;
}

enum pend_status srv_walls_raise(const struct srv_config *config, char lack[SRV_CONFIG_TEXT],
                                 struct pend_error *error) {
    size_t used = 0;
    lack[0] = 0;
    if (!config->walls) return PEND_OK;
    for (int wall = 0; wall < 3; wall++) {
        struct pend_error why = {.text = ""};
        enum pend_status status = wall == 0   ? srv_privileges_drop(&why)
                                  : wall == 1 ? walls_fence(config, &why)
                                              : srv_calls_restrict(&why);
        if (status == PEND_OK) continue;
        if (config->walls != SRV_CONFIG_AUTO || status == PEND_NO_MEMORY)
            return pend_fail(error, status, -1, 0, "walls: %.200s", why.text);
        if (used + 1 < SRV_CONFIG_TEXT)
            used += (size_t)snprintf(lack + used, SRV_CONFIG_TEXT - used, "%s%.110s",
                                     used ? "; " : "", why.text);
    }
    return PEND_OK;
}

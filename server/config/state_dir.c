#include "server/config/state_dir.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static int state_directory(char *path) {
    for (char *at = strchr(path + 1, '/'); at; at = strchr(at + 1, '/')) {
        *at = 0;
        int made = !mkdir(path, 0700) || errno == EEXIST;
        *at = '/';
        if (!made) return 0;
    }
    return !mkdir(path, 0700) || errno == EEXIST;
}

enum pend_status srv_state_url(const char *store, char url[SRV_CONFIG_TEXT],
                               struct pend_error *error) {
    char path[SRV_CONFIG_TEXT];
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    if (strcmp(store, "sqlite")) {
        snprintf(url, SRV_CONFIG_TEXT, "%s", store);
        return PEND_OK;
    }
    int own = state && state[0] == '/', count = 0;
    if (own)
        count = snprintf(path, sizeof path, "%s/pendulumd", state);
    else if (home && home[0] == '/')
        count = snprintf(path, sizeof path, "%s/.local/state/pendulumd", home);
    if (!count || snprintf(url, SRV_CONFIG_TEXT, "sqlite:%s/store.db", path) >= SRV_CONFIG_TEXT)
        return pend_fail(
            error, PEND_INVALID, -1, 0,
            "there is no directory for jobs: set --store sqlite:PATH, or --store none for no jobs");
    if (state_directory(path)) return PEND_OK;
    return pend_fail(
        error, PEND_INVALID, -1, 0,
        "%.120s cannot be created: %s; choose another path with --store, or --store none", path,
        strerror(errno));
}

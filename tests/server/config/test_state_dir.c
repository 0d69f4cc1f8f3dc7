#include "server/config/state_dir.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/harness/test.h"

/* the url of the store "sqlite" in an environment; "" if there is none */
static const char *state_url(const char *state, const char *home, char url[SRV_CONFIG_TEXT]) {
    struct pend_error error = {0};
    if (state)
        setenv("XDG_STATE_HOME", state, 1);
    else
        unsetenv("XDG_STATE_HOME");
    if (home)
        setenv("HOME", home, 1);
    else
        unsetenv("HOME");
    if (srv_state_url("sqlite", url, &error) == PEND_OK) return url;
    CHECK(strstr(error.text, "--store") != NULL);
    return strcpy(url, "");
}

TEST(a_store_without_a_name_lies_in_the_state_directory_of_its_user) {
    char top[] = "build/state.XXXXXX", here[256], place[512], expected[600], url[SRV_CONFIG_TEXT];
    struct stat made;
    REQUIRE(mkdtemp(top) != NULL && getcwd(here, sizeof here) != NULL);
    char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    char *state_was = state ? strdup(state) : NULL, *home_was = home ? strdup(home) : NULL;

    snprintf(place, sizeof place, "%s/%s/a/b", here, top);
    snprintf(expected, sizeof expected, "sqlite:%s/pendulumd/store.db", place);
    CHECK_TEXT(state_url(place, "/nowhere", url), expected);
    snprintf(expected, sizeof expected, "%s/pendulumd", place);
    CHECK(!stat(expected, &made) && S_ISDIR(made.st_mode) && (made.st_mode & 0777) == 0700);

    /* without a state directory, or with a relative one, it is below the home directory */
    snprintf(place, sizeof place, "%s/%s", here, top);
    snprintf(expected, sizeof expected, "sqlite:%s/.local/state/pendulumd/store.db", place);
    CHECK_TEXT(state_url(NULL, place, url), expected);
    CHECK_TEXT(state_url("relative", place, url), expected);

    /* without either, or if no directory can be created, the error names the option */
    CHECK_TEXT(state_url(NULL, NULL, url), "");
    CHECK_TEXT(state_url(NULL, "relative", url), "");
    CHECK_TEXT(state_url("/dev/null", "/nowhere", url), "");

    state_was ? setenv("XDG_STATE_HOME", state_was, 1) : unsetenv("XDG_STATE_HOME");
    home_was ? setenv("HOME", home_was, 1) : unsetenv("HOME");
    free(state_was);
    free(home_was);
    snprintf(place, sizeof place, "rm -r %s", top);
    CHECK_INT(system(place), 0);
}

TEST(a_store_that_is_named_keeps_its_name) {
    char url[SRV_CONFIG_TEXT];
    struct pend_error error;
    CHECK_INT(srv_state_url("sqlite:/a/b.db", url, &error), PEND_OK);
    CHECK_TEXT(url, "sqlite:/a/b.db");
    CHECK_INT(srv_state_url("postgresql://host/name", url, &error), PEND_OK);
    CHECK_TEXT(url, "postgresql://host/name");
}

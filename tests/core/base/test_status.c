/* Tests of core/base/status: the list of codes, and errors with and without a receiver.
 * Leaves to others: how a code reaches a user (tests/api).
 * Invariant: every code of the list is tested. */
#include "core/base/status.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(status_names_every_code) {
    for (int code = 0; code < PEND_STATUS_COUNT; code++) {
        const char *name = pend_status_name((enum pend_status)code),
                   *text = pend_status_text((enum pend_status)code);
        CHECK_SAYING(!strncmp(name, "PEND_", 5), "code %d is named %s", code, name);
        CHECK_SAYING(strlen(text) > 5, "%s says \"%s\"", name, text);
        for (int other = 0; other < code; other++)
            CHECK_SAYING(strcmp(text, pend_status_text((enum pend_status)other)),
                         "%s and code %d share a text", name, other);
    }
    CHECK_TEXT(pend_status_name(PEND_OK), "PEND_OK");
    CHECK_TEXT(pend_status_name(PEND_BUG), "PEND_BUG");
}

TEST(status_knows_an_unknown_code) {
    static const int strange[] = {-1, PEND_STATUS_COUNT, 1000000};
    for (int i = 0; i < 3; i++) {
        enum pend_status code;
        // not every int is a value of the enumeration; this is a damaged one
        memcpy(&code, &strange[i], sizeof code);
        CHECK_TEXT(pend_status_text(code), "unknown status");
        CHECK_TEXT(pend_status_name(code), "unknown");
    }
}

TEST(status_fail_fills_an_error_and_returns_its_code) {
    struct pend_error error;
    memset(&error, 0x55, sizeof error);
    CHECK_INT(pend_fail(&error, PEND_NOT_FINITE, 3, 1.5, "arm %d at %g s", 4, 1.5),
              PEND_NOT_FINITE);
    CHECK_INT(error.code, PEND_NOT_FINITE);
    CHECK_INT(error.arm, 3);
    CHECK(error.time == 1.5);
    CHECK_TEXT(error.text, "arm 4 at 1.5 s");
    CHECK_INT(pend_fail(NULL, PEND_LIMIT, -1, 0, "nobody reads %s", "this"), PEND_LIMIT);
}

TEST(status_fail_blames_nothing_else_where_memory_ran_out) {
    struct pend_error error;
    CHECK_INT(pend_fail(&error, PEND_NO_MEMORY, 2, 0, "there is no such pendulum"), PEND_NO_MEMORY);
    CHECK_TEXT(error.text, "out of memory");
    pend_fail(&error, PEND_NO_MEMORY, 2, 0, "no memory for %d arms", 5);
    CHECK_TEXT(error.text, "no memory for 5 arms");
}

TEST(status_fail_cuts_a_long_text) {
    struct pend_error error;
    char longer[2 * sizeof error.text];
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = 0;
    pend_fail(&error, PEND_BUG, -1, 0, "%s", longer);
    CHECK_INT(strlen(error.text), sizeof error.text - 1);
}

static enum pend_status status_pass_up(enum pend_status code, int *reached) {
    PEND_TRY(code);
    *reached = 1;
    return PEND_OK;
}

TEST(status_try_passes_a_failure_up) {
    int reached = 0;
    CHECK_INT(status_pass_up(PEND_DEADLINE, &reached), PEND_DEADLINE);
    CHECK_INT(reached, 0);
    CHECK_INT(status_pass_up(PEND_OK, &reached), PEND_OK);
    CHECK_INT(reached, 1);
}

#include "core/base/status.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    const char *text;
} status_table[PEND_STATUS_COUNT] = {
#define X(name, text) {#name, text},
    PEND_STATUS_LIST(X)
#undef X
};

static_assert(PEND_OK == 0, "0 is success");

static int status_known(enum pend_status code) { return (unsigned)code < PEND_STATUS_COUNT; }

const char *pend_status_text(enum pend_status code) {
    return status_known(code) ? status_table[code].text : "unknown status";
}

const char *pend_status_name(enum pend_status code) {
    return status_known(code) ? status_table[code].name : "unknown";
}

enum pend_status pend_fail(struct pend_error *error, enum pend_status code, int arm, double time,
                           const char *format, ...) {
    assert(code != PEND_OK && status_known(code));
    assert(arm >= -1 && format);
    if (!error) return code;
    error->code = code;
    error->arm = arm;
    error->time = time;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    /* a lack of memory is no fault of the caller's input */
    if (code == PEND_NO_MEMORY && !strstr(error->text, "memory"))
        snprintf(error->text, sizeof error->text, "%s", pend_status_text(code));
    return code;
}

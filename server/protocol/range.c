#include "server/protocol/range.h"

#include <string.h>
#include <strings.h>

enum { RANGE_DIGITS = 18 };

/* reads a number of at most 18 digits; returns its end, NULL if there is none */
static const char *range_number(const char *at, long long *number) {
    size_t digits = strspn(at, "0123456789");
    *number = 0;
    if (!digits || digits > RANGE_DIGITS) return NULL;
    for (size_t i = 0; i < digits; i++) *number = 10 * *number + (at[i] - '0');
    return at + digits;
}

int srv_range_read(const char *field, struct api_range *range) {
    const char *at = field;
    *range = (struct api_range){-1, -1};
    if (!at || strncasecmp(at, "bytes=", 6) != 0) return 0;
    at += 6;
    at += strspn(at, " \t");
    if (*at != '-' && !(at = range_number(at, &range->first))) return 0;
    if (*at++ != '-') return 0;
    if (*at >= '0' && *at <= '9') {
        if (!(at = range_number(at, &range->last))) return 0;
    } else if (range->first < 0) {
        return 0;
    }
    at += strspn(at, " \t");
    return !*at && (range->first < 0 || range->last < 0 || range->first <= range->last);
}

#include "api/limits.h"

#include <stddef.h>

static const struct api_limit_row limits_table[] = {
#define X(field, name, start, least, most, unit, meaning) {name, start, least, most, unit, meaning},
    API_LIMITS_LIST(X)
#undef X
};

static const size_t limits_offset[] = {
#define X(field, name, start, least, most, unit, meaning) offsetof(struct api_limits, field),
    API_LIMITS_LIST(X)
#undef X
};

enum { LIMITS_COUNT = sizeof limits_table / sizeof *limits_table };

void api_limits_init(struct api_limits *limits) {
    for (int i = 0; i < LIMITS_COUNT; i++) *api_limits_value(limits, i) = limits_table[i].start;
}

const struct api_limit_row *api_limits_row(int i) { return i >= 0 && i < LIMITS_COUNT ? &limits_table[i] : NULL; }

double *api_limits_value(struct api_limits *limits, int i) { return (double *)((char *)limits + limits_offset[i]); }

#include "api/base/limits.h"

#include <assert.h>
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

/* options that allow jobs a larger value of a limit */
static const struct {
    size_t offset;
    const char *name;
} limits_of_jobs[] = {{offsetof(struct api_limits, samples), "max-job-samples"},
                      {offsetof(struct api_limits, members), "max-job-members"},
                      {offsetof(struct api_limits, steps), "max-job-steps"},
                      {offsetof(struct api_limits, compute_seconds), "max-job-seconds"}};

enum { LIMITS_COUNT = sizeof limits_table / sizeof *limits_table };

void api_limits_init(struct api_limits *limits) {
    limits->of_jobs = limits->stored = 0;
    for (int i = 0; i < LIMITS_COUNT; i++) *api_limits_value(limits, i) = limits_table[i].start;
}

const struct api_limit_row *api_limits_row(int i) {
    return i >= 0 && i < LIMITS_COUNT ? &limits_table[i] : NULL;
}

double *api_limits_value(struct api_limits *limits, int i) {
    assert(i >= 0 && i < LIMITS_COUNT);
    return (double *)((char *)limits + limits_offset[i]);
}

const char *api_limits_name(const struct api_limits *limits, const double *field) {
    size_t offset = (size_t)((const char *)field - (const char *)limits);
    for (size_t i = 0; limits->of_jobs && i < sizeof limits_of_jobs / sizeof *limits_of_jobs; i++)
        if (limits_of_jobs[i].offset == offset) return limits_of_jobs[i].name;
    int i = 0;
    while (i + 1 < LIMITS_COUNT && limits_offset[i] != offset) i++;
    assert(limits_offset[i] == offset);
    return limits_table[i].name;
}

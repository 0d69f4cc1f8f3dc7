#include "api/base/limits.h"

#include <stddef.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(limits_start_with_the_defaults_of_the_table) {
    struct api_limits limits;
    api_limits_init(&limits);
    CHECK(limits.arms == 5000);
    CHECK(limits.samples == 1e7);
    CHECK(limits.body_bytes == 8 << 20);
    CHECK(limits.compute_seconds == 60);
    CHECK(limits.depth == 16);
}

TEST(limits_table_has_a_row_for_every_field) {
    struct api_limits limits;
    int rows = 0;
    api_limits_init(&limits);
    for (; api_limits_row(rows); rows++) {
        const struct api_limit_row *row = api_limits_row(rows);
        CHECK(row->least <= row->start && row->start <= row->most);
        CHECK(*row->name && *row->unit && *row->meaning);
        CHECK(*api_limits_value(&limits, rows) == row->start);
        for (int i = 0; i < rows; i++) {
            CHECK(strcmp(api_limits_row(i)->name, row->name));
            CHECK(api_limits_value(&limits, i) != api_limits_value(&limits, rows));
        }
    }
    CHECK_INT(rows, (long long)(offsetof(struct api_limits, of_jobs) / sizeof(double)));
    CHECK(!api_limits_row(-1));
}

TEST(limits_are_set_through_their_row) {
    struct api_limits limits;
    api_limits_init(&limits);
    for (int i = 0; api_limits_row(i); i++)
        if (!strcmp(api_limits_row(i)->name, "max-arms")) *api_limits_value(&limits, i) = 7;
    CHECK(limits.arms == 7);
    CHECK(limits.samples == 1e7);
}

TEST(limits_of_jobs_are_called_by_the_names_of_their_own_options) {
    struct api_limits limits;
    api_limits_init(&limits);
    CHECK_TEXT(api_limits_name(&limits, &limits.members), "max-members");
    CHECK_TEXT(api_limits_name(&limits, &limits.depth), "max-json-depth");
    limits.of_jobs = 1;
    CHECK_TEXT(api_limits_name(&limits, &limits.members), "max-job-members");
    CHECK_TEXT(api_limits_name(&limits, &limits.samples), "max-job-samples");
    CHECK_TEXT(api_limits_name(&limits, &limits.steps), "max-job-steps");
    CHECK_TEXT(api_limits_name(&limits, &limits.compute_seconds), "max-job-seconds");
    CHECK_TEXT(api_limits_name(&limits, &limits.arms), "max-arms");
}

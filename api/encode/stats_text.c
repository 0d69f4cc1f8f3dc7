#include "api/encode/stats_text.h"

#include <stdio.h>
#include <string.h>

#include "api/json/json_out.h"

const char api_stats_field_names[] = "X-Horizon, X-Trust-Until, X-Energy-Drift, X-Warning";

/* statistics that have their own HTTP field */
static const struct {
    const char *stat, *field;
} stats_numbers[] = {
    {"horizon", "X-Horizon"}, {"trust_until", "X-Trust-Until"}, {"energy_drift", "X-Energy-Drift"}};

enum pend_status api_stats_json(const struct api_stats *stats, struct api_buffer *out) {
    int warnings = api_stats_warnings(stats);
    PEND_TRY(api_out_open(out, "stats", '{'));
    for (int i = 0; i < stats->count; i++) {
        const struct api_stat *stat = &stats->stat[i];
        if (stat->kind == API_STAT_TEXT) PEND_TRY(api_out_text(out, stat->name, stat->text));
        if (stat->kind == API_STAT_WHOLE) PEND_TRY(api_out_whole(out, stat->name, stat->whole));
        if (stat->kind == API_STAT_NUMBER)
            PEND_TRY(api_out_number(out, stat->name, stat->number, 0));
    }
    PEND_TRY(api_buffer_text(out, "}"));
    if (!warnings) return PEND_OK;
    PEND_TRY(api_out_open(out, "warnings", '['));
    for (int i = 0; i < stats->count; i++)
        if (stats->stat[i].kind == API_STAT_WARNING)
            PEND_TRY(
                api_buffer_format(out, --warnings ? "\"%s\"," : "\"%s\"", stats->stat[i].text));
    return api_buffer_text(out, "]");
}

static void stats_number(double value, char text[API_NUMBER_BYTES + 1]) {
    *api_number_write(text, value) = 0;
}

enum pend_status api_stats_comments(const struct api_stats *stats, struct api_buffer *out) {
    char text[API_NUMBER_BYTES + 1];
    for (int i = 0; i < stats->count; i++) {
        const struct api_stat *stat = &stats->stat[i];
        if (stat->kind == API_STAT_WARNING)
            PEND_TRY(api_buffer_format(out, "# warning: %s\n", stat->text));
        if (stat->kind != API_STAT_NUMBER || strcmp(stat->name, "trust_until") != 0) continue;
        stats_number(stat->number, text);
        PEND_TRY(api_buffer_format(out, "# trust_until: %s\n", text));
    }
    return PEND_OK;
}

void api_stats_fields(struct api_stats_headers *stat_fields, const struct api_stats *stats) {
    stat_fields->count = 0;
    for (int i = 0; stats && i < stats->count && stat_fields->count < API_STATS_FIELDS; i++) {
        const struct api_stat *stat = &stats->stat[i];
        char *value = stat_fields->field[stat_fields->count].value;
        const char *name = stat->kind == API_STAT_WARNING ? "X-Warning" : NULL;
        for (size_t j = 0;
             stat->kind == API_STAT_NUMBER && j < sizeof stats_numbers / sizeof *stats_numbers; j++)
            if (!strcmp(stat->name, stats_numbers[j].stat)) name = stats_numbers[j].field;
        if (!name) continue;
        if (stat->kind == API_STAT_NUMBER)
            stats_number(stat->number, value);
        else
            snprintf(value, API_STATS_FIELD_TEXT, "%s", stat->text);
        stat_fields->field[stat_fields->count++].name = name;
    }
}

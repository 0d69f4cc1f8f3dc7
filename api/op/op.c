#include "api/op/op.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode_raw.h"
#include "api/encode/stats_text.h"

static const double turn_seconds = 0.001, hurried_seconds = 0.00025;
static const size_t turn_bytes = 1 << 18;

double api_turn_seconds(const struct api_turn *turn) {
    assert(turn->earlier >= 0);
    return turn->now ? turn->earlier + (turn->now(turn->context) - turn->begun) : -1;
}

int api_turn_over(const struct api_turn *turn) {
    assert(turn->out->bytes >= turn->before);
    if (!turn->now || turn->out->bytes - turn->before >= turn_bytes) return 1;
    double seconds = turn->now(turn->context) - turn->begun;
    return seconds >= turn_seconds ||
           (turn->hurry && seconds >= hurried_seconds && turn->hurry(turn->company));
}

void api_turn_tell(const struct api_turn *turn, double more, struct api_stats *stats) {
    double seconds = api_turn_seconds(turn) + more;
    api_stats_origin(stats);
    if (seconds >= 0) api_stats_number(stats, "compute_seconds", rint(seconds * 1e6) / 1e6);
}

enum pend_status api_turn_close(const struct api_turn *turn) {
    struct api_stats stats = {.count = 0};
    api_turn_tell(turn, 0, &stats);
    PEND_TRY(api_stats_json(&stats, turn->out));
    return api_buffer_text(turn->out, "}");
}

enum pend_status api_op_read(void **state, const struct api_reading *reading) {
    *state = calloc(1, reading->op->size);
    if (!*state) return PEND_NO_MEMORY;
    enum pend_status status = reading->op->read(*state, reading);
    if (status != PEND_OK) api_op_free(reading->op, state);
    return status;
}

const struct api_table *api_op_table(const struct api_op *op, const void *state) {
    assert(op->table);
    return (const struct api_table *)((const char *)state + op->table);
}

const struct api_stats *api_op_stats(const struct api_op *op, const void *state) {
    assert(op->stats);
    return (const struct api_stats *)((const char *)state + op->stats);
}

void api_op_free(const struct api_op *op, void **state) {
    if (*state && op->clear) op->clear(*state);
    free(*state);
    *state = NULL;
}

enum pend_status api_reading_tree(const struct api_reading *reading, struct api_tree *tree) {
    struct api_value pendulum = api_value_member(reading->root, "pendulum");
    PEND_TRY(api_tree_read(tree, &pendulum, reading->limits, reading->problem));
    if (tree->cart && !reading->op->cart) {
        api_value_fault(&pendulum, reading->problem,
                        API_CODE_UNSUPPORTED "has a pivot on a cart, which \"%s\" does not support",
                        reading->op->name);
        return PEND_INVALID;
    }
    if (tree->rules && !reading->op->pieces) {
        api_value_fault(&pendulum, reading->problem,
                        API_CODE_UNSUPPORTED
                        "has controllers, input tables, dry friction or stops, which \"%s\" does "
                        "not support: leave them out, or give dry friction a \"speed\"",
                        reading->op->name);
        return PEND_INVALID;
    }
    if (!tree->terms || reading->op->terms) return PEND_OK;
    api_value_fault(&pendulum, reading->problem,
                    API_CODE_UNSUPPORTED "has rods, bodies, springs, friction or drives, which "
                                         "\"%s\" does not support yet: leave them out",
                    reading->op->name);
    return PEND_INVALID;
}

void api_reading_check_json(const struct api_reading *reading, const struct api_value *value,
                            const char *what, const char *instead) {
    if (reading->format == &api_format_json || reading->format == &api_format_raw) return;
    api_value_fault(value, reading->problem,
                    API_CODE_UNSUPPORTED
                    "%s returned only in %s, not in %s: %s, or ask for that representation",
                    what, api_format_json.media_type, reading->format->media_type, instead);
}

void api_reading_check_size(const struct api_reading *reading, const struct api_table *table,
                            const struct api_value *value, const char *what, const char *fewer) {
    assert(table->count >= 1 && table->rows >= 0);
    const struct api_format *format = reading->format;
    double bytes = format->bytes(table), most = reading->limits->answer_bytes;
    char flowing[API_FORMATS_TEXT], reason[80] = "the limit max-answer-bytes";
    if (api_format_streams(format, table)) return;
    if (reading->limits->stored && api_format_turns(format, table)) return;
    if (format->most_bytes && format->most_bytes < most) {
        snprintf(reason, sizeof reason, "the bound of %s", format->media_type);
        most = format->most_bytes;
    }
    if (bytes <= most) return;
    api_format_list(flowing, 1, 1);
    api_value_fault(value, reading->problem,
                    API_CODE_LIMIT
                    "asks for %ld %s of %.0f numbers, up to %.0f bytes, more than %s of %.0f. Ask "
                    "for %s%s, or choose a format without this limit: %s",
                    table->rows, what, api_table_numbers(table, 0), bytes, reason, most, fewer,
                    format->digits ? ", or round the numbers by \"digits\"" : "", flowing);
}

void api_reading_check_kept(const struct api_reading *reading, const struct api_table *table,
                            const struct api_value *value, int arms, const char *what,
                            const char *fewer) {
    double bytes = 8 * api_table_numbers(table, 0) * (double)table->rows;
    if (bytes > reading->limits->answer_bytes)
        api_value_fault(value, reading->problem,
                        API_CODE_LIMIT
                        "asks for %s%ld %s of %d arms, %.0f bytes, more than the limit "
                        "max-answer-bytes of %.0f: ask for fewer",
                        table->rows_later ? "up to " : "", table->rows, what, arms, bytes,
                        reading->limits->answer_bytes);
    api_reading_check_size(reading, table, value, what, fewer);
}

enum pend_status api_table_grow(const struct api_table *table, long used, long first, long *room,
                                double *column[], struct pend_error *error) {
    long more = *room ? 2 * *room : first;
    if (used < *room) return PEND_OK;
    if (more > table->rows) more = table->rows;
    for (int c = 0; c < table->count; c++) {
        size_t numbers = (size_t)more * (size_t)api_column_numbers(&table->column[c]);
        double *grown = realloc(column[c], numbers * sizeof *grown);
        if (!grown) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for %ld rows", more);
        column[c] = grown;
    }
    *room = more;
    return PEND_OK;
}

static const struct api_op *const ops[API_OP_COUNT] = {
    [API_OP_TREES] = &api_op_trees,         [API_OP_TRAJECTORIES] = &api_op_trajectories,
    [API_OP_FORCES] = &api_op_forces,       [API_OP_MODES] = &api_op_modes,
    [API_OP_ENSEMBLES] = &api_op_ensembles, [API_OP_PRESETS] = &api_op_presets,
    [API_OP_PRESET] = &api_op_preset,       [API_OP_EQUATIONS] = &api_op_equations,
    [API_OP_LYAPUNOV] = &api_op_lyapunov,   [API_OP_SECTIONS] = &api_op_sections,
    [API_OP_RESPONSE] = &api_op_response,   [API_OP_FITS] = &api_op_fits,
    [API_OP_ORBITS] = &api_op_orbits,       [API_OP_CONTROLLERS] = &api_op_controllers,
    [API_OP_TABLES] = &api_op_tables,       [API_OP_TRIALS] = &api_op_trials,
};

enum api_op_id api_op_find(const char *name) {
    int id = 0;
    while (id < API_OP_COUNT && strcmp(ops[id]->name, name)) id++;
    return (enum api_op_id)id;
}

const struct api_op *api_op_at(enum api_op_id id) {
    return id >= 0 && id < API_OP_COUNT ? ops[id] : NULL;
}

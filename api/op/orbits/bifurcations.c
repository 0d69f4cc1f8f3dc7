#include "api/op/orbits/bifurcations.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_out.h"

enum { FIRST_PLACES = 8, MOST = 1000000 };

static const char *const kinds[PEND_ORBITS_KINDS] = {[PEND_ORBITS_FOLD] = "fold",
                                                     [PEND_ORBITS_BRANCH] = "branch",
                                                     [PEND_ORBITS_SYMMETRY] = "symmetry",
                                                     [PEND_ORBITS_DOUBLING] = "doubling",
                                                     [PEND_ORBITS_TORUS] = "torus"};

enum pend_status api_bifurcations_add(struct api_bifurcations *list, const struct pend_orbit *orbit,
                                      long after) {
    size_t n = (size_t)list->tree->n;
    const int *order = list->tree->order;
    assert(list->count <= list->places && after >= 0);
    if (list->count == list->places) {
        int places = list->places ? 2 * list->places : FIRST_PLACES;
        struct api_bifurcation *grown = realloc(list->item, (size_t)places * sizeof *grown);
        if (!grown) return PEND_NO_MEMORY;
        list->item = grown, list->places = places;
    }
    double *state = malloc(2 * n * sizeof *state);
    if (!state) return PEND_NO_MEMORY;
    for (size_t k = 0; k < n; k++) {
        state[order[k]] = orbit->phi[k];
        state[n + (size_t)order[k]] = orbit->rate[k];
    }
    list->item[list->count++] = (struct api_bifurcation){.kind = orbit->kind,
                                                         .after = after,
                                                         .period = orbit->period,
                                                         .energy = orbit->energy,
                                                         .value = orbit->value,
                                                         .state = state};
    return PEND_OK;
}

void api_bifurcations_clear(struct api_bifurcations *list) {
    for (int i = 0; i < list->count; i++) free(list->item[i].state);
    free(list->item);
    free(list->block);
    list->count = list->places = 0, list->item = NULL, list->block = NULL;
}

double api_bifurcations_bytes(const struct api_bifurcations *list, int columns) {
    double places = list->places > FIRST_PLACES ? 3.0 * list->places : 3.0 * FIRST_PLACES;
    double n = list->tree->n;
    return places * (96 + 16 * n + (columns ? 40 + 16 * n : 0));
}

void api_bifurcations_table(const struct api_bifurcations *list, struct api_table *table) {
    assert(!table->count);
    api_table_add(table, "kind", NULL, 0);
    api_table_add(table, "after", NULL, 0);
    if (list->varies) api_table_add(table, list->varies, NULL, 0);
    if (!list->driven) api_table_add(table, "energy", NULL, 0);
    api_table_add(table, "period", NULL, 0);
    api_table_add(table, "phi", NULL, list->tree->n);
    api_table_add(table, "phid", NULL, list->tree->n);
}

enum pend_status api_bifurcations_columns(struct api_bifurcations *list,
                                          const struct api_table *table, const double *column[]) {
    size_t rows = (size_t)list->count, n = (size_t)list->tree->n;
    assert(!list->block && table->count >= 5);
    double *at = list->block = calloc(rows * (5 + 2 * n) + 1, sizeof *at);
    if (!at) return PEND_NO_MEMORY;
    for (int c = 0; c < table->count; c++) {
        column[c] = at;
        at += rows * (table->column[c].width ? n : 1);
    }
    for (size_t i = 0; i < rows; i++) {
        const struct api_bifurcation *b = &list->item[i];
        double *to = list->block + i;
        *to = (double)b->kind + 1, to += rows;
        *to = (double)b->after, to += rows;
        if (list->varies) *to = b->value, to += rows;
        if (!list->driven) *to = b->energy, to += rows;
        *to = b->period, to += rows;
        memcpy(to - i + i * n, b->state, n * sizeof *to), to += rows * n;
        memcpy(to - i + i * n, b->state + n, n * sizeof *to);
    }
    return PEND_OK;
}

enum pend_status api_bifurcations_carry(struct api_bifurcations *list,
                                        struct pend_checkpoint *checkpoint) {
    size_t n = (size_t)list->tree->n;
    int count = list->count, puts = pend_checkpoint_puts(checkpoint);
    pend_checkpoint_int(checkpoint, &count, MOST);
    for (int i = 0; i < count; i++) {
        if (puts) {
            double *state = calloc(2 * n, sizeof *state);
            const struct pend_orbit none = {.phi = state, .rate = state};
            enum pend_status status = state ? api_bifurcations_add(list, &none, 0) : PEND_NO_MEMORY;
            free(state);
            if (status != PEND_OK) return status;
        }
        struct api_bifurcation *b = &list->item[i];
        int kind = (int)b->kind;
        pend_checkpoint_int(checkpoint, &kind, PEND_ORBITS_KINDS - 1);
        pend_checkpoint_counts(checkpoint, &b->after, 1);
        pend_checkpoint_row(checkpoint, &b->period, 1);
        pend_checkpoint_row(checkpoint, &b->energy, 1);
        pend_checkpoint_row(checkpoint, &b->value, 1);
        pend_checkpoint_row(checkpoint, b->state, 2 * n);
        b->kind = (enum pend_orbits_kind)kind;
        if (puts && !pend_checkpoint_puts(checkpoint)) return PEND_INVALID;
    }
    return PEND_OK;
}

static enum pend_status bifurcation_write(const struct api_bifurcations *list,
                                          const struct api_bifurcation *b, int digits,
                                          struct api_buffer *out) {
    int n = list->tree->n;
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "kind", kinds[b->kind]));
    PEND_TRY(api_out_whole(out, "after", b->after));
    PEND_TRY(api_out_number(out, "period", b->period, digits));
    if (!list->driven) PEND_TRY(api_out_number(out, "energy", b->energy, digits));
    if (list->varies) PEND_TRY(api_out_number(out, list->varies, b->value, digits));
    PEND_TRY(api_out_numbers(out, "phi", n, b->state, digits));
    PEND_TRY(api_out_numbers(out, "phid", n, b->state + n, digits));
    return api_buffer_text(out, "}");
}

enum pend_status api_bifurcations_write(const struct api_bifurcations *list, int digits,
                                        struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "bifurcations", '['));
    for (int i = 0; i < list->count; i++)
        PEND_TRY(bifurcation_write(list, &list->item[i], digits, out));
    return api_buffer_text(out, "]");
}

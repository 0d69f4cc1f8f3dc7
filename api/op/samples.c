#include "api/op/samples.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/tree/rules.h"

enum source {
    PHI,
    RATE,
    ACC,
    FORCE,
    Z_RE,
    Z_IM,
    ZD_RE,
    ZD_IM,
    THETA,
    JOINT_ALONG,
    JOINT_ACROSS,
    TIP_ACROSS,
    CONTROL,
    KINETIC,
    POTENTIAL,
    TOTAL,
    WORK,
    HEAT,
    CART_PLACE,
    CART_SPEED,
    CART_REACTION,
    SOURCES
};

enum { PARTS = 3, BLOCK_ROWS = 256, BLOCK_NUMBERS = 16384 };

static const struct {
    const char *name;
    int parts;
    const char *part[PARTS];
    enum source source[PARTS];
} output_table[API_OUTPUTS] = {
    {"phi", 1, {NULL}, {PHI}},
    {"phid", 1, {NULL}, {RATE}},
    {"phidd", 1, {NULL}, {ACC}},
    {"theta", 1, {NULL}, {THETA}},
    {"thetad", 1, {NULL}, {RATE}},
    {"z", 2, {"re", "im"}, {Z_RE, Z_IM}},
    {"zd", 2, {"re", "im"}, {ZD_RE, ZD_IM}},
    {"lambda", 1, {NULL}, {FORCE}},
    {"energy", 3, {"kinetic", "potential", "total"}, {KINETIC, POTENTIAL, TOTAL}},
    {"joint_force", 2, {"along", "across"}, {JOINT_ALONG, JOINT_ACROSS}},
    {"tip_force", 2, {"along", "across"}, {FORCE, TIP_ACROSS}},
    {"exchange", 2, {"work", "heat"}, {WORK, HEAT}},
    {"cart", 3, {"x", "v", "reaction"}, {CART_PLACE, CART_SPEED, CART_REACTION}},
    {"control", 1, {NULL}, {CONTROL}},
};

static const char *const output_start[] = {"phi", "phid", "lambda", NULL};

/* numbers per row: one for each arm or controller, or a single one */
static int source_width(const struct api_outputs *outputs, enum source source, int n) {
    if (source == CONTROL) return outputs->controllers;
    return source >= KINETIC ? 0 : n;
}

/* ---- reading */

static int output_find(const char *name) {
    for (int i = 0; i < API_OUTPUTS; i++)
        if (!strcmp(output_table[i].name, name)) return i;
    return -1;
}

static void output_add(struct api_outputs *outputs, const struct api_value *item,
                       struct api_problem *problem) {
    const char *names[API_OUTPUTS + 1] = {0};
    int output = 0;
    for (int i = 0; i < API_OUTPUTS; i++) names[i] = output_table[i].name;
    if (api_field_word(item, names, &output, problem) <= 0) return;
    for (int i = 0; i < outputs->count; i++)
        if (outputs->output[i] == output) {
            api_value_fault(item, problem, API_CODE_DUPLICATE "\"%s\" is in the list already",
                            names[output]);
            return;
        }
    outputs->output[outputs->count++] = output;
}

void api_outputs_read(struct api_outputs *outputs, const struct api_value *value,
                      struct api_problem *problem) {
    *outputs = (struct api_outputs){0};
    if (api_value_kind(value) == API_MISSING) {
        for (int i = 0; output_start[i]; i++)
            outputs->output[outputs->count++] = output_find(output_start[i]);
        return;
    }
    struct api_value item = api_value_item(value, 0);
    if (api_value_kind(value) != API_ARRAY || !api_value_count(value))
        api_value_fault(value, problem,
                        API_CODE_WRONG_COUNT
                        "must be an array of at least one name, such as [\"phi\"]");
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        output_add(outputs, &item, problem);
    int i = 0;
    while (i < outputs->count && output_start[i] &&
           !strcmp(output_table[outputs->output[i]].name, output_start[i]))
        i++;
    if (i == outputs->count && !output_start[i]) api_value_usual(value);
}

int api_outputs_cart(const struct api_outputs *outputs) {
    for (int i = 0; i < outputs->count; i++)
        if (output_table[outputs->output[i]].source[0] == CART_PLACE) return 1;
    return 0;
}

void api_outputs_control(struct api_outputs *outputs, const struct api_tree *tree,
                         const struct api_value *value, struct api_problem *problem) {
    outputs->controllers = tree->rules ? tree->rules->controllers : 0;
    for (int i = 0; i < outputs->count && tree->tree && !outputs->controllers; i++)
        if (output_table[outputs->output[i]].source[0] == CONTROL)
            api_value_fault(value, problem,
                            API_CODE_NOT_APPLICABLE
                            "has \"control\", but the pendulum has no controller");
}

/* ---- columns */

void api_outputs_columns(const struct api_outputs *outputs, int n, struct api_table *table) {
    assert(n >= 1 && outputs->count >= 0);
    table->count = 0;
    api_table_add(table, "t", NULL, 0);
    for (int i = 0; i < outputs->count; i++) {
        int output = outputs->output[i];
        for (int p = 0; p < output_table[output].parts; p++)
            api_table_add(table, output_table[output].name, output_table[output].part[p],
                          source_width(outputs, output_table[output].source[p], n));
    }
}

static int outputs_exchange(const struct api_outputs *outputs) {
    for (int i = 0; i < outputs->count; i++)
        if (output_table[outputs->output[i]].source[0] == WORK) return 1;
    return 0;
}

void api_outputs_derived(const struct api_outputs *outputs, const struct api_value *value,
                         struct api_derived *derived, struct api_table *table,
                         struct api_problem *problem) {
    static const int what[SOURCES] = {[PHI] = PEND_DERIVED_PHI,
                                      [RATE] = PEND_DERIVED_RATE,
                                      [ACC] = PEND_DERIVED_ACC,
                                      [FORCE] = PEND_DERIVED_FORCE,
                                      [Z_RE] = PEND_DERIVED_Z_RE,
                                      [Z_IM] = PEND_DERIVED_Z_IM,
                                      [ZD_RE] = PEND_DERIVED_ZD_RE,
                                      [ZD_IM] = PEND_DERIVED_ZD_IM,
                                      [THETA] = PEND_DERIVED_PHI,
                                      [JOINT_ALONG] = PEND_DERIVED_JOINT_ALONG,
                                      [JOINT_ACROSS] = PEND_DERIVED_JOINT_ACROSS,
                                      [TIP_ACROSS] = PEND_DERIVED_TIP_ACROSS,
                                      [KINETIC] = PEND_DERIVED_KINETIC,
                                      [POTENTIAL] = PEND_DERIVED_POTENTIAL,
                                      [TOTAL] = API_DERIVED_TOTAL,
                                      [CART_PLACE] = PEND_DERIVED_CART_PLACE,
                                      [CART_SPEED] = PEND_DERIVED_CART_SPEED,
                                      [CART_REACTION] = PEND_DERIVED_CART_REACTION};
    if (outputs->controllers)
        api_value_fault(value, problem,
                        API_CODE_UNSUPPORTED
                        "cannot be computed through controllers: leave out one of the two");
    if (outputs_exchange(outputs))
        api_value_fault(value, problem,
                        API_CODE_UNSUPPORTED
                        "of \"exchange\" are not supported: leave out one of the two");
    for (int i = 0; i < outputs->count; i++) {
        int output = outputs->output[i];
        for (int p = 0; p < output_table[output].parts; p++)
            api_derived_add(derived, table, output_table[output].name, output_table[output].part[p],
                            what[output_table[output].source[p]]);
    }
}

/* gives each needed source its array in a block that begins at `base`, after t; returns how many
 * numbers they take */
static size_t samples_place(const struct api_outputs *outputs, const char wanted[SOURCES], int n,
                            long cap, double *base, double *array[SOURCES]) {
    size_t used = (size_t)cap;
    for (int source = 0; source < SOURCES; source++) {
        int width = source_width(outputs, (enum source)source, n);
        array[source] = wanted[source] && base ? base + used : NULL;
        if (wanted[source]) used += (size_t)cap * (size_t)(width ? width : 1);
    }
    return used;
}

/* rows per block, so that its numbers are about 300 KiB as text */
static long samples_cap(size_t numbers, long rows) {
    long cap = BLOCK_NUMBERS / (long)numbers;
    if (cap > BLOCK_ROWS) cap = BLOCK_ROWS;
    if (cap > rows) cap = rows;
    return cap < 1 ? 1 : cap;
}

enum pend_status api_samples_new(struct api_samples **samples, const struct api_outputs *outputs,
                                 int n, long rows) {
    assert(n >= 1 && rows >= 1);
    char wanted[SOURCES] = {0};
    double *array[SOURCES];
    for (int i = 0; i < outputs->count; i++)
        for (int p = 0; p < output_table[outputs->output[i]].parts; p++)
            wanted[output_table[outputs->output[i]].source[p]] = 1;
    long cap = samples_cap(samples_place(outputs, wanted, n, 1, NULL, array), rows);
    *samples = NULL;
    struct api_samples *made =
        malloc(sizeof *made + samples_place(outputs, wanted, n, cap, NULL, array) * sizeof(double));
    if (!made) return PEND_NO_MEMORY;
    double *base = (double *)(made + 1);
    samples_place(outputs, wanted, n, cap, base, array);
    *made = (struct api_samples){.n = n, .total = array[TOTAL]};
    made->samples = (struct pend_samples){.cap = cap,
                                          .t = base,
                                          .phi = array[PHI],
                                          .rate = array[RATE],
                                          .acc = array[ACC],
                                          .force = array[FORCE],
                                          .z_re = array[Z_RE],
                                          .z_im = array[Z_IM],
                                          .zd_re = array[ZD_RE],
                                          .zd_im = array[ZD_IM],
                                          .theta = array[THETA],
                                          .joint_along = array[JOINT_ALONG],
                                          .joint_across = array[JOINT_ACROSS],
                                          .across = array[TIP_ACROSS],
                                          .work = array[WORK],
                                          .heat = array[HEAT],
                                          .control = array[CONTROL],
                                          .cart_place = array[CART_PLACE],
                                          .cart_speed = array[CART_SPEED],
                                          .cart_reaction = array[CART_REACTION],
                                          .kinetic = array[KINETIC],
                                          .potential = array[POTENTIAL]};
    int column = 0;
    made->column[column++] = base;
    for (int i = 0; i < outputs->count; i++)
        for (int p = 0; p < output_table[outputs->output[i]].parts; p++)
            made->column[column++] = array[output_table[outputs->output[i]].source[p]];
    *samples = made;
    return PEND_OK;
}

PEND_VALIDATOR samples_valid(const struct api_samples *samples) {
    const struct pend_samples *s = &samples->samples;
    return samples->n >= 1 && s->cap >= 1 && s->count >= 0 && s->count <= s->cap &&
           samples->column[0] == s->t && (!samples->total || (s->kinetic && s->potential));
}

void api_samples_free(struct api_samples **samples) {
    assert(!*samples || samples_valid(*samples));
    free(*samples);
    *samples = NULL;
}

void api_samples_derive(struct api_samples *samples) {
    assert(samples_valid(samples));
    const struct pend_samples *from = &samples->samples;
    for (long i = 0; samples->total && i < from->count; i++)
        samples->total[i] = from->kinetic[i] + from->potential[i];
}

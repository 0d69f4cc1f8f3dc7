#include "api/op/terms_write.h"

#include <assert.h>
#include <math.h>

#include "api/read/terms_fields.h"
#include "core/tree/rules.h"

/* the first harmonic that drives this arm or a later one */
static int first_harmonic(const struct pend_terms *terms, int drives) {
    int low = 0, high = terms->harmonics;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (terms->harmonic[middle].drives < drives)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static int has_harmonics(const struct pend_terms *terms, int drives) {
    int h = first_harmonic(terms, drives);
    return h < terms->harmonics && terms->harmonic[h].drives == drives;
}

/* the table that drives an arm; NULL if there is none */
static const struct pend_table *drive_table(const struct pend_terms *terms, int drives) {
    for (int i = 0; terms->rules && i < terms->rules->tables; i++)
        if (terms->rules->table[i].drives == drives) return &terms->rules->table[i];
    return NULL;
}

static enum pend_status write_table(const struct pend_terms *terms, int drives,
                                    struct api_buffer *out) {
    static const char *const outside[] = {NULL, "hold", "zero"};
    const struct pend_table *table = drive_table(terms, drives);
    if (!table) return PEND_OK;
    PEND_TRY(api_out_open(out, "table", '{'));
    PEND_TRY(api_out_numbers(out, "t", table->count, table->t, 0));
    PEND_TRY(api_out_numbers(out, "value", table->count, table->value, 0));
    if (drives >= 0) PEND_TRY(api_out_text(out, "hold", table->linear ? "linear" : "zero"));
    if (table->outside) PEND_TRY(api_out_text(out, "outside", outside[table->outside]));
    return api_buffer_text(out, "}");
}

static enum pend_status write_harmonics(const struct pend_loads *loads, int drives,
                                        struct api_buffer *out) {
    const struct pend_terms *terms = loads->terms;
    PEND_TRY(api_out_open(out, "harmonics", '['));
    for (int h = first_harmonic(terms, drives);
         h < terms->harmonics && terms->harmonic[h].drives == drives; h++) {
        const double *part = &loads->value[terms->harmonic[h].at];
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(api_out_number(out, "amplitude", part[0], 0));
        PEND_TRY(api_out_number(out, "omega", part[1], 0));
        PEND_TRY(api_out_number(out, "phase", part[2], 0));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "]");
}

static double part_number(const struct pend_loads *loads, int row, int k) {
    assert(loads->terms->row[row] >= 0 && k >= 0 && k < loads->terms->n);
    return loads->value[loads->terms->row[row] + k];
}

static int part_says(const struct pend_loads *loads, const struct api_terms_part *part, int k) {
    const struct pend_terms *terms = loads->terms;
    if (terms->row[part->row] < 0) return 0;
    if (part->row == PEND_TERM_AT_X) return terms->hung[k];
    return part_number(loads, (int)part->row, k) != api_terms_usual(part->row) ||
           (part->point && part_number(loads, (int)part->row + 1, k) != 0);
}

static enum pend_status write_part(const struct pend_loads *loads,
                                   const struct api_terms_part *part, const char *name, int k,
                                   struct api_buffer *out) {
    double x = part_number(loads, (int)part->row, k);
    if (!part->point) return api_out_number(out, name, x, 0);
    double pair[2] = {x, part_number(loads, (int)part->row + 1, k)};
    return pair[1] != 0 ? api_out_numbers(out, name, 2, pair, 0) : api_out_number(out, name, x, 0);
}

/* writes Coulomb friction of stored arm k; name: the member for the sliding friction */
static enum pend_status write_coulomb(const struct pend_rules *rules, const char *name, int k,
                                      struct api_buffer *out) {
    if (!rules || !rules->holding || rules->holding[k] == 0) return PEND_OK;
    PEND_TRY(api_out_open(out, "friction", '{'));
    PEND_TRY(api_out_number(out, name, rules->sliding[k], 0));
    if (rules->holding[k] != rules->sliding[k])
        PEND_TRY(api_out_number(out, "static", rules->holding[k], 0));
    return api_buffer_text(out, "}");
}

static enum pend_status write_stop(const struct pend_rules *rules, int k, struct api_buffer *out) {
    if (!rules || !rules->least || (isinf(rules->least[k]) && isinf(rules->most[k])))
        return PEND_OK;
    PEND_TRY(api_out_open(out, "stop", '{'));
    if (!isinf(rules->least[k])) PEND_TRY(api_out_number(out, "min", rules->least[k], 0));
    if (!isinf(rules->most[k])) PEND_TRY(api_out_number(out, "max", rules->most[k], 0));
    PEND_TRY(api_out_number(out, "restitution", rules->restitution[k], 0));
    return api_buffer_text(out, "}");
}

static enum pend_status write_field(const struct pend_loads *loads,
                                    const struct api_terms_row *field, int k,
                                    struct api_buffer *out) {
    int waves = field->kind == API_TERMS_DRIVE && has_harmonics(loads->terms, k),
        drive = waves || (field->kind == API_TERMS_DRIVE && drive_table(loads->terms, k)),
        says = drive;
    for (const struct api_terms_part *part = field->part; part->unit; part++)
        says |= part_says(loads, part, k);
    if (!says) return PEND_OK;
    if (field->kind == API_TERMS_PLAIN || (field->kind == API_TERMS_DRIVE && !drive))
        return write_part(loads, field->part, field->name, k, out);
    PEND_TRY(api_out_open(out, field->name, '{'));
    for (const struct api_terms_part *part = field->part; part->unit; part++)
        if (part->needed || part_says(loads, part, k))
            PEND_TRY(write_part(loads, part, part->name, k, out));
    if (waves) PEND_TRY(write_harmonics(loads, k, out));
    if (drive) PEND_TRY(write_table(loads->terms, k, out));
    return api_buffer_text(out, "}");
}

enum pend_status api_terms_write_arm(const struct pend_loads *loads, int k,
                                     struct api_buffer *out) {
    assert(!loads->terms || (pend_terms_valid(loads->terms) && k < loads->terms->n));
    for (int f = 0; loads->terms && f < API_TERMS_FIELDS; f++)
        PEND_TRY(write_field(loads, api_terms_row((enum api_terms_field)f), k, out));
    if (!loads->terms || !loads->terms->rules) return PEND_OK;
    PEND_TRY(write_coulomb(loads->terms->rules, "torque", k, out));
    return write_stop(loads->terms->rules, k, out);
}

static enum pend_status write_pivot(const struct pend_loads *loads, struct api_buffer *out) {
    static const struct {
        const char *name;
        int drives;
    } axes[] = {{"x", PEND_DRIVE_PIVOT_X}, {"y", PEND_DRIVE_PIVOT_Y}};
    const int *one = loads->terms->one;
    PEND_TRY(api_out_open(out, "pivot", '{'));
    for (int i = 0; i < 2; i++) {
        int waves = has_harmonics(loads->terms, axes[i].drives);
        if (!waves && !drive_table(loads->terms, axes[i].drives)) continue;
        PEND_TRY(api_out_open(out, axes[i].name, '{'));
        if (waves) PEND_TRY(write_harmonics(loads, axes[i].drives, out));
        PEND_TRY(write_table(loads->terms, axes[i].drives, out));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    if (one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0) {
        double both[2] = {loads->value[one[PEND_TERM_PIVOT_ACCELERATION_X]],
                          loads->value[one[PEND_TERM_PIVOT_ACCELERATION_Y]]};
        PEND_TRY(api_out_numbers(out, "acceleration", 2, both, 0));
    }
    return api_buffer_text(out, "}");
}

/* writes the force along the rail: a number, or a constant and harmonics */
static enum pend_status write_cart_force(const struct pend_loads *loads, struct api_buffer *out) {
    double constant = pend_terms_get(loads->terms, loads->value, PEND_TERM_TORQUE, 0);
    int waves = has_harmonics(loads->terms, 0);
    if (!waves && !drive_table(loads->terms, 0)) return api_out_number(out, "force", constant, 0);
    PEND_TRY(api_out_open(out, "force", '{'));
    PEND_TRY(api_out_number(out, "constant", constant, 0));
    if (waves) PEND_TRY(write_harmonics(loads, 0, out));
    PEND_TRY(write_table(loads->terms, 0, out));
    return api_buffer_text(out, "}");
}

static enum pend_status write_cart(const struct pend_tree *tree, const struct pend_loads *loads,
                                   struct api_buffer *out) {
    const struct pend_terms *terms = loads->terms;
    assert(pend_terms_cart(terms) && terms->n == tree->n);
    PEND_TRY(api_out_open(out, "pivot", '{'));
    PEND_TRY(api_out_open(out, "cart", '{'));
    PEND_TRY(api_out_number(out, "mass", tree->mass[0], 0));
    PEND_TRY(api_out_number(out, "angle", loads->value[terms->one[PEND_TERM_RAIL]], 0));
    PEND_TRY(api_out_number(out, "damping",
                            pend_terms_get(terms, loads->value, PEND_TERM_DAMPING, 0), 0));
    PEND_TRY(api_out_number(out, "stiffness",
                            pend_terms_get(terms, loads->value, PEND_TERM_STIFFNESS, 0), 0));
    PEND_TRY(write_cart_force(loads, out));
    PEND_TRY(write_coulomb(terms->rules, "force", 0, out));
    PEND_TRY(write_stop(terms->rules, 0, out));
    return api_buffer_text(out, "}}");
}

enum pend_status api_terms_write_whole(const struct pend_tree *tree, const struct pend_loads *loads,
                                       struct api_buffer *out) {
    const struct pend_terms *terms = loads->terms;
    if (!terms) return PEND_OK;
    assert(loads->value && pend_terms_valid(terms));
    int drag = terms->one[PEND_TERM_DRAG_PER_MASS];
    if (drag >= 0) PEND_TRY(api_out_number(out, "drag_per_mass", loads->value[drag], 0));
    if (pend_terms_cart(terms)) return write_cart(tree, loads, out);
    if (terms->one[PEND_TERM_PIVOT_ACCELERATION_X] < 0 && terms->one[PEND_TERM_PIVOT_TRACK] < 0 &&
        !has_harmonics(terms, PEND_DRIVE_PIVOT_X) && !has_harmonics(terms, PEND_DRIVE_PIVOT_Y))
        return PEND_OK;
    return write_pivot(loads, out);
}

double api_terms_write_bytes(const struct pend_loads *loads) {
    enum { NAMED_NUMBER = 48 }; /* bytes per number, including its name and its braces */
    const struct pend_rules *rules = loads->terms ? loads->terms->rules : NULL;
    double more = rules ? (double)rules->numbers : 0;
    return loads->terms ? 256 + NAMED_NUMBER * (loads->terms->count + more) : 0;
}

#include "api/op/fit/fits_terms.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/varied.h"
#include "api/read/terms_fields.h"

/* the set of terms */
struct wanted {
    unsigned char row[PEND_TERM_ROWS], one[PEND_TERM_ONES];
};

/* terms that have an effect without any other term */
static int is_alone(int row) {
    static const int alone[] = {PEND_TERM_ROD,       PEND_TERM_BODY,          PEND_TERM_DAMPING,
                                PEND_TERM_STIFFNESS, PEND_TERM_FRICTION,      PEND_TERM_TORQUE,
                                PEND_TERM_DRAG,      PEND_TERM_DRAG_QUADRATIC};
    for (size_t i = 0; i < sizeof alone / sizeof *alone; i++)
        if (alone[i] == row) return 1;
    return 0;
}

/* marks the term with this name; returns whether it is new */
static int wanted_name(struct wanted *wanted, const char *name) {
    for (int i = 0; i < PEND_TERM_OWN_ROWS + PEND_TERM_OWN_ONES; i++) {
        int one = i - PEND_TERM_OWN_ROWS;
        if (strcmp(name, api_varied_name(i)) != 0) continue;
        if (one < 0 ? !is_alone(i) : one == PEND_TERM_RAIL) return 0;
        unsigned char *mark = one < 0 ? &wanted->row[i] : &wanted->one[one], had = *mark;
        *mark = 1;
        return !had;
    }
    return 0;
}

/* copies the pendulum's numbers to their new indices */
static void terms_carry(const struct api_tree *tree, struct pend_terms *made, const int place[],
                        double value[]) {
    const struct pend_terms *had = tree->terms;
    pend_terms_clear(made, tree->tree, value);
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        for (int k = 0; made->row[r] >= 0 && k < made->n; k++) {
            if (had && had->row[r] >= 0)
                value[made->row[r] + k] = tree->value[had->row[r] + k];
            else if (r != PEND_TERM_AT_X)
                value[made->row[r] + k] = api_terms_usual((enum pend_term_row)r);
        }
    for (int one = 0; had && one < PEND_TERM_ONES; one++)
        if (had->one[one] >= 0) value[made->one[one]] = tree->value[had->one[one]];
    for (int h = 0; h < made->harmonics; h++)
        memcpy(&value[made->harmonic[h].at], &tree->value[had->harmonic[place[h]].at],
               3 * sizeof *value);
    if (had) memcpy(made->hung, had->hung, (size_t)made->n);
    if (had) made->rules = had->rules;
}

/* marks the present terms, and those that unknowns name; returns whether any is new */
static int wanted_all(struct wanted *wanted, const struct pend_terms *had,
                      const struct api_value *list) {
    int fresh = 0;
    for (int r = 0; had && r < PEND_TERM_ROWS; r++) wanted->row[r] = had->row[r] >= 0;
    for (int one = 0; had && one < PEND_TERM_ONES; one++) wanted->one[one] = had->one[one] >= 0;
    struct api_value item = api_value_item(list, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        struct api_value vary = api_value_member(&item, "vary");
        const char *name = api_value_text(&vary);
        if (name) fresh |= wanted_name(wanted, name);
    }
    return fresh;
}

enum pend_status api_fit_give_terms(struct api_tree *tree, const struct api_value *list) {
    const struct pend_terms *had = tree->terms;
    struct wanted wanted = {{0}, {0}};
    int harmonics = had ? had->harmonics : 0;
    if (!tree->tree || tree->cart || api_value_kind(list) != API_ARRAY) return PEND_OK;
    if (!wanted_all(&wanted, had, list)) return PEND_OK;
    struct pend_terms *made = NULL;
    int *drives = malloc(2 * ((size_t)harmonics + 1) * sizeof *drives);
    if (!drives) return PEND_NO_MEMORY;
    for (int h = 0; h < harmonics; h++) drives[h] = had->harmonic[h].drives;
    enum pend_status status = pend_terms_new(&made, tree->tree->n, wanted.row, wanted.one,
                                             harmonics, drives, drives + harmonics);
    double *value = status == PEND_OK ? malloc((size_t)made->count * sizeof *value) : NULL;
    if (value) {
        assert(made->harmonics == harmonics);
        terms_carry(tree, made, drives + harmonics, value);
        pend_terms_free(&tree->terms);
        free(tree->value);
        tree->terms = made, tree->value = value;
        tree->loads.terms = made, tree->loads.value = value;
    } else {
        pend_terms_free(&made);
        status = PEND_NO_MEMORY;
    }
    free(drives);
    return status;
}

/* POST /v1/equations: a pendulum's equations of motion written out, as formulas and as programs.
 * Leaves to others: the formulas and the programs (equations).
 * Invariant: the output contains only this pendulum's numbers, and no text of the client. */
#include "api/op/op.h"

#include <math.h>
#include <stdlib.h>

#include "api/json/json_out.h"
#include "api/op/equations/equations.h"
#include "api/op/terms_write.h"

static const char *const fields[] = {"pendulum", "initial", "form", NULL};
static const char *const forms[] = {"explicit", "compact", NULL};

struct equations {
    struct api_tree tree;
    struct api_states *start;
    int is_explicit;
    struct api_buffer text;
};

static void equations_clear(void *state) {
    struct equations *equations = state;
    api_buffer_clear(&equations->text);
    api_states_free(&equations->start);
    api_tree_clear(&equations->tree);
}

static void equations_read_form(struct equations *equations, const struct api_reading *reading) {
    struct api_value form = api_value_member(reading->root, "form");
    const struct pend_terms *terms = equations->tree.loads.terms;
    int n = equations->tree.n, word = n > API_EQUATIONS_EXPLICIT || terms;
    (void)api_field_word(&form, forms, &word, reading->problem);
    equations->is_explicit = word == 0;
    if (equations->is_explicit && terms)
        api_value_fault(&form, reading->problem,
                        API_CODE_UNSUPPORTED
                        "writes out every entry only for ideal pendulums, but this one has rods, "
                        "bodies, springs, friction or drives: ask for \"compact\"");
    if (equations->is_explicit && n > API_EQUATIONS_MOST)
        api_value_fault(
            &form, reading->problem,
            API_CODE_LIMIT
            "writes out every entry for at most %d arms, this pendulum has %d: ask for \"compact\"",
            API_EQUATIONS_MOST, n);
}

static enum pend_status equations_read_parts(struct equations *equations,
                                             const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    (void)api_value_only(reading->root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &equations->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK)
        PEND_TRY(api_states_new(&equations->start, 1, api_tree_stored(&equations->tree)));
    api_states_read(equations->start, 0, API_MEMBER(reading->root, "initial"), &equations->tree,
                    reading->limits, problem);
    equations_read_form(equations, reading);
    return problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status equations_read(void *state, const struct api_reading *reading) {
    struct equations *equations = state;
    api_buffer_init(&equations->text, (size_t)reading->limits->answer_bytes);
    return equations_read_parts(equations, reading);
}

static enum pend_status equations_say(struct equations *equations, enum api_equations_form form,
                                      const char *formula, const char *name,
                                      struct api_buffer *out) {
    struct api_equations written = {&equations->tree, equations->start->phi, equations->start->rate,
                                    equations->is_explicit};
    equations->text.bytes = 0;
    PEND_TRY(api_equations_write(&written, form, formula, &equations->text));
    PEND_TRY(api_buffer_add(&equations->text, "", 1));
    return api_out_text(out, name, equations->text.data);
}

static enum pend_status equations_write(struct equations *equations, const struct api_turn *turn) {
    struct api_buffer *out = turn->out;
    const char *formula;
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_whole(out, "n", equations->tree.n));
    PEND_TRY(api_out_text(out, "form", forms[!equations->is_explicit]));
    PEND_TRY(api_out_open(out, "latex", '{'));
    for (int i = 0; (formula = api_equations_formula(&equations->tree, i)); i++)
        PEND_TRY(equations_say(equations, API_EQUATIONS_LATEX, formula, formula, out));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(api_out_open(out, "code", '{'));
    PEND_TRY(equations_say(equations, API_EQUATIONS_MATLAB, NULL, "matlab", out));
    PEND_TRY(equations_say(equations, API_EQUATIONS_PYTHON, NULL, "python", out));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(equations_say(equations, API_EQUATIONS_CURL, NULL, "curl", out));
    return api_turn_close(turn);
}

static enum pend_status equations_run(void *state, const struct api_turn *turn, int *done,
                                      struct pend_error *error) {
    struct equations *equations = state;
    const struct api_states *start = equations->start;
    *done = 1;
    PEND_TRY(api_states_settle(equations->start, &equations->tree, error));
    for (int k = 0; k < start->n; k++)
        if (!isfinite(start->phi[k]) || !isfinite(start->rate[k])) return PEND_NOT_FINITE;
    return equations_write(equations, turn);
}

/* bytes for the text of one form at a time, and for the answer: some hundred per arm, some ten per
 * pair of arms if every entry is written out */
static double equations_bytes(const void *state) {
    const struct equations *equations = state;
    double n = equations->tree.n, square = equations->is_explicit ? n * n : 0;
    // the values of terms occur in three programs
    return API_OP_SMALL_BYTES + 4 * api_terms_write_bytes(&equations->tree.loads) + 2048 * n +
           2048 * square + api_tree_bytes(&equations->tree) + api_states_bytes(equations->start);
}

const struct api_op api_op_equations = {.name = "equations",
                                        .size = sizeof(struct equations),
                                        .body = 1,
                                        .terms = 1,
                                        .cart = 1,
                                        .pieces = 1,
                                        .read = equations_read,
                                        .run = equations_run,
                                        .bytes = equations_bytes,
                                        .clear = equations_clear};

#include "api/op/modes/modes_json.h"

#include <math.h>
#include <stdlib.h>

#include "api/op/modes/damped_json.h"

static const char *const modes_fields[] = {"pendulum",    "about",   "select",  "vectors",
                                           "normalize",   "include", "initial", "digits",
                                           "derivatives", NULL};

/* reads ["down", "up", ...], one for each arm */
static enum pend_status read_about(struct api_modes *modes, const struct api_value *value,
                                   struct api_problem *problem) {
    static const char *const words[] = {"down", "up", NULL};
    const struct pend_tree *tree = modes->tree.tree;
    struct api_value item = api_value_item(value, 0);
    if (api_value_kind(value) == API_MISSING) return PEND_OK;
    if (api_value_kind(value) != API_ARRAY || (tree && api_value_count(value) != modes->tree.n)) {
        api_value_fault(value, problem,
                        API_CODE_WRONG_COUNT
                        "must be an array with \"down\" or \"up\" for each of the %d arms",
                        modes->tree.n);
        return PEND_OK;
    }
    if (tree && !(modes->up = calloc((size_t)tree->n, 1))) return PEND_NO_MEMORY;
    int standing = 0;
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        int word = 0;
        if (api_field_word(&item, words, &word, problem) <= 0 || !tree) continue;
        modes->up[tree->place[item.index]] = (unsigned char)word;
        standing += word;
    }
    if (standing) return PEND_OK;
    free(modes->up);
    modes->up = NULL;
    return PEND_OK;
}

/* reads {"slowest": k} or {"fastest": k}; returns true if the object has that field */
static int read_extreme(struct api_modes *modes, const struct api_value *object, const char *name,
                        enum pend_select select, struct api_problem *problem) {
    struct api_value field = api_value_member(object, name);
    long count = 0;
    if (api_value_kind(&field) == API_MISSING) return 0;
    (void)api_field_whole(&field, 1, modes->tree.n ? modes->tree.n : 1000000000, &count, problem);
    modes->request.select = select;
    modes->request.count = (int)count;
    return 1;
}

/* reads {"from": w1, "to": w2} */
static void read_range(struct api_modes *modes, const struct api_value *object,
                       struct api_problem *problem) {
    struct api_value from = api_value_member(object, "from"), to = api_value_member(object, "to");
    modes->request.select = PEND_SELECT_BETWEEN;
    int good = api_field_needed(&from, problem) && api_field_needed(&to, problem);
    good &= api_value_read_number(&from, 0, INFINITY, "rad/s", &modes->request.from, problem) > 0;
    good &= api_value_read_number(&to, 0, INFINITY, "rad/s", &modes->request.to, problem) > 0;
    double low = modes->request.from, high = modes->request.to;
    if (good && low > high)
        api_value_fault(&to, problem,
                        API_CODE_ORDER "must not be below \"from\" (%.15g rad/s), got %.15g", low,
                        high);
}

static void read_select(struct api_modes *modes, const struct api_value *value,
                        struct api_problem *problem) {
    static const char *const words[] = {"all", NULL};
    static const char *const allowed[] = {"slowest", "fastest", "from", "to", NULL};
    int chosen;
    if (api_value_kind(value) == API_NUMBER || api_value_kind(value) == API_ARRAY) {
        char found[API_FOUND_BYTES];
        api_value_found(value, found);
        api_value_fault(value, problem,
                        API_CODE_WRONG_TYPE
                        "must be \"all\", or an object such as {\"slowest\": 3} or "
                        "{\"from\": 1, \"to\": 5}, in rad/s, got %s",
                        found);
        return;
    }
    if (api_value_kind(value) != API_OBJECT) {
        if (api_field_word(value, words, &chosen, problem) > 0) api_value_usual(value);
        return;
    }
    (void)api_value_only(value, allowed, problem);
    int ways = read_extreme(modes, value, "slowest", PEND_SELECT_SLOWEST, problem);
    ways += read_extreme(modes, value, "fastest", PEND_SELECT_FASTEST, problem);
    if (api_value_kind(API_MEMBER(value, "from")) != API_MISSING ||
        api_value_kind(API_MEMBER(value, "to")) != API_MISSING) {
        read_range(modes, value, problem);
        ways++;
    }
    if (ways != 1)
        api_value_fault(
            value, problem,
            API_CODE_WRONG_TYPE
            "must be \"all\", or have one of \"slowest\", \"fastest\", and \"from\" with \"to\"");
}

static void read_include(struct api_modes *modes, const struct api_value *value,
                         const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value item = api_value_item(value, 0);
    if (api_value_kind(value) == API_MISSING) return;
    if (api_value_kind(value) != API_ARRAY)
        api_value_fault(value, problem,
                        API_CODE_WRONG_TYPE
                        "must be an array of names of matrices, such as [\"A\"]");
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        int matrix = 0;
        if (api_field_word(&item, pend_matrix_names, &matrix, problem) <= 0) continue;
        if (modes->include[matrix])
            api_value_fault(&item, problem, API_CODE_DUPLICATE "\"%s\" is in the list already",
                            pend_matrix_names[matrix]);
        modes->include[matrix] = 1;
    }
    double most = reading->limits->matrix_arms;
    if (modes->tree.loads.terms) most = fmin(most, PEND_DAMPED_DENSE);
    if (api_value_count(value) && modes->tree.n > most)
        api_value_fault(value, problem,
                        API_CODE_LIMIT "matrices are returned for at most %.0f arms (%s), but this "
                                       "pendulum has %d: leave this field out",
                        most,
                        most < reading->limits->matrix_arms ? "of a real pendulum"
                                                            : "the limit max-matrix-arms",
                        modes->tree.n);
    if (api_value_count(value))
        api_reading_check_json(reading, value, "matrices are", "leave it out");
}

static void read_style(struct api_modes *modes, const struct api_value *root,
                       struct api_problem *problem) {
    static const char *const names[] = {"first", "mass", "max", NULL};
    static const enum pend_normalize rules[] = {PEND_NORMALIZE_FIRST, PEND_NORMALIZE_MASS,
                                                PEND_NORMALIZE_MAX};
    struct api_value vectors = api_value_member(root, "vectors"),
                     normalize = api_value_member(root, "normalize");
    int rule = 0;
    if (api_field_truth(&vectors, &modes->vectors, problem) > 0 && modes->vectors)
        api_value_usual(&vectors);
    if (api_field_word(&normalize, names, &rule, problem) > 0 && !rule) api_value_usual(&normalize);
    modes->request.normalize = rules[rule];
}

static enum pend_status read_derived(struct api_modes *modes, const struct api_value *value,
                                     struct api_problem *problem) {
    enum pend_status status = api_derived_read(&modes->derived, value, &modes->tree, problem);
    int starts = 0;
    for (int i = 0; i < modes->derived.count; i++)
        starts |= modes->derived.parameter[i].kind < PEND_PARAMETER_LENGTH;
    if (modes->derived.count &&
        (modes->tree.loads.terms || modes->up || modes->request.select || starts))
        api_value_fault(value, problem,
                        API_CODE_UNSUPPORTED
                        "are those of all modes of an ideal pendulum about hanging, by length, "
                        "mass or gravity: leave \"select\", \"about\" and other terms out");
    return status == PEND_NO_MEMORY ? status : PEND_OK;
}

/* adds errors for requests that modes of a real pendulum do not support: its equilibrium is
 * computed, and so are all modes */
static void check_real(const struct api_modes *modes, const struct api_reading *reading) {
    static const char *const absent[] = {"select", "normalize"};
    static const char *const way[] = {
        "all modes of a real pendulum are returned: leave it out",
        "the shapes of a real pendulum are scaled so that the largest entry is 1: leave it out"};
    for (size_t i = 0; i < sizeof absent / sizeof *absent; i++) {
        struct api_value field = api_value_member(reading->root, absent[i]);
        if (api_value_kind(&field) != API_MISSING)
            api_value_fault(&field, reading->problem, API_CODE_NOT_APPLICABLE "%s", way[i]);
    }
    if (modes->up && modes->start)
        api_value_fault(API_MEMBER(reading->root, "about"), reading->problem,
                        API_CODE_CONFLICT
                        "and \"initial\" both set the equilibrium: leave one out");
    const struct pend_loads *loads = &modes->tree.loads;
    int loses = pend_loads_lose(loads);
    int most = loses ? API_DAMPED_ARMS : API_STILL_ARMS;
    struct api_value pendulum = api_value_member(reading->root, "pendulum");
    if (modes->tree.n > most)
        api_value_fault(&pendulum, reading->problem,
                        API_CODE_LIMIT
                        "has %d arms; the modes of real pendulums are found for at most %d, or %d "
                        "without friction and drag",
                        modes->tree.n, API_DAMPED_ARMS, API_STILL_ARMS);
}

enum pend_status api_modes_read(struct api_modes *modes, const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(root, "initial");
    long rounded = 0;
    *modes = (struct api_modes){.vectors = 1};
    (void)api_value_only(root, modes_fields, problem);
    enum pend_status status = api_reading_tree(reading, &modes->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (modes->tree.n && !modes->tree.loads.terms)
        api_tree_modes_allowed(&modes->tree, API_MEMBER(root, "pendulum"), 0, "finding the modes",
                               reading->limits, problem);
    if (api_value_kind(&initial) != API_MISSING && status == PEND_OK)
        PEND_TRY(api_states_new(&modes->start, 1, api_tree_stored(&modes->tree)));
    api_states_read(modes->start, 0, &initial, &modes->tree, reading->limits, problem);
    PEND_TRY(read_about(modes, API_MEMBER(root, "about"), problem));
    read_select(modes, API_MEMBER(root, "select"), problem);
    read_style(modes, root, problem);
    read_include(modes, API_MEMBER(root, "include"), reading);
    PEND_TRY(read_derived(modes, API_MEMBER(root, "derivatives"), problem));
    (void)api_field_whole(API_MEMBER(root, "digits"), 1, 17, &rounded, problem);
    modes->digits = (int)rounded;
    if (modes->tree.loads.terms) check_real(modes, reading);
    return PEND_OK;
}

void api_modes_clear(struct api_modes *modes) {
    api_derived_clear(&modes->derived);
    free(modes->up);
    api_states_free(&modes->start);
    api_tree_clear(&modes->tree);
}

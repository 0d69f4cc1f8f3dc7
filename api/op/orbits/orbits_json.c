#include "api/op/orbits/orbits_json.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/varied.h"
#include "core/orbits/orbit_form.h"

static const char *const fields[] = {
    "pendulum", "mode",  "amplitude", "unit",   "energy", "initial", "periods", "settle",
    "step",     "count", "points",    "branch", "switch", "rows",    "digits",  NULL};
static const char *const branch_fields[] = {"vary", "arm", "harmonic", "to", NULL};

enum { POINTS_USUAL = 300, SETTLE_MOST = 100000 };
static const double pi = 3.14159265358979323846;

/* limits: smallest swing, rad, that doubles distinguish from rest; largest swing; largest energy,
 * J; longest step; default steps of a branch and of one orbit */
static const double amplitude_least = 1e-4, amplitude_most = 1000, energy_most = 1e300;
static const double step_most = 1, step_usual = 0.1, step_alone = 0.3;

static int present(const struct api_value *value) { return api_value_kind(value) != API_MISSING; }

/* adds errors for fields that do not apply to orbits of such a pendulum */
static void fault_others(const struct api_value *root, const char *const names[], const char *why,
                         struct api_problem *problem) {
    for (int i = 0; names[i]; i++) {
        struct api_value field = api_value_member(root, names[i]);
        if (present(&field)) api_value_fault(&field, problem, API_CODE_NOT_APPLICABLE "%s", why);
    }
}

/* ---- orbits between two states of rest */

static void read_amplitude(struct api_orbits *asked, const struct api_value *root,
                           struct api_problem *problem) {
    struct api_value amplitude = api_value_member(root, "amplitude");
    struct api_value energy = api_value_member(root, "energy");
    int degrees = 0;
    (void)api_field_word(API_MEMBER(root, "unit"), api_field_angles, &degrees, problem);
    double turn = degrees ? 180 / pi : 1;
    if (present(&amplitude) == present(&energy)) {
        api_value_fault(present(&energy) ? &energy : &amplitude, problem,
                        present(&energy) ? API_CODE_CONFLICT
                            "cannot be combined with an amplitude: orbits are "
                            "followed up to one of the two"
                                         : API_CODE_MISSING
                            "is required, or \"energy\": the end up to which orbits are followed, "
                            "starting from small swings");
        return;
    }
    if (present(&energy)) {
        asked->problem.target = PEND_ORBIT_ENERGY;
        (void)api_value_read_number(&energy, 1e-300, energy_most, "J", &asked->problem.until,
                                    problem);
        return;
    }
    asked->problem.target = PEND_ORBIT_AMPLITUDE;
    if (api_value_read_number(&amplitude, amplitude_least * turn, amplitude_most * turn,
                              degrees ? "deg" : "rad", &asked->problem.until, problem) > 0)
        asked->problem.until /= turn;
}

static void read_brake(struct api_orbits *asked, const struct api_value *root,
                       struct api_problem *problem) {
    static const char *const others[] = {"initial", "periods", "settle", NULL};
    struct api_value mode = api_value_member(root, "mode");
    struct api_value branch = api_value_member(root, "branch");
    const struct pend_loads *loads = &asked->tree.loads;
    long number = 1;
    fault_others(root, others, "is only for driven pendulums: this one has no drive", problem);
    if (loads->terms && asked->tree.tree && !pend_terms_conserve(loads->terms, loads->value)) {
        api_value_fault(API_MEMBER(root, "pendulum"), problem,
                        API_CODE_NOT_APPLICABLE
                        "gains or loses energy and has no periodic drive, so it has no periodic "
                        "motion: leave friction, drag and torques out, or give it a drive");
    }
    if (api_field_needed(&mode, problem))
        (void)api_field_whole(&mode, 1, asked->tree.n ? asked->tree.n : 1000000000, &number,
                              problem);
    asked->problem.mode = (int)number - 1;
    read_amplitude(asked, root, problem);
    if (api_value_kind(&branch) == API_OBJECT)
        api_value_fault(&branch, problem,
                        API_CODE_WRONG_TYPE "must be true or false: orbits of a mode are followed "
                                            "in their amplitude; other numbers need a drive");
    else if (api_field_truth(&branch, &asked->problem.branch, problem) > 0 &&
             !asked->problem.branch)
        api_value_usual(&branch);
}

/* ---- orbits of driven pendulums */

/* reads the varied number, unless it is the frequency of the drive */
static void read_varied(struct api_orbits *asked, const struct api_value *branch,
                        struct api_problem *problem) {
    struct api_value vary = api_value_member(branch, "vary");
    struct api_target target;
    if (!api_target_read(&target, branch, &asked->tree, problem)) return;
    const char *name = api_value_text(&vary);
    size_t bytes = strlen(name);
    if (target.quantity < API_VARY_LENGTH) {
        api_value_fault(&vary, problem,
                        API_CODE_NOT_APPLICABLE
                        "is computed for every orbit: vary a number of the pendulum, or \"omega\"");
        return;
    }
    if (bytes > 6 && !strcmp(name + bytes - 6, "_omega")) {
        api_value_fault(&vary, problem,
                        API_CODE_CONFLICT "would change only one of the drives: vary \"omega\", "
                                          "which changes all drives together");
        return;
    }
    asked->problem.vary = PEND_ORBIT_PARAMETER;
    asked->problem.by = api_target_parameter(&target);
}

static double value_from(const struct api_orbits *asked) {
    struct pend_parameter by = asked->problem.by;
    if (asked->problem.vary == PEND_ORBIT_OMEGA) return asked->omega;
    if (by.kind == PEND_PARAMETER_LENGTH) return asked->tree.tree->len[by.at];
    if (by.kind == PEND_PARAMETER_MASS) return asked->tree.tree->mass[by.at];
    return by.kind == PEND_PARAMETER_TERM ? asked->tree.value[by.at] : asked->tree.loads.gravity;
}

/* adds an error if the last value is invalid for the pendulum or equals the first */
static void check_end(const struct api_orbits *asked, const struct api_value *to,
                      struct api_problem *problem) {
    double from = value_from(asked), last = asked->problem.to;
    enum pend_parameter_kind kind = asked->problem.by.kind;
    int size = asked->problem.vary == PEND_ORBIT_OMEGA || kind == PEND_PARAMETER_LENGTH ||
               kind == PEND_PARAMETER_MASS;
    int good = size ? last > 0 : 1;
    assert(asked->problem.vary != PEND_ORBIT_ALONE);
    if (!size && kind == PEND_PARAMETER_TERM)
        good = pend_terms_fits(asked->tree.loads.terms, asked->problem.by.at, last);
    if (last == from)
        api_value_fault(to, problem,
                        API_CODE_NOT_APPLICABLE
                        "must differ from the value at which the branch begins, %.15g",
                        from);
    else if (!good)
        api_value_fault(to, problem,
                        API_CODE_OUT_OF_RANGE "is out of range for this number, got %.15g", last);
}

static void read_branch(struct api_orbits *asked, const struct api_value *branch,
                        struct api_problem *problem) {
    struct api_value to = api_value_member(branch, "to");
    const char *name = api_value_text(API_MEMBER(branch, "vary"));
    int omega = name && !strcmp(name, "omega");
    if (!present(branch) || !api_field_object(branch, branch_fields, problem)) return;
    asked->problem.branch = 1;
    if (omega) {
        static const char *const others[] = {"arm", "harmonic", NULL};
        asked->problem.vary = PEND_ORBIT_OMEGA;
        fault_others(branch, others, "cannot be combined with omega, which all drives share",
                     problem);
    } else {
        read_varied(asked, branch, problem);
    }
    int given = api_field_needed(&to, problem) &&
                api_value_read_number(&to, -1e9, 1e9, "", &asked->problem.to, problem) > 0;
    if (!given || problem->status || asked->problem.vary == PEND_ORBIT_ALONE) return;
    check_end(asked, &to, problem);
}

static enum pend_status read_driven(struct api_orbits *asked, const struct api_reading *reading) {
    static const char *const others[] = {"mode", "amplitude", "unit", "energy", NULL};
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(root, "initial");
    struct api_value periods = api_value_member(root, "periods");
    struct api_value settle = api_value_member(root, "settle");
    struct api_value pendulum = api_value_member(root, "pendulum");
    const struct pend_terms *terms = asked->tree.loads.terms;
    long whole = 1, wait = 0;
    asked->problem.driven = 1;
    fault_others(root, others,
                 "is only for orbits between two instants of rest: this pendulum is driven, and "
                 "the period of its orbits is a multiple of the drive's",
                 problem);
    if (!pend_orbit_drive(&asked->tree.loads, &asked->omega))
        api_value_fault(&pendulum, problem,
                        API_CODE_NOT_APPLICABLE
                        "has drives without a common period: their frequencies must be integer "
                        "multiples (at most 12) of one frequency");
    int air = terms->row[PEND_TERM_DRAG] >= 0 || terms->row[PEND_TERM_DRAG_QUADRATIC] >= 0 ||
              terms->one[PEND_TERM_DRAG_PER_MASS] >= 0;
    if (air && terms->one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0)
        api_value_fault(&pendulum, problem,
                        API_CODE_NOT_APPLICABLE
                        "has an accelerating pivot and drag, so no motion is periodic");
    if (present(&initial)) {
        PEND_TRY(api_states_new(&asked->start, 1, asked->tree.n));
        api_states_read(asked->start, 0, &initial, &asked->tree, reading->limits, problem);
    }
    (void)api_field_whole(&periods, 1, PEND_ORBIT_PERIODS, &whole, problem);
    api_value_usual_number(&periods, 1);
    (void)api_field_whole(&settle, 0, SETTLE_MOST, &wait, problem);
    api_value_usual_number(&settle, 0);
    asked->problem.periods = (int)whole;
    asked->problem.settle = (int)wait;
    read_branch(asked, API_MEMBER(root, "branch"), problem);
    if (asked->problem.vary != PEND_ORBIT_ALONE)
        asked->varies = asked->problem.vary == PEND_ORBIT_OMEGA ? "omega" : "value";
    return PEND_OK;
}

static void read_switch(struct api_orbits *asked, const struct api_value *root,
                        struct api_problem *problem) {
    struct api_value list = api_value_member(root, "switch");
    if (!present(&list)) return;
    int count = api_value_count(&list);
    if (api_value_kind(&list) != API_ARRAY || count < 1 || count > PEND_ORBIT_SWITCHES) {
        api_value_fault(&list, problem,
                        API_CODE_WRONG_TYPE
                        "must be a list of 1 to %d numbers of bifurcations, such as [1]: at each "
                        "of them the search switches to the branch that begins there",
                        PEND_ORBIT_SWITCHES);
        return;
    }
    if (!asked->problem.branch) {
        api_value_fault(&list, problem,
                        API_CODE_CONFLICT "needs a branch to switch from: give \"branch\" too");
        return;
    }
    for (int i = 0; i < count; i++) {
        struct api_value item = api_value_item(&list, i);
        long number = 1;
        if (api_field_whole(&item, -API_ORBITS_POINTS, API_ORBITS_POINTS, &number, problem) > 0 &&
            number == 0)
            api_value_fault(&item, problem,
                            API_CODE_OUT_OF_RANGE "must be 1 for the first bifurcation of a "
                                                  "branch, 2 for the next; a minus sign selects "
                                                  "the other side");
        asked->problem.leave[i] = (int)number;
    }
    asked->problem.switches = count;
}

/* reads which rows the answer has; a table has no place for bifurcations beside orbits */
static void read_rows(struct api_orbits *asked, const struct api_reading *reading) {
    static const char *const words[] = {"orbits", "bifurcations", NULL};
    struct api_problem *problem = reading->problem;
    struct api_value rows = api_value_member(reading->root, "rows");
    int named = api_field_word(&rows, words, &asked->rows, problem);
    if (!named && asked->problem.branch)
        api_reading_check_json(reading, &rows, "is missing: orbits and bifurcations together are",
                               "give \"orbits\" or \"bifurcations\"");
    if (named <= 0) return;
    if (!asked->rows) api_value_usual(&rows);
    if (asked->rows && !asked->problem.branch)
        api_value_fault(&rows, problem,
                        API_CODE_CONFLICT "needs a branch to search: give \"branch\" too");
}

enum pend_status api_orbits_read(struct api_orbits *asked, const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value pendulum = api_value_member(root, "pendulum");
    struct api_value points = api_field_renamed(root, "count", "points", problem);
    long most = POINTS_USUAL, rounded = 0;
    *asked = (struct api_orbits){.omega = 0};
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &asked->tree);
    if (status == PEND_NO_MEMORY) return status;
    const struct pend_terms *terms = asked->tree.loads.terms;
    if (asked->tree.n > API_ORBITS_ARMS)
        api_value_fault(&pendulum, problem,
                        API_CODE_LIMIT "has %d arms: orbits are supported for at most %d",
                        asked->tree.n, API_ORBITS_ARMS);
    if (asked->tree.tree && !terms && !pend_loads_pull_down(&asked->tree.loads))
        api_value_fault(&pendulum, problem,
                        API_CODE_NOT_APPLICABLE "has no gravity, so no mode oscillates");
    if (terms && asked->tree.tree && terms->harmonics)
        PEND_TRY(read_driven(asked, reading));
    else
        read_brake(asked, root, problem);
    read_switch(asked, root, problem);
    read_rows(asked, reading);
    asked->problem.step = asked->problem.branch ? step_usual : step_alone;
    (void)api_value_read_number(API_MEMBER(root, "step"), 1e-4, step_most, "", &asked->problem.step,
                                problem);
    (void)api_field_whole(&points, 2, API_ORBITS_POINTS, &most, problem);
    api_value_usual_number(&points, POINTS_USUAL);
    asked->problem.points = (int)most;
    (void)api_field_whole(API_MEMBER(root, "digits"), 1, 17, &rounded, problem);
    asked->digits = (int)rounded;
    return problem->status ? PEND_INVALID : PEND_OK;
}

void api_orbits_clear(struct api_orbits *asked) {
    api_states_free(&asked->start);
    api_tree_clear(&asked->tree);
}

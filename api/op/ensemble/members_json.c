#include "api/op/ensemble/members_json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const axis_fields[] = {"vary",  "arm",  "harmonic", "start", "stop",
                                          "scale", "unit", "count",    "with",  NULL};
static const char *const tied_fields[] = {"vary", "arm",   "harmonic", "start",
                                          "stop", "scale", "unit",     NULL};
static const char *const draw_fields[] = {"vary", "arm",  "harmonic",  "distribution", "low",
                                          "high", "mean", "deviation", "unit",         NULL};
static const char *const random_fields[] = {"count", "seed", "first", "draw", NULL};
static const char *const member_fields[] = {"initial", "length", "mass", "gravity",
                                            "energy",  "set",    NULL};

/* maximum number of paths tied to an axis; largest number of the first member, which must be exact
 * as a double */
enum { TIED_MOST = 64 };
static const long first_most = (1l << 53) - (1l << 32);

struct reading {
    const struct api_tree *tree;
    const struct api_limits *limits;
    struct api_problem *problem;
};

static int is_size(enum api_quantity quantity) {
    return quantity == API_VARY_LENGTH || quantity == API_VARY_MASS;
}

/* reads quantity, arm and unit; returns the factor that converts given numbers to SI units */
static double read_target(const struct api_value *value, const struct reading *reading,
                          struct api_variation *out) {
    struct api_value unit = api_value_member(value, "unit");
    struct api_target target;
    int degrees = 0;
    int named = api_energy_target(&target, value, reading->problem) ||
                api_target_read(&target, value, reading->tree, reading->problem);
    out->quantity = target.quantity, out->arm = target.arm, out->place = target.place;
    if (!named) return 1;
    if (api_field_word(&unit, api_field_angles, &degrees, reading->problem) > 0 &&
        out->quantity > API_VARY_THETAD)
        api_value_fault(&unit, reading->problem,
                        API_CODE_NOT_APPLICABLE "is only for angles and their rates: leave it out");
    return degrees ? M_PI / 180 : 1;
}

/* reads a number that must be present, and for a size positive */
static void read_end(const struct api_value *value, const struct api_variation *of, double scale,
                     double *out, struct api_problem *problem) {
    double x = 0;
    if (!api_field_needed(value, problem)) return;
    if (api_value_read_number(value, -INFINITY, INFINITY, "", &x, problem) <= 0) return;
    if ((is_size(of->quantity) || of->spread == API_SPREAD_LOG) && !(x > 0))
        api_value_fault(value, problem, API_CODE_OUT_OF_RANGE "must be greater than 0%s, got %g",
                        is_size(of->quantity) ? "" : " on a logarithmic scale", x);
    *out = scale * x;
}

/* adds an error for an end of an axis that is not a valid value of the term */
static void check_end(const struct api_value *value, const struct api_variation *of, double x,
                      const struct reading *reading) {
    if (of->quantity != API_VARY_TERM || of->place < 0 || !reading->tree->loads.terms) return;
    if (reading->problem->status || pend_terms_fits(reading->tree->loads.terms, of->place, x))
        return;
    api_value_fault(value, reading->problem,
                    API_CODE_ORDER "is %g, which is out of range for this number of a pendulum: it "
                                   "must be 0 or more, and a speed must be above 0",
                    x);
}

/* reads the path of a number along an axis */
static void read_path(const struct api_value *value, const struct reading *reading,
                      struct api_variation *out) {
    static const char *const scales[] = {"linear", "log", NULL};
    struct api_value scale = api_value_member(value, "scale"),
                     start = api_value_member(value, "start"),
                     stop = api_value_member(value, "stop");
    int spread = 0;
    double factor = read_target(value, reading, out);
    if (api_field_word(&scale, scales, &spread, reading->problem) > 0 && !spread)
        api_value_usual(&scale);
    out->spread = spread ? API_SPREAD_LOG : API_SPREAD_LINEAR;
    read_end(&start, out, factor, &out->from, reading->problem);
    read_end(&stop, out, factor, &out->to, reading->problem);
    check_end(&start, out, out->from, reading);
    check_end(&stop, out, out->to, reading);
    if (out->spread != API_SPREAD_LOG || !(out->from > 0 && out->to > 0)) return;
    out->from = log(out->from);
    out->to = log(out->to);
}

static void read_draw(const struct api_value *value, const struct reading *reading,
                      struct api_variation *out) {
    static const char *const kinds[] = {"uniform", "normal", NULL};
    struct api_value kind = api_value_member(value, "distribution");
    struct api_value low = api_value_member(value, "low"), high = api_value_member(value, "high");
    struct api_value mean = api_value_member(value, "mean"),
                     deviation = api_value_member(value, "deviation");
    int chosen = 0;
    (void)api_value_only(value, draw_fields, reading->problem);
    double factor = read_target(value, reading, out);
    if (!api_field_needed(&kind, reading->problem) ||
        api_field_word(&kind, kinds, &chosen, reading->problem) < 0)
        return;
    out->spread = chosen ? API_SPREAD_NORMAL : API_SPREAD_UNIFORM;
    const struct api_value *own[2] = {chosen ? &mean : &low, chosen ? &deviation : &high};
    const struct api_value *other[2] = {chosen ? &low : &mean, chosen ? &high : &deviation};
    for (int i = 0; i < 2; i++)
        if (api_value_kind(other[i]) != API_MISSING)
            api_value_fault(other[i], reading->problem,
                            API_CODE_NOT_APPLICABLE "has no meaning for the %s distribution",
                            kinds[chosen]);
    read_end(own[0], out, factor, &out->from, reading->problem);
    double second = 0;
    if (api_field_needed(own[1], reading->problem))
        (void)api_value_read_number(own[1], chosen ? 0 : -INFINITY, INFINITY, "", &second,
                                    reading->problem);
    out->to = factor * second;
    if (!chosen && out->to < out->from)
        api_value_fault(own[1], reading->problem,
                        API_CODE_ORDER "must not be less than \"low\", got %g", second);
}

/* true if an earlier variation varies the same number; phi and theta are the same, and so are their
 * rates */
static int is_repeated(const struct api_members *members, int at) {
    const struct api_variation *a = &members->variation[at];
    for (int i = 0; i < at; i++) {
        const struct api_variation *b = &members->variation[i];
        int same = a->quantity == b->quantity ||
                   (a->quantity < API_VARY_LENGTH && b->quantity < API_VARY_LENGTH &&
                    a->quantity / 2 == b->quantity / 2);
        if (same && a->arm == b->arm && a->place == b->place) return 1;
    }
    return 0;
}

/* appends a variation; adds an error if an earlier one varies the same number */
static void keep_variation(struct api_members *members, const struct api_value *value, int before,
                           const struct reading *reading) {
    if (!before && !reading->problem->status && is_repeated(members, members->variations))
        api_value_fault(value, reading->problem,
                        API_CODE_DUPLICATE "varies the same number as an earlier one");
    members->variations++;
}

static void read_axis(struct api_members *members, const struct api_value *value,
                      const struct reading *reading) {
    struct api_value count = api_value_member(value, "count"),
                     with = api_value_member(value, "with");
    struct api_value item = api_value_item(&with, 0);
    struct api_variation *out = &members->variation[members->variations];
    int before = reading->problem->status;
    (void)api_value_only(value, axis_fields, reading->problem);
    read_path(value, reading, out);
    out->count = 1;
    if (api_field_needed(&count, reading->problem))
        (void)api_field_whole(&count, 1, 1000000000, &out->count, reading->problem);
    long steps = members->axis_count[members->axes++] = out->count;
    keep_variation(members, value, before, reading);
    if (api_value_kind(&with) == API_MISSING) return;
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        out = &members->variation[members->variations];
        *out = (struct api_variation){.count = steps, .tied = 1};
        before = reading->problem->status;
        if (!api_field_object(&item, tied_fields, reading->problem)) continue;
        read_path(&item, reading, out);
        keep_variation(members, &item, before, reading);
    }
}

/* an upper bound of the number of variations in a list, including those tied to axes; -1 and an
 * error if it is too large */
static int count_variations(const struct api_value *list, int most, int draws,
                            const struct reading *reading) {
    int count = api_value_count(list), all = count;
    if (api_value_kind(list) != API_ARRAY || !count || count > most) {
        api_value_fault(
            list, reading->problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d %s%s", most,
            draws ? "draws" : "axes",
            api_value_kind(list) == API_OBJECT ? ", each an object: put [ ] around it" : "");
        return -1;
    }
    struct api_value item = api_value_item(list, 0);
    for (; !draws && api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        if (api_value_kind(&item) != API_OBJECT) continue;
        struct api_value with = api_value_member(&item, "with");
        int tied = api_value_count(&with);
        if (api_value_kind(&with) == API_MISSING) continue;
        if (api_value_kind(&with) == API_ARRAY && tied >= 1 && tied <= TIED_MOST) {
            all += tied;
            continue;
        }
        api_value_fault(&with, reading->problem,
                        API_CODE_WRONG_COUNT "must be an array of 1 to %d paths, which run from "
                                             "\"start\" to \"stop\" together with this axis",
                        TIED_MOST);
        return -1;
    }
    return all;
}

static enum pend_status read_variations(struct api_members *members, const struct api_value *list,
                                        int most, int draws, const struct reading *reading) {
    int all = count_variations(list, most, draws, reading);
    if (all < 0) return PEND_INVALID;
    members->variation = calloc((size_t)all, sizeof *members->variation);
    if (!members->variation) return PEND_NO_MEMORY;
    API_VALUE_EACH (item, api_value_item(list, 0)) {
        int before = reading->problem->status;
        if (!api_field_object(&item, NULL, reading->problem)) continue;
        if (!draws) {
            read_axis(members, &item, reading);
            continue;
        }
        read_draw(&item, reading, &members->variation[members->variations]);
        keep_variation(members, &item, before, reading);
    }
    return reading->problem->status ? PEND_INVALID : PEND_OK;
}

static void check_count(double count, const struct api_value *value,
                        const struct reading *reading) {
    if (count <= reading->limits->members) return;
    api_value_fault(value, reading->problem,
                    API_CODE_LIMIT "makes %.15g members, more than the limit %s of %.0f: ask for "
                                   "fewer, or split it into several requests",
                    count, api_limits_name(reading->limits, &reading->limits->members),
                    reading->limits->members);
}

static enum pend_status read_grid(struct api_members *members, const struct api_value *grid,
                                  const struct reading *reading) {
    double count = 1;
    PEND_TRY(read_variations(members, grid, API_AXES, 0, reading));
    for (int i = 0; i < members->axes; i++) count *= (double)members->axis_count[i];
    check_count(count, grid, reading);
    members->count = count <= reading->limits->members ? (long)count : 0;
    return PEND_OK;
}

static enum pend_status read_random(struct api_members *members, const struct api_value *random,
                                    const struct reading *reading) {
    if (!api_field_object(random, NULL, reading->problem)) return PEND_INVALID;
    struct api_value count = api_value_member(random, "count");
    struct api_value draw = api_value_member(random, "draw"),
                     first = api_value_member(random, "first");
    long number = 0,
         most = reading->tree->n ? (4 + PEND_TERM_OWN_ROWS) * api_tree_stored(reading->tree) + 64
                                 : 1000000,
         drawn = 0;
    (void)api_value_only(random, random_fields, reading->problem);
    if (api_field_needed(&count, reading->problem) &&
        api_field_whole(&count, 1, 1000000000, &number, reading->problem) > 0)
        check_count((double)number, &count, reading);
    if (api_field_whole(API_MEMBER(random, "seed"), 0, 1l << 53, &drawn, reading->problem) > 0)
        members->seed = (uint64_t)drawn;
    (void)api_field_whole(&first, 0, first_most, &members->first, reading->problem);
    api_value_usual_number(&first, 0);
    members->count = number;
    if (!api_field_needed(&draw, reading->problem)) return PEND_INVALID;
    return read_variations(members, &draw, (int)most, 1, reading);
}

/* creates the states of a list named `what`; its length must be within the limits */
static enum pend_status begin_list(struct api_members *members, const struct api_value *list,
                                   const char *what, const struct reading *reading) {
    long count = api_value_count(list);
    if (api_value_kind(list) != API_ARRAY || !count) {
        api_value_fault(list, reading->problem,
                        API_CODE_WRONG_COUNT "must be an array of at least one %s", what);
        return PEND_INVALID;
    }
    check_count((double)count, list, reading);
    if (reading->problem->status) return PEND_INVALID;
    PEND_TRY(api_states_new(&members->states, count, api_tree_stored(reading->tree)));
    members->listed = 1;
    members->count = count;
    return PEND_OK;
}

static enum pend_status read_states(struct api_members *members, const struct api_value *list,
                                    const struct reading *reading) {
    PEND_TRY(begin_list(members, list, "state", reading));
    API_VALUE_EACH (state, api_value_item(list, 0))
        api_states_read(members->states, state.index, &state, reading->tree, reading->limits,
                        reading->problem);
    return PEND_OK;
}

/* reads a listed member: its start, or the common one, and its own numbers */
static enum pend_status read_member(struct api_members *members, const struct api_value *member,
                                    const struct api_value *initial,
                                    const struct reading *reading) {
    struct api_value own = api_value_member(member, "initial");
    if (!api_field_object(member, member_fields, reading->problem)) return PEND_OK;
    api_states_read(members->states, member->index,
                    api_value_kind(&own) == API_MISSING ? initial : &own, reading->tree,
                    reading->limits, reading->problem);
    return api_sets_read(members->sets, member->index, member, reading->tree, reading->problem);
}

/* checks memory: a member of two characters in the request needs space for all numbers of a
 * start */
static void check_room(const struct api_value *list, const struct reading *reading) {
    const struct api_limits *limits = reading->limits;
    double state = 4.0 * api_tree_stored(reading->tree) + 2,
           bytes = api_value_count(list) * state * sizeof(double);
    if (bytes <= limits->answer_bytes) return;
    api_value_fault(list, reading->problem,
                    API_CODE_LIMIT "has starts that take %.0f bytes of memory, more than the limit "
                                   "%s of %.0f: split it into several requests",
                    bytes, api_limits_name(limits, &limits->answer_bytes), limits->answer_bytes);
}

static enum pend_status read_members(struct api_members *members, const struct api_value *list,
                                     const struct api_value *initial,
                                     const struct reading *reading) {
    // report an error in the common start only once
    api_states_read(NULL, 0, initial, reading->tree, reading->limits, reading->problem);
    check_room(list, reading);
    if (reading->problem->status) return PEND_INVALID;
    PEND_TRY(begin_list(members, list, "member", reading));
    PEND_TRY(api_sets_new(&members->sets, members->count));
    API_VALUE_EACH (member, api_value_item(list, 0))
        PEND_TRY(read_member(members, &member, initial, reading));
    return PEND_OK;
}

enum way { WAY_STATES, WAY_MEMBERS, WAY_GRID, WAY_RANDOM, WAYS };
static const char *const ways[WAYS] = {"states", "members", "grid", "random"};

static enum pend_status read_way(struct api_members *members, enum way chosen,
                                 const struct api_value *way, const struct api_value *root,
                                 const struct reading *reading) {
    struct api_value initial = api_value_member(root, "initial");
    if (chosen == WAY_STATES && api_value_kind(&initial) != API_MISSING)
        api_value_fault(&initial, reading->problem,
                        API_CODE_CONFLICT
                        "cannot be combined with \"states\", which give the start of each member");
    if (chosen == WAY_STATES) return read_states(members, way, reading);
    if (chosen == WAY_MEMBERS) return read_members(members, way, &initial, reading);
    if (reading->tree->n)
        PEND_TRY(api_states_new(&members->states, 1, api_tree_stored(reading->tree)));
    api_states_read(members->states, 0, &initial, reading->tree, reading->limits, reading->problem);
    return chosen == WAY_GRID ? read_grid(members, way, reading)
                              : read_random(members, way, reading);
}

/* true if a start has a rate that could be scaled, or may get one */
static int can_move(const struct api_members *members, long i) {
    const struct api_states *states = members->states;
    for (int v = 0; v < members->variations; v++)
        if (members->variation[v].quantity == API_VARY_PHID ||
            members->variation[v].quantity == API_VARY_THETAD)
            return 1;
    for (int k = 0; k < states->n; k++)
        if (states->rate[i * states->n + k] != 0) return 1;
    return members->sets && api_sets_moves(members->sets, i);
}

/* adds errors for members with a given energy that cannot move */
static void check_moves(const struct api_members *members, const struct api_value *at,
                        const struct reading *reading) {
    for (long i = 0; i < members->states->count; i++) {
        int asked = !isnan(members->energy) || !members->sets || api_sets_energy(members->sets, i);
        if (members->states->mode[i] || !asked || can_move(members, i)) continue;
        char which[40] = "";
        if (members->listed) snprintf(which, sizeof which, " of member %ld", i);
        api_value_fault(at, reading->problem,
                        API_CODE_MISSING
                        "the energy is reached by scaling rates, and all rates%s are 0: give "
                        "\"thetad\" or \"phid\"",
                        which);
        return;
    }
}

static void read_energy(struct api_members *members, const struct api_value *root,
                        const struct reading *reading) {
    struct api_value energy = api_value_member(root, "energy");
    int varied = 0;
    members->energy = NAN;
    if (api_value_read_number(&energy, -INFINITY, INFINITY, "J", &members->energy,
                              reading->problem) > 0)
        members->on_energy = 1;
    for (int v = 0; v < members->variations; v++)
        varied |= members->variation[v].quantity == API_VARY_ENERGY;
    if (varied && members->on_energy)
        api_value_fault(
            &energy, reading->problem,
            API_CODE_CONFLICT
            "applies to all members, but a variation varies it too: give only one of them");
    if (members->sets) varied |= api_sets_energies(members->sets);
    members->on_energy |= varied;
    if (members->on_energy && !reading->problem->status)
        check_moves(members, api_value_kind(&energy) == API_MISSING ? root : &energy, reading);
}

/* lists the term values that vary, each once */
static enum pend_status list_shown(struct api_members *members) {
    size_t most = (size_t)members->variations;
    if (members->sets && members->terms) most = (size_t)members->terms->count;
    if (!most) return PEND_OK;
    members->shown_place = calloc(most, sizeof *members->shown_place);
    if (!members->shown_place) return PEND_NO_MEMORY;
    for (int v = 0; v < members->variations; v++)
        if (members->variation[v].quantity == API_VARY_TERM)
            members->shown_place[members->shown++] = members->variation[v].place;
    if (members->sets && members->terms)
        return api_sets_places(members->sets, members->terms->count, members->shown_place,
                               &members->shown);
    return PEND_OK;
}

enum pend_status api_members_read(struct api_members *members, const struct api_value *root,
                                  const struct api_tree *tree, const struct api_limits *limits,
                                  struct api_problem *problem) {
    struct reading reading = {tree, limits, problem};
    struct api_value way[WAYS];
    int chosen = -1;
    *members = (struct api_members){.terms = tree->loads.terms, .energy = NAN};
    for (int i = 0; i < WAYS; i++) {
        way[i] = api_value_member(root, ways[i]);
        if (api_value_kind(&way[i]) == API_MISSING) continue;
        if (chosen >= 0)
            api_value_fault(
                &way[i], problem,
                API_CODE_CONFLICT "cannot be combined with \"%s\": give one of the two%s",
                ways[chosen], chosen ? "" : "; \"initial\" is the common start of all members");
        else
            chosen = i;
    }
    if (chosen < 0) {
        api_value_fault(root, problem,
                        API_CODE_MISSING
                        "needs members: \"states\", \"members\", \"grid\" or \"random\"");
        return PEND_INVALID;
    }
    PEND_TRY(read_way(members, (enum way)chosen, &way[chosen], root, &reading));
    read_energy(members, root, &reading);
    return problem->status ? PEND_INVALID : list_shown(members);
}

void api_members_clear(struct api_members *members) {
    api_states_free(&members->states);
    api_sets_free(&members->sets);
    free(members->variation);
    free(members->shown_place);
    members->variation = NULL;
    members->shown_place = NULL;
}

double api_members_bytes(const struct api_members *members) {
    return (double)members->variations * (sizeof *members->variation + sizeof(int)) +
           (members->sets ? api_sets_bytes(members->sets) : 0);
}

#include "api/op/members_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/varied.h"
#include "core/base/rng.h"
#include "core/tree/turns.h"

static const double pi = 3.14159265358979323846;

static const char *const axis_fields[] = {"vary",  "arm",   "harmonic", "start", "stop",
                                          "count", "scale", "unit",     NULL};
static const char *const draw_fields[] = {"vary", "arm",  "harmonic",  "distribution", "low",
                                          "high", "mean", "deviation", "unit",         NULL};
static const char *const random_fields[] = {"count", "seed", "draw", NULL};

/* the context in which a variation is read */
struct reading {
    const struct api_tree *tree;
    const struct api_limits *limits;
    struct api_problem *problem;
};

/* true for quantities that must be positive */
static int is_size(enum api_quantity quantity) {
    return quantity == API_VARY_LENGTH || quantity == API_VARY_MASS;
}

/* reads quantity, arm and unit; returns the factor that converts the given numbers to SI */
static double read_target(const struct api_value *value, const struct reading *reading,
                          struct api_variation *out) {
    static const char *const units[] = {"rad", "deg", NULL};
    struct api_value unit = api_value_member(value, "unit");
    struct api_target target;
    int degrees = 0;
    int named = api_target_read(&target, value, reading->tree, reading->problem);
    out->quantity = target.quantity, out->arm = target.arm, out->place = target.place;
    if (!named) return 1;
    if (api_field_word(&unit, units, &degrees, reading->problem) > 0 &&
        out->quantity > API_VARY_THETAD)
        api_value_fault(&unit, reading->problem, "is for angles and their rates: leave it out");
    return degrees ? pi / 180 : 1;
}

/* reads a number that must be present; a size must be positive */
static void read_end(const struct api_value *value, const struct api_variation *of, double scale,
                     double *out, struct api_problem *problem) {
    double x = 0;
    if (!api_field_needed(value, problem)) return;
    if (api_value_read_number(value, -INFINITY, INFINITY, "", &x, problem) <= 0) return;
    if ((is_size(of->quantity) || of->spread == API_SPREAD_LOG) && !(x > 0))
        api_value_fault(value, problem, "must be greater than 0%s, got %g",
                        is_size(of->quantity) ? "" : " on a logarithmic scale", x);
    *out = scale * x;
}

/* the ends of an axis over a term must be what the term may be */
static void check_end(const struct api_value *value, const struct api_variation *of, double x,
                      const struct reading *reading) {
    if (of->quantity != API_VARY_TERM || of->place < 0 || !reading->tree->loads.terms) return;
    if (reading->problem->status || pend_terms_fits(reading->tree->loads.terms, of->place, x))
        return;
    api_value_fault(value, reading->problem,
                    "is %g, which this number of a pendulum cannot be: it must not be below 0, and "
                    "a speed must be above 0",
                    x);
}

static void read_axis(const struct api_value *value, const struct reading *reading,
                      struct api_variation *out) {
    static const char *const scales[] = {"linear", "log", NULL};
    struct api_value scale = api_value_member(value, "scale"),
                     count = api_value_member(value, "count");
    struct api_value start = api_value_member(value, "start"),
                     stop = api_value_member(value, "stop");
    int spread = 0;
    (void)api_value_only(value, axis_fields, reading->problem);
    double factor = read_target(value, reading, out);
    if (api_field_word(&scale, scales, &spread, reading->problem) > 0 && !spread)
        api_value_usual(&scale);
    out->spread = spread ? API_SPREAD_LOG : API_SPREAD_LINEAR;
    read_end(&start, out, factor, &out->from, reading->problem);
    read_end(&stop, out, factor, &out->to, reading->problem);
    check_end(&start, out, out->from, reading);
    check_end(&stop, out, out->to, reading);
    out->count = 1;
    if (api_field_needed(&count, reading->problem))
        (void)api_field_whole(&count, 1, 1000000000, &out->count, reading->problem);
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
            api_value_fault(other[i], reading->problem, "has no meaning for the %s distribution",
                            kinds[chosen]);
    read_end(own[0], out, factor, &out->from, reading->problem);
    double second = 0;
    if (api_field_needed(own[1], reading->problem))
        (void)api_value_read_number(own[1], chosen ? 0 : -INFINITY, INFINITY, "", &second,
                                    reading->problem);
    out->to = factor * second;
    if (!chosen && out->to < out->from)
        api_value_fault(own[1], reading->problem, "must not be less than \"low\", got %g", second);
}

/* true if an earlier variation has the same value; phi and theta are the same, and so are their
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

/* reads the axes of a grid or the draws */
static enum pend_status read_variations(struct api_members *members, const struct api_value *list,
                                        int most, int draws, const struct reading *reading) {
    int count = api_value_count(list);
    if (api_value_kind(list) != API_ARRAY || !count || count > most) {
        api_value_fault(list, reading->problem, "must be an array of 1 to %d %s", most,
                        draws ? "draws" : "axes");
        return PEND_INVALID;
    }
    members->variation = calloc((size_t)count, sizeof *members->variation);
    if (!members->variation) return PEND_NO_MEMORY;
    struct api_value item = api_value_item(list, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        struct api_variation *out = &members->variation[item.index];
        if (!api_field_object(&item, reading->problem)) continue;
        int before = reading->problem->status;
        if (draws)
            read_draw(&item, reading, out);
        else
            read_axis(&item, reading, out);
        if (!before && !reading->problem->status && is_repeated(members, item.index))
            api_value_fault(&item, reading->problem, "varies what an earlier one varies already");
    }
    members->variations = count;
    return reading->problem->status ? PEND_INVALID : PEND_OK;
}

static void check_count(double count, const struct api_value *value,
                        const struct reading *reading) {
    if (count <= reading->limits->members) return;
    api_value_fault(
        value, reading->problem,
        "makes %.15g members, more than the limit %s of %.0f: ask for fewer, or for parts of it in "
        "several requests",
        count, api_limits_name(reading->limits, &reading->limits->members),
        reading->limits->members);
}

enum { AXES_MOST = 8 };

static enum pend_status read_grid(struct api_members *members, const struct api_value *grid,
                                  const struct reading *reading) {
    double count = 1;
    PEND_TRY(read_variations(members, grid, AXES_MOST, 0, reading));
    for (int i = 0; i < members->variations; i++) count *= (double)members->variation[i].count;
    check_count(count, grid, reading);
    members->count = count <= reading->limits->members ? (long)count : 0;
    return PEND_OK;
}

static enum pend_status read_random(struct api_members *members, const struct api_value *random,
                                    const struct reading *reading) {
    if (!api_field_object(random, reading->problem)) return PEND_INVALID;
    struct api_value count = api_value_member(random, "count"),
                     seed = api_value_member(random, "seed");
    struct api_value draw = api_value_member(random, "draw");
    long number = 0,
         most = reading->tree->n ? (4 + PEND_TERM_ROWS) * api_tree_stored(reading->tree) + 64
                                 : 1000000,
         drawn = 0;
    (void)api_value_only(random, random_fields, reading->problem);
    if (api_field_needed(&count, reading->problem) &&
        api_field_whole(&count, 1, 1000000000, &number, reading->problem) > 0)
        check_count((double)number, &count, reading);
    if (api_field_whole(&seed, 0, 1l << 53, &drawn, reading->problem) > 0)
        members->seed = (uint64_t)drawn;
    members->count = number;
    if (!api_field_needed(&draw, reading->problem)) return PEND_INVALID;
    return read_variations(members, &draw, (int)most, 1, reading);
}

static enum pend_status read_listed(struct api_members *members, const struct api_value *list,
                                    const struct reading *reading) {
    long count = api_value_count(list);
    if (api_value_kind(list) != API_ARRAY || !count) {
        api_value_fault(list, reading->problem, "must be an array of at least one state");
        return PEND_INVALID;
    }
    check_count((double)count, list, reading);
    if (reading->problem->status) return PEND_INVALID;
    PEND_TRY(api_states_new(&members->states, count, api_tree_stored(reading->tree)));
    members->listed = 1;
    members->count = count;
    struct api_value state = api_value_item(list, 0);
    for (; api_value_kind(&state) != API_MISSING; state = api_value_next(&state))
        api_states_read(members->states, state.index, &state, reading->tree, reading->limits,
                        reading->problem);
    return PEND_OK;
}

enum pend_status api_members_read(struct api_members *members, const struct api_value *root,
                                  const struct api_tree *tree, const struct api_limits *limits,
                                  struct api_problem *problem) {
    static const char *const ways[] = {"states", "grid", "random"};
    struct reading reading = {tree, limits, problem};
    struct api_value way[3], initial = api_value_member(root, "initial");
    int chosen = -1;
    *members = (struct api_members){.terms = tree->loads.terms};
    for (int i = 0; i < 3; i++) {
        way[i] = api_value_member(root, ways[i]);
        if (api_value_kind(&way[i]) == API_MISSING) continue;
        if (chosen >= 0)
            api_value_fault(&way[i], problem,
                            "does not go together with \"%s\": give one of the two%s", ways[chosen],
                            chosen ? "" : "; where all members start is \"initial\"");
        else
            chosen = i;
    }
    if (chosen < 0) {
        api_value_fault(root, problem, "needs members: \"states\", \"grid\" or \"random\"");
        return PEND_INVALID;
    }
    if (chosen == 0 && api_value_kind(&initial) != API_MISSING)
        api_value_fault(&initial, problem,
                        "does not go together with \"states\", which say how each member starts");
    if (chosen == 0) return read_listed(members, &way[0], &reading);
    if (tree->n) PEND_TRY(api_states_new(&members->states, 1, api_tree_stored(tree)));
    api_states_read(members->states, 0, &initial, tree, limits, problem);
    return chosen == 1 ? read_grid(members, &way[1], &reading)
                       : read_random(members, &way[2], &reading);
}

int api_members_varied(const struct api_members *members) {
    int count = 0;
    for (int v = 0; v < members->variations; v++)
        count += members->variation[v].quantity == API_VARY_TERM;
    return count;
}

void api_members_clear(struct api_members *members) {
    api_states_free(&members->states);
    free(members->variation);
    members->variation = NULL;
}

/* the value of a variation in a member; `step` of an axis */
static double member_value(const struct api_members *members, const struct api_variation *of,
                           long i, long step, uint32_t place) {
    if (of->spread == API_SPREAD_UNIFORM)
        return of->from + (of->to - of->from) * pend_rng_uniform(members->seed, (uint64_t)i, place);
    if (of->spread == API_SPREAD_NORMAL)
        return of->from + of->to * pend_rng_normal(members->seed, (uint64_t)i, place);
    // both ends exactly
    double part = of->count > 1 ? (double)step / (double)(of->count - 1) : 0;
    double x =
        step == of->count - 1 && of->count > 1 ? of->to : of->from + (of->to - of->from) * part;
    return of->spread == API_SPREAD_LOG ? exp(x) : x;
}

static void member_set(const struct api_members *members, struct pend_member *member,
                       const struct api_variation *of, double x) {
    assert(of->quantity >= API_VARY_GRAVITY || of->arm >= 0);
    double size = x > 0 && isfinite(x) ? x : NAN;
    struct pend_sum hanging;
    switch (of->quantity) {
    case API_VARY_PHI:
        member->phi[of->arm] = x;
        if (member->phi_low) member->phi_low[of->arm] = 0;
        break;
    case API_VARY_THETA:
        hanging = pend_turns_hanging(x);
        member->phi[of->arm] = hanging.high;
        if (member->phi_low) member->phi_low[of->arm] = hanging.low;
        break;
    case API_VARY_PHID:
    case API_VARY_THETAD:
        member->rate[of->arm] = x;
        break;
    case API_VARY_LENGTH:
        member->length[of->arm] = size;
        break;
    case API_VARY_MASS:
        member->mass[of->arm] = size;
        break;
    case API_VARY_TERM:
        member->value[of->place] = pend_terms_fits(members->terms, of->place, x) ? x : NAN;
        break;
    default:
        member->loads.gravity = x;
        break;
    }
}

void api_members_fill(const struct api_members *members, int n, long i,
                      struct pend_member *member) {
    assert(i >= 0 && i < members->count && n >= 1);
    size_t state = members->listed ? (size_t)i * (size_t)n : 0, bytes = (size_t)n * sizeof(double);
    long rest = i;
    memcpy(member->phi, members->states->phi + state, bytes);
    memcpy(member->rate, members->states->rate + state, bytes);
    if (member->phi_low) memcpy(member->phi_low, members->states->phi_low + state, bytes);
    for (int v = 0; v < members->variations; v++) {
        const struct api_variation *of = &members->variation[v];
        long step = of->count ? rest % of->count : 0;
        if (of->count) rest /= of->count;
        member_set(members, member, of, member_value(members, of, i, step, (uint32_t)v));
    }
}

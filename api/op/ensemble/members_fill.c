#include "api/op/ensemble/members_fill.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/base/rng.h"
#include "core/tree/turns.h"

int api_members_shapes(const struct api_members *members) {
    for (int v = 0; v < members->variations; v++)
        if (members->variation[v].quantity >= API_VARY_LENGTH &&
            members->variation[v].quantity <= API_VARY_TERM)
            return 1;
    return members->sets && api_sets_shapes(members->sets);
}

/* the value of a variation in a member; `step` is the index on an axis */
static double member_value(const struct api_members *members, const struct api_variation *of,
                           long i, long step, uint32_t place) {
    uint64_t member = (uint64_t)(members->first + i);
    if (of->spread == API_SPREAD_UNIFORM)
        return of->from + (of->to - of->from) * pend_rng_uniform(members->seed, member, place);
    if (of->spread == API_SPREAD_NORMAL)
        return of->from + of->to * pend_rng_normal(members->seed, member, place);
    // exact at both ends of the axis
    double part = of->count > 1 ? (double)step / (double)(of->count - 1) : 0;
    double x =
        step == of->count - 1 && of->count > 1 ? of->to : of->from + (of->to - of->from) * part;
    return of->spread == API_SPREAD_LOG ? exp(x) : x;
}

static void member_set(const struct api_members *members, struct pend_member *member,
                       enum api_quantity quantity, int arm, int place, double x) {
    assert(quantity == API_VARY_GRAVITY || quantity == API_VARY_TERM || arm >= 0);
    double size = x > 0 && isfinite(x) ? x : NAN;
    struct pend_sum hanging;
    switch (quantity) {
    case API_VARY_PHI:
        member->phi[arm] = x;
        if (member->phi_low) member->phi_low[arm] = 0;
        break;
    case API_VARY_THETA:
        hanging = pend_turns_hanging(x);
        member->phi[arm] = hanging.high;
        if (member->phi_low) member->phi_low[arm] = hanging.low;
        break;
    case API_VARY_PHID:
    case API_VARY_THETAD:
        member->rate[arm] = x;
        break;
    case API_VARY_LENGTH:
        member->length[arm] = size;
        break;
    case API_VARY_MASS:
        member->mass[arm] = size;
        break;
    case API_VARY_TERM:
        member->value[place] = pend_terms_fits(members->terms, place, x) ? x : NAN;
        break;
    default:
        member->loads.gravity = x;
        break;
    }
}

/* sets the numbers of a listed member; returns its energy, NaN if it has none */
static double member_sets(const struct api_members *members, long i, struct pend_member *member) {
    double energy = NAN;
    const struct api_set *end = api_sets_end(members->sets, i);
    for (const struct api_set *set = api_sets_begin(members->sets, i); set < end; set++)
        if (set->quantity == API_VARY_ENERGY)
            energy = set->x;
        else
            member_set(members, member, set->quantity, set->at, set->at, set->x);
    return energy;
}

void api_members_fill(const struct api_members *members, const struct pend_tree *tree, long i,
                      struct pend_member *member, double room[]) {
    size_t n = (size_t)tree->n, state = members->listed ? (size_t)i * n : 0,
           bytes = n * sizeof(double);
    long rest = i, step = 0;
    double energy = members->energy;
    assert(i >= 0 && i < members->count && n >= 1);
    memcpy(member->phi, members->states->phi + state, bytes);
    memcpy(member->rate, members->states->rate + state, bytes);
    if (member->phi_low) memcpy(member->phi_low, members->states->phi_low + state, bytes);
    for (int v = 0; v < members->variations; v++) {
        const struct api_variation *of = &members->variation[v];
        if (of->count && !of->tied) step = rest % of->count, rest /= of->count;
        double x = member_value(members, of, i, step, (uint32_t)v);
        if (of->quantity == API_VARY_ENERGY)
            energy = x;
        else
            member_set(members, member, of->quantity, of->arm, of->place, x);
    }
    if (members->sets) {
        double own = member_sets(members, i, member);
        if (!isnan(own)) energy = own;
    }
    if (members->on_energy && !isnan(energy)) api_energy_reach(tree, member, energy, room);
}

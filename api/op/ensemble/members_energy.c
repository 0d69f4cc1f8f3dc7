#include "api/op/ensemble/members_energy.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"

/* relative to the scale of energies: the largest rounding difference between two sums of one
 * energy */
static const double rounding = 1e-14;

int api_energy_target(struct api_target *target, const struct api_value *value,
                      struct api_problem *problem) {
    struct api_value arm = api_value_member(value, "arm"),
                     harmonic = api_value_member(value, "harmonic");
    const char *text = api_value_text(API_MEMBER(value, "vary"));
    if (!text || strcmp(text, "energy") != 0) return 0;
    *target = (struct api_target){.quantity = API_VARY_ENERGY, .arm = -1, .place = -1};
    if (api_value_kind(&arm) != API_MISSING)
        api_value_fault(&arm, problem,
                        API_CODE_CONFLICT
                        "cannot be combined with energy, which belongs to the whole pendulum");
    if (api_value_kind(&harmonic) != API_MISSING)
        api_value_fault(&harmonic, problem,
                        API_CODE_NOT_APPLICABLE "has no meaning for energy: leave it out");
    return 1;
}

/* kinetic and potential energy if the rates are multiplied by a factor */
static struct pend_energy energy_at(const struct pend_tree *tree, const struct pend_member *member,
                                    double factor, double rate[], double scratch[]) {
    for (int k = 0; k < tree->n; k++) rate[k] = factor * member->rate[k];
    return pend_kinematics_energy_at(tree, &member->loads, member->start, member->phi, rate,
                                     scratch);
}

/* the factor f >= 0 that solves a f^2 + b f = gap; NaN if there is none */
static double energy_factor(double a, double b, double gap) {
    if (!(a > 0)) return gap == 0 ? 1 : NAN;
    double root = sqrt(b * b + 4 * a * gap);
    // after an overflow, the factor below would be 0 and give another energy
    if (!isfinite(root)) return NAN;
    double factor = b > 0 ? 2 * gap / (b + root) : (root - b) / (2 * a);
    return factor >= 0 && isfinite(factor) ? factor : NAN;
}

void api_energy_reach(const struct pend_tree *tree, struct pend_member *member, double energy,
                      double room[]) {
    int n = tree->n;
    double *rate = room + n, *scratch = rate + n;
    struct pend_tree own = pend_member_tree(tree, member, room);
    assert(n >= 1 && member->phi && member->rate);
    // if the pivot moves, there is kinetic energy at rates of 0, and the sign of the rates matters
    struct pend_energy still = energy_at(&own, member, 0, rate, scratch),
                       ahead = energy_at(&own, member, 1, rate, scratch),
                       back = energy_at(&own, member, -1, rate, scratch);
    double a = (ahead.kinetic + back.kinetic) / 2 - still.kinetic,
           b = (ahead.kinetic - back.kinetic) / 2, gap = energy - still.potential - still.kinetic,
           scale = pend_kinematics_energy_scale_at(&own, &member->loads, still.kinetic);
    if (fabs(gap) <= rounding * fmax(scale, fabs(energy))) gap = 0;
    double factor = energy_factor(a, b, gap);
    for (int k = 0; k < n; k++) member->rate[k] *= factor;
}

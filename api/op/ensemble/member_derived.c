#include "api/op/ensemble/member_derived.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* arm evaluations per call, about half a millisecond */
static const double piece = 25000;

struct api_member_derived {
    struct api_member_derived_of of;
    struct api_derived derived; /* a copy that contains the rows of the current member */
    struct pend_tree tree;      /* the member's own tree */
    struct pend_member member;
    double *subtree, *room; /* room: scratch of api_members_fill */
    double ends[2];         /* s, both ends of the motion */
    long rows;
    int skipped; /* whether the row of the first instant, which is not reported, is complete */
};

static size_t terms_of(const struct api_tree *tree) {
    return tree->loads.terms ? (size_t)tree->loads.terms->count : 0;
}

enum pend_status api_member_derived_new(struct api_member_derived **made,
                                        const struct api_member_derived_of *of) {
    size_t n = (size_t)of->tree->tree->n, terms = terms_of(of->tree);
    assert(of->derived->count >= 1 && of->derived->columns >= 1);
    struct api_member_derived *d = *made =
        calloc(1, sizeof *d + ((6 + API_ENERGY_ROOM) * n + terms) * sizeof(double));
    if (!d) return PEND_NO_MEMORY;
    d->of = *of;
    d->derived = *of->derived;
    d->member.phi = (double *)(d + 1);
    d->member.rate = d->member.phi + n;
    d->member.phi_low = d->member.rate + n;
    d->member.length = d->member.phi_low + n;
    d->member.mass = d->member.length + n;
    d->subtree = d->member.mass + n;
    d->room = d->subtree + n;
    d->member.value = d->room + API_ENERGY_ROOM * n;
    return PEND_OK;
}

void api_member_derived_free(struct api_member_derived **derived) {
    if (*derived) api_derived_end(&(*derived)->derived);
    free(*derived);
    *derived = NULL;
}

double api_member_derived_bytes(const struct api_derived *derived, const struct api_tree *tree,
                                long instants) {
    assert(derived->count >= 1 && instants >= 1);
    double numbers = (6.0 + API_ENERGY_ROOM) * tree->tree->n + (double)terms_of(tree);
    return (double)sizeof(struct api_member_derived) + numbers * sizeof(double) +
           api_derived_bytes(derived, tree, api_derived_cap(derived, instants));
}

static void fill(struct api_member_derived *d, long member) {
    const struct api_tree *tree = d->of.tree;
    size_t bytes = (size_t)tree->tree->n * sizeof(double);
    memcpy(d->member.length, tree->tree->len, bytes);
    memcpy(d->member.mass, tree->tree->mass, bytes);
    d->member.loads = tree->loads;
    if (terms_of(tree)) {
        memcpy(d->member.value, tree->loads.value, terms_of(tree) * sizeof(double));
        d->member.loads.value = d->member.value;
    }
    d->member.start = d->of.origin;
    api_members_fill(d->of.members, tree->tree, member, &d->member, d->room);
    d->tree = pend_member_tree(tree->tree, &d->member, d->subtree);
}

enum pend_status api_member_derived_begin(struct api_member_derived *d, long member, long rows,
                                          struct pend_error *error) {
    assert(rows >= 1 && (d->of.times || rows == 1));
    fill(d, member);
    d->ends[0] = d->of.origin, d->ends[1] = d->of.origin + d->of.duration;
    d->rows = rows;
    d->skipped = d->of.times != NULL;
    struct pend_problem problem = {.tree = &d->tree,
                                   .loads = d->member.loads,
                                   .phi = d->member.phi,
                                   .phi_low = d->member.phi_low,
                                   .rate = d->member.rate,
                                   .rtol = d->of.rtol,
                                   .atol = d->of.atol,
                                   .atol_given = 1,
                                   .step_cap = d->of.step_cap};
    if (d->of.times) {
        problem.times = *d->of.times;
        problem.times.count = rows;
    } else {
        problem.times = (struct pend_times){.count = 2, .list = d->ends};
    }
    api_derived_end(&d->derived);
    return api_derived_begin(&d->derived, &problem, api_derived_cap(&d->derived, rows), error);
}

enum pend_status api_member_derived_next(struct api_member_derived *d, double raw[], long stride,
                                         long *made) {
    long more = 0, cap = d->derived.cap, left = d->rows - *made;
    assert(d->derived.motion && left >= 1 && stride >= 1);
    PEND_TRY(api_derived_next(&d->derived, 0,
                              d->skipped && left < cap ? left
                              : d->skipped             ? cap
                                                       : 1,
                              piece, &more, NULL));
    if (!more) return PEND_OK;
    if (!d->skipped) {
        d->skipped = 1;
        return PEND_OK;
    }
    for (long i = 0; i < more; i++)
        (void)api_derived_put(&d->derived, i, raw + (*made + i) * stride);
    *made += more;
    return PEND_OK;
}

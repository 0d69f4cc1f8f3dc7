#include "core/taylor/large/rods.h"

#include <assert.h>
#include <math.h>

#include "core/taylor/jets_loads.h"

/* Largest ratio among a chain's masses at joints, and among its inertias; and how close to a single
 * point mass an arm may be. Other chains use the general kernel. */
static const double RODS_MASSES = 256, RODS_POINT = 0.125;
/* kg: powers of masses below this underflow, and above its inverse they overflow */
static const double RODS_LEAST = 0x1p-900;

int pend_rods_known(const struct pend_tree *tree, const struct pend_terms *terms) {
    struct pend_terms points = *terms; // `terms` with masses at the tips
    int shaped = 0;
    if (tree->n <= CHAIN_ARMS || terms->row[PEND_TERM_AT_X] >= 0) return 0;
    for (int k = 1; k < tree->n; k++)
        if (tree->parent[k] != k - 1) return 0;
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        if (!jets_loads_shape(r)) continue;
        shaped |= terms->row[r] >= 0;
        points.row[r] = -1;
    }
    return shaped && jets_loads_known(&points);
}

/* an arm's masses and inertias, the latter over the square of its length */
struct rods_arm {
    double tip, joint, near, far, twist, spread;
};

static struct rods_arm rods_arm(const struct pend_tree *tree, const struct pend_loads *loads,
                                int k) {
    const struct pend_terms *terms = loads->terms;
    double part = 1 / tree->len[k], m = tree->mass[k];
    double rod = pend_terms_get(terms, loads->value, PEND_TERM_ROD, k);
    double body = pend_terms_get(terms, loads->value, PEND_TERM_BODY, k);
    double x = pend_terms_get(terms, loads->value, PEND_TERM_CENTER_X, k) * part, y = 1 - x;
    double own = pend_terms_get(terms, loads->value, PEND_TERM_INERTIA, k) * part * part;
    double half = x - 0.5, pairs = m * rod / 4 + m * body * y * y + rod * body * half * half;
    return (struct rods_arm){.tip = m + rod / 2 + body * x,
                             .joint = rod / 2 + body * y,
                             .near = m + rod / 3 + body * x * x + own,
                             .far = rod / 3 + body * y * y + own,
                             .twist = own - rod / 6 - body * x * y,
                             .spread = (m + rod + body) * (rod / 12 + own) + pairs};
}

int pend_rods_suit(const struct pend_tree *tree, const struct pend_loads *loads) {
    const struct pend_terms *terms = loads->terms;
    double least = INFINITY, most = 0, before = 0;
    if (!pend_rods_known(tree, terms)) return 0;
    for (int k = 0; k < tree->n; k++) {
        struct rods_arm arm = rods_arm(tree, loads, k);
        double node = before + arm.joint;
        if (pend_terms_get(terms, loads->value, PEND_TERM_CENTER_Y, k) != 0) return 0;
        if (!(arm.joint >= 0) || !(arm.tip > 0)) return 0;
        if (!(arm.spread >= RODS_POINT * arm.tip * arm.joint)) return 0;
        if (k) least = fmin(least, node);
        most = fmax(most, fmax(node, fabs(arm.twist)));
        before = arm.tip;
    }
    least = fmin(least, before), most = fmax(most, before);
    return most <= RODS_MASSES * least && least > RODS_LEAST && most < 1 / RODS_LEAST;
}

static size_t rods_count(const struct pend_tree *tree) {
    return ((size_t)tree->n + CHAIN_ARMS - 1) / CHAIN_ARMS;
}

size_t pend_rods_bytes(const struct pend_tree *tree) {
    assert(tree->n > CHAIN_ARMS);
    return pend_chain_bytes(tree) + (rods_count(tree) + 2) * RODS_NUMBERS * sizeof(double);
}

void pend_rods_init(struct rods *rods, struct chain *chain, const struct pend_tree *tree,
                    const struct pend_loads *loads, void *memory) {
    assert(pend_rods_suit(tree, loads) && (size_t)memory % 64 == 0);
    int exponent;
    double before = 0;
    pend_chain_lay(chain, tree, memory);
    rods->count = (int)rods_count(tree);
    rods->numbers = (double *)(void *)((char *)memory + pend_chain_bytes(tree)) + RODS_NUMBERS;
    frexp(rods_arm(tree, loads, 0).tip, &exponent);
    rods->scale = ldexp(1, -exponent);
    for (int k = 0; k < rods->count * CHAIN_ARMS; k++) {
        double *at = rods->numbers + (size_t)(k / CHAIN_ARMS) * RODS_NUMBERS + k % CHAIN_ARMS;
        if (k >= tree->n) {
            at[RODS_VOID * CHAIN_ARMS] = 1;
            continue;
        }
        struct rods_arm arm = rods_arm(tree, loads, k);
        double scale = rods->scale, node = before + arm.joint;
        at[RODS_TIP * CHAIN_ARMS] = arm.tip * scale;
        at[RODS_JOINT * CHAIN_ARMS] = arm.joint * scale;
        at[RODS_WHOLE * CHAIN_ARMS] = (arm.tip + arm.joint) * scale;
        at[RODS_NEAR * CHAIN_ARMS] = arm.near * scale;
        at[RODS_FAR * CHAIN_ARMS] = arm.far * scale;
        at[RODS_TWIST * CHAIN_ARMS] = arm.twist * scale;
        at[RODS_SPREAD * CHAIN_ARMS] = arm.spread * scale * scale;
        at[RODS_NODE * CHAIN_ARMS] = node * scale;
        at[RODS_RESIST * CHAIN_ARMS] = arm.twist;
        at[RODS_WIND * CHAIN_ARMS] = arm.twist * tree->len[k];
        double next = k + 1 < tree->n ? rods_arm(tree, loads, k + 1).joint : 0;
        at[RODS_SHARE * CHAIN_ARMS] = (arm.tip - tree->mass[k]) / (arm.tip + next);
        before = arm.tip;
    }
}

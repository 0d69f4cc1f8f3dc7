#include "core/integrate/pieces/stuck.h"

#include <complex.h>
#include <stdlib.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/integrate/pieces/balance.h"

/* kg m^2, the inertia of an arm stuck to the pivot: so large that its rate stays exactly 0 */
static const double stuck_inertia = 1e40;

void pend_stuck_free(struct pend_stuck **stuck) {
    struct pend_stuck *s = *stuck;
    if (s) {
        pend_tree_free(&s->tree);
        pend_terms_free(&s->terms);
        free(s->value);
        free(s->work);
    }
    free(s);
    *stuck = NULL;
}

/* properties of the bodies on an arm: mass, first moment, and inertia about their common center */
struct stuck_heap {
    double mass, spread;
    double complex center;
};

static void stuck_add(struct stuck_heap *heap, double mass, double complex at, double inertia) {
    double sum = heap->mass + mass, part = sum > 0 ? mass / sum : 0;
    double complex gap = at - heap->center;
    heap->spread += inertia + heap->mass * part * creal(gap * conj(gap));
    heap->center += part * gap;
    heap->mass = sum;
}

static double stuck_get(const struct pend_loads *loads, enum pend_term_row row, int k) {
    return pend_terms_get(loads->terms, loads->value, row, k);
}

/* Finds which arms turn together, and the differences of their angles. Sets `place` to the index of
 * each remaining arm, -1 if it does not remain. Returns the number of remaining arms. */
static int stuck_group(struct pend_stuck *s, const struct pend_tree *tree,
                       const struct pend_terms *terms, const unsigned char holds[],
                       const double phi[], const double low[], int place[], int top[]) {
    int count = 0;
    for (int k = 0; k < tree->n; k++) {
        int p = pend_terms_holder(terms, tree->parent, k);
        int joins = holds[k] && p >= 0, t = joins ? top[p] : k;
        double gap = phi[k] - phi[t], back = phi[k] - gap;
        top[k] = t;
        place[k] = joins ? -1 : count++;
        s->still[k] = joins ? s->still[p] : holds[k];
        s->offset[k] = joins ? gap : 0;
        s->low[k] = joins ? (phi[k] - (gap + back)) + (back - phi[t]) : 0;
        if (joins && low) s->low[k] += low[k] - low[t];
    }
    return count;
}

/* from the joint of the arm with which arm k turns to that of arm k, in the frame of the former */
static double complex stuck_hang(const struct pend_tree *tree, const struct pend_loads *loads,
                                 const struct pend_stuck *s, const double complex base[], int k) {
    int p = tree->parent[k];
    double complex own = tree->len[p];
    if (loads->terms->hung[k])
        own = stuck_get(loads, PEND_TERM_AT_X, k) + I * stuck_get(loads, PEND_TERM_AT_Y, k);
    return base[p] + pend_balance_turn(s->offset[p]) * own;
}

/* lists the harmonics of the contracted pendulum: the target of each, and the index of its values;
 * returns their number */
static int stuck_waves(const struct pend_stuck *s, const struct pend_terms *terms,
                       const int place[], int drives[], int from[]) {
    int count = 0;
    for (int i = 0; i < terms->harmonics; i++) {
        int arm = terms->harmonic[i].drives, to = arm < 0 ? arm : place[arm];
        if (arm >= 0 && (to < 0 || s->still[arm])) continue; // the joint of this arm holds
        drives[count] = arm < 0 ? arm : s->tree->place[to];
        from[count++] = terms->harmonic[i].at;
    }
    return count;
}

static enum pend_status stuck_lay(struct pend_stuck *s, const struct pend_terms *terms, int left,
                                  const int place[]) {
    unsigned char rows[PEND_TERM_ROWS], ones[PEND_TERM_ONES];
    for (int r = 0; r < PEND_TERM_ROWS; r++) rows[r] = terms->row[r] >= 0;
    for (int i = 0; i < PEND_TERM_ONES; i++) ones[i] = terms->one[i] >= 0;
    rows[PEND_TERM_BODY] = rows[PEND_TERM_AT_X] = 1;
    size_t most = (size_t)terms->harmonics + 1;
    int *drives = malloc(3 * most * sizeof *drives);
    if (!drives) return PEND_NO_MEMORY;
    int *from = drives + most, *order = from + most,
        count = stuck_waves(s, terms, place, drives, from);
    enum pend_status status = pend_terms_new(&s->terms, left, rows, ones, count, drives, order);
    if (status == PEND_OK) s->terms->rules = terms->rules; // marks the energy as not conserved
    s->value = status == PEND_OK ? calloc((size_t)s->terms->count + 1, sizeof(double)) : NULL;
    if (status == PEND_OK && !s->value) status = PEND_NO_MEMORY;
    for (int i = 0; status == PEND_OK && i < count; i++)
        memcpy(s->value + s->terms->harmonic[i].at, s->loads.value + from[order[i]],
               3 * sizeof(double));
    free(drives);
    return status;
}

/* adds the bodies of arm k, whose joint is at `base` in the frame of the arm with which it turns;
 * that arm's own rod and tip mass are not added */
static void stuck_bodies(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                         int own, double complex base, double complex turn,
                         struct stuck_heap *heap) {
    double l = tree->len[k], rod = stuck_get(loads, PEND_TERM_ROD, k);
    double complex center =
        stuck_get(loads, PEND_TERM_CENTER_X, k) + I * stuck_get(loads, PEND_TERM_CENTER_Y, k);
    stuck_add(heap, stuck_get(loads, PEND_TERM_BODY, k), base + turn * center,
              stuck_get(loads, PEND_TERM_INERTIA, k));
    if (own) return;
    stuck_add(heap, tree->mass[k], base + turn * l, 0);
    stuck_add(heap, rod, base + turn * (l / 2), rod * l * l / 12);
}

/* whether a term has no effect because it acts in the joint of an arm that does not turn */
static int stuck_idle(const struct pend_stuck *s, int row, int k) {
    return s->still[k] && row >= PEND_TERM_DAMPING && row != PEND_TERM_FRICTION_SPEED &&
           (row < PEND_TERM_DRAG || row > PEND_TERM_DRAG_SPEED);
}

/* computes the values of arm k, which remains as arm c of the contracted pendulum */
static void stuck_arm(struct pend_stuck *s, const struct pend_tree *tree,
                      const struct pend_loads *loads, const double complex base[],
                      const struct stuck_heap *heap, int k, int c) {
    const int *row = s->terms->row;
    int p = tree->parent[k], holder = pend_terms_holder(loads->terms, tree->parent, k);
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (loads->terms->row[r] >= 0 && !stuck_idle(s, r, k))
            s->value[row[r] + c] = stuck_get(loads, r, k);
    s->value[row[PEND_TERM_BODY] + c] = heap->mass;
    s->value[row[PEND_TERM_CENTER_X] + c] = creal(heap->center);
    s->value[row[PEND_TERM_CENTER_Y] + c] = cimag(heap->center);
    s->value[row[PEND_TERM_INERTIA] + c] = heap->spread + (s->still[k] ? stuck_inertia : 0);
    // springs depend on the angle to the parent itself
    if (row[PEND_TERM_REST] >= 0 && holder >= 0)
        s->value[row[PEND_TERM_REST] + c] += s->offset[holder];
    if (p < 0 || (!p && pend_terms_cart(loads->terms))) return;
    if (!loads->terms->hung[k] && s->of[s->tree->parent[c]] == p) {
        s->value[row[PEND_TERM_AT_X] + c] = tree->len[p];
        return;
    }
    double complex at = stuck_hang(tree, loads, s, base, k);
    s->value[row[PEND_TERM_AT_X] + c] = creal(at);
    s->value[row[PEND_TERM_AT_Y] + c] = cimag(at);
    s->terms->hung[c] = 1;
}

static void stuck_fill(struct pend_stuck *s, const struct pend_tree *tree,
                       const struct pend_loads *loads, double complex base[],
                       struct stuck_heap heap[]) {
    int cart = pend_terms_cart(loads->terms);
    for (int k = 0; k < tree->n; k++) {
        int top = s->of[s->rep[k]] == k, p = tree->parent[k];
        base[k] = top || p < 0 || (!p && cart) ? 0 : stuck_hang(tree, loads, s, base, k);
        if (!k && cart) continue;
        stuck_bodies(tree, loads, k, top, base[k], pend_balance_turn(s->offset[k]),
                     &heap[s->rep[k]]);
    }
    for (int c = 0; c < s->tree->n; c++) stuck_arm(s, tree, loads, base, &heap[c], s->of[c], c);
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (s->terms->one[i] >= 0) s->value[s->terms->one[i]] = loads->value[loads->terms->one[i]];
}

static struct pend_stuck *stuck_allocate(int n) {
    size_t each = sizeof(double complex) + sizeof(struct stuck_heap) + 4 * sizeof(double) +
                  5 * sizeof(int) + 2;
    char *block = calloc(1, sizeof(struct pend_stuck) + 64 + (size_t)n * each);
    struct pend_stuck *s = (struct pend_stuck *)(void *)block;
    if (!s) return NULL;
    s->n = n;
    s->offset = (double *)(s + 1);
    s->low = s->offset + n;
    s->rep = (int *)(s->low + n);
    s->of = s->rep + n;
    s->still = (unsigned char *)(s->of + n);
    return s;
}

enum pend_status pend_stuck_new(struct pend_stuck **stuck, const struct pend_tree *tree,
                                const struct pend_loads *loads, const unsigned char holds[],
                                const double phi[], const double phi_low[]) {
    size_t n = (size_t)tree->n;
    struct pend_stuck *s = *stuck = stuck_allocate(tree->n);
    double complex *room = calloc(n, sizeof *room + sizeof(struct stuck_heap) + 2 * sizeof(double) +
                                         3 * sizeof(int) + 1);
    enum pend_status status = s && room ? PEND_OK : PEND_NO_MEMORY;
    if (status == PEND_OK) {
        struct stuck_heap *heap = (struct stuck_heap *)(void *)(room + n);
        double *length = (double *)(heap + n), *mass = length + n;
        int *place = (int *)(mass + n), *top = place + n, *parent = top + n;
        unsigned char *bare = (unsigned char *)(parent + n);
        int left = stuck_group(s, tree, loads->terms, holds, phi, phi_low, place, top);
        for (int k = 0; k < tree->n; k++) {
            int c = place[k], p = tree->parent[k];
            if (c < 0) continue;
            length[c] = tree->len[k], mass[c] = tree->mass[k];
            bare[c] = 1;
            parent[c] = p < 0 ? -1 : place[top[p]];
        }
        s->loads = *loads;
        status = pend_tree_new_bare(&s->tree, left, length, mass, bare, parent, NULL);
        if (status == PEND_OK) status = stuck_lay(s, loads->terms, left, place);
        for (int k = 0; status == PEND_OK && k < tree->n; k++) {
            s->rep[k] = s->tree->place[place[top[k]]];
            if (place[k] >= 0) s->of[s->rep[k]] = k;
        }
        if (status == PEND_OK) stuck_fill(s, tree, loads, room, heap);
        s->loads.terms = s->terms, s->loads.value = s->value;
        if (status == PEND_OK)
            s->work = aligned_alloc(64, (pend_bodies_bytes(s->tree, s->terms) + 63) / 64 * 64);
        if (!s->work) status = PEND_NO_MEMORY;
    }
    free(room);
    if (status != PEND_OK) pend_stuck_free(stuck);
    return status;
}

void pend_stuck_inputs(struct pend_stuck *s, const struct pend_terms *terms, const double value[]) {
    static const enum pend_term_row rows[] = {PEND_TERM_INPUT, PEND_TERM_INPUT_RATE,
                                              PEND_TERM_SLIDE};
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < s->tree->n && terms->row[rows[i]] >= 0; c++)
            s->value[s->terms->row[rows[i]] + c] =
                s->still[s->of[c]] ? 0 : value[terms->row[rows[i]] + s->of[c]];
    for (int i = PEND_TERM_PIECE; i < PEND_TERM_ONES; i++)
        if (terms->one[i] >= 0) s->value[s->terms->one[i]] = value[terms->one[i]];
}

double *pend_stuck_spread(const struct pend_stuck *s, const double from[], double to[]) {
    for (int k = 0; k < s->n; k++) to[k] = s->still[k] ? 0 : from[s->rep[k]];
    return to;
}

void pend_stuck_turn(const struct pend_stuck *s, const double from[], const double from_low[],
                     double to[], double to_low[]) {
    for (int k = 0; k < s->n; k++) {
        double x = from[s->rep[k]], sum = x + s->offset[k], part = sum - x;
        double low = (x - (sum - part)) + (s->offset[k] - part) + s->low[k];
        if (from_low) low += from_low[s->rep[k]];
        to[k] = to_low ? sum : sum + low;
        if (to_low) to_low[k] = low;
    }
}

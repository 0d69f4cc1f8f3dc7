#include "core/tree/terms.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* the first and last terms of groups that are stored together for each arm */
static const struct {
    enum pend_term_row first, last;
} families[] = {{PEND_TERM_ROD, PEND_TERM_ROD},
                {PEND_TERM_BODY, PEND_TERM_INERTIA},
                {PEND_TERM_AT_X, PEND_TERM_AT_Y},
                {PEND_TERM_DAMPING, PEND_TERM_DAMPING},
                {PEND_TERM_STIFFNESS, PEND_TERM_REST},
                {PEND_TERM_FRICTION, PEND_TERM_FRICTION_SPEED},
                {PEND_TERM_TORQUE, PEND_TERM_TORQUE},
                {PEND_TERM_DRAG, PEND_TERM_DRAG},
                {PEND_TERM_DRAG_QUADRATIC, PEND_TERM_DRAG_SPEED},
                {PEND_TERM_INPUT, PEND_TERM_INPUT_RATE},
                {PEND_TERM_SLIDE, PEND_TERM_SLIDE}};

enum range { RANGE_ANY, RANGE_NOT_NEGATIVE, RANGE_POSITIVE };

static const unsigned char row_range[PEND_TERM_ROWS] = {
    [PEND_TERM_ROD] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_BODY] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_INERTIA] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_DAMPING] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_STIFFNESS] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_FRICTION] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_FRICTION_SPEED] = RANGE_POSITIVE,
    [PEND_TERM_DRAG] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_DRAG_QUADRATIC] = RANGE_NOT_NEGATIVE,
    [PEND_TERM_DRAG_SPEED] = RANGE_POSITIVE,
};

static const unsigned char one_range[PEND_TERM_ONES] = {[PEND_TERM_DRAG_PER_MASS] =
                                                            RANGE_NOT_NEGATIVE};

/* assigns list indices to the terms of the arms; returns the number of values */
static int terms_place_rows(struct pend_terms *terms, const unsigned char rows[]) {
    int count = 0;
    for (size_t f = 0; f < sizeof families / sizeof *families; f++) {
        int there = 0;
        for (int r = families[f].first; r <= (int)families[f].last; r++) there |= rows[r];
        for (int r = families[f].first; r <= (int)families[f].last; r++) {
            terms->row[r] = there ? count : -1;
            if (there) count += terms->n;
        }
    }
    return count;
}

/* assigns list indices to the terms of the pendulum, from `count` on; returns the number of values
 * so far */
static int terms_place_ones(struct pend_terms *terms, const unsigned char ones[], int count) {
    int moves = ones[PEND_TERM_PIVOT_ACCELERATION_X] || ones[PEND_TERM_PIVOT_ACCELERATION_Y];
    for (int i = 0; i < PEND_TERM_ONES; i++) {
        int pushed = i == PEND_TERM_PIVOT_ACCELERATION_X || i == PEND_TERM_PIVOT_ACCELERATION_Y;
        int there = pushed ? moves : ones[i];
        terms->one[i] = there ? count++ : -1;
    }
    return count;
}

/* sorts harmonics by the driven quantity; harmonics of one quantity keep the caller's order */
static int drive_order(const void *a, const void *b, void *context) {
    const int *drives = context;
    int i = *(const int *)a, j = *(const int *)b;
    if (drives[i] != drives[j]) return drives[i] > drives[j] ? 1 : -1;
    return (i > j) - (i < j);
}

enum pend_status pend_terms_new(struct pend_terms **terms, int n, const unsigned char rows[],
                                const unsigned char ones[], int harmonics, const int drives[],
                                int place[]) {
    assert(n >= 1 && harmonics >= 0);
    size_t head = sizeof **terms, list = (size_t)harmonics * sizeof *(*terms)->harmonic;
    char *block = calloc(1, head + list + (size_t)n);
    *terms = (struct pend_terms *)(void *)block;
    if (!block) return PEND_NO_MEMORY;
    struct pend_terms *made = *terms;
    *made = (struct pend_terms){.n = n,
                                .harmonics = harmonics,
                                .harmonic = (struct pend_harmonic *)(void *)(block + head),
                                .hung = (unsigned char *)block + head + list};
    made->count = terms_place_ones(made, ones, terms_place_rows(made, rows));
    for (int i = 0; i < harmonics; i++) place[i] = i;
    if (harmonics) qsort_r(place, (size_t)harmonics, sizeof *place, drive_order, (void *)drives);
    for (int i = 0; i < harmonics; i++) {
        made->harmonic[i] = (struct pend_harmonic){drives[place[i]], made->count};
        made->count += 3;
    }
    assert(pend_terms_valid(made));
    return PEND_OK;
}

void pend_terms_free(struct pend_terms **terms) {
    free(*terms);
    *terms = NULL;
}

void pend_terms_clear(const struct pend_terms *terms, const struct pend_tree *tree,
                      double value[]) {
    for (int i = 0; i < terms->count; i++) value[i] = 0;
    for (int k = 0; k < terms->n; k++) {
        int p = tree->parent[k], x = pend_terms_place(terms, PEND_TERM_AT_X, k);
        if (x >= 0 && p >= 0) value[x] = tree->len[p];
        if (terms->row[PEND_TERM_FRICTION_SPEED] >= 0)
            value[terms->row[PEND_TERM_FRICTION_SPEED] + k] = 1;
        if (terms->row[PEND_TERM_DRAG_SPEED] >= 0) value[terms->row[PEND_TERM_DRAG_SPEED] + k] = 1;
    }
}

static const char *terms_wrong(double x, enum range range) {
    if (!isfinite(x)) return "must be a finite number";
    if (range == RANGE_NOT_NEGATIVE && x < 0) return "must be 0 or more";
    if (range == RANGE_POSITIVE && !(x > 0)) return "must be greater than 0";
    return NULL;
}

/* checks that every arm has an inertia about its joint */
static int terms_swings(const struct pend_terms *terms, const struct pend_tree *tree,
                        const double value[], int k) {
    double body = pend_terms_get(terms, value, PEND_TERM_BODY, k);
    double x = pend_terms_get(terms, value, PEND_TERM_CENTER_X, k),
           y = pend_terms_get(terms, value, PEND_TERM_CENTER_Y, k);
    return tree->mass[k] > 0 || pend_terms_get(terms, value, PEND_TERM_ROD, k) > 0 ||
           (body > 0 &&
            (x != 0 || y != 0 || pend_terms_get(terms, value, PEND_TERM_INERTIA, k) > 0));
}

int pend_terms_check(const struct pend_terms *terms, const struct pend_tree *tree,
                     const double value[],
                     void (*found)(void *context, const struct pend_terms_fault *fault),
                     void *context) {
    assert(pend_terms_valid(terms) && terms->n == tree->n);
    int faults = 0;
    struct pend_terms_fault fault;
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        for (int k = 0; k < terms->n && terms->row[r] >= 0; k++) {
            fault = (struct pend_terms_fault){
                r, -1, k, 0, terms_wrong(value[terms->row[r] + k], (enum range)row_range[r])};
            if (fault.text) found(context, &fault), faults++;
        }
    }
    for (int i = 0; i < PEND_TERM_ONES; i++) {
        if (terms->one[i] < 0) continue;
        fault = (struct pend_terms_fault){
            -1, i, -1, 0, terms_wrong(value[terms->one[i]], (enum range)one_range[i])};
        if (fault.text) found(context, &fault), faults++;
    }
    for (int i = 0; i < 3 * terms->harmonics; i++) {
        fault = (struct pend_terms_fault){
            -1, -1, i / 3, i % 3, terms_wrong(value[terms->harmonic[i / 3].at + i % 3], RANGE_ANY)};
        if (fault.text) found(context, &fault), faults++;
    }
    int sound = !faults; // after another fault, do not report a missing inertia, which it may cause
    for (int k = 0; k < terms->n && sound; k++) {
        fault = (struct pend_terms_fault){PEND_TERM_BODY, -1, k, 0,
                                          "has no inertia: give it a mass at its tip, a rod, or a "
                                          "body with an inertia or with a mass off the joint"};
        if (!terms_swings(terms, tree, value, k)) found(context, &fault), faults++;
    }
    return faults;
}

int pend_terms_fits(const struct pend_terms *terms, int place, double x) {
    enum range range = RANGE_ANY;
    assert(place >= 0 && place < terms->count);
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (terms->row[r] >= 0 && place >= terms->row[r] && place < terms->row[r] + terms->n)
            range = (enum range)row_range[r];
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (terms->one[i] == place) range = (enum range)one_range[i];
    return !terms_wrong(x, range);
}

int pend_terms_conserve(const struct pend_terms *terms, const double value[]) {
    static const enum pend_term_row changes[] = {
        PEND_TERM_DAMPING, PEND_TERM_FRICTION, PEND_TERM_DRAG,       PEND_TERM_DRAG_QUADRATIC,
        PEND_TERM_TORQUE,  PEND_TERM_INPUT,    PEND_TERM_INPUT_RATE, PEND_TERM_SLIDE};
    // a later piece may add or remove energy, although the list does not show this yet
    if (terms->rules) return 0;
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++)
        for (int k = 0; k < terms->n; k++)
            if (pend_terms_get(terms, value, changes[i], k) != 0) return 0;
    for (int i = 0; i < terms->harmonics; i++)
        if (value[terms->harmonic[i].at] != 0) return 0;
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (i != PEND_TERM_RAIL && i != PEND_TERM_PIECE && terms->one[i] >= 0 &&
            value[terms->one[i]] != 0)
            return 0;
    return 1;
}

double pend_terms_inertia(const struct pend_terms *terms, double length, double mass,
                          const double value[], int k) {
    double x = pend_terms_get(terms, value, PEND_TERM_CENTER_X, k),
           y = pend_terms_get(terms, value, PEND_TERM_CENTER_Y, k);
    return (mass + pend_terms_get(terms, value, PEND_TERM_ROD, k) / 3) * length * length +
           pend_terms_get(terms, value, PEND_TERM_INERTIA, k) +
           pend_terms_get(terms, value, PEND_TERM_BODY, k) * (x * x + y * y);
}

/* The sum of the amplitudes of the harmonics of one target, an arm's torque, N m, or a coordinate
 * of the pivot, m/s^2. Harmonics are grouped by target; `next` is the first one not visited yet. */
static double terms_drive(const struct pend_terms *terms, const double value[], int drives,
                          int *next) {
    double sum = 0;
    for (; *next < terms->harmonics && terms->harmonic[*next].drives <= drives; (*next)++) {
        const double *harmonic = value + terms->harmonic[*next].at;
        sum += fabs(harmonic[0]) * (drives < 0 ? harmonic[1] * harmonic[1] : 1);
    }
    return sum;
}

/* m, the shortest arm: the length scale for forces on a cart and accelerations of its pivot */
static double terms_shortest(const struct pend_terms *terms, const double length[]) {
    double shortest = INFINITY;
    for (int k = 1; k < terms->n; k++) shortest = fmin(shortest, length[k]);
    return shortest;
}

double pend_terms_rate(const struct pend_terms *terms, const int parent[], const double length[],
                       const double mass[], const double value[], double *decay) {
    assert(pend_terms_valid(terms));
    int drag_per_mass = terms->one[PEND_TERM_DRAG_PER_MASS], next = 0;
    double most = 0, fade = 0, pull = terms_drive(terms, value, PEND_DRIVE_PIVOT_X, &next);
    for (int i = PEND_TERM_PIVOT_ACCELERATION_X; i <= PEND_TERM_PIVOT_ACCELERATION_Y; i++)
        if (terms->one[i] >= 0) pull += fabs(value[terms->one[i]]);
    for (int k = 0; k < terms->n; k++) {
        double l = length[k], yields = 1 / pend_terms_inertia(terms, l, mass[k], value, k);
        // a torque between two arms moves both
        int p = pend_terms_holder(terms, parent, k), cart = !k && pend_terms_cart(terms);
        double parents = p < 0 ? 0 : 1 / pend_terms_inertia(terms, length[p], mass[p], value, p);
        double torque = fabs(pend_terms_get(terms, value, PEND_TERM_TORQUE, k)) +
                        fabs(pend_terms_get(terms, value, PEND_TERM_INPUT, k)) +
                        fabs(pend_terms_get(terms, value, PEND_TERM_SLIDE, k)) +
                        terms_drive(terms, value, k, &next);
        if (cart) torque /= l = terms_shortest(terms, length);
        torque += pend_terms_get(terms, value, PEND_TERM_STIFFNESS, k);
        double loss = pend_terms_get(terms, value, PEND_TERM_DAMPING, k);
        if (terms->row[PEND_TERM_FRICTION] >= 0)
            loss += value[terms->row[PEND_TERM_FRICTION] + k] /
                    value[terms->row[PEND_TERM_FRICTION_SPEED] + k];
        double drag = pend_terms_get(terms, value, PEND_TERM_DRAG, k) +
                      pend_terms_get(terms, value, PEND_TERM_DRAG_QUADRATIC, k) *
                          pend_terms_get(terms, value, PEND_TERM_DRAG_SPEED, k);
        double rate = sqrt(torque * (yields + parents) + pull / l) + loss * (yields + parents) +
                      drag * l * l * yields;
        most = fmax(most, rate);
        fade = fmax(fade, loss * (yields + parents) + drag * l * l * yields);
    }
    if (decay) *decay = fade + (drag_per_mass >= 0 ? 2 * value[drag_per_mass] : 0);
    return most + (drag_per_mass >= 0 ? 2 * value[drag_per_mass] : 0);
}

double pend_terms_drive_rate(const struct pend_terms *terms, const double value[]) {
    double most = 0;
    for (int i = 0; i < terms->harmonics; i++)
        if (value[terms->harmonic[i].at] != 0)
            most = fmax(most, fabs(value[terms->harmonic[i].at + 1]));
    return most;
}

int pend_terms_valid(const struct pend_terms *terms) {
    if (terms->n < 1 || terms->count < 0 || terms->harmonics < 0) return 0;
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (terms->row[r] >= 0 && terms->row[r] + terms->n > terms->count) return 0;
    for (int i = 0; i < terms->harmonics; i++) {
        const struct pend_harmonic *h = &terms->harmonic[i];
        if (h->drives < PEND_DRIVE_PIVOT_Y || h->drives >= terms->n || h->at + 3 > terms->count)
            return 0;
        if (i && h->drives < h[-1].drives) return 0;
    }
    return 1;
}

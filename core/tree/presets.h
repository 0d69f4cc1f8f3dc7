/* Ready-made trees: the paper's examples and the classics, by name.
 * Leaves to others: serving them (api), random trees for tests (tests/harness).
 * Invariant: every preset builds without a fault. */
#ifndef PEND_PRESETS_H
#define PEND_PRESETS_H

#include "core/tree/loads.h"
#include "core/tree/tree.h"

enum { PEND_PRESET_ARMS = 64 };

/* A pendulum with an interesting start; parents come before children. */
struct pend_preset {
    const char *name;        /* as in a URL: "paper-four-arms" */
    const char *title;       /* a few words */
    const char *description; /* a sentence or two: its origin, what to look for */
    int n;
    double length[PEND_PRESET_ARMS], mass[PEND_PRESET_ARMS]; /* m, kg */
    int parent[PEND_PRESET_ARMS];                            /* from 0, -1 = the pivot */
    struct pend_loads loads;                                 /* what acts on the tree */
    double phi[PEND_PRESET_ARMS], rate[PEND_PRESET_ARMS];    /* rad, rad/s */
    double stop, step;                                       /* s: suggested times 0 .. stop */
};

/**
 * Returns the number of presets.
 */
int pend_preset_count(void);

/**
 * Fills preset number i, 0 <= i < pend_preset_count(). O(n).
 */
void pend_preset_get(int i, struct pend_preset *preset);

/**
 * Returns the number of the preset of that name, or -1.
 */
int pend_preset_find(const char *name);

#endif

/* Predefined real pendulums, as parts of requests: with bars, springs, friction and drives.
 * Leaves to others: the ideal ones (core/tree/presets), serving both (op_presets).
 * Invariant: every text is JSON in the format of requests, with parents before children. */
#ifndef API_PRESETS_REAL_H
#define API_PRESETS_REAL_H

struct api_preset_real {
    const char *name, *title, *description; /* as in struct pend_preset */
    int n;                                  /* arms */
    const char *pendulum;                   /* an object, in the form of lists */
    const char *initial;                    /* an object with phi and phid */
    double stop, step;                      /* s */
};

/** Returns number i >= 0, or NULL beyond the last. O(1). */
const struct api_preset_real *api_preset_real(int i);

#endif

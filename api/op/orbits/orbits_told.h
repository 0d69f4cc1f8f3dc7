/* The end of a search for orbits, as a word and as a sentence.
 * Leaves to others: the search (core/orbits), the answer (op_orbits).
 * Invariant: a sentence has no comma and no quote, as in warnings. */
#pragma once

#include "api/encode/encode.h"
#include "core/orbits/orbits.h"

/** Returns the word for an end of a search. O(1). */
const char *api_orbits_end(enum pend_orbits_end end);

/**
 * Writes a sentence on how a finished search ended.
 *
 * orbits  number of orbits found.
 */
void api_orbits_sentence(const struct pend_orbit_problem *problem, const struct pend_orbits *search,
                         long orbits, char text[API_WARNING_TEXT]);

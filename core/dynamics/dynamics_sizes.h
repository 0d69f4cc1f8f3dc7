/* Sizes that the fast forms of the dynamics share with their callers.
 * Leaves to others: the forms (dynamics_*_template), memory (dynamics).
 * Invariant: DYNAMICS_VEC is a multiple of every width of vectors. */
#pragma once

/* Number of arms whose scratch is contiguous, so that one base address serves all arrays of a
 * sweep; number of states computed together. */
enum { DYNAMICS_BLOCK = 64, DYNAMICS_VEC = 8 };

/* Number of scratch values per arm, in blocks of DYNAMICS_BLOCK arms of one state. For DYNAMICS_VEC
 * states each value is DYNAMICS_VEC numbers. */
enum { DYNAMICS_VALUES = 7 };

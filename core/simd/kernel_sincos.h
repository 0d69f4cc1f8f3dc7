/* Cosines and sines of many angles, by instruction set.
 * Leaves to others: positions and velocities (kinematics).
 * Invariant: a kernel is called only on a processor that has its instruction set. */
#pragma once

enum { PEND_TURN_CAP = 64 };

/**
 * Cosines and sines of up to PEND_TURN_CAP angles: within 1 ulp of the larger of the two up to 1e6
 * rad, and as exact as the angle itself beyond, up to 1e12 rad.
 *
 * phi       count angles, rad.
 * re, im    out, PEND_TURN_CAP values each, aligned to 64 bytes; those from count on are undefined.
 */
typedef void pend_sincos_fn(const double phi[], int count, double re[], double im[]);

pend_sincos_fn pend_kernel_sincos_base;
#ifdef __x86_64__
pend_sincos_fn pend_kernel_sincos_avx2, pend_kernel_sincos_avx512;
#endif

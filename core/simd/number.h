/* The numbers that templates compute with: their interface, and the kinds.
 *
 * A template is written once, in `num` and the functions below. A file that includes templates
 * first defines one of
 *
 *     NUMBER_VEC 1            a double; the default
 *     NUMBER_VEC 2, 4 or 8    a vector of so many doubles, one value per lane
 *     NUMBER_DOUBLE_DOUBLE    32 digits: a sum of two of the widest vectors
 *     NUMBER_TANGENT          a double and its derivatives with respect to eight parameters
 *     NUMBER_OTHER type       a type for which the file has defined num_of .. num_neg
 *
 * and then includes this file. All kinds have
 *
 *     num_of(double)                   the number, in every lane
 *     num_add, num_sub, num_mul, num_div (x, y)
 *     num_fma(x, y, z)                 x y + z, rounded once where the kind can
 *     num_neg(x)
 *
 * The sums of two doubles have
 *
 *     num_of2(high, low)               a number of two parts, |high| >= |low|, in every lane
 *     num_scale(x, power)              x times a power of two, exact
 *     num_sincos(x, &sine, &cosine)
 *
 * and NUM_(name) is a function that only one kind has.
 * Leaves to others: the arithmetic (vec, double_double, tangent).
 * Invariant: every kind passes the static checks at the end of this file. */
#pragma once

#include <assert.h>

#ifdef NUMBER_OTHER
typedef NUMBER_OTHER num;
#else
#include "core/simd/vec_isa.h"
#if defined NUMBER_DOUBLE_DOUBLE
#define LANES KERNEL_WIDTH
#include "core/simd/double_double.h"
typedef KERNEL_OF(pairs, ) num;
#define NUM_(name) KERNEL_OF(pairs, _##name)
#elif defined NUMBER_TANGENT
#include "core/simd/tangent.h"
typedef struct tangent num;
#define NUM_(name) tangent_##name
#else
#ifndef NUMBER_VEC
#define NUMBER_VEC 1
#endif
typedef KERNEL_PASTE(lanes, NUMBER_VEC, ) num;
#define NUM_(name) KERNEL_PASTE(lanes, NUMBER_VEC, _##name)
#endif

#define num_of NUM_(of)
#define num_fma NUM_(fma)
#ifdef NUMBER_VEC
VEC_INLINE num num_add(num x, num y) { return x + y; }
VEC_INLINE num num_sub(num x, num y) { return x - y; }
VEC_INLINE num num_mul(num x, num y) { return x * y; }
VEC_INLINE num num_div(num x, num y) { return x / y; }
VEC_INLINE num num_neg(num x) { return -x; }
#else
#define num_add NUM_(add)
#define num_sub NUM_(sub)
#define num_mul NUM_(mul)
#define num_div NUM_(div)
#define num_neg NUM_(neg)
#define num_of2 NUM_(of2)
#define num_scale NUM_(scale)
#define num_sincos NUM_(sincos)
#endif
#endif

/* keeps a vector in a register at this point; no effect for other kinds */
#ifdef NUMBER_VEC
#define NUM_PIN VEC_PIN
#else
#define NUM_PIN(x) ((void)(x))
#endif

/* The interface as static checks. A kind that lacks a function, or whose function returns another
 * type, does not compile; nothing is evaluated. */
#define NUMBER_ANY (*(num *)0)
#define NUMBER_IS(x) static_assert(_Generic((x), num : 1, default : 0), #x " must be a num")
NUMBER_IS(num_of(1.0));
NUMBER_IS(num_add(NUMBER_ANY, NUMBER_ANY));
NUMBER_IS(num_sub(NUMBER_ANY, NUMBER_ANY));
NUMBER_IS(num_mul(NUMBER_ANY, NUMBER_ANY));
NUMBER_IS(num_div(NUMBER_ANY, NUMBER_ANY));
NUMBER_IS(num_fma(NUMBER_ANY, NUMBER_ANY, NUMBER_ANY));
NUMBER_IS(num_neg(NUMBER_ANY));
#ifdef NUMBER_DOUBLE_DOUBLE
NUMBER_IS(num_of2(1.0, 0.0));
#endif
/* templates store numbers in blocks of doubles, and memory is counted in doubles */
static_assert(sizeof(num) % sizeof(double) == 0 && _Alignof(num) <= 64,
              "a num must be laid out as doubles");

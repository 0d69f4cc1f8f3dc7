/* The templates of programs, formulas and requests, each from a text file.
 * Leaves to others: filling them in (template), the values of their names (equations).
 * Invariant: each begins with a line end. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

extern const char api_equations_latex[], api_equations_matlab[], api_equations_python[],
    api_equations_curl[];

#ifdef __cplusplus
}
#endif

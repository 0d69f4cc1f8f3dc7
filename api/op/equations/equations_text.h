/* The templates of programs, formulas and of a request, each of a file of text.
 * Leaves to others: filling them in (template), what their names mean (equations_names).
 * Invariant: each begins with the end of a line. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

extern const char api_equations_latex[], api_equations_matlab[], api_equations_python[],
    api_equations_curl[];

#ifdef __cplusplus
}
#endif

/* Numbers as text: doubles to and from decimals, exactly.
 * Leaves to others: JSON's grammar around them (json_in), buffers (encode_*).
 * Invariant: the locale does not matter; api_number_read of the text from api_number_write gives
 * the same double. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

/* Space needed to write a number. Its text has at most 24 bytes; the bytes after it may be
 * overwritten. */
enum { API_NUMBER_BYTES = 32 };

/**
 * Writes the shortest decimal that reads back to the same double; of several, the nearest.
 *
 * The text is a JSON number, in plain form if 1e-5 <= |x| < 1e16 (0.57, 100, 1234.5), else with an
 * exponent (1.5e-7, 1e300). Whole numbers below 1e16 are exact; zero is 0, and -0.0 is -0.
 *
 * out  space for API_NUMBER_BYTES; no NUL is written.
 * x    finite.
 * Returns the end of the text. O(1), no allocation.
 */
char *api_number_write(char *out, double x);

/**
 * As api_number_write, rounded to at most `digits` significant digits.
 *
 * If the shortest decimal that reads back has at most `digits` digits, it is written (17 never
 * rounds). Otherwise the exact value of the double is rounded, ties to even, and trailing zeros are
 * dropped; a result above the largest double is rounded down instead.
 *
 * digits  1 to 17.
 */
char *api_number_write_digits(char *out, double x, int digits);

/* Numbers to be written as rows. */
struct api_number_rows {
    long rows, width;
    const double *value; /* rows x width, finite */
    int digits;          /* 1 to 17 as in api_number_write_digits; 0 = do not round */
    char open;           /* written before the first number of a row; 0 = nothing */
    char close[3];       /* written after the last number of a row */
    int close_bytes;     /* number of bytes in `close` */
};

/* Space after the text of rows that may be overwritten. */
enum { API_NUMBER_ROWS_BYTES = API_NUMBER_BYTES };

/**
 * Writes rows of numbers with a comma between them.
 *
 * out  space for the numbers, commas, open and close, and API_NUMBER_ROWS_BYTES more.
 * Returns the end of the text. Faster than a call for each number.
 */
char *api_number_write_rows(char *out, const struct api_number_rows *rows);

/** Writes an integer; out has API_NUMBER_BYTES of space. Returns the end of the text. */
char *api_number_write_int(char *out, long long i);

/**
 * Reads the decimal number that fills [text, end), exactly rounded.
 *
 * text  a number of RFC 8259's grammar, checked by the caller.
 * Returns the nearest double; +-INFINITY if the number is beyond the range of a double.
 */
double api_number_read(const char *text, const char *end);

#ifdef __cplusplus
}
#endif

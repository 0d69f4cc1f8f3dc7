/* Numbers as text: doubles to and from decimals, exactly.
 * Leaves to others: JSON's grammar around them (json_in), buffers (encode_*).
 * Invariant: independent of the locale; what api_number_write writes, api_number_read reads back to the same double. */
#ifndef API_NUMBER_H
#define API_NUMBER_H

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Reads the decimal number that fills [text, end), exactly rounded.
 *
 * text  a number of RFC 8259's grammar, checked by the caller.
 * Returns the nearest double; +-INFINITY where the number is beyond the range of a double.
 */
double api_number_read(const char *text, const char *end);

#ifdef __cplusplus
}
#endif

#endif

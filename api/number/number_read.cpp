#include "api/number/number.h"

#include <fast_float/fast_float.h>

extern "C" double api_number_read(const char *text, const char *end) {
    double x = 0;
    fast_float::from_chars(text, end, x);
    return x;
}

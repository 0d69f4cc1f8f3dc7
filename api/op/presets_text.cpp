#include "api/op/presets_text.h"

/* C++ has raw strings, in which the text needs no quotes and no escapes */
const char api_presets_text[] =
#include "api/op/presets.txt"
    ;

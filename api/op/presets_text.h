/* The predefined pendulums, each a request for its trajectory with a name, a title and a sentence.
 * Leaves to others: finding and serving them (op_presets).
 * Invariant: JSON with parents before children; line ends inside a preset are not part of it, and
 * an empty line follows each preset except the last. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

extern const char api_presets_text[];

#ifdef __cplusplus
}
#endif

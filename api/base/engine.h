/* The engine's version: a digest of the sources of core and api, made by the build.
 * Leaves to others: reporting it (remarks, server).
 * Invariant: engines of different sources have different digests. */
#ifndef API_ENGINE_H
#define API_ENGINE_H

/* The version for people; the same in responses, in the program's output and in its metrics. */
#define API_VERSION "0.1.0"

/* 64 hexadecimal digits; and the first 16 of them, which responses report. */
extern const char api_engine[], api_engine_name[];

#endif

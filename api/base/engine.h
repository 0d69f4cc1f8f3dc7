/* The engine's version: a digest of the sources of core and api, made by the build.
 * Leaves to others: reporting it (stats_text, server).
 * Invariant: engines of different sources have different digests. */
#pragma once

/* The version with the commit of a build between two releases (docker/version.sh):
 * "0.1.0+git20261126.abc1234". In the program's output and metrics, and at /version. */
extern const char api_version[];

/* the digest's 64 hexadecimal digits; the first 16 of them, as in responses */
extern const char api_engine[], api_engine_name[];

/* Which engine this is: a digest of the sources of core and api, made when it is built.
 * Leaves to others: where it is told. Invariant: another engine, another text. */
#ifndef API_ENGINE_H
#define API_ENGINE_H

/* For people; the same wherever an answer, the program or its metrics tell it. */
#define API_VERSION "0.1.0"

/* 64 hexadecimal digits; and the first 16 of them, by which it is told. */
extern const char api_engine[], api_engine_name[];

#endif

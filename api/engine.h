/* Which engine this is: a digest of the sources of core and api, made when it is built.
 * Leaves to others: the version that people read (server/config). Invariant: another engine, another text. */
#ifndef API_ENGINE_H
#define API_ENGINE_H

/* 64 hexadecimal digits. */
extern const char api_engine[];

#endif

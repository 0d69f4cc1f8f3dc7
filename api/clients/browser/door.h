/* The engine without a server, as a WebAssembly module and as the shared library libpendulum.so: a
 * caller has a request answered in its own process, by the code that answers it in a server.
 * Leaves to others: the mechanics and the request (core, api), threads (the page's worker, the
 * caller), libraries that a browser lacks (missing, and the script's imports).
 * Invariant: one request is open at a time in each thread; the same request has the bytes that a
 * server answers, without compute_seconds: of the module, a server of the base instruction set. */
#pragma once

#include <stddef.h>

#ifdef __wasm__
#define DOOR_EXPORT(name) __attribute__((export_name(#name)))
#else
#define DOOR_EXPORT(name) __attribute__((visibility("default")))
#endif

/**
 * Makes room for a request of so many bytes, which door_open reads: the operation ("trajectories"),
 * its argument ("" = none) and the field Accept, each with a NUL behind it, then the body.
 *
 * Returns where to write it, valid until the next call; NULL without memory.
 */
DOOR_EXPORT(door_room) char *door_room(size_t bytes);

enum { DOOR_UNKNOWN = -1, DOOR_FULL = -2 };

/** Opens the request that lies in the room, and closes the one before. Returns an enum
 * api_progress, DOOR_UNKNOWN if there is no such operation or the text is cut short, DOOR_FULL
 * without memory. */
DOOR_EXPORT(door_open) int door_open(void);

/** Returns the estimate of the computation that is open, s on the server's machine; 0 for one that
 * was refused. */
DOOR_EXPORT(door_cost) double door_cost(void);

/** Lets the answer be taken in pieces, if its representation can: a failure from now on breaks it.
 */
DOOR_EXPORT(door_promise) void door_promise(void);

/** Computes about a block of samples, or another piece of some milliseconds. Returns an enum
 * api_progress. */
DOOR_EXPORT(door_run) int door_run(void);

/** Returns the bytes of the answer that were not taken yet, valid until the next call. */
DOOR_EXPORT(door_data) const char *door_data(void);

/** Returns how many there are. */
DOOR_EXPORT(door_bytes) size_t door_bytes(void);

/** Forgets the bytes that door_data told. */
DOOR_EXPORT(door_taken) void door_taken(void);

/** Returns the HTTP status of the answer: final once a run has returned API_DONE. */
DOOR_EXPORT(door_status) int door_status(void);

/** Returns the answer's header fields, "Name: value" a line, ended by a NUL; valid until the next
 * call. NULL without memory. */
DOOR_EXPORT(door_head) const char *door_head(void);

/** Ends the request and frees what it holds; without one nothing happens. */
DOOR_EXPORT(door_close) void door_close(void);

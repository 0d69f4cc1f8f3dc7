/* The engine without a server, as a WebAssembly module and as the shared library libpendulum.so. A
 * caller has requests answered in its own process, by the code that answers them in a server.
 * Leaves to others: the mechanics and the request (core, api), threads (the page's worker, the
 * caller), libraries that a browser lacks (missing, and the script's imports).
 * Invariant: each thread has one open request at a time. A request gets the same bytes as from a
 * server, without compute_seconds; the module's are those of a server with the base instruction
 * set. */
#pragma once

#include <stddef.h>

#ifdef __wasm__
#define DOOR_EXPORT(name) __attribute__((export_name(#name)))
#else
#define DOOR_EXPORT(name) __attribute__((visibility("default")))
#endif

/**
 * Reserves memory for a request of `bytes` bytes, which door_open reads: the operation
 * ("trajectories"), its argument ("" = none) and the field Accept, each terminated by a NUL, then
 * the body.
 *
 * Returns the address to which to write it, valid until the next call; NULL if memory is short.
 */
DOOR_EXPORT(door_room) char *door_room(size_t bytes);

enum { DOOR_UNKNOWN = -1, DOOR_FULL = -2 };

/** Opens the request in that memory, and closes the previous one. Returns an enum api_progress,
 * DOOR_UNKNOWN if there is no such operation or the text is incomplete, DOOR_FULL if memory is
 * short. */
DOOR_EXPORT(door_open) int door_open(void);

/** Returns the estimated time of the open computation, s on the server's reference machine; 0 for a
 * refused request. */
DOOR_EXPORT(door_cost) double door_cost(void);

/** Allows the answer to be taken in pieces, if its representation can be streamed. From now on a
 * failure breaks the answer. */
DOOR_EXPORT(door_promise) void door_promise(void);

/** Computes about a block of samples, or for some milliseconds. Returns an enum api_progress. */
DOOR_EXPORT(door_run) int door_run(void);

/** Returns the bytes of the answer that were not taken yet, valid until the next call. */
DOOR_EXPORT(door_data) const char *door_data(void);

/** Returns the number of bytes at door_data. */
DOOR_EXPORT(door_bytes) size_t door_bytes(void);

/** Removes the bytes that door_data returned. */
DOOR_EXPORT(door_taken) void door_taken(void);

/** Returns the HTTP status of the answer, which is final once door_run has returned API_DONE. */
DOOR_EXPORT(door_status) int door_status(void);

/** Returns the answer's header fields, one "Name: value" per line, terminated by a NUL; valid until
 * the next call. NULL if memory is short. */
DOOR_EXPORT(door_head) const char *door_head(void);

/** Ends the request and frees its memory; without a request it does nothing. */
DOOR_EXPORT(door_close) void door_close(void);

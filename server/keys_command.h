/* The command `pendulumd keys`: creates, lists, revokes, expires and removes API keys, and sets the
 * limits of roles.
 * Leaves to others: the file (keys/key_file), reloading it in a running server (keys/key_ring).
 * Invariant: a key is printed once, when it is created, and stored nowhere. */
#pragma once

/**
 * Runs `pendulumd keys ACTION ...`; argv as for main.
 *
 * Returns the exit status: 0; 1 if the file or the system fails; 2 for a bad argument. Errors are a
 * sentence on standard error.
 */
int srv_keys_command(int argc, char *const argv[]);

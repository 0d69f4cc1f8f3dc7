/* The command `pendulumd keys`: makes, lists, revokes, expires and removes keys, and sets what
 * roles may have. Leaves to others: the file (keys/key_file), what a running server makes of it
 * (keys/key_ring). Invariant: a key is printed once, where it is made, and nowhere kept. */
#ifndef SRV_KEYS_COMMAND_H
#define SRV_KEYS_COMMAND_H

/**
 * Runs `pendulumd keys ACTION ...`; argv as of main.
 *
 * Returns the exit status: 0, 1 where the file or the system is in the way, 2 for a bad argument,
 * with a sentence on standard error.
 */
int srv_keys_command(int argc, char *const argv[]);

#endif

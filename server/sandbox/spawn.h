/* Another process of this program, begun before this one has threads or anything to hide.
 * Leaves to others: what it does (hooks/hook_loop).
 * Invariant: it has one descriptor of this process besides the empty three, and of the environment
 * what a sanitizer or the linker is told. */
#ifndef SRV_SPAWN_H
#define SRV_SPAWN_H

#include <sys/types.h>

/* the descriptor that it finds its socket at */
enum { SRV_SPAWN_FD = 3 };

/**
 * Starts `pendulumd WORD` with one end of a pair of sockets of packets.
 *
 * word  that main knows.
 * fd    out: this process' end; -1 on failure, with errno set.
 *
 * Returns its pid, -1 on failure.
 */
int srv_spawn(const char *word, int *fd);

/** Waits for a packet for at most a minute; returns its bytes, <= 0 if there is none. */
struct msghdr;
ssize_t srv_spawn_hear(int fd, struct msghdr *message);

/** Whether SRV_SPAWN_FD is such a socket: a person who says the word by hand has none. */
int srv_spawned(void);

#endif

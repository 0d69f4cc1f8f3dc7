/* The process that makes the processes that compute, where the server has --isolate: it is another
 * program than the daemon to the kernel, begun before the daemon has a thread, a socket or a file,
 * so that nothing of these is in the memory of a process that computes.
 * Leaves to others: what these compute (cell_loop), asking for them (cells).
 * Invariant: it has no files, no network and no privileges, and takes orders from its daemon alone;
 * it ends with the daemon, and its processes end with it, whatever they do just then. */
#ifndef SRV_ZYGOTE_H
#define SRV_ZYGOTE_H

#include "server/sandbox/spawn.h"

enum { SRV_ZYGOTE_FD = SRV_SPAWN_FD, SRV_ZYGOTE_TEXT = 200, SRV_ZYGOTE_MOST = 4096 };

/* The first message to it. */
struct srv_zygote_rules {
    double walls;               /* as the option */
    unsigned long long bytes;   /* memory of a process */
    unsigned long long seconds; /* of computation, of a process */
};

/* Its first message. */
struct srv_zygote_hello {
    int good;
    char lack[SRV_ZYGOTE_TEXT]; /* walls that are not up, or why it cannot begin; "" = all are */
};

enum srv_zygote_what {
    SRV_ZYGOTE_NEW, /* another process: its socket comes with the answer */
    SRV_ZYGOTE_END, /* ends a process, and tells how it ended */
    SRV_ZYGOTE_DROP /* ends a process; there is no answer */
};

struct srv_zygote_order {
    int what;
    unsigned long long number;     /* of the process, but for NEW */
    struct srv_zygote_rules rules; /* of NEW: those that hold now; walls stay as they are */
};

struct srv_zygote_told {
    int pid;                   /* <= 0: there is no such process, or none could be made */
    int status;                /* of one that has ended, as waitpid gives it */
    unsigned long long number; /* of the process: the system gives a pid to another once one has
                                  ended, and nobody gives this again */
};

/** What `pendulumd compute` does, which the daemon starts with a socket of packets as descriptor
 * SRV_ZYGOTE_FD. Returns the exit status. */
int srv_zygote_main(void);

#endif

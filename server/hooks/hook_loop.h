/* The process that sends webhooks, `pendulumd hooks`, and what it and the daemon say to each other.
 * Leaves to others: one message (hook_post), what is due and how it went (jobs/courier).
 * Invariant: it knows no store, no key and no client but a message and its url while that is under
 * way; every order is answered once, unless the process ends; it ends with its daemon. */
#ifndef SRV_HOOK_LOOP_H
#define SRV_HOOK_LOOP_H

#include "server/config/config.h"
#include "server/hooks/hook_keys.h"
#include "server/hooks/hook_post.h"
#include "server/store/store.h"

enum { SRV_HOOK_LOOP_MOST = 32, SRV_HOOK_BODY = 8192, SRV_HOOK_LACK = 200 };

/* The first message to it. */
struct srv_hook_rules {
    double walls; /* as the option */
    char networks[SRV_CONFIG_TEXT], authority[SRV_CONFIG_TEXT];
};

/* Its first message. */
struct srv_hook_hello {
    int good;
    char lack[SRV_HOOK_LACK]; /* walls that are not up; "" = all are */
};

/* A message to send. */
struct srv_hook_order {
    int place; /* 0 .. SRV_HOOK_LOOP_MOST - 1: the daemon's, none is used twice at a time */
    char url[SRV_HOOK_BYTES], id[API_WEBHOOK_ID], timestamp[24], signatures[SRV_HOOK_SIGNATURES];
    int bytes;
    char body[SRV_HOOK_BODY];
};

/* How that went. */
struct srv_hook_told {
    int place, status; /* status 0 = no answer */
    enum srv_hook_end end;
};

/** Runs `pendulumd hooks`, which the daemon starts (sandbox/spawn). Returns the exit status. */
int srv_hook_loop_main(void);

#endif

/* The routes of scenes: links that show the same to everybody, until their makers take them
 * away.
 * Leaves to others: what a scene is (api/call/scene), keeping it (store).
 * Invariant: an id never changes its meaning; every exchange that comes in goes out through its
 * finish, once. */
#ifndef SRV_SCENES_H
#define SRV_SCENES_H

#include "server/work/exchange.h"

/** POST /v1/scenes: 201 with the scene and where it is; the same scene again leads to the one
 * that is there. */
void srv_scenes_create(struct srv_exchange *exchange);

/**
 * DELETE /v1/scenes/{id}: the client's share of it; the scene goes with the last share.
 *
 * For a token or an account that stored it; 403 for others, as a link is there to be handed out and
 * its being is no secret. Nobody takes away what was stored without a token, as everybody who
 * shares an address has the link.
 */
void srv_scenes_drop(struct srv_exchange *exchange);

/** GET /v1/scenes/{id}. Who knows the id may ask. */
void srv_scenes_read(struct srv_exchange *exchange);

#endif

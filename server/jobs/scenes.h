/* The routes of scenes: a link that shows the same to everybody, until all clients that stored it
 * have deleted it.
 * Leaves to others: what a scene is (api/link/scene), keeping it (store).
 * Invariant: an id never changes its meaning; the finish of every exchange is called exactly
 * once. */
#ifndef SRV_SCENES_H
#define SRV_SCENES_H

#include "server/work/exchange.h"

/** POST /v1/scenes: 201 with the scene and where it is; a scene that is stored already keeps
 * its id. */
void srv_scenes_create(struct srv_exchange *exchange);

/**
 * DELETE /v1/scenes/{id}: removes the client's share; the scene is deleted with the last share.
 *
 * Allowed for a token or an account that stored the scene; 403 for others, since the existence of a
 * link that is handed out is no secret. A scene that was stored without a token cannot be deleted,
 * since many people may share an address.
 */
void srv_scenes_drop(struct srv_exchange *exchange);

/** GET /v1/scenes/{id}. Whoever knows the id may ask. */
void srv_scenes_read(struct srv_exchange *exchange);

#endif

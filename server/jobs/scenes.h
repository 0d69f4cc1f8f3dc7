/* The routes of scenes. A scene is a permanent link, until all clients that stored it have deleted
 * it. Leaves to others: the contents of a scene (api/link/scene), storing it (store). Invariant: an
 * id never changes its meaning; the finish of every exchange is called exactly once. */
#pragma once

#include "server/work/exchange.h"

/** POST /v1/scenes: 201 with the scene and its Location; an existing scene keeps its id. */
void srv_scenes_create(struct srv_exchange *exchange);

/**
 * DELETE /v1/scenes/{id}: removes the client's share; the scene is deleted with the last share.
 *
 * Allowed for a token or account that stored the scene; 403 for others, because the existence of a
 * shared link is no secret. A scene stored without a token cannot be deleted, because many people
 * may share an address.
 */
void srv_scenes_drop(struct srv_exchange *exchange);

/** GET /v1/scenes/{id}. Anyone with the id can read it. */
void srv_scenes_read(struct srv_exchange *exchange);

/* A scene: a request for a trajectory and the page's view of it, with an id derived from both.
 * Leaves to others: storing it (server), the contents of `view` (the page).
 * Invariant: equal scenes have the same id, whatever the order of keys and the format of numbers;
 * `request` is a valid body for /v1/trajectories. */
#pragma once

#include "api/call/request.h"

enum {
    API_SCENE_ID = 27,         /* bytes of an id with its NUL: 26 letters, 130 bits of a SHA-256 */
    API_SCENE_TITLE = 200,     /* maximum number of characters of a title */
    API_SCENE_VIEW = 16 * 1024 /* maximum bytes of a view in canonical form */
};

/**
 * Reads and checks a scene's body.
 *
 * request  its op is ignored.
 * most     most bytes of a stored scene.
 * created  current time in RFC 3339 form.
 * id       out.
 * scene    the scene is appended as JSON, as it is stored and sent.
 * out      a problem is appended.
 *
 * Returns 0 if the scene is valid, else the problem's HTTP status. O(body).
 */
int api_scene_read(const struct api_request *request, const struct api_limits *limits, double most,
                   const char *created, char id[API_SCENE_ID], struct api_buffer *scene,
                   struct api_buffer *out);

/**
 * Checks a request for a trajectory as /v1/trajectories does, for a representation that streams,
 * whose answers have no size limit.
 *
 * value    the request; an error is added if it is no object.
 *
 * PEND_INVALID    problem has the errors.
 * PEND_NO_MEMORY
 * O(request).
 */
PEND_MUST_CHECK enum pend_status api_scene_check_request(const struct api_value *value,
                                                         const struct api_limits *limits,
                                                         struct api_problem *problem);

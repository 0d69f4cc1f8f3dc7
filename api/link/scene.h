/* A scene: a trajectory's request, and how a page shows it, under an id made from its contents.
 * Leaves to others: storing it (server), the contents of `view` (the page).
 * Invariant: the same scene has the same id, whatever the order of its keys and the spelling of
 * its numbers; `request` is a good body for /v1/trajectories. */
#ifndef API_SCENE_H
#define API_SCENE_H

#include "api/call/request.h"

enum {
    API_SCENE_ID = 27,         /* bytes of an id, with its NUL: 26 letters, 130 bits of a SHA-256 */
    API_SCENE_TITLE = 200,     /* characters of a title */
    API_SCENE_VIEW = 16 * 1024 /* bytes of a view in its canonical form */
};

/**
 * Reads and checks a scene's body.
 *
 * request  its op is ignored.
 * most     bytes that a stored scene may have.
 * created  the time in the form of RFC 3339.
 * id       out.
 * scene    the scene as JSON, as it is stored and sent, is appended here.
 * out      a problem is appended here.
 *
 * Returns 0 if the scene is good, else the problem's HTTP status. O(body).
 */
int api_scene_read(const struct api_request *request, const struct api_limits *limits, double most,
                   const char *created, char id[API_SCENE_ID], struct api_buffer *scene,
                   struct api_buffer *out);

/**
 * Checks a trajectory's request as /v1/trajectories does; a representation that streams has no
 * limit of the answer.
 *
 * value    the request; a fault is added where it is no object.
 *
 * PEND_INVALID    problem has the faults.
 * PEND_NO_MEMORY
 * O(request).
 */
PEND_MUST_CHECK enum pend_status api_scene_check_request(const struct api_value *value,
                                                         const struct api_limits *limits,
                                                         struct api_problem *problem);

#endif

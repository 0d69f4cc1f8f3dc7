/* The url of the store: a file in the user's state directory if the option names none.
 * Leaves to others: opening it (storage).
 * Invariant: a directory that is created here is readable by its user only. */
#pragma once

#include "server/config/config.h"

/**
 * Writes the url of a store. "sqlite" alone stands for pendulumd/store.db in $XDG_STATE_HOME, or in
 * ~/.local/state; missing directories are created.
 *
 * store  as the option; not "none".
 * url    out, SRV_CONFIG_TEXT bytes.
 *
 * PEND_INVALID  there is no such directory and it cannot be created; error says so.
 */
PEND_MUST_CHECK enum pend_status srv_state_url(const char *store, char url[SRV_CONFIG_TEXT],
                                               struct pend_error *error);

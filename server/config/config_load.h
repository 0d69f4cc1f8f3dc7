/* The four places that set the options: default, file, environment, command line.
 * Leaves to others: the list of options (config), using the values.
 * Invariant: loaded values have passed all checks of the table. */
#pragma once

#include "server/config/config.h"

/**
 * Loads the options; later places win: the defaults, the file, the environment, the command line.
 *
 * argv         of main; argv[0] is skipped.
 * environment  of main, ended by NULL; a PENDULUMD_ variable that names no option gives a warning,
 *              because supervisors set some of their own.
 *
 * PEND_INVALID  error->text names the option, its place, and the valid values.
 */
PEND_MUST_CHECK enum pend_status srv_config_load(struct srv_config *config, int argc,
                                                 char *const argv[], char *const environment[],
                                                 struct pend_error *error);

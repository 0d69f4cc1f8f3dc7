/* The command `pendulumd healthy`: queries the health of the server with the same options; the
 * health check of a container without a shell or an HTTP client. Leaves to others: the options
 * (config/config_load), the server's answer (http/probes). Invariant: it starts nothing, stores
 * nothing, and ends within seconds. */
#pragma once

/**
 * Requests GET /healthz at the address of --probe-listen, else of --listen, from the options, the
 * environment and the configuration file; wildcard addresses become loopback. argv as for main;
 * argv[1] is the subcommand.
 *
 * Returns the exit status: 0 if the answer is 200; 1 for any other answer, or none within two
 * seconds per step; 2 for a bad option, with a sentence on standard error.
 */
int srv_healthy_command(int argc, char *const argv[], char *const environment[]);

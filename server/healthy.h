/* The command `pendulumd healthy`: asks the server that has the same options how it is, as the
 * health check of a container without a shell or an HTTP client.
 * Leaves to others: the options (config/config_load), what the server answers (http/probes).
 * Invariant: it starts nothing, keeps nothing, and ends within seconds. */
#ifndef SRV_HEALTHY_H
#define SRV_HEALTHY_H

/**
 * Asks GET /healthz where the options, the environment and the file of options say that the server
 * answers probes: at --probe-listen where there is one, else at --listen; an address that means
 * every one is asked on loopback. argv as of main: argv[1] is the word itself.
 *
 * Returns the exit status: 0 where the answer is 200, 1 where there is none, or another, within two
 * seconds for each step; 2 for a bad option, with a sentence on standard error.
 */
int srv_healthy_command(int argc, char *const argv[], char *const environment[]);

#endif

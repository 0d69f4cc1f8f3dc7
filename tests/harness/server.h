/* A live daemon as a child process, and a small HTTP client that shows every byte.
 * Leaves to others: requests and expected answers (tests/wire).
 * Invariant: a server that a test started ends with the test program; all traffic stays on
 * loopback. */
#pragma once

#include <stddef.h>

struct test_server;

/* s that a test waits for something: the machine may be slow, and busy */
enum { TEST_PATIENCE = 120 };

/**
 * Starts the daemon of the same build (build/MODE/pendulumd) and waits until it says `listening
 * on`.
 *
 * options  command line, ended by NULL; NULL for none. `--listen 127.0.0.1:0 --store none --hosts
 *          *` and an hour for
 * all that a client or a drain may take go in front, so that own ones win. A prefix such as
 * "valgrind -q" can be given in the environment variable TEST_UNDER. Returns NULL, with a failed
 * check, when it does not get ready within
 * TEST_PATIENCE. Ends with test_server_stop.
 */
struct test_server *test_server_start(const char *const options[]);

/** The port that it listens on. */
int test_server_port(const struct test_server *server);

/** The process number. */
int test_server_pid(const struct test_server *server);

/** Its standard error so far; valid until the next call for this server. */
const char *test_server_log(struct test_server *server);

/** Sends a signal. */
void test_server_signal(const struct test_server *server, int number);

/**
 * Waits for the end of the process, at most TEST_PATIENCE.
 *
 * Returns its exit status, 128 + the signal that killed it, or -1 (and kills it) when it did not
 * end.
 */
int test_server_wait(struct test_server *server);

/**
 * Stops it with SIGTERM if it still runs, checks exit status 0 and that standard error contains
 * only the `listening on` line and JSON lines, frees it and clears the pointer. NULL is accepted.
 */
void test_server_stop(struct test_server **server);

/** Kills it if it still runs, frees it and clears the pointer; nothing is checked. */
void test_server_drop(struct test_server **server);

/**
 * Runs the daemon to its end with some options.
 *
 * text  out, what it wrote to standard output and standard error, cut at `cap` - 1 bytes.
 * Returns the exit status as test_server_wait does.
 */
int test_server_run(const char *const options[], char text[], size_t cap);

enum { TEST_HEADERS = 48 };

/* One reply; ends with test_reply_clear. */
struct test_reply {
    int status;     /* 0 = no complete reply */
    int interim;    /* number of 1xx replies before it */
    int keep_alive; /* whether the connection can be used again */
    int headers;
    char *name[TEST_HEADERS], *value[TEST_HEADERS];
    char *head;    /* owns names and values */
    char *trailer; /* lines after the last chunk, each with its CR LF; NULL = none */
    char *body;    /* followed by a NUL; "" if there is none, even if no reply came */
    size_t body_bytes, body_cap;
};

struct test_client {
    int fd; /* -1 = not connected */
    char *data;
    size_t bytes, cap; /* received and not yet returned */
};

/** Connects to 127.0.0.1; returns 1, or 0 with a failed check. */
int test_client_open(struct test_client *client, int port);

void test_client_close(struct test_client *client);

/** Sends bytes; returns 0 if the other side has closed. */
int test_client_send(struct test_client *client, const void *bytes, size_t count);

/** Sends text. */
int test_client_say(struct test_client *client, const char *text);

/**
 * Reads the next whole reply: length-delimited, chunked or up to the end of the connection.
 *
 * bodiless  non-zero for the reply to a HEAD.
 * seconds   the longest wait in all.
 * Returns the status, or 0 if no complete reply came.
 */
int test_client_receive(struct test_client *client, struct test_reply *reply, int bodiless,
                        double seconds);

/** Waits until the other side closes; returns 1 if it did within the time, 0 if it did not or sent
 * more bytes. */
int test_client_ended(struct test_client *client, double seconds);

/** The value of a header (any case), or NULL. */
const char *test_reply_header(const struct test_reply *reply, const char *name);

void test_reply_clear(struct test_reply *reply);

/**
 * One request on a separate connection; every reply is recorded (test_reply_record).
 *
 * headers  further header lines, each ended by CR LF, or "".
 * body     NULL for none; else sent with its Content-Length and as application/json unless headers
 *          name a type.
 * Returns the status, or 0 if no complete reply came within TEST_PATIENCE.
 */
int test_request(const struct test_server *server, struct test_reply *reply, const char *method,
                 const char *path, const char *headers, const char *body);

/**
 * Appends a reply as a line {"method", "path", "status", "content_type", "body"} to replies.ndjson
 * beside the test program, for tests/rules/replies.py; those above 4 MB are left out, and all under
 * TEST_UNDER, which runs beside. The body is text, or null where there was none. What an earlier
 * run appended is removed as the program starts.
 */
void test_reply_record(const struct test_reply *reply, const char *method, const char *path);

/** Seconds of the monotonic clock. */
double test_clock(void);

/** Sleeps. */
void test_sleep(double seconds);

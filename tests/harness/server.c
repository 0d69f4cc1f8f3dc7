#include "tests/harness/server.h"

#include <arpa/inet.h>
#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "tests/harness/test.h"

enum { WORDS = 96 };

struct test_server {
    pid_t pid; /* 0 = it has ended */
    int port, exit_status;
    char log_path[4096];
    char *log;
};

double test_clock(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void test_sleep(double seconds) {
    struct timespec pause = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)};
    nanosleep(&pause, NULL);
}

/* a path next to the test program, or above it: build/MODE/tests/ROOM/run is the program */
static void path_from_program(char path[4096], int up, const char *name) {
    char program[3072];
    ssize_t bytes = readlink("/proc/self/exe", program, sizeof program - 1);
    program[bytes > 0 ? bytes : 0] = 0;
    char *directory = dirname(program);
    for (; up > 0; up--) directory = dirname(directory);
    snprintf(path, 4096, "%s/%s", directory, name);
}

static char *file_text(const char *path) {
    FILE *file = fopen(path, "rb");
    char *text = calloc(1, 1);
    size_t bytes = 0, got;
    char block[4096];
    while (file && text && (got = fread(block, 1, sizeof block, file)) > 0) {
        char *larger = realloc(text, bytes + got + 1);
        if (!larger) break;
        text = larger;
        memcpy(text + bytes, block, got);
        text[bytes += got] = 0;
    }
    if (file) fclose(file);
    return text;
}

/* starts the daemon with its standard output and standard error in a file; 0 on failure */
static pid_t launch(const char *const options[], const char *listen, const char *log_path) {
    static char program[4096], under[4096];
    char *word[WORDS];
    int count = 0;
    const char *prefix = getenv("TEST_UNDER");
    snprintf(under, sizeof under, "%s", prefix ? prefix : "");
    for (char *at = strtok(under, " "); at && count < WORDS / 2; at = strtok(NULL, " "))
        word[count++] = at;
    path_from_program(program, 2, "pendulumd");
    word[count++] = program;
    if (listen) {
        const char *const strict[] = {
            "--listen",         listen, "--store",         "none",  "--max-wait-seconds",   "3600",
            "--header-seconds", "3600", "--body-seconds",  "3600",  "--send-seconds",       "3600",
            "--idle-seconds",   "3600", "--drain-seconds", "86400", "--drain-idle-seconds", "0.25",
            "--hosts",          "*"};
        for (size_t i = 0; i < sizeof strict / sizeof *strict; i++)
            word[count++] = (char *)strict[i];
    }
    for (int i = 0; options && options[i] && count < WORDS - 1; i++)
        word[count++] = (char *)options[i];
    word[count] = NULL;
    fflush(stdout);
    pid_t pid = fork();
    if (pid != 0) return pid > 0 ? pid : 0;
    /* the child ends with the test program, whatever ends it */
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    int log = open(log_path, O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0644);
    int null = open("/dev/null", O_RDONLY);
    if (log < 0 || null < 0) _exit(126);
    dup2(null, 0);
    dup2(log, 1);
    dup2(log, 2);
    setenv("PENDULUMD_ALLOW_ROOT", "on", 0);
    /* another program under which it runs makes other system calls */
    if (prefix) setenv("PENDULUMD_SANDBOX", "off", 0);
    execvp(word[0], word);
    _exit(127);
}

/* collects the child if it has ended; returns 1 if it has */
static int reap(struct test_server *server) {
    int status;
    if (!server->pid) return 1;
    if (waitpid(server->pid, &status, WNOHANG) != server->pid) return 0;
    server->pid = 0;
    server->exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return 1;
}

static int port_in_log(struct test_server *server) {
    const char *log = test_server_log(server), *line = strstr(log, "listening on ");
    if (!line || !strchr(line, '\n')) return 0;
    /* a path has no port, but the line was written */
    if (!strncmp(line, "listening on unix:", 18)) return 1;
    const char *colon = NULL;
    for (const char *at = line; *at != '\n'; at++)
        if (*at == ':') colon = at;
    return atoi(colon + 1);
}

static struct test_server *server_new(const char *const options[], const char *listen) {
    static int number;
    char name[40];
    struct test_server *server = calloc(1, sizeof *server);
    if (!server) return NULL;
    snprintf(name, sizeof name, "server-%d-%d.log", test_lane, ++number);
    path_from_program(server->log_path, 0, name);
    unlink(server->log_path);
    server->pid = launch(options, listen, server->log_path);
    if (!server->pid) server->exit_status = -1;
    return server;
}

static void server_free(struct test_server *server) {
    free(server->log);
    free(server);
}

struct test_server *test_server_start(const char *const options[]) {
    struct test_server *server = server_new(options, "127.0.0.1:0");
    if (!server) return NULL;
    double end = test_clock() + TEST_PATIENCE;
    while (!(server->port = port_in_log(server)) && !reap(server) && test_clock() < end)
        test_sleep(0.002);
    if (server->port) return server;
    CHECK_SAYING(0, "the server did not get ready (exit status %d); it said: %s",
                 server->exit_status, test_server_log(server));
    if (server->pid) kill(server->pid, SIGKILL), test_server_wait(server);
    server_free(server);
    return NULL;
}

int test_server_port(const struct test_server *server) { return server->port; }

int test_server_pid(const struct test_server *server) { return server->pid; }

const char *test_server_log(struct test_server *server) {
    free(server->log);
    server->log = file_text(server->log_path);
    return server->log ? server->log : "";
}

void test_server_signal(const struct test_server *server, int number) {
    if (server->pid) kill(server->pid, number);
}

int test_server_wait(struct test_server *server) {
    double end = test_clock() + TEST_PATIENCE;
    while (!reap(server)) {
        if (test_clock() > end) {
            kill(server->pid, SIGKILL);
            waitpid(server->pid, NULL, 0);
            server->pid = 0;
            return server->exit_status = -1;
        }
        test_sleep(0.002);
    }
    return server->exit_status;
}

/* the first line of the log that is neither the listening line nor a JSON object, or NULL */
static const char *noise(const char *log) {
    while (*log) {
        const char *end = strchr(log, '\n');
        if (!end) return log;
        int json = log[0] == '{' && end[-1] == '}';
        int sandbox = !strncmp(log, "sandbox: incomplete: ", 21);
        int carries = !strncmp(log, "the database's max_connections", 30);
        if (!json && !sandbox && !carries && end != log && strncmp(log, "listening on ", 13) != 0)
            return log;
        log = end + 1;
    }
    return NULL;
}

void test_server_stop(struct test_server **server) {
    if (!*server) return;
    test_server_signal(*server, SIGTERM);
    int status = test_server_wait(*server);
    const char *line = noise(test_server_log(*server));
    CHECK_SAYING(status == 0, "the server ended with status %d", status);
    CHECK_SAYING(!line, "the server said: %s", line);
    server_free(*server);
    *server = NULL;
}

void test_server_drop(struct test_server **server) {
    if (!*server) return;
    test_server_signal(*server, SIGKILL);
    test_server_wait(*server);
    server_free(*server);
    *server = NULL;
}

int test_server_run(const char *const options[], char text[], size_t cap) {
    struct test_server *server = server_new(options, NULL);
    if (!server) return -1;
    int status = test_server_wait(server);
    snprintf(text, cap, "%s", test_server_log(server));
    server_free(server);
    return status;
}

int test_client_open(struct test_client *client, int port) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    *client = (struct test_client){.fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    if (client->fd >= 0 && connect(client->fd, (struct sockaddr *)&address, sizeof address) == 0)
        return 1;
    CHECK_SAYING(0, "connecting to port %d: %s", port, strerror(errno));
    test_client_close(client);
    return 0;
}

void test_client_close(struct test_client *client) {
    if (client->fd >= 0) close(client->fd);
    free(client->data);
    *client = (struct test_client){.fd = -1};
}

int test_client_send(struct test_client *client, const void *bytes, size_t count) {
    const char *at = bytes;
    while (count > 0) {
        ssize_t sent = send(client->fd, at, count, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return 0;
        at += sent;
        count -= (size_t)sent;
    }
    return 1;
}

int test_client_say(struct test_client *client, const char *text) {
    return test_client_send(client, text, strlen(text));
}

/* waits for more bytes until `end`; 1 more came, 0 the connection ended, -1 the time is up */
static int client_more(struct test_client *client, double end) {
    if (client->cap - client->bytes < 65536) {
        char *larger = realloc(client->data, client->cap * 2 + 131072);
        if (!larger) return -1;
        client->data = larger;
        client->cap = client->cap * 2 + 131072;
    }
    double left = end - test_clock();
    struct pollfd wait = {.fd = client->fd, .events = POLLIN};
    if (poll(&wait, 1, left > 0 ? (int)(left * 1000) + 1 : 0) <= 0) return -1;
    ssize_t got =
        recv(client->fd, client->data + client->bytes, client->cap - client->bytes - 1, 0);
    if (got <= 0) return got < 0 ? -1 : 0; /* a reset is not an end */
    client->bytes += (size_t)got;
    client->data[client->bytes] = 0;
    return 1;
}

static void client_drop(struct test_client *client, size_t count) {
    memmove(client->data, client->data + count, client->bytes - count + 1);
    client->bytes -= count;
}

/* waits until `count` bytes have arrived */
static int client_need(struct test_client *client, size_t count, double end) {
    while (client->bytes < count)
        if (client_more(client, end) <= 0) return 0;
    return 1;
}

/* the position after the next occurrence of `mark` at or after `from`, 0 if none came */
static size_t client_find(struct test_client *client, size_t from, const char *mark, double end) {
    for (;;) {
        char *at = client->bytes > from ? strstr(client->data + from, mark) : NULL;
        if (at) return (size_t)(at - client->data) + strlen(mark);
        if (client_more(client, end) <= 0) return 0;
    }
}

/* splits the head into names and values; returns the status */
static int head_split(struct test_reply *reply) {
    char *line = strstr(reply->head, "\r\n");
    if (strncmp(reply->head, "HTTP/1.", 7) != 0 || strlen(reply->head) < 12) return 0;
    while (line && line[2] && line[2] != '\r' && reply->headers < TEST_HEADERS) {
        *line = 0;
        char *name = line + 2, *colon = strchr(name, ':');
        line = strstr(name, "\r\n");
        if (!colon || !line || colon > line) return 0;
        *colon = 0;
        reply->name[reply->headers] = name;
        reply->value[reply->headers++] = colon + 1 + strspn(colon + 1, " \t");
    }
    if (line) *line = 0;
    return atoi(reply->head + 9);
}

const char *test_reply_header(const struct test_reply *reply, const char *name) {
    for (int i = 0; i < reply->headers; i++)
        if (!strcasecmp(reply->name[i], name)) return reply->value[i];
    return NULL;
}

void test_reply_clear(struct test_reply *reply) {
    free(reply->trailer);
    free(reply->head);
    free(reply->body);
    *reply = (struct test_reply){0};
}

/* Moves the first `count` bytes from the client to the end of the body. The buffer doubles: under a
 * sanitizer each realloc copies all previous bytes. */
static int body_take(struct test_client *client, struct test_reply *reply, size_t count) {
    size_t room = reply->body_bytes + count + 1;
    if (room > reply->body_cap) {
        char *larger = realloc(reply->body, 2 * room);
        if (!larger) return 0;
        reply->body = larger;
        reply->body_cap = 2 * room;
    }
    memcpy(reply->body + reply->body_bytes, client->data, count);
    reply->body[reply->body_bytes += count] = 0;
    client_drop(client, count);
    return 1;
}

/* a line after the last chunk, with its CR LF */
static int trailer_take(const struct test_client *client, struct test_reply *reply, size_t line) {
    size_t before = reply->trailer ? strlen(reply->trailer) : 0;
    char *larger = realloc(reply->trailer, before + line + 1);
    if (!larger) return 0;
    memcpy(larger + before, client->data, line);
    larger[before + line] = 0;
    reply->trailer = larger;
    return 1;
}

static int body_chunked(struct test_client *client, struct test_reply *reply, double end) {
    for (;;) {
        size_t line = client_find(client, 0, "\r\n", end);
        if (!line || !isxdigit((unsigned char)client->data[0])) return 0;
        size_t count = strtoul(client->data, NULL, 16);
        client_drop(client, line);
        if (!count) break;
        if (!client_need(client, count + 2, end)) return 0;
        if (!body_take(client, reply, count) || memcmp(client->data, "\r\n", 2) != 0) return 0;
        client_drop(client, 2);
    }
    for (size_t line;;) {
        line = client_find(client, 0, "\r\n", end);
        if (!line) return 0;
        if (line > 2 && !trailer_take(client, reply, line)) return 0;
        client_drop(client, line);
        if (line == 2) return 1;
    }
}

static int body_to_the_end(struct test_client *client, struct test_reply *reply, double end) {
    int more;
    while ((more = client_more(client, end)) > 0) continue;
    return more == 0 && body_take(client, reply, client->bytes);
}

static int body_receive(struct test_client *client, struct test_reply *reply, double end) {
    const char *coding = test_reply_header(reply, "Transfer-Encoding");
    const char *length = test_reply_header(reply, "Content-Length");
    if (coding)
        return !strcasecmp(coding, "chunked") && !length && body_chunked(client, reply, end);
    if (!length) return body_to_the_end(client, reply, end);
    size_t count = strtoul(length, NULL, 10);
    return client_need(client, count, end) && body_take(client, reply, count);
}

int test_client_receive(struct test_client *client, struct test_reply *reply, int bodiless,
                        double seconds) {
    double end = test_clock() + seconds;
    int status, interim = -1;
    *reply = (struct test_reply){.body = calloc(1, 1)};
    do {
        free(reply->head);
        *reply = (struct test_reply){.body = reply->body};
        size_t head = client_find(client, 0, "\r\n\r\n", end);
        if (!head || !(reply->head = strndup(client->data, head))) return 0;
        client_drop(client, head);
        status = head_split(reply);
        reply->interim = ++interim;
    } while (status >= 100 && status < 200);
    const char *connection = test_reply_header(reply, "Connection");
    reply->keep_alive = !connection || strcasecmp(connection, "close") != 0;
    if (!status || !reply->body) return 0;
    if (!bodiless && status != 204 && status != 304 && !body_receive(client, reply, end)) return 0;
    return reply->status = status;
}

int test_client_ended(struct test_client *client, double seconds) {
    size_t before = client->bytes;
    double end = test_clock() + seconds;
    int more;
    while ((more = client_more(client, end)) > 0) continue;
    return more == 0 && client->bytes == before;
}

int test_request(const struct test_server *server, struct test_reply *reply, const char *method,
                 const char *path, const char *headers, const char *body) {
    OWN(test_client, close) client;
    char line[256];
    *reply = (struct test_reply){0};
    if (!test_client_open(&client, server->port)) {
        reply->body = calloc(1, 1);
        return 0;
    }
    test_client_say(&client, method);
    test_client_say(&client, " ");
    test_client_say(&client, path);
    test_client_say(&client, " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n");
    test_client_say(&client, headers);
    snprintf(line, sizeof line, "%sContent-Length: %zu\r\n",
             strcasestr(headers, "content-type:") ? "" : "Content-Type: application/json\r\n",
             body ? strlen(body) : 0);
    if (body) test_client_say(&client, line);
    test_client_say(&client, "\r\n");
    if (body) test_client_say(&client, body);
    int status = test_client_receive(&client, reply, !strcmp(method, "HEAD"), TEST_PATIENCE);
    if (status) test_reply_record(reply, method, path);
    return status;
}

/* a JSON string, or null for NULL */
static void write_text(FILE *file, const char *text) {
    if (!text) {
        fputs("null", file);
        return;
    }
    putc('"', file);
    for (const char *at = text; *at; at++) {
        if (*at == '"' || *at == '\\') putc('\\', file);
        if ((unsigned char)*at < ' ')
            fprintf(file, "\\u%04x", *at);
        else
            putc(*at, file);
    }
    putc('"', file);
}

/* the file may contain lines of an earlier run; the processes of this run append to it at the same
 * time */
__attribute__((constructor)) static void replies_forget(void) {
    char file_path[4096];
    path_from_program(file_path, 0, "replies.ndjson");
    if (!getenv("TEST_UNDER")) unlink(file_path);
}

void test_reply_record(const struct test_reply *reply, const char *method, const char *path) {
    char file_path[4096];
    /* an encoded body has the same contents, and is not text */
    if (reply->body_bytes > 4 << 20 || test_reply_header(reply, "Content-Encoding") ||
        getenv("TEST_UNDER"))
        return;
    path_from_program(file_path, 0, "replies.ndjson");
    FILE *file = fopen(file_path, "a");
    if (!file) return;
    flock(fileno(file), LOCK_EX);
    fprintf(file, "{\"method\":\"%s\",\"path\":", method);
    write_text(file, path);
    fprintf(file, ",\"status\":%d,\"content_type\":", reply->status);
    write_text(file, test_reply_header(reply, "Content-Type"));
    fprintf(file, ",\"body\":");
    write_text(file, reply->body_bytes ? reply->body : NULL);
    fprintf(file, "}\n");
    fclose(file);
}

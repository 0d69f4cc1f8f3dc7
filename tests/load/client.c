/* A load client that sees every single request: closed loops, dripping and idle connections, one
 * epoll thread.
 * Leaves to others: what is asked (files of raw messages), starting servers and judging the
 * figures (load.py).
 * Invariant: loopback only; an answer is read to its last byte before the next request of its
 * connection goes out. */
#include <arpa/inet.h>
#include <errno.h>
#include <getopt.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    CLIENT_MESSAGES = 64,
    CLIENT_HEAD = 16384,  /* bytes of an answer's head */
    CLIENT_BUCKETS = 4096 /* of the histogram: 64 for every power of two of a microsecond */
};

static const char client_usage[] =
    "usage: client --port P [options] MESSAGE[=STATUS]...\n"
    "Each MESSAGE is a file with one raw request; STATUS (200) is what must answer it, 0 "
    "anything.\n"
    "  --connections N   closed loops (8)          --seconds S       how long (5)\n"
    "  --requests N      ends after so many (no end) --close-every N  new connection after N "
    "answers (0 = never)\n"
    "  --leave-every N   leaves instead of reading every N-th answer (0 = never)\n"
    "  --drip N          connections that send a byte a second\n"
    "  --idle N          connections that say nothing\n"
    "  --spread          each connection from a loopback address of its own\n"
    "  --slow-ms T       lists requests that took longer (0 = none); a stall of all runs "
    "--at-stall COMMAND\n"
    "  --seed N          of the mix (1)\n";

/* What a connection is for. */
enum client_kind { CLIENT_LOOP, CLIENT_DRIP, CLIENT_IDLE };

struct client_message {
    const char *name;
    char *data;
    size_t bytes;
    int status;
};

struct client_connection {
    enum client_kind kind;
    int fd, number;
    const struct client_message *message;
    size_t sent;
    int64_t begun; /* ns: the first byte of the request; 0 = none is under way */
    /* the answer so far */
    int head_bytes, status, chunked, close, chunk_state;
    int64_t left; /* bytes of the body or chunk; -1 = up to the end */
    int answers;  /* on this connection */
    char head[CLIENT_HEAD + 1];
};

static struct {
    int port, connections, close_every, leave_every, drip, idle, spread;
    double seconds, slow_ms;
    long requests;
    const char *at_stall;
    uint64_t random;
    struct client_message message[CLIENT_MESSAGES];
    int messages;
} ask = {.connections = 8, .seconds = 5, .requests = -1, .random = 1};

static struct {
    long begun, complete, wrong, broken, refused, left, slow, stalls;
    long drips_open, drips_ended;
    int64_t bytes, longest, last; /* last: when an answer was last complete */
    long bucket[CLIENT_BUCKETS];
} got;

static int client_epoll;
static int64_t client_start;
static char client_rubbish[1 << 18];

static int64_t now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * INT64_C(1000000000) + time.tv_nsec;
}

static _Noreturn void die(const char *what) {
    perror(what);
    exit(2);
}

static uint64_t client_random(void) {
    ask.random ^= ask.random << 13;
    ask.random ^= ask.random >> 7;
    ask.random ^= ask.random << 17;
    return ask.random;
}

/* --- latencies --- */

static int bucket_of(int64_t ns) {
    uint64_t us = (uint64_t)(ns / 1000 > 0 ? ns / 1000 : 1);
    int power = 63 - __builtin_clzll(us);
    int place = power < 6 ? (int)us : 64 * (power - 5) + (int)(us >> (power - 6) & 63);
    return place < CLIENT_BUCKETS ? place : CLIENT_BUCKETS - 1;
}

/* ms, the upper end of a bucket */
static double bucket_ms(int bucket) {
    if (bucket < 64) return (bucket + 1) / 1e3;
    int power = bucket / 64 + 5;
    return (double)(((UINT64_C(64) + (unsigned)bucket % 64 + 1) << (power - 6))) / 1e3;
}

static double quantile_ms(double part) {
    long want = (long)(part * (double)got.complete), seen = 0;
    for (int i = 0; i < CLIENT_BUCKETS; i++)
        if ((seen += got.bucket[i]) > want) return bucket_ms(i);
    return 0;
}

/* --- connections --- */

static void client_watch(struct client_connection *connection, int operation, uint32_t events) {
    struct epoll_event event = {.events = events, .data.ptr = connection};
    if (epoll_ctl(client_epoll, operation, connection->fd, &event)) die("epoll_ctl");
}

static void client_open(struct client_connection *connection) {
    struct sockaddr_in from = {.sin_family = AF_INET},
                       to = {.sin_family = AF_INET, .sin_port = htons((uint16_t)ask.port)};
    int on = 1;
    connection->fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (connection->fd < 0) die("socket");
    setsockopt(connection->fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (ask.spread) {
        setsockopt(connection->fd, IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, &on, sizeof on);
        from.sin_addr.s_addr = htonl(0x7f000002u + (uint32_t)connection->number);
        if (bind(connection->fd, (struct sockaddr *)&from, sizeof from)) die("bind");
    }
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(connection->fd, (struct sockaddr *)&to, sizeof to) && errno != EINPROGRESS)
        die("connect");
    connection->answers = 0;
    connection->begun = 0;
    connection->message = NULL;
    client_watch(connection, EPOLL_CTL_ADD, connection->kind == CLIENT_LOOP ? EPOLLOUT : EPOLLIN);
    got.drips_open += connection->kind == CLIENT_DRIP;
}

static void client_close(struct client_connection *connection) {
    if (connection->fd >= 0) close(connection->fd);
    connection->fd = -1;
}

static int client_done(void) { return ask.requests >= 0 && got.begun >= ask.requests; }

static void client_begin(struct client_connection *connection) {
    connection->message = &ask.message[client_random() % (uint64_t)ask.messages];
    connection->sent = 0;
    connection->head_bytes = connection->status = connection->chunked = connection->chunk_state =
        connection->close = 0;
    connection->left = 0;
    connection->begun = now();
    got.begun++;
}

/* sends on; returns 0 when the other side has gone */
static int client_send(struct client_connection *connection) {
    const struct client_message *message = connection->message;
    while (connection->sent < message->bytes) {
        ssize_t sent = send(connection->fd, message->data + connection->sent,
                            message->bytes - connection->sent, MSG_NOSIGNAL);
        if (sent < 0 && errno == EAGAIN) {
            client_watch(connection, EPOLL_CTL_MOD, EPOLLIN | EPOLLOUT);
            return 1;
        }
        if (sent < 0) return 0;
        connection->sent += (size_t)sent;
    }
    client_watch(connection, EPOLL_CTL_MOD, EPOLLIN);
    return 1;
}

static void client_next(struct client_connection *connection);

/* a connection that ended in mid-answer, or could not be had */
static void client_broken(struct client_connection *connection) {
    if (connection->begun && connection->sent)
        got.broken++;
    else
        got.refused++;
    if (got.broken + got.refused <= 5)
        fprintf(stderr, "connection %d: %s after %zu bytes of %s and %d of its answer\n",
                connection->number, errno ? strerror(errno) : "ended", connection->sent,
                connection->message ? connection->message->name : "-", connection->head_bytes);
    client_close(connection);
    if (!client_done()) client_open(connection);
}

static void client_complete(struct client_connection *connection) {
    int64_t time = now(), took = time - connection->begun;
    const struct client_message *message = connection->message;
    got.complete++;
    got.last = time;
    got.bucket[bucket_of(took)]++;
    if (took > got.longest) got.longest = took;
    if (message->status && connection->status != message->status && got.wrong++ < 5)
        fprintf(stderr, "%s was answered %d\n", message->name, connection->status);
    if (ask.slow_ms > 0 && (double)took > ask.slow_ms * 1e6 && got.slow++ < 200)
        fprintf(stderr, "slow: at %.3f s, %.0f ms, connection %d, answer %d of it, %s\n",
                (double)(time - client_start) / 1e9, (double)took / 1e6, connection->number,
                connection->answers + 1, message->name);
    connection->begun = 0;
    connection->answers++;
    if (connection->close || (ask.close_every && connection->answers >= ask.close_every)) {
        client_close(connection);
        if (!client_done()) client_open(connection);
        return;
    }
    client_next(connection);
}

static void client_next(struct client_connection *connection) {
    if (client_done()) {
        client_close(connection);
        return;
    }
    client_begin(connection);
    if (!client_send(connection)) client_broken(connection);
}

/* --- answers --- */

/* the head is there: how long is the body? */
static void client_head(struct client_connection *connection) {
    const char *length = strcasestr(connection->head, "\r\nContent-Length:");
    connection->status = atoi(connection->head + 9);
    connection->chunked = strcasestr(connection->head, "\r\nTransfer-Encoding: chunked") != NULL;
    connection->close = strcasestr(connection->head, "\r\nConnection: close") != NULL;
    connection->left = length ? strtoll(length + 17, NULL, 10) : connection->chunked ? 0 : -1;
    if (connection->status == 204 || connection->status == 304 ||
        !strncmp(connection->message->data, "HEAD ", 5))
        connection->left = connection->chunked = 0;
}

/* takes bytes of the head; returns how many */
static size_t client_take_head(struct client_connection *connection, const char *data,
                               size_t bytes) {
    size_t taken = 0;
    while (taken < bytes && connection->head_bytes < CLIENT_HEAD) {
        char *head = connection->head;
        int at = connection->head_bytes;
        head[connection->head_bytes++] = data[taken++];
        if (at < 3 || head[at] != '\n' || memcmp(head + at - 3, "\r\n\r\n", 4) != 0) continue;
        head[connection->head_bytes] = 0;
        client_head(connection);
        break;
    }
    return taken;
}

/* takes bytes of chunks; chunk_state: 0 a size comes, 1 its line ends, 2 CR, 3 LF behind a
 * chunk, 4.. the trailer */
static size_t client_take_chunk(struct client_connection *connection, const char *data,
                                size_t bytes) {
    size_t taken = 0;
    while (taken < bytes && connection->chunk_state < 6) {
        char c = data[taken];
        if (connection->left > 0) {
            size_t run =
                (size_t)connection->left < bytes - taken ? (size_t)connection->left : bytes - taken;
            connection->left -= (int64_t)run;
            taken += run;
            if (!connection->left) connection->chunk_state = 2;
            continue;
        }
        taken++;
        if (connection->chunk_state == 0 && c != '\r') {
            connection->left = 16 * connection->left - (c <= '9' ? c - '0' : (c | 32) - 'a' + 10);
        } else if (connection->chunk_state == 0) {
            connection->chunk_state = 1;
        } else if (connection->chunk_state == 1) {
            connection->left = -connection->left;
            connection->chunk_state = connection->left ? 0 : 4;
        } else if (connection->chunk_state < 4) {
            connection->chunk_state = connection->chunk_state == 2 ? 3 : 0;
        } else {
            connection->chunk_state++;
        }
    }
    return taken;
}

/* reads what is there; an answer may end in it */
static void client_receive(struct client_connection *connection) {
    errno = 0;
    ssize_t count = recv(connection->fd, client_rubbish, sizeof client_rubbish, 0);
    if (count < 0 && errno == EAGAIN) return;
    if (connection->kind != CLIENT_LOOP) {
        got.drips_ended += count <= 0;
        if (count > 0) return;
        client_close(connection);
        client_open(connection);
        return;
    }
    if (count <= 0) {
        int whole = !count && connection->begun && connection->status && connection->left == -1 &&
                    !connection->chunked;
        connection->close |= whole;
        if (whole)
            client_complete(connection);
        else
            client_broken(connection);
        return;
    }
    got.bytes += count;
    const char *data = client_rubbish;
    size_t bytes = (size_t)count, run = 0;
    if (!connection->status) run = client_take_head(connection, data, bytes);
    if (!connection->status) return;
    if (ask.leave_every && got.begun % ask.leave_every == 0) {
        got.left++;
        client_close(connection);
        if (!client_done()) client_open(connection);
        return;
    }
    data += run, bytes -= run;
    if (connection->chunked)
        run = client_take_chunk(connection, data, bytes);
    else if (connection->left > 0)
        connection->left -=
            (int64_t)(run = (size_t)connection->left < bytes ? (size_t)connection->left : bytes);
    else
        run = connection->left < 0 ? bytes : 0;
    if (run < bytes) {
        fprintf(stderr, "%s: %zu bytes behind the answer\n", connection->message->name,
                bytes - run);
        got.wrong++;
    }
    int over = connection->chunked ? connection->chunk_state == 6 : !connection->left;
    if (!over) return;
    if (connection->status >= 200) {
        client_complete(connection);
    } else {
        connection->head_bytes = connection->status = 0; /* an interim answer */
    }
}

static void client_event(struct client_connection *connection, uint32_t events) {
    if (connection->fd < 0) return;
    if (connection->kind == CLIENT_LOOP && !connection->begun && events & EPOLLOUT &&
        !(events & (EPOLLERR | EPOLLHUP))) {
        client_next(connection);
    } else if (events & (EPOLLIN | EPOLLERR | EPOLLHUP)) {
        client_receive(connection);
    } else if (events & EPOLLOUT && !client_send(connection)) {
        client_broken(connection);
    }
}

/* the dripping connections take turns, so that each sends a byte a second: one in a field that
 * never ends */
static void client_drip(struct client_connection connection[], int64_t *at, int *turn) {
    static const char head[] = "POST /v1/trees HTTP/1.1\r\nHost: x\r\nX-Drip: ";
    int64_t pause = ask.drip ? INT64_C(1000000000) / ask.drip : 0;
    for (int64_t time = now(); ask.drip && time > *at;
         *at += pause, *turn = (*turn + 1) % ask.drip) {
        struct client_connection *one = &connection[*turn];
        char c = one->sent < sizeof head - 1 ? head[one->sent] : 'a';
        if (one->answers == 0 && send(one->fd, &c, 1, MSG_NOSIGNAL) == 1) one->sent++;
    }
}

/* nobody has got an answer for long, though all wait for one */
static void client_stall(void) {
    int64_t time = now();
    if (ask.slow_ms <= 0 || !got.last || (double)(time - got.last) < ask.slow_ms * 1e6) return;
    fprintf(stderr, "stall: at %.3f s, nothing for %.0f ms\n", (double)(time - client_start) / 1e9,
            (double)(time - got.last) / 1e6);
    if (!got.stalls++ && ask.at_stall && system(ask.at_stall))
        fprintf(stderr, "the command failed\n");
    got.last = now();
}

static void client_run(struct client_connection connection[], int count) {
    int turn = 0, alive = 1;
    int64_t drip_at = now(), end = client_start + (int64_t)(ask.seconds * 1e9);
    while (alive && now() < end) {
        struct epoll_event event[256];
        int events = epoll_wait(client_epoll, event, 256, ask.drip ? 1 : 20);
        for (int i = 0; i < events; i++) client_event(event[i].data.ptr, event[i].events);
        client_drip(connection, &drip_at, &turn);
        if (!events) client_stall();
        if (!client_done()) continue;
        alive = 0;
        for (int i = 0; i < count; i++)
            alive |= connection[i].kind == CLIENT_LOOP && connection[i].fd >= 0;
    }
}

/* --- start and end --- */

static void client_load(const char *argument) {
    struct client_message *message = &ask.message[ask.messages++];
    char *name = strdup(argument), *status = strrchr(name, '=');
    if (ask.messages > CLIENT_MESSAGES) die("too many messages");
    message->status = status ? atoi(status + 1) : 200;
    if (status) *status = 0;
    FILE *file = fopen(name, "rb");
    if (!file) die(name);
    message->data = calloc(1, 16 << 20);
    message->bytes = fread(message->data, 1, (16 << 20) - 1, file);
    message->name = name;
    fclose(file);
}

static void client_options(int argc, char **argv) {
    static const struct option options[] = {
        {"port", 1, NULL, 'p'},     {"connections", 1, NULL, 'c'}, {"seconds", 1, NULL, 's'},
        {"requests", 1, NULL, 'n'}, {"close-every", 1, NULL, 'k'}, {"leave-every", 1, NULL, 'l'},
        {"drip", 1, NULL, 'd'},     {"idle", 1, NULL, 'i'},        {"spread", 0, NULL, 'a'},
        {"slow-ms", 1, NULL, 't'},  {"at-stall", 1, NULL, 'x'},    {"seed", 1, NULL, 'r'},
        {NULL, 0, NULL, 0},
    };
    for (int option; (option = getopt_long(argc, argv, "", options, NULL)) != -1;) switch (option) {
        case 'p':
            ask.port = atoi(optarg);
            break;
        case 'c':
            ask.connections = atoi(optarg);
            break;
        case 's':
            ask.seconds = atof(optarg);
            break;
        case 'n':
            ask.requests = atol(optarg);
            break;
        case 'k':
            ask.close_every = atoi(optarg);
            break;
        case 'l':
            ask.leave_every = atoi(optarg);
            break;
        case 'd':
            ask.drip = atoi(optarg);
            break;
        case 'i':
            ask.idle = atoi(optarg);
            break;
        case 'a':
            ask.spread = 1;
            break;
        case 't':
            ask.slow_ms = atof(optarg);
            break;
        case 'x':
            ask.at_stall = optarg;
            break;
        case 'r':
            ask.random += strtoull(optarg, NULL, 10) * 0x9e3779b97f4a7c15u;
            break;
        default:
            fputs(client_usage, stderr);
            exit(2);
        }
    for (int i = optind; i < argc; i++) client_load(argv[i]);
    if (ask.port && (ask.messages || !ask.connections)) return;
    fputs(client_usage, stderr);
    exit(2);
}

static void client_report(double seconds) {
    printf("{\"seconds\":%.3f,\"requests\":%ld,\"rate\":%.1f,\"wrong\":%ld,\"broken\":%ld,"
           "\"refused\":%ld,\"left\":%ld,\"slow\":%ld,\"stalls\":%ld,\"bytes\":%lld,\"p50\":%.3f,"
           "\"p99\":%.3f,\"p999\":%.3f,\"longest\":%.3f,\"drips_ended\":%ld}\n",
           seconds, got.complete, (double)got.complete / seconds, got.wrong, got.broken,
           got.refused, got.left, got.slow, got.stalls, (long long)got.bytes, quantile_ms(0.5),
           quantile_ms(0.99), quantile_ms(0.999), (double)got.longest / 1e6, got.drips_ended);
}

int main(int argc, char **argv) {
    client_options(argc, argv);
    int count = ask.drip + ask.idle + ask.connections;
    struct rlimit files = {(rlim_t)count + 64, (rlim_t)count + 64};
    if (count > 900 && setrlimit(RLIMIT_NOFILE, &files)) die("setrlimit");
    struct client_connection *connection = calloc((size_t)count, sizeof *connection);
    client_epoll = epoll_create1(EPOLL_CLOEXEC);
    if (!connection || client_epoll < 0) die("out of memory");
    client_start = now();
    for (int i = 0; i < count; i++) {
        connection[i].number = i;
        connection[i].kind = i < ask.drip              ? CLIENT_DRIP
                             : i < ask.drip + ask.idle ? CLIENT_IDLE
                                                       : CLIENT_LOOP;
        client_open(&connection[i]);
    }
    client_run(connection, count);
    client_report((double)(now() - client_start) / 1e9);
    return got.wrong || got.broken || got.refused;
}

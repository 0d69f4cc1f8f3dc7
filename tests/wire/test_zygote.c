/* `pendulumd compute`, the process that makes those which compute, asked by the test in the
 * daemon's place: which process an order means, and when there is none. */
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/work/zygote.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"

enum { PATH = 1024, TRIES = 300, ENOUGH = 64 << 20, MINUTE = 60 };

struct zygote {
    int pid, fd;
};

/* a process that was made, and the test's end of its socket */
struct made {
    struct srv_zygote_told told;
    int fd;
};

static int hear(int fd, void *data, size_t bytes) {
    struct pollfd ear = {.fd = fd, .events = POLLIN};
    return poll(&ear, 1, 1000 * TEST_PATIENCE) == 1 && read(fd, data, bytes) == (ssize_t)bytes;
}

static int begin(struct zygote *zygote) {
    char program[PATH] = "", *words[] = {program, "compute", NULL};
    const struct srv_zygote_rules rules = {.walls = 0, .bytes = ENOUGH, .seconds = MINUTE};
    struct srv_zygote_hello hello;
    int ends[2];
    ssize_t bytes = readlink("/proc/self/exe", program, sizeof program - 1);
    program[bytes > 0 ? bytes : 0] = 0;
    char *end = strstr(program, "/tests/wire/run");
    if (!CHECK(end != NULL) || !CHECK(!socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends)))
        return 0;
    strcpy(end, "/pendulumd");
    zygote->pid = fork();
    if (!zygote->pid) {
        if (ends[1] == SRV_ZYGOTE_FD)
            fcntl(ends[1], F_SETFD, 0);
        else
            dup2(ends[1], SRV_ZYGOTE_FD);
        execv(program, words);
        _exit(1);
    }
    close(ends[1]);
    zygote->fd = ends[0];
    return CHECK(write(ends[0], &rules, sizeof rules) == (ssize_t)sizeof rules) &&
           CHECK(hear(ends[0], &hello, sizeof hello)) && CHECK(hello.good);
}

static void end(struct zygote *zygote) {
    int status = -1;
    close(zygote->fd);
    waitpid(zygote->pid, &status, 0);
    CHECK_SAYING(WIFEXITED(status) && !WEXITSTATUS(status), "status %d", status);
}

static int order(const struct zygote *zygote, enum srv_zygote_what what,
                 unsigned long long number) {
    struct srv_zygote_order said = {.what = (int)what, .number = number};
    said.rules = (struct srv_zygote_rules){.bytes = ENOUGH, .seconds = MINUTE};
    return CHECK(write(zygote->fd, &said, sizeof said) == (ssize_t)sizeof said);
}

static struct made take(const struct zygote *zygote) {
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control;
    struct made made = {.fd = -1};
    struct iovec iov = {&made.told, sizeof made.told};
    struct msghdr message = {.msg_iov = &iov,
                             .msg_iovlen = 1,
                             .msg_control = control.room,
                             .msg_controllen = sizeof control.room};
    order(zygote, SRV_ZYGOTE_NEW, 0);
    CHECK(recvmsg(zygote->fd, &message, MSG_CMSG_CLOEXEC) == (ssize_t)sizeof made.told);
    struct cmsghdr *head = CMSG_FIRSTHDR(&message);
    if (CHECK(head && head->cmsg_type == SCM_RIGHTS))
        memcpy(&made.fd, CMSG_DATA(head), sizeof made.fd);
    CHECK(made.told.pid > 0);
    return made;
}

/* ends a process by an order; what is told of it */
static struct srv_zygote_told finish(const struct zygote *zygote, unsigned long long number) {
    struct srv_zygote_told told = {.pid = 0};
    order(zygote, SRV_ZYGOTE_END, number);
    CHECK(hear(zygote->fd, &told, sizeof told));
    return told;
}

/* how many processes another has made that somebody has not waited for yet; of one: its pid */
static int children(int parent, int *first) {
    char path[PATH], text[PATH] = "";
    int count = 0, used = 0, pid;
    snprintf(path, sizeof path, "/proc/%d/task/%d/children", parent, parent);
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    size_t bytes = fread(text, 1, sizeof text - 1, file);
    text[bytes] = 0;
    fclose(file);
    for (const char *at = text; sscanf(at, "%d%n", &pid, &used) == 1; at += used)
        if (!count++) *first = pid;
    return count;
}

/* waits until there are so many */
static int await(int parent, int count, int *first) {
    double until = test_clock() + TEST_PATIENCE;
    while (children(parent, first) != count && test_clock() < until) test_sleep(0.002);
    return CHECK_INT(children(parent, first), count);
}

/* is there a process of that number? One that has ended, and that nobody has waited for, is none */
static int here(int pid) {
    char path[PATH], text[PATH] = "";
    snprintf(path, sizeof path, "/proc/%d/stat", pid);
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    /* PID (NAME) STATE */
    const char *at = fgets(text, sizeof text, file) ? strrchr(text, ')') : NULL;
    fclose(file);
    return at && strncmp(at, ") Z", 3) != 0;
}

static int gone(int pid) {
    double until = test_clock() + TEST_PATIENCE;
    while (here(pid) && test_clock() < until) test_sleep(0.002);
    return !here(pid);
}

/* the system gives this pid to the next process, if nobody is quicker and it may be told so */
static int next_pid(int pid) {
    int fd = open("/proc/sys/kernel/ns_last_pid", O_WRONLY | O_CLOEXEC);
    int good = fd >= 0 && dprintf(fd, "%d", pid - 1) > 0;
    if (fd >= 0) close(fd);
    return good;
}

/* waits until a process has begun to be what it is made for; it is bound to its maker then */
static int begun(int pid) {
    char path[PATH], name[64] = "";
    double until = test_clock() + TEST_PATIENCE;
    snprintf(path, sizeof path, "/proc/%d/comm", pid);
    for (; strcmp(name, "pendulumd-cell\n") && test_clock() < until; test_sleep(0.002)) {
        FILE *file = fopen(path, "r");
        if (!file || !fgets(name, sizeof name, file)) name[0] = 0;
        if (file) fclose(file);
    }
    return !strcmp(name, "pendulumd-cell\n");
}

TEST(an_order_means_the_process_that_was_made_and_not_a_later_one_of_its_pid) {
    struct zygote zygote;
    struct made first, again = {.fd = -1};
    int spare = 0, may = 1;
    if (!begin(&zygote)) return;
    first = take(&zygote);
    /* it ends by itself, and nobody has asked how */
    await(zygote.pid, 2, &spare);
    CHECK(!kill(first.told.pid, SIGTERM));
    await(zygote.pid, 1, &spare);
    for (int i = 0; may && i < TRIES && again.told.pid != first.told.pid; i++) {
        if (again.fd >= 0) {
            close(again.fd);
            order(&zygote, SRV_ZYGOTE_DROP, again.told.number);
        }
        await(zygote.pid, 1, &spare);
        may = next_pid(first.told.pid);
        again = take(&zygote);
    }
    if (again.told.pid != first.told.pid)
        test_skip("the system gives no pid again that is asked for");
    /* the next one made ahead is not to get it again */
    await(zygote.pid, 2, &spare);
    struct srv_zygote_told told = finish(&zygote, first.told.number);
    CHECK(again.told.number != first.told.number);
    CHECK_SAYING(told.pid == first.told.pid && WIFSIGNALED(told.status) &&
                     WTERMSIG(told.status) == SIGTERM,
                 "status %d", told.status);
    CHECK(here(again.told.pid));
    told = finish(&zygote, again.told.number);
    CHECK(told.pid == again.told.pid && WTERMSIG(told.status) == SIGKILL);
    CHECK(gone(again.told.pid));
    /* what has been told of, or never was, is nobody's any more */
    CHECK(finish(&zygote, first.told.number).pid < 0 && finish(&zygote, 1000000).pid < 0);
    close(first.fd);
    if (again.fd >= 0) close(again.fd);
    end(&zygote);
}

TEST(a_process_made_ahead_that_ends_is_made_again_when_somebody_has_asked) {
    struct zygote zygote;
    int spare = 0, other = 0;
    if (!begin(&zygote)) return;
    await(zygote.pid, 1, &spare);
    /* it has waited for that one: a sanitizer's threads may outlive what /proc shows as ended */
    CHECK(!kill(spare, SIGKILL));
    await(zygote.pid, 0, &other);
    /* it has looked for what to do since */
    for (int i = 0; i < 3; i++) CHECK(finish(&zygote, 1000000).pid < 0);
    CHECK_INT(children(zygote.pid, &other), 0);
    struct made made = take(&zygote);
    CHECK(made.told.pid != spare && here(made.told.pid));
    await(zygote.pid, 2, &other);
    close(made.fd);
    end(&zygote);
}

TEST(a_process_that_stands_still_ends_with_the_one_that_made_it) {
    struct zygote zygote;
    int status = 0;
    if (!begin(&zygote)) return;
    struct made made = take(&zygote);
    /* it takes no notice of its socket, nor of any other signal */
    CHECK(begun(made.told.pid));
    CHECK(!kill(made.told.pid, SIGSTOP) && !kill(zygote.pid, SIGKILL));
    CHECK(waitpid(zygote.pid, &status, 0) == zygote.pid);
    CHECK(gone(made.told.pid));
    if (here(made.told.pid)) kill(made.told.pid, SIGKILL);
    close(made.fd);
    close(zygote.fd);
}

/* The sandbox of a live daemon: its privileges, and the kernel's answer to forbidden calls. The
 * test attaches to the daemon as a debugger does and makes one of its threads execute a call, as an
 * attacker's code would. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/harness/server.h"
#include "tests/harness/test.h"
#include "tests/wire/ask.h"

enum { PATH = 4096 };

/* starts a daemon with the full sandbox; skips the test if this build or kernel does not support it
 */
static struct test_server *sandboxed(void) {
    const char *const options[] = {"--sandbox", "on", NULL};
    char said[PATH];
    const char *const brief[] = {"--sandbox", "on",     "--listen", "127.0.0.1:0", "--store",
                                 "none",      "--role", "worker",   NULL};
    int status = test_server_run(brief, said, sizeof said);
    if (getenv("TEST_UNDER") || (status == 1 && strstr(said, "sandbox: "))) {
        test_skip(getenv("TEST_UNDER") ? "it runs under another program" : said);
        return NULL;
    }
    return test_server_start(options);
}

TEST(a_live_server_has_no_privileges_and_a_filter) {
    OWN(test_server, stop) *server = sandboxed();
    if (!server) return;
    int pid = test_server_pid(server);
    CHECK_INT(ask_process(pid, "NoNewPrivs", 10), 1);
    CHECK_INT(ask_process(pid, "Seccomp", 10), 2);
    CHECK_INT(ask_process(pid, "CapEff", 16), 0);
    CHECK_INT(ask_process(pid, "CapPrm", 16), 0);
    CHECK_INT(ask_process(pid, "CapAmb", 16), 0);
    if (!geteuid()) CHECK_INT(ask_process(pid, "CapBnd", 16), 0);
}

TEST(root_is_refused_unless_it_is_allowed) {
    char said[PATH];
    const char *const options[] = {"--allow-root", "off",    "--listen", "127.0.0.1:0", "--store",
                                   "none",         "--role", "worker",   NULL};
    if (geteuid()) {
        test_skip("this is not root");
        return;
    }
    CHECK_INT(test_server_run(options, said, sizeof said), 1);
    CHECK_SAYING(strstr(said, "the server does not need root") && strstr(said, "--allow-root on"),
                 "%s", said);
}

#if defined __x86_64__

/* makes the stopped process execute a call as soon as it continues; returns 0 if that is not
 * possible */
static int prepared(int pid, long number, const long long argument[6],
                    struct user_regs_struct *before) {
    if (!CHECK(!ptrace(PTRACE_GETREGS, pid, NULL, before))) return 0;
    struct user_regs_struct now = *before;
    /* it waits in a system call: the instruction of that call is before the next one */
    now.rip -= 2, now.rax = (unsigned long long)number, now.orig_rax = (unsigned long long)-1;
    now.rdi = (unsigned long long)argument[0], now.rsi = (unsigned long long)argument[1];
    now.rdx = (unsigned long long)argument[2], now.r10 = (unsigned long long)argument[3];
    now.r8 = (unsigned long long)argument[4], now.r9 = (unsigned long long)argument[5];
    errno = 0;
    long code = ptrace(PTRACE_PEEKTEXT, pid, (void *)now.rip, NULL);
    return CHECK(!errno && (code & 0xffff) == 0x050f) &&
           CHECK(!ptrace(PTRACE_SETREGS, pid, NULL, &now));
}

/* makes the stopped process execute one call, with the handler of signals that may follow; returns
 * the call's result */
static long long injected(int pid, long number, const long long argument[6]) {
    struct user_regs_struct before, now;
    int status, sent = 0;
    if (!prepared(pid, number, argument, &before)) return -1;
    do {
        if (!CHECK(!ptrace(PTRACE_SINGLESTEP, pid, NULL, (void *)(long)sent))) return -1;
        if (!CHECK(waitpid(pid, &status, __WALL) == pid && WIFSTOPPED(status))) return -1;
        /* the signal of a call that is not listed: its handler sets what the call returns */
        sent = WSTOPSIG(status) == SIGSYS ? SIGSYS : 0;
        if (!CHECK(!ptrace(PTRACE_GETREGS, pid, NULL, &now))) return -1;
        /* the handler's own calls may pass the same instruction, with another stack */
    } while (sent || now.rip != before.rip || now.rsp != before.rsp);
    CHECK(!ptrace(PTRACE_SETREGS, pid, NULL, &before));
    return (long long)now.rax;
}

/* attaches to the daemon's first thread, which waits for signals */
static int attached(int pid) {
    int status;
    return CHECK(!ptrace(PTRACE_ATTACH, pid, NULL, NULL)) &&
           CHECK(waitpid(pid, &status, __WALL) == pid && WIFSTOPPED(status));
}

/* opens a file as the daemon; returns the kernel's result */
static long long opened(int pid, const char *path, long flags) {
    struct user_regs_struct now;
    if (ptrace(PTRACE_GETREGS, pid, NULL, &now)) return -1;
    unsigned long long place = now.rsp - 65536;
    struct iovec from = {(void *)path, strlen(path) + 1}, to = {(void *)place, from.iov_len};
    if (!CHECK(process_vm_writev(pid, &from, 1, &to, 1, 0) == (ssize_t)from.iov_len)) return -1;
    return injected(pid, SYS_openat,
                    (const long long[6]){AT_FDCWD, (long long)place, flags, 0600, 0, 0});
}

TEST(a_call_that_is_not_listed_fails_and_is_told) {
    OWN(test_server, drop) *server = sandboxed();
    struct test_reply reply;
    if (!server) return;
    int pid = test_server_pid(server);
    if (attached(pid)) {
        const long long none[6] = {0};
        CHECK_INT(injected(pid, SYS_sethostname, none), -ENOSYS);
        CHECK_INT(injected(pid, SYS_getpid, none), pid);
        /* memory to be written and executed, a program, and a socket that reads every packet */
        const long long page[6] = {
            0, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0};
        CHECK_INT(injected(pid, SYS_mmap, page), -ENOSYS);
        CHECK_INT(injected(pid, SYS_socket, (const long long[6]){AF_PACKET, SOCK_RAW}), -ENOSYS);
        ptrace(PTRACE_DETACH, pid, NULL, NULL);
    }
    CHECK_INT(test_request(server, &reply, "GET", "/healthz", "", NULL), 200);
    test_reply_clear(&reply);
    char line[96];
    snprintf(line, sizeof line, "sandbox: refused the system call %04d,", SYS_sethostname);
    CHECK_SAYING(strstr(test_server_log(server), line) != NULL, "%s", test_server_log(server));
}

TEST(a_call_that_only_an_intruder_makes_ends_the_process) {
    static const long calls[] = {SYS_execve, SYS_ptrace, SYS_setuid};
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        OWN(test_server, drop) *server = sandboxed();
        struct user_regs_struct before;
        if (!server) return;
        int pid = test_server_pid(server);
        if (attached(pid) && prepared(pid, calls[i], (const long long[6]){0}, &before)) {
            CHECK(!ptrace(PTRACE_DETACH, pid, NULL, NULL));
            int status = test_server_wait(server);
            CHECK_SAYING(status == 128 + SIGSYS, "call %ld: status %d", calls[i], status);
        }
    }
}

TEST(files_that_no_option_names_stay_shut) {
    char own[PATH], made[PATH + 16];
    OWN(test_server, stop) *server = sandboxed();
    if (!server) return;
    int pid = test_server_pid(server);
    ssize_t bytes = readlink("/proc/self/exe", own, sizeof own - 1);
    own[bytes > 0 ? bytes : 0] = 0;
    snprintf(made, sizeof made, "%s.sandbox", own);
    if (attached(pid)) {
        CHECK_INT(opened(pid, own, O_RDONLY), -EACCES);
        CHECK_INT(opened(pid, made, O_WRONLY | O_CREAT), -EACCES);
        CHECK_INT(opened(pid, "/etc/passwd", O_RDWR), -EACCES);
        CHECK(opened(pid, "/etc/passwd", O_RDONLY) > 0);
        ptrace(PTRACE_DETACH, pid, NULL, NULL);
    }
    CHECK(access(made, F_OK) != 0);
}

#endif

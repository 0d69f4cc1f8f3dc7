#include "server/sandbox/sandbox_seccomp.h"

#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <ucontext.h>
#include <unistd.h>

#include <seccomp.h>

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
#define CALLS_SANITIZED 1
#elif defined __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define CALLS_SANITIZED 1
#endif
#endif
#ifndef CALLS_SANITIZED
#define CALLS_SANITIZED 0
#endif

/* Calls of the C library for threads, memory and files, of libmicrohttpd, SQLite, libpq with name
 * resolution, and the server's own. Names that a processor does not have are skipped. */
static const char *const calls_listed[] = {
    /* memory; mmap and mprotect have conditions */
    "brk", "madvise", "mincore", "mlock", "mremap", "msync", "munlock", "munmap",
    /* threads, time, signals to itself; clone has a condition */
    "clock_getres", "clock_gettime", "clock_nanosleep", "exit", "exit_group", "futex",
    "futex_waitv", "get_robust_list", "getcpu", "gettid", "gettimeofday", "membarrier", "nanosleep",
    "restart_syscall", "rseq", "rt_sigaction", "rt_sigpending", "rt_sigprocmask", "rt_sigreturn",
    "rt_sigsuspend", "rt_sigtimedwait", "sched_getaffinity", "sched_getparam", "sched_getscheduler",
    "sched_setaffinity", "sched_yield", "set_robust_list", "set_tid_address", "sigaltstack",
    "tgkill", "time", "times",
    /* queries about the process and the machine */
    "getegid", "geteuid", "getgid", "getgroups", "getpgrp", "getpid", "getppid", "getpriority",
    "getrandom", "getresgid", "getresuid", "getrlimit", "getrusage", "getuid", "prlimit64",
    "setrlimit", "sysinfo", "umask", "uname",
    /* files */
    "access", "chmod", "close", "close_range", "dup", "dup2", "dup3", "faccessat", "faccessat2",
    "fadvise64", "fallocate", "fchmod", "fchmodat", "fchown", "fcntl", "fdatasync", "flock",
    "fstat", "fstatfs", "fsync", "ftruncate", "getcwd", "getdents64", "inotify_add_watch",
    "inotify_init1", "inotify_rm_watch", "ioctl", "lseek", "lstat", "mkdir", "mkdirat",
    "newfstatat", "open", "openat", "pread64", "preadv", "preadv2", "pwrite64", "pwritev",
    "pwritev2", "read", "readlink", "readlinkat", "readv", "rename", "renameat", "renameat2",
    "rmdir", "sendfile", "stat", "statfs", "statx", "unlink", "unlinkat", "utimensat", "write",
    "writev",
    /* sockets; socket has a condition. Name resolution binds a netlink socket. */
    "accept", "accept4", "bind", "connect", "epoll_create1", "epoll_ctl", "epoll_pwait",
    "epoll_pwait2", "epoll_wait", "eventfd2", "getpeername", "getsockname", "getsockopt", "listen",
    "pipe2", "poll", "ppoll", "pselect6", "recvfrom", "recvmmsg", "recvmsg", "select", "sendmmsg",
    "sendmsg", "sendto", "setsockopt", "shutdown", "socketpair", "splice"};

/* Calls that only an attacker would make: to run another program, to reach another process's
 * memory, to become another user, to use the kernel's own facilities. */
static const char *const calls_deadly[] = {"add_key",
                                           "bpf",
                                           "chroot",
                                           "delete_module",
                                           "execve",
                                           "execveat",
                                           "finit_module",
                                           "fork",
                                           "init_module",
                                           "io_uring_setup",
                                           "kexec_file_load",
                                           "kexec_load",
                                           "keyctl",
                                           "mount",
                                           "open_by_handle_at",
                                           "open_tree",
                                           "perf_event_open",
                                           "pidfd_getfd",
                                           "pivot_root",
                                           "process_vm_readv",
                                           "process_vm_writev",
                                           "ptrace",
                                           "reboot",
                                           "request_key",
                                           "setfsgid",
                                           "setfsuid",
                                           "setgid",
                                           "setgroups",
                                           "setns",
                                           "setregid",
                                           "setresgid",
                                           "setresuid",
                                           "setreuid",
                                           "setuid",
                                           "swapon",
                                           "umount2",
                                           "unshare",
                                           "userfaultfd",
                                           "vfork"};

static const int calls_families[] = {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK};

/* prctl options that are allowed: the thread's name */
static const int calls_settings[] = {PR_SET_NAME, PR_GET_NAME};

enum { CALLS_TOLD = 16, CALLS_THREAD = 0x00010000 /* CLONE_THREAD */ };

/* signal handler: logs a refused call, and makes it fail with ENOSYS */
static void calls_refused(int number, siginfo_t *why, void *where) {
    static atomic_int told;
    int before = errno, was = atomic_fetch_add(&told, 1);
    char text[] = "sandbox: refused the system call 0000, which the server does not need\n";
    char *digit = strchr(text, '0');
    (void)number;
    for (int call = why->si_syscall, i = 3; i >= 0; i--, call /= 10) digit[i] += (char)(call % 10);
    if (was >= CALLS_TOLD)
        atomic_store(&told, CALLS_TOLD);
    else if (write(STDERR_FILENO, text, sizeof text - 1) < 0)
        errno = before;
    ucontext_t *thread = where;
#if defined __x86_64__
    thread->uc_mcontext.gregs[REG_RAX] = -ENOSYS;
#elif defined __aarch64__
    thread->uc_mcontext.regs[0] = (unsigned long long)-ENOSYS;
#else
    (void)thread;
#endif
    errno = before;
}

/* adds a rule for each name that this processor has; returns 0, or the error of libseccomp */
static int calls_names(scmp_filter_ctx filter, const char *const name[], size_t count,
                       uint32_t action) {
    for (size_t i = 0; i < count; i++) {
        int call = seccomp_syscall_resolve_name(name[i]), failed = 0;
        if (call >= 0) failed = seccomp_rule_add(filter, action, call, 0);
        if (failed) return failed;
    }
    return 0;
}

/* adds the calls that are allowed only with certain arguments */
static int calls_conditions(scmp_filter_ctx filter) {
    int failed = 0;
    /* no page is writable and executable; name-resolution libraries are mapped readable and
     * executable */
    const struct scmp_arg_cmp run_only =
                                  SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_WRITE | PROT_EXEC, PROT_EXEC),
                              no_run = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0),
                              thread = SCMP_A0(SCMP_CMP_MASKED_EQ, CALLS_THREAD, CALLS_THREAD);
    failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 1, run_only);
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 1, no_run);
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 1, no_run);
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(clone), 1, thread);
    /* filters cannot read the arguments of clone3; with ENOSYS the C library uses clone */
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
    for (size_t i = 0; !failed && i < sizeof calls_families / sizeof *calls_families; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(socket), 1,
                                  SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)calls_families[i], 0));
    for (size_t i = 0; !failed && i < sizeof calls_settings / sizeof *calls_settings; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(prctl), 1,
                                  SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)calls_settings[i], 0));
    return failed;
}

/* returns 0, or the error of libseccomp, negative */
static int calls_load(scmp_filter_ctx filter) {
    int failed = seccomp_attr_set(filter, SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
    /* searches a binary tree in place of comparing call by call */
    if (!failed) failed = seccomp_attr_set(filter, SCMP_FLTATR_CTL_OPTIMIZE, 2);
    if (!failed)
        failed = calls_names(filter, calls_listed, sizeof calls_listed / sizeof *calls_listed,
                             SCMP_ACT_ALLOW);
    if (!failed)
        failed = calls_names(filter, calls_deadly, sizeof calls_deadly / sizeof *calls_deadly,
                             SCMP_ACT_KILL_PROCESS);
    if (!failed) failed = calls_conditions(filter);
    return failed ? failed : seccomp_load(filter);
}

enum pend_status srv_sandbox_seccomp(struct pend_error *error) {
    if (CALLS_SANITIZED)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "this build has a sanitizer, which needs other system calls");
    struct sigaction action = {.sa_sigaction = calls_refused, .sa_flags = SA_SIGINFO};
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_TRAP);
    int failed = filter ? 0 : -ENOMEM;
    if (!failed && sigaction(SIGSYS, &action, NULL)) failed = -errno;
    if (!failed) failed = calls_load(filter);
    if (filter) seccomp_release(filter);
    if (!failed) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "cannot install the system-call filter (seccomp): %s", strerror(-failed));
}

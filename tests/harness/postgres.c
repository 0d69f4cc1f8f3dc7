#include "tests/harness/postgres.h"

#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <grp.h>
#include <pwd.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { PATH_BYTES = 300, READY_MS = 30000 };

struct test_postgres {
    pid_t pid;
    char directory[64], bin[PATH_BYTES - 100], url[PATH_BYTES];
};

/* the programs of the newest installed version */
static int postgres_find(struct test_postgres *postgres) {
    glob_t found;
    int there = !glob("/usr/lib/postgresql/*/bin/initdb", 0, NULL, &found) && found.gl_pathc > 0;
    if (there)
        snprintf(postgres->bin, sizeof postgres->bin, "%.*s",
                 (int)(strlen(found.gl_pathv[found.gl_pathc - 1]) - 7),
                 found.gl_pathv[found.gl_pathc - 1]);
    globfree(&found);
    return there;
}

/* PostgreSQL does not run as root; with root's rights it becomes the user that Debian created for
 * it */
static void postgres_drop(void) {
    const struct passwd *user = geteuid() ? NULL : getpwnam("postgres");
    if (user && (setgroups(0, NULL) || setgid(user->pw_gid) || setuid(user->pw_uid))) _exit(126);
}

/* starts a program of PostgreSQL, or one whose path is given, with its output in the directory's
 * log; PostgreSQL's programs find each other by the path in argv[0] */
static pid_t postgres_spawn(const struct test_postgres *postgres, const char *program,
                            char *argv[]) {
    char path[PATH_BYTES], log[PATH_BYTES];
    snprintf(path, sizeof path, "%s%s%s", program[0] == '/' ? "" : postgres->bin,
             program[0] == '/' ? "" : "/", program);
    snprintf(log, sizeof log, "%s/log", postgres->directory);
    pid_t pid = fork();
    if (pid) return pid;
    postgres_drop();
    /* it must not outlive a test program that was killed: fast shutdown */
    prctl(PR_SET_PDEATHSIG, SIGINT);
    int out = open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (out < 0 || dup2(out, 1) < 0 || dup2(out, 2) < 0 || chdir(postgres->directory)) _exit(126);
    argv[0] = path;
    execv(path, argv);
    _exit(127);
}

static int postgres_end(pid_t pid) {
    int status = -1;
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

static int postgres_ready(const struct test_postgres *postgres) {
    for (int ms = 0; ms < READY_MS; ms += 20) {
        char *argv[] = {"pg_isready", "-q", "-h", (char *)postgres->directory, NULL};
        if (!postgres_end(postgres_spawn(postgres, "pg_isready", argv))) return 1;
        if (waitpid(postgres->pid, NULL, WNOHANG) != 0) return 0;
        nanosleep(&(struct timespec){0, 20000000}, NULL);
    }
    return 0;
}

static int postgres_serve(struct test_postgres *postgres) {
    char *argv[] = {"postgres", "-D", "data", "-k", postgres->directory, "-c",
                    "listen_addresses=", "-c", "max_connections=40", "-c", "shared_buffers=16MB",
                    "-c", "logging_collector=off",
                    /* processes are killed here, never the system: written data survive without
                     * waiting for disks */
                    "-c", "fsync=off", NULL};
    postgres->pid = postgres_spawn(postgres, "postgres", argv);
    return postgres->pid > 0 && postgres_ready(postgres);
}

/* The directory with a new database from which all of this program's are copied, because a copy is
 * faster than a new one; and the process that removes it. */
static char postgres_first[64];
static pid_t postgres_owner;

static void postgres_remove(const char *directory) {
    char *argv[] = {"rm", "-rf", (char *)directory, NULL};
    pid_t pid = fork();
    if (!pid) {
        execv("/bin/rm", argv);
        _exit(127);
    }
    postgres_end(pid);
}

static void postgres_forget(void) {
    if (postgres_owner == getpid()) postgres_remove(postgres_first);
}

/* a directory under /tmp that PostgreSQL may write in */
static int postgres_directory(char directory[64]) {
    const struct passwd *user = geteuid() ? NULL : getpwnam("postgres");
    snprintf(directory, 64, "/tmp/pendulumd-test-XXXXXX");
    /* a daemon of root has no capabilities: it needs the permissions of others to find the
     * socket */
    return mkdtemp(directory) && !chmod(directory, 0711) &&
           (!user || !chown(directory, user->pw_uid, user->pw_gid));
}

/* creates the first database if there is none yet */
static int postgres_make(const struct test_postgres *postgres) {
    char data[80];
    char *argv[] = {"initdb", "-D", data,   "-U",         "pendulumd", "-A",
                    "trust",  "-E", "UTF8", "--locale=C", "-N",        NULL};
    if (postgres_first[0]) return 1;
    if (!postgres_directory(postgres_first)) return 0;
    postgres_owner = getpid();
    atexit(postgres_forget);
    snprintf(data, sizeof data, "%s/data", postgres_first);
    if (!postgres_end(postgres_spawn(postgres, "initdb", argv))) return 1;
    postgres_remove(postgres_first);
    postgres_first[0] = postgres_owner = 0;
    return 0;
}

static int postgres_copy(const struct test_postgres *postgres) {
    char data[80];
    char *argv[] = {"cp", "-a", data, "data", NULL};
    snprintf(data, sizeof data, "%s/data", postgres_first);
    return !postgres_end(postgres_spawn(postgres, "/bin/cp", argv));
}

struct test_postgres *test_postgres_start(void) {
    struct test_postgres *postgres = calloc(1, sizeof *postgres);
    if (!postgres) return NULL;
    if (!postgres_find(postgres) || !postgres_directory(postgres->directory)) {
        free(postgres);
        return NULL;
    }
    int good = postgres_make(postgres) && postgres_copy(postgres) && postgres_serve(postgres);
    snprintf(postgres->url, sizeof postgres->url, "postgresql://pendulumd@/postgres?host=%s",
             postgres->directory);
    if (!good) test_postgres_stop(&postgres);
    return postgres;
}

const char *test_postgres_url(const struct test_postgres *postgres) { return postgres->url; }

void test_postgres_halt(struct test_postgres *postgres, int number) {
    kill(postgres->pid, number);
    postgres_end(postgres->pid);
    postgres->pid = 0;
}

int test_postgres_resume(struct test_postgres *postgres) {
    /* after a crash the children end by themselves, and the new server waits for none of them */
    for (int i = 0; i < 250; i++) {
        if (postgres_serve(postgres)) return 1;
        postgres_end(postgres->pid);
        nanosleep(&(struct timespec){0, 20000000}, NULL);
    }
    return 0;
}

int test_postgres_restart(struct test_postgres *postgres, int number) {
    test_postgres_halt(postgres, number);
    return test_postgres_resume(postgres);
}

void test_postgres_freeze(const struct test_postgres *postgres, int frozen) {
    char path[64];
    int child, number = frozen ? SIGSTOP : SIGCONT;
    /* it first, so that it creates no more children than are read */
    kill(postgres->pid, number);
    snprintf(path, sizeof path, "/proc/%d/task/%d/children", (int)postgres->pid,
             (int)postgres->pid);
    FILE *children = fopen(path, "r");
    while (children && fscanf(children, "%d", &child) == 1) kill(child, number);
    if (children) fclose(children);
}

int test_postgres_run(const struct test_postgres *postgres, const char *command) {
    char *argv[] = {"psql", "-q", "-X", "-d", (char *)postgres->url, "-c", (char *)command, NULL};
    return !postgres_end(postgres_spawn(postgres, "psql", argv));
}

void test_postgres_stop(struct test_postgres **postgres) {
    struct test_postgres *gone = *postgres;
    *postgres = NULL;
    if (!gone) return;
    if (gone->pid > 0) {
        kill(gone->pid, SIGINT);
        postgres_end(gone->pid);
    }
    postgres_remove(gone->directory);
    free(gone);
}

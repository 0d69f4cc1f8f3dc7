/* Disk failures, by the linker's --wrap of the calls with which SQLite writes: pwrite, fsync,
 * fdatasync and ftruncate.
 * Leaves to others: deciding which call fails (the test).
 * Invariant: with failures off every call goes straight through; while they are on, nothing waits
 * for a disk. */
#include <errno.h>
#include <stdatomic.h>
#include <sys/types.h>

#include "tests/harness/test.h"

ssize_t __real_pwrite64(int fd, const void *data, size_t bytes, off_t at);
int __real_fsync(int fd);
int __real_fdatasync(int fd);
int __real_ftruncate64(int fd, off_t bytes);
ssize_t __wrap_pwrite64(int fd, const void *data, size_t bytes, off_t at);
int __wrap_fsync(int fd);
int __wrap_fdatasync(int fd);
int __wrap_ftruncate64(int fd, off_t bytes);

static atomic_long disk_count, disk_fail_at;
static atomic_int disk_for_good, disk_error;

void test_disk_fail(long count, int for_good, int error) {
    disk_for_good = for_good;
    disk_error = error;
    disk_count = 0;
    disk_fail_at = count;
}

long test_disk_faults_off(void) {
    disk_fail_at = 0;
    return disk_count;
}

static int disk_fails(void) {
    long fail_at = disk_fail_at;
    if (!fail_at) return 0;
    long number = ++disk_count;
    if (number != fail_at && (!disk_for_good || number < fail_at)) return 0;
    errno = disk_error;
    return 1;
}

ssize_t __wrap_pwrite64(int fd, const void *data, size_t bytes, off_t at) {
    return disk_fails() ? -1 : __real_pwrite64(fd, data, bytes, at);
}
int __wrap_fsync(int fd) { return disk_fails() ? -1 : disk_fail_at ? 0 : __real_fsync(fd); }
int __wrap_fdatasync(int fd) { return disk_fails() ? -1 : disk_fail_at ? 0 : __real_fdatasync(fd); }
int __wrap_ftruncate64(int fd, off_t bytes) {
    return disk_fails() ? -1 : __real_ftruncate64(fd, bytes);
}

#include "server/store/store_sqlite_disk.h"

#include <assert.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

enum {
    LOG_PAGES = 1000,      /* pages of the log that start a checkpoint */
    FILE_STEP = 256 << 10, /* bytes by which the file grows */
    /* disk space that results must leave free, so that jobs can end on a full disk; the log may
     * use half of it */
    DISK_SPARE = 4 << 20,
    /* disk space that the file must leave free however it grows, because nothing can be written
     * without the log */
    DISK_LOG = 1 << 20,
    CHECKPOINT_LOCK = 1 /* WAL_CKPT_LOCK of SQLite's file format, in the shared memory */
};

static int disk_hook(void *context, sqlite3 *db, const char *name, int pages) {
    struct srv_sqlite_disk *disk = context;
    (void)db, (void)name;
    disk->log_pages = pages;
    return SQLITE_OK;
}

static int disk_pragma(sqlite3_stmt *pragma, sqlite3_int64 *value) {
    int code = sqlite3_step(pragma);
    *value = code == SQLITE_ROW ? sqlite3_column_int64(pragma, 0) : 0;
    int ended = sqlite3_reset(pragma);
    return code == SQLITE_ROW ? ended : code;
}

int srv_sqlite_disk_open(struct srv_sqlite_disk *disk, sqlite3 *db) {
    sqlite3_stmt *size = NULL;
    int step = FILE_STEP;
    *disk = (struct srv_sqlite_disk){.db = db, .log_most = LOG_PAGES};
    sqlite3_wal_hook(db, disk_hook, disk);
    int code = sqlite3_file_control(db, "main", SQLITE_FCNTL_CHUNK_SIZE, &step);
    if (code == SQLITE_OK) code = sqlite3_prepare_v2(db, "PRAGMA page_size", -1, &size, NULL);
    if (code == SQLITE_OK) code = disk_pragma(size, &disk->page_bytes);
    sqlite3_finalize(size);
    if (code == SQLITE_OK)
        code = sqlite3_prepare_v2(db, "PRAGMA page_count", -1, &disk->pages, NULL);
    if (code == SQLITE_OK)
        code = sqlite3_prepare_v2(db, "PRAGMA freelist_count", -1, &disk->unused, NULL);
    return code;
}

void srv_sqlite_disk_begin(struct srv_sqlite_disk *disk, int full) {
    assert(sqlite3_get_autocommit(disk->db) && disk->page_bytes > 0);
    disk->promised = 0;
    disk->changes = sqlite3_total_changes(disk->db);
    if (full) sqlite3_wal_checkpoint_v2(disk->db, NULL, SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
}

static const char *disk_file(const struct srv_sqlite_disk *disk) {
    return sqlite3_db_filename(disk->db, "main");
}

/* free bytes of the disk; a huge number if unknown */
static double disk_left(const struct srv_sqlite_disk *disk) {
    struct statvfs state;
    return statvfs(disk_file(disk), &state) ? 1e18
                                            : (double)state.f_bavail * (double)state.f_frsize;
}

/* the bytes of all pages including this transaction's, and how many of them the file lacks */
static int disk_measure(const struct srv_sqlite_disk *disk, sqlite3_int64 *bytes,
                        sqlite3_int64 *shorter) {
    struct stat file;
    int code = disk_pragma(disk->pages, bytes);
    *bytes *= disk->page_bytes;
    *shorter = 0;
    if (code != SQLITE_OK) return code;
    if (stat(disk_file(disk), &file)) return SQLITE_IOERR;
    if (file.st_size < *bytes) *shorter = *bytes - file.st_size;
    return SQLITE_OK;
}

int srv_sqlite_disk_room(struct srv_sqlite_disk *disk, size_t bytes) {
    sqlite3_int64 whole, shorter, unused;
    double left = disk_left(disk);
    disk->promised += (double)bytes;
    double log = DISK_SPARE / 2 + disk->promised, file = DISK_SPARE / 2 + (double)bytes;
    if (left >= 2 * log) return 1;
    if (disk_measure(disk, &whole, &shorter) != SQLITE_OK ||
        disk_pragma(disk->unused, &unused) != SQLITE_OK)
        return 0;
    /* unused pages can be used too */
    file -= (double)(unused * disk->page_bytes);
    return left >= log + (double)shorter + (file > 0 ? file : 0);
}

/* Extends the file. SQLite does so by writing single bytes into blocks that it believes to be new,
 * which would corrupt pages that a checkpoint of another process writes there at the same time. The
 * lock of checkpoints is therefore held. A checkpoint in progress extends the file itself, so
 * nothing is done then. */
static int disk_lengthen(struct srv_sqlite_disk *disk, sqlite3_int64 bytes) {
    sqlite3_file *file = NULL;
    int code = sqlite3_file_control(disk->db, "main", SQLITE_FCNTL_FILE_POINTER, &file);
    if (code != SQLITE_OK) return code;
    if (file->pMethods->iVersion < 2) return SQLITE_OK;
    if (file->pMethods->xShmLock(file, CHECKPOINT_LOCK, 1,
                                 SQLITE_SHM_LOCK | SQLITE_SHM_EXCLUSIVE) != SQLITE_OK)
        return SQLITE_OK;
    code = sqlite3_file_control(disk->db, "main", SQLITE_FCNTL_SIZE_HINT, &bytes);
    file->pMethods->xShmLock(file, CHECKPOINT_LOCK, 1, SQLITE_SHM_UNLOCK | SQLITE_SHM_EXCLUSIVE);
    return code;
}

int srv_sqlite_disk_take(struct srv_sqlite_disk *disk) {
    sqlite3_int64 bytes, shorter;
    int code = disk_measure(disk, &bytes, &shorter);
    if (code != SQLITE_OK || !shorter) return code;
    if (disk_left(disk) >= (double)shorter + FILE_STEP + DISK_LOG &&
        disk_lengthen(disk, bytes) == SQLITE_OK)
        return SQLITE_OK;
    /* readers are not refused, even if another process left the file too short */
    return sqlite3_total_changes(disk->db) == disk->changes ? SQLITE_OK : SQLITE_FULL;
}

void srv_sqlite_disk_committed(struct srv_sqlite_disk *disk) {
    assert(sqlite3_get_autocommit(disk->db) && disk->log_most >= LOG_PAGES);
    int pages = disk->log_pages;
    disk->log_pages = 0;
    if (pages && pages < LOG_PAGES) disk->log_most = LOG_PAGES;
    if (pages < disk->log_most) return;
    int code = sqlite3_wal_checkpoint_v2(disk->db, NULL, SQLITE_CHECKPOINT_RESTART, NULL, NULL);
    disk->log_most = code == SQLITE_OK ? LOG_PAGES : pages + LOG_PAGES;
}

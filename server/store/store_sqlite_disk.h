/* What an SQLite database takes of its disk: the file, and the log of writes before it (WAL).
 * Leaves to others: statements and transactions (store_sqlite).
 * Invariant: what is committed has its place in the file as well, so that carrying the log over
 * takes no room and a full disk shows before the commit; only who may write carries over, as
 * SQLite then cuts the file to the pages it knows of. */
#ifndef SRV_STORE_SQLITE_DISK_H
#define SRV_STORE_SQLITE_DISK_H

#include <sqlite3.h>
#include <stddef.h>

/* A connection's view of the disk; begins as {0}. */
struct srv_sqlite_disk {
    sqlite3 *db;
    sqlite3_stmt *pages, *unused; /* in the transaction: all there are, those without content */
    sqlite3_int64 page_bytes;
    int changes;     /* rows changed before this transaction */
    double promised; /* bytes that were given room in this transaction */
    int log_pages;   /* in the log, at this commit; 0 = it wrote nothing */
    int log_most;    /* from so many on it is carried over */
};

/** Begins with a connection that is set to WAL; returns a result code of SQLite. Nothing else may
 * set its WAL hook. */
int srv_sqlite_disk_open(struct srv_sqlite_disk *disk, sqlite3 *db);

/** Frees the statements of a disk, before its connection is closed. */
void srv_sqlite_disk_close(struct srv_sqlite_disk *disk);

/** Before a transaction begins; `full`: the disk was in the last one, and what the log of writes
 * has is given back. */
void srv_sqlite_disk_begin(struct srv_sqlite_disk *disk, int full);

/** In a transaction that writes: whether so many bytes may be, on top of those asked for before,
 * and small things after. */
int srv_sqlite_disk_room(struct srv_sqlite_disk *disk, size_t bytes);

/**
 * Before the commit of a transaction that may write: takes what all pages need of the disk. Costs a
 * look at the file.
 *
 * Returns a result code of SQLite; SQLITE_FULL: it has changed rows, which do not fit, and is to be
 * rolled back.
 */
int srv_sqlite_disk_take(struct srv_sqlite_disk *disk);

/**
 * After a commit: carries a long log over to the file, and lets it begin anew. Who writes meanwhile
 * waits; a reader that does not end (a backup) is waited for as the busy handler says, and passed
 * over until the log has grown as much again.
 */
void srv_sqlite_disk_committed(struct srv_sqlite_disk *disk);

#endif

/* Disk space of an SQLite database: the file, and the write-ahead log (WAL).
 * Leaves to others: statements and transactions (store_sqlite).
 * Invariant: the file has space for everything that is committed, so that a checkpoint needs no
 * space and a full disk shows before the commit; only a writer runs checkpoints, because SQLite
 * then truncates the file to the pages that it knows. */
#pragma once

#include <sqlite3.h>
#include <stddef.h>

/* A connection's view of the disk; initialized with {0}. */
struct srv_sqlite_disk {
    sqlite3 *db;
    sqlite3_stmt *pages, *unused; /* count all pages and the unused ones, within the transaction */
    sqlite3_int64 page_bytes;
    int changes;     /* rows changed before this transaction */
    double promised; /* bytes reserved in this transaction */
    int log_pages;   /* pages in the log at this commit; 0 = nothing written */
    int log_most;    /* a checkpoint runs from this many pages on */
};

/** Initializes the view of a connection in WAL mode; returns an SQLite result code. Nothing else
 * may set the WAL hook. */
int srv_sqlite_disk_open(struct srv_sqlite_disk *disk, sqlite3 *db);

/** Call before a transaction begins. full: the disk was full in the last one, so the log is
 * truncated. */
void srv_sqlite_disk_begin(struct srv_sqlite_disk *disk, int full);

/** In a writing transaction: returns non-zero if there is space for this many more bytes, with a
 * reserve for small writes. */
int srv_sqlite_disk_room(struct srv_sqlite_disk *disk, size_t bytes);

/**
 * Call before the commit of a writing transaction: reserves the disk space of all pages. Costs one
 * stat.
 *
 * Returns an SQLite result code; SQLITE_FULL: the changes do not fit, roll back.
 */
int srv_sqlite_disk_take(struct srv_sqlite_disk *disk);

/** Call after a commit: runs a checkpoint if the log is long. Other writers wait for it. It waits
 * for readers only as long as the busy handler allows; after that it is retried when the log has
 * doubled. */
void srv_sqlite_disk_committed(struct srv_sqlite_disk *disk);

"""Stores of the drill's own: an SQLite file, or a real PostgreSQL, which can be looked into, restarted and filled up.

Leaves to others: the daemons on them (house.py). Invariant: a place is gone when its block is; a database listens on a
Unix socket in its own directory and nowhere else.
"""
import contextlib
import ctypes
import glob
import os
import pathlib
import pwd
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time

# every time that a part is marked as done, whoever does it, leaves a row that commits or vanishes with it; in SQLite the
# daemon runs no trigger that it finds in a store, so there a part that was counted twice shows in its job's sum
WATCH = "CREATE TABLE drill_kept (job TEXT, number BIGINT)"
WATCH_SQLITE = "CREATE VIEW drill_kept AS SELECT job, number FROM parts WHERE state = 2"
WATCH_POSTGRES = ("CREATE FUNCTION drill_keep() RETURNS trigger LANGUAGE plpgsql AS "
                  "'BEGIN INSERT INTO drill_kept VALUES (NEW.job, NEW.number); RETURN NEW; END'",
                  "CREATE TRIGGER drill_keep AFTER UPDATE OF state ON parts FOR EACH ROW WHEN (NEW.state = 2) "
                  "EXECUTE FUNCTION drill_keep()")


def die_with_parent(number):
    """What a child does first: it is not to outlive a drill that was killed."""
    return lambda: ctypes.CDLL(None).prctl(1, number)


class Sqlite:
    name = "sqlite"

    def __init__(self, directory):
        self.directory = str(directory)
        self.use(directory)

    def use(self, directory):
        """Another directory, before anything is there."""
        self.file = pathlib.Path(directory, "store.db")
        self.url = f"sqlite:{self.file}"

    def rows(self, command):
        with contextlib.closing(sqlite3.connect(self.file, timeout=300)) as base:
            found = base.execute(command).fetchall()
            base.commit()
            return found

    def watch(self):
        self.rows(WATCH_SQLITE)

    def close(self):
        pass


def postgres_programs():
    """The directory of the newest installed PostgreSQL, or None."""
    return max((os.path.dirname(path) for path in glob.glob("/usr/lib/postgresql/*/bin/initdb")), default=None)


class Postgres:
    name = "postgres"

    def __init__(self, directory, buffers="16MB", connections=100):
        self.directory, self.programs = str(directory), postgres_programs()
        self.settings = ("-c", f"shared_buffers={buffers}", "-c", f"max_connections={connections}")
        # it does not run as root; with root's rights it gets the user that Debian made for it
        owner = pwd.getpwnam("postgres") if not os.geteuid() else None
        self.user = {"user": owner.pw_uid, "group": owner.pw_gid, "extra_groups": []} if owner else {}
        if owner:
            os.chown(self.directory, owner.pw_uid, owner.pw_gid)
            os.chmod(self.directory, 0o711)  # a daemon of root has no capabilities: it finds the socket as everybody does
        self.url = f"postgresql://pendulumd@/postgres?host={self.directory}"
        self.log = open(pathlib.Path(directory, "log"), "ab")
        self.run("initdb", "-D", "data", "-U", "pendulumd", "-A", "trust", "-E", "UTF8", "--locale=C", "-N")
        self.start()

    def spawn(self, program, *words, **more):
        return subprocess.Popen([os.path.join(self.programs, program), *words], cwd=self.directory, stdin=subprocess.DEVNULL,
                                stderr=self.log, preexec_fn=die_with_parent(signal.SIGINT), **{"stdout": self.log} | self.user | more)

    def run(self, program, *words):
        if self.spawn(program, *words).wait():
            raise RuntimeError(f"{program} {' '.join(words)}: see {self.log.name}")

    def ready(self):
        return not self.spawn("pg_isready", "-q", "-h", self.directory).wait()

    def start(self):
        end = time.monotonic() + 300
        while time.monotonic() < end:
            self.server = self.spawn("postgres", "-D", "data", "-k", self.directory, "-c", "listen_addresses=", *self.settings)
            while self.server.poll() is None and time.monotonic() < end:
                if self.ready():
                    return
                time.sleep(0.02)
            time.sleep(0.02)  # after a crash the old one's children may not have gone yet
        raise RuntimeError(f"PostgreSQL does not start: see {self.log.name}")

    def restart(self, number):
        """Ends it by a signal and starts it on the same data: SIGINT ends in order, SIGQUIT and SIGKILL do not."""
        self.server.send_signal(number)
        self.server.wait()
        self.start()

    @property
    def socket(self):
        return f"{self.directory}/.s.PGSQL.5432"

    def rows(self, command):
        words = ("-q", "-X", "-A", "-t", "-v", "ON_ERROR_STOP=1", "-d", self.url, "-c", command)
        for _ in range(2000):
            process = self.spawn("psql", *words, stdout=subprocess.PIPE, text=True)
            out, _ = process.communicate()
            if not process.returncode:
                return [[int(f) if f.lstrip("-").isdigit() else f for f in line.split("|")] for line in out.splitlines()]
            time.sleep(0.05)
        raise RuntimeError(f"{command}: see {self.log.name}")

    def watch(self):
        for command in (WATCH, *WATCH_POSTGRES):
            self.rows(command)

    def close(self):
        if self.server.poll() is None:
            self.server.send_signal(signal.SIGINT)
            self.server.wait()
        self.log.close()


@contextlib.contextmanager
def place(kind, keep=False, **more):
    directory = tempfile.mkdtemp(prefix="pendulumd-drill-")
    made = None
    try:
        made = (Sqlite if kind == "sqlite" else Postgres)(directory, **more)
        yield made
    finally:
        if made:
            made.close()
        if not keep:
            shutil.rmtree(directory, ignore_errors=True)


@contextlib.contextmanager
def small_disk(directory, size):
    """A file system of so many bytes; PermissionError where mounting is not allowed."""
    os.makedirs(directory)
    if os.geteuid() or subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", directory], stderr=subprocess.DEVNULL).returncode:
        raise PermissionError("a small file system can be mounted by root only")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", directory], check=False)

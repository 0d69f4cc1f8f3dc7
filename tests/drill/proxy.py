"""A TCP proxy between a daemon and its database whose lines can be frozen, cut and barred.

Leaves to others: when (faults.py). Invariant: a byte that is passed on is passed on once and in order.
"""
import contextlib
import selectors
import socket
import threading


class Proxy:
    """Listens on 127.0.0.1:port and passes on to a Unix socket."""

    def __init__(self, target):
        self.target, self.frozen, self.barred = target, False, False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.setblocking(False)
        self.port = self.listener.getsockname()[1]
        self.other, self.over, self.cutting = {}, False, False
        self.bell, self.rung = socket.socketpair()
        self.changed = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def tell(self, **what):
        """Sets frozen, barred, cutting or over, and waits until that holds."""
        self.changed.clear()
        for name, value in what.items():
            setattr(self, name, value)
        self.bell.send(b"!")
        self.changed.wait(10)

    def freeze(self):
        """Nothing passes, and nobody is told."""
        self.tell(frozen=True)

    def cut(self):
        """All lines end with a reset, and new ones are refused."""
        self.tell(cutting=True, barred=True)

    def mend(self):
        self.tell(frozen=False, barred=False)

    def close(self):
        self.tell(over=True)
        self.thread.join(10)

    # --- on the proxy's thread

    def drop(self, line):
        for end in (line, self.other.pop(line, None)):
            if end:
                self.other.pop(end, None)
                with contextlib.suppress(OSError):  # a reset, not an end
                    end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
                end.close()

    def accept(self):
        with contextlib.suppress(OSError):
            line, _ = self.listener.accept()
            beyond = socket.socket(socket.AF_UNIX)
            try:
                if self.barred:
                    raise OSError("barred")
                beyond.connect(self.target)
            except OSError:
                line.close()
                beyond.close()
                return
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.other[line], self.other[beyond] = beyond, line

    def pass_on(self, line):
        try:
            data = line.recv(1 << 16)
            if data:
                self.other[line].sendall(data)
                return
        except OSError:
            pass
        self.drop(line)

    def run(self):
        while not self.over:
            with selectors.DefaultSelector() as ready:
                for end in [self.rung] + ([] if self.frozen else [self.listener, *self.other]):
                    ready.register(end, selectors.EVENT_READ)
                events = [key.fileobj for key, _ in ready.select()]
            for end in events:
                if end is self.rung:
                    self.rung.recv(100)
                elif end is self.listener:
                    self.accept()
                elif end in self.other:
                    self.pass_on(end)
            if self.cutting:
                for line in list(self.other):
                    if line in self.other:
                        self.drop(line)
                self.cutting = False
            if self.rung in events:
                self.changed.set()
        for line in [*self.other, self.listener, self.bell, self.rung]:
            line.close()

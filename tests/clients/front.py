"""A front of a daemon that refuses or cuts exchanges as it is told: what clients have to bear.

Leaves to others: what is asked (the tests of the clients). Invariant: bytes are passed on once and in order, until a line is cut.
"""
import socket
import threading


PAGE = ("refuse", "404 Not Found", "Content-Type: text/html; charset=utf-8")  # of a server that is none of ours


class Front:
    """Listens on 127.0.0.1:port. Each new line takes the next of `moods`, or passes all on.

    moods  ("refuse", status line, further header lines) answers so; ("cut", N) ends the line after N bytes of the answer.
    heads  of all requests, in order, as far as the first packet of a line has them.
    """

    def __init__(self, target):
        self.target, self.moods, self.heads = target, [], []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                line, _ = self.listener.accept()
            except OSError:
                return
            mood = self.moods.pop(0) if self.moods else ("pass",)
            threading.Thread(target=self.serve, args=(line, *mood), daemon=True).start()

    def serve(self, line, mood, *what):
        with line:
            data = line.recv(1 << 16)
            self.heads.append(data.partition(b"\r\n\r\n")[0].decode())
            if mood == "refuse":
                self.read_whole(line, data)
                line.sendall(f"HTTP/1.1 {what[0]}\r\n{''.join(field + chr(13) + chr(10) for field in what[1:])}"
                             "Content-Length: 0\r\nConnection: close\r\n\r\n".encode())
                return
            with socket.create_connection(("127.0.0.1", self.target)) as beyond:
                threading.Thread(target=self.pump, args=(line, beyond, data), daemon=True).start()
                self.pump(beyond, line, b"", what[0] if mood == "cut" else -1)

    @staticmethod
    def read_whole(line, data):
        """The rest of a request: an answer before it would be lost in a reset."""
        head, _, body = data.partition(b"\r\n\r\n")
        sizes = [int(field.split(b":")[1]) for field in head.split(b"\r\n") if field.lower().startswith(b"content-length:")]
        missing = sum(sizes) - len(body)
        while missing > 0 and (piece := line.recv(1 << 16)):
            missing -= len(piece)

    @staticmethod
    def pump(source, sink, data, left=-1):
        """Passes bytes on, at most `left`, and then ends both lines."""
        try:
            while True:
                if 0 <= left <= len(data):
                    sink.sendall(data[:left])
                    break
                sink.sendall(data)
                left -= len(data) if left > 0 else 0
                data = source.recv(1 << 16)
                if not data:
                    break
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def close(self):
        self.listener.close()

"""A name server on loopback with changeable answers, like Docker's own when containers come and go.

Leaves to others: the client (nginx.py). Invariant: it answers every name from memory, and forwards nothing.
"""
import contextlib
import socket
import struct
import threading

A, TTL = 1, 1


def question_end(query):
    """Where the first question of a message ends."""
    at = 12
    while query[at]:
        at += 1 + query[at]
    return at + 5


def answer(query, addresses):
    """The reply to one question: an A record for each address, and none of any other type."""
    end = question_end(query)
    kind, = struct.unpack("!H", query[end - 4:end - 2])
    found = addresses if kind == A else []
    head = query[:2] + struct.pack("!HHHHH", 0x8180, 1, len(found), 0, 0)
    records = (struct.pack("!HHHIH", 0xC00C, A, 1, TTL, 4) + socket.inet_aton(address) for address in found)
    return head + query[12:end] + b"".join(records)


class Names:
    """Every name has `addresses`; `asked` counts the questions."""

    def __init__(self, *addresses):
        self.addresses, self.asked = list(addresses), 0
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        with contextlib.suppress(OSError):
            while True:
                query, client = self.socket.recvfrom(512)
                self.asked += 1
                self.socket.sendto(answer(query, list(self.addresses)), client)

    def close(self):
        self.socket.close()

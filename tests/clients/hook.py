"""A receiver of webhooks behind TLS, and the program of the project's README that tells genuine messages from others.

Leaves to others: submitting jobs with its url (the tests of the clients). Invariant: what is checked is run as the README has it.
"""
import http.server
import pathlib
import re
import ssl
import subprocess
import threading
import time

from rule import TOP, check
from servers import tool


class Hook:
    """Listens on https://localhost:PORT, with a certificate that is its own authority; `options` are those of a daemon that trusts it."""

    def __init__(self, home):
        self.seen, key, secret = {}, home / "hook.key", home / "hook.secret"
        self.authority = home / "hook.pem"
        subprocess.run([tool("openssl"), "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", self.authority, "-days", "2", "-subj",
                        "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"], check=True, capture_output=True)
        secret.write_text("what-signs-the-messages-of-this-test\n")
        secret.chmod(0o600)
        self.options = ["--webhook-secret", secret, "--webhook-networks", "127.0.0.0/8, ::1", "--webhook-authority", self.authority]
        seen = self.seen

        class Receiver(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                seen[self.path] = dict(self.headers), self.rfile.read(int(self.headers["Content-Length"]))
                self.send_response(204)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(self.authority, key)
        self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
        self.url = f"https://localhost:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def told(self, name, secret):
        """Checks that the end of a job came to the path /NAME, signed by `secret`."""
        until = time.monotonic() + 120
        while f"/{name}" not in self.seen and time.monotonic() < until:
            time.sleep(0.05)
        fields, body = self.seen.get(f"/{name}", ({}, b""))
        check(f"{name}: the end of a job is told", b'"job.successful"' in body and secret.startswith("whsec_"), (fields, body, secret))
        if not body or not secret:
            return
        program = re.search(r"```python\n(import base64.*?)```", pathlib.Path(TOP, "README.md").read_text(encoding="utf-8"), re.S)[1]
        known = {}
        exec(program, known)  # noqa: S102
        genuine, late = known["genuine"], fields | {"webhook-timestamp": str(int(fields["webhook-timestamp"]) - 1000)}
        check(f"{name}: by the README's program it is genuine", genuine(secret, fields, body), fields)
        for what, message in (("another body", (secret, fields, body + b" ")), ("another id", (secret, fields | {"webhook-id": "msg_0"}, body)),
                              ("another time", (secret, late, body)), ("another secret", ("whsec_" + 43 * "A" + "=", fields, body))):
            check(f"{name}: {what} is not", not genuine(*message), message)

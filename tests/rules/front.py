"""Runs the shipped nginx configuration in front of a daemon on a port of loopback, for tests in other languages: prints its
port, and ends at the end of its input.

usage: front.py PORT
Leaves to others: the requests. Invariant: it does not outlive the process that started it.
"""
import sys

from rule import counts, shipped_nginx
from servers import nginx, tool

if not tool("nginx"):
    sys.exit("nginx is not installed")
# a machine may stand still for longer than a client is granted; what is limited is as it is shipped
patient = [(f"{what}_timeout {seconds}s;", f"{what}_timeout 3600s;") for what, seconds in
           (("client_header", 10), ("client_body", 15), ("send", 30), ("keepalive", 30), ("proxy_read", 70))]
config = shipped_nginx([int(sys.argv[1])], changes=patient)
if counts["failed"]:
    sys.exit(1)
with nginx(config) as server:
    print(server.port, flush=True)
    sys.stdin.read()

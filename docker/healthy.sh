#!/bin/bash
# True when the daemon in this container answers /healthz with 200.
# bash opens the connection itself, so that neither the image nor the daemon needs an HTTP client.
exec 3<>"/dev/tcp/127.0.0.1/${PENDULUMD_LISTEN##*:}" || exit 1
printf 'GET /healthz HTTP/1.0\r\nHost: localhost\r\n\r\n' >&3
read -r -t 2 version status _ <&3
[[ $version = HTTP/1.* && $status = 200 ]]

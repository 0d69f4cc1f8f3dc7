#include "server/hooks/hook_files.h"

#include <assert.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* libraries, what names are resolved by, and the certificates of Debian, Fedora and Arch; not all
 * of /etc/ssl, where keys are too */
static const char *const files[] = {"/usr",
                                    "/lib",
                                    "/lib64",
                                    "/dev/urandom",
                                    "/etc/ld.so.cache",
                                    "/etc/localtime",
                                    "/etc/nsswitch.conf",
                                    "/etc/resolv.conf",
                                    "/etc/host.conf",
                                    "/etc/hosts",
                                    "/etc/gai.conf",
                                    "/etc/ssl/certs",
                                    "/etc/ssl/openssl.cnf",
                                    "/etc/pki/tls/certs",
                                    "/etc/pki/ca-trust/extracted",
                                    "/etc/ca-certificates/extracted",
                                    "/etc/gnutls/config",
                                    "/etc/crypto-policies"};

void srv_hook_files(struct srv_fence *fence, const char *authority) {
    char resolver[PATH_MAX];
    *fence = (struct srv_fence){.connects = 1};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        srv_fence_add(fence, SRV_FENCE_READ, files[i]);
    /* often a link to /run, where the credentials of services are too */
    if (realpath("/etc/resolv.conf", resolver)) srv_fence_add(fence, SRV_FENCE_READ, resolver);
    if (strcmp(authority, "none")) srv_fence_add(fence, SRV_FENCE_READ, authority);
    assert(fence->count <= SRV_FENCE_PLACES);
}

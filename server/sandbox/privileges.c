#include "server/sandbox/privileges.h"

#include <errno.h>
#include <linux/capability.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

enum pend_status srv_privileges_drop(struct pend_error *error) {
    struct __user_cap_header_struct header = {.version = _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {{0}},
                                  has[_LINUX_CAPABILITY_U32S_3] = {{0}};
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))
        return pend_fail(error, PEND_INVALID, -1, 0, "no_new_privs: %s", strerror(errno));
    prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
    /* fails harmlessly without CAP_SETPCAP */
    for (int which = 0; !prctl(PR_CAPBSET_DROP, which, 0, 0, 0); which++) continue;
    /* skip capset if there is nothing to drop: a supervisor may have forbidden the call */
    int held = syscall(SYS_capget, &header, has) || memcmp(has, none, sizeof none);
    if (held && syscall(SYS_capset, &header, none))
        return pend_fail(error, PEND_INVALID, -1, 0, "capabilities stay: %s", strerror(errno));
    return PEND_OK;
}

#include "server/jobs/job_notify.h"

#include <stdio.h>
#include <string.h>

#include "server/hooks/hook_address.h"
#include "server/hooks/hook_keys.h"
#include "server/work/admission.h"

int srv_job_notify_suits(struct srv_exchange *exchange, int job) {
    if (job || !exchange->field[SRV_JOB_NOTIFY]) return 1;
    srv_exchange_problem(exchange, 400,
                         "Job-Notify tells the end of a job, and this request makes none: it takes "
                         "Prefer: respond-async");
    return 0;
}

int srv_job_notify_read(struct srv_exchange *exchange, char url[SRV_HOOK_BYTES]) {
    const struct srv_service *service = exchange->service;
    const char *text = exchange->field[SRV_JOB_NOTIFY];
    struct api_webhook_place place;
    url[0] = 0;
    if (!text) return 1;
    const char *wrong =
        strlen(text) < SRV_HOOK_BYTES ? api_webhook_url(text, &place) : "is too long";
    if (!service->hook_keys)
        srv_exchange_problem(exchange, 422,
                             "this server sends no webhooks: its option --webhook-secret is none; "
                             "ask for the job with ?wait=, or listen to its events");
    else if (exchange->identity.kind == SRV_IDENTITY_ADDRESS)
        srv_admission_challenge(exchange,
                                "Job-Notify needs a client with a name, whose secret the messages "
                                "are signed with");
    else if (wrong)
        srv_exchange_problem(exchange, 400, "Job-Notify %s; it is a url of at most %d letters",
                             wrong, SRV_HOOK_BYTES - 1);
    else if (!srv_hook_host_may(place.host, &service->hook_networks))
        srv_exchange_problem(exchange, 422,
                             "Job-Notify has an address that is none of the public internet, and "
                             "in none of the networks that --webhook-networks names");
    else {
        snprintf(url, SRV_HOOK_BYTES, "%s", text);
        return 1;
    }
    return 0;
}

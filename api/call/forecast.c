#include "api/call/forecast.h"

#include <assert.h>
#include <math.h>

/* describes how to shorten a computation */
static const char *forecast_way_out(const struct api_op *op, const void *state) {
    const char *way = op->way_out ? op->way_out(state) : NULL;
    return way ? way : "ask for a shorter time or a looser tolerance";
}

static const char *forecast_job(const struct api_limits *limits) {
    return limits->of_jobs ? "" : "; a job, by Prefer: respond-async, may take longer";
}

int api_forecast_begins(const struct api_op *op, const void *state, const struct api_limits *limits,
                        double seconds, struct api_problem *problem) {
    if (op->doubt <= 0 || limits->stored || !(seconds > op->doubt * limits->compute_seconds))
        return 1;
    api_problem_set(problem, 422,
                    API_TYPE_LIMIT "this would take about %.2g s (estimated), longer than "
                                   "the limit %s of %.15g s: %s%s",
                    seconds, api_limits_name(limits, &limits->compute_seconds),
                    limits->compute_seconds, forecast_way_out(op, state), forecast_job(limits));
    return 0;
}

int api_forecast_good(struct api_forecast *forecast, const struct api_op *op, void *state,
                      const struct api_limits *limits, double seconds,
                      struct api_problem *problem) {
    enum { LEAST_STEPS = 500 };
    static const double forgiven[] = {12, 10, 8, 7, 6, 5.5, 5, 4, 3, 2, 1.5, 1.3, 1.1},
                        first_look = 0.01, next_look = 2;
    const int looks = sizeof forgiven / sizeof *forgiven;
    assert(op && limits && seconds >= 0);
    double part = -1, work = -1, steps = op->steps ? (double)op->steps(state) : 0;
    if (!op->progress || (op->steps && steps < LEAST_STEPS)) return 1;
    if (seconds < forecast->look_at) return 1;
    double times = forgiven[forecast->looks < looks ? forecast->looks : looks - 1];
    forecast->looks++;
    forecast->look_at = fmax(first_look, next_look * seconds);
    op->progress(state, &part, &work);
    const char *way_out = forecast_way_out(op, state), *job = forecast_job(limits);
    if (part > 0 && steps / part > times * limits->steps)
        api_problem_set(
            problem, 422,
            API_TYPE_LIMIT
            "this would take about %.2g integration steps, more than the limit %s of %.0f: %s%s",
            steps / part, api_limits_name(limits, &limits->steps), limits->steps, way_out, job);
    else if (work > 0 && seconds / work > times * limits->compute_seconds)
        api_problem_set(problem, 422,
                        API_TYPE_LIMIT
                        "this would take about %.2g s, longer than the limit %s of %.15g s: %s%s",
                        seconds / work, api_limits_name(limits, &limits->compute_seconds),
                        limits->compute_seconds, way_out, job);
    return !problem->status;
}

#include "core/taylor/taylor_order.h"

#include <assert.h>
#include <math.h>

double pend_taylor_target(double rtol) {
    assert(rtol > 0);
    return fmax(0.01 * rtol, 1e-16);
}

double pend_taylor_atol(double atol) {
    assert(atol >= 0);
    return 0.01 * atol;
}

int pend_taylor_order(double rtol, int alone) {
    assert(rtol > 0);
    double target = pend_taylor_target(rtol);
    int order = (int)ceil(4 - 0.65 * log(target)) + (alone && target < 2e-15 ? 2 : 0);
    if (order < PEND_TAYLOR_ORDER_MIN) return PEND_TAYLOR_ORDER_MIN;
    return order > PEND_TAYLOR_ORDER_MAX ? PEND_TAYLOR_ORDER_MAX : order;
}

double pend_taylor_first_unit(int n, const struct pend_loads *loads, const double length[],
                              const double rate[]) {
    assert(n >= 1);
    double fastest = 0;
    for (int k = 0; k < n; k++)
        fastest = fmax(fastest, fmax(fabs(rate[k]), sqrt(fabs(loads->gravity) / length[k])));
    return fastest > 0 ? exp2(-floor(log2(fastest))) : 1;
}

#include "core/taylor_order.h"

#include <math.h>

int pend_taylor_order(double rtol) {
    int order = (int)ceil(4 - 0.65 * log(rtol));
    if (order < PEND_TAYLOR_ORDER_MIN) return PEND_TAYLOR_ORDER_MIN;
    return order > PEND_TAYLOR_ORDER_MAX ? PEND_TAYLOR_ORDER_MAX : order;
}

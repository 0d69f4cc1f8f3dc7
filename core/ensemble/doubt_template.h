/* Horizons of the members, by the method of horizon.c and neighbour.c, for all lanes at once.
 * Included by the kernel, after its series. Leaves to others: the series of a step
 * (kernel_ensemble), those of a neighbour of a real pendulum (real_template). Invariant: no lane's
 * estimate depends on another lane. */
#pragma once

/* number of terms to which the recurrence is fitted; number of terms that it extrapolates */
enum { DOUBT_FITTED = 6, DOUBT_FORETOLD = 6 };

/* rounding error of a step relative to the step's increments; factor by which the neglected terms
 * may exceed the extrapolated ones */
static const double doubt_rounding = 2 * 0x1p-53, doubt_left = 2;

/* Records the ratio of error to allowed error at an instant. If it is too large, the accuracy holds
 * up to the previous instant. */
VEC_INLINE void doubt_note(const struct ensemble_doubt *doubt, num time, num ratio) {
    num held = lane_get(doubt->held, 0), before = lane_get(doubt->ratio, 0),
        from = lane_get(doubt->time, 0);
    wide_mask lost = (wide_mask)(ratio > 1) & (wide_mask)(held == ENSEMBLE_HELD);
    if (!mask_set(lost)) return;
    num low = NUM_(log2)(num_max(before, num_of(0x1p-1000))),
        high = NUM_(log2)(num_min(ratio, num_of(0x1p1000)));
    num part = num_min(num_max(low / (low - high), num_of(0)), num_of(1));
    lane_put(doubt->held, 0, NUM_(pick)(lost, num_fma(part, time - from, from), held));
}

/* the largest error of angles and rates, relative to the allowed error; the position of a cart is
 * divided by the length of the shortest arm */
VEC_INLINE num doubt_ratio(const struct ensemble_lanes *lanes, const double rate[]) {
    const struct ensemble_doubt *doubt = &lanes->doubt;
    num angle = num_of(0), speed = num_of(0), fastest = lane_get(doubt->fastest, 0);
    int cart = pend_terms_cart(lanes->terms);
    if (cart) {
        num shortest = lane_get(lanes->len, 1);
        for (int k = 2; k < lanes->n; k++) shortest = num_min(shortest, lane_get(lanes->len, k));
        fastest = num_max(fastest, num_abs(lane_get(rate, 0)) / shortest);
        angle = num_abs(lane_get(doubt->phi, 0)) / shortest;
        speed = num_abs(lane_get(doubt->rate, 0)) / shortest;
    }
    for (int k = cart; k < lanes->n; k++) {
        fastest = num_max(fastest, num_abs(lane_get(rate, k)));
        angle = num_max(angle, num_abs(lane_get(doubt->phi, k)));
        speed = num_max(speed, num_abs(lane_get(doubt->rate, k)));
    }
    lane_put(doubt->fastest, 0, fastest);
    num share = NUM_(pick)((wide_mask)(fastest > 0), speed / num_max(fastest, num_of(0x1p-1000)),
                           num_of(0));
    return doubt->grade * num_max(angle, share);
}

/* Computes the series of the errors, to first order. Returns the error of the forces at the start,
 * times unit^2. */
VEC_INLINE num doubt_change(const struct ensemble_lanes *lanes, const struct jets_system *s,
                            const struct jets_system *change, num gravity, num inverse) {
    const struct ensemble_doubt *doubt = &lanes->doubt;
    num force = num_of(0);
    for (int k = 0; k < lanes->n; k++) {
        change->turn_im[k] = lane_get(doubt->phi, k);
        change->rate[k] = lane_get(doubt->rate, k) / inverse;
    }
    change_orders(s, change, gravity, doubt->order);
    for (int k = 0; k < lanes->n; k++) force = num_max(force, num_abs(change->force[k]));
    return force;
}

/* the limit of the partial sums, in row 0, by Wynn's vector epsilon algorithm as in neighbour.c */
static __attribute__((noinline)) void doubt_limit(num *sum, num *before, int last, int size) {
    for (int i = 0; i < (last + 1) * size; i++) before[i] = num_of(0);
    for (int left = last; left > 0; left--) {
        for (int j = 0; j < left; j++) {
            num *row = sum + j * size, *old = before + j * size, square = num_of(0);
            for (int i = 0; i < size; i++) {
                num d = row[size + i] - row[i];
                square = num_fma(d, d, square);
            }
            num least = num_of(0x1p-1000), inverse = 1 / num_max(square, least);
            inverse = NUM_(pick)((wide_mask)(square > least), inverse, num_of(0));
            for (int i = 0; i < size; i++) {
                num next = num_fma(row[size + i] - row[i], inverse, old[size + i]);
                old[i] = row[i];
                row[i] = next;
            }
        }
        for (int i = 0; i < size; i++) before[left * size + i] = sum[left * size + i];
    }
}

/* computes the errors at the end of a step as the sum of their series alone */
VEC_INLINE void doubt_sum(const struct ensemble_doubt *doubt, const struct jets_system *change,
                          num x, num inverse) {
    for (int k = 0; k < change->n; k++) {
        num phi = num_of(0), rate = num_of(0);
        for (int j = doubt->order; j >= 0; j--) {
            num c = change->rate[(size_t)j * change->stride + (size_t)k];
            phi = num_fma(phi, x, c * change->share[j]);
            rate = num_fma(rate, x, c);
        }
        lane_put(doubt->phi, k, num_fma(x, phi, lane_get(doubt->phi, k)));
        lane_put(doubt->rate, k, rate * inverse);
    }
}

/* Computes the errors at the end of a step: the sum of their series or, if its terms do not
 * decrease, as in a contracting motion, its limit. */
static __attribute__((noinline)) void doubt_later(const struct ensemble_lanes *lanes,
                                                  const struct jets_system *change, num x,
                                                  num inverse) {
    const double falls = 0.02;
    const struct ensemble_doubt *doubt = &lanes->doubt;
    int n = lanes->n, order = doubt->order, size = 2 * n;
    num *sum = (num *)(void *)doubt->limit, *before = sum + (order + 1) * size;
    num power = x, start = num_of(0), last[2] = {num_of(0), num_of(0)};
    for (int k = 0; k < n; k++) {
        num faster = change->rate[k] * x, phi = lane_get(doubt->phi, k);
        sum[2 * k] = phi + faster, sum[2 * k + 1] = faster;
        start = num_max(start, num_max(num_abs(phi), num_abs(faster)));
    }
    for (int j = 1; j <= order; j++) {
        num *row = sum + j * size, largest = num_of(0);
        power *= x;
        for (int k = 0; k < n; k++) {
            num gap = change->rate[(size_t)j * change->stride + (size_t)k] * power;
            row[2 * k] = num_fma(gap, num_of(change->share[j]), row[2 * k - size]);
            row[2 * k + 1] = row[2 * k + 1 - size] + gap;
            largest = num_max(largest, num_abs(gap));
        }
        last[0] = last[1], last[1] = largest;
    }
    wide_mask fallen = (wide_mask)(last[0] + last[1] <= falls * start);
    const num *end = sum + order * size;
    for (int k = 0; k < n; k++) {
        lane_put(doubt->phi, k, end[2 * k]);
        lane_put(doubt->rate, k, end[2 * k + 1] * inverse / x);
    }
    if (!mask_set(~fallen)) return;
    doubt_limit(sum, before, order / 2 * 2, size);
    for (int k = 0; k < n; k++) {
        num phi = lane_get(doubt->phi, k), rate = lane_get(doubt->rate, k);
        lane_put(doubt->phi, k, NUM_(pick)(fallen, phi, sum[2 * k]));
        lane_put(doubt->rate, k, NUM_(pick)(fallen, rate, sum[2 * k + 1] * inverse / x));
    }
}

/* Computes the errors at the end of the step from those at its start. Returns the error of the
 * forces at the start, relative to the largest force so far. */
VEC_INLINE num doubt_spread(const struct ensemble_lanes *lanes, const struct jets_system *s, num x,
                            num gravity, num inverse) {
    const struct ensemble_doubt *doubt = &lanes->doubt;
    const struct ensemble_tables *change = ensemble_table(lanes, doubt->series, doubt->order),
                                 *own = ensemble_table(lanes, lanes->series, lanes->known);
    num strongest = lane_get(doubt->strongest, 0), square = inverse * inverse, force;
    if (lanes->terms)
        force = real_spread(lanes, &change->jets, &own->real, &change->real,
                            lane_get(lanes->unit, 0), gravity, x);
    else
        force = doubt_change(lanes, s, &change->jets, gravity, inverse);
    /* a short motion without losses contracts nowhere for long */
    if (!lanes->terms && doubt->order == JETS_SPREAD)
        doubt_sum(doubt, &change->jets, x, inverse);
    else
        doubt_later(lanes, &change->jets, x, inverse);
    for (int k = 0; k < lanes->n; k++)
        strongest = num_max(strongest, num_abs(s->force[k] * square));
    lane_put(doubt->strongest, 0, strongest);
    return NUM_(pick)((wide_mask)(strongest > 0),
                      square * force / num_max(strongest, num_of(0x1p-1000)), num_of(0));
}

/* The recurrence that fits the last terms of the lanes' series, as in left_template.h: a term is
 * `one` times the term before it plus `two` times the term before that. */
VEC_INLINE void doubt_recurrence(const struct jets_system *s, int last, num x, num *one, num *two) {
    num aa = num_of(0), ab = num_of(0), bb = num_of(0), ac = num_of(0), bc = num_of(0);
    for (int k = 0; k < s->n; k++) {
        const num *c = s->rate + (size_t)(last + 1 - DOUBT_FITTED) * s->stride + (size_t)k;
        num q = c[0], p = c[s->stride] * x, power = x * x;
        for (int i = 2; i < DOUBT_FITTED; i++, power *= x) {
            num r = c[(size_t)i * s->stride] * power;
            aa = num_fma(p, p, aa);
            ab = num_fma(p, q, ab);
            bb = num_fma(q, q, bb);
            ac = num_fma(p, r, ac);
            bc = num_fma(q, r, bc);
            q = p, p = r;
        }
    }
    num d = aa * bb - ab * ab;
    wide_mask good = (wide_mask)(d > 1e-6 * aa * bb);
    num share = num_of(1) / NUM_(pick)(good, d, num_of(1)), none = num_of(0);
    *one = NUM_(pick)(good, (ac * bb - bc * ab) * share, none);
    *two = NUM_(pick)(good, (bc * aa - ac * ab) * share, none);
}

/* adds the errors of the step itself: the neglected terms, known or extrapolated, and rounding */
VEC_INLINE void doubt_add(const struct ensemble_lanes *lanes, const struct jets_system *s, num x,
                          num inverse) {
    const struct ensemble_doubt *doubt = &lanes->doubt;
    int known = lanes->known;
    num power = x, most = num_of(0), length = num_abs(x / inverse),
        turn = num_abs(x) * doubt_rounding, one, two;
    wide_mask down = (wide_mask)num_of(-0.0);
    for (int j = 2; j < known; j++) power *= x;
    for (int k = 0; k < lanes->n; k++)
        most = num_max(most, num_abs(s->rate[s->stride + (size_t)k]) * s->len[k]);
    most *= num_abs(inverse) * turn;
    doubt_recurrence(s, known, x, &one, &two);
    for (int k = 0; k < lanes->n; k++) {
        const num *c = s->rate + (size_t)known * s->stride + (size_t)k;
        num before = *(c - s->stride) * power, last = c[0] * (power * x), faster = last;
        num turned = last * s->share[known];
        for (int i = 1; i <= DOUBT_FORETOLD; i++) {
            num next = num_fma(two, before, one * last);
            before = last, last = next;
            faster += next;
            turned = num_fma(next, num_of(s->share[known + i]), turned);
        }
        num rate = lane_get(doubt->rate, k) - doubt_left * faster * inverse;
        num phi = lane_get(doubt->phi, k) - doubt_left * turned * x;
        num push = most * s->inv_len[k];
        num more = num_fma(push, length * 0.5, num_abs(s->rate[k]) * turn);
        lane_put(doubt->rate, k, rate + (num)((wide_mask)push | ((wide_mask)rate & down)));
        lane_put(doubt->phi, k, phi + (num)((wide_mask)more | ((wide_mask)phi & down)));
    }
}

static void ensemble_doubt(const struct ensemble_lanes *lanes, const struct jets_system *s, num x,
                           num next, num gravity) {
    const struct ensemble_doubt *doubt = &lanes->doubt;
    if (!mask_set((wide_mask)(lane_get(doubt->held, 0) == ENSEMBLE_HELD))) return;
    num unit = lane_get(lanes->unit, 0), inverse = 1 / unit, time = lane_get(lanes->from.time, 0),
        one = num_of(1);
    num ratio = doubt_ratio(lanes, lanes->from.rate);
    num part = doubt->grade * doubt_spread(lanes, s, x, gravity, inverse),
        all = num_max(ratio, part);
    doubt_note(doubt, time, all);
    lane_put(doubt->time, 0, time);
    lane_put(doubt->ratio, 0, all);
    doubt_add(lanes, s, x, inverse);
    num grown = NUM_(pick)((wide_mask)(ratio > 0),
                           num_max(part / num_max(ratio, num_of(0x1p-1000)), one), one);
    doubt_note(doubt, next, doubt_ratio(lanes, lanes->to.rate) * grown);
}

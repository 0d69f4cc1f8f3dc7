/* Propagation of a small error of the state over one step, for a tree of up to LANES arms: the
 * equations of the orders, linearized about the motion, with the motion's table of responses.
 * Leaves to others: the motion's own series and its table (small_template, which includes this file
 * once for each number of lanes).
 * Invariant: the motion's series are only read. */

/* The changes of the motion's series: one series of pairs and one of turns. */
struct SMALL(change) {
    struct SMALL(pair) motion[JETS_SPREAD_MAX + 1];
    struct SMALL(turn) turn[JETS_SPREAD_MAX + 2];
};

/* the known part of the change of T and c of order k: every product has one factor of the motion
 * and one of the change */
VEC_INLINE void SMALL(change_known)(const struct jets_system *s, const struct SMALL(change) * x,
                                    int k, struct SMALL(known) * known) {
    for (int p = 0; p < PARTS; p++) {
        int at = p % TURNS;
        PART zero = PART_(of)(0), minus_re[2] = {zero, zero}, im[2] = {zero, zero};
        // the newest coefficients come last
        for (int j = 0; j < k; j++) {
            const double *turn = s->turn_re + (k + 1 - j) * 8 + at * PART_WIDTH;
            PART own = PART_(get)(SMALL(motion)(s, k + 1 - j, p)), other = x->motion[j].part[p];
            minus_re[0] = PART_(fma)(x->turn[j].minus_re[at], own, minus_re[0]);
            im[0] = PART_(fma)(x->turn[j].im[at], own, im[0]);
            minus_re[1] = PART_(fma)(PART_(get)(turn), other, minus_re[1]);
            im[1] = PART_(fma)(PART_(get)(s->turn_im + (turn - s->turn_re)), other, im[1]);
        }
        for (int j = k; j < k + 2; j++) {
            PART own = PART_(get)(SMALL(motion)(s, k + 1 - j, p));
            minus_re[0] = PART_(fma)(x->turn[j].minus_re[at], own, minus_re[0]);
            im[0] = PART_(fma)(x->turn[j].im[at], own, im[0]);
        }
        // the motion's turns of order 1 are i phi'_0 and are not stored
        PART first = SMALL(twice)(PART_(get)(SMALL(motion)(s, 0, at)));
        im[1] = PART_(fma)(first, x->motion[k].part[p], im[1]);
        known->minus_re.part[p] = minus_re[0] + minus_re[1];
        known->im.part[p] = im[0] + im[1];
    }
}

/* the change at the start: rotation of the arms by the errors of their angles, and the errors of
 * the rates */
VEC_INLINE void SMALL(change_start)(const struct jets_system *s, double unit, const double phi[],
                                    const double rate[], struct SMALL(change) * x) {
    struct SMALL(arms) zero, angle, speed;
    for (int i = 0; i < SPANS; i++) {
        zero.span[i] = VEC_(of)(0);
        angle.span[i] = VEC_(get)(phi + i * VEC_WIDTH);
        speed.span[i] = VEC_(get)(rate + i * VEC_WIDTH) * unit;
    }
    struct SMALL(pair) turned = SMALL(join)(&angle, &angle), faster = SMALL(join)(&speed, &speed);
    x->motion[0] = SMALL(join)(&speed, &zero);
    for (int p = 0; p < TURNS; p++) {
        x->turn[0].minus_re[p] = PART_(of)(0);
        x->turn[0].im[p] = turned.part[p];
        x->turn[1].minus_re[p] = SMALL(twice)(PART_(get)(SMALL(motion)(s, 0, p))) * turned.part[p];
        x->turn[1].im[p] = faster.part[p];
    }
}

/* order k + 1 of the change */
VEC_INLINE void SMALL(change_order)(const struct jets_system *s, struct SMALL(change) * x, int k) {
    const struct SMALL(table) *table = (const struct SMALL(table) *)(const void *)s->answers;
    struct SMALL(known) known;
    SMALL(change_known)(s, x, k, &known);
    for (int p = 0; p < PARTS; p++) known.im.part[p] *= SMALL(factor)(1, s->share[k], p);
    struct SMALL(pair) answer = SMALL(solve)(table, &known.im);
    PART share = PART_(of)(s->share[k + 1]);
    for (int p = 0; p < PARTS; p++)
        x->motion[k + 1].part[p] =
            PART_(fma)(SMALL(factor)(1, k + 1, p), answer.part[p], known.minus_re.part[p]);
    for (int p = 0; p < TURNS; p++) {
        x->turn[k + 2].minus_re[p] = share * SMALL(twice)(known.im.part[p]);
        x->turn[k + 2].im[p] = share * SMALL(twice)(answer.part[p]);
    }
}

/* the terms of one order, in units, and the sums of the terms of rates and of angles so far */
struct SMALL(change_sums) {
    PART term[PARTS], faster[PARTS], turned[PARTS];
};

/* adds the terms of order j of the change; `power` is the step to the power j + 1 */
VEC_INLINE void SMALL(change_add)(const struct jets_system *s, const struct SMALL(change) * x,
                                  int j, double power, struct SMALL(change_sums) * sums) {
    for (int p = 0; p < PARTS; p++) {
        sums->term[p] = x->motion[j].part[p] * power;
        sums->faster[p] += sums->term[p];
        sums->turned[p] = PART_(fma)(sums->term[p], PART_(of)(s->share[j]), sums->turned[p]);
    }
}

/* the largest rate among the terms of the current order */
VEC_INLINE double SMALL(change_size)(const struct SMALL(change_sums) * sums, int n) {
    double most = 0;
    for (int k = 0; k < (LANES == 2 ? 2 : n); k++) {
        double rate = fabs(sums->term[k / PART_WIDTH][k % PART_WIDTH]);
        most = rate > most ? rate : most;
    }
    return most;
}

/* computes orders until their terms no longer matter */
VEC_INLINE void SMALL(change_all)(const struct jets_system *s, const struct jets_spread *how,
                                  double least, struct SMALL(change) * x,
                                  struct SMALL(change_sums) * sums) {
    double power = how->x, before = 0;
    int k = 0;
    for (int p = 0; p < PARTS; p++) sums->faster[p] = sums->turned[p] = PART_(of)(0);
#pragma GCC unroll 8
    for (; k < JETS_SPREAD; k++, power *= how->x) {
        SMALL(change_add)(s, x, k, power, sums);
        SMALL(change_order)(s, x, k);
    }
    if (how->order > k) before = SMALL(change_size)(sums, s->n);
    for (;; k++, power *= how->x) {
        SMALL(change_add)(s, x, k, power, sums);
        if (k == how->order) return;
        double last = SMALL(change_size)(sums, s->n);
        if (last + before < least) return;
        SMALL(change_order)(s, x, k);
        before = last;
    }
}

static double SMALL(spread)(const struct jets_system *s, const struct jets_spread *how,
                            double phi[], double rate[]) {
    struct SMALL(change) x;
    struct SMALL(change_sums) sums;
    double size = 0, most = 0, length = how->unit * how->x, square = how->unit * how->unit;
    for (int k = 0; k < s->n; k++) {
        double turned = fabs(phi[k]), faster = fabs(rate[k] * length);
        size = turned > size ? turned : size;
        size = faster > size ? faster : size;
    }
    SMALL(change_start)(s, how->unit, phi, rate, &x);
    SMALL(change_all)(s, how, how->least * size, &x, &sums);
    for (int k = 0; k < s->n; k++) {
        int p = k / PART_WIDTH, lane = k % PART_WIDTH, at = LANES + k;
        double gap = fabs(x.motion[1].part[at / PART_WIDTH][at % PART_WIDTH]);
        phi[k] += sums.turned[p][lane];
        rate[k] = sums.faster[p][lane] / length;
        most = gap > most ? gap : most;
    }
    return most / square;
}

/* The tuning constants of fits. Each comment gives the meaning, the unit, and in brackets the test
 * that fails if the constant is three times larger or smaller. A constant that only bounds work or
 * memory, or keeps numbers finite, is marked "Safety".
 * Leaves to others: limits of requests (api/base/limits). Invariant: no other file of this
 * directory defines such a constant. */
#pragma once

/* Relative step at which the search in a window ends before more rows are added, and distance from
 * a bound at which an unknown without effect there starts. Unit: relative.
 * [wrong_requests_of_fits_are_told_what_helps] */
static const double fit_rough = 1e-3;
/* Step at which the search of all rows has converged. Unit: relative.
 * [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_fine = 1e-6;
/* Most iterations before more rows are added. [wrong_requests_of_fits_are_told_what_helps] */
enum { FIT_WINDOW_ITERATIONS = 12 };
/* Iterations after which bounds are examined.
 * [fits_of_chaotic_motions_converge_by_multiple_shooting] */
enum { FIT_BOUND_ITERATIONS = 16 };
/* Rows are added while the standard deviation of their prediction is below this. Unit: rad, or the
 * reach. [searches_in_a_curved_valley_go_on_to_its_lowest_place] */
static const double fit_foretold = 0.4;
/* Amplitude, rad, at which a swing of unknown amplitude begins. [starts_come_from_five_rows] */
static const double fit_swing_rate = 0.3;
/* Most steps of a motion, and additional ones per arm and swing. Safety: work at extreme values. */
enum { FIT_STEPS = 200 };
/* Most steps that friction may add, one for each decay by 1/e. Safety: work at extreme values. */
enum { FIT_STIFF_STEPS = 200000 };
/* Expected motions of all rows per unknown, counting six more unknowns than there are.
 * [fits_of_synthetic_data_are_within_three_standard_errors] */
enum { FIT_MOTIONS = 2 };
/* A motion that explains less than this fraction does not follow the data. Unit: the sum of
 * squares. [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_explained = 0.9;
/* A motion that explains more than this fraction follows the data without further tests. Unit: of
 * the squares. [fits_of_synthetic_data_are_within_three_standard_errors] */
static const double fit_clear = 0.99;
/* A remaining sum of squares below this is rounding: the fit is exact. A search that restarts in a
 * curved valley goes on to this. Unit: the sum of squares. [small_steps_are_negligible] */
static const double fit_exact = 1e-12;
/* A mean residual above this is not noise. Unit: sigma.
 * [fits_of_synthetic_data_are_within_three_standard_errors] */
static const double fit_strange = 3;
/* Adjacent residuals correlated above this are not noise. [models_are_judged_by_what_rows_allow] */
static const double fit_common = 0.5;
/* Pairs of residuals needed for this test. [models_are_judged_by_what_rows_allow] */
enum { FIT_PAIRS = 16 };
/* A smaller decrease of the sum of squares after a restart is rounding. Unit: of the variance.
 * [searches_in_a_curved_valley_go_on_to_its_lowest_place] */
static const double fit_fall = 0.01;
/* Most unknowns with second derivatives. Safety: one step computes two motions for each. */
enum { FIT_BENDS = 16 };
/* An unknown that moved farther has diverged. Unit: its start. [unknowns_far_away_are_reported] */
static const double fit_away = 1e6;
/* Predicted decrease by one more step that is negligible at a minimum; fit_step is the second
 * limit. A curvature below this makes no minimum. Unit: the sum of squares.
 * [searches_in_a_curved_valley_go_on_to_its_lowest_place] */
static const double fit_minimum = 1e-6;
/* Second limit of the predicted decrease, squared standard errors. [small_steps_are_negligible] */
static const double fit_step = 1e-4;
/* Misfit of data without noise, and error of slopes. Unit: rtol. [small_steps_are_negligible] */
static const double fit_loose = 300;
/* Rounding error of a motion; smaller effects of an unknown count as none. Unit: relative.
 * [directions_beside_a_steep_one_are_found] */
static const double fit_rounding = 1e-13;
/* Directions are identifiable if their singular value, relative to the largest, is above this.
 * Unit: relative. [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_least = 1e-9;
/* Largest standard error below fit_least. Unit: scale. [directions_beside_a_steep_one_are_found] */
static const double fit_unsure = 1e3;
/* Largest slope. Safety: sums of the squares of larger ones overflow. */
static const double fit_largest = 1e140;
/* Residual if there is no motion. Safety: above all others, so that the step is rejected. */
static const double fit_nowhere = 1e6;
/* Squared component in null directions above which an unknown is reported alone. Unit: of a square.
 * [fits_to_data_at_rest_name_one_by_one_what_they_do_not_tell] */
static const double fit_alone = (1 - 1e-6);
/* Least independent part of a null direction. Safety: rounding grows by the reciprocal. */
static const double fit_left = 0.1;
/* Relative step of differences of slopes and frequencies. [slopes_of_frequencies_are_exact] */
static const double fit_curve_step = 1e-4;
/* Significance of the tests of the model. Unit: p-value. [p_values_reject_models] */
static const double fit_level = 1e-3;
/* Least noise without a sigma. Unit: of a column. [models_are_judged_by_what_rows_allow] */
static const double fit_known_best = 1e-6;
/* Least fraction of the data for standard errors. Safety: the noise is divided by this fraction. */
static const double fit_freedom = 0.25;
/* One outlier is allowed in this many measurements. Unit: measurements.
 * [fits_list_outliers_and_robust_losses_pass_them_by] */
enum { FIT_OUTLIERS = 10 };
/* Degrees of freedom that a model without a test needs. [models_are_judged_by_what_rows_allow] */
enum { FIT_FREEDOM = 3 };
/* Positions on a shorter arc give no scale. Unit: of the spread. Safety: their circle is singular.
 */
static const double fit_circle_flat = 1e-9;
/* Residuals above this belong to another motion. Gaps between pieces begin with this standard
 * deviation; each round divides it by ten. Unit: noise. [starts_come_from_five_rows] */
static const double fit_noisy = 10;
/* If the first rows deviate more from a constant rate, it comes from a parabola. Unit: rad.
 * [starts_come_from_five_rows] */
static const double fit_bent = 0.1;
/* The first row is an outlier if the step after it exceeds the longest following step by this
 * factor; on a parabola by at most 5 / 3. [starts_come_from_five_rows] */
static const double fit_outlier = 5;
/* Rows on each side through which a parabola is fitted. The same number of first rows gives the
 * rate, or a circle; a piece has the rows of both sides. [starts_come_from_five_rows] */
enum { FIT_BESIDE = 2, FIT_FIRST = 2 * FIT_BESIDE + 1 };
/* Most arms with which unmeasured ones are assumed in line. Safety: work grows with their cube. */
enum { FIT_LINE_ARMS = 30 };
/* Number of first rows in which unmeasured arms are assumed in line. Safety: bounds the work. */
enum { FIT_LINE_ROWS = 64 };
/* Most pieces. Safety: the memory of slopes grows with them. */
enum { FIT_PIECES = 24 };
/* Rounds of multiple shooting, each with a larger weight of continuity.
 * [fits_of_chaotic_motions_converge_by_multiple_shooting] */
enum { FIT_ROUNDS = 4 };
/* Most iterations of a round. [fits_of_chaotic_motions_converge_by_multiple_shooting] */
enum { FIT_ROUND_ITERATIONS = 15 };
/* Most measurements that are divided into pieces. Safety: the memory of slopes grows with them. */
enum { FIT_PIECE_NUMBERS = 16384 };
/* Length of a piece; passing over the top takes as long for half a turn. Unit: swing.
 * [fits_name_no_farthest_row_of_what_cannot_be_compared] */
static const double fit_piece = 0.25;
/* Shifts of a clock that are tried on each side of its value, and their number in a swing.
 * [shifts_of_clocks_are_found_with_their_errors] */
enum { FIT_CLOCK_STEPS = 96, FIT_CLOCK_PARTS = 24 };
/* Another shift is reported if its sum of squares is larger by less. Unit: of the variance.
 * [shifts_of_clocks_are_found_with_their_errors] */
static const double fit_clock = 9;

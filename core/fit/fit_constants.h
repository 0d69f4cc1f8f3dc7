/* The tuning constants of fits. Each comment gives the meaning, the unit, and in brackets the test
 * that fails if the constant is three times larger or smaller, if there is one.
 * Leaves to others: limits of requests (api/base/limits). Invariant: no other file of this
 * directory defines such a constant. */
#pragma once

/* Relative step at which the search in a window ends before more rows are added. Unit: relative.
 * [wrong_requests_of_fits_are_told_what_helps] */
static const double fit_rough = 1e-3;
/* Step at which the search of all rows has converged. Unit: relative.
 * [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_fine = 1e-6;
/* Step at which a search that restarts in a curved valley has converged. Unit: relative. */
static const double fit_finest = 1e-12;
/* Most iterations in a window before more rows are added.
 * [wrong_requests_of_fits_are_told_what_helps] */
enum { FIT_WINDOW_ITERATIONS = 12 };
/* Iterations on all rows after which bounds are examined. */
enum { FIT_BOUND_ITERATIONS = 16 };
/* Rows are added while the standard deviation of their prediction is below this. Unit: rad, or the
 * reach. [searches_in_a_curved_valley_go_on_to_its_lowest_place] */
static const double fit_foretold = 0.4;
/* Where a swing of unknown amplitude begins: its amplitude, or its rate over that of a swing. Unit:
 * rad. */
static const double fit_swing_rate = 0.3;
/* Most steps of a motion, and additional steps per arm and swing. Unit: steps. */
enum { FIT_STEPS = 200 };
/* Most steps that friction may add, one for each decay by 1/e. Unit: steps. */
enum { FIT_STIFF_STEPS = 200000 };
/* Motions of all rows that a fit takes, and additional ones per unknown. Unit: motions. */
enum { FIT_MOTIONS = 12, FIT_UNKNOWN_MOTIONS = 2 };
/* Cost of a motion without derivatives. Unit: of one with derivatives. */
static const double fit_plain = 0.25;
/* Residual reported to the solver if the motion cannot be computed. Unit: residual. */
static const double fit_nowhere = 1e6;
/* A motion that explains less than this fraction does not follow the data. Unit: of the squares.
 * [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_explained = 0.9;
/* A motion that explains more than this fraction follows the data without further tests. Unit: of
 * the squares. [fits_of_synthetic_data_are_within_three_standard_errors] */
static const double fit_clear = 0.99;
/* A remaining sum of squares below this is rounding: the fit is exact. Unit: of the squares. */
static const double fit_exact = 1e-12;
/* A mean residual above this is not noise. Unit: sigma. */
static const double fit_strange = 3;
/* Residuals with an autocorrelation above this are not noise. Unit: of the squares. */
static const double fit_common = 0.5;
/* Pairs of adjacent residuals needed to test the autocorrelation. Unit: pairs. */
enum { FIT_PAIRS = 16 };
/* An unknown that moved by more than this is reported as not identifiable. Unit: of its start. */
static const double fit_away = 1e6;
/* A smaller decrease of the sum of squares after a restart is rounding. Unit: of the variance. */
static const double fit_fall = 0.01;
/* Most unknowns whose second derivatives are computed. Unit: unknowns. */
enum { FIT_BENDS = 16 };
/* Predicted decrease by one more step that is negligible at a minimum; fit_step is the second
 * limit. Unit: of the squares. [searches_in_a_curved_valley_go_on_to_its_lowest_place] */
static const double fit_minimum = 1e-6;
/* The second limit of that decrease, in squared standard errors. Unit: of the variance. */
static const double fit_step = 1e-4;
/* Allowed misfit of data without noise. Unit: rtol. */
static const double fit_loose = 300;
/* Rounding error of a motion; smaller effects of an unknown count as none. Unit: relative. */
static const double fit_rounding = 1e-13;
/* Directions are identifiable if their singular value, relative to the largest, is above this.
 * Unit: relative. [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_least = 1e-9;
/* A direction below fit_least is identifiable too if its standard error is at most this. Unit:
 * sizes. */
static const double fit_unsure = 1e3;
/* Largest slope whose square can still be summed. */
static const double fit_largest = 1e140;
/* Squared component in null directions above which an unknown is reported alone. Unit: of a square.
 * [fits_to_data_at_rest_name_one_by_one_what_they_do_not_tell] */
static const double fit_alone = (1 - 1e-6);
/* A null direction is skipped if a smaller fraction of it is independent of the directions before
 * it. Unit: of a length. */
static const double fit_left = 0.1;
/* A curvature of the sum of squares below this does not make a minimum. Unit: of the slopes'. */
static const double fit_flat = 1e-6;
/* Step of finite differences of slopes. Unit: relative. */
static const double fit_curve_step = 1e-4;
/* Error of a motion in those differences. Unit: rtol. */
static const double fit_curve_margin = 10;
/* Effects of an unknown at its bound that are below this count as none. Unit: of the data. */
static const double fit_unmoved = 1e-6;
/* Distance from the bound at which such an unknown restarts. Unit: of the interval. */
static const double fit_little = 1e-3;
/* Significance of the tests of the model. Unit: p-value. */
static const double fit_level = 1e-3;
/* Least noise assumed for measurements without a sigma. Unit: of a column. */
static const double fit_known_best = 1e-6;
/* Errors are withheld if less of the data remains to estimate the noise. Unit: of the data. */
static const double fit_freedom = 0.25;
/* One outlier is allowed in this many measurements. Unit: measurements.
 * [fits_list_outliers_and_robust_losses_pass_them_by] */
enum { FIT_OUTLIERS = 10 };
/* Degrees of freedom needed to accept a model that no test has checked. */
enum { FIT_FREEDOM = 3 };
/* Positions on a shorter arc of a circle give no scale. Unit: of the spread. */
static const double fit_circle_flat = 1e-9;
/* Residuals above this belong to another motion. Unit: noise. */
static const double fit_noisy = 10;
/* If the first rows deviate more from a constant rate, it comes from a parabola. Unit: rad. */
static const double fit_bent = 0.1;
/* The first row is an outlier if the step after it exceeds the longest following step by this
 * factor. On a parabola the ratio is at most 5 / 3. */
static const double fit_outlier = 5;
/* Rows on each side through which a parabola is fitted. Unit: rows. */
enum { FIT_BESIDE = 2 };
/* Number of first rows that give the rate; of positions that a circle needs. Unit: rows. */
enum { FIT_FIRST = 5 };
/* Most arms for which an arm without a measured tip is assumed in line with others. Unit: arms. */
enum { FIT_LINE_ARMS = 30 };
/* Number of first rows in which such an arm is searched for. Unit: rows. */
enum { FIT_LINE_ROWS = 64 };
/* Fewest rows of a piece. Unit: rows. */
enum { FIT_PIECE_ROWS = 4 };
/* Most pieces. Unit: pieces. */
enum { FIT_PIECES = 24 };
/* Rounds of multiple shooting; the weight of continuity grows with each. Unit: rounds. */
enum { FIT_ROUNDS = 4 };
/* Iterations per round. */
enum { FIT_ROUND_ITERATIONS = 15 };
/* Most measurements that are divided into pieces. Unit: numbers. */
enum { FIT_PIECE_NUMBERS = 16384 };
/* Initial standard deviation of a gap between pieces; each round divides it by ten. Unit: sigma. */
static const double fit_gape = 10;
/* Length of a piece; passing over the top takes as long for half a turn. Unit: swing. */
static const double fit_piece = 0.25;

#include "api/csv/csv_roles.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

/* the role of each column: "t", "theta 1 deg", "x 2 cm", "sigma of 1"; followed by "?" if it is
 * doubtful, "-" for one that is not used */
static void roles_text(const struct api_csv *csv, const struct api_csv_roles *roles, char *out,
                       size_t cap) {
    size_t at = 0;
    for (int i = 0; i < csv->columns; i++) {
        const struct api_csv_taken *taken = &roles->column[i];
        const char *unit = "";
        int time = taken->role == API_CSV_TIME;
        if (!time && fabs(taken->unit - 0.017453292519943295) < 1e-12) unit = " deg";
        if (taken->role == API_CSV_X || taken->role == API_CSV_Y)
            unit = taken->unit == 1       ? " m"
                   : taken->unit == 0.01  ? " cm"
                   : taken->unit == 0.001 ? " mm"
                                          : " px";
        if (time && taken->unit == 1e-3) unit = " ms";
        if (time && taken->unit == 60) unit = " min";
        if (taken->role == API_CSV_NONE)
            at += (size_t)snprintf(out + at, cap - at, "%s-", i ? ", " : "");
        else if (taken->role == API_CSV_SIGMA)
            at += (size_t)snprintf(out + at, cap - at, ", sigma of %d", taken->of);
        else if (time)
            at += (size_t)snprintf(out + at, cap - at, "%st%s%s", i ? ", " : "", unit,
                                   taken->sure ? "" : "?");
        else
            at += (size_t)snprintf(out + at, cap - at, "%s%s %d%s%s", i ? ", " : "",
                                   api_csv_role_name(taken->role), taken->arm, unit,
                                   taken->sure ? "" : "?");
    }
}

/* tables as people and programs save them, and their columns; made up for this test */
static const struct {
    const char *name, *text;
    int arms, rows;
    const char *is;
} tables[] = {
    {"commas", "t,theta_1 (deg)\n0,10\n0.1,9\n0.2,6\n", 1, 3, "t, theta 1 deg"},
    {"semicolons and decimal commas", "t;theta_1\n0,0;0,31\n0,1;0,28\n0,2;0,19\n", 1, 3,
     "t, theta 1?"},
    {"tabs, German", "Zeit in s\tWinkel \316\2701 in \302\260\n0\t12\n0,5\t-3\n", 1, 2,
     "t, theta 1 deg"},
    {"spaces under a comment", "# t theta_rad\n0.00 0.22\n0.03 0.15\n", 1, 2, "t, theta 1"},
    {"a per cent sign, MATLAB", "% t phi_1 phi_2\n  0.0  -1.1  -1.2\n  0.1  -1.3  -1.0\n", 2, 2,
     "t, phi 1?, phi 2?"},
    {"no names, degrees", "0.006, -18.9\n0.034, 16.9\n0.067, -13.8\n0.1, 11\n", 1, 4,
     "t?, theta 1 deg?"},
    {"no names, two arms", "0 0.5 0.4\n0.1 0.3 0.2\n0.2 0.0 -0.1\n", 2, 3,
     "t?, theta 1?, theta 2?"},
    {"no names, one tip", "0 0.5 -0.4\n0.1 0.3 -0.5\n0.2 0.0 -0.6\n", 1, 3, "t?, x 1 px?, y 1 px?"},
    {"a mark in front, CR LF", "\357\273\277t,x,y\r\n0,1,2\r\n1,2,1\r\n", 1, 2,
     "t, x 1 px, y 1 px"},
    {"CR alone", "t,theta_1 (rad)\r0,0.5\r0.1,0.4\r0.2,0.2\r", 1, 3, "t, theta 1"},
    {"sep=", "sep=;\nt;theta_1 (deg)\n0;10\n1;9\n", 1, 2, "t, theta 1 deg"},
    {"Tracker, one mass", "mass A,,\nt,x,y\n0,30.1,-95.2\n0.25,22.3,-97.6\n", 1, 2,
     "t, x 1 px, y 1 px"},
    {"Tracker, two masses", ",mass A,,mass B,\nt,x,y,x,y\n0,1,2,3,4\n1,2,3,4,5\n", 2, 2,
     "t, x 1 px, y 1 px, x 2 px, y 2 px"},
    {"numbers lead to arms", "t;x_m2;y_m2;r_m2;x_m1;y_m1\n0;1;2;3;4;5\n1;2;3;4;5;6\n", 2, 2,
     "t, x 2 px, y 2 px, -, x 1 px, y 1 px"},
    {"arms from 0", "time,theta_0 [rad],theta_1 [rad]\n0,1,2\n1,2,1\n", 2, 2,
     "t, theta 1, theta 2"},
    {"phyphox gyroscope", "\"Time (s)\",\"Gyroscope z (rad/s)\"\n0.01,0.5\n0.02,0.4\n", 1, 2,
     "t, thetad 1"},
    {"phyphox, all axes",
     "\"Time (s)\",\"Gyroscope x (rad/s)\",\"Gyroscope y (rad/s)\",\"Gyroscope z (rad/s)\","
     "\"Absolute (rad/s)\"\n0.01,0.1,0.5,0.0,0.5\n0.02,0.1,-2.5,0.1,2.5\n",
     2, 2, "t, -, thetad 1?, -, -"},
    {"an angle between arms", "t,theta_1 (deg),joint_2 (deg)\n0,1,2\n1,2,3\n", 2, 2,
     "t, theta 1 deg, joint 2 deg"},
    {"units above names in another spelling", "t;x_1;y_1\n(s);(mm);(mm)\n0;1;2\n1;2;3\n", 1, 2,
     "t, x 1 mm, y 1 mm"},
    {"accelerations", "t (s),theta_1 (rad),a_1 (m/s^2)\n0,0.1,2\n1,0.2,3\n", 1, 2, "t, theta 1, -"},
    {"PASCO Capstone", "\"Time (s) Run #1\",\"Angle (rad) Run #1\"\n0,0.2\n0.05,0.1\n", 1, 2,
     "t, theta 1"},
    {"Vernier", "Time (s)\tAngle (\302\260)\tVelocity (\302\260/s)\n0\t10\t0\n0.1\t9\t-20\n", 1, 2,
     "t, theta 1 deg, -"},
    {"DeepLabCut with a time",
     "scorer,,a,a,a\nbodyparts,,tip,tip,tip\ntime,coords,x,y,likelihood\n0,0,1,2,0.9\n0.1,1,2,3,0."
     "9\n",
     1, 2, "t, -, x 1 px, y 1 px, -"},
    {"OpenCV script", "frame,time_ms,x_px,y_px\n0,0,100,200\n1,33,101,202\n2,67,104,203\n", 1, 3,
     "-, t ms, x 1 px, y 1 px"},
    {"milliseconds without a word", "time,angle\n0,0.5\n33,0.4\n67,0.2\n", 1, 3, "t ms?, theta 1?"},
    {"an epoch", "timestamp,theta_1 (rad)\n1700000000.1,0.5\n1700000000.2,0.4\n", 1, 2,
     "t?, theta 1"},
    {"an epoch in milliseconds", "timestamp,theta_1 (rad)\n1700000000100,0.5\n1700000000200,0.4\n",
     1, 2, "t ms?, theta 1"},
    {"a clock", "Uhrzeit;Winkel (\302\260)\n12:00:01,0;5\n12:00:01,5;4\n", 1, 2, "t, theta 1 deg"},
    {"a date", "date,angle (deg)\n2026-11-27 12:00:01,5\n2026-11-27 12:00:02,4\n", 1, 2,
     "t, theta 1 deg"},
    {"units in a line of their own", "t,theta_1,theta_2\ns,deg,deg\n0,10,5\n1,9,4\n", 2, 2,
     "t, theta 1 deg, theta 2 deg"},
    {"units in brackets below", "Time,x,y\n(s),(cm),(cm)\n0,1,2\n1,2,3\n", 1, 2,
     "t, x 1 cm, y 1 cm"},
    {"measured, simulated, error",
     "temps_s,theta1_mesure_deg,theta1_simule_deg,erreur_theta1_deg\n0,10,10.1,-0.1\n1,9,9.2,-0."
     "2\n",
     1, 2, "t, theta 1 deg, -, -"},
    {"standard errors", "t (s),theta_1 (deg),sigma_theta_1 (deg)\n0,10,0.5\n1,9,0.5\n", 1, 2,
     "t, theta 1 deg, sigma of 1"},
    {"errors behind each", "t,x (mm),err,y (mm),err\n0,1,0.1,2,0.2\n1,2,0.1,3,0.2\n", 1, 2,
     "t, x 1 mm, sigma of 1, y 1 mm, sigma of 3"},
    {"X, Y and their errors", "X,Y,X',Y'\n0,1.3,0.01,0.002\n0.1,1.2,0.01,0.004\n0.2,1,0.01,0.003\n",
     1, 3, "t?, theta 1?, -, sigma of 1"},
    {"two tables side by side", "t,theta (rad),,t,theta (rad)\n0,0.25,,0,0.25\n1,0.2,,1,0.2\n", 1,
     2, "t, theta 1, -, -, -"},
    {"missing values", "t,theta_1 (rad)\n0,0.5\n1,NaN\n2,-\n3,N/A\n4,\n5,0.1\n", 1, 6,
     "t, theta 1"},
    {"thousands", "t;x_1 (mm)\n0,5;1.234,5\n1,5;1.200,0\n", 1, 2, "t, x 1 mm"},
    {"blanks as thousands, a real minus", "t;x_1 (mm)\n0,5;1\302\240234,5\n1,5;\342\210\22212,0\n",
     1, 2, "t, x 1 mm"},
    {"Spanish", "tiempo (s);\303\241ngulo (\302\260)\n0,0;10\n0,1;9\n", 1, 2, "t, theta 1 deg"},
    {"Turkish", "zaman,a\303\247\304\261 (rad)\n0,1\n1,0.5\n", 1, 2, "t, theta 1"},
    {"Dutch", "tijd [s];hoek [rad];hoeksnelheid [rad/s]\n0,1;1,2;0,1\n0,2;1,1;0,2\n", 1, 2,
     "t, theta 1, -"},
    {"Russian",
     "\320\222\321\200\320\265\320\274\321\217;\320\243\320\263\320\276\320\273 "
     "(rad)\n0;1\n1;0,5\n",
     1, 2, "t, theta 1"},
    {"a slash before the unit", "Time/s,Angle/rad\n0,1\n1,0.5\n", 1, 2, "t, theta 1"},
    {"a title above", "Pendulum of 3 May, group 4\n\nt,theta_1 (deg)\n0,10\n1,9\n", 1, 2,
     "t, theta 1 deg"},
    {"notes below", "t,theta_1 (deg)\n0,10\n1,9\nend of run\n", 1, 2, "t, theta 1 deg"},
    {"a log of a clock",
     "date,amplitude (deg),period (s)\n2026-11-27 12:00,5,1.9\n2026-11-27 12:01,4,1.9\n", 1, 2,
     "t, amplitude 1 deg, period 1"},
    {"an amplitude beside its angle", "t,theta_1 (deg),amplitude (deg)\n0,5,5\n1,2,5\n", 1, 2,
     "t, theta 1 deg, -"},
    {"accelerations along and across",
     "t (s),a along (m/s^2),a across (m/s^2),a z (m/s^2)\n0,-9,1,0\n0.1,-8,2,0\n", 1, 2,
     "t, along 1, across 1, -"},
    {"a cart", "t (s);x_cart (cm);theta_1 (deg)\n0;1,5;3\n0,1;1,7;2\n", 1, 2,
     "t, cart 1, theta 1 deg"},
    {"an arm too many", "t,theta_1 (deg),theta_2 (deg)\n0,1,2\n1,2,3\n", 1, 2, "t, theta 1 deg, -"},
};

TEST(tables_as_people_save_them_are_read) {
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        struct api_csv csv;
        struct api_csv_roles roles;
        char is[1024];
        if (!CHECK_SAYING(api_csv_look(&csv, tables[i].text), "%s is not read", tables[i].name))
            continue;
        api_csv_guess(&roles, &csv,
                      &(struct api_csv_hints){.arms = tables[i].arms, .cart = 1, .degrees = -1});
        roles_text(&csv, &roles, is, sizeof is);
        CHECK_SAYING(!strcmp(is, tables[i].is), "%s: %s, not %s", tables[i].name, is, tables[i].is);
        CHECK_SAYING(csv.rows == tables[i].rows, "%s: %ld rows", tables[i].name, csv.rows);
    }
}

/* names in a request override guesses */
TEST(given_names_of_columns_go_before_the_table_s) {
    static const char text[] = "a,b (deg),t,theta_1\n0,1,5,7\n1,2,6,8\n2,1,7,9\n";
    static const struct {
        const char *given[4];
        const char *is;
    } tried[] = {
        {{NULL, NULL, NULL, NULL}, "-, theta 1 deg, t, -"},
        {{"t", NULL, "", NULL}, "t, theta 1 deg, -, -"},
        {{"t (ms)", "sigma_theta_1", "", "theta 1"}, "t ms, sigma of 3, -, theta 1?"},
        {{NULL, "", NULL, NULL}, "-, -, t, theta 1?"},
        {{NULL, "thetad 1", NULL, NULL}, "-, thetad 1 deg, t, theta 1?"},
        {{"x_1 (cm)", "y_1 (cm)", NULL, ""}, "x 1 cm, y 1 cm, t, -"},
        {{NULL, "theta 3", NULL, NULL}, "-, -, t, theta 1?"},
    };
    for (size_t i = 0; i < sizeof tried / sizeof *tried; i++) {
        struct api_csv csv;
        struct api_csv_roles roles;
        struct api_csv_cell given[4];
        char is[1024];
        for (int k = 0; k < 4; k++) {
            const char *name = tried[i].given[k];
            given[k] = (struct api_csv_cell){name, name ? (int)strlen(name) : 0};
        }
        CHECK(api_csv_look(&csv, text));
        api_csv_guess(
            &roles, &csv,
            &(struct api_csv_hints){.arms = 1, .degrees = -1, .gives = 4, .given = given});
        roles_text(&csv, &roles, is, sizeof is);
        CHECK_SAYING(!strcmp(is, tried[i].is), "%zu: %s, not %s", i, is, tried[i].is);
    }
}

/* 12 swings of 0.3 about 0.2, with noise */
TEST(a_column_swings_about_the_mean_of_its_swings) {
    char text[8000], *at = text + sprintf(text, "t,theta_1\n");
    unsigned long long seed = 5;
    struct api_csv csv;
    double center, error, reach;
    for (int i = 0; i < 200; i++)
        at += sprintf(at, "%g,%.6f\n", 0.05 * i,
                      0.2 + 0.3 * exp(-0.01 * i) * cos(0.4 * i) + 0.004 * test_random(&seed));
    CHECK(api_csv_look(&csv, text));
    CHECK(api_csv_center(&csv.column[1], &center, &error, &reach));
    CHECK_SAYING(fabs(center - 0.202) < 4 * error && error < 0.01, "%g +- %g", center, error);
    CHECK(fabs(reach - 0.2) < 0.1);
}

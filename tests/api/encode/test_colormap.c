#include "api/encode/colormap.h"

#include <math.h>

#include "tests/harness/test.h"

/* the colour that the eye sees: OKLab, from the bytes */
static void seen(const unsigned char rgb[3], double lab[3]) {
    double x[3], cone[3];
    static const double in[3][3] = {{0.4122214708, 0.5363325363, 0.0514459929},
                                    {0.2119034982, 0.6806995451, 0.1073969566},
                                    {0.0883024619, 0.2817188376, 0.6299787005}};
    static const double out[3][3] = {{0.2104542553, 0.7936177850, -0.0040720468},
                                     {1.9779984951, -2.4285922050, 0.4505937099},
                                     {0.0259040371, 0.7827717662, -0.8086757660}};
    for (int i = 0; i < 3; i++) {
        double y = rgb[i] / 255.0;
        x[i] = y <= 0.04045 ? y / 12.92 : pow((y + 0.055) / 1.055, 2.4);
    }
    for (int i = 0; i < 3; i++) cone[i] = cbrt(in[i][0] * x[0] + in[i][1] * x[1] + in[i][2] * x[2]);
    for (int i = 0; i < 3; i++)
        lab[i] = out[i][0] * cone[0] + out[i][1] * cone[1] + out[i][2] * cone[2];
}

TEST(shades_are_evenly_apart_and_grow_lighter) {
    enum { APART = 23 };
    double least = 1, most = 0, light = 0;
    for (int i = 0; i + APART < API_COLORMAP_SHADES; i++) {
        unsigned char rgb[2][3];
        double lab[2][3], square = 0;
        api_colormap_shade(i, rgb[0]);
        api_colormap_shade(i + APART, rgb[1]);
        seen(rgb[0], lab[0]);
        seen(rgb[1], lab[1]);
        for (int c = 0; c < 3; c++) square += (lab[1][c] - lab[0][c]) * (lab[1][c] - lab[0][c]);
        least = fmin(least, sqrt(square));
        most = fmax(most, sqrt(square));
        CHECK(lab[0][0] > light - 0.005);
        light = lab[0][0];
    }
    CHECK(least > 0.05 && most / least < 1.15);
}

#include "api/encode/colormap.h"

#include <assert.h>
#include <math.h>

/* lightness, chroma and hue (degrees) at both ends of the path of colours */
static const double light_from = 0.27, light_to = 0.91, chroma = 0.09, hue_from = 305, hue_to = 100;

/* the sRGB byte of a linear intensity in 0 .. 1 */
static unsigned char colormap_byte(double x) {
    double y = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return (unsigned char)(255 * fmin(fmax(y, 0), 1) + 0.5);
}

void api_colormap_shade(int shade, unsigned char rgb[3]) {
    assert(shade >= 0 && shade < API_COLORMAP_SHADES);
    double part = (double)shade / (API_COLORMAP_SHADES - 1),
           light = light_from + (light_to - light_from) * part;
    double hue = (hue_from + (hue_to - hue_from) * part) * M_PI / 180;
    double a = chroma * cos(hue), b = chroma * sin(hue);
    // from OKLab to the cones' responses, then to linear sRGB
    double l = pow(light + 0.3963377774 * a + 0.2158037573 * b, 3);
    double m = pow(light - 0.1055613458 * a - 0.0638541728 * b, 3);
    double s = pow(light - 0.0894841775 * a - 1.2914855480 * b, 3);
    rgb[0] = colormap_byte(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s);
    rgb[1] = colormap_byte(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s);
    rgb[2] = colormap_byte(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s);
}

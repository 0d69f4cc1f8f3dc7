/* The colours of a picture: 254 perceptually uniform shades, for every kind of colour vision.
 * Leaves to others: mapping numbers to shades (encode_png).
 * Invariant: each shade is lighter than the one before by the same amount. */
#pragma once

enum { API_COLORMAP_SHADES = 254 };

/**
 * Computes red, green and blue of a shade, 0 .. API_COLORMAP_SHADES - 1. The shades run from dark
 * violet over blue and green to light yellow.
 *
 * In Ottosson's OKLab space lightness rises linearly and hue turns at constant chroma. Lightness
 * alone orders the shades, so that colour-blind readers and grey prints keep the order.
 */
void api_colormap_shade(int shade, unsigned char rgb[3]);

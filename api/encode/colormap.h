/* The colours of a picture of numbers: 254 shades that look equally far apart, for every kind of
 * colour vision.
 * Leaves to others: which number gets which shade (encode_png).
 * Invariant: each shade is lighter than the one before by the same amount. */
#ifndef API_COLORMAP_H
#define API_COLORMAP_H

enum { API_COLORMAP_SHADES = 254 };

/**
 * Red, green and blue of a shade, 0 .. API_COLORMAP_SHADES - 1, from dark violet over blue and
 * green to light yellow.
 *
 * A straight line in lightness and a turn in hue at constant chroma in Ottosson's OKLab space, so
 * that equal steps are seen as equal; lightness alone orders the shades, which is what survives
 * every colour blindness and a grey print.
 */
void api_colormap_shade(int shade, unsigned char rgb[3]);

#endif

/* The colours of a picture of numbers: 254 shades whose perceived distances are equal, for every
 * kind of colour vision.
 * Leaves to others: which shade a number has (encode_png).
 * Invariant: each shade is lighter than the one before by the same amount. */
#ifndef API_COLORMAP_H
#define API_COLORMAP_H

enum { API_COLORMAP_SHADES = 254 };

/**
 * Computes red, green and blue of a shade, 0 .. API_COLORMAP_SHADES - 1, from dark violet over blue
 * and green to light yellow.
 *
 * The shades are a straight line in lightness and a turn in hue at constant chroma in Ottosson's
 * OKLab space, so that equal steps look equal. Lightness alone orders them, which remains visible
 * with every colour blindness and in a grey print.
 */
void api_colormap_shade(int shade, unsigned char rgb[3]);

#endif

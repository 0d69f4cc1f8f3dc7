/* One column of a grid as a picture with one pixel per member: a PNG with a palette, by libpng.
 * Leaves to others: choosing the column (picture_json), the colours (colormap).
 * Invariant: no other file uses libpng; the first axis points right, the second up. */
#include "api/encode/encode.h"

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/colormap.h"
#include "core/base/status.h"

enum { NEVER, FAILED, FIRST_SHADE, STATUS_COLUMN = 1 };

/* the mapping of numbers to shades */
struct scale {
    const struct api_table_picture *picture;
    double from, to; /* numbers at both ends; their logarithms if the scale is logarithmic */
};

/* the buffer to which libpng writes, and the status */
struct sink {
    struct api_buffer *out;
    enum pend_status status;
};

static double png_bytes(const struct api_table *table) {
    return 1.01 * (double)table->rows + 65536;
}

/* the position of a number on the scale; NAN for a missing value, and on a logarithmic scale for a
 * number that is not positive */
static double scaled(const struct api_writer *writer, long row) {
    const struct api_table_picture *picture = &writer->table.picture;
    long width = api_column_numbers(&writer->table.column[picture->column]);
    double x = writer->column[picture->column][row * width + picture->arm];
    if (writer->column[STATUS_COLUMN][row] != 0) return NAN;
    if (!picture->logarithmic) return x;
    return x > 0 ? log(x) : NAN;
}

static struct scale scale_of(const struct api_writer *writer) {
    struct scale scale = {&writer->table.picture, INFINITY, -INFINITY};
    for (long row = 0; row < writer->rows; row++) {
        double x = scaled(writer, row);
        if (x < scale.from) scale.from = x;
        if (x > scale.to) scale.to = x;
    }
    return scale;
}

static unsigned char pixel(const struct api_writer *writer, const struct scale *scale, long row) {
    if (writer->column[STATUS_COLUMN][row] != 0) return FAILED;
    double x = scaled(writer, row);
    if (isnan(x)) return NEVER;
    double part = scale->to > scale->from ? (x - scale->from) / (scale->to - scale->from) : 0.5;
    return (unsigned char)(FIRST_SHADE + (int)(part * (API_COLORMAP_SHADES - 1) + 0.5));
}

static void sink_write(png_structp png, png_bytep data, size_t bytes) {
    struct sink *sink = png_get_io_ptr(png);
    sink->status = api_buffer_add(sink->out, (const char *)data, bytes);
    if (sink->status != PEND_OK) png_error(png, "no room");
}

static void sink_flush(png_structp png) { (void)png; }

static void leave(png_structp png, png_const_charp text) {
    (void)text;
    png_longjmp(png, 1);
}

static void stay_silent(png_structp png, png_const_charp text) { (void)png, (void)text; }

/* writes the pixels, and a text chunk that explains the colours */
static void write_picture(png_structp png, png_infop info, const struct api_writer *writer,
                          png_bytep line) {
    const struct api_table_picture *picture = &writer->table.picture;
    struct scale scale = scale_of(writer);
    long across = picture->across, down = writer->rows / across;
    png_color palette[256] = {[NEVER] = {255, 255, 255}, [FAILED] = {128, 128, 128}};
    for (int i = 0; i < API_COLORMAP_SHADES; i++) {
        unsigned char rgb[3];
        api_colormap_shade(i, rgb);
        palette[FIRST_SHADE + i] = (png_color){rgb[0], rgb[1], rgb[2]};
    }
    char name[] = "Title", title[64], key[] = "Description", note[200];
    snprintf(title, sizeof title, "%s", writer->table.column[picture->column].name);
    snprintf(note, sizeof note,
             "dark to light: %.6g to %.6g, %s; white: never, or not on the scale; grey: failed",
             picture->logarithmic ? exp(scale.from) : scale.from,
             picture->logarithmic ? exp(scale.to) : scale.to,
             picture->logarithmic ? "logarithmic" : "linear");
    png_text text[2] = {{.compression = PNG_TEXT_COMPRESSION_NONE, .key = name, .text = title},
                        {.compression = PNG_TEXT_COMPRESSION_NONE, .key = key, .text = note}};
    png_set_IHDR(png, info, (png_uint_32)across, (png_uint_32)down, 8, PNG_COLOR_TYPE_PALETTE,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_PLTE(png, info, palette, FIRST_SHADE + API_COLORMAP_SHADES);
    png_set_text(png, info, text, 2);
    png_set_compression_level(png, 3);
    png_write_info(png, info);
    for (long y = down - 1; y >= 0; y--) {
        for (long x = 0; x < across; x++) line[x] = pixel(writer, &scale, y * across + x);
        png_write_row(png, line);
    }
    png_write_end(png, info);
}

static int picture_written(png_structp png, png_infop info, const struct api_writer *writer,
                           png_bytep line) {
    if (setjmp(png_jmpbuf(png))) return 0;
    write_picture(png, info, writer, line);
    return 1;
}

static enum pend_status png_finish(struct api_writer *writer, struct api_buffer *out, int *done) {
    struct sink sink = {out, PEND_OK};
    enum pend_status status = PEND_NO_MEMORY;
    png_infop info = NULL;
    png_bytep line = malloc((size_t)writer->table.picture.across + 1);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, leave, stay_silent);
    if (!line || !png) goto out;
    info = png_create_info_struct(png);
    if (!info) goto out;
    png_set_write_fn(png, &sink, sink_write, sink_flush);
    int written = picture_written(png, info, writer, line);
    status = written || sink.status == PEND_OK ? PEND_OK : sink.status;
    if (!written && status == PEND_OK) status = PEND_NO_MEMORY;
    *done = status == PEND_OK;
out:
    png_destroy_write_struct(&png, &info);
    free(line);
    return status;
}

const struct api_format api_format_png = {
    .media_type = "image/png",
    .samples_only = 2,
    .picture = 1,
    .writer_bytes = sizeof(struct api_writer),
    .bytes = png_bytes,
    .finish = png_finish,
};

/** @file
 * TIFF as pages of chunks (strips or tiles). Directories are read here, by the bounded source, and only once: stacks
 * have thousands of them. libtiff decodes one chunk at a time, on any thread, from a small file of that chunk alone.
 */
#ifndef VVI_IO_FORMATS_TIFF_H
#define VVI_IO_FORMATS_TIFF_H
#include "core/text.h"
#include "io/formats/tiff/tiff_own.h"
#include "io/layout.h"
#include "io/notes.h"

enum {
    VVI_TIFF_PLAIN = 1, /* compression */
    VVI_TIFF_LZW = 5,
    VVI_TIFF_OLD_JPEG = 6,
    VVI_TIFF_JPEG = 7,
    VVI_TIFF_DEFLATE = 8,
    VVI_TIFF_OLD_DEFLATE = 32946,
    VVI_TIFF_ZSTD = 50000,
    VVI_TIFF_PNG = 65001,       /* no number of TIFF: a PNG file as one chunk (slices.h) */
    VVI_TIFF_WHITE_IS_ZERO = 0, /* photometric */
    VVI_TIFF_BLACK_IS_ZERO = 1,
    VVI_TIFF_RGB = 2,
    VVI_TIFF_PALETTE = 3,
    VVI_TIFF_YCBCR = 6,
    VVI_TIFF_UNSIGNED = 1, /* sample format */
    VVI_TIFF_SIGNED = 2,
    VVI_TIFF_FLOAT = 3
};

/** Values of an entry where they lie in the file. */
typedef struct vvi_tiff_array {
    uint64_t where, n;
    uint64_t first; /* the first value, known without reading again */
    uint16_t type;
} vvi_tiff_array;

typedef struct vvi_tiff_page {
    uint32_t file; /* of vvi_tiff.files; 0 where there are none */
    uint32_t width, height;
    uint32_t chunk_width, chunk_height; /* of a tile; of a strip, the width of the page and its rows */
    uint32_t subfile;
    uint16_t bits, samples, compression, photometric, planar, predictor, format, fill_order, orientation, n_extra,
        extra; /* the first of the extra samples */
    bool tiled, big_endian, big;
    bool is_file;                   /* a picture's file as one chunk (slices.h) */
    vvi_tiff_array offsets, counts; /* of chunks; counts.n is 0 where there are none */
    vvi_tiff_array jpeg_tables;
    vvi_tiff_array description, software, date, ome, xmp; /* texts */
    vvi_tiff_array colors;
    vvi_tiff_array imagej_lengths, imagej_data; /* tiff_imagej_extras.c */
    double resolution[2];                       /* pixels a unit along x and y; 0: not said */
    uint16_t resolution_unit;
} vvi_tiff_page;

/** A page that does not exist. */
#define VVI_TIFF_NO_PAGE UINT32_MAX

/** What is read of a file, or of several with one volume together. */
typedef struct vvi_tiff {
    vvi_tiff_page *pages;
    size_t n_pages, room_pages;
    char **files; /* beside the source, by vvi_tiff_page.file; NULL: the source itself is file 0 */
    size_t n_files;
    uint32_t *planes; /* pages in the order channel, slice, frame; VVI_TIFF_NO_PAGE: there is none */
    int64_t channels, slices, frames;
    uint64_t n_bytes; /* of all files */
    bool cut;         /* the chain of directories breaks off */
    bool half;        /* 16-bit floats, made f32 */
    bool plain;       /* samples lie as `layout` says, from `offset` on */
    bool mappable;
    uint64_t offset;
    vvi_layout layout;
    vvi_tiff_own own;
} vvi_tiff;

/** Where a page is read from. */
typedef struct vvi_tiff_reader {
    vv_source *source;
    uint64_t n_bytes;
    bool big_endian, big;
    vv_job *job;
} vvi_tiff_reader;

/* tiff_directory.c: pages of a file, appended; reduced pages and masks too. *n_out: how many there were. */
vv_status vvi_tiff_read_pages(vvi_tiff *tiff, vvi_tiff_reader *reader, vv_source *source, uint32_t file, vv_job *job);
/** The first page alone, appended: pictures have no other. */
vv_status vvi_tiff_read_first_page(vvi_tiff *tiff, vvi_tiff_reader *reader, vv_source *source, vv_job *job);
vv_status vvi_tiff_add_page(vvi_tiff *tiff, const vvi_tiff_page *page, vv_job *job);
/** A text of the file, cleaned of what is no text: yours to vvi_free(); NULL where there is none. */
vv_status vvi_tiff_text(char **out, const vvi_tiff_reader *reader, const vvi_tiff_array *array, uint64_t most);
/** The same of a text that the end of the file cuts off: what is there. *lacks_out: bytes of it that are not. */
vv_status vvi_tiff_text_there(char **out, uint64_t *lacks_out, const vvi_tiff_reader *reader,
                              const vvi_tiff_array *array, uint64_t most);
/** Values [first, first + n) of an array of whole numbers. */
vv_status vvi_tiff_numbers(uint64_t *out, const vvi_tiff_reader *reader, const vvi_tiff_array *array, uint64_t first,
                           size_t n);

/* tiff_page.c: what one page is made of */
vv_status vvi_tiff_check_page(const vvi_tiff_page *page, vv_source *source);
/** Whether two pages can be slices of one volume. */
bool vvi_tiff_same_kind(const vvi_tiff_page *a, const vvi_tiff_page *b);
vv_type vvi_tiff_type(const vvi_tiff_page *page);
/** Samples of a pixel in a chunk: 1 where they have planes of their own. */
static inline uint32_t vvi_tiff_chunk_samples(const vvi_tiff_page *page)
{
    return page->planar == 2 ? 1 : page->samples;
}
static inline uint64_t vvi_tiff_chunk_row_bytes(const vvi_tiff_page *page)
{
    return ((uint64_t)page->chunk_width * vvi_tiff_chunk_samples(page) * page->bits + 7) / 8;
}
static inline uint64_t vvi_tiff_chunks_across(const vvi_tiff_page *page)
{
    return ((uint64_t)page->width + page->chunk_width - 1) / page->chunk_width;
}
static inline uint64_t vvi_tiff_chunks_down(const vvi_tiff_page *page)
{
    return ((uint64_t)page->height + page->chunk_height - 1) / page->chunk_height;
}
static inline uint64_t vvi_tiff_chunks(const vvi_tiff_page *page)
{
    return vvi_tiff_chunks_across(page) * vvi_tiff_chunks_down(page) * (page->planar == 2 ? page->samples : 1);
}
/** Rows of a chunk: fewer in the last strip. */
uint32_t vvi_tiff_chunk_rows(const vvi_tiff_page *page, uint64_t chunk);
vv_status vvi_tiff_chunk_place(uint64_t *offset, uint64_t *n, const vvi_tiff_reader *reader, const vvi_tiff_page *page,
                               uint64_t chunk, uint64_t n_chunks);

/* tiff_stack.c: which page is which plane */
/** Planes of the first page and those like it, one after another: slices. */
vv_status vvi_tiff_stack(vvi_tiff *tiff, vv_source *source, vv_notes *notes, vv_job *job);
/** What the first plane says of samples, to the info; finds out whether samples lie as plain bytes. */
vv_status vvi_tiff_describe(vv_field_info *info, vvi_tiff *tiff, vv_source *source, vv_notes *notes, vv_job *job);

/* tiff_codec.c */
/** Whether chunks of this compression can be decoded; else VV_E_UNSUPPORTED. */
vv_status vvi_tiff_codec_check(const vvi_tiff_page *page, const char *name);
/** One chunk of `rows` rows, of the machine's byte order. False, and what is wrong, when it cannot be. Any thread. */
bool vvi_tiff_decode(void *out, size_t n_out, const vvi_tiff_page *page, uint32_t rows, const uint8_t *coded, size_t n,
                     const uint8_t *tables, size_t n_tables, char *why, size_t n_why);

/* slices_png.c */
bool vvi_slices_decode_png(void *out, size_t n_out, const vvi_tiff_page *page, const uint8_t *coded, size_t n,
                           char *why, size_t n_why);

/* tiff_read.c */
vv_status vvi_tiff_read(vv_field **out, const vv_field_info *info, const vvi_tiff *tiff, vv_source *source,
                        int64_t frame, const vv_box *region, vv_job *job);

/* tiff_imagej.c */
/** "ImageJ=..." of the first page: axes, spacing, frames. *is_out: it was there. */
vv_status vvi_tiff_imagej(bool *is_out, vv_field_info *info, vvi_tiff *tiff, const vvi_tiff_reader *reader,
                          vv_notes *notes, vv_job *job);

/* tiff_imagej_extras.c */
/** Names, colours and ranges of channels, texts of slices and of the file, to the notes. The info has its values. */
vv_status vvi_tiff_imagej_extras(const vv_field_info *info, const vvi_tiff *tiff, const vvi_tiff_page *page,
                                 const vvi_tiff_reader *reader, vv_notes *notes);

/* tiff_ome_info.c */
/** OME-XML in the first page: planes, spacing, channels, time. *is_out: it was there. */
vv_status vvi_tiff_ome(bool *is_out, vv_field_info *info, vvi_tiff *tiff, const vvi_tiff_reader *reader,
                       const char *part, vv_notes *notes, vv_job *job);

void vvi_tiff_free(void *tiff);
#endif

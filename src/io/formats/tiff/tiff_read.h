/** @file
 * Reading a box from chunks of TIFF, in two steps: bytes are fetched one chunk after another, then a batch of them is
 * decoded side by side.
 */
#ifndef VVI_IO_FORMATS_TIFF_READ_H
#define VVI_IO_FORMATS_TIFF_READ_H
#include "io/formats/tiff/tiff.h"

#define VVI_TIFF_BATCH 1024 /* chunks */

/** A chunk that is read. */
typedef struct vvi_tiff_chunk {
    const vvi_tiff_page *page;
    uint64_t number;  /* in its page */
    int64_t slice;    /* of the output */
    int component;    /* the first that it holds */
    size_t at, n;     /* its coded bytes in the batch */
    bool blank;       /* left out of the file: zeros */
    uint64_t missing; /* numbers that could not be read */
    char why[80];     /* what libtiff says */
} vvi_tiff_chunk;

/** A box being read, a batch of chunks at a time. */
typedef struct vvi_tiff_reading {
    const vv_field_info *info;
    const vvi_tiff *tiff;
    const vv_box *box;
    vv_job *job;
    const char *name;
    vv_source *source;        /* of `file` */
    vv_source *main, *beside; /* beside: NULL while the main one is read */
    uint32_t file;
    vvi_tiff_reader reader;
    uint8_t *out;
    size_t element, pixel; /* bytes of the output */
    uint8_t *batch;
    size_t room, used;
    vvi_tiff_chunk chunks[VVI_TIFF_BATCH];
    size_t n_chunks;
    uint8_t *tables; /* of JPEG, of the page `tables_of` */
    size_t n_tables;
    uint64_t missing, done, total; /* numbers */
    char why[80];                  /* of the first chunk that could not be decoded */
} vvi_tiff_reading;

/** The part of a chunk that the box asks for, in pixels of the page. */
typedef struct vvi_tiff_window {
    uint64_t x0, x1, y0, y1; /* in the page */
    uint64_t left, top;      /* of the chunk */
} vvi_tiff_window;

/* tiff_chunks.c */
vvi_tiff_window vvi_tiff_window_of(const vvi_tiff_reading *reading, const vvi_tiff_chunk *chunk);
/** Decodes the batch to the output and counts what is missing; the batch is empty afterwards. */
vv_status vvi_tiff_flush(vvi_tiff_reading *reading);
#endif

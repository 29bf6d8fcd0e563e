/** @file
 * Writing TIFF: pages are streamed, each directory before its samples, so nothing is ever written twice.
 */
#ifndef VVI_IO_FORMATS_TIFF_WRITE_H
#define VVI_IO_FORMATS_TIFF_WRITE_H
#include "core/text.h"
#include "io/formats/tiff/tiff_own.h"
#include "io/sink.h"
#include "io/world_order.h"

/** What ImageJ keeps of channels: bytes, and the lengths of their header and of each item. */
typedef struct vvi_tiff_extras {
    vvi_text data;
    uint64_t *length;
    size_t n_lengths, ended; /* ended: where the last item does */
} vvi_tiff_extras;

/** What all pages share. */
typedef struct vvi_tiff_writing {
    vv_sink *sink;
    vv_job *job;
    const vv_field_info *info;
    const vv_write_options *options;
    vvi_turn turn;        /* how pages lie in the field */
    bool big_endian, big; /* big: BigTIFF */
    int samples;          /* of a pixel: 3 or 4 for colours, else 1 */
    int64_t channels;     /* pages of one slice */
    uint64_t n_pages;
    int compression, predictor;
    uint32_t rows;     /* of a strip */
    uint64_t n_strips; /* of a page */
    size_t row_bytes, page_bytes;
    vvi_tiff_own own;
    const char *description, *software; /* of the first page; NULL: none */
    vvi_text xmp;                       /* the same */
    bool multiplied;                    /* colours by their alpha */
    vvi_tiff_extras extras;             /* of the first page; n_lengths 0: none */
    double resolution[2];
    int resolution_unit;
} vvi_tiff_writing;

/* tiff_encode.c */
/** Room that n bytes may need when they are compressed. */
size_t vvi_tiff_encode_bound(int compression, size_t n);
/** Rows of one strip, changed in place by the predictor, to out; VV_E_... when the compressor fails. */
vv_status vvi_tiff_encode(uint8_t *out, size_t room, size_t *n_out, uint8_t *rows, size_t n,
                          const vvi_tiff_writing *writing);

/* tiff_write_directory.c */
/** The directory of a page that lies at `where`, with what belongs to it. offsets and counts: of its strips. */
void vvi_tiff_put_directory(vvi_text *out, const vvi_tiff_writing *writing, bool first, uint64_t where,
                            const uint64_t *offsets, const uint64_t *counts, uint64_t next);
void vvi_tiff_put_head(vvi_text *out, const vvi_tiff_writing *writing, uint64_t first);

/* tiff_write_text.c */
/** Seconds in a unit of time that both dialects know; 0 of others, and where there is none: then no step is written. */
double vvi_tiff_seconds(const char *unit);
/** OME's name of a unit of length; NULL of what it has none for. */
const char *vvi_tiff_ome_unit(const char *unit);
void vvi_tiff_imagej_text(vvi_text *out, vvi_tiff_writing *writing, size_t n_frames);
vv_status vvi_tiff_ome_text(vvi_text *out, const vvi_tiff_writing *writing, size_t n_frames);

/* tiff_write_extras.c */
/** Names, colours and ranges of channels, as ImageJ keeps them. Free with vvi_tiff_extras_free, also when it fails. */
vv_status vvi_tiff_extras_build(vvi_tiff_extras *extras, const vvi_tiff_writing *writing);
void vvi_tiff_extras_free(vvi_tiff_extras *extras);

/* tiff_write.c */
vv_status vvi_tiff_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                         vv_job *job);
vv_status vvi_tiff_write_ome(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, vv_job *job);
#endif

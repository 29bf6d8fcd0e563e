/** @file
 * OME-XML, the description of OME-TIFF: https://docs.openmicroscopy.org/ome-model/6.3.1/ome-tiff/specification.html
 */
#ifndef VVI_IO_FORMATS_TIFF_OME_H
#define VVI_IO_FORMATS_TIFF_OME_H
#include "io/formats/tiff/tiff.h"

/** Directories [ifd, ifd + n) of a file are the planes from (c, z, t) on; -1: not said. */
typedef struct vvi_ome_run {
    int64_t ifd, first[3], n; /* first: c, z, t */
    char file[256], uuid[64]; /* "": the file itself */
} vvi_ome_run;

/** One image of the document: the one that is read. */
typedef struct vvi_ome {
    char id[64], name[128], uuid[64], companion[256];
    char order[8];   /* "XYZCT" */
    int64_t size[5]; /* x y z c t */
    double step[3], time_step;
    char unit[3][16], time_unit[16], bits[8];
    vv_channel *channels;
    size_t n_channels;
    vvi_ome_run *runs;
    size_t n_runs;
    size_t n_images;
    bool cut, has_pixels; /**< the text ends too early; but it says what the samples of an image are */
    vvi_tiff_own own;
} vvi_ome;

/** The image named `part` (NULL: the first); lists all as parts. Free with vvi_ome_free, also when it fails. */
vv_status vvi_ome_parse(vvi_ome *ome, const char *text, size_t n, const char *part, vv_notes *notes,
                        const char *file_name, vv_job *job);
void vvi_ome_free(vvi_ome *ome);

/* tiff_ome_planes.c */
/** Pages of all files that the image names to planes. */
vv_status vvi_ome_planes(vvi_tiff *tiff, const vvi_ome *ome, vv_source *source, vv_notes *notes, vv_job *job);
#endif

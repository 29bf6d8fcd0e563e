/** @file
 * BigDataViewer: an .xml that tells of views, and an .h5 that holds their samples.
 */
#ifndef VVI_IO_FORMATS_BDV_H
#define VVI_IO_FORMATS_BDV_H
#include "io/source.h"

#define VVI_BDV_SETUPS 256

/** A way that the specimen was looked at: one channel from one angle. */
typedef struct vvi_bdv_setup {
    int64_t id;
    char name[64];
    double voxel[3]; /* 0 when it is not said */
    char unit[16];
    int64_t channel; /* -1 when it is not said */
    int64_t others;  /* angle, tile and illumination as one number: equal when all are */
} vvi_bdv_setup;

typedef struct vvi_bdv_channel {
    int64_t id;
    char name[64];
} vvi_bdv_channel;

typedef struct vvi_bdv_views {
    char file[256]; /* of the samples, beside the .xml; "" when they are not in HDF5 */
    char loader[32];
    int n;
    vvi_bdv_setup setup[VVI_BDV_SETUPS];
    int n_channels;
    vvi_bdv_channel channel[VVI_BDV_SETUPS];
} vvi_bdv_views;

/** VV_E_FORMAT when it is no such XML. */
vv_status vvi_bdv_read_views(vvi_bdv_views *out, vv_source *xml, vv_job *job);
#endif

/** @file
 * What GDCM does for us: unpacking one JPEG, JPEG-LS or JPEG 2000 picture. It never sees a file.
 */
#ifndef VVI_IO_DICOM_GDCM_H
#define VVI_IO_DICOM_GDCM_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum vvi_gdcm_codec { VVI_GDCM_JPEG, VVI_GDCM_JPEG_LS, VVI_GDCM_JPEG_2000 } vvi_gdcm_codec;

typedef struct vvi_gdcm_picture {
    vvi_gdcm_codec codec;
    const char *syntax; /* its transfer syntax */
    unsigned columns, rows;
    unsigned components, allocated, stored; /* bits */
    bool is_signed;
    const char *photometric;
    bool planar; /* set: the samples came out plane by plane */
    bool ybr;    /* set: colours came out as YBR */
} vvi_gdcm_picture;

/** n_out bytes of samples, little-endian; false when the picture is damaged. Any thread. */
bool vvi_gdcm_unpack(vvi_gdcm_picture *picture, uint8_t *out, size_t n_out, const uint8_t *in, size_t n_in);
const char *vvi_gdcm_version(void);

#ifdef __cplusplus
}
#endif
#endif

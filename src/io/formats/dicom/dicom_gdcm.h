/** @file
 * What GDCM does for us: unpacking one JPEG, JPEG-LS or JPEG 2000 picture. It never sees a file. Its dictionaries take
 * 20 ms whenever a program that is linked with it starts, so it is in a module of its own, volvis-gdcm.so, which is
 * loaded when a picture first needs it.
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

/* Changes with any of these structs. */
#define VVI_GDCM_API 1

/** What the module has, under the name VVI_GDCM_TABLE. */
typedef struct vvi_gdcm {
    unsigned api; /**< VVI_GDCM_API; always the first member */
    /** n_out bytes of samples, little-endian; false when the picture is damaged. Any thread. */
    bool (*unpack)(vvi_gdcm_picture *picture, uint8_t *out, size_t n_out, const uint8_t *in, size_t n_in);
} vvi_gdcm;

#define VVI_GDCM_MODULE "volvis-gdcm.so"
#define VVI_GDCM_TABLE "volvis_gdcm"
#ifdef __cplusplus
extern __attribute__((visibility("default"))) const vvi_gdcm volvis_gdcm;
#endif

/** The module, loaded once and for good; NULL: it cannot be. Any thread. The import program calls it before it locks
 * itself in: no library is loaded after that. */
const vvi_gdcm *vvi_gdcm_load(void);
/** Why vvi_gdcm_load() gave NULL: "there is no volvis-gdcm.so ..."; NULL: it did not. */
const char *vvi_gdcm_problem(void);
/** Whether the module is there, by its name alone. */
bool vvi_gdcm_is_there(void);

#ifdef __cplusplus
}
#endif
#endif

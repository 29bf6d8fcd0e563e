/** @file
 * Small DICOM files in memory, one of each dialect: a slice, or slices, of 8 x 8 samples 9 * (i + j).
 */
#ifndef TEST_DICOMS_H
#define TEST_DICOMS_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum test_dicom {
    TEST_DICOM_EXPLICIT,
    TEST_DICOM_IMPLICIT,
    TEST_DICOM_BIG,
    TEST_DICOM_BARE,     /* no preamble */
    TEST_DICOM_ENHANCED, /* 2 frames that say where they lie, sequences with lengths */
    TEST_DICOM_NESTED,   /* the same without lengths */
    TEST_DICOM_CINE,     /* 2 time steps */
    TEST_DICOM_DOSE,     /* 2 slices by offsets */
    TEST_DICOM_RLE,
    TEST_DICOM_LOSSLESS,
    TEST_DICOM_JPEG_LS, /* from here on with GDCM */
    TEST_DICOM_JPEG_2000,
    TEST_DICOM_BASELINE, /* lossy: 4 or less away */
} test_dicom;
#define TEST_DICOMS 13

/** An element that says something else. */
typedef struct test_dicom_change {
    uint32_t tag;
    const char *value; /* a text, or numbers of 16 bits, "8\\9"; NULL: the element is left out */
    bool number;
} test_dicom_change;

extern const char *const test_dicom_names[TEST_DICOMS];
/** The bytes of a file, for free(); change may be NULL. */
uint8_t *test_dicom_make(test_dicom kind, const test_dicom_change *change, size_t *n_out);
#endif

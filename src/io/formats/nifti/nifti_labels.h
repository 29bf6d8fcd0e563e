/** @file
 * Names of labels in NIfTI header extensions.
 */
#ifndef VVI_IO_NIFTI_LABELS_H
#define VVI_IO_NIFTI_LABELS_H
#include "core/text.h"
#include "io/notes.h"

/** VALUE_LABEL_DTABLE of an AFNI extension (code 4): labels and names. The text is changed on the way. */
vv_status vvi_nifti_afni_labels(char *text, vv_notes *notes);
/** <LabelTable> of a Caret or CIFTI extension (codes 30 and 32): labels, names and colours. */
vv_status vvi_nifti_caret_labels(char *text, vv_notes *notes);
/** The second form, as Connectome Workbench writes it. */
void vvi_nifti_add_caret_labels(vvi_text *out, const vv_label *labels, size_t n, bool is_unsigned);
#endif

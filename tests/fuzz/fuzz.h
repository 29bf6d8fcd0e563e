/** @file
 * What the fuzz targets share. Each is one function on bytes: libFuzzer calls it with -Dfuzz=true, else standalone.c
 * with the files that it is given.
 */
#ifndef FUZZ_H
#define FUZZ_H
#include <volvis/sys/registry.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n);
/** One job for all inputs of a process: a thread, 64 MiB of memory. */
vv_job *fuzz_job(void);
/** Header and first frames of a format; options NULL: defaults. Stops the process when a promise is broken: a failure
 * without a sentence, or a success with dims that are none. */
void fuzz_format(const vv_format *format, const uint8_t *data, size_t n, const vv_read_options *options);
/** Pixels and text of an image format, together and the text alone; without a library for it, nothing. */
void fuzz_image(const vv_image_format *format, const uint8_t *data, size_t n);
/** Stops the process unless the condition holds: what a fuzzer takes for a finding. */
void fuzz_expect(bool condition);
#endif

/** @file
 * Whole numbers in the order of samples: what sorts one type sorts all of them.
 *
 * A key has as many bytes as its sample: uint8_t, int16_t, int32_t or int64_t. NaN come before and behind all others.
 */
#ifndef VVI_FILTER_SAMPLE_KEYS_H
#define VVI_FILTER_SAMPLE_KEYS_H
#include <volvis/field.h>

/** n samples, `step` bytes from one to the next, as packed keys. */
void vvi_keys_of_samples(void *keys, const void *samples, int64_t step, vv_type type, int64_t n);
void vvi_samples_of_keys(void *samples, int64_t step, const void *keys, vv_type type, int64_t n);
/** The keys of -infinity and infinity; false for types that have none, and no NaN. */
bool vvi_keys_bounds(int64_t *lo, int64_t *hi, vv_type type);
/** The key at an index, whatever its size. */
int64_t vvi_key_at(const void *keys, int64_t index, vv_type type);
/** The sample that has a key. */
void vvi_sample_of_key(void *sample, int64_t key, vv_type type);
#endif

/** @file
 * A hash of any part of a World: over what is set, by the class tables, so that it means the same in every process and
 * on every machine, whatever order members have in memory. For what depends on that part: pictures that go on,
 * preparations that are kept.
 */
#ifndef VVI_MODEL_OBJECT_HASH_H
#define VVI_MODEL_OBJECT_HASH_H
#include <volvis/model.h>

/** What it goes over. Zeros: all that is set, and references as names. */
typedef struct vvi_hash_rules {
    /** Whether a property that is set does not count; NULL: all do. An object of which no others are set does not
     * either. */
    bool (*leaves_out)(const void *user, const vv_object *owner, const vv_property *row);
    const void *user;
    /** Not NULL: references to objects of this World count as what they lead to, whatever its name, at most 16 deep. */
    const vv_world *world;
} vvi_hash_rules;

/** Goes on from `seed`, 0 at first. What a newer schema said and this one does not know does not count. */
uint64_t vvi_object_hash(const vv_object *object, const vvi_hash_rules *rules, uint64_t seed);
/** The same of numbers that are no property. */
uint64_t vvi_hash_u64(uint64_t value, uint64_t seed);
uint64_t vvi_hash_f64(double value, uint64_t seed);
uint64_t vvi_hash_text(const char *text, uint64_t seed); /* NULL is not "" */
#endif

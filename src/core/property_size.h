/** @file
 * How large property objects are.
 */
#ifndef VVI_CORE_PROPERTY_SIZE_H
#define VVI_CORE_PROPERTY_SIZE_H
#include <volvis/property.h>

/** At least as many characters as the object is printed with. Cheap: nothing is printed. */
size_t vvi_object_text_most(const vv_object *object);
/** Bytes of memory that an object has for itself, and does not share with an older or newer version (NULL: none). */
size_t vvi_object_apart(const vv_object *object, const vv_object *from);
#endif

/** @file
 * Names of tables: which one is meant, and what a sentence says where there is none of that name.
 */
#ifndef VVI_CORE_NAMES_H
#define VVI_CORE_NAMES_H
#include "core/status.h"
#include "core/text.h"
#include <volvis/property.h>

/** So many names a sentence lists; of more it tells where they are listed. */
enum { VVI_KNOWN_LISTED = 48 };

typedef struct vvi_known {
    const char *const *name;
    size_t n;
    const char *lister;         /**< "volvis presets": what lists them all; NULL: nothing does */
    const char *const *aliases; /**< as vv_property has them: pairs of another word for a name, and the name; or NULL */
} vvi_known;

/** Number of the name that was typed: the very same, else the only one that differs by the case of letters alone; n:
 * there is none. */
size_t vvi_name_find(const char *typed, const char *const *names, size_t n);

/** What the sentence about an unknown name ends with: "; did you mean 'x'? There are x, y and z", "; there are x, y (or
 * w) and z", or "; 'volvis presets' lists them" of many. */
void vvi_known_add(vvi_text *out, const char *typed, const vvi_known *names);

/** A failure whose text is the sentence and that end. file, where: as vv_fail_at() takes them, or NULL. */
vv_status vvi_fail_name(vv_status status, const char *file, const char *where, const char *typed,
                        const vvi_known *names, const char *format, ...) VV_PRINTF(6, 7);

/** Whether a row acts while the enum that its `when` names has this word; true of rows that name none. */
bool vvi_property_acts_with(const vv_property *row, const char *word);
/** The enum that a row's `when` names, in its class; NULL: none. */
const vv_property *vvi_property_choice(const vv_class *cls, const vv_property *row);
#endif

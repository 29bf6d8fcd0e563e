/** @file
 * JSON of jansson's trees, from text and to text, whole or not at all. Its own reader (2.14) takes no notice of a text
 * that cannot grow: it then leaves letters and digits out, and writes past the end of what it has; its printer leaves
 * names out. So neither is used.
 */
#ifndef VVI_CORE_JSON_TEXT_H
#define VVI_CORE_JSON_TEXT_H
#include <jansson.h>
#include <volvis/base.h>

typedef enum vvi_json_fault {
    VVI_JSON_SYNTAX,
    VVI_JSON_LARGE, /**< a number that is too large */
    VVI_JSON_MEMORY
} vvi_json_fault;

/** Why a text is none. */
typedef struct vvi_json_flaw {
    vvi_json_fault fault;
    int line, column; /**< of the last letter that was read, from 1 */
    char text[80];
} vvi_json_flaw;

/** NULL where the n bytes are no JSON, or there is no memory. flags: as for json_loadb(), of which there are
 * JSON_DECODE_ANY, JSON_REJECT_DUPLICATES, JSON_ALLOW_NUL and JSON_DECODE_INT_AS_REAL. flaw_out may be NULL. */
json_t *vvi_json_decode(const char *text, size_t n, size_t flags, vvi_json_flaw *flaw_out);

/** Of a text that was printed here: NULL is for want of memory. */
json_t *vvi_json_of_own(const char *text);

/** The text, to be given back with free(), or NULL. flags: those of json_dumps(). */
char *vvi_json_encode(const json_t *tree, size_t flags);

/** Adds to a list, to an object, what is new: its reference is taken. Where it cannot be, or was not made for want of
 * memory, the list or object is NULL from then on. */
void vvi_json_append(json_t **list, json_t *value);
void vvi_json_put(json_t **object, const char *name, json_t *value);

/** json_copy() of an object, which leaves out what there is no memory for: NULL then. */
json_t *vvi_json_copy_object(const json_t *object);
#endif

/** @file
 * A growing string; a failed allocation makes it bad, checked once at the end.
 */
#ifndef VVI_CORE_TEXT_H
#define VVI_CORE_TEXT_H
#include <stdarg.h>
#include <volvis/base.h>

typedef struct vvi_text {
    char *s; /**< NULL while empty; ends with 0 */
    size_t n, room;
    bool bad;
} vvi_text;

void vvi_text_add(vvi_text *text, const char *s);
void vvi_text_add_n(vvi_text *text, const char *s, size_t n);
void vvi_text_printf(vvi_text *text, const char *format, ...) VV_PRINTF(2, 3);
/** A JSON string with its quotes; bytes that are not UTF-8 become U+FFFD. */
void vvi_text_json(vvi_text *text, const char *s);
/** The same in ASCII alone ("\u00f6"), for readers that take it for nothing else. */
void vvi_text_json_ascii(vvi_text *text, const char *s);
/** The path of a file as a text: its bytes that are no UTF-8, which names may have, become characters of the private
 * use area, U+EF80 for 0x80 to U+EFFF for 0xff. What is one of these already is written byte by byte, so that no two
 * paths are one text. */
void vvi_text_path(vvi_text *text, const char *path);
/** vvi_text_path() as a JSON string. */
void vvi_text_json_path(vvi_text *text, const char *path);
/** The path that vvi_text_path() wrote, in place. */
void vvi_path_of_text(char *s);
/** The string, yours to free(), and the text is empty again; NULL when it is bad. */
char *vvi_text_take(vvi_text *text);
void vvi_text_free(vvi_text *text);

/** Bytes of the UTF-8 character at s: 1 to 4, or 0 at the end and where there is none. */
size_t vvi_utf8_length(const char *s);
/** Adds a text from outside, the name of a file say, as vvi_text_clean() makes it. */
void vvi_text_add_clean(vvi_text *text, const char *s);
/** Cuts what stands behind the first n bytes. */
void vvi_text_cut(vvi_text *text, size_t n);
/** Makes one harmless line of a text from outside: control characters, marks of direction and broken UTF-8 become '?'.
 */
void vvi_text_clean(char *s);
/** The most brackets of a JSON text that are open at once: to know it before a parser recurses as deep. */
size_t vvi_json_nesting(const char *text, size_t n);
/** What its values take in memory when it is parsed, at least as much as it will be, without the texts in it. */
uint64_t vvi_json_tree_bytes(const char *text, size_t n);
/** How many letters a place for a number has that a text begins with, "%d" or "%03d", and how wide it is (up to 999; 0:
 * as wide as the number); 0 where there is none. */
size_t vvi_text_place(const char *text, int *width_out);
#endif

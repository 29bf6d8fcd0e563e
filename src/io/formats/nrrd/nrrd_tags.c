/* What a segment is, in the tags that 3D Slicer gives it: KEY:VALUE|KEY:VALUE|. The value of TerminologyEntry has seven
 * parts between '~', five of them codes as SCHEME^VALUE^MEANING:
 * https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html */
#include "io/formats/nrrd/nrrd.h"
#include "io/scan.h"
#include <stdio.h>
#include <string.h>

#define ENTRY "TerminologyEntry:"

/* Which of the parts are codes; the others name lists of them. */
static const int part_of[VV_LABEL_CODES] = {1, 2, 3, 5, 6};

static void copy_text(char *out, size_t room, const char *text, size_t n)
{
    snprintf(out, room, "%.*s", (int)vvi_utf8_cut(text, n, room - 1), text);
}

/* SCHEME^VALUE^MEANING, of n letters. */
static void parse_code(vv_code *out, const char *text, size_t n)
{
    const char *end = text + n, *value = memchr(text, '^', n);
    const char *meaning = value ? memchr(value + 1, '^', (size_t)(end - value - 1)) : NULL;
    if (!meaning)
        return;
    copy_text(out->scheme, sizeof out->scheme, text, (size_t)(value - text));
    copy_text(out->value, sizeof out->value, value + 1, (size_t)(meaning - value - 1));
    copy_text(out->meaning, sizeof out->meaning, meaning + 1, (size_t)(end - meaning - 1));
}

bool vvi_nrrd_parse_tags(vv_code out[VV_LABEL_CODES], const char *tags)
{
    const char *at = tags;
    bool any = false;
    while (at && strncmp(at, ENTRY, strlen(ENTRY)) != 0)
        at = (at = strchr(at, '|')) ? at + 1 : NULL;
    memset(out, 0, VV_LABEL_CODES * sizeof *out);
    if (at)
        at += strlen(ENTRY);
    for (int part = 0; at; part++) {
        const size_t n = strcspn(at, "~|");
        for (int c = 0; c < VV_LABEL_CODES; c++)
            if (part_of[c] == part) {
                parse_code(&out[c], at, n);
                any |= out[c].value[0] || out[c].meaning[0];
            }
        at = at[n] == '~' ? at + n + 1 : NULL;
    }
    return any;
}

/* Marks that would end it go. */
static void add_text(vvi_text *t, const char *text)
{
    for (; *text; text++)
        if (!strchr("~^|\n\r", *text))
            vvi_text_add_n(t, text, 1);
}

void vvi_nrrd_add_tags(vvi_text *t, const vv_code codes[VV_LABEL_CODES])
{
    for (int part = 0, c = 0; part < 7; part++) {
        vvi_text_add(t, part ? "~" : ENTRY "Segmentation category and type - DICOM master list");
        if (part == 4)
            vvi_text_add(t, "Anatomic codes - DICOM master list");
        if (part_of[c] != part)
            continue;
        add_text(t, codes[c].scheme);
        vvi_text_add(t, "^");
        add_text(t, codes[c].value);
        vvi_text_add(t, "^");
        add_text(t, codes[c++].meaning);
    }
    vvi_text_add(t, "|");
}

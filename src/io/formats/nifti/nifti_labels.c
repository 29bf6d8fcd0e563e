/* Tables of labels. AFNI: afni.nimh.nih.gov, README.attributes, VALUE_LABEL_DTABLE. Caret: the LabelTable of GIFTI
 * (www.nitrc.org/projects/gifti), as Connectome Workbench keeps it in NIfTI volumes. */
#include "io/formats/nifti/nifti_labels.h"
#include "grid/label_id.h"
#include "io/scan.h"
#include <inttypes.h>
#include <string.h>
#include <volvis/image.h>

/* XML ------------------------------------------------------------------------------------------------------------- */

static size_t add_utf8(char *to, uint64_t c)
{
    const size_t n = c < 0x80 ? 1 : c < 0x800 ? 2 : c < 0x10000 ? 3 : 4;
    static const uint8_t first[] = {0, 0, 0xc0, 0xe0, 0xf0};
    for (size_t i = n; i-- > 1; c >>= 6)
        to[i] = (char)(0x80 | (c & 0x3f));
    to[0] = (char)(first[n] | c);
    return n;
}

/* "&#65;", "&#x41;": bytes of it that count, 0 when it is none. The text is never longer than what stood there. */
static size_t decode_number(char *to, size_t *n_to, const char *from)
{
    const bool hex = from[2] == 'x' || from[2] == 'X';
    const char *digits = from + 2 + hex;
    const size_t n = strspn(digits, hex ? "0123456789abcdefABCDEF" : "0123456789");
    uint64_t c = 0;
    for (size_t i = 0; i < n && c < 0x110000; i++) {
        const char d = digits[i];
        const unsigned value = d <= '9' ? (unsigned)(d - '0') : ((unsigned)d | 32) - 'a' + 10;
        c = c * (hex ? 16 : 10) + value;
    }
    if (n == 0 || digits[n] != ';' || c == 0 || c >= 0x110000)
        return 0;
    *n_to = add_utf8(to, c);
    return (size_t)(digits - from) + n + 1;
}

/* Entities become what they stand for, in place. */
static void decode(char *text)
{
    static const char *const names[] = {"&lt;", "&gt;", "&quot;", "&apos;", "&amp;"};
    char *to = text;
    for (const char *from = text; *from;) {
        size_t n = 0, n_to = 1;
        if (from[0] == '&' && from[1] == '#')
            n = decode_number(to, &n_to, from);
        for (size_t i = 0; i < 5 && n == 0 && *from == '&'; i++)
            if (strncmp(from, names[i], strlen(names[i])) == 0) {
                *to = "<>\"'&"[i];
                n = strlen(names[i]);
            }
        if (n == 0)
            *to = from[n++];
        from += n;
        to += n_to;
    }
    *to = 0;
}

static void copy_name(char out[64], const char *text, size_t n)
{
    n = vvi_utf8_cut(text, n, 63);
    memcpy(out, text, n);
    out[n] = 0;
    vvi_text_clean(out);
}

/* A label that stands there twice keeps its first name. */
static vv_status note(vv_notes *notes, const vv_label *label)
{
    size_t n;
    const vv_label *known = vvi_notes_labels(notes, &n);
    for (size_t i = n; i-- > 0 && known[n - 1].value >= label->value;)
        if (known[i].value == label->value)
            return VV_OK;
    return vvi_notes_label(notes, label);
}

/* AFNI ------------------------------------------------------------------------------------------------------------ */

/* A word, or what stands between quotes; NULL at the end of the table. */
static char *next_word(char **rest)
{
    char *at = *rest + strspn(*rest, " \t\r\n"), *end;
    if (*at == 0 || *at == '<')
        return NULL;
    if (*at == '"' || *at == '\'') {
        if (!(end = strchr(at + 1, *at)))
            return NULL;
        at++;
    } else {
        end = at + strcspn(at, " \t\r\n<");
    }
    *rest = *end && *end != '<' ? end + 1 : end;
    if (*end != '<')
        *end = 0;
    return at;
}

vv_status vvi_nifti_afni_labels(char *text, vv_notes *notes)
{
    char *attribute = strstr(text, "atr_name=\"VALUE_LABEL_DTABLE\""), *value, *name;
    vv_status st = VV_OK;
    if (!attribute || !(attribute = strchr(attribute, '>')))
        return VV_OK;
    char *end = strstr(attribute, "</AFNI_atr");
    if (end)
        *end = 0;
    decode(attribute); /* the table is an element inside the string of an element */
    char *table = strstr(attribute, "<VALUE_LABEL_DTABLE");
    if (!table || !(table = strchr(table, '>')))
        return VV_OK;
    for (char *rest = table + 1; st == VV_OK && (value = next_word(&rest)) && (name = next_word(&rest));) {
        vv_label label = {0};
        const char *after;
        if (!vvi_scan_label(&label.value, value, &after) || *after)
            continue;
        decode(name);
        copy_name(label.name, name, strlen(name));
        st = note(notes, &label);
    }
    return st;
}

/* Caret ----------------------------------------------------------------------------------------------------------- */

/* NAME="value" among the attributes before `end`. */
static const char *attribute(const char *from, const char *end, const char *name)
{
    const size_t n = strlen(name);
    for (; from < end; from++)
        if ((from[0] == ' ' || from[0] == '\n' || from[0] == '\t' || from[0] == '\r') && (size_t)(end - from) > n + 2 &&
            strncmp(from + 1, name, n) == 0 && from[n + 1] == '=' && (from[n + 2] == '"' || from[n + 2] == '\''))
            return from + n + 3;
    return NULL;
}

static bool color_of(vv_color *out, const char *from, const char *end)
{
    static const char *const names[] = {"Red", "Green", "Blue", "Alpha"};
    double c[4] = {0, 0, 0, 1};
    for (int i = 0; i < 4; i++) {
        const char *text = attribute(from, end, names[i]), *after;
        const bool there = text && vvi_scan_real(&c[i], text, &after);
        if ((!there && i < 3) || !(c[i] >= 0 && c[i] <= 1))
            return false;
    }
    *out = (vv_color){vv_srgb_decode(c[0]), vv_srgb_decode(c[1]), vv_srgb_decode(c[2]), c[3]};
    return true;
}

static void name_of(char out[64], char *text, char *end)
{
    static const char open[] = "<![CDATA[";
    *end = 0;
    char *data = strstr(text, open), *close = data ? strstr(data, "]]>") : NULL;
    if (close) {
        copy_name(out, data + strlen(open), (size_t)(close - data) - strlen(open));
        return;
    }
    decode(text);
    text += strspn(text, " \t\r\n");
    size_t n = strlen(text);
    while (n > 0 && strchr(" \t\r\n", text[n - 1]))
        n--;
    copy_name(out, text, n);
}

vv_status vvi_nifti_caret_labels(char *text, vv_notes *notes)
{
    char *at = strstr(text, "<LabelTable"), *last = at ? strstr(at, "</LabelTable") : NULL;
    vv_status st = VV_OK;
    while (st == VV_OK && at && last && (at = strstr(at + 1, "<Label ")) && at < last) {
        vv_label label = {0};
        char *inside = strchr(at, '>'), *end = strstr(at, "</Label>");
        if (!inside || !end || end > last || end < inside)
            break;
        const char *key = attribute(at, inside, "Key"), *after;
        label.has_color = color_of(&label.color, at, inside);
        name_of(label.name, inside + 1, end);
        if (key && vvi_scan_label(&label.value, key, &after))
            st = note(notes, &label);
        at = end; /* where the text may end now: the table goes on behind it */
    }
    return st;
}

static void add_escaped(vvi_text *t, const char *name)
{
    for (; *name; name++)
        switch (*name) {
        case '<':
            vvi_text_add(t, "&lt;");
            break;
        case '>':
            vvi_text_add(t, "&gt;");
            break;
        case '&':
            vvi_text_add(t, "&amp;");
            break;
        default:
            vvi_text_add_n(t, name, 1);
        }
}

static double clamp(double v)
{
    return v > 0 ? v < 1 ? v : 1 : 0;
}

void vvi_nifti_add_caret_labels(vvi_text *t, const vv_label *labels, size_t n, bool is_unsigned)
{
    char digits[VVI_LABEL_DIGITS];
    vvi_text_add(t, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<CaretExtension>\n<VolumeInformation Index=\"0\">\n"
                    "<LabelTable>\n");
    for (size_t i = 0; i < n; i++) {
        const vv_color c = labels[i].color;
        vvi_text_printf(t, "<Label Key=\"%s\"", vvi_label_print(digits, labels[i].value, is_unsigned));
        if (labels[i].has_color)
            vvi_text_printf(t, " Red=\"%.6g\" Green=\"%.6g\" Blue=\"%.6g\" Alpha=\"%.6g\"", clamp(vv_srgb_encode(c.r)),
                            clamp(vv_srgb_encode(c.g)), clamp(vv_srgb_encode(c.b)), clamp(c.a));
        vvi_text_add(t, ">");
        add_escaped(t, labels[i].name);
        vvi_text_add(t, "</Label>\n");
    }
    vvi_text_add(t, "</LabelTable>\n<VolumeType>Label</VolumeType>\n</VolumeInformation>\n</CaretExtension>\n");
}

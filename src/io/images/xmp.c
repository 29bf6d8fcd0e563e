/* Keys are XML names as far as they can be; all other bytes of them are "_" and two hexadecimal digits. */
#include "io/images/xmp.h"

#include "core/job.h"
#include "core/memory.h"
#include "io/images/image_text.h"
#include "io/xml.h"

#include <stdlib.h>
#include <string.h>

#define TEXTS_MOST 1000
#define NAME_MOST 512
#define OURS "VolVis:"

/* Writing --------------------------------------------------------------------------------------------------------- */

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static void add_name(vvi_text *out, const char *key)
{
    const bool ours = strncmp(key, OURS, strlen(OURS)) == 0;
    vvi_text_add(out, ours ? "volvis:" : "text:");
    if (ours)
        key += strlen(OURS);
    for (const char *c = key; *c; c++) {
        if (is_letter(*c) || (c > key && *c >= '0' && *c <= '9'))
            vvi_text_add_n(out, c, 1);
        else
            vvi_text_printf(out, "_%02x", (unsigned char)*c);
    }
}

static void add_value(vvi_text *out, const char *s)
{
    while (*s) {
        const size_t n = vvi_utf8_length(s);
        if (*s == '<')
            vvi_text_add(out, "&lt;");
        else if (*s == '&')
            vvi_text_add(out, "&amp;");
        else if (*s == '>')
            vvi_text_add(out, "&gt;");
        else if (*s == '\r')
            vvi_text_add(out, "&#13;"); /* else it is read as the end of a line */
        else if (n == 0 || (n == 1 && *s < ' ' && *s != '\n' && *s != '\t'))
            vvi_text_add(out, "\xef\xbf\xbd");
        else
            vvi_text_add_n(out, s, n);
        s += n > 0 ? n : 1;
    }
}

void vvi_xmp_write(vvi_text *out, const vv_text *text, size_t n_text)
{
    if (n_text == 0)
        return;
    vvi_text_add(out, "<?xpacket begin=\"\xef\xbb\xbf\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
                      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
                      "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
                      "<rdf:Description rdf:about=\"\" xmlns:volvis=\"urn:volvis:picture\" "
                      "xmlns:text=\"urn:volvis:text\">\n");
    for (size_t i = 0; i < n_text; i++) {
        vvi_text name = {0};
        add_name(&name, text[i].key);
        vvi_text_printf(out, "<%s>", name.s ? name.s : "");
        add_value(out, text[i].value);
        vvi_text_printf(out, "</%s>\n", name.s ? name.s : "");
        out->bad = out->bad || name.bad;
        vvi_text_free(&name);
    }
    vvi_text_add(out, "</rdf:Description>\n</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"r\"?>");
}

/* Reading --------------------------------------------------------------------------------------------------------- */

typedef struct reading {
    vv_text *text;
    size_t n_text, held; /* held: bytes of all texts */
    char *key;           /* of the open property; NULL: none is */
    int depth;           /* of it */
    vvi_text value;
} reading;

static int hex(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* NULL of what is no property of ours, and without memory. */
static char *key_of(const char *name)
{
    const bool ours = strncmp(name, "volvis:", 7) == 0;
    if ((!ours && strncmp(name, "text:", 5) != 0) || strlen(name) > NAME_MOST)
        return NULL;
    name += ours ? 7 : 5;
    char *key = vvi_asprintf("%s%s", ours ? OURS : "", name), *to = key ? key + (ours ? strlen(OURS) : 0) : NULL;
    for (; key && *name; name++) {
        const int high = *name == '_' ? hex(name[1]) : -1, low = high >= 0 ? hex(name[2]) : -1;
        if (low >= 0 && high + low > 0) {
            *to++ = (char)(high << 4 | low);
            name += 2;
        } else {
            *to++ = *name;
        }
    }
    if (key)
        *to = 0;
    return key;
}

/* Takes the key. What goes beyond the limits is left out. */
static vv_status add(reading *r, char *key, const char *value)
{
    const size_t n = strlen(value);
    if (r->n_text >= TEXTS_MOST || n > VVI_XMP_MOST - r->held) {
        free(key);
        return VV_OK;
    }
    char *copy = vvi_text_utf8(value, n);
    vv_text *more = copy ? vvi_realloc_plain(r->text, (r->n_text + 1) * sizeof *more) : NULL;
    if (!more) {
        free(key);
        free(copy);
        return vv_fail_memory(n);
    }
    r->text = more;
    r->text[r->n_text++] = (vv_text){key, copy};
    r->held += n;
    return VV_OK;
}

/* A property is an element of its own or, as some programs put it when they save, an attribute of the description. */
static vv_status on_open(void *user, vvi_xml *xml, const char *name, const char *const *attributes)
{
    reading *r = user;
    vv_status st = VV_OK;
    if (strcmp(name, "rdf:Description") == 0) {
        for (; *attributes && st == VV_OK; attributes += 2) {
            char *key = key_of(attributes[0]);
            if (key)
                st = add(r, key, attributes[1]);
        }
    } else if (!r->key && (r->key = key_of(name)) != NULL) {
        r->depth = vvi_xml_depth(xml);
    }
    return st;
}

static vv_status on_text(void *user, vvi_xml *xml, const char *text, size_t n)
{
    reading *r = user;
    if (!r->key || vvi_xml_depth(xml) != r->depth || r->value.n + n > VVI_XMP_MOST)
        return VV_OK;
    vvi_text_add_n(&r->value, text, n);
    return r->value.bad ? vv_fail_memory(n) : VV_OK;
}

static vv_status on_close(void *user, vvi_xml *xml, const char *name)
{
    reading *r = user;
    (void)name;
    if (!r->key || vvi_xml_depth(xml) != r->depth)
        return VV_OK;
    const vv_status st = add(r, r->key, r->value.s ? r->value.s : "");
    r->key = NULL;
    vvi_text_cut(&r->value, 0);
    return st;
}

vv_status vvi_xmp_read(vv_text **text_out, size_t *n_text_out, vv_source *packet, vv_job *job)
{
    static const vvi_xml_events events = {on_open, on_close, on_text};
    reading r = {0};
    bool cut = false;
    *text_out = NULL;
    *n_text_out = 0;
    const vv_status st = vvi_xml_parse(&cut, packet, &events, &r, job);
    free(r.key);
    vvi_text_free(&r.value);
    if (st != VV_OK) {
        vv_text_free(r.text, r.n_text);
        return st;
    }
    *text_out = r.text;
    *n_text_out = r.n_text;
    return VV_OK;
}

vv_status vvi_xmp_read_memory(vv_text **text_out, size_t *n_text_out, const void *packet, size_t n, const char *name,
                              vv_job *job)
{
    vv_source *source;
    *text_out = NULL;
    *n_text_out = 0;
    vv_status st = vvi_source_memory(&source, packet, n < VVI_XMP_MOST ? n : VVI_XMP_MOST, name, job);
    if (st != VV_OK)
        return st;
    st = vvi_xmp_read(text_out, n_text_out, source, job);
    vvi_source_close(source);
    return st;
}

/* NumPy's .npy, versions 1 to 3: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
 *
 * Axes are taken as Python programs index volumes, [z, y, x]:
 *   (y, x)   (z, y, x)   (t, z, y, x)   (t, z, y, x, c)
 * and, for 8-bit samples whose last axis has 3 or 4 entries, as colours:   (y, x, c)   (z, y, x, c)
 * Four axes of which the last has at most 4 entries, and no other has, are (z, y, x, c). A part says it otherwise: a
 * letter for each axis, "czyx". What we write is never in doubt: where a shape could be taken for another, it gets more
 * axes. */
#include "io/formats/npy/npy.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include "registry.h"
#include <ctype.h>
#include <inttypes.h>
#include <string.h>

static const uint8_t magic[] = {0x93, 'N', 'U', 'M', 'P', 'Y'};

/* An array by itself. */
typedef struct npy {
    vvi_npy array;
    bool mappable;
} npy;

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return n >= 10 && memcmp(head, magic, sizeof magic) == 0 ? 2 : 0;
}

/* The header is a Python dictionary; only what numpy writes is understood --------------------------------------------
 */

static const char *blanks(const char *at)
{
    return at + strspn(at, " \t\n");
}

/* The value of a key, or NULL. Keys are looked for at the outermost level only: values hold no colon but in structured
 * types, which are refused before. */
static const char *find_value(const char *text, const char *key)
{
    const size_t n = strlen(key);
    for (const char *at = text; (at = strstr(at, key)) != NULL; at += n) {
        const char quote = at > text ? at[-1] : 0;
        if ((quote != '\'' && quote != '"') || at[n] != quote)
            continue;
        const char *colon = blanks(at + n + 1);
        if (*colon == ':')
            return blanks(colon + 1);
    }
    return NULL;
}

static vv_status parse_type(vvi_npy *p, const char *text, const char *name)
{
    const char *at = find_value(text, "descr"), *end;
    int64_t bytes;
    if (!at)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its header has no 'descr'");
    if (*at == '[')
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "its elements are structures; save one of their fields by itself");
    const char quote = *at;
    if (quote != '\'' && quote != '"')
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its 'descr' is not text");
    at++;
    p->order = strchr("<>|=", *at) && *at ? *at++ : '=';
    p->letter = *at;
    if (p->letter == 'O')
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "holds Python objects, which are never loaded; save numbers");
    if (!*at || !vvi_scan_int(&bytes, at + 1, &end) || *end != quote || bytes < 1 || bytes > 64)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its 'descr' '%.20s' is not a type of numbers", at);
    p->bytes = (int)bytes;
    return VV_OK;
}

static vv_status choose_type(vvi_npy *p, const char *name)
{
    static const struct {
        char letter;
        int bytes;
        vv_type type;
        bool half;
    } types[] = {
        {'b', 1, VV_TYPE_U8, false},  {'u', 1, VV_TYPE_U8, false},  {'i', 1, VV_TYPE_I8, false},
        {'u', 2, VV_TYPE_U16, false}, {'i', 2, VV_TYPE_I16, false}, {'u', 4, VV_TYPE_U32, false},
        {'i', 4, VV_TYPE_I32, false}, {'u', 8, VV_TYPE_U64, false}, {'i', 8, VV_TYPE_I64, false},
        {'f', 4, VV_TYPE_F32, false}, {'f', 8, VV_TYPE_F64, false}, {'f', 2, VV_TYPE_F32, true},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].letter == p->letter && types[i].bytes == p->bytes) {
            const uint16_t one = 1;
            const bool machine_big = *(const uint8_t *)&one == 0;
            p->layout.type = types[i].type;
            p->layout.half = types[i].half;
            p->layout.swap = p->bytes > 1 && (p->order == '>' || p->order == '<') && (p->order == '>') != machine_big;
            return VV_OK;
        }
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "its elements are of type '%c%d'; integers and floats of 1 to 8 bytes "
                      "and booleans can be shown",
                      isprint((unsigned char)p->letter) ? p->letter : '?', p->bytes);
}

static vv_status parse_order(vvi_npy *p, const char *text, const char *name)
{
    const char *at = find_value(text, "fortran_order");
    if (at && strncmp(at, "True", 4) == 0)
        p->fortran = true;
    else if (!at || strncmp(at, "False", 5) != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its header has no 'fortran_order' that is True or False");
    return VV_OK;
}

static vv_status parse_shape(vvi_npy *p, const char *text, const char *name, const vv_limits *limits)
{
    const char *at = find_value(text, "shape");
    if (!at || *at != '(')
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its header has no 'shape'");
    for (at = blanks(at + 1); *at != ')'; at = blanks(at)) {
        int64_t n;
        if (!vvi_scan_int(&n, at, &at) || n < 1 || n > (int64_t)limits->dim)
            return vv_fail_at(VV_E_FORMAT, name, NULL,
                              "axis %d of its 'shape' is not a number from 1 to %llu (--limit dim=N allows more)",
                              p->n_shape + 1, (unsigned long long)limits->dim);
        if (p->n_shape == 5)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has more than 5 axes; (t, z, y, x, c) is the most");
        p->shape[p->n_shape++] = n;
        at = blanks(at);
        if (*at == ',')
            at++;
        else if (*at != ')')
            return vv_fail_at(VV_E_FORMAT, name, NULL, "its 'shape' is not closed");
    }
    return p->n_shape >= 1 ? VV_OK : vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "holds one number and no axes");
}

/* Axes ------------------------------------------------------------------------------------------------------------- */

static bool is_byte(const vvi_npy *p)
{
    return p->layout.type == VV_TYPE_U8 && p->letter == 'u';
}

/* Images are no 4 samples wide where all that lies around is larger. */
static bool has_few_last(const vvi_npy *p)
{
    const int n = p->n_shape;
    bool larger = true;
    for (int i = 0; i < n - 1; i++)
        larger = larger && p->shape[i] > 4;
    return p->shape[n - 1] == 1 || (p->shape[n - 1] <= 4 && larger);
}

static const char *roles_of(const vvi_npy *p)
{
    const int64_t last = p->shape[p->n_shape - 1];
    const bool colour = is_byte(p) && (last == 3 || last == 4);
    switch (p->n_shape) {
    case 1:
        return "x";
    case 2:
        return "yx";
    case 3:
        return colour ? "yxc" : "zyx";
    case 4:
        return colour || has_few_last(p) ? "zyxc" : "tzyx";
    default:
        return "tzyxc";
    }
}

static const char letters[] = "cxyzt"; /* of axes, as vvi_role counts */

/* A letter for each axis, none twice. */
static bool is_order(const char *text, int n)
{
    for (int i = 0; i < n; i++)
        if (!text[i] || !strchr(letters, text[i]) || memchr(text, text[i], (size_t)i))
            return false;
    return text[n] == 0;
}

/* Shapes that may be meant in another way have their ways as parts. */
static vv_status choose_roles(const char **out, const vvi_npy *p, const char *part, const char *name, vv_notes *notes)
{
    static const char *const ways[6][4] = {{NULL},
                                           {NULL},
                                           {NULL},
                                           {"zyx", "yxc", "tyx", NULL},
                                           {"tzyx", "zyxc", "czyx", NULL},
                                           {"tzyxc", "tczyx", "ctzyx", NULL}};
    const char *guess = roles_of(p);
    vv_status st = VV_OK;
    *out = part ? part : guess;
    if (part && !is_order(part, p->n_shape))
        return vv_fail_at(VV_E_NOT_FOUND, name, NULL,
                          "has no part '%.60s': it is one array of %d axes; a part names them, with a letter of t, z, "
                          "y, x, c for each, such as '%s'",
                          part, p->n_shape, guess);
    if (!notes || (!part && p->n_shape < 4 && strcmp(guess, "yxc") != 0))
        return VV_OK;
    bool listed = false;
    for (const char *const *way = ways[p->n_shape]; *way && st == VV_OK; way++) {
        const bool chosen = strcmp(*way, *out) == 0;
        st = vvi_notes_part(notes, *way, "order of axes", chosen);
        listed |= chosen;
    }
    return st == VV_OK && !listed ? vvi_notes_part(notes, *out, "order of axes", true) : st;
}

static void place_axes(vv_field_info *info, vvi_npy *p, const char *roles)
{
    p->layout.n_axes = p->n_shape;
    for (int i = 0; i < p->n_shape; i++) {
        const int at = p->fortran ? i : p->n_shape - 1 - i;
        const vvi_role role = (vvi_role)(strchr(letters, roles[i]) - letters);
        p->layout.axis[at] = (vvi_layout_axis){p->shape[i], role};
        if (role == VVI_ROLE_COMPONENT)
            info->components = (int)p->shape[i];
        else if (role == VVI_ROLE_FRAME)
            info->n_frames = p->shape[i];
        else
            info->grid.dims[role - VVI_ROLE_X] = p->shape[i];
    }
    info->type = p->layout.type;
    if (is_byte(p) && info->components == 3)
        info->meaning = VV_MEANING_RGB;
    if (is_byte(p) && info->components == 4)
        info->meaning = VV_MEANING_RGBA;
}

/* Reading ------------------------------------------------------------------------------------------------------------
 */

/* The dictionary's text, yours to vvi_free(). */
static vv_status read_text(char **out, uint64_t *offset, vv_source *source, vv_job *job)
{
    uint8_t head[12];
    const char *name = vvi_source_name(source);
    *out = NULL;
    vv_status st = vvi_source_read(source, head, 10, "the .npy header");
    if (st != VV_OK)
        return st;
    if (memcmp(head, magic, sizeof magic) != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is not a .npy file: it does not begin with \\x93NUMPY");
    if (head[6] < 1 || head[6] > 3)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "is of .npy version %d.%d; 1, 2 and 3 are known", head[6],
                          head[7]);
    size_t n = (size_t)head[8] | (size_t)head[9] << 8;
    if (head[6] > 1) {
        if ((st = vvi_source_read(source, head + 10, 2, "the .npy header")) != VV_OK)
            return st;
        n |= (size_t)head[10] << 16 | (size_t)head[11] << 24;
    }
    *offset = vvi_source_tell(source) + n;
    if (n > vvi_job_limits(job)->string_bytes)
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "its header has %zu bytes; at most %llu are read (--limit string_bytes=N allows more)", n,
                          (unsigned long long)vvi_job_limits(job)->string_bytes);
    if ((st = vvi_source_expect(source, vvi_source_tell(source), n, "the .npy header")) != VV_OK)
        return st;
    char *text = vvi_alloc(job, n + 1, VVI_MEM_SCRATCH);
    if (!text)
        return vv_fail_memory(n + 1);
    st = vvi_source_read(source, text, n, "the .npy header");
    text[n] = 0;
    if (st != VV_OK)
        vvi_free(text);
    else
        *out = text;
    return st;
}

static vv_status parse(vvi_npy *p, const char *text, const char *name, const vv_limits *limits)
{
    vv_status st = parse_type(p, text, name);
    if (st != VV_OK || (st = choose_type(p, name)) != VV_OK || (st = parse_order(p, text, name)) != VV_OK)
        return st;
    return parse_shape(p, text, name, limits);
}

vv_status vvi_npy_parse(vvi_npy *p, vv_source *source, vv_job *job)
{
    char *text;
    *p = (vvi_npy){0};
    vv_status st = read_text(&text, &p->offset, source, job);
    if (st != VV_OK)
        return st;
    st = parse(p, text, vvi_source_name(source), vvi_job_limits(job));
    vvi_free(text);
    return st;
}

vv_status vvi_npy_place(vv_field_info *info, vvi_npy *p, const char *axes, const char *name, vv_notes *notes)
{
    const char *roles;
    vv_status st = choose_roles(&roles, p, axes, name, notes);
    if (st == VV_OK)
        place_axes(info, p, roles);
    return st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    const char *name = vvi_source_name(source);
    npy p = {0};
    uint64_t n;
    *plan_out = NULL;
    vv_status st = vvi_npy_parse(&p.array, source, job);
    if (st != VV_OK || (st = vvi_npy_place(info, &p.array, options->part, name, notes)) != VV_OK)
        return st;
    const uint64_t offset = p.array.offset, bytes = (uint64_t)p.array.bytes;
    if ((st = vvi_layout_count(&n, &p.array.layout, name)) != VV_OK ||
        (st = vvi_source_expect_half(source, offset, n * bytes, "samples")) != VV_OK)
        return st;
    p.mappable = vvi_layout_mappable(&p.array.layout, offset) && vvi_source_mappable(source, offset, n * bytes);
    npy *plan = vvi_alloc(job, sizeof *plan, VVI_MEM_MODEL);
    if (!plan)
        return vv_fail_memory(sizeof *plan);
    *plan = p;
    *plan_out = plan;
    return VV_OK;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const npy *p = plan;
    return vvi_layout_read_plain(out, info, &p->array.layout, source, p->array.offset, frame, region, job);
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const npy *)plan)->mappable;
}

static void free_plan(void *plan)
{
    vvi_free(plan);
}

/* Writing ------------------------------------------------------------------------------------------------------------
 */

/* The shortest shape that is read back as the same. */
static void add_shape(vvi_text *t, const vv_field_info *info, size_t n_frames)
{
    const int64_t *n = info->grid.dims;
    const int c = info->components;
    const bool byte = info->type == VV_TYPE_U8, colour = byte && (c == 3 || c == 4);
    const bool like_colour = byte && (n[0] == 3 || n[0] == 4);
    const bool five = (c > 1 && !colour) || (n_frames > 1 && (c > 1 || n[0] <= 4));
    if (five)
        vvi_text_printf(t, "(%zu, %" PRId64 ", %" PRId64 ", %" PRId64 ", %d)", n_frames, n[2], n[1], n[0], c);
    else if (n_frames > 1)
        vvi_text_printf(t, "(%zu, %" PRId64 ", %" PRId64 ", %" PRId64 ")", n_frames, n[2], n[1], n[0]);
    else if (colour || like_colour)
        vvi_text_printf(t, "(%" PRId64 ", %" PRId64 ", %" PRId64 ", %d)", n[2], n[1], n[0], c);
    else
        vvi_text_printf(t, "(%" PRId64 ", %" PRId64 ", %" PRId64 ")", n[2], n[1], n[0]);
}

vv_status vvi_npy_add_header(vvi_text *t, const vv_field_info *info, size_t n_frames, bool big_endian, size_t before)
{
    static const char *const types[VV_TYPE_COUNT] = {"u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"};
    const char order = vv_type_bytes(info->type) == 1 ? '|' : big_endian ? '>' : '<';
    vvi_text_add_n(t, "\x93NUMPY\1\0\0\0", 10);
    vvi_text_printf(t, "{'descr': '%c%s', 'fortran_order': False, 'shape': ", order, types[info->type]);
    add_shape(t, info, n_frames);
    vvi_text_add(t, ", }");
    while ((before + t->n + 1) % 64 != 0 && !t->bad)
        vvi_text_add(t, " ");
    vvi_text_add(t, "\n");
    if (t->bad)
        return vv_fail_memory(t->n);
    t->s[8] = (char)(t->n - 10);
    t->s[9] = (char)((t->n - 10) >> 8);
    return VV_OK;
}

static vv_status write_field(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    vvi_text t = {0};
    vvi_log_loss(sink, info, n_frames, "npy", job);
    vvi_log_lost_names(sink, options, 0, "npy", job);
    vv_status st = vvi_npy_add_header(&t, info, n_frames, options->big_endian, 0);
    if (st == VV_OK)
        st = vvi_sink_write(sink, t.s, t.n);
    vvi_text_free(&t);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++)
        st = vvi_samples_write(sink, frames[f], -1, options->big_endian, job);
    return st;
}

static const char *const suffixes[] = {".npy", NULL};
static const char *const encodings[] = {"raw", NULL};

const vv_format vvi_format_npy = {
    .api = VV_FORMAT_API,
    .name = "npy",
    .doc = "NumPy arrays, axes as in Python: z, y, x; FILE:czyx gives other axes",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
    .write = write_field,
};

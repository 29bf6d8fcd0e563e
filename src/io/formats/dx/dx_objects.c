/* The objects of a .dx file, word by word. */
#include "io/formats/dx/dx_objects.h"
#include "core/memory.h"
#include "io/number_text.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define LINE_MOST ((size_t)64 << 10)

typedef struct parser {
    vv_source *source;
    vv_job *job;
    char *line; /* a copy: the source keeps its own only until the next */
    size_t room, at, n;
    bool end, ended; /* of the file; an "end" was read */
    char word[VVI_DX_WORD];
    bool pushed;           /* the word was not wanted: it comes again */
    bool text, big_endian; /* of arrays that do not say */
    vvi_dx_object *object;
    size_t n_objects, object_room;
} parser;

static vv_status fail_word(const parser *p, const char *text)
{
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(p->source), NULL, "expected %s, found '%.60s'%s", text,
                      p->end ? "the end" : p->word, p->end ? "; the file is cut short" : "");
}

static vv_status next_line(parser *p)
{
    const char *line;
    vv_status st = vvi_source_line(p->source, &line, LINE_MOST, &p->end);
    if (st != VV_OK)
        return st;
    p->at = 0;
    p->n = strlen(line);
    if (p->n + 1 > p->room) {
        char *bigger = vvi_realloc(p->job, p->line, p->n + 1, VVI_MEM_SCRATCH);
        if (!bigger)
            return vv_fail_memory(p->n + 1);
        p->line = bigger;
        p->room = p->n + 1;
    }
    memcpy(p->line, line, p->n + 1);
    return VV_OK;
}

/* The next word into p->word, quoted ones without their quotes; "" at the end. */
static vv_status next(parser *p)
{
    if (p->pushed) {
        p->pushed = false;
        return VV_OK;
    }
    p->word[0] = 0;
    while (!p->end) {
        if (p->line && p->at < p->n)
            p->at += strspn(p->line + p->at, " \t\r\f\v,");
        if (p->line && p->at < p->n && p->line[p->at] != '#')
            break;
        vv_status st = next_line(p);
        if (st != VV_OK)
            return st;
    }
    if (p->end)
        return VV_OK;
    const bool quoted = p->line[p->at] == '"';
    p->at += quoted;
    const size_t n = strcspn(p->line + p->at, quoted ? "\"" : " \t\r\f\v,");
    if (n >= VVI_DX_WORD)
        return fail_word(p, "a shorter word");
    memcpy(p->word, p->line + p->at, n);
    p->word[n] = 0;
    p->at += n + (quoted && p->at + n < p->n);
    return VV_OK;
}

static bool is(const parser *p, const char *word)
{
    return !p->end && strcasecmp(p->word, word) == 0;
}

static vv_status next_int(parser *p, int64_t *out, int64_t lo, int64_t hi, const char *what)
{
    const char *end;
    vv_status st = next(p);
    if (st != VV_OK)
        return st;
    return vvi_scan_int(out, p->word, &end) && !*end && *out >= lo && *out <= hi ? VV_OK : fail_word(p, what);
}

static vv_status next_real(parser *p, double *out)
{
    const char *end;
    vv_status st = next(p);
    if (st != VV_OK)
        return st;
    return vvi_scan_real(out, p->word, &end) && !*end && isfinite(*out) ? VV_OK : fail_word(p, "a finite number");
}

/* gridpositions ------------------------------------------------------------------------------------------------------
 */

/* "counts 4 5 6 origin 0 0 0 delta 1 0 0 delta 0 1 0 delta 0 0 1" */
static vv_status read_grid(parser *p, vvi_dx_object *o)
{
    vv_status st = next(p);
    int n_deltas = 0;
    const char *end;
    if (st == VV_OK && !is(p, "counts"))
        st = fail_word(p, "'counts'");
    while (st == VV_OK && (st = next(p)) == VV_OK && o->grid.n_axes < 3 &&
           vvi_scan_int(&o->grid.n[o->grid.n_axes], p->word, &end) && !*end && !p->end) {
        if (o->grid.n[o->grid.n_axes] < 1 || o->grid.n[o->grid.n_axes] > INT32_MAX)
            return fail_word(p, "a count of at least 1");
        o->grid.n_axes++;
    }
    const int n = o->grid.n_axes;
    if (st == VV_OK && n == 0)
        st = fail_word(p, "1 to 3 counts");
    for (int a = 0; a < n && a < 3; a++)
        o->grid.delta[a][a] = 1;
    while (st == VV_OK && (is(p, "origin") || is(p, "delta"))) {
        const bool origin = is(p, "origin");
        if (!origin && n_deltas == n)
            return fail_word(p, "as many deltas as counts");
        double *to = origin ? o->grid.origin : o->grid.delta[n_deltas++];
        for (int k = 0; k < n && st == VV_OK; k++)
            st = next_real(p, &to[k]);
        if (st == VV_OK)
            st = next(p);
    }
    p->pushed = st == VV_OK && !p->end;
    return st;
}

/* arrays -------------------------------------------------------------------------------------------------------------
 */

static bool set_mode(const parser *p, bool *text, bool *big_endian)
{
    if (is(p, "text") || is(p, "ascii"))
        *text = true;
    else if (is(p, "ieee") || is(p, "binary") || is(p, "xdr"))
        *text = false;
    else if (is(p, "msb") || is(p, "lsb")) {
        *text = false;
        *big_endian = is(p, "msb");
    } else {
        return false;
    }
    return true;
}

/* Data that follow begin on the next line; they are passed over. */
static vv_status pass_data(parser *p, vvi_dx_object *o)
{
    vvi_number_text *numbers;
    uint64_t got;
    o->follows = true;
    o->offset = vvi_source_tell(p->source);
    p->n = p->at = 0;
    const uint64_t n = (uint64_t)o->items * (uint64_t)o->components;
    if (!o->text) {
        bool exact;
        const uint64_t bytes = n * (o->has_type ? vv_type_bytes(o->type) : 1),
                       left = vvi_source_left(p->source, &exact);
        return vvi_source_seek(p->source, o->offset + (bytes < left ? bytes : left));
    }
    vv_status st = vvi_number_text_open(&numbers, p->source, o->offset, UINT64_MAX, VV_TYPE_F64, p->job);
    if (st != VV_OK)
        return st;
    st = vvi_number_text_skip(numbers, n, &got);
    const uint64_t end = vvi_number_text_tell(numbers);
    vvi_number_text_close(numbers);
    return st == VV_OK ? vvi_source_seek(p->source, end) : st;
}

/* "data follows", "data 1234", "data file name 1234" */
static vv_status read_data(parser *p, vvi_dx_object *o)
{
    vv_status st = next(p);
    const char *end;
    if (st != VV_OK || is(p, "follows"))
        return st == VV_OK ? pass_data(p, o) : st;
    if (is(p, "file")) {
        if ((st = next(p)) != VV_OK)
            return st;
        snprintf(o->file, sizeof o->file, "%s", p->word);
        st = next(p);
        p->pushed = st == VV_OK && !p->end && !vvi_scan_uint(&o->offset, p->word, &end);
        return st;
    }
    if (!vvi_scan_uint(&o->offset, p->word, &end) || *end || p->end)
        return fail_word(p, "'follows', 'file' or a number of bytes");
    return VV_OK;
}

static vv_status read_type(parser *p, vvi_dx_object *o)
{
    char two[2 * VVI_DX_WORD];
    vv_status st = next(p);
    snprintf(two, sizeof two, "%s", p->word);
    if (st == VV_OK && (is(p, "unsigned") || is(p, "signed"))) {
        st = next(p);
        snprintf(two + strlen(two), sizeof two - strlen(two), " %s", p->word);
    }
    o->has_type = st == VV_OK && vvi_dx_type(&o->type, two);
    return st;
}

/* What is left out is a scalar (rank 0) of real numbers (category) of type float. */
static vv_status read_array(parser *p, vvi_dx_object *o)
{
    vv_status st = VV_OK;
    int64_t v = 0;
    o->has_type = true;
    o->type = VV_TYPE_F32;
    o->text = p->text;
    o->big_endian = p->big_endian;
    o->components = 1;
    while (st == VV_OK && (st = next(p)) == VV_OK && !p->end) {
        if (is(p, "type")) {
            st = read_type(p, o);
        } else if (is(p, "rank")) {
            st = next_int(p, &v, 0, 8, "a rank of 0 to 8");
            o->rank = (int)v;
        } else if (is(p, "shape")) {
            for (int i = 0; i < (o->rank ? o->rank : 1) && st == VV_OK; i++)
                if ((st = next_int(p, &v, 1, 4096, "a shape of 1 to 4096")) == VV_OK)
                    o->components = (int)(o->components * v <= 4096 ? o->components * v : 4096);
        } else if (is(p, "items")) {
            st = next_int(p, &o->items, 0, INT64_C(1) << 40, "a number of items");
        } else if (is(p, "category")) {
            if ((st = next(p)) == VV_OK)
                o->not_real = !is(p, "real");
        } else if (is(p, "data")) {
            return read_data(p, o);
        } else if (!set_mode(p, &o->text, &o->big_endian)) {
            p->pushed = true;
            return VV_OK;
        }
    }
    return st;
}

/* fields and the file ------------------------------------------------------------------------------------------------
 */

/* component "data" value 3 */
static vv_status read_component(parser *p, vvi_dx_object *o)
{
    vv_status st = next(p);
    char *to = is(p, "data") ? o->data : is(p, "positions") ? o->positions : NULL;
    if (st == VV_OK)
        st = next(p);
    if (st == VV_OK && is(p, "value"))
        st = next(p);
    if (st == VV_OK && is(p, "file")) /* in another file: never found */
        st = next(p);
    if (st == VV_OK && to)
        snprintf(to, VVI_DX_WORD, "%s", p->word);
    return st;
}

/* attribute "dep" string "connections" */
static vv_status read_attribute(parser *p, vvi_dx_object *o)
{
    vv_status st = next(p);
    const bool dep = is(p, "dep");
    if (st == VV_OK)
        st = next(p);
    if (st == VV_OK && (is(p, "string") || is(p, "number") || is(p, "value")))
        st = next(p);
    if (st == VV_OK && dep)
        o->cells = is(p, "connections");
    return st;
}

static vv_status add_object(parser *p)
{
    /* an object is as large as several keys */
    if (p->n_objects >= vvi_job_limits(p->job)->metadata_keys / 4)
        return vv_fail_at(VV_E_LIMIT, vvi_source_name(p->source), NULL,
                          "has more than %zu objects; --limit metadata_keys=N allows more", p->n_objects);
    if (p->n_objects == p->object_room) {
        const size_t room = p->object_room ? 2 * p->object_room : 8;
        vvi_dx_object *bigger = vvi_realloc(p->job, p->object, room * sizeof *bigger, VVI_MEM_SCRATCH);
        if (!bigger)
            return vv_fail_memory(room * sizeof *bigger);
        p->object = bigger;
        p->object_room = room;
    }
    p->object[p->n_objects++] = (vvi_dx_object){.kind = VVI_DX_OTHER};
    return VV_OK;
}

static vv_status read_object(parser *p)
{
    vv_status st = add_object(p);
    if (st != VV_OK || (st = next(p)) != VV_OK)
        return st;
    vvi_dx_object *o = &p->object[p->n_objects - 1];
    snprintf(o->name, sizeof o->name, "%s", p->word);
    st = next(p);
    if (st == VV_OK && is(p, "class"))
        st = next(p);
    if (st != VV_OK)
        return st;
    snprintf(o->class_name, sizeof o->class_name, "%.31s", p->word);
    o->kind = is(p, "array")           ? VVI_DX_ARRAY
              : is(p, "gridpositions") ? VVI_DX_GRID
              : is(p, "field")         ? VVI_DX_FIELD
                                       : VVI_DX_OTHER;
    return o->kind == VVI_DX_ARRAY ? read_array(p, o) : o->kind == VVI_DX_GRID ? read_grid(p, o) : VV_OK;
}

static vv_status read_objects(parser *p)
{
    vv_status st = VV_OK;
    while (st == VV_OK && !p->ended && (st = next(p)) == VV_OK && !p->end) {
        vvi_dx_object *o = p->n_objects ? &p->object[p->n_objects - 1] : NULL;
        if (is(p, "object"))
            st = read_object(p);
        else if (o && is(p, "component"))
            st = read_component(p, o);
        else if (o && is(p, "attribute"))
            st = read_attribute(p, o);
        else if (is(p, "data"))
            st = next(p); /* data mode ... */
        else if (is(p, "end"))
            p->ended = true;
        else
            set_mode(p, &p->text, &p->big_endian);
    }
    return st;
}

vv_status vvi_dx_read_objects(vvi_dx_objects *out, vv_source *source, vv_job *job)
{
    parser p = {.source = source, .job = job, .text = true, .big_endian = true};
    const vv_status st = read_objects(&p);
    *out = (vvi_dx_objects){.source = source, .object = p.object, .n_objects = p.n_objects};
    vvi_free(p.line);
    return st;
}

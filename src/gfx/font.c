/* One line of text by FreeType: glyphs are drawn once for each size and quarter of a pixel, and kept. */
#include "gfx/font.h"
#include "config.h"
#include "core/memory.h"
#include "gfx/font_file.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if !VV_HAVE_FREETYPE

vv_status vvi_font_open(vvi_font **out, const char *path)
{
    (void)path;
    *out = NULL;
    return vv_fail(
        VV_E_UNSUPPORTED,
        "this VolVis was built without FreeType and cannot draw letters: install libfreetype-dev and build again");
}

void vvi_font_close(void *font)
{
    (void)font;
}

const char *vvi_font_path(const vvi_font *font)
{
    (void)font;
    return "";
}

vvi_font_heights vvi_font_get_heights(const vvi_font *font)
{
    (void)font;
    return (vvi_font_heights){0};
}

double vvi_font_length(vvi_font *font, const char *utf8, double size)
{
    (void)font;
    (void)utf8;
    (void)size;
    return 0;
}

vv_status vvi_font_draw(void *font, vvi_gfx_coverage *out, const char *utf8, double size, vv_job *job)
{
    (void)font;
    (void)utf8;
    (void)size;
    (void)job;
    *out = (vvi_gfx_coverage){0};
    return vvi_font_open(&(vvi_font *){NULL}, NULL);
}

vv_status vvi_font_trace(vvi_font_outline *out, vvi_font *font, const char *utf8, double error_em, vv_job *job)
{
    (void)font;
    (void)utf8;
    (void)error_em;
    (void)job;
    *out = (vvi_font_outline){0};
    return vvi_font_open(&(vvi_font *){NULL}, NULL);
}

#else

#include <ft2build.h>
#include <pthread.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H
#include FT_TRUETYPE_TABLES_H

enum {
    SLOTS = 1024,       /* glyphs that are kept: what falls into the same slot takes it over */
    PARTS = 4,          /* places of a glyph in its pixel */
    MOST_PIXELS = 16384 /* length of a line */
};

typedef struct glyph {
    FT_UInt index;
    int32_t size, part; /* in 1/64 pixels, and of PARTS */
    bool used;
    int32_t left, top, width, height; /* top: above the base line */
    uint8_t *coverage;
} glyph;

struct vvi_font {
    FT_Library library;
    FT_Face face;
    char *path;
    vvi_font_heights heights;
    pthread_mutex_t lock; /* FreeType's face, and the glyphs */
    glyph slot[SLOTS];
};

/* Opening --------------------------------------------------------------------------------------------------------- */

static vvi_font_heights measure(FT_Face face)
{
    const double em = face->units_per_EM;
    const TT_OS2 *os2 = FT_Get_Sfnt_Table(face, FT_SFNT_OS2);
    const bool known = os2 && os2->version >= 2 && os2->sCapHeight > 0 && os2->sxHeight > 0;
    return (vvi_font_heights){.capital = known ? os2->sCapHeight / em : 0.72,
                              .small = known ? os2->sxHeight / em : 0.53,
                              .above = face->ascender / em,
                              .below = -face->descender / em};
}

static vv_status load(vvi_font *font)
{
    if (FT_Init_FreeType(&font->library))
        return vv_fail(VV_E_MEMORY, "FreeType cannot be started");
    const FT_Error error = FT_New_Face(font->library, font->path, 0, &font->face);
    if (error == FT_Err_Cannot_Open_Resource)
        return vv_fail_at(VV_E_NOT_FOUND, font->path, NULL, "there is no font that can be read");
    if (error)
        return vv_fail_at(VV_E_FORMAT, font->path, NULL,
                          "is not a font that FreeType can read; give a .ttf or .otf file");
    if (!FT_IS_SCALABLE(font->face))
        return vv_fail_at(VV_E_FORMAT, font->path, NULL, "has letters of fixed sizes only; give a .ttf or .otf file");
    font->heights = measure(font->face);
    return VV_OK;
}

vv_status vvi_font_open(vvi_font **out, const char *path)
{
    *out = NULL;
    vvi_font *font = vvi_calloc(1, sizeof *font);
    if (!font)
        return vv_fail_memory(sizeof *font);
    pthread_mutex_init(&font->lock, NULL);
    vv_status st = vvi_font_find(&font->path, path);
    if (st == VV_OK)
        st = load(font);
    if (st != VV_OK) {
        vvi_font_close(font);
        return st;
    }
    *out = font;
    return VV_OK;
}

void vvi_font_close(void *user)
{
    vvi_font *font = user;
    if (!font)
        return;
    for (size_t i = 0; i < SLOTS; i++)
        free(font->slot[i].coverage);
    if (font->face)
        FT_Done_Face(font->face);
    if (font->library)
        FT_Done_FreeType(font->library);
    pthread_mutex_destroy(&font->lock);
    free(font->path);
    free(font);
}

const char *vvi_font_path(const vvi_font *font)
{
    return font->path;
}

vvi_font_heights vvi_font_get_heights(const vvi_font *font)
{
    return font->heights;
}

/* Lines ----------------------------------------------------------------------------------------------------------- */

/* The code point at *s, which moves on; 0 at the end. Broken UTF-8 is U+FFFD. */
static FT_ULong next_code(const char **s)
{
    static const uint8_t lead[] = {0, 0x7f, 0x1f, 0x0f, 0x07};
    const size_t n = vvi_utf8_length(*s);
    if (n == 0) {
        const bool end = **s == 0;
        *s += !end;
        return end ? 0 : 0xfffd;
    }
    FT_ULong code = (uint8_t)(*s)[0] & lead[n];
    for (size_t i = 1; i < n; i++)
        code = code << 6 | ((uint8_t)(*s)[i] & 0x3f);
    *s += n;
    return code;
}

/* A walk along a line, in units of the font. */
typedef struct pen {
    const char *rest;
    FT_UInt index, before;
    double x; /* of the glyph */
} pen;

static double kerning(const vvi_font *font, FT_UInt left, FT_UInt right)
{
    FT_Vector k = {0, 0};
    if (!left || !FT_HAS_KERNING(font->face) || FT_Get_Kerning(font->face, left, right, FT_KERNING_UNSCALED, &k))
        return 0;
    return (double)k.x;
}

static double advance_of(const vvi_font *font, FT_UInt index)
{
    return FT_Load_Glyph(font->face, index, FT_LOAD_NO_SCALE) ? 0 : (double)font->face->glyph->metrics.horiAdvance;
}

/* The next glyph; false at the end, when x is the length of the line. */
static bool pen_next(pen *p, const vvi_font *font)
{
    if (p->index)
        p->x += advance_of(font, p->index);
    p->before = p->index;
    const FT_ULong code = next_code(&p->rest);
    p->index = code ? FT_Get_Char_Index(font->face, code) : 0;
    if (!code)
        return false;
    p->x += kerning(font, p->before, p->index);
    if (!p->index) /* the empty box has a width too, which the next turn could not tell from no glyph */
        p->x += advance_of(font, 0);
    return true;
}

static double length_of(const vvi_font *font, const char *utf8)
{
    pen p = {.rest = utf8};
    while (pen_next(&p, font)) {
    }
    return p.x / font->face->units_per_EM;
}

double vvi_font_length(vvi_font *font, const char *utf8, double size)
{
    pthread_mutex_lock(&font->lock);
    const double ems = length_of(font, utf8);
    pthread_mutex_unlock(&font->lock);
    return ems * size;
}

/* Coverage -------------------------------------------------------------------------------------------------------- */

static vv_status keep_bitmap(glyph *g, const FT_GlyphSlot slot)
{
    const FT_Bitmap *b = &slot->bitmap;
    const size_t bytes = (size_t)b->width * b->rows;
    free(g->coverage);
    *g = (glyph){.left = slot->bitmap_left, .top = slot->bitmap_top};
    if (!bytes)
        return VV_OK;
    g->coverage = vvi_calloc(bytes, 1);
    if (!g->coverage)
        return vv_fail_memory(bytes);
    g->width = (int32_t)b->width;
    g->height = (int32_t)b->rows;
    for (size_t y = 0; y < b->rows; y++)
        memcpy(g->coverage + y * b->width, b->buffer + (ptrdiff_t)y * b->pitch, b->width);
    return VV_OK;
}

/* size: in 1/64 pixels, which the face has been set to. */
static vv_status get_glyph(const glyph **out, vvi_font *font, FT_UInt index, int32_t size, int32_t part)
{
    glyph *g = &font->slot[((uint32_t)index * 31u + (uint32_t)size * 7u + (uint32_t)part) % SLOTS];
    *out = g;
    if (g->used && g->index == index && g->size == size && g->part == part)
        return VV_OK;
    const FT_GlyphSlot slot = font->face->glyph;
    if (FT_Load_Glyph(font->face, index, FT_LOAD_TARGET_LIGHT | FT_LOAD_NO_BITMAP) ||
        slot->format != FT_GLYPH_FORMAT_OUTLINE)
        return vv_fail_at(VV_E_FORMAT, font->path, NULL, "has a glyph that cannot be drawn; use another font");
    FT_Outline_Translate(&slot->outline, part * 64 / PARTS, 0);
    if (FT_Render_Glyph(slot, FT_RENDER_MODE_NORMAL))
        return vv_fail_at(VV_E_FORMAT, font->path, NULL, "has a glyph that cannot be drawn; use another font");
    const vv_status st = keep_bitmap(g, slot);
    if (st != VV_OK)
        return st;
    g->index = index;
    g->size = size;
    g->part = part;
    g->used = true;
    return VV_OK;
}

static void paint(const vvi_gfx_coverage *out, const glyph *g, int32_t x)
{
    for (int32_t j = 0; j < g->height; j++) {
        const int32_t y = j - g->top - out->top;
        for (int32_t i = 0; i < g->width; i++) {
            const int32_t at = x + g->left + i - out->left;
            if (y < 0 || y >= out->height || at < 0 || at >= out->width)
                continue;
            uint8_t *p = &out->coverage[(size_t)y * (size_t)out->width + (size_t)at];
            const int sum = *p + g->coverage[(size_t)j * (size_t)g->width + (size_t)i];
            *p = (uint8_t)(sum < 255 ? sum : 255);
        }
    }
}

/* A box that all glyphs of the line fit into: the font's own, and a pixel more on each side. */
static vv_status new_coverage(vvi_gfx_coverage *out, const vvi_font *font, double ems, double size, vv_job *job)
{
    const double em = font->face->units_per_EM;
    const FT_BBox *b = &font->face->bbox;
    const double reach = fmax(fabs((double)b->xMin), fabs((double)b->xMax - font->face->max_advance_width)) / em;
    out->left = -(int32_t)ceil(reach * size) - 1;
    out->top = -(int32_t)ceil((double)b->yMax / em * size) - 2;
    out->width = (int32_t)ceil(ems * size + 2 * reach * size) + 3;
    out->height = -out->top + (int32_t)ceil(-(double)b->yMin / em * size) + 2;
    const size_t bytes = (size_t)out->width * (size_t)out->height;
    out->coverage = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    return out->coverage ? VV_OK : vv_fail_memory(bytes);
}

static vv_status paint_line(const vvi_gfx_coverage *out, vvi_font *font, const char *utf8, int32_t size64)
{
    pen p = {.rest = utf8};
    vv_status st = VV_OK;
    const double scale = size64 / 64.0 / font->face->units_per_EM;
    while (st == VV_OK && pen_next(&p, font)) {
        const glyph *g = NULL;
        const FT_UInt index = p.index;
        const double x = (p.x - (index ? 0 : advance_of(font, 0))) * scale;
        const double quarter = floor(x * PARTS + 0.5);
        const int32_t whole = (int32_t)floor(quarter / PARTS);
        st = get_glyph(&g, font, index, size64, (int32_t)quarter - whole * PARTS);
        if (st == VV_OK)
            paint(out, g, whole);
    }
    return st;
}

vv_status vvi_font_draw(void *user, vvi_gfx_coverage *out, const char *utf8, double size, vv_job *job)
{
    vvi_font *font = user;
    *out = (vvi_gfx_coverage){0};
    if (!(size >= 1 && size <= 4096))
        return vv_fail(VV_E_ARGUMENT, "text: a size of %g pixels is not between 1 and 4096", size);
    const int32_t size64 = (int32_t)lround(size * 64);
    pthread_mutex_lock(&font->lock);
    const double ems = length_of(font, utf8), exact = size64 / 64.0;
    vv_status st = VV_OK;
    if (ems * exact > MOST_PIXELS)
        st = vv_fail(VV_E_ARGUMENT, "text: '%.40s...' is %.0f pixels long, and at most %d can be drawn", utf8,
                     ems * exact, MOST_PIXELS);
    else if (FT_Set_Char_Size(font->face, size64, size64, 72, 72))
        st = vv_fail_at(VV_E_FORMAT, font->path, NULL, "cannot be drawn at %g pixels; use another font", exact);
    out->advance = ems * exact;
    if (st == VV_OK && *utf8 && (st = new_coverage(out, font, ems, exact, job)) == VV_OK)
        st = paint_line(out, font, utf8, size64);
    pthread_mutex_unlock(&font->lock);
    if (st != VV_OK) {
        vvi_free(out->coverage);
        *out = (vvi_gfx_coverage){0};
    }
    return st;
}

/* Outlines -------------------------------------------------------------------------------------------------------- */

typedef struct tracer {
    vvi_font_outline *out;
    size_t room_points, room_polygons;
    double scale, x; /* ems a unit of the font; where the glyph begins, ems */
    double error;    /* ems */
    FT_Vector at;    /* units */
    vv_status st;
    vv_job *job;
} tracer;

static bool grow(tracer *t, void **array, size_t *room, size_t n, size_t bytes)
{
    if (n < *room)
        return true;
    const size_t more = *room ? 2 * *room : 64;
    void *larger = vvi_realloc(t->job, *array, more * bytes, VVI_MEM_SCRATCH);
    if (!larger) {
        t->st = vv_fail_memory(more * bytes);
        return false;
    }
    *array = larger;
    *room = more;
    return true;
}

static void add_point(tracer *t, double x, double y)
{
    if (grow(t, (void **)&t->out->points, &t->room_points, t->out->n_points, sizeof *t->out->points))
        t->out->points[t->out->n_points++] = (vv_vec3){t->x + x * t->scale, y * t->scale, 0};
}

static void end_polygon(tracer *t)
{
    vvi_font_outline *out = t->out;
    const size_t begin = out->n_polygons ? out->ends[out->n_polygons - 1] : 0;
    if (out->n_points > begin && grow(t, (void **)&out->ends, &t->room_polygons, out->n_polygons, sizeof *out->ends))
        out->ends[out->n_polygons++] = out->n_points;
}

static int move_to(const FT_Vector *to, void *user)
{
    tracer *t = user;
    end_polygon(t);
    add_point(t, (double)to->x, (double)to->y);
    t->at = *to;
    return t->st;
}

static int line_to(const FT_Vector *to, void *user)
{
    tracer *t = user;
    add_point(t, (double)to->x, (double)to->y);
    t->at = *to;
    return t->st;
}

/* Pieces of a curve whose second difference of control points is (x, y): a chord over 1/n of it is at most
 * |second derivative| / 8 n^2 away, and that derivative is twice the difference (quadratic) or six times (cubic). */
static int pieces(const tracer *t, double x, double y, double factor)
{
    const double n = sqrt(factor * hypot(x, y) * t->scale / (8 * t->error));
    return n < 1 ? 1 : n > 64 ? 64 : (int)ceil(n);
}

static int quadratic_to(const FT_Vector *control, const FT_Vector *to, void *user)
{
    tracer *t = user;
    const double ax = (double)t->at.x, ay = (double)t->at.y, bx = (double)control->x, by = (double)control->y;
    const double cx = (double)to->x, cy = (double)to->y;
    const int n = pieces(t, ax - 2 * bx + cx, ay - 2 * by + cy, 2);
    for (int i = 1; i <= n; i++) {
        const double v = (double)i / n, u = 1 - v;
        add_point(t, u * u * ax + 2 * u * v * bx + v * v * cx, u * u * ay + 2 * u * v * by + v * v * cy);
    }
    t->at = *to;
    return t->st;
}

static int cubic_to(const FT_Vector *first, const FT_Vector *second, const FT_Vector *to, void *user)
{
    tracer *t = user;
    const double ax = (double)t->at.x, ay = (double)t->at.y, bx = (double)first->x, by = (double)first->y;
    const double cx = (double)second->x, cy = (double)second->y, dx = (double)to->x, dy = (double)to->y;
    const double x = fmax(fabs(ax - 2 * bx + cx), fabs(bx - 2 * cx + dx));
    const double y = fmax(fabs(ay - 2 * by + cy), fabs(by - 2 * cy + dy));
    const int n = pieces(t, x, y, 6);
    for (int i = 1; i <= n; i++) {
        const double v = (double)i / n, u = 1 - v;
        const double a = u * u * u, b = 3 * u * u * v, c = 3 * u * v * v, d = v * v * v;
        add_point(t, a * ax + b * bx + c * cx + d * dx, a * ay + b * by + c * cy + d * dy);
    }
    t->at = *to;
    return t->st;
}

static void trace_line(tracer *t, vvi_font *font, const char *utf8)
{
    static const FT_Outline_Funcs funcs = {move_to, line_to, quadratic_to, cubic_to, 0, 0};
    pen p = {.rest = utf8};
    while (t->st == VV_OK && pen_next(&p, font)) {
        t->x = (p.x - (p.index ? 0 : advance_of(font, 0))) * t->scale;
        if (FT_Load_Glyph(font->face, p.index, FT_LOAD_NO_SCALE) ||
            font->face->glyph->format != FT_GLYPH_FORMAT_OUTLINE)
            continue;
        FT_Outline_Decompose(&font->face->glyph->outline, &funcs, t);
        end_polygon(t);
    }
    t->out->advance = p.x * t->scale;
}

vv_status vvi_font_trace(vvi_font_outline *out, vvi_font *font, const char *utf8, double error_em, vv_job *job)
{
    *out = (vvi_font_outline){0};
    tracer t = {.out = out, .scale = 1.0 / font->face->units_per_EM, .error = error_em, .job = job};
    pthread_mutex_lock(&font->lock);
    trace_line(&t, font, utf8);
    pthread_mutex_unlock(&font->lock);
    if (t.st != VV_OK)
        vvi_font_outline_finish(out);
    return t.st;
}

#endif

void vvi_font_outline_finish(vvi_font_outline *outline)
{
    vvi_free(outline->points);
    vvi_free(outline->ends);
    *outline = (vvi_font_outline){0};
}

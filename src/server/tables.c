#include "server/tables.h"
#include "input/method.h"
#include "scene/presets.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measuring.h>
#include <volvis/model.h>
#include <volvis/render.h>

enum { CLASSES_MOST = 128 };

/* Classes that were met, each told once. */
typedef struct known {
    const vv_class *cls[CLASSES_MOST];
    size_t n, told;
} known;

static void meet(known *k, const vv_class *cls)
{
    bool met = !cls || k->n == CLASSES_MOST;
    for (size_t i = 0; i < k->n && !met; i++)
        met = strcmp(k->cls[i]->name, cls->name) == 0;
    if (!met)
        k->cls[k->n++] = cls;
}

static void tell_property(vvi_result *out, const vv_property *row)
{
    vvi_result_open(out, NULL, '{');
    vvi_property_tell(out, row);
    if (row->label)
        vvi_result_string(out, "label", row->label);
    if (row->when)
        vvi_result_string(out, "when", row->when);
    if (row->automatic)
        vvi_result_string(out, "automatic", row->automatic);
    if (!vvi_property_tell_default(out, row) && row->def_text)
        vvi_result_raw(out, "default", row->def_text);
    if (row->kind == VV_KIND_ENUM)
        vvi_result_strings(out, "names", row->names);
    if (row->cls)
        vvi_result_string(out, "class", row->cls->name);
    if (row->ref_to)
        vvi_result_string(out, "ref_to", row->ref_to);
    if (row->table)
        vvi_result_string(out, "table", row->table);
    if (row->columns > 0)
        vvi_result_integer(out, "columns", row->columns);
    vvi_result_close(out, '}');
}

static void tell_class(vvi_result *out, known *k, const char *name, const vv_class *cls)
{
    vvi_result_open(out, name, '{');
    vvi_result_string(out, "doc", cls->doc);
    vvi_result_open(out, "properties", '[');
    for (const vv_property *row = cls->properties; row->name; row++) {
        if (row->hidden)
            continue;
        meet(k, row->cls);
        tell_property(out, row);
    }
    vvi_result_close(out, ']');
    vvi_result_close(out, '}');
}

static void tell_classes(vvi_result *out, const vv_registry *registry)
{
    known k = {.n = 0};
    char name[96];
    vvi_result_open(out, "classes", '{');
    for (size_t i = 0; registry->operations[i]; i++) {
        snprintf(name, sizeof name, "operation.%s", registry->operations[i]->name);
        tell_class(out, &k, name, registry->operations[i]->params);
    }
    for (size_t i = 0; registry->renderers[i]; i++) {
        snprintf(name, sizeof name, "renderer.%s", registry->renderers[i]->name);
        tell_class(out, &k, name, registry->renderers[i]->params);
    }
    meet(&k, &vv_world_class);
    for (; k.told < k.n; k.told++)
        tell_class(out, &k, k.cls[k.told]->name, k.cls[k.told]);
    vvi_result_close(out, '}');
}

static void tell_operands(vvi_result *out, const vv_operation *row)
{
    vvi_result_open(out, "inputs", '[');
    for (const vv_operand *o = row->inputs; o->name; o++) {
        vvi_result_open(out, NULL, '{');
        vvi_result_string(out, "name", o->name);
        vvi_result_string(out, "doc", o->doc);
        vvi_result_bool(out, "volume", (o->is & VV_IS_FIELD) != 0);
        vvi_result_bool(out, "mesh", (o->is & VV_IS_MESH) != 0);
        vvi_result_unsigned(out, "least", o->least);
        vvi_result_unsigned(out, "most", o->most);
        vvi_result_bool(out, "named", o->names != NULL);
        vvi_result_close(out, '}');
    }
    vvi_result_close(out, ']');
}

static void tell_operations(vvi_result *out, const vv_registry *registry)
{
    char name[96];
    vvi_result_open(out, "operations", '[');
    for (const vv_operation *const *row = registry->operations; *row; row++) {
        vvi_result_open(out, NULL, '{');
        vvi_result_string(out, "name", (*row)->name);
        vvi_result_string(out, "component", (*row)->component);
        vvi_result_string(out, "group", (*row)->group ? (*row)->group : (*row)->component);
        vvi_result_string(out, "doc", (*row)->doc);
        snprintf(name, sizeof name, "operation.%s", (*row)->name);
        vvi_result_string(out, "class", name);
        tell_operands(out, *row);
        vvi_result_bool(out, "new_values", !(*row)->carry);
        vvi_result_string(out, "gives", vv_operation_makes(*row) == VV_IS_MESH ? "mesh" : "volume");
        vvi_result_close(out, '}');
    }
    vvi_result_close(out, ']');
}

static void tell_renderers(vvi_result *out, const vv_registry *registry)
{
    char name[96];
    vvi_result_open(out, "renderers", '[');
    for (const vv_renderer *const *row = registry->renderers; *row; row++) {
        vvi_result_open(out, NULL, '{');
        vvi_result_string(out, "name", (*row)->name);
        vvi_result_string(out, "label", (*row)->label ? (*row)->label : (*row)->name);
        vvi_result_string(out, "doc", (*row)->doc);
        snprintf(name, sizeof name, "renderer.%s", (*row)->name);
        vvi_result_string(out, "class", name);
        vvi_result_bool(out, "plane", (*row)->plane != NULL);
        vvi_result_close(out, '}');
    }
    vvi_result_close(out, ']');
}

/* The properties that a form uses, as words. */
static void tell_uses(vvi_result *out, const char *uses)
{
    char word[64];
    vvi_result_open(out, "uses", '[');
    for (const char *at = uses + strspn(uses, " "); *at; at += strspn(at, " ")) {
        const size_t n = strcspn(at, " ");
        snprintf(word, sizeof word, "%.*s", (int)n, at);
        vvi_result_string(out, NULL, word);
        at += n;
    }
    vvi_result_close(out, ']');
}

/* What it is of, and how many points each way takes: 0, however many. */
static void tell_forms(vvi_result *out, const vv_measure_kind *kind)
{
    static const char *const names[] = {"volume", "mesh", "shown"};
    vvi_result_open(out, "forms", '[');
    for (const vv_measure_form *form = kind->forms; form->run; form++) {
        vvi_result_open(out, NULL, '{');
        vvi_result_open(out, "of", '[');
        for (int i = 0; i < 3; i++)
            if (form->input >> i & 1)
                vvi_result_string(out, NULL, names[i]);
        vvi_result_close(out, ']');
        vvi_result_bool(out, "other", form->other != 0);
        vvi_result_unsigned(out, "points", form->n_points);
        tell_uses(out, form->uses);
        vvi_result_close(out, '}');
    }
    vvi_result_close(out, ']');
}

static void tell_measures(vvi_result *out)
{
    const vv_measure_kind *kind;
    vvi_result_open(out, "measures", '[');
    for (size_t i = 0; (kind = vv_measure_kind_nth(i)) != NULL; i++) {
        vvi_result_open(out, NULL, '{');
        vvi_result_string(out, "name", kind->name);
        vvi_result_string(out, "doc", kind->doc);
        if (kind->main)
            vvi_result_string(out, "main", kind->main);
        vvi_result_bool(out, "plot", kind->plot);
        vvi_result_unsigned(out, "least_points", kind->least_points);
        vvi_result_bool(out, "any_points", kind->most_points == SIZE_MAX);
        tell_forms(out, kind);
        vvi_result_close(out, '}');
    }
    vvi_result_close(out, ']');
}

/* Piecewise linear: what stands behind the first column. */
static void row_at(double *out, const double *rows, size_t n, size_t columns, double at)
{
    size_t i = 0;
    while (i + 1 < n && rows[(i + 1) * columns] < at)
        i++;
    const double *a = rows + i * columns, *b = i + 1 < n ? a + columns : a;
    const double t = b[0] > a[0] ? fmin(fmax((at - a[0]) / (b[0] - a[0]), 0), 1) : 0;
    for (size_t c = 1; c < columns; c++)
        out[c - 1] = a[c] + t * (b[c] - a[c]);
}

static unsigned code(double linear)
{
    return (unsigned)(vv_srgb_encode(fmin(fmax(linear, 0), 1)) * 255 + 0.5);
}

static void tell_colormap(vvi_result *out, const char *name)
{
    enum { COLORS = 32 };
    vvi_result_open(out, name, '[');
    for (int i = 0; i < COLORS; i++) {
        vv_color c = {0};
        char text[8];
        vv_colormap_sample(&c, name, (double)i / (COLORS - 1));
        snprintf(text, sizeof text, "#%02x%02x%02x", code(c.r) & 255u, code(c.g) & 255u, code(c.b) & 255u);
        vvi_result_string(out, NULL, text);
    }
    vvi_result_close(out, ']');
}

/* Colours and opacities over the range of the nodes. */
static void tell_transfer_colors(vvi_result *out, const vvi_preset *p)
{
    enum { COLORS = 32 };
    const double lo = p->opacity[0][0], hi = p->opacity[p->n_opacity - 1][0];
    vvi_result_open(out, "colors", '[');
    for (int i = 0; i < COLORS; i++) {
        const double s = (double)i / (COLORS - 1), at = lo + s * (hi - lo);
        double alpha = 0, rgb[3];
        char text[12];
        vv_color c = {0};
        row_at(&alpha, &p->opacity[0][0], p->n_opacity, 2, at);
        if (p->color) {
            row_at(rgb, &p->color[0][0], p->n_color, 4, at);
            c = (vv_color){rgb[0], rgb[1], rgb[2], 1};
        } else {
            vv_colormap_sample(&c, p->colormap, s);
        }
        snprintf(text, sizeof text, "#%02x%02x%02x%02x", code(c.r) & 255u, code(c.g) & 255u, code(c.b) & 255u,
                 (unsigned)(alpha * 255 + 0.5) & 255u);
        vvi_result_string(out, NULL, text);
    }
    vvi_result_close(out, ']');
}

static void tell_presets(vvi_result *out)
{
    const vv_preset *p;
    vvi_result_open(out, "presets", '[');
    for (size_t i = 0; (p = vv_preset_nth(i)) != NULL; i++) {
        vvi_result_open(out, NULL, '{');
        vvi_result_string(out, "name", p->name);
        vvi_result_string(out, "doc", p->doc);
        vvi_result_string(out, "kind", p->kind);
        vvi_result_string(out, "unit", p->value_unit);
        const vvi_preset *whole = strcmp(p->kind, "transfer") == 0 ? vvi_preset_find(p->name, "") : NULL;
        if (whole && whole->n_opacity)
            tell_transfer_colors(out, whole);
        vvi_result_close(out, '}');
    }
    vvi_result_close(out, ']');
    vvi_result_open(out, "colormaps", '{');
    for (size_t i = 0; (p = vv_preset_nth(i)) != NULL; i++)
        if (strcmp(p->kind, "colormap") == 0)
            tell_colormap(out, p->name);
    vvi_result_close(out, '}');
}

static void tell_methods(vvi_result *out)
{
    vvi_result_open(out, "methods", '{');
    for (const vvi_method *const *row = vvi_methods; *row; row++)
        vvi_result_string(out, (*row)->name, (*row)->doc);
    vvi_result_close(out, '}');
}

void vvi_tables_tell(vvi_result *out, const vv_registry *registry)
{
    tell_classes(out, registry);
    tell_operations(out, registry);
    tell_renderers(out, registry);
    tell_measures(out);
    tell_presets(out);
    tell_methods(out);
}

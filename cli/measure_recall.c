/* The options that a stored measurement was asked with. */
#include "core/units.h"
#include "measure.h"
#include "measure_stored.h"
#include <stdio.h>
#include <stdlib.h>

static void add_text(vvi_text *out, const char *name, const char *value)
{
    vvi_text_printf(out, "%s\"%s\": ", out->n > 1 ? ", " : "", name);
    vvi_text_json(out, value);
}

static void print_row(char out[128], const double *v, size_t n)
{
    size_t at = 0;
    for (size_t i = 0; i < n; i++)
        at += (size_t)snprintf(out + at, 128 - at, "%s%.17g", i ? "," : "", v[i]);
}

/* Numbers are typed as words: each as it stands in JSON, in quotes. Large labels have theirs. */
static void add_numbers(vvi_text *out, const vv_measurement *m)
{
    static const char *const names[] = {"iso", "other_iso", "label", "other_label"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *json = NULL;
        const bool there = vv_object_is_set(&m->base, names[i]) && vv_path_get(&json, &m->base, names[i]) == VV_OK;
        if (there && *json == '"')
            vvi_text_printf(out, "%s\"%s\": %s", out->n > 1 ? ", " : "", names[i], json);
        else if (there)
            add_text(out, names[i], json);
        free(json);
    }
}

static void add_row(vvi_text *out, const char *name, const double *v, size_t n)
{
    char row[128];
    print_row(row, v, n);
    add_text(out, name, row);
}

static void add_threshold(vvi_text *out, const vv_measurement *m)
{
    char lo[32] = "", hi[32] = "", both[72];
    const bool from = vv_object_is_set(&m->base, "threshold_lo"), to = vv_object_is_set(&m->base, "threshold_hi");
    if (from)
        vvi_print_number(lo, m->threshold_lo);
    if (to)
        vvi_print_number(hi, m->threshold_hi);
    snprintf(both, sizeof both, "%s,%s", lo, hi);
    if (from || to)
        add_text(out, "threshold", both);
}

static void begin_words(vvi_text *out, const char *name)
{
    vvi_text_printf(out, "%s\"%s\": [", out->n > 1 ? ", " : "", name);
}

static void add_words(vvi_text *out, const vv_measurement *m)
{
    char row[128], normal[128];
    if (m->points && m->points->n) {
        begin_words(out, "point");
        for (size_t i = 0; i + 3 <= m->points->n; i += 3) {
            print_row(row, m->points->v + i, 3);
            vvi_text_printf(out, "%s{\"text\": \"%s\"}", i ? ", " : "", row);
        }
        vvi_text_add(out, "]");
    }
    if (!m->cut_planes->n)
        return;
    begin_words(out, "clip");
    for (size_t i = 0; i < m->cut_planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)m->cut_planes->entry[i].object;
        print_row(normal, &p->normal.x, 3);
        print_row(row, &p->offset, 1);
        vvi_text_printf(out, "%s{\"text\": \"plane(n=%s d=%s)\"}", i ? ", " : "", normal, row);
    }
    vvi_text_add(out, "]");
}

/* In both classes a property of this name and kind. */
void cli_measure_add_same(vvi_text *out, const vv_object *from)
{
    static const char *const names[] = {"space",   "box",    "method", "closed",    "bins",
                                        "samples", "values", "mask",   "input_unit"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *json = NULL;
        if (vv_object_is_set(from, names[i]) && vv_path_get(&json, from, names[i]) == VV_OK)
            vvi_text_printf(out, "%s\"%s\": %s", out->n > 1 ? ", " : "", names[i], json);
        free(json);
    }
}

vv_status cli_measure_recall(vv_object **out, const vv_measurement *m)
{
    vvi_text json = {0};
    vvi_text_add(&json, "{");
    add_numbers(&json, m);
    add_threshold(&json, m);
    if (vv_object_is_set(&m->base, "seed"))
        add_row(&json, "seed", &m->seed.x, 3);
    if (m->range && m->range->n == 2)
        add_row(&json, "range", m->range->v, 2);
    if (vv_object_is_set(&m->base, "component")) {
        char number[32];
        snprintf(number, sizeof number, "%lld", (long long)m->component);
        add_text(&json, "component", number);
    }
    add_words(&json, m);
    cli_measure_add_same(&json, &m->base);
    vvi_text_add(&json, "}");
    const vv_status st =
        json.bad ? vv_fail_memory(json.n) : vv_object_from_json(out, &cli_measure_class, json.s, json.n, NULL);
    vvi_text_free(&json);
    return st;
}

#include "io/mesh_part.h"
#include "core/text.h"
#include "grid/mesh.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/property.h>

/* The nearest name, and all. */
static vv_status fail_no_part(const vv_mesh_info *m, const char *part, const char *path)
{
    enum { SHOWN = 12, LOOKED_AT = 64 };
    const char *names[LOOKED_AT];
    size_t n = 0;
    vvi_text list = {0};
    if (m->n_parts == 0)
        return vv_fail_at(VV_E_NOT_FOUND, path, NULL,
                          "has no part '%.60s': it is one object without parts, which is read without a name", part);
    for (size_t i = 0; i < m->n_parts && n < LOOKED_AT; i++)
        if (m->parts[i].name[0])
            names[n++] = m->parts[i].name;
    const char *near = vv_nearest_name(part, names, n);
    for (size_t i = 0; i < n && i < SHOWN; i++)
        vvi_text_printf(&list, "%s%s", i ? ", " : ": ", names[i]);
    char numbers[64];
    snprintf(numbers, sizeof numbers, m->n_parts > 1 ? "%shere are %zu, 0 to %zu" : "%shere is %zu, number %zu",
             near ? "T" : "t", m->n_parts, m->n_parts - 1);
    const vv_status st =
        vv_fail_at(VV_E_NOT_FOUND, path, NULL, "has no part '%.60s'; %s%s%s%s%s%s", part, near ? "did you mean '" : "",
                   near ? near : "", near ? "'? " : "", numbers, list.s && !list.bad ? list.s : "",
                   n > SHOWN ? ", ... ('volvis info --json' lists them)" : "");
    vvi_text_free(&list);
    return st;
}

/* By name first: a name may be a number. */
static vv_status find_part(size_t *out, const vv_mesh_info *m, const char *part, const char *path)
{
    const bool digits = *part && strlen(part) < 10 && !part[strspn(part, "0123456789")];
    const size_t number = digits ? (size_t)strtoul(part, NULL, 10) : SIZE_MAX;
    size_t n = 0;
    for (size_t i = 0; i < m->n_parts; i++)
        if (strcmp(m->parts[i].name, part) == 0 && n++ == 0)
            *out = i;
    if (n > 1)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL,
                          "has %zu parts of the name '%.60s': give the number of one, from 0; the first is %zu", n,
                          part, *out);
    if (n == 1)
        return VV_OK;
    if (number >= m->n_parts)
        return fail_no_part(m, part, path);
    *out = number;
    return VV_OK;
}

vv_status vvi_mesh_pick_part(vv_mesh **mesh, const char *part, const char *path, vv_job *job)
{
    size_t index = 0;
    vv_mesh *one = NULL;
    if (!part)
        return VV_OK;
    vv_status st = find_part(&index, vv_mesh_get_info(*mesh), part, path);
    if (st == VV_OK)
        st = vvi_mesh_part(&one, *mesh, index, job);
    if (st != VV_OK)
        return st;
    vv_mesh_release(*mesh);
    *mesh = one;
    return VV_OK;
}

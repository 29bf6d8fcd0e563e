/* Gaussian cube files: values round a molecule, as text: https://gaussian.com/cubegen/
 *
 * Two lines of comment; the number of atoms and the origin; three lines with the number of steps and the step along
 * each axis, in bohr, or in angstrom where that number is negative; a line an atom; then values, the last axis fastest.
 * A negative number of atoms: a line with the number of orbitals and which they are stands before the values, and
 * each place has a value of each orbital. */
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "io/data_files.h"
#include "io/notes.h"
#include "io/scan.h"
#include "registry.h"
#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_MOST ((size_t)64 << 10)
#define BOHR 0.529177210903 /* angstrom; CODATA 2018 */
#define ATOMS_LISTED 256
#define COMPONENTS_MOST 4096

typedef struct cube {
    vv_source *source;
    int line;
    int64_t n_atoms;
    bool orbitals;
    int64_t per_place; /* values */
    double origin[3], step[3][3];
    int64_t n[3];
    bool angstrom;
} cube;

static vv_status fail_line(const cube *c, const char *text)
{
    char where[32];
    snprintf(where, sizeof where, "%d", c->line);
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(c->source), where, "expected %s", text);
}

static vv_status next_line(cube *c, const char **line)
{
    bool end;
    vv_status st = vvi_source_line(c->source, line, LINE_MOST, &end);
    c->line++;
    return st == VV_OK && end ? fail_line(c, "more of the header; the file is cut short, or no Gaussian cube") : st;
}

/* A whole number and three finite ones; *rest is what follows. */
static bool scan_row(int64_t *n, double v[3], const char *line, const char **rest)
{
    if (!vvi_scan_int(n, line, &line))
        return false;
    for (int i = 0; i < 3; i++)
        if (!vvi_scan_real(&v[i], line, &line) || !isfinite(v[i]))
            return false;
    *rest = line;
    return true;
}

/* The third line of a file that begins like one, for the probe: a count and three numbers with fractions. */
static bool looks_like_origin(const char *line)
{
    int64_t n, values;
    double v[3];
    const char *rest;
    if (!scan_row(&n, v, line, &rest) || n == 0 || !memchr(line, '.', (size_t)(rest - line)))
        return false;
    const char *end = rest + strspn(rest, " \t\r");
    return *end == 0 || (vvi_scan_int(&values, rest, &end) && end[strspn(end, " \t\r")] == 0);
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    char text[4097];
    const char *line = text;
    memcpy(text, head, n < 4096 ? n : 4096);
    text[n < 4096 ? n : 4096] = 0;
    for (int i = 0; i < 2; i++) {
        if (!(line = strchr(line, '\n')))
            return 0;
        line++;
    }
    for (int i = 0; i < 4; i++) {
        char *end = strchr(line, '\n');
        int64_t count;
        double v[3];
        const char *rest;
        if (!end)
            return 0;
        *end = 0;
        if (i == 0 ? !looks_like_origin(line)
                   : !scan_row(&count, v, line, &rest) || rest[strspn(rest, " \t\r")] || count == 0)
            return 0;
        line = end + 1;
    }
    return 1;
}

static vv_status read_titles(cube *c, vv_notes *notes)
{
    static const char *const keys[2] = {"title", "about"};
    vv_status st = VV_OK;
    for (int i = 0; i < 2 && st == VV_OK; i++) {
        const char *line;
        if ((st = next_line(c, &line)) != VV_OK)
            return st;
        line += strspn(line, " \t");
        if (*line)
            st = vvi_notes_add(notes, keys[i], line);
    }
    return st;
}

static vv_status read_box(cube *c)
{
    const char *line, *rest;
    int64_t values;
    vv_status st = next_line(c, &line);
    if (st != VV_OK)
        return st;
    if (!scan_row(&c->n_atoms, c->origin, line, &rest) || c->n_atoms < -1000000 || c->n_atoms > 1000000)
        return fail_line(c, "the number of atoms and the origin, three finite numbers");
    c->orbitals = c->n_atoms < 0;
    c->n_atoms = c->orbitals ? -c->n_atoms : c->n_atoms;
    c->per_place = 1;
    if (vvi_scan_int(&values, rest, &rest)) {
        if (values < 1 || values > COMPONENTS_MOST)
            return fail_line(c, "1 to 4096 values at each point");
        c->per_place = values;
    }
    for (int a = 0; a < 3; a++) {
        if ((st = next_line(c, &line)) != VV_OK)
            return st;
        if (!scan_row(&c->n[a], c->step[a], line, &rest) || c->n[a] == 0 || c->n[a] < -INT32_MAX || c->n[a] > INT32_MAX)
            return fail_line(c, "a number of steps along an axis, not 0, and the step, three finite numbers");
        c->angstrom = c->angstrom || c->n[a] < 0;
        c->n[a] = c->n[a] < 0 ? -c->n[a] : c->n[a];
    }
    return VV_OK;
}

/* Atoms as "6 1.5 0 -2", numbers of the elements and places in angstrom. */
static vv_status read_atoms(cube *c, vv_notes *notes)
{
    const double unit = c->angstrom ? 1 : BOHR;
    char key[32], number[32];
    vv_status st = VV_OK;
    snprintf(number, sizeof number, "%" PRId64, c->n_atoms);
    st = vvi_notes_add(notes, "atoms", number);
    for (int64_t i = 0; i < c->n_atoms && st == VV_OK; i++) {
        const char *line;
        double v[4];
        int64_t element;
        if ((st = next_line(c, &line)) != VV_OK)
            return st;
        bool good = vvi_scan_int(&element, line, &line);
        for (int k = 0; k < 4; k++)
            good = good && vvi_scan_real(&v[k], line, &line);
        if (!good)
            return fail_line(c, "an atom: its element, its charge and its position");
        char text[160], place[3][32];
        for (int k = 0; k < 3; k++)
            vvi_print_number(place[k], round(v[k + 1] * unit * 1e6) / 1e6);
        snprintf(key, sizeof key, "atom %" PRId64, i + 1);
        snprintf(text, sizeof text, "%" PRId64 " %s %s %s", element, place[0], place[1], place[2]);
        if (i < ATOMS_LISTED)
            st = vvi_notes_add(notes, key, text);
    }
    return st;
}

/* How many orbitals and which they are: numbers over as many lines as it takes. */
static vv_status read_orbitals(cube *c, vv_notes *notes)
{
    int64_t wanted = 0;
    vvi_text list = {0};
    for (int64_t got = -1; got < wanted;) {
        const char *line;
        int64_t v;
        vv_status st = next_line(c, &line);
        if (st != VV_OK) {
            vvi_text_free(&list);
            return st;
        }
        const int64_t before = got;
        for (; got < wanted && vvi_scan_int(&v, line, &line); got++) {
            if (got < 0)
                wanted = v;
            else
                vvi_text_printf(&list, "%s%" PRId64, got ? " " : "", v);
        }
        if (got == before || wanted < 1 || wanted > COMPONENTS_MOST || line[strspn(line, " \t")]) {
            vvi_text_free(&list);
            return fail_line(c, "the number of orbitals, 1 to 4096, and the number of each");
        }
    }
    c->per_place = wanted;
    vv_status st = list.bad ? vv_fail_memory(list.n) : vvi_notes_add(notes, "orbitals", list.s);
    vvi_text_free(&list);
    return st;
}

static void place(vv_field_info *info, const cube *c)
{
    const double unit = c->angstrom ? 1 : BOHR;
    vv_affine *map = &info->grid.index_to_world;
    for (int a = 0; a < 3; a++) {
        info->grid.dims[a] = c->n[a];
        map->axis[a] = (vv_vec3){c->step[a][0] * unit, c->step[a][1] * unit, c->step[a][2] * unit};
    }
    map->origin = (vv_vec3){c->origin[0] * unit, c->origin[1] * unit, c->origin[2] * unit};
    strcpy(info->grid.unit, "A");
    info->type = VV_TYPE_F32;
    info->components = (int)c->per_place;
}

/* The last axis is the fastest, but for the values of one place. */
static void lay_out(vvi_data_files *d, const cube *c)
{
    vvi_layout *layout = &d->layout;
    *layout = (vvi_layout){.type = VV_TYPE_F32};
    if (c->per_place > 1)
        layout->axis[layout->n_axes++] = (vvi_layout_axis){c->per_place, VVI_ROLE_COMPONENT};
    for (int a = 2; a >= 0; a--)
        layout->axis[layout->n_axes++] = (vvi_layout_axis){c->n[a], (vvi_role)(VVI_ROLE_X + a)};
}

static vv_status parse(cube *c, vv_notes *notes)
{
    vv_status st = read_titles(c, notes);
    if (st == VV_OK)
        st = read_box(c);
    if (st == VV_OK)
        st = read_atoms(c, notes);
    return st == VV_OK && c->orbitals ? read_orbitals(c, notes) : st;
}

static void free_plan(void *plan)
{
    vvi_data_files_finish(plan);
    vvi_free(plan);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    cube c = {.source = source};
    *plan_out = NULL;
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK || (st = parse(&c, notes)) != VV_OK)
        return st;
    vvi_data_files *d = vvi_alloc_zeroed(job, sizeof *d, VVI_MEM_MODEL);
    if (!d)
        return vv_fail_memory(sizeof *d);
    *d = (vvi_data_files){.header = vvi_source_name(source), .limits = vvi_job_limits(job), .numbers = true};
    d->coded_bytes = UINT64_MAX;
    d->skip = (int64_t)vvi_source_tell(source);
    place(info, &c);
    lay_out(d, &c);
    if ((st = vvi_data_files_check(d, source, job)) != VV_OK)
        free_plan(d);
    else
        *plan_out = d;
    return st;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    return vvi_data_files_read(out, info, plan, source, frame, region, job);
}

static const char *const suffixes[] = {".cube", ".cub", NULL};

const vv_format vvi_format_cube = {
    .api = VV_FORMAT_API,
    .name = "cube",
    .doc = "Gaussian cube files: densities and orbitals of molecules, in angstrom; atoms are metadata",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
};

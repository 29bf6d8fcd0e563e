#include "worlds.h"
#include "core/text.h"
#include "fields.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint64_t test_roll(test_dice *dice, uint64_t n)
{
    return test_random(dice->seed, dice->index++) % n;
}

static double any_bits(test_dice *dice)
{
    double value = NAN;
    while (!isfinite(value)) {
        const uint64_t bits = test_random(dice->seed, dice->index++);
        memcpy(&value, &bits, sizeof value);
    }
    return value;
}

double test_roll_double(test_dice *dice)
{
    static const double corners[] = {0.0,
                                     -0.0,
                                     5e-324,
                                     -2.2250738585072009e-308,
                                     1.7976931348623157e308,
                                     0.1,
                                     1e22,
                                     1e23,
                                     9007199254740993.0,
                                     1e16,
                                     123456789012345680.0,
                                     1.0 / 3,
                                     1e-7};
    switch (test_roll(dice, 4)) {
    case 0:
        return corners[test_roll(dice, sizeof corners / sizeof *corners)];
    case 1:
        return (double)test_roll(dice, 2000) - 1000;
    case 2:
        return ((double)test_roll(dice, UINT64_C(1) << 53) * 0x1p-53 - 0.5) * 1000;
    default:
        return any_bits(dice);
    }
}

static double roll_number(test_dice *dice, const vv_property *p)
{
    double value = test_roll_double(dice);
    if (!p->limited || (value >= p->min && value <= p->max))
        return value;
    const double lo = p->min, hi = p->max > 1e6 ? lo + 1e6 : p->max;
    value = lo + (hi - lo) * ((double)test_roll(dice, UINT64_C(1) << 53) * 0x1p-53);
    return test_roll(dice, 8) ? value : test_roll(dice, 2) ? lo : p->max;
}

static void add_number(vvi_text *text, double value)
{
    /* the tests never change the locale while worlds are made */
    if (value == 0)
        vvi_text_add(text, signbit(value) ? "-0.0" : "0");
    else
        vvi_text_printf(text, "%.17g", value);
}

static void add_string(test_dice *dice, vvi_text *text)
{
    static const char *const pieces[] = {"a",
                                         "Z9",
                                         " ",
                                         "\"",
                                         "\\",
                                         "\n",
                                         "\t",
                                         "\x01",
                                         "/",
                                         ".",
                                         "\x7f",
                                         "é",
                                         "\xe2\x82\xac",
                                         "{}",
                                         "\xf0\x9f\xa7\xa0",
                                         "null",
                                         "1e5",
                                         "'",
                                         "crc32:89abcdef"};
    vvi_text plain = {0};
    vvi_text_add(&plain, "");
    for (uint64_t n = test_roll(dice, 8); n > 0; n--)
        vvi_text_add(&plain, pieces[test_roll(dice, sizeof pieces / sizeof *pieces)]);
    vvi_text_json(text, plain.s ? plain.s : "");
    vvi_text_free(&plain);
}

static void add_name(test_dice *dice, vvi_text *text)
{
    static const char *const names[] = {"head", "key", "A-1", "_x", "b2", "main"};
    vvi_text_json(text, names[test_roll(dice, sizeof names / sizeof *names)]);
}

static void add_table_name(test_dice *dice, vvi_text *text, const vv_property *p, const vv_property_context *context)
{
    const char *name = NULL;
    size_t n = 0;
    while (context->variant && context->variant(context->user, p->table, n, &name))
        n++;
    if (n && context->variant(context->user, p->table, test_roll(dice, n), &name))
        vvi_text_json(text, name);
    else
        add_name(dice, text);
}

static void add_vector(test_dice *dice, vvi_text *text, const vv_property *p)
{
    for (int i = 0; i < 3; i++) {
        vvi_text_add(text, i ? "," : "[");
        add_number(text, roll_number(dice, p));
    }
    vvi_text_add(text, "]");
}

static void add_color(test_dice *dice, vvi_text *text)
{
    const int n = 3 + (int)test_roll(dice, 2);
    if (test_roll(dice, 2)) {
        vvi_text_printf(text, n == 3 ? "\"#%06x\"" : "\"#%08x\"",
                        (unsigned)test_roll(dice, n == 3 ? 1 << 24 : UINT64_C(1) << 32));
        return;
    }
    for (int i = 0; i < n; i++) {
        vvi_text_add(text, i ? "," : "[");
        add_number(text,
                   i < 3 && !test_roll(dice, 4) ? fabs(test_roll_double(dice)) : (double)test_roll(dice, 1001) / 1000);
    }
    vvi_text_add(text, "]");
}

/* Rows by ascending first column, the others within 0..1: what transfer functions and label tables want. */
static void add_rows(test_dice *dice, vvi_text *text, const vv_property *p)
{
    const int columns = p->columns > 1 ? p->columns : 1;
    const uint64_t n = test_roll(dice, 6);
    double first = (double)test_roll(dice, 100) - 50;
    vvi_text_add(text, "[");
    for (uint64_t i = 0; i < n; i++) {
        vvi_text_add(text, i ? ",[" : columns > 1 ? "[" : "");
        first += (double)test_roll(dice, 1000) / 7;
        add_number(text, first);
        for (int c = 1; c < columns; c++) {
            vvi_text_add(text, ",");
            add_number(text, (double)test_roll(dice, 1001) / 1000);
        }
        vvi_text_add(text, columns > 1 ? "]" : "");
    }
    vvi_text_add(text, "]");
}

static size_t count(const char *const *names)
{
    size_t n = 0;
    while (names[n])
        n++;
    return n;
}

static void add_value(test_dice *dice, vvi_text *text, const vv_property *p, const vv_property_context *context)
{
    switch (p->kind) {
    case VV_KIND_BOOL:
        vvi_text_add(text, test_roll(dice, 2) ? "true" : "false");
        break;
    case VV_KIND_I64:
        vvi_text_printf(text, "%.0f",
                        floor(roll_number(dice, &(vv_property){.limited = true,
                                                               .min = p->limited ? p->min : -1e15,
                                                               .max = p->limited ? p->max : 1e15})));
        break;
    case VV_KIND_F64:
        add_number(text, roll_number(dice, p));
        break;
    case VV_KIND_ENUM:
        vvi_text_json(text, p->names[test_roll(dice, count(p->names))]);
        break;
    case VV_KIND_STRING:
        if (p->table)
            add_table_name(dice, text, p, context);
        else
            add_string(dice, text);
        break;
    case VV_KIND_PATH:
        add_string(dice, text);
        break;
    case VV_KIND_REF:
        add_name(dice, text);
        break;
    case VV_KIND_VEC3:
        add_vector(dice, text, p);
        break;
    case VV_KIND_COLOR:
        add_color(dice, text);
        break;
    case VV_KIND_NUMBERS:
        add_rows(dice, text, p);
        break;
    case VV_KIND_LIST:
        vvi_text_add(text, test_roll(dice, 2) ? "[]" : "[{}, {}]");
        break;
    default:
        vvi_text_add(text, test_roll(dice, 2) || p->kind == VV_KIND_OBJECT ? "{}" : "{\"one\": {}, \"two\": {}}");
        break;
    }
}

char *test_roll_value(test_dice *dice, const vv_property *property, const vv_property_context *context)
{
    vvi_text text = {0};
    add_value(dice, &text, property, context);
    return vvi_text_take(&text);
}

/* Rows of an object and its own objects; entries are added by the caller. */
typedef struct spree {
    test_dice *dice;
    vv_object **root;
    const vv_property_context *context;
    char **paths;
    const vv_property **rows;
    size_t n, room;
} spree;

static bool note_path(void *user, const char *path, const vv_property *property, const vv_object *owner)
{
    spree *s = user;
    (void)owner;
    if (s->n == s->room) {
        s->room = s->room ? 2 * s->room : 64;
        s->paths = realloc(s->paths, s->room * sizeof *s->paths);
        s->rows = realloc(s->rows, s->room * sizeof *s->rows);
    }
    s->paths[s->n] = strdup(path);
    s->rows[s->n++] = property;
    return true;
}

static void forget_paths(spree *s)
{
    for (size_t i = 0; i < s->n; i++)
        free(s->paths[i]);
    free(s->paths);
    free(s->rows);
    s->paths = NULL;
    s->rows = NULL;
    s->n = s->room = 0;
}

static void add_entries(spree *s)
{
    static const char *const names[] = {"head", "key", "A-1", "_x", "b2", "main"};
    vv_path_each(*s->root, note_path, s);
    for (size_t i = 0; i < s->n; i++) {
        const bool map = s->rows[i]->kind == VV_KIND_MAP;
        if (!map && s->rows[i]->kind != VV_KIND_LIST)
            continue;
        for (uint64_t n = test_roll(s->dice, 4); n > 0; n--)
            vv_path_add(s->root, s->paths[i], map ? names[test_roll(s->dice, 6)] : NULL, NULL, s->context);
    }
    forget_paths(s);
}

static bool is_plain(const vv_property *p)
{
    return p->kind != VV_KIND_OBJECT && p->kind != VV_KIND_LIST && p->kind != VV_KIND_MAP;
}

void test_roll_object(test_dice *dice, vv_object **root, int share, const vv_property_context *context)
{
    spree s = {.dice = dice, .root = root, .context = context};
    add_entries(&s); /* maps of the root */
    add_entries(&s); /* lists inside of what was added */
    vv_path_each(*root, note_path, &s);
    for (size_t i = 0; i < s.n; i++) {
        if (!is_plain(s.rows[i]) || !strcmp(s.paths[i], "schema") || (int)test_roll(dice, 256) >= share)
            continue;
        char *json = test_roll_value(dice, s.rows[i], context);
        vv_path_set(root, s.paths[i], json, context); /* a class may refuse what its row allows */
        free(json);
    }
    forget_paths(&s);
}

vv_object *test_roll_world(test_dice *dice, int share, const vv_property_context *context)
{
    vv_object *world = NULL;
    if (vv_object_new(&world, &vv_world_class, context) == VV_OK)
        test_roll_object(dice, &world, share, context);
    return world;
}

char *test_roll_path(test_dice *dice, const vv_property **property_out, const vv_object *world)
{
    spree s = {.dice = dice};
    vv_path_each(world, note_path, &s);
    const size_t i = test_roll(dice, s.n);
    char *path = strdup(s.paths[i]);
    *property_out = s.rows[i];
    forget_paths(&s);
    return path;
}

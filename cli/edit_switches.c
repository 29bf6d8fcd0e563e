/* --decorate and --aov: which switches of the view are on, by a list of their names. */
#include "core/names.h"
#include "edits.h"
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <volvis/image.h>

enum { MOST = 32 };

/* An option, and the object of the view that has its switches. */
typedef struct switches {
    const char *option, *path;
    const char *unknown; /* the sentence's begin of a name that there is not */
    bool takes_all;
} switches;

static const switches decorations = {"decorate", "decorations", "--decorate: there is no", true};
static const switches layers = {"aov", "render.layers", "--aov: no layer", false};

/* A row of the object by number, of those that are on or off; NULL past the last. */
static const vv_property *switch_nth(const switches *s, size_t index)
{
    const vv_property *row = NULL;
    const vv_class *cls = NULL;
    if (vv_path_row(&row, &cls, &vv_view_class, s->path, NULL) != VV_OK)
        return NULL;
    for (row = cls->properties; row->name; row++)
        if (row->kind == VV_KIND_BOOL && index-- == 0)
            return row;
    return NULL;
}

const char *cli_decoration_word(size_t index)
{
    static const char *const others[] = {"all", "none"};
    static char words[MOST][32]; /* the same whoever asks */
    size_t n = 0;
    while (n < MOST && switch_nth(&decorations, n))
        n++;
    if (index >= n)
        return index < n + 2 ? others[index - n] : NULL;
    snprintf(words[index], sizeof words[index], "%s", switch_nth(&decorations, index)->name);
    for (char *c = words[index]; *c; c++)
        *c = *c == '_' ? '-' : *c;
    return words[index];
}

/* scale-bar is scale_bar, and so is Scale-Bar. */
static bool same(const char *name, const char *word, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (name[i] != (word[i] == '-' ? '_' : tolower((unsigned char)word[i])))
            return false;
    return name[n] == 0;
}

static vv_status fail_word(const switches *s, const char *word, size_t n)
{
    const char *names[MOST], *name;
    size_t n_names = 0;
    char typed[32];
    snprintf(typed, sizeof typed, "%.*s", (int)(n < 30 ? n : 30), word);
    for (int i = 0; s->takes_all && i < 2; i++)
        if (strcasecmp(typed, i ? "all" : "none") == 0)
            return vv_fail(VV_E_ARGUMENT, "--decorate: '%s' stands alone: it takes %s; name it, or the others",
                           i ? "all" : "none", i ? "every decoration" : "every decoration away");
    while (n_names < MOST && (name = s->takes_all ? cli_decoration_word(n_names) : vv_layer_name(n_names)))
        names[n_names++] = name;
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, typed, &(vvi_known){names, n_names, NULL, NULL}, "%s '%s'",
                         s->unknown, typed);
}

/* Those that are named, and no others: "none" takes away what a scene asks for. */
static vv_status parse(uint32_t *out, const switches *s, const char *typed)
{
    *out = s->takes_all && strcasecmp(typed, "all") == 0 ? UINT32_MAX : 0;
    if (*out || strcasecmp(typed, "none") == 0)
        return VV_OK;
    for (const char *word = typed;; word++) {
        const size_t n = strcspn(word, ",");
        const vv_property *row;
        size_t i = 0;
        while ((row = switch_nth(s, i)) && !same(row->name, word, n))
            i++;
        if (!row || n == 0)
            return fail_word(s, word, n);
        *out |= 1u << i;
        word += n;
        if (!*word)
            return VV_OK;
    }
}

/* Measurements show where a scene has some: only "none" takes what is on by itself away. */
static vv_status set_switches(cli_edits *edits, const switches *s, const char *typed, bool take_away)
{
    const vv_property *row;
    uint32_t wanted = 0;
    vv_status st = parse(&wanted, s, typed);
    for (size_t i = 0; st == VV_OK && (row = switch_nth(s, i)); i++) {
        const bool by_itself = row->def != 0;
        st = (by_itself ? take_away : wanted >> i & 1)
                 ? cli_edit_set(edits, s->option, by_itself ? "false" : "true", "views.%s.%s.%s", edits->view, s->path,
                                row->name)
                 : cli_edit_unset(edits, "views.%s.%s.%s", edits->view, s->path, row->name);
    }
    return st;
}

static bool has_measurements(const cli_edits *edits)
{
    vv_world *world = vv_model_snapshot(edits->model);
    const bool some = world->measurements->n > 0;
    vv_object_release(&world->base);
    return some;
}

vv_status cli_edit_switches(cli_edits *edits)
{
    const char *typed = edits->look->decorate;
    const bool none = typed && strcasecmp(typed, "none") == 0;
    vv_status st = edits->look->aov ? set_switches(edits, &layers, edits->look->aov, false) : VV_OK;
    if (st == VV_OK && typed)
        st = set_switches(edits, &decorations, typed, none && has_measurements(edits));
    if (st == VV_OK && none && (st = cli_edit_unset(edits, "views.%s.decorations.title", edits->view)) == VV_OK)
        st = cli_edit_unset(edits, "views.%s.decorations.caption", edits->view);
    return st;
}

unsigned cli_layers_of(const vv_view *view)
{
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)view->render;
    const vv_layer_choice *chosen = (const vv_layer_choice *)(const void *)choice->layers;
    const bool on[VV_LAYER_COUNT] = {chosen->depth, chosen->normal, chosen->id, chosen->samples, chosen->value};
    unsigned bits = 0;
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        bits |= on[i] ? 1u << i : 0;
    return bits;
}

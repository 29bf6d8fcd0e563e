/* --decorate, --title, --caption: what is drawn over the picture. */
#include "core/names.h"
#include "edits.h"
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { MOST = 32 };

/* The decorations that are on or off: rows of the view's class. */
const char *cli_decoration_name(size_t index)
{
    const vv_property *row = vv_class_find(&vv_view_class, "decorations");
    for (const vv_property *p = row ? row->cls->properties : NULL; p && p->name; p++)
        if (p->kind == VV_KIND_BOOL && index-- == 0)
            return p->name;
    return NULL;
}

const char *cli_decoration_word(size_t index)
{
    static const char *const others[] = {"all", "none"};
    static char words[MOST][32]; /* the same whoever asks */
    size_t n = 0;
    while (n < MOST && cli_decoration_name(n))
        n++;
    if (index >= n)
        return index < n + 2 ? others[index - n] : NULL;
    snprintf(words[index], sizeof words[index], "%s", cli_decoration_name(index));
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

static bool is_word(const char *word, size_t n, const char *name)
{
    return strlen(name) == n && strncasecmp(word, name, n) == 0;
}

static vv_status fail_word(const char *word, size_t n)
{
    for (int i = 0; i < 2; i++)
        if (is_word(word, n, i ? "all" : "none"))
            return vv_fail(VV_E_ARGUMENT, "--decorate: '%s' stands alone: it takes %s; name it, or the others",
                           i ? "all" : "none", i ? "every decoration" : "every decoration away");
    const char *names[MOST], *name;
    size_t n_names = 0;
    char typed[32];
    for (; n_names < MOST && (name = cli_decoration_word(n_names)) != NULL; n_names++)
        names[n_names] = name;
    snprintf(typed, sizeof typed, "%.*s", (int)(n < 30 ? n : 30), word);
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, typed, &(vvi_known){names, n_names, NULL, NULL},
                         "--decorate: there is no '%s'", typed);
}

/* Measurements show where a scene has some: only "none" takes them away. */
static bool is_on_by_itself(const char *name)
{
    const vv_property *row = vv_class_find(&vv_view_class, "decorations");
    return vv_class_find(row->cls, name)->def != 0;
}

static bool has_measurements(const cli_edits *edits)
{
    vv_world *world = vv_model_snapshot(edits->model);
    const bool some = world->measurements->n > 0;
    vv_object_release(&world->base);
    return some;
}

/* Those that are named, and no others: "none" takes away what a scene asks for. */
static vv_status parse(uint32_t *out, const char *typed)
{
    *out = 0;
    if (strcasecmp(typed, "all") == 0)
        *out = UINT32_MAX;
    if (*out || strcasecmp(typed, "none") == 0)
        return VV_OK;
    for (const char *word = typed;; word++) {
        const size_t n = strcspn(word, ",");
        const char *name;
        size_t i = 0;
        while ((name = cli_decoration_name(i)) != NULL && !same(name, word, n))
            i++;
        if (!name || n == 0)
            return fail_word(word, n);
        *out |= 1u << i;
        word += n;
        if (!*word)
            return VV_OK;
    }
}

/* Free text, which is never read as JSON. */
static vv_status set_text(cli_edits *edits, const char *option, const char *text)
{
    vvi_text json = {0};
    if (!text)
        return VV_OK;
    vvi_text_json(&json, text);
    const vv_status st = json.bad ? vv_fail_memory(json.n)
                                  : cli_edit_set(edits, option, json.s, "views.%s.decorations.%s", edits->view, option);
    vvi_text_free(&json);
    return st;
}

vv_status cli_edit_decorations(cli_edits *edits)
{
    const char *typed = edits->look->decorate, *name;
    const bool take_away = typed && strcasecmp(typed, "none") == 0 && has_measurements(edits);
    uint32_t wanted = 0;
    vv_status st = typed ? parse(&wanted, typed) : VV_OK;
    for (size_t i = 0; typed && st == VV_OK && (name = cli_decoration_name(i)) != NULL; i++) {
        const bool by_itself = is_on_by_itself(name);
        st = (by_itself ? take_away : wanted >> i & 1)
                 ? cli_edit_set(edits, "decorate", by_itself ? "false" : "true", "views.%s.decorations.%s", edits->view,
                                name)
                 : cli_edit_unset(edits, "views.%s.decorations.%s", edits->view, name);
    }
    if (typed && strcasecmp(typed, "none") == 0 && st == VV_OK &&
        (st = cli_edit_unset(edits, "views.%s.decorations.title", edits->view)) == VV_OK)
        st = cli_edit_unset(edits, "views.%s.decorations.caption", edits->view);
    if (st == VV_OK)
        st = set_text(edits, "title", edits->look->title);
    return st == VV_OK ? set_text(edits, "caption", edits->look->caption) : st;
}

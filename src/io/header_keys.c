#include "io/header_keys.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/scan.h"
#include "io/source.h"
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define BLANKS " \t\r"
/* Each line is compared with those before it. No header of these formats has a tenth as many. */
#define KEYS_MOST 4096

static void trim(const char **text, size_t *n)
{
    while (*n > 0 && strchr(BLANKS, **text)) {
        ++*text;
        --*n;
    }
    while (*n > 0 && strchr(BLANKS, (*text)[*n - 1]))
        --*n;
}

static char *copy(const char *text, size_t n)
{
    char *out = vvi_calloc(n + 1, 1);
    if (out && n > 0)
        memcpy(out, text, n);
    return out;
}

bool vvi_keys_split(const char *line, const char *separators, size_t *n_name, const char **value)
{
    const char *at = strpbrk(line, separators);
    if (!at)
        return false;
    *value = at + 1;
    *n_name = (size_t)(at - line);
    const char *name = line;
    size_t n = *n_name;
    trim(&name, &n);
    return n > 0;
}

static vvi_key *find(const vvi_keys *keys, const char *name, size_t n)
{
    for (size_t i = 0; i < keys->n; i++)
        if (strlen(keys->key[i].name) == n && strncasecmp(keys->key[i].name, name, n) == 0)
            return &keys->key[i];
    return NULL;
}

vv_status vvi_keys_add(vvi_keys *keys, const char *name, size_t n_name, const char *value, size_t n_value, int line)
{
    char where[16];
    snprintf(where, sizeof where, "%d", line);
    trim(&name, &n_name);
    trim(&value, &n_value);
    const vvi_key *old = find(keys, name, n_name);
    if (old)
        return vv_fail_at(VV_E_FORMAT, keys->file, where, "'%.40s' appears twice; it was given in line %d", old->name,
                          old->line);
    if (keys->n >= KEYS_MOST)
        return vv_fail_at(VV_E_FORMAT, keys->file, where, "its header has more than %d lines", KEYS_MOST);
    if ((keys->n & (keys->n - 1)) == 0) { /* room doubles at powers of two */
        const size_t room = keys->n ? keys->n * 2 : 1;
        vvi_key *grown = vvi_realloc_plain(keys->key, room * sizeof *grown);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        keys->key = grown;
    }
    const vvi_key key = {copy(name, n_name), copy(value, n_value), line, false};
    keys->key[keys->n++] = key;
    return key.name && key.value ? VV_OK : vv_fail_memory(n_name + n_value);
}

void vvi_keys_finish(vvi_keys *keys)
{
    for (size_t i = 0; i < keys->n; i++) {
        free(keys->key[i].name);
        free(keys->key[i].value);
    }
    free(keys->key);
    *keys = (vvi_keys){0};
}

const char *vvi_keys_get(vvi_keys *keys, const char *name)
{
    vvi_key *key = find(keys, name, strlen(name));
    if (!key)
        return NULL;
    key->used = true;
    return key->value;
}

const char *vvi_keys_first(vvi_keys *keys, const char *const *names)
{
    const char *first = NULL;
    for (; *names; names++) /* all of them, so that none is left over as metadata */
        if (vvi_keys_get(keys, *names) && !first)
            first = *names;
    return first;
}

vv_status vvi_keys_fail(const vvi_keys *keys, const char *name, const char *format, ...)
{
    char where[16], text[400];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    const vvi_key *key = find(keys, name, strlen(name));
    snprintf(where, sizeof where, "%d", key ? key->line : 0);
    return vv_fail_at(VV_E_FORMAT, keys->file, key ? where : NULL, "'%s' %s", name, text);
}

vv_status vvi_keys_need(vvi_keys *keys, const char *name)
{
    return vvi_keys_get(keys, name) ? VV_OK : vv_fail_at(VV_E_FORMAT, keys->file, NULL, "its header has no '%s'", name);
}

/* Numbers -------------------------------------------------------------------------------------------------------- */

static bool at_end(const char *text)
{
    return text[strspn(text, BLANKS)] == 0;
}

vv_status vvi_keys_ints(int64_t *out, int n, vvi_keys *keys, const char *name, int64_t lo, int64_t hi)
{
    const char *text = vvi_keys_get(keys, name), *at = text;
    for (int i = 0; text && i < n; i++) {
        if (!vvi_scan_int(&out[i], at, &at))
            return n == 1 ? vvi_keys_fail(keys, name, "is '%.40s', not a whole number", text)
                          : vvi_keys_fail(keys, name, "is '%.60s'; expected %d whole numbers", text, n);
        if (out[i] < lo || out[i] > hi)
            return hi == INT64_MAX ? vvi_keys_fail(keys, name, "has %lld; it must be %lld or more", (long long)out[i],
                                                   (long long)lo)
                                   : vvi_keys_fail(keys, name, "has %lld; %lld to %lld are possible", (long long)out[i],
                                                   (long long)lo, (long long)hi);
    }
    if (text && !at_end(at))
        return vvi_keys_fail(keys, name, "is '%.60s'; expected %d whole number%s and nothing more", text, n,
                             n == 1 ? "" : "s");
    return VV_OK;
}

vv_status vvi_keys_int(int64_t *out, vvi_keys *keys, const char *name, int64_t lo, int64_t hi)
{
    return vvi_keys_ints(out, 1, keys, name, lo, hi);
}

vv_status vvi_keys_dims(int64_t *out, int n, vvi_keys *keys, const char *name, const vv_limits *limits)
{
    const vv_status st = vvi_keys_ints(out, n, keys, name, 1, INT64_MAX);
    for (int i = 0; st == VV_OK && vvi_keys_get(keys, name) && i < n; i++)
        if ((uint64_t)out[i] > limits->dim)
            return vvi_keys_fail(keys, name, "has %lld; 1 to %llu are possible (--limit dim=N allows more)",
                                 (long long)out[i], (unsigned long long)limits->dim);
    return st;
}

vv_status vvi_keys_reals(double *out, int n, vvi_keys *keys, const char *name)
{
    const char *text = vvi_keys_get(keys, name), *at = text;
    for (int i = 0; text && i < n; i++)
        if (!vvi_scan_real(&out[i], at, &at) || !isfinite(out[i]))
            return vvi_keys_fail(keys, name, "is '%.60s'; expected %d finite number%s", text, n, n == 1 ? "" : "s");
    if (text && !at_end(at))
        return vvi_keys_fail(keys, name, "is '%.60s'; expected %d number%s and nothing more", text, n,
                             n == 1 ? "" : "s");
    return VV_OK;
}

vv_status vvi_keys_flag(bool *out, vvi_keys *keys, const char *name)
{
    static const char *const words[] = {"true", "false", "yes", "no", "1", "0", "t", "f"};
    const char *text = vvi_keys_get(keys, name);
    for (size_t i = 0; text && i < sizeof words / sizeof *words; i++)
        if (strcasecmp(text, words[i]) == 0) {
            *out = i % 2 == 0;
            return VV_OK;
        }
    return text ? vvi_keys_fail(keys, name, "is '%.40s'; expected True or False", text) : VV_OK;
}

static const struct {
    const char *name;
    int least, most; /* components */
} meanings[] = {
    [VV_MEANING_SCALAR] = {"scalar", 1, INT_MAX}, [VV_MEANING_RGB] = {"rgb", 3, 3},
    [VV_MEANING_RGBA] = {"rgba", 4, 4},           [VV_MEANING_VECTOR] = {"vector", 1, INT_MAX},
    [VV_MEANING_LABEL] = {"label", 1, 1},
};

const char *vvi_meaning_name(vv_meaning meaning)
{
    return meanings[meaning].name;
}

vv_status vvi_keys_meaning(vv_field_info *info, vvi_keys *keys, const char *name)
{
    const char *text = vvi_keys_get(keys, name);
    for (int i = 0; text && i < (int)(sizeof meanings / sizeof *meanings); i++) {
        if (strcasecmp(text, meanings[i].name) != 0)
            continue;
        if (info->components < meanings[i].least || info->components > meanings[i].most)
            return vvi_keys_fail(keys, name, "is %s, which samples of %d channels cannot be", meanings[i].name,
                                 info->components);
        if (i == VV_MEANING_LABEL && vv_type_is_float(info->type))
            return vvi_keys_fail(keys, name, "is label, but the samples are floats; labels are whole numbers");
        info->meaning = (vv_meaning)i;
        return VV_OK;
    }
    return text ? vvi_keys_fail(keys, name, "is '%.40s'; scalar, rgb, rgba, vector and label are known", text) : VV_OK;
}

void vvi_keys_text(char *out, size_t room, vvi_keys *keys, const char *name)
{
    const char *text = vvi_keys_get(keys, name);
    if (!text)
        return;
    const size_t n = vvi_utf8_cut(text, strlen(text), room - 1);
    memcpy(out, text, n);
    out[n] = 0;
}

vv_status vvi_keys_note_rest(const vvi_keys *keys, vv_notes *notes)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < keys->n && st == VV_OK; i++)
        if (!keys->key[i].used)
            st = vvi_notes_add(notes, keys->key[i].name, keys->key[i].value);
    return st;
}

/* Writing ---------------------------------------------------------------------------------------------------------- */

void vvi_keys_print(vvi_text *t, const char *name, const char *separator, const char *value)
{
    if (!value[0])
        return;
    vvi_text_printf(t, "%s%s", name, separator);
    for (; *value; value++)
        vvi_text_add_n(t, *value == '\n' || *value == '\r' ? " " : value, 1);
    vvi_text_add(t, "\n");
}

void vvi_keys_print_numbers(vvi_text *t, const char *name, const char *separator, const double *v, int n)
{
    char number[32];
    vvi_text_printf(t, "%s%s", name, separator);
    for (int i = 0; i < n; i++) {
        vvi_print_unsigned_zero(number, v[i]);
        vvi_text_printf(t, " %s", number);
    }
    vvi_text_add(t, "\n");
}

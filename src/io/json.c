#include "io/json.h"
#include "core/json_text.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/text.h"
#include "grid/label_id.h"
#include "io/scan.h"
#include <math.h>
#include <string.h>

/* What a parsed tree takes for a byte of text, where that is not much: what is more is refused before it is parsed. */
#define TREE_BYTES 48
/* How many times the most bytes of a header it may take, and twice its own: "{},{},..." would take 75 times its own. */
#define TREE_HEADERS 6

static void replace_python_words(char *text, size_t n)
{
    static const char *const words[] = {"-Infinity", "Infinity", "NaN"};
    bool quoted = false;
    for (size_t i = 0; i < n; i++) {
        if (quoted) {
            i += text[i] == '\\';
            quoted = i < n && text[i] != '"';
            continue;
        }
        quoted = text[i] == '"';
        for (size_t w = 0; w < 3; w++) {
            const size_t m = strlen(words[w]);
            if (n - i < m || memcmp(text + i, words[w], m) != 0)
                continue;
            memset(text + i, ' ', m);
            text[i] = text[i + 1] = '"';
            i += m - 1;
            break;
        }
    }
}

/* Those of a number that begins here; 0: none does. */
static size_t number_length(const char *text, size_t n)
{
    size_t i = 0;
    while (i < n && text[i] && strchr("0123456789+-.eE", text[i]))
        i++;
    return i;
}

static bool is_past_64_bits(const char *number, size_t n)
{
    char digits[32] = "";
    int64_t whole;
    const char *end;
    for (size_t i = *number == '-'; i < n; i++)
        if (number[i] < '0' || number[i] > '9')
            return false;
    if (n < sizeof digits)
        memcpy(digits, number, n);
    return n > 18 && !vvi_scan_int(&whole, digits, &end);
}

/* Whether text[at] begins the value of such a key. */
static bool is_value_of(const char *key, const char *text, size_t at)
{
    const size_t n = strlen(key);
    bool colon = false;
    while (at > 0 && strchr(" \t\r\n:", text[at - 1]) && text[at - 1])
        colon |= text[--at] == ':';
    return colon && at >= n && memcmp(text + at - n, key, n) == 0;
}

/* Integers past 64 bits, which the parser refuses, as reals; those that are labels as text, with all of their digits.
 */
static void replace_large(vvi_text *out, const char *text, size_t n)
{
    bool quoted = false;
    size_t done = 0;
    for (size_t i = 0, m; i < n; i += m ? m : 1) {
        m = quoted ? 0 : number_length(text + i, n - i);
        if (text[i] == '"')
            quoted = !quoted;
        else if (quoted && text[i] == '\\')
            m = 2;
        if (quoted || m == 0 || !is_past_64_bits(text + i, m))
            continue;
        const bool label = is_value_of("\"label-value\"", text, i);
        vvi_text_add_n(out, text + done, i - done);
        vvi_text_add(out, label ? "\"" : "");
        vvi_text_add_n(out, text + i, m);
        vvi_text_add(out, label ? "\"" : ".0");
        done = i + m;
    }
    vvi_text_add_n(out, text + done, n - done);
}

static json_t *load_large(const char *text, size_t n, vvi_json_flaw *flaw)
{
    vvi_text replaced = {0};
    replace_large(&replaced, text, n);
    flaw->fault = VVI_JSON_MEMORY;
    json_t *tree = replaced.bad ? NULL : vvi_json_decode(replaced.s, replaced.n, 0, flaw);
    vvi_text_free(&replaced);
    return tree;
}

vv_status vvi_json_read_text(json_t **out, char *text, size_t n, const char *name, const vv_job *job)
{
    vvi_json_flaw flaw;
    char where[48];
    const uint64_t most = vvi_job_limits(job)->nesting;
    if ((uint64_t)vvi_json_nesting(text, n) > most)
        return vv_fail_at(VV_E_LIMIT, name, NULL, "is nested deeper than %llu levels; --limit nesting=N allows more",
                          (unsigned long long)most);
    const uint64_t tree = vvi_json_tree_bytes(text, n), room = TREE_HEADERS * vvi_job_limits(job)->header_bytes + 2 * n;
    if (tree > room)
        return vv_fail_at(VV_E_LIMIT, name, NULL,
                          "holds so many values that they would take %llu MiB; at most %llu are taken for it (--limit "
                          "header_bytes=N allows %d times as much)",
                          (unsigned long long)(tree >> 20), (unsigned long long)(room >> 20), TREE_HEADERS);
    replace_python_words(text, n);
    *out = vvi_json_decode(text, n, 0, &flaw);
    /* numbers past 64 bits: the largest unsigned one is a usual fill value */
    if (!*out && flaw.fault == VVI_JSON_LARGE)
        *out = load_large(text, n, &flaw);
    if (!*out && flaw.fault == VVI_JSON_MEMORY)
        return vv_fail_memory(n);
    snprintf(where, sizeof where, "%d:%d", flaw.line, flaw.column);
    if (!*out)
        return vv_fail_at(VV_E_FORMAT, name, where, "is not JSON: %s", flaw.text);
    if (json_is_object(*out))
        return VV_OK;
    json_decref(*out);
    *out = NULL;
    return vv_fail_at(VV_E_FORMAT, name, NULL, "is JSON, but not an object");
}

vv_status vvi_json_read_beside(json_t **out, const vv_source *folder, const char *name, vv_job *job)
{
    vv_source *source;
    bool exact;
    *out = NULL;
    vv_status st = vvi_source_find_beside(&source, folder, name, job);
    if (st != VV_OK || !source)
        return st;
    const uint64_t n = vvi_source_left(source, &exact);
    char *text = NULL;
    if (n > vvi_job_limits(job)->header_bytes)
        st = vv_fail_at(VV_E_LIMIT, vvi_source_name(source), NULL,
                        "has %llu bytes; at most %llu are read (--limit header_bytes=N allows more)",
                        (unsigned long long)n, (unsigned long long)vvi_job_limits(job)->header_bytes);
    else
        st = vvi_memory_plan(job, n * TREE_BYTES, "metadata");
    if (st == VV_OK && !(text = vvi_alloc(job, (size_t)n + 1, VVI_MEM_SCRATCH)))
        st = vv_fail_memory((size_t)n + 1);
    if (st == VV_OK)
        st = vvi_source_read(source, text, (size_t)n, "metadata");
    if (st == VV_OK)
        st = vvi_json_read_text(out, text, (size_t)n, vvi_source_name(source), job);
    vvi_free(text);
    vvi_source_close(source);
    return st;
}

bool vvi_json_whole(int64_t *out, const json_t *value)
{
    if (json_is_integer(value)) {
        *out = json_integer_value(value);
        return true;
    }
    const double real = json_real_value(value);
    if (!json_is_real(value) || !(fabs(real) <= 0x1p53) || real != floor(real))
        return false;
    *out = (int64_t)real;
    return true;
}

bool vvi_json_label(vv_label_id *out, const json_t *value)
{
    const char *digits = json_string_value(value);
    return digits ? vvi_label_parse(out, digits, true) : vvi_json_whole(out, value);
}

bool vvi_json_real(double *out, const json_t *value)
{
    if (!json_is_number(value) || !isfinite(json_number_value(value)))
        return false;
    *out = json_number_value(value);
    return true;
}

const char *vvi_json_text(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

void vvi_json_copy_text(char *out, size_t room, const char *text)
{
    const size_t n = text ? vvi_utf8_cut(text, strlen(text), room - 1) : 0;
    if (n > 0)
        memcpy(out, text, n);
    out[n] = 0;
    vvi_text_clean(out);
}

/* Declared in json_text.h. One pass over the text; what is said about a flaw is found when there is one. */
#include "core/json_text.h"
#include "core/text.h"
#include "core/units.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* DEEPEST: of what is open at once, since each takes room of the stack. NEAR: letters of a piece that are told. */
enum { DEEPEST = 2048, NEAR = 20 };

typedef struct reader {
    const char *begin, *at, *end;
    size_t flags;
    size_t depth;
    vvi_text kept; /* the names of what is open, each with its 0, and behind them the text or number that is read */
    vvi_json_flaw flaw;
} reader;

/* Flaws ----------------------------------------------------------------------------------------------------------- */

static bool fail_memory(reader *r)
{
    r->flaw.fault = VVI_JSON_MEMORY;
    snprintf(r->flaw.text, sizeof r->flaw.text, "out of memory");
    return false;
}

/* Bytes of the letter at c; 0: it is none. */
static size_t letter_at(const char *c, const char *end)
{
    char last[4] = {0};
    if (end - c > 3 || (unsigned char)*c < 0x80)
        return vvi_utf8_length(c);
    memcpy(last, c, (size_t)(end - c));
    return vvi_utf8_length(last);
}

/* The end of the piece at c, as people see it: a word or number, or a letter. */
static const char *piece_end(const char *c, const char *end)
{
    static const char of_words[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-._";
    const char *at = c;
    while (at < end && *at && strchr(of_words, *at))
        at++;
    if (at == c && at < end) {
        const size_t n = letter_at(c, end);
        at += n ? n : 1;
    }
    return at;
}

/* Says what is wrong with the piece from..to. */
static bool fail_piece(reader *r, const char *what, const char *from, const char *to)
{
    const int n = (int)(to - from);
    r->flaw.line = 1;
    for (const char *c = r->begin; c < to; c++) {
        const bool ends_line = *c == '\n';
        r->flaw.line += ends_line;
        r->flaw.column = ends_line ? 0 : r->flaw.column + ((*c & 0xc0) != 0x80);
    }
    if (n == 0)
        snprintf(r->flaw.text, sizeof r->flaw.text, "%s near its end", what);
    else if (n > NEAR || (unsigned char)*from < ' ' || letter_at(from, r->end) == 0)
        snprintf(r->flaw.text, sizeof r->flaw.text, "%s", what);
    else
        snprintf(r->flaw.text, sizeof r->flaw.text, "%s near '%.*s'", what, n, from);
    return false;
}

static bool fail_here(reader *r, const char *what)
{
    return fail_piece(r, what, r->at, piece_end(r->at, r->end));
}

/* Texts ----------------------------------------------------------------------------------------------------------- */

static void skip_blanks(reader *r)
{
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\n' || *r->at == '\t' || *r->at == '\r'))
        r->at++;
}

/* Whether c comes next, behind blanks; then it is taken. */
static bool take(reader *r, char c)
{
    skip_blanks(r);
    const bool is = r->at < r->end && *r->at == c;
    r->at += is;
    return is;
}

/* Four digits of base 16; -1: they are not there. */
static int32_t hex_at(const char *c, const char *end)
{
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    int32_t code = 0;
    if (end - c < 4)
        return -1;
    for (int i = 0; i < 4; i++) {
        const char *found = c[i] ? strchr(digits, c[i]) : NULL;
        if (!found)
            return -1;
        code = code << 4 | (int32_t)((found - digits) % 16);
    }
    return code;
}

static void keep_code(vvi_text *kept, uint32_t code)
{
    char u[4];
    size_t n = 0;
    if (code < 0x80) {
        u[n++] = (char)code;
    } else if (code < 0x800) {
        u[n++] = (char)(0xc0 | code >> 6);
    } else if (code < 0x10000) {
        u[n++] = (char)(0xe0 | code >> 12);
        u[n++] = (char)(0x80 | (code >> 6 & 0x3f));
    } else {
        u[n++] = (char)(0xf0 | code >> 18);
        u[n++] = (char)(0x80 | (code >> 12 & 0x3f));
        u[n++] = (char)(0x80 | (code >> 6 & 0x3f));
    }
    if (code >= 0x80)
        u[n++] = (char)(0x80 | (code & 0x3f));
    vvi_text_add_n(kept, u, n);
}

/* "\u00e4", or two of them for one letter beyond 16 bits; c: behind the u. Returns what is behind it; NULL: none. */
static const char *keep_coded(reader *r, const char *c)
{
    int32_t code = hex_at(c, r->end);
    size_t n = 4;
    if (code >= 0xd800 && code < 0xdc00 && r->end - c > 6 && c[4] == '\\' && c[5] == 'u') {
        const int32_t low = hex_at(c + 6, r->end);
        code = low >= 0xdc00 && low < 0xe000 ? 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00) : -1;
        n = 10;
    }
    if (code < 0 || (code >= 0xd800 && code < 0xe000))
        return NULL;
    keep_code(&r->kept, (uint32_t)code);
    return c + n;
}

/* c: at the backslash. */
static const char *keep_escape(reader *r, const char *c)
{
    static const char letters[] = "\"\\/bfnrt", bytes[] = "\"\\/\b\f\n\r\t";
    if (r->end - c < 2 || !c[1])
        return NULL;
    if (c[1] == 'u')
        return keep_coded(r, c + 2);
    const char *found = strchr(letters, c[1]);
    if (!found)
        return NULL;
    vvi_text_add_n(&r->kept, &bytes[found - letters], 1);
    return c + 2;
}

/* Adds the text that begins at r->at, a quote, to what is kept. */
static bool keep_text(reader *r)
{
    const char *c = r->at + 1, *plain = c;
    vvi_text_add_n(&r->kept, "", 0); /* so that it is a text even where it is empty */
    while (c < r->end && *c != '"') {
        if (*c == '\\') {
            vvi_text_add_n(&r->kept, plain, (size_t)(c - plain));
            const char *behind = keep_escape(r, c);
            if (!behind)
                return fail_piece(r, "a text has an escape that there is not", c, piece_end(c + 1, r->end));
            plain = c = behind;
            continue;
        }
        const size_t n = (unsigned char)*c < ' ' ? 0 : (unsigned char)*c < 0x80 ? 1 : letter_at(c, r->end);
        if (n == 0)
            return fail_piece(r, (unsigned char)*c < ' ' ? "a text has a control character" : "a text is not UTF-8", c,
                              c + 1);
        c += n;
    }
    if (c == r->end)
        return fail_piece(r, "a text has no end", r->end, r->end);
    vvi_text_add_n(&r->kept, plain, (size_t)(c - plain));
    r->at = c + 1;
    return !r->kept.bad || fail_memory(r);
}

static json_t *read_text(reader *r)
{
    const size_t before = r->kept.n;
    const char *begin = r->at;
    if (!keep_text(r))
        return NULL;
    const char *text = r->kept.s + before;
    const size_t n = r->kept.n - before;
    json_t *value = NULL;
    if (!(r->flags & JSON_ALLOW_NUL) && memchr(text, 0, n))
        fail_piece(r, "a text has the character U+0000", begin, r->at);
    else if (!(value = json_stringn_nocheck(text, n)))
        fail_memory(r);
    vvi_text_cut(&r->kept, before);
    return value;
}

/* Numbers and words ----------------------------------------------------------------------------------------------- */

static const char *skip_digits(const char *c, const char *end)
{
    while (c < end && *c >= '0' && *c <= '9')
        c++;
    return c;
}

/* Behind the number at c; NULL: it is none. */
static const char *number_end(bool *real_out, const char *c, const char *end)
{
    c += *c == '-';
    const char *digits = c;
    c = skip_digits(c, end);
    if (c == digits || (*digits == '0' && c > digits + 1))
        return NULL;
    if (c < end && *c == '.') {
        *real_out = true;
        digits = c + 1;
        if ((c = skip_digits(digits, end)) == digits)
            return NULL;
    }
    if (c < end && (*c == 'e' || *c == 'E')) {
        *real_out = true;
        digits = c + 1;
        digits += digits < end && (*digits == '-' || *digits == '+');
        if ((c = skip_digits(digits, end)) == digits)
            return NULL;
    }
    return c;
}

static json_t *read_real(reader *r, const char *begin)
{
    const size_t before = r->kept.n;
    double value = 0;
    vvi_text_add_n(&r->kept, begin, (size_t)(r->at - begin));
    if (r->kept.bad) {
        fail_memory(r);
        return NULL;
    }
    vvi_parse_number(&value, r->kept.s + before);
    vvi_text_cut(&r->kept, before);
    if (isinf(value)) {
        r->flaw.fault = VVI_JSON_LARGE;
        fail_piece(r, "a number is too large", begin, r->at);
        return NULL;
    }
    json_t *made = json_real(value);
    if (!made)
        fail_memory(r);
    return made;
}

static json_t *read_whole(reader *r, const char *begin)
{
    const bool minus = *begin == '-';
    const uint64_t most = (uint64_t)INT64_MAX + minus;
    uint64_t value = 0;
    for (const char *c = begin + minus; c < r->at; c++) {
        const uint64_t digit = (uint64_t)(*c - '0');
        if (value > (most - digit) / 10) {
            r->flaw.fault = VVI_JSON_LARGE;
            fail_piece(r, "a whole number is too large", begin, r->at);
            return NULL;
        }
        value = 10 * value + digit;
    }
    json_t *made = json_integer((json_int_t)(minus ? 0 - value : value));
    if (!made)
        fail_memory(r);
    return made;
}

static json_t *read_number(reader *r)
{
    const char *begin = r->at;
    bool real = r->flags & JSON_DECODE_INT_AS_REAL;
    const char *behind = number_end(&real, begin, r->end);
    if (!behind) {
        fail_here(r, "this is no number");
        return NULL;
    }
    r->at = behind;
    return real ? read_real(r, begin) : read_whole(r, begin);
}

static json_t *read_word(reader *r)
{
    static const struct {
        const char *word;
        json_t *(*make)(void);
    } words[] = {{"true", json_true}, {"false", json_false}, {"null", json_null}};
    const size_t n = (size_t)(piece_end(r->at, r->end) - r->at);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (n != strlen(words[i].word) || memcmp(r->at, words[i].word, n) != 0)
            continue;
        r->at += n;
        return words[i].make();
    }
    fail_here(r, "a value was expected");
    return NULL;
}

/* Lists and objects ------------------------------------------------------------------------------------------------ */

static json_t *read_value(reader *r); /* each reads the other, not deeper than DEEPEST */

static bool read_element(reader *r, json_t *list)
{
    json_t *value = read_value(r);
    return value && (json_array_append_new(list, value) == 0 || fail_memory(r));
}

/* The name is kept while its value is read. */
static bool read_member(reader *r, json_t *object)
{
    const size_t name = r->kept.n;
    skip_blanks(r);
    const char *begin = r->at;
    if (r->at == r->end || *r->at != '"')
        return fail_here(r, "a name in double quotes was expected");
    if (!keep_text(r))
        return false;
    if (memchr(r->kept.s + name, 0, r->kept.n - name))
        return fail_piece(r, "a name has the character U+0000", begin, r->at);
    if ((r->flags & JSON_REJECT_DUPLICATES) && json_object_get(object, r->kept.s + name))
        return fail_piece(r, "duplicate object key", begin, r->at);
    vvi_text_add_n(&r->kept, "", 1);
    if (r->kept.bad)
        return fail_memory(r);
    if (!take(r, ':'))
        return fail_here(r, "':' was expected");
    json_t *value = read_value(r);
    if (!value)
        return false;
    const bool set = json_object_set_new_nocheck(object, r->kept.s + name, value) == 0;
    vvi_text_cut(&r->kept, name);
    return set || fail_memory(r);
}

static json_t *read_many(reader *r, json_t *many, bool (*read_one)(reader *r, json_t *many), char last,
                         const char *wanted)
{
    bool good = many || fail_memory(r);
    r->at++;
    for (size_t i = 0; good && !take(r, last); i++)
        good = (i == 0 || take(r, ',') || fail_here(r, wanted)) && read_one(r, many);
    if (good)
        return many;
    json_decref(many);
    return NULL;
}

static json_t *read_value(reader *r)
{
    json_t *value = NULL;
    skip_blanks(r);
    const char c = r->at < r->end ? *r->at : 0;
    if (++r->depth > DEEPEST)
        fail_here(r, "it is nested too deep");
    else if (c == '{')
        value = read_many(r, json_object(), read_member, '}', "',' or '}' was expected");
    else if (c == '[')
        value = read_many(r, json_array(), read_element, ']', "',' or ']' was expected");
    else if (c == '"')
        value = read_text(r);
    else if (c == '-' || (c >= '0' && c <= '9'))
        value = read_number(r);
    else
        value = read_word(r);
    r->depth--;
    return value;
}

json_t *vvi_json_decode(const char *text, size_t n, size_t flags, vvi_json_flaw *flaw_out)
{
    reader r = {.begin = text, .at = text, .end = text + n, .flags = flags};
    json_t *tree = NULL;
    skip_blanks(&r);
    if ((flags & JSON_DECODE_ANY) || (r.at < r.end && (*r.at == '{' || *r.at == '[')))
        tree = read_value(&r);
    else
        fail_here(&r, "'{' or '[' was expected");
    skip_blanks(&r);
    if (tree && r.at < r.end) {
        fail_here(&r, "its end was expected");
        json_decref(tree);
        tree = NULL;
    }
    vvi_text_free(&r.kept);
    if (flaw_out)
        *flaw_out = r.flaw;
    return tree;
}

json_t *vvi_json_of_own(const char *text)
{
    return vvi_json_decode(text, strlen(text), 0, NULL);
}

/* Printing -------------------------------------------------------------------------------------------------------- */

static int add(const char *piece, size_t n, void *text)
{
    vvi_text_add_n(text, piece, n);
    return ((vvi_text *)text)->bad ? -1 : 0;
}

char *vvi_json_encode(const json_t *tree, size_t flags)
{
    vvi_text text = {0};
    if (json_dump_callback(tree, add, &text, flags) != 0) /* bad is what a name could not be added to, too */
        text.bad = true;
    return vvi_text_take(&text);
}

/* Making ---------------------------------------------------------------------------------------------------------- */

void vvi_json_append(json_t **list, json_t *value)
{
    if (json_array_append_new(*list, value) == 0)
        return;
    json_decref(*list);
    *list = NULL;
}

void vvi_json_put(json_t **object, const char *name, json_t *value)
{
    if (json_object_set_new(*object, name, value) == 0)
        return;
    json_decref(*object);
    *object = NULL;
}

json_t *vvi_json_copy_object(const json_t *object)
{
    json_t *copy = json_copy((json_t *)object);
    if (!copy || json_object_size(copy) == json_object_size(object))
        return copy;
    json_decref(copy);
    return NULL;
}

#include "io/meshes/mesh_words.h"
#include "core/job.h"
#include "core/units.h"
#include "io/scan.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { POLLED_LINES = 1 << 14 };

void vvi_words_begin(vvi_words *out, vv_source *source, char comment, vv_job *job)
{
    *out = (vvi_words){.source = source, .comment = comment, .job = job};
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

static void pass_blanks(vvi_words *w)
{
    while (is_blank(*w->at))
        w->at++;
    if (w->comment && *w->at == w->comment)
        w->at += strlen(w->at);
}

vv_status vvi_words_line(vvi_words *w, const char **line_out)
{
    *line_out = NULL;
    if (++w->line % POLLED_LINES == 0 && vvi_job_poll(w->job) != VV_OK)
        return vv_error_last()->status;
    const vv_status st =
        vvi_source_line(w->source, &w->at, (size_t)vvi_source_limits(w->source)->string_bytes, &w->ended);
    if (st != VV_OK || w->ended) {
        w->at = "";
        return st;
    }
    pass_blanks(w);
    *line_out = w->at;
    return VV_OK;
}

const char *vvi_words_here(vvi_words *w, size_t *n_out)
{
    *n_out = 0;
    if (!w->at)
        return NULL;
    pass_blanks(w);
    const char *word = w->at;
    while (*w->at && !is_blank(*w->at) && !(w->comment && *w->at == w->comment))
        w->at++;
    *n_out = (size_t)(w->at - word);
    return *n_out ? word : NULL;
}

size_t vvi_words_left(const vvi_words *w, size_t most)
{
    vvi_words ahead = *w;
    size_t n = 0, length;
    while (n < most && vvi_words_here(&ahead, &length))
        n++;
    return n;
}

vv_status vvi_words_next(vvi_words *w, const char **word_out, size_t *n_out)
{
    while (!(*word_out = vvi_words_here(w, n_out))) {
        const char *line;
        const vv_status st = vvi_words_line(w, &line);
        if (st != VV_OK || !line)
            return st;
    }
    return VV_OK;
}

vv_status vvi_words_fail(const vvi_words *w, const char *format, ...)
{
    char text[512], line[32];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    snprintf(line, sizeof line, "%llu", (unsigned long long)w->line);
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(w->source), line, "%s", text);
}

/* Powers of ten that doubles hold exactly: a number of at most 53 bits times or by one of them is rounded once, which
 * is right (Clinger 1990). */
static const double tens[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                              1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static const char *scan_exponent(int *power, const char *at)
{
    const char *digits = at + 1;
    int e = 0;
    digits += *digits == '-' || *digits == '+';
    if (*digits < '0' || *digits > '9')
        return at;
    const bool minus = at[1] == '-';
    for (; *digits >= '0' && *digits <= '9'; digits++)
        e = e < 10000 ? 10 * e + (*digits - '0') : e;
    *power += minus ? -e : e;
    return digits;
}

bool vvi_words_number(double *out, const char *text, const char **end)
{
    const char *at = text;
    const bool minus = *at == '-';
    uint64_t m = 0;
    int n = 0, power = 0;
    at += minus || *at == '+';
    for (; *at >= '0' && *at <= '9'; at++, n++)
        m = n < 19 ? 10 * m + (uint64_t)(*at - '0') : m;
    if (*at == '.')
        for (at++; *at >= '0' && *at <= '9'; at++, n++, power--)
            m = n < 19 ? 10 * m + (uint64_t)(*at - '0') : m;
    if (n > 0 && (*at == 'e' || *at == 'E'))
        at = scan_exponent(&power, at);
    if (n == 0 || n > 19 || m > (UINT64_C(1) << 53) || power < -22 || power > 22 || *at == 'x' || *at == 'X')
        return vvi_scan_real(out, text, end);
    const double v = power < 0 ? (double)m / tens[-power] : (double)m * tens[power];
    *out = minus ? -v : v;
    *end = at;
    return true;
}

static vv_status fail_word(const vvi_words *w, const char *word, size_t n, const char *expected, const char *what)
{
    if (n == 0)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(w->source), NULL,
                          "ends after %llu lines where %s was expected; the file is cut short or its header wrong",
                          (unsigned long long)w->line - 1, what);
    return vvi_words_fail(w, "found '%.*s' where %s, %s, was expected", (int)(n < 40 ? n : 40), word, what, expected);
}

vv_status vvi_words_real(vvi_words *w, double *out, const char *what)
{
    const char *word, *end;
    size_t n;
    const vv_status st = vvi_words_next(w, &word, &n);
    if (st != VV_OK)
        return st;
    if (n == 0 || !vvi_words_number(out, word, &end) || end != word + n)
        return fail_word(w, word, n, "a number", what);
    return VV_OK;
}

vv_status vvi_words_int(vvi_words *w, int64_t *out, int64_t lo, int64_t hi, const char *what)
{
    const char *word, *end;
    size_t n;
    const vv_status st = vvi_words_next(w, &word, &n);
    if (st != VV_OK)
        return st;
    if (n == 0 || !vvi_scan_int(out, word, &end) || end != word + n)
        return fail_word(w, word, n, "a whole number", what);
    if (*out < lo || *out > hi)
        return vvi_words_fail(w, "%s is %lld; it goes from %lld to %lld", what, (long long)*out, (long long)lo,
                              (long long)hi);
    return VV_OK;
}

/* Numbers to text ------------------------------------------------------------------------------------------------- */

/* The last digits of a number, to the left from `end`; two at a time. */
static char *print_left(char *end, uint32_t value)
{
    static const char pairs[] =
        "00010203040506070809101112131415161718192021222324252627282930313233343536373839404142434445"
        "46474849505152535455565758596061626364656667686970717273747576777879808182838485868788899091"
        "9293949596979899";
    for (; value >= 100; value /= 100)
        end = memcpy(end - 2, pairs + 2 * (value % 100), 2);
    if (value >= 10)
        return memcpy(end - 2, pairs + 2 * value, 2);
    *--end = (char)('0' + value);
    return end;
}

size_t vvi_print_uint(char out[32], uint64_t value)
{
    char digits[24], *end = digits + sizeof digits, *at = end;
    for (; value > UINT32_MAX; value /= 10)
        *--at = (char)('0' + value % 10);
    at = print_left(at, (uint32_t)value);
    memcpy(out, at, (size_t)(end - at));
    return (size_t)(end - at);
}

/* n digits with a point after the first `point` of them (at most 0: zeros in front). */
static size_t place_point(char *out, const char *digits, size_t n, int point)
{
    size_t at = 0;
    while (n > 1 && digits[n - 1] == '0' && (int)n > point)
        n--;
    if (point <= 0) {
        out[at++] = '0';
        out[at++] = '.';
        for (int i = point; i < 0; i++)
            out[at++] = '0';
    }
    const size_t before = point > 0 && (size_t)point < n ? (size_t)point : 0;
    memcpy(out + at, digits, before);
    at += before;
    if (before > 0)
        out[at++] = '.';
    memcpy(out + at, digits + before, n - before);
    return at + n - before;
}

/* floor(log10(v)) of 1e-4 <= v < 1e9, by the power of 2 and one comparison. */
static int decimals_above(double v)
{
    static const double least[] = {1e-4, 1e-3, 1e-2, 1e-1, 1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    const int guess = ((int)(bits >> 52 & 2047) - 1023) * 1233 >> 12; /* at most one too low */
    return guess + (v >= least[guess + 5]);
}

static size_t print_plain(char *out, double v, float value)
{
    const double size = fabs(v);
    const int above = decimals_above(size);
    for (int digits = 6; digits <= 9; digits++) {
        const int shift = digits - 1 - above;
        const double scaled = shift < 0 ? size / tens[-shift] : size * tens[shift], whole = rint(scaled);
        const double back = shift < 0 ? whole * tens[-shift] : whole / tens[shift];
        if ((float)back != fabsf(value) && digits < 9)
            continue;
        if ((float)back != fabsf(value))
            break;
        if (shift < 0)
            return vvi_print_uint(out, (uint64_t)back);
        char text[32];
        const int n = (int)vvi_print_uint(text, (uint64_t)whole);
        return place_point(out, text, (size_t)n, n - shift);
    }
    return 0;
}

size_t vvi_print_float(char out[32], float value)
{
    const double v = value;
    size_t at = 0;
    if (isfinite(value) && fabs(v) >= 1e-4 && fabs(v) < 1e9) {
        if (v < 0)
            out[at++] = '-';
        const double size = fabs(v);
        if (size < 1 << 24 && size == (double)(uint32_t)size) /* most places: two of three lie on a sample */
            return at + vvi_print_uint(out + at, (uint32_t)size);
        const size_t n = print_plain(out + at, v, value);
        if (n > 0)
            return at + n;
    }
    if (!isfinite(value))
        return (size_t)snprintf(out, 32, "%s", isnan(value) ? "nan" : v > 0 ? "inf" : "-inf");
    if (value == 0)
        return (size_t)snprintf(out, 32, "0");
    for (int digits = 1; digits <= 9; digits++) {
        double back;
        const char *end;
        const int n = snprintf(out, 32, "%.*e", digits - 1, v);
        for (char *c = out; *c; c++)
            if (*c == ',')
                *c = '.'; /* the locale's */
        if (vvi_words_number(&back, out, &end) && (float)back == value)
            return (size_t)n;
    }
    return strlen(out);
}

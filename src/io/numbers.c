#include "io/numbers.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/scan.h"
#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TEXT_ROOM ((size_t)64 << 10)
#define TOKEN_MOST 128

vv_status vvi_numbers_begin(vvi_numbers *out, vv_source *source, vv_type type, uint64_t expected, vv_job *job)
{
    *out = (vvi_numbers){.source = source, .type = type, .expected = expected, .job = job};
    out->text = vvi_alloc(job, TEXT_ROOM, VVI_MEM_SCRATCH);
    return out->text ? VV_OK : vv_fail_memory(TEXT_ROOM);
}

void vvi_numbers_end(vvi_numbers *r)
{
    vvi_free(r->text);
    *r = (vvi_numbers){0};
}

static vv_status more_text(vvi_numbers *r, bool *end)
{
    vv_status st = VV_OK;
    if (r->text_at == r->text_end) {
        r->text_at = 0;
        st = vvi_source_read_some(r->source, r->text, TEXT_ROOM, &r->text_end);
    }
    *end = st == VV_OK && r->text_end == 0;
    return st;
}

static bool separates(char c)
{
    return isspace((unsigned char)c) || c == ',';
}

/* A number that ends where the file ends may have had more digits. Files by hand may lack the last line's end as well,
 * so it is said and no more: nothing is known to be missing. */
static void doubt_last(const vvi_numbers *r, const char *token)
{
    if (r->job)
        vvi_log(r->job, VV_LOG_WARNING, "io",
                "%s: ends right after its last number, %.40s, without a line end; if the file was cut short, digits of "
                "it are missing",
                vvi_source_name(r->source), token);
}

/* Empty at the end of the text. */
static vv_status next_token(vvi_numbers *r, char out[TOKEN_MOST])
{
    size_t n = 0;
    bool end = false;
    vv_status st;
    while ((st = more_text(r, &end)) == VV_OK && !end) {
        const char c = r->text[r->text_at];
        if (separates(c) && n > 0)
            break;
        r->text_at++;
        if (separates(c))
            continue;
        if (n + 1 == TOKEN_MOST)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                              "sample %llu is not a number: it has more than %d characters", (unsigned long long)r->at,
                              TOKEN_MOST - 1);
        out[n++] = c;
    }
    out[n] = 0;
    if (st == VV_OK && end && n > 0)
        doubt_last(r, out);
    return st;
}

static bool store_u64(void *out, const char *token)
{
    uint64_t v;
    const char *end;
    if (!vvi_scan_uint(&v, token, &end) || *end)
        return false;
    memcpy(out, &v, sizeof v);
    return true;
}

static bool store_i64(void *out, const char *token)
{
    int64_t v;
    const char *end;
    if (!vvi_scan_int(&v, token, &end) || *end)
        return false;
    memcpy(out, &v, sizeof v);
    return true;
}

/* Fortran leaves the letter out where an exponent has three digits: 0.123-104. */
static bool scan_bare_exponent(double *v, const char *token, const char *sign)
{
    char copy[TOKEN_MOST + 1];
    const char *end;
    const size_t n = (size_t)(sign - token);
    if ((*sign != '-' && *sign != '+') || strspn(sign + 1, "0123456789") != 3 || sign[4] || !memchr(token, '.', n))
        return false;
    snprintf(copy, sizeof copy, "%.*se%s", (int)n, token, sign);
    return vvi_scan_real(v, copy, &end) && !*end;
}

static bool store_number(void *out, vv_type type, const char *token)
{
    double v;
    const char *end;
    if (type == VV_TYPE_U64)
        return store_u64(out, token);
    if (type == VV_TYPE_I64)
        return store_i64(out, token);
    if (!vvi_scan_real(&v, token, &end) || (*end && !scan_bare_exponent(&v, token, end)))
        return false;
    if (!vv_type_is_float(type) && !(v >= vvi_type_min(type) && v <= vvi_type_max(type) && v == floor(v)))
        return false;
    vvi_samples_from_f64(out, &v, type, 1);
    return true;
}

vv_status vvi_numbers_read_some(vvi_numbers *r, void *out, size_t n, size_t *n_read)
{
    char token[TOKEN_MOST];
    const size_t bytes = vv_type_bytes(r->type);
    for (*n_read = 0; *n_read < n; ++*n_read) {
        vv_status st = next_token(r, token);
        if (st != VV_OK || token[0] == 0)
            return st;
        if (!store_number((uint8_t *)out + *n_read * bytes, r->type, token))
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL, "sample %llu is '%.40s', which is not %s",
                              (unsigned long long)r->at, token, vv_type_name(r->type));
        r->at++;
    }
    return VV_OK;
}

vv_status vvi_numbers_read(vvi_numbers *r, void *out, size_t n)
{
    size_t got;
    vv_status st = vvi_numbers_read_some(r, out, n, &got);
    if (st == VV_OK && got < n)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                          "ends after %llu samples; %llu were expected; the file is cut short or its header wrong",
                          (unsigned long long)r->at, (unsigned long long)r->expected);
    return st;
}

void vvi_sample_print(char out[32], vv_type type, const void *sample)
{
    double v;
    if (type == VV_TYPE_U64) {
        uint64_t u;
        memcpy(&u, sample, sizeof u);
        snprintf(out, 32, "%" PRIu64, u);
    } else if (type == VV_TYPE_I64) {
        int64_t i;
        memcpy(&i, sample, sizeof i);
        snprintf(out, 32, "%" PRId64, i);
    } else {
        vvi_samples_to_f64(&v, sample, type, 1);
        if (isfinite(v))
            vvi_print_number(out, v);
        else
            snprintf(out, 32, "%s", isnan(v) ? "nan" : v > 0 ? "inf" : "-inf");
    }
}

vv_status vvi_numbers_skip(vvi_numbers *r, uint64_t n)
{
    uint8_t thrown[256];
    vv_status st = VV_OK;
    const uint64_t room = sizeof thrown / vv_type_bytes(r->type);
    while (n > 0 && st == VV_OK) {
        const size_t m = (size_t)(n < room ? n : room);
        st = vvi_numbers_read(r, thrown, m);
        n -= m;
    }
    return st;
}

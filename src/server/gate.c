#include "server/gate.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>

enum { FAILURES = 5, LEAST_TOKEN = 16, LEAST_KINDS = 8, LEAST_BITS = 128 };
#define SECOND INT64_C(1000000000)

vv_status vvi_token_make(char out[VVI_TOKEN_TEXT])
{
    static const char digits[] = "0123456789abcdef";
    unsigned char bytes[VVI_TOKEN_BYTES];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return vv_fail(VV_E_READ, "the system gives no random numbers, so no secret token can be made");
    for (size_t i = 0; i < sizeof bytes; i++) {
        out[2 * i] = digits[bytes[i] >> 4];
        out[2 * i + 1] = digits[bytes[i] & 15];
    }
    out[VVI_TOKEN_TEXT - 1] = 0;
    return VV_OK;
}

static bool is_visible(const char *s)
{
    for (; *s; s++)
        if (*s <= ' ' || *s > '~')
            return false;
    return true;
}

/* Of how many different characters it is made. */
static size_t kinds(const char *token)
{
    size_t n = 0;
    for (const char *s = token; *s; s++)
        n += strchr(token, *s) == s;
    return n;
}

/* The length of the shortest piece that makes all of it when it is repeated: whoever knows it knows the rest. */
static size_t period(const char *token, size_t n)
{
    size_t p = 1;
    while (p <= n / 2 && memcmp(token, token + p, n - p) != 0)
        p++;
    return p <= n / 2 ? p : n;
}

/* Whether b is a itself, or next to it in the alphabet, among the digits, or on the keyboard. */
static bool are_near(char a, char b)
{
    static const char keys[] = "1234567890 qwertyuiop asdfghjkl zxcvbnm";
    const char *x = strchr(keys, tolower((unsigned char)a)), *y = strchr(keys, tolower((unsigned char)b));
    return abs(a - b) <= 1 || (x && y && x - y >= -1 && x - y <= 1);
}

/* Whether the three characters that end at i have been there before, in whatever case. */
static bool is_repeated(const char *token, size_t i)
{
    for (size_t j = 2; j < i; j++)
        if (strncasecmp(token + j - 2, token + i - 2, 3) == 0)
            return true;
    return false;
}

/* Characters, of which three and more that are near each other ("abc", "998877", "aaa", "qwert") count as one, and
 * those that repeat what was there ("change" in "changemechange") as none. */
static size_t loose_characters(const char *token, size_t n)
{
    size_t loose = n;
    for (size_t i = 2, run = 0; i < n; i++) {
        const bool goes_on = are_near(token[i], token[i - 1]) && are_near(token[i - 1], token[i - 2]);
        loose -= goes_on ? run ? 1 : 2 : is_repeated(token, i);
        run = goes_on ? run + 1 : 0;
    }
    return loose;
}

/* What each character of its kind could say: of hex digits, decimal ones, letters, and others. */
static double bits_each(const char *token)
{
    static const char digits[] = "0123456789", lower_hex[] = "0123456789abcdef", upper_hex[] = "0123456789ABCDEF";
    static const char lowers[] = "abcdefghijklmnopqrstuvwxyz", uppers[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";
    static const char signs[] = "!\"#$%&'()*+,-./:;<=>?@[\\]^_`{|}~";
    if (!token[strspn(token, digits)])
        return log2(10);
    if (!token[strspn(token, lower_hex)] || !token[strspn(token, upper_hex)])
        return log2(16);
    return log2((strpbrk(token, digits) ? 10 : 0) + (strpbrk(token, lowers) ? 26 : 0) +
                (strpbrk(token, uppers) ? 26 : 0) + (strpbrk(token, signs) ? 32 : 0));
}

vv_status vvi_token_check(const char *token)
{
    const size_t n = strnlen(token, VVI_TOKEN_TEXT);
    if (n < LEAST_TOKEN || n >= VVI_TOKEN_TEXT || !is_visible(token))
        return vv_fail(VV_E_ARGUMENT, "a token is %d to %d ASCII characters without blanks; this one is not",
                       LEAST_TOKEN, VVI_TOKEN_TEXT - 1);
    const size_t p = period(token, n);
    if (kinds(token) < LEAST_KINDS || loose_characters(token, p) < LEAST_TOKEN)
        return vv_fail(
            VV_E_ARGUMENT,
            "this token can be guessed: it has fewer than %d different characters, repeats a short piece, or "
            "consists of sequences such as 'abc' or 'qwerty'; leave it out and one is made",
            LEAST_KINDS);
    const double bits = (double)p * bits_each(token);
    if (bits < LEAST_BITS)
        return vv_fail(
            VV_E_ARGUMENT,
            "this token can be guessed: %zu characters of its kind have %.0f bits at most, expected %d or more "
            "(as 'openssl rand -hex 16' gives); leave it out and one is made",
            p, floor(bits), LEAST_BITS);
    return VV_OK;
}

static vv_status set_token(vvi_gate *gate, const char *token)
{
    const vv_status st = vvi_token_check(token);
    if (st == VV_OK)
        memcpy(gate->token, token, strlen(token) + 1);
    return st;
}

vv_status vvi_gate_open(vvi_gate *out, int port, const char *token, bool tls)
{
    static const char *const names[] = {"localhost", "127.0.0.1", "[::1]"};
    *out = (vvi_gate){.tls = tls};
    snprintf(out->cookie_name, sizeof out->cookie_name, "%svolvis-%d", tls ? "__Host-" : "", port);
    vv_status st = vvi_token_make(out->cookie);
    if (st == VV_OK)
        st = token ? set_token(out, token) : vvi_token_make(out->token);
    for (int i = 0; i < 3 && st == VV_OK; i++)
        st = vvi_gate_add_host(out, names[i], port);
    return st;
}

vv_status vvi_gate_renew(vvi_gate *gate)
{
    char token[VVI_TOKEN_TEXT], cookie[VVI_TOKEN_TEXT];
    vv_status st = vvi_token_make(token);
    if (st == VV_OK)
        st = vvi_token_make(cookie);
    if (st != VV_OK)
        return st;
    memcpy(gate->token, token, sizeof token);
    memcpy(gate->cookie, cookie, sizeof cookie);
    *gate->launch = 0;
    return VV_OK;
}

vv_status vvi_gate_launch(vvi_gate *gate)
{
    return vvi_token_make(gate->launch);
}

/* After the last colon that is not within an IPv6 address. */
static bool has_port(const char *host)
{
    const char *bracket = strrchr(host, ']'), *colon = strrchr(host, ':');
    return colon && (!bracket || colon > bracket);
}

vv_status vvi_gate_add_host(vvi_gate *gate, const char *host, int port)
{
    const size_t n = strnlen(host, 240);
    if (n == 0 || n == 240 || !is_visible(host) || strpbrk(host, "/@?#\\"))
        return vv_fail(VV_E_ARGUMENT, "\"%.40s\" is not a host name; give one such as viewer.example.org", host);
    if (gate->n_hosts == VVI_GATE_HOSTS)
        return vv_fail(VV_E_LIMIT, "a server has at most %d names", VVI_GATE_HOSTS);
    char *out = gate->host[gate->n_hosts++];
    if (has_port(host))
        snprintf(out, sizeof gate->host[0], "%s", host);
    else
        snprintf(out, sizeof gate->host[0], "%s:%d", host, port);
    return VV_OK;
}

/* As long for every text of n bytes. */
static bool equal_bytes(const char *a, const char *b, size_t n)
{
    unsigned difference = 0;
    for (size_t i = 0; i < n; i++)
        difference |= (unsigned)(unsigned char)a[i] ^ (unsigned)(unsigned char)b[i];
    return difference == 0;
}

static bool is_secret(const char *given, size_t n, const char *secret)
{
    return n == strlen(secret) && equal_bytes(given, secret, n);
}

/* ASCII alone: names of hosts have no other letters here. */
static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c + 'a' - 'A') : c;
}

static bool equal_names(const char *a, const char *b)
{
    for (; *a && lower(*a) == lower(*b); a++, b++)
        ;
    return !*a && !*b;
}

/* A browser leaves out the port that its scheme has by itself. */
static bool is_host(const vvi_gate *gate, const vvi_request *r, const char *host)
{
    char whole[300];
    if (!host || !*host || strnlen(host, 256) == 256)
        return false;
    snprintf(whole, sizeof whole, has_port(host) ? "%s" : gate->tls ? "%s:443" : "%s:80", host);
    for (int i = 0; i < gate->n_hosts; i++)
        if (equal_names(whole, gate->host[i]))
            return true;
    return r->here && *r->here && equal_names(whole, r->here);
}

bool vvi_gate_is_loopback(const char *host)
{
    static const char *const names[] = {"localhost", "127.0.0.1", "[::1]"};
    char name[300];
    snprintf(name, sizeof name, "%.*s", has_port(host) ? (int)(strrchr(host, ':') - host) : (int)strlen(host), host);
    for (int i = 0; i < 3; i++)
        if (equal_names(name, names[i]))
            return true;
    return false;
}

static bool is_origin(const vvi_gate *gate, const vvi_request *r)
{
    const char *origin = r->origin;
    const char *scheme = gate->tls ? "https://" : "http://";
    const size_t n = strlen(scheme);
    return strncmp(origin, scheme, n) == 0 && is_host(gate, r, origin + n);
}

/* "a=b; volvis-8080=...; c=d" */
static bool has_cookie(const vvi_gate *gate, const char *header)
{
    const size_t name = strlen(gate->cookie_name);
    while (header && *header) {
        header += strspn(header, " ;");
        const size_t n = strcspn(header, ";");
        if (n > name && strncmp(header, gate->cookie_name, name) == 0 && header[name] == '=' &&
            is_secret(header + name + 1, n - name - 1, gate->cookie))
            return true;
        header += n;
    }
    return false;
}

/* Failures ---------------------------------------------------------------------------------------------------------
 * A table of fixed size: an attacker with many addresses makes it forget the oldest, and guesses 256 bits all the same.
 */

static vvi_failures *failures_of(vvi_gate *gate, const char *address, int64_t now)
{
    vvi_failures *oldest = &gate->failures[0];
    const char *name = address ? address : "";
    for (int i = 0; i < VVI_GATE_ADDRESSES; i++) {
        vvi_failures *f = &gate->failures[i];
        if (f->n && strncmp(f->address, name, sizeof f->address - 1) == 0) {
            if (now - f->since >= SECOND)
                *f = (vvi_failures){.n = 0};
            return f;
        }
        if (f->since < oldest->since || !f->n)
            oldest = f;
    }
    *oldest = (vvi_failures){.n = 0};
    return oldest;
}

static void count_failure(vvi_gate *gate, const char *address, int64_t now)
{
    vvi_failures *f = failures_of(gate, address, now);
    if (f->n++)
        return;
    f->since = now;
    snprintf(f->address, sizeof f->address, "%s", address ? address : "");
}

static bool is_blocked(vvi_gate *gate, const char *address, int64_t now)
{
    return failures_of(gate, address, now)->n >= FAILURES;
}

/* Checks ---------------------------------------------------------------------------------------------------------- */

static bool comes_from_here(const vvi_gate *gate, const vvi_request *r)
{
    if (!is_host(gate, r, r->host) || (r->origin && !is_origin(gate, r)))
        return false;
    return !r->fetch_site || strcmp(r->fetch_site, "same-origin") == 0 || strcmp(r->fetch_site, "none") == 0;
}

/* Whatever others of this address have tried: they may be behind one proxy. */
static vvi_pass take_token(vvi_gate *gate, const vvi_request *r, const char *token, bool is_right, int64_t now)
{
    if (is_right || is_secret(token, strnlen(token, VVI_TOKEN_TEXT), gate->token))
        return VVI_PASS_ALL;
    if (is_blocked(gate, r->address, now))
        return VVI_PASS_SLOWER;
    count_failure(gate, r->address, now);
    return VVI_PASS_NONE;
}

/* A link that lets in once is for a page, which comes with it by vvi_gate_exchange(). */
vvi_pass vvi_gate_check(vvi_gate *gate, const vvi_request *r, int64_t now)
{
    if (!comes_from_here(gate, r))
        return VVI_PASS_NONE;
    if (has_cookie(gate, r->cookie))
        return VVI_PASS_ALL;
    return r->bearer ? take_token(gate, r, r->bearer, false, now) : VVI_PASS_PAGE;
}

vvi_pass vvi_gate_exchange(vvi_gate *gate, const vvi_request *r, const char *token, int64_t now)
{
    if (!comes_from_here(gate, r))
        return VVI_PASS_NONE;
    const bool launches = *gate->launch && is_secret(token, strnlen(token, VVI_TOKEN_TEXT), gate->launch);
    if (launches)
        *gate->launch = 0;
    return take_token(gate, r, token, launches, now);
}

void vvi_gate_cookie(char out[256], const vvi_gate *gate)
{
    snprintf(out, 256, "%s=%s; Path=/; HttpOnly; SameSite=Strict%s", gate->cookie_name, gate->cookie,
             gate->tls ? "; Secure" : "");
}

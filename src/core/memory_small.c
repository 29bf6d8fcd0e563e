/* Small uncounted memory, and failing on purpose; declared in memory.h. */
#include "core/memory.h"

#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* 0: off; n > 0: the n-th allocation fails; ALL: one has failed, and so do all after it; ONE: those after it do not.
 * Process-wide because workers must fail too; only tests ever set it. */
enum { ALL = -1, ONE = -2 };
static _Atomic int64_t countdown;
static _Atomic int64_t then = ALL;

void vvi_alloc_fail_after(int64_t n)
{
    atomic_store(&then, ALL);
    atomic_store(&countdown, n);
}

void vvi_alloc_fail_once(int64_t n)
{
    atomic_store(&then, ONE);
    atomic_store(&countdown, n);
}

bool vvi_alloc_has_failed(void)
{
    return atomic_load(&countdown) < 0;
}

bool vvi_alloc_fails(void)
{
    int64_t n = atomic_load_explicit(&countdown, memory_order_relaxed);
    while (n > 0)
        if (atomic_compare_exchange_weak(&countdown, &n, n == 1 ? atomic_load(&then) : n - 1))
            return n == 1;
    return n == ALL;
}

void *vvi_calloc(size_t n, size_t size)
{
    return vvi_alloc_fails() ? NULL : calloc(n ? n : 1, size ? size : 1);
}

void *vvi_realloc_plain(void *memory, size_t bytes)
{
    return vvi_alloc_fails() ? NULL : realloc(memory, bytes ? bytes : 1);
}

char *vvi_strdup(const char *text)
{
    return vvi_alloc_fails() ? NULL : strdup(text);
}

char *vvi_asprintf(const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    const int n = vvi_alloc_fails() ? -1 : vasprintf(&text, format, args);
    va_end(args);
    return n < 0 ? NULL : text;
}

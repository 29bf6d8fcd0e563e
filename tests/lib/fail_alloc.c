#include "fail_alloc.h"
#include "core/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

static void check_failure(vv_status st, int64_t n)
{
    if (st != VV_E_MEMORY && st != VV_E_LIMIT)
        fail_msg("allocation %lld failed and the status is %s: %s", (long long)n, vv_status_name(st),
                 vv_error_last()->message);
    assert_int_equal(vv_error_last()->status, st);
    assert_true(vv_error_last()->message[0]);
}

int64_t test_fail_each_alloc(vv_status (*act)(void *user), void *user)
{
    for (int64_t n = 1;; n++) {
        vvi_alloc_fail_after(n);
        const vv_status st = act(user);
        const bool failed = vvi_alloc_has_failed();
        vvi_alloc_fail_after(0);
        if (!failed) {
            if (st != VV_OK)
                fail_msg("no allocation failed, but the status is %s: %s", vv_status_name(st),
                         vv_error_last()->message);
            return n - 1;
        }
        if (st != VV_OK)
            check_failure(st, n);
    }
}

/* Counted memory. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/os.h"
#include "core/runtime.h"
#include "core/status.h"
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MIB = 1 << 20, OVERHEAD = 128 }; /* at most, by allocation */

static uint64_t used(vv_job *job)
{
    return vv_runtime_memory_used(vv_job_runtime(job));
}

static void memory_is_aligned_and_counted_by_tag(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 64 * MIB);
    vv_runtime *runtime = vv_job_runtime(job);
    void *voxels = vvi_alloc(job, 1000, VVI_MEM_VOXELS), *image = vvi_alloc(job, 9 * MIB, VVI_MEM_IMAGE);
    assert_non_null(voxels);
    assert_non_null(image);
    assert_int_equal((uintptr_t)voxels % 64, 0);
    assert_int_equal((uintptr_t)image % 64, 0);
    memset(voxels, 1, 1000);
    memset(image, 1, 9 * MIB);
    assert_in_range(vvi_memory_by_tag(runtime, VVI_MEM_VOXELS), 1000, 1000 + OVERHEAD);
    assert_in_range(vvi_memory_by_tag(runtime, VVI_MEM_IMAGE), 9 * MIB, 9 * MIB + OVERHEAD);
    assert_int_equal(vvi_memory_by_tag(runtime, VVI_MEM_SCRATCH), 0);
    assert_int_equal(used(job), vvi_memory_by_tag(runtime, VVI_MEM_VOXELS) + vvi_memory_by_tag(runtime, VVI_MEM_IMAGE));
    vvi_free(image);
    vvi_free(voxels);
    assert_int_equal(used(job), 0);
    assert_in_range(vv_runtime_memory_peak(runtime), 9 * MIB + 1000, 9 * MIB + 1000 + 2 * OVERHEAD);
    vv_job_release(job);
}

static void zeroed_memory_is_zero_at_every_size(void **state)
{
    (void)state;
    static const size_t sizes[] = {0, 1, 63, 64, 65, 4096, MIB, 8 * MIB - 64, 8 * MIB, 20 * MIB + 1};
    vv_job *job = test_job(1, 64 * MIB);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        unsigned char *dirty = vvi_alloc(job, sizes[i], VVI_MEM_SCRATCH);
        memset(dirty, 0xff, sizes[i]);
        vvi_free(dirty);
        unsigned char *clean = vvi_alloc_zeroed(job, sizes[i], VVI_MEM_SCRATCH);
        assert_non_null(clean);
        for (size_t k = 0; k < sizes[i]; k++)
            if (clean[k])
                fail_msg("byte %zu of %zu is not zero", k, sizes[i]);
        vvi_free(clean);
    }
    vv_job_release(job);
}

static void what_exceeds_the_limit_is_refused_with_the_numbers(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 2 * MIB);
    void *first = vvi_alloc(job, MIB, VVI_MEM_SCRATCH);
    assert_non_null(first);
    const uint64_t before = used(job);
    assert_null(vvi_alloc(job, 3 * MIB / 2, VVI_MEM_SCRATCH));
    assert_int_equal(vv_fail_memory(3 * MIB / 2), VV_E_LIMIT);
    assert_string_equal(
        vv_error_last()->message,
        "needs 1.5 MiB of memory, but 1.0 MiB of the limit of 2.0 MiB are in use; give more with --memory");
    assert_int_equal(used(job), before);
    vvi_free(first);
    first = vvi_alloc(job, 3 * MIB / 2, VVI_MEM_SCRATCH);
    assert_non_null(first);
    vvi_free(first);
    vv_job_release(job);
}

static void an_impossible_size_is_refused(void **state)
{
    (void)state;
    vv_job *job = test_job(1, UINT64_MAX);
    static const size_t sizes[] = {SIZE_MAX, SIZE_MAX - 64, SIZE_MAX - 127};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        assert_null(vvi_alloc(job, sizes[i], VVI_MEM_SCRATCH));
        assert_int_equal(vv_fail_memory(sizes[i]), VV_E_MEMORY);
        assert_null(vvi_alloc_zeroed(NULL, sizes[i], VVI_MEM_SCRATCH));
    }
    assert_int_equal(used(job), 0);
    vv_job_release(job);
}

static void without_a_job_one_allocation_may_take_half_of_the_machine(void **state)
{
    (void)state;
    vv_runtime *runtime;
    assert_int_equal(vv_runtime_new(&runtime, NULL), VV_OK); /* its limit is by default that half */
    const uint64_t half = vv_runtime_memory_limit(runtime);
    vv_runtime_release(runtime);
    static const size_t sizes[] = {0, 100, 20 * MIB};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        void *little = vvi_alloc(NULL, sizes[i], VVI_MEM_SCRATCH);
        assert_non_null(little);
        vvi_free(little);
    }
    assert_null(vvi_alloc(NULL, half + MIB, VVI_MEM_SCRATCH));
    assert_int_equal(vv_fail_memory(half + MIB), VV_E_LIMIT);
    assert_int_equal(vvi_memory_plan(NULL, half + MIB, "the volume"), VV_E_LIMIT);
    assert_int_equal(vvi_memory_plan(NULL, MIB, "the volume"), VV_OK);
}

static void a_refusal_is_forgotten_when_memory_is_had_again(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 3 * MIB);
    void *first = vvi_alloc(job, 2 * MIB, VVI_MEM_SCRATCH);
    assert_null(vvi_alloc(job, 2 * MIB, VVI_MEM_SCRATCH));
    vvi_free(first);
    first = vvi_alloc(job, 2 * MIB, VVI_MEM_SCRATCH);
    assert_non_null(first);
    assert_int_equal(vv_fail_memory(2 * MIB), VV_E_MEMORY); /* somebody else's malloc of the same size */
    vvi_free(first);
    vv_job_release(job);
}

static void of_several_blocks_the_one_that_was_refused_is_told(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 2 * MIB);
    void *fine[2] = {vvi_alloc(job, 512, VVI_MEM_SCRATCH), NULL};
    assert_null(vvi_alloc(job, 3 * MIB, VVI_MEM_SCRATCH));
    fine[1] = vvi_alloc(job, MIB, VVI_MEM_SCRATCH);
    assert_non_null(fine[1]);
    assert_int_equal(vv_fail_memory(MIB), VV_E_LIMIT);
    assert_string_equal(
        vv_error_last()->message,
        "needs 3.0 MiB of memory, but 576 bytes of the limit of 2.0 MiB are in use; give more with --memory");
    vvi_free(fine[0]);
    vvi_free(fine[1]);
    vv_job_release(job);
}

static void a_plan_says_what_is_needed_and_how_to_allow_it(void **state)
{
    (void)state;
    const uint64_t gib = UINT64_C(1) << 30;
    vv_job *job = test_job(1, 2 * gib);
    assert_int_equal(vvi_memory_plan(job, gib, "the volume"), VV_OK);
    assert_int_equal(vvi_memory_plan(job, 2 * gib, "the volume"), VV_OK);
    assert_int_equal(vvi_memory_plan(job, gib * 32 / 10, "the volume 'a.nrrd'"), VV_E_LIMIT);
    assert_string_equal(vv_error_last()->message,
                        "the volume 'a.nrrd' needs 3.2 GiB, the limit is 2.0 GiB; give --memory "
                        "4G or use less data");
    void *held = vvi_alloc(job, 100 * MIB, VVI_MEM_SCRATCH);
    assert_int_equal(vvi_memory_plan(job, 2 * gib, "x"), VV_E_LIMIT);
    assert_string_equal(
        vv_error_last()->message,
        "x needs 2.0 GiB, but 100.0 MiB of the limit of 2.0 GiB are in use; give --memory 3G or use less data");
    assert_int_equal(vvi_memory_plan(job, UINT64_MAX, "x"), VV_E_LIMIT);
    vvi_free(held);
    vv_job_release(job);
    job = test_job(1, 10 * MIB);
    assert_int_equal(vvi_memory_plan(job, 50 * MIB, "x"), VV_E_LIMIT);
    assert_string_equal(vv_error_last()->message,
                        "x needs 50.0 MiB, the limit is 10.0 MiB; give --memory 51M or use less data");
    vv_job_release(job);
}

static void reallocating_keeps_the_contents(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    vv_job *job = test_job(1, 512 * MIB);
    unsigned char *memory = NULL;
    size_t bytes = 0;
    for (uint64_t i = 0; i < 200; i++) {
        /* mostly small, sometimes over the size from which pages are mapped */
        const size_t next = test_random(seed, i) % (i % 8 == 7 ? 40 * MIB : 70000) + 1;
        memory = vvi_realloc(job, memory, next, VVI_MEM_SCRATCH);
        assert_non_null(memory);
        assert_int_equal((uintptr_t)memory % 64, 0);
        const size_t kept = bytes < next ? bytes : next;
        for (size_t k = 0; k < kept; k += 997)
            assert_int_equal(memory[k], (unsigned char)(k * 31));
        for (size_t k = 0; k < next; k += 997)
            memory[k] = (unsigned char)(k * 31);
        bytes = next;
        assert_in_range(used(job), bytes, bytes + OVERHEAD);
    }
    vvi_free(memory);
    assert_int_equal(used(job), 0);
    vv_job_release(job);
}

static void a_refused_reallocation_leaves_the_old_memory(void **state)
{
    (void)state;
    static const size_t from[] = {1000, 10 * MIB}, to[] = {30 * MIB, 30 * MIB};
    for (int i = 0; i < 2; i++) {
        vv_job *job = test_job(1, 25 * MIB); /* room for 10 + 11 where blocks cannot be moved */
        unsigned char *memory = vvi_alloc_zeroed(job, from[i], VVI_MEM_SCRATCH);
        memory[from[i] - 1] = 42;
        const uint64_t before = used(job);
        assert_null(vvi_realloc(job, memory, to[i], VVI_MEM_SCRATCH));
        assert_int_equal(vv_fail_memory(to[i]), VV_E_LIMIT);
        vvi_alloc_fail_after(1);
        assert_null(vvi_realloc(job, memory, from[i] + MIB, VVI_MEM_SCRATCH));
        vvi_alloc_fail_after(0);
        assert_int_equal(vv_fail_memory(from[i] + MIB), VV_E_MEMORY);
        assert_int_equal(used(job), before);
        assert_int_equal(memory[from[i] - 1], 42);
        vvi_free(memory);
        assert_int_equal(used(job), 0);
        vv_job_release(job);
    }
}

static void memory_outlives_its_job_and_runtime(void **state)
{
    (void)state;
    vv_job *job = test_job(2, 0);
    char *kept = vvi_alloc(job, 100, VVI_MEM_MODEL);
    vv_job_release(job); /* the last that knew the runtime */
    memset(kept, 1, 100);
    vvi_free(kept);
    vvi_free(NULL);
}

static vv_status hammer(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    vv_job *job = shared;
    for (uint64_t i = 0; i < 200; i++) {
        const size_t bytes = test_random(index, i) % 20000;
        unsigned char *memory = vvi_alloc(job, bytes, (vvi_memory_tag)(i % VVI_MEM_TAGS));
        if (memory)
            memset(memory, (int)i, bytes);
        vvi_free(memory);
    }
    return VV_OK;
}

static void many_threads_never_exceed_the_limit_together(void **state)
{
    (void)state;
    vv_job *job = test_job(8, 50000);
    const vvi_work work = {.item = hammer};
    assert_int_equal(vvi_parallel_for(job, &work, job, 100), VV_OK);
    assert_int_equal(used(job), 0);
    for (int tag = 0; tag < VVI_MEM_TAGS; tag++)
        assert_int_equal(vvi_memory_by_tag(vv_job_runtime(job), (vvi_memory_tag)tag), 0);
    assert_in_range(vv_runtime_memory_peak(vv_job_runtime(job)), 1, 50000);
    vv_job_release(job);
}

static vv_status make_derived(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    *bytes_out = *(size_t *)user;
    *value_out = vvi_alloc(job, *bytes_out, VVI_MEM_DERIVED);
    return *value_out ? VV_OK : vv_fail_memory(*bytes_out);
}

static void fill_cache(vv_job *job, uint64_t n, size_t bytes)
{
    for (uint64_t i = 0; i < n; i++) {
        vvi_cached *cached;
        assert_int_equal(vvi_cache_get(&cached, &(vvi_cache_key){"test", 1, i}, make_derived, vvi_free, &bytes, job),
                         VV_OK);
        vvi_cache_release(cached);
    }
}

static void the_cache_gives_way_to_allocations_and_plans(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 10 * MIB);
    vvi_cache_counts counts;
    fill_cache(job, 8, MIB);
    void *large = vvi_alloc(job, 5 * MIB, VVI_MEM_VOXELS);
    assert_non_null(large);
    vvi_cache_get_counts(&counts, vv_job_runtime(job));
    assert_in_range(counts.entries, 3, 4);
    vvi_free(large);
    fill_cache(job, 8, MIB);
    assert_int_equal(vvi_memory_plan(job, 4 * MIB, "x"), VV_OK);
    vvi_cache_get_counts(&counts, vv_job_runtime(job));
    assert_in_range(counts.entries, 5, 6); /* no more goes than must */
    fill_cache(job, 8, MIB);
    assert_int_equal(vvi_memory_plan(job, 9 * MIB, "x"), VV_OK);
    vvi_cache_get_counts(&counts, vv_job_runtime(job));
    assert_in_range(counts.entries, 0, 1);
    fill_cache(job, 8, MIB);
    vvi_cache_get_counts(&counts, vv_job_runtime(job));
    const uint64_t before = counts.entries;
    assert_int_equal(vvi_memory_plan(job, 11 * MIB, "x"), VV_E_LIMIT); /* hopeless: nothing is dropped for it */
    assert_null(vvi_alloc(job, 11 * MIB, VVI_MEM_VOXELS));
    vvi_cache_get_counts(&counts, vv_job_runtime(job));
    assert_int_equal(counts.entries, before);
    vv_job_release(job);
}

static void sizes_multiply_exactly_or_fail(void **state)
{
    (void)state;
    size_t n = 7;
    assert_int_equal(vvi_mul_size(&n, 1000, 1000), VV_OK);
    assert_int_equal(n, 1000000);
    assert_int_equal(vvi_mul_size(&n, SIZE_MAX, 2), VV_E_LIMIT);
    assert_int_equal(vvi_mul3_size(&n, 2, 3, 4), VV_OK);
    assert_int_equal(n, 24);
    assert_int_equal(vvi_mul3_size(&n, SIZE_MAX / 2, 2, 1), VV_OK);
    assert_int_equal(vvi_mul3_size(&n, SIZE_MAX / 2, 1, 3), VV_E_LIMIT);
    assert_int_equal(vvi_mul3_size(&n, SIZE_MAX, SIZE_MAX, 0), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, " x "));
}

static vv_status allocate_three(void *user)
{
    void *a = vvi_alloc(user, 100, VVI_MEM_SCRATCH), *b = NULL, *c = NULL;
    vv_status st = a ? VV_OK : vv_fail_memory(100);
    if (st == VV_OK && !(b = vvi_alloc_zeroed(user, 10 * MIB, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(10 * MIB);
    if (st == VV_OK && !(c = vvi_realloc(user, b, 12 * MIB, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(12 * MIB);
    vvi_free(c ? c : b);
    vvi_free(a);
    assert_int_equal(used(user), 0);
    return st;
}

static void every_allocation_can_fail(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 64 * MIB);
    assert_int_equal(test_fail_each_alloc(allocate_three, job), 3);
    vv_job_release(job);
}

/* Maps that are kept ---------------------------------------------------------------------------------------------- */

enum { PAGE = 4096, MARK = 0x5a };

static vvi_kept_maps *new_kept(void)
{
    static vvi_kept_maps kept;
    kept = (vvi_kept_maps){.n = 0};
    assert_int_equal(pthread_mutex_init(&kept.lock, NULL), 0);
    return &kept;
}

static char *marked_map(size_t bytes)
{
    char *map = vvi_os_map(bytes);
    assert_non_null(map);
    memset(map, MARK, bytes);
    return map;
}

static void a_freed_map_is_taken_again_with_its_pages_at_nearly_its_size(void **state)
{
    (void)state;
    static const size_t sizes[] = {40 * PAGE, 21 * PAGE, 79 * PAGE, 40 * PAGE - 1};
    vvi_kept_maps *kept = new_kept();
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        vvi_kept_give(kept, marked_map(40 * PAGE), 40 * PAGE, MIB);
        assert_int_equal(kept->bytes, 40 * PAGE);
        char *again = vvi_kept_take(kept, sizes[i], MIB);
        assert_non_null(again);
        assert_int_equal(again[0], MARK);
        assert_int_equal(again[20 * PAGE], MARK);
        again[sizes[i] - 1] = 1;
        assert_int_equal(kept->n, 0);
        assert_int_equal(kept->bytes, 0);
        vvi_os_unmap(again, sizes[i]);
    }
    pthread_mutex_destroy(&kept->lock);
}

static void the_nearest_size_is_taken(void **state)
{
    (void)state;
    vvi_kept_maps *kept = new_kept();
    static const size_t sizes[] = {30 * PAGE, 60 * PAGE, 45 * PAGE};
    for (size_t i = 0; i < 3; i++)
        vvi_kept_give(kept, marked_map(sizes[i]), sizes[i], MIB);
    char *again = vvi_kept_take(kept, 44 * PAGE, MIB);
    assert_non_null(again);
    assert_int_equal(kept->n, 2);
    assert_int_equal(kept->bytes, 90 * PAGE);
    vvi_os_unmap(again, 44 * PAGE);
    vvi_kept_drop(kept);
    assert_int_equal(kept->n, 0);
    assert_int_equal(kept->bytes, 0);
    pthread_mutex_destroy(&kept->lock);
}

static void maps_are_dropped_where_none_fits_or_room_is_short(void **state)
{
    (void)state;
    vvi_kept_maps *kept = new_kept();
    vvi_kept_give(kept, marked_map(10 * PAGE), 10 * PAGE, 9 * PAGE);
    assert_int_equal(kept->n, 0);
    vvi_kept_give(kept, marked_map(10 * PAGE), 10 * PAGE, 15 * PAGE);
    vvi_kept_give(kept, marked_map(10 * PAGE), 10 * PAGE, 15 * PAGE);
    assert_int_equal(kept->n, 1);
    assert_null(vvi_kept_take(kept, 50 * PAGE, MIB)); /* too large to be made of it */
    assert_int_equal(kept->n, 0);
    for (int i = 0; i < VVI_KEPT_MAPS + 3; i++)
        vvi_kept_give(kept, marked_map(PAGE), PAGE, MIB);
    assert_int_equal(kept->n, VVI_KEPT_MAPS);
    char *again = vvi_kept_take(kept, PAGE, PAGE); /* what is left is more than there is room for */
    assert_non_null(again);
    assert_int_equal(kept->n, 0);
    vvi_os_unmap(again, PAGE);
    pthread_mutex_destroy(&kept->lock);
}

static void what_is_kept_stays_within_the_limit(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 64 * MIB);
    const vvi_kept_maps *kept = &vv_job_runtime(job)->kept;
    for (size_t i = 0; i < 40; i++) {
        const size_t each = (9 + i * 7 % 20) * MIB;
        void *a = vvi_alloc(job, each, VVI_MEM_SCRATCH), *b = vvi_alloc(job, each, VVI_MEM_SCRATCH);
        assert_non_null(a);
        assert_non_null(b);
        assert_true(used(job) + kept->bytes <= 64 * MIB);
        vvi_free(a);
        assert_true(used(job) + kept->bytes <= 64 * MIB);
        vvi_free(b);
        assert_true(used(job) + kept->bytes <= 64 * MIB);
    }
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_is_aligned_and_counted_by_tag),
        cmocka_unit_test(zeroed_memory_is_zero_at_every_size),
        cmocka_unit_test(what_exceeds_the_limit_is_refused_with_the_numbers),
        cmocka_unit_test(an_impossible_size_is_refused),
        cmocka_unit_test(without_a_job_one_allocation_may_take_half_of_the_machine),
        cmocka_unit_test(a_refusal_is_forgotten_when_memory_is_had_again),
        cmocka_unit_test(of_several_blocks_the_one_that_was_refused_is_told),
        cmocka_unit_test(a_plan_says_what_is_needed_and_how_to_allow_it),
        cmocka_unit_test(reallocating_keeps_the_contents),
        cmocka_unit_test(a_refused_reallocation_leaves_the_old_memory),
        cmocka_unit_test(memory_outlives_its_job_and_runtime),
        cmocka_unit_test(many_threads_never_exceed_the_limit_together),
        cmocka_unit_test(the_cache_gives_way_to_allocations_and_plans),
        cmocka_unit_test(sizes_multiply_exactly_or_fail),
        cmocka_unit_test(every_allocation_can_fail),
        cmocka_unit_test(a_freed_map_is_taken_again_with_its_pages_at_nearly_its_size),
        cmocka_unit_test(the_nearest_size_is_taken),
        cmocka_unit_test(maps_are_dropped_where_none_fits_or_room_is_short),
        cmocka_unit_test(what_is_kept_stays_within_the_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

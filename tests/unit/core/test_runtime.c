/* Runtimes, instruction sets, the machine. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/os.h"
#include "fail_alloc.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/registry.h>
#include <volvis/version.h>

#include <cmocka.h>

static vv_status make(vv_runtime **out, const char *cpu)
{
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.cpu = cpu;
    return vv_runtime_new(out, &options);
}

static void default_options_are_those_of_no_options(void **state)
{
    (void)state;
    vv_runtime *runtime;
    assert_int_equal(vv_runtime_new(&runtime, NULL), VV_OK);
    assert_int_equal(vv_runtime_threads(runtime), vvi_os_cores());
    assert_int_equal(vv_runtime_memory_limit(runtime), vvi_os_memory_bytes() / 2);
    assert_int_equal(vv_runtime_memory_used(runtime), 0);
    assert_int_equal(vv_runtime_memory_peak(runtime), 0);
    assert_ptr_equal(vv_runtime_registry(runtime), vv_registry_builtin());
    assert_ptr_equal(vv_runtime_retain(runtime), runtime);
    vv_runtime_release(runtime);
    vv_runtime_release(runtime);
    vv_runtime_release(NULL);
}

static void options_are_obeyed(void **state)
{
    (void)state;
    static const vv_registry mine = {0};
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    assert_int_equal(options.size, sizeof options);
    assert_int_equal(options.log_level, VV_LOG_WARNING);
    options.threads = 5;
    options.memory_bytes = 12345678;
    options.registry = &mine;
    options.allow_outside = true;
    vv_runtime *runtime;
    vv_job *job;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    assert_int_equal(vv_runtime_threads(runtime), 5);
    assert_int_equal(vv_runtime_memory_limit(runtime), 12345678);
    assert_ptr_equal(vvi_job_registry(job), &mine);
    assert_true(vvi_job_allow_outside(job));
    vv_job_release(job);
    vv_runtime_release(runtime);
}

static void a_caller_that_knows_less_or_more_options_is_understood(void **state)
{
    (void)state;
    struct {
        vv_runtime_options known;
        char newer[64];
    } large;
    vv_runtime *runtime;
    memset(&large, 0xee, sizeof large);
    vv_runtime_options_init(&large.known, sizeof large);
    assert_int_equal(large.known.size, sizeof large);
    assert_int_equal(large.newer[63], 0);
    assert_int_equal(vv_runtime_new(&runtime, &large.known), VV_OK);
    vv_runtime_release(runtime);
    /* An older caller: only up to memory_bytes; what lies behind is not touched and not read. */
    const size_t old_size = offsetof(vv_runtime_options, cpu);
    memset(&large, 0xee, sizeof large);
    vv_runtime_options_init(&large.known, old_size);
    assert_int_equal(((unsigned char *)&large)[old_size], 0xee);
    large.known.threads = 3;
    assert_int_equal(vv_runtime_new(&runtime, &large.known), VV_OK);
    assert_int_equal(vv_runtime_threads(runtime), 3);
    vv_runtime_release(runtime);
}

static void wrong_options_are_refused(void **state)
{
    (void)state;
    static const int threads[] = {-1, 257, 1 << 30};
    vv_runtime_options options;
    vv_runtime *runtime;
    for (int i = 0; i < 3; i++) {
        vv_runtime_options_init(&options, sizeof options);
        options.threads = threads[i];
        assert_int_equal(vv_runtime_new(&runtime, &options), VV_E_ARGUMENT);
        assert_null(runtime);
        assert_non_null(strstr(vv_error_last()->message, "0 to 256"));
    }
    memset(&options, 0, sizeof options);
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "vv_runtime_options_init"));
}

static void the_threads_by_default_are_those_of_the_affinity_mask(void **state)
{
    (void)state;
    cpu_set_t before, one;
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    CPU_ZERO(&one);
    for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&one) == 0; i++)
        if (CPU_ISSET(i, &before))
            CPU_SET(i, &one);
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    assert_int_equal(vvi_os_cores(), 1);
    assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
    assert_in_range(vvi_os_cores(), 1, CPU_COUNT(&before));
}

/* Instruction sets ----------------------------------------------------------------------------------------------- */

/* VOLVIS_CPU may be set around this test program: it is put back. */
static char *cpu_before;

static int save_cpu(void **state)
{
    (void)state;
    const char *name = getenv("VOLVIS_CPU");
    cpu_before = name ? strdup(name) : NULL;
    unsetenv("VOLVIS_CPU");
    return 0;
}

static int restore_cpu(void **state)
{
    (void)state;
    if (cpu_before)
        setenv("VOLVIS_CPU", cpu_before, 1);
    else
        unsetenv("VOLVIS_CPU");
    free(cpu_before);
    return 0;
}

static void the_machine_s_features_are_those_the_compiler_sees(void **state)
{
    (void)state;
    const uint32_t bits = vvi_cpu_detect();
#if defined(__x86_64__)
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
    const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    assert_int_equal((bits & VVI_CPU_AVX2) != 0, avx2);
    assert_int_equal((bits & VVI_CPU_AVX512) != 0, avx2 && avx512);
#elif defined(__aarch64__)
    assert_int_equal(bits, VVI_CPU_NEON);
#else
    assert_int_equal(bits, 0);
#endif
}

static void check_isa(const char *option, const char *variable, const char *expected)
{
    vv_runtime *runtime;
    if (variable)
        setenv("VOLVIS_CPU", variable, 1);
    else
        unsetenv("VOLVIS_CPU");
    assert_int_equal(make(&runtime, option), VV_OK);
    assert_string_equal(vv_runtime_isa(runtime), expected);
    vv_job *job;
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    if (strcmp(expected, "base") == 0)
        assert_int_equal(vvi_job_cpu(job), 0);
    vv_job_release(job);
    vv_runtime_release(runtime);
}

static void the_instruction_set_can_be_lowered(void **state)
{
    (void)state;
    const uint32_t bits = vvi_cpu_detect();
    check_isa("base", NULL, "base");
    check_isa(NULL, "base", "base");
    if (bits & VVI_CPU_AVX2) {
        check_isa("avx2", NULL, "avx2");
        check_isa("avx2", "base", "avx2"); /* the option wins */
        check_isa(NULL, "avx2", "avx2");
    }
    if (bits & VVI_CPU_AVX512) {
        check_isa("avx512", NULL, "avx512");
        check_isa(NULL, "", "avx512");
    }
    setenv("VOLVIS_CPU", "base", 1);
    assert_int_equal(vvi_cpu_detect(), 0);
    assert_int_equal(vvi_job_cpu(NULL), 0);
}

static void an_unknown_instruction_set_is_answered_with_the_known_ones(void **state)
{
    (void)state;
    vv_runtime *runtime;
    assert_int_equal(make(&runtime, "avx3"), VV_E_ARGUMENT);
    assert_string_equal(vv_error_last()->message,
                        "cpu: no instruction set is named 'avx3'; there are base, avx2, avx512, neon");
    setenv("VOLVIS_CPU", "sse9", 1);
    assert_int_equal(make(&runtime, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "VOLVIS_CPU: "));
    assert_null(runtime);
    assert_int_equal(make(&runtime, "base"), VV_OK); /* the option wins, right or wrong */
    vv_runtime_release(runtime);
}

static void an_instruction_set_that_the_machine_lacks_is_unsupported(void **state)
{
    (void)state;
    vv_runtime *runtime;
#if defined(__aarch64__)
    const char *absent = "avx2";
#else
    const char *absent = "neon";
#endif
    assert_int_equal(make(&runtime, absent), VV_E_UNSUPPORTED);
    assert_non_null(strstr(vv_error_last()->message, absent));
    assert_null(runtime);
}

/* Life and memory ------------------------------------------------------------------------------------------------ */

static vv_status make_and_release(void *user)
{
    (void)user;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vv_status st = vv_runtime_new(&runtime, NULL);
    if (st == VV_OK)
        st = vv_job_new(&job, runtime, NULL, NULL);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st;
}

static void every_allocation_of_a_new_runtime_and_job_can_fail(void **state)
{
    (void)state;
    assert_int_equal(test_fail_each_alloc(make_and_release, NULL), 2);
}

static void *retain_and_release(void *user)
{
    for (int i = 0; i < 10000; i++)
        vv_runtime_release(vv_runtime_retain(user));
    return NULL;
}

static void references_may_be_taken_by_any_thread(void **state)
{
    (void)state;
    vv_runtime *runtime;
    pthread_t threads[4];
    assert_int_equal(vv_runtime_new(&runtime, NULL), VV_OK);
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, retain_and_release, runtime), 0);
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    vv_runtime_release(runtime);
}

static void the_library_knows_its_version(void **state)
{
    (void)state;
    assert_string_equal(vv_version(), VV_VERSION_STRING);
    vv_library library;
    size_t n = 0;
    for (; vv_library_nth(&library, n, false); n++)
        assert_true(*library.name && *library.purpose && (!*library.version || strpbrk(library.version, "0123456789")));
    assert_true(n > 15 && !vv_library_nth(&library, n, true));
    const char *isa;
    bool usable;
    assert_true(vv_isa_nth(&isa, &usable, 0) && usable);
    assert_string_equal(isa, "base");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(default_options_are_those_of_no_options),
        cmocka_unit_test(options_are_obeyed),
        cmocka_unit_test(a_caller_that_knows_less_or_more_options_is_understood),
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(the_threads_by_default_are_those_of_the_affinity_mask),
        cmocka_unit_test_setup_teardown(the_machine_s_features_are_those_the_compiler_sees, save_cpu, restore_cpu),
        cmocka_unit_test_setup_teardown(the_instruction_set_can_be_lowered, save_cpu, restore_cpu),
        cmocka_unit_test_setup_teardown(an_unknown_instruction_set_is_answered_with_the_known_ones, save_cpu,
                                        restore_cpu),
        cmocka_unit_test_setup_teardown(an_instruction_set_that_the_machine_lacks_is_unsupported, save_cpu,
                                        restore_cpu),
        cmocka_unit_test(every_allocation_of_a_new_runtime_and_job_can_fail),
        cmocka_unit_test(references_may_be_taken_by_any_thread),
        cmocka_unit_test(the_library_knows_its_version),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Limits of control groups, read from folders made for the test. */
#include "core/os.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64];

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/volvis-cgroup-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command); /* NOLINT(cert-env33-c): fixed words */
}

/* Writes a file of the tree with all folders above it. */
static void put(const char *path, const char *text)
{
    char file[512];
    snprintf(file, sizeof file, "%s/%s", folder, path);
    for (char *slash = file + 1; (slash = strchr(slash, '/')); slash++) {
        *slash = 0;
        mkdir(file, 0755);
        *slash = '/';
    }
    FILE *f = fopen(file, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

static vvi_cgroup_limits read_limits(void)
{
    char membership[128], root[128];
    snprintf(membership, sizeof membership, "%s/self", folder);
    snprintf(root, sizeof root, "%s/fs", folder);
    return vvi_cgroup_read(membership, root);
}

static void check(uint64_t memory_bytes, double cores)
{
    const vvi_cgroup_limits limits = read_limits();
    assert_int_equal(limits.memory_bytes, memory_bytes);
    if (limits.cores != cores)
        fail_msg("%g cores, not %g", limits.cores, cores);
}

static void without_groups_nothing_is_limited(void **state)
{
    (void)state;
    check(UINT64_MAX, INFINITY);
    put("self", "nonsense\n:::\n0:\n\n");
    check(UINT64_MAX, INFINITY);
    put("self", "0::/a/b\n4:memory:/c\n");
    check(UINT64_MAX, INFINITY);
}

static void version_2_limits_come_from_the_group_and_all_above(void **state)
{
    (void)state;
    put("self", "0::/user/job\n");
    put("fs/user/job/memory.max", "max\n");
    put("fs/user/job/cpu.max", "max 100000\n");
    check(UINT64_MAX, INFINITY);
    put("fs/user/memory.max", "3000000\n");
    put("fs/user/cpu.max", "150000 100000\n");
    check(3000000, 1.5);
    put("fs/user/job/memory.max", "2000000\n");
    put("fs/user/job/cpu.max", "400000 100000\n");
    check(2000000, 1.5); /* the least of each */
    put("fs/user/job/memory.high", "1000000\n");
    check(1000000, 1.5);
}

static void the_root_of_a_container_is_its_own_group(void **state)
{
    (void)state;
    put("self", "0::/\n");
    put("fs/memory.max", "12345\n");
    put("fs/cpu.max", "50000 100000\n");
    check(12345, 0.5);
    put("self", "0::/../../outside\n");
    check(12345, 0.5);
}

static void version_1_has_a_tree_for_each_controller(void **state)
{
    (void)state;
    put("self", "9:name=systemd:/\n4:memory:/docker/1\n2:cpu,cpuacct:/docker/1\n3:cpuset:/\n");
    put("fs/memory/memory.limit_in_bytes", "9223372036854771712\n"); /* how version 1 says: none */
    put("fs/memory/docker/1/memory.limit_in_bytes", "777\n");
    put("fs/cpu,cpuacct/docker/1/cpu.cfs_quota_us", "-1\n");
    put("fs/cpu,cpuacct/docker/1/cpu.cfs_period_us", "100000\n");
    check(777, INFINITY);
    put("fs/cpu,cpuacct/docker/1/cpu.cfs_quota_us", "250000\n");
    check(777, 2.5);
    put("self", "2:mycpu,cpuacct:/docker/1\n3:cpuset,notcpu:/docker/1\n");
    put("fs/mycpu,cpuacct/docker/1/cpu.cfs_quota_us", "100000\n");
    put("fs/mycpu,cpuacct/docker/1/cpu.cfs_period_us", "100000\n");
    check(UINT64_MAX, INFINITY); /* other controllers */
    put("self", "2:cpuacct,cpu,more:/\n");
    put("fs/cpuacct,cpu,more/cpu.cfs_quota_us", "100000\n");
    put("fs/cpuacct,cpu,more/cpu.cfs_period_us", "100000\n");
    check(UINT64_MAX, 1);
    put("self", "4:memory:/not/visible/here\n");
    put("fs/memory/memory.limit_in_bytes", "888\n");
    check(888, INFINITY);
}

static void mixed_systems_have_version_2_beside_version_1(void **state)
{
    (void)state;
    put("self", "4:memory:/a\n0::/b\n");
    put("fs/memory/a/memory.limit_in_bytes", "900\n");
    put("fs/unified/b/memory.max", "800\n");
    check(800, INFINITY);
}

static void what_makes_no_sense_limits_nothing(void **state)
{
    (void)state;
    put("self", "0::/a\n");
    put("fs/a/memory.max", "lots\n");
    put("fs/a/cpu.max", "100000 0\n");
    check(UINT64_MAX, INFINITY);
    put("fs/a/cpu.max", "");
    put("fs/a/memory.max", "");
    check(UINT64_MAX, INFINITY);
}

static void above_a_path_that_is_too_long_limits_still_hold(void **state)
{
    (void)state;
    char line[6000] = "0::/";
    memset(line + 4, 'a', 5000);
    put("self", line);
    put("fs/memory.max", "100\n");
    check(100, INFINITY);
}

static void this_machine_has_cores_memory_and_a_clock(void **state)
{
    (void)state;
    const double before_s = vvi_os_seconds();
    assert_true(vvi_os_cores() >= 1);
    assert_true(vvi_os_memory_bytes() > 1 << 24);
    assert_true(vvi_os_seconds() >= before_s);
}

static void maps_are_zero_and_aligned_and_keep_their_bytes_when_they_grow(void **state)
{
    (void)state;
    const size_t bytes = (20 << 20) + 5;
    unsigned char *memory = vvi_os_map(bytes);
    assert_non_null(memory);
    assert_int_equal((uintptr_t)memory % (2 << 20), 0);
    for (size_t i = 0; i < bytes; i += 511)
        assert_int_equal(memory[i], 0);
    memory[bytes - 1] = 9;
    memory = vvi_os_remap(memory, bytes, 3 * bytes);
    assert_non_null(memory);
    assert_int_equal(memory[bytes - 1], 9);
    assert_int_equal(memory[3 * bytes - 1], 0);
    vvi_os_unmap(memory, 3 * bytes);
    assert_null(vvi_os_map((size_t)1 << 62));
}

#define WITH_FOLDER(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(without_groups_nothing_is_limited),
        WITH_FOLDER(version_2_limits_come_from_the_group_and_all_above),
        WITH_FOLDER(the_root_of_a_container_is_its_own_group),
        WITH_FOLDER(version_1_has_a_tree_for_each_controller),
        WITH_FOLDER(mixed_systems_have_version_2_beside_version_1),
        WITH_FOLDER(what_makes_no_sense_limits_nothing),
        WITH_FOLDER(above_a_path_that_is_too_long_limits_still_hold),
        cmocka_unit_test(this_machine_has_cores_memory_and_a_clock),
        cmocka_unit_test(maps_are_zero_and_aligned_and_keep_their_bytes_when_they_grow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

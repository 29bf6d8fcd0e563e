/* Simple points against counts of parts, cavities and cells of the block with them and without. */
#include "fields.h"
#include "segment/simple_points.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 5, ALL = SIDE * SIDE * SIDE };

static void block(uint8_t out[ALL], uint32_t object)
{
    memset(out, 0, ALL);
    for (int b = 0; b < VVI_AROUND; b++)
        out[b % 3 + 1 + SIDE * (b / 3 % 3 + 1 + SIDE * (b / 9 + 1))] = object >> b & 1;
}

static void fill(uint8_t *at, int index, uint8_t from, uint8_t to, int axes)
{
    at[index] = to;
    for (int d = 0; d < 27; d++) {
        const int x = index % SIDE + d % 3 - 1, y = index / SIDE % SIDE + d / 3 % 3 - 1,
                  z = index / SIDE / SIDE + d / 9 - 1;
        const int next = x + SIDE * (y + SIDE * z), differ = (d % 3 != 1) + (d / 3 % 3 != 1) + (d / 9 != 1);
        if (x >= 0 && x < SIDE && y >= 0 && y < SIDE && z >= 0 && z < SIDE && differ <= axes && at[next] == from)
            fill(at, next, from, to, axes);
    }
}

static int parts(const uint8_t in[ALL], uint8_t of, int axes)
{
    uint8_t at[ALL];
    int n = 0;
    memcpy(at, in, ALL);
    for (int i = 0; i < ALL; i++)
        if (at[i] == of) {
            fill(at, i, of, 7, axes);
            n++;
        }
    return n;
}

/* Corners - edges + faces - cubes of the closed cubes. */
static int euler(const uint8_t at[ALL])
{
    int sum = 0;
    for (int code = 0; code < 8; code++)
        for (int z = 1; z < SIDE; z++)
            for (int y = 1; y < SIDE; y++)
                for (int x = 1; x < SIDE; x++) {
                    bool any = false;
                    for (int d = 0; d < 8; d++) /* along axes that the cell spans there is one voxel, else two */
                        if (!(d & code))
                            any |= at[x - (d & 1) + SIDE * (y - (d >> 1 & 1) + SIDE * (z - (d >> 2)))];
                    const int spans = (code & 1) + (code >> 1 & 1) + (code >> 2);
                    sum += any ? (spans % 2 ? -1 : 1) : 0;
                }
    return sum;
}

static bool same_topology(uint32_t object)
{
    uint8_t with[ALL], without[ALL];
    block(with, object | 1u << VVI_AROUND_OWN);
    block(without, object & ~(1u << VVI_AROUND_OWN));
    return parts(with, 1, 3) == parts(without, 1, 3) && parts(with, 0, 1) == parts(without, 0, 1) &&
           euler(with) == euler(without);
}

static void check(uint32_t object)
{
    if (vvi_is_simple(object) != same_topology(object))
        fail_msg("block %07x", object);
}

static void a_voxel_is_simple_where_nothing_changes_without_it(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (uint32_t a = 0; a < VVI_AROUND; a++) /* few neighbours, and few that are missing */
        for (uint32_t b = 0; b < VVI_AROUND; b++)
            for (uint32_t c = 0; c < VVI_AROUND; c += 2) {
                check(1u << a | 1u << b | 1u << c);
                check(~(1u << a | 1u << b | 1u << c) & ((1u << VVI_AROUND) - 1));
            }
    for (uint64_t i = 0; i < 20000; i++) {
        const uint32_t bits = (uint32_t)test_random(seed, i), more = (uint32_t)test_random(seed, i + 1000000);
        check((i % 3 == 0 ? bits : i % 3 == 1 ? bits & more : bits | more) & ((1u << VVI_AROUND) - 1));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_voxel_is_simple_where_nothing_changes_without_it)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

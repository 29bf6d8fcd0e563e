/* Boxes cut into items for parallel loops. */
#include "grid/slabs.h"

static int64_t at_least_1(int64_t v)
{
    return v < 1 ? 1 : v;
}

static int64_t at_most(int64_t v, int64_t most)
{
    return v < most ? v : most;
}

vvi_slabs vvi_slabs_of(const vv_box *box, int64_t most)
{
    vvi_slabs s = {.box = *box};
    if (box->n[0] < 1 || box->n[1] < 1 || box->n[2] < 1)
        return s;
    s.step[0] = at_most(box->n[0], at_least_1(most));
    s.step[1] = s.step[0] < box->n[0] ? 1 : at_most(box->n[1], at_least_1(most / box->n[0]));
    s.step[2] = s.step[1] < box->n[1] ? 1 : at_most(box->n[2], at_least_1(most / box->n[0] / box->n[1]));
    s.n = 1;
    for (int a = 0; a < 3; a++) {
        s.items[a] = (box->n[a] - 1) / s.step[a] + 1;
        s.n *= (size_t)s.items[a];
    }
    return s;
}

vv_box vvi_slabs_item(const vvi_slabs *slabs, size_t index)
{
    vv_box item;
    int64_t rest = (int64_t)index;
    for (int a = 0; a < 3; a++) {
        const int64_t at = rest % slabs->items[a] * slabs->step[a];
        rest /= slabs->items[a];
        item.lo[a] = slabs->box.lo[a] + at;
        item.n[a] = at_most(slabs->step[a], slabs->box.n[a] - at);
    }
    return item;
}

int64_t vvi_slabs_row(const vvi_slabs *slabs, const vv_box *item, int64_t j, int64_t k)
{
    const vv_box *all = &slabs->box;
    const int64_t row = (item->lo[2] - all->lo[2] + k) * all->n[1] + item->lo[1] - all->lo[1] + j;
    return row * all->n[0] + item->lo[0] - all->lo[0];
}

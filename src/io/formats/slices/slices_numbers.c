/* Numbers in the names of slices, and the words before them that say what they count. */
#include "io/formats/slices/slices.h"
#include <string.h>
#include <strings.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_lower(char c)
{
    return c >= 'a' && c <= 'z';
}

static bool is_upper(char c)
{
    return c >= 'A' && c <= 'Z';
}

static bool is_letter(char c)
{
    return is_lower(c) || is_upper(c);
}

/* As microscopes and their programs write them, whatever the case. */
static vvi_slice_role role_of(const char *word, size_t n)
{
    static const struct {
        const char *word;
        vvi_slice_role role;
    } words[] = {
        {"z", VVI_SLICE_Z},
        {"slice", VVI_SLICE_Z},
        {"plane", VVI_SLICE_Z},
        {"section", VVI_SLICE_Z},
        {"zslice", VVI_SLICE_Z},
        {"zplane", VVI_SLICE_Z},
        {"c", VVI_SLICE_C},
        {"ch", VVI_SLICE_C},
        {"chan", VVI_SLICE_C},
        {"channel", VVI_SLICE_C},
        {"w", VVI_SLICE_C},
        {"wave", VVI_SLICE_C},
        {"wavelength", VVI_SLICE_C},
        {"t", VVI_SLICE_T},
        {"time", VVI_SLICE_T},
        {"frame", VVI_SLICE_T},
        {"tp", VVI_SLICE_T},
        {"timepoint", VVI_SLICE_T},
        {"timestep", VVI_SLICE_T},
        {"s", VVI_SLICE_SERIES},
        {"series", VVI_SLICE_SERIES},
        {"pos", VVI_SLICE_SERIES},
        {"position", VVI_SLICE_SERIES},
        {"xy", VVI_SLICE_SERIES},
        {"site", VVI_SLICE_SERIES},
        {"field", VVI_SLICE_SERIES},
        {"fov", VVI_SLICE_SERIES},
        {"well", VVI_SLICE_SERIES},
        {"scene", VVI_SLICE_SERIES},
        {"tile", VVI_SLICE_SERIES},
        {"roi", VVI_SLICE_SERIES},
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i].word) == n && strncasecmp(words[i].word, word, n) == 0)
            return words[i].role;
    return VVI_SLICE_UNKNOWN;
}

/* The word directly before `at`, or before one mark between them; of "imgZ" it is "Z". */
static void find_word(vvi_slice_run *run, const char *name, size_t at)
{
    const char mark = at > 0 ? name[at - 1] : 0;
    const bool apart = mark == '_' || mark == '-' || mark == ' ' || mark == '=';
    const size_t end = at - apart;
    size_t begin = end;
    while (begin > 0 && is_letter(name[begin - 1]) &&
           !(begin < end && is_upper(name[begin]) && is_lower(name[begin - 1])))
        begin--;
    run->n_word = end - begin;
    run->role = role_of(name + begin, end - begin);
    run->weak = apart && mark != '=' && end - begin == 1;
}

/* "w2GFP_": wave 2, called GFP; but "w2z05" is wave 2 of slice 5. */
static size_t channel_name(const char *name, size_t at)
{
    size_t n = 0, letters = 0;
    while (is_letter(name[at + letters]))
        letters++;
    if (letters == 0 || (is_digit(name[at + letters]) && role_of(name + at, letters) != VVI_SLICE_UNKNOWN))
        return 0;
    while (is_letter(name[at + n]) || is_digit(name[at + n]))
        n++;
    return n;
}

vvi_slice_run vvi_slices_number(const char *name, size_t at)
{
    vvi_slice_run run = {.at = at};
    for (; is_digit(name[at + run.n]); run.n++)
        run.value = run.value < UINT64_MAX / 16 ? run.value * 10 + (uint64_t)(name[at + run.n] - '0') : run.value;
    find_word(&run, name, at);
    if (run.role == VVI_SLICE_C && run.n_word == 1 && (name[at - 1] == 'w' || name[at - 1] == 'W'))
        run.n += channel_name(name, at + run.n);
    return run;
}

vvi_slice_runs vvi_slices_numbers(const char *name)
{
    vvi_slice_runs runs = {.n = 0};
    for (size_t i = 0; name[i] && runs.n < VVI_SLICE_RUNS;)
        if (is_digit(name[i])) {
            runs.run[runs.n] = vvi_slices_number(name, i);
            i += runs.run[runs.n++].n;
        } else {
            i++;
        }
    return runs;
}

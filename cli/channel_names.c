#include "channel_names.h"
#include "core/names.h"
#include "label_names.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { NAMES_MOST = 64 };

static bool is_called(const char *name, const char *word, size_t length)
{
    return name && strlen(name) == length && strncasecmp(name, word, length) == 0;
}

static vv_status fail_channel(const cli_input *input, const char *word, size_t length, const vv_channel *channels,
                              size_t n)
{
    char typed[64];
    const char *names[NAMES_MOST];
    size_t n_names = 0;
    const vv_field_info *info = vv_file_info(input->file);
    for (size_t c = 0; c < n && n_names < NAMES_MOST; c++)
        if (channels[c].name[0])
            names[n_names++] = channels[c].name;
    for (int c = 0; c < info->components && vv_component_name(info, c) && n_names < NAMES_MOST; c++)
        names[n_names++] = vv_component_name(info, c);
    snprintf(typed, sizeof typed, "%.*s", (int)(length < 60 ? length : 60), word);
    if (!n_names)
        return vv_fail_at(VV_E_ARGUMENT, input->path, NULL, "there is no channel '%s'; they are numbered 0 to %d",
                          typed, info->components - 1);
    return vvi_fail_name(VV_E_ARGUMENT, input->path, NULL, typed, &(vvi_known){names, n_names, NULL, NULL},
                         "there is no channel '%s' of those numbered 0 to %d", typed, info->components - 1);
}

static vv_status find_channel(int *out, const cli_input *input, const char *word, size_t length)
{
    size_t n;
    const vv_channel *channels = vv_file_channels(input->file, &n);
    const vv_field_info *info = vv_file_info(input->file);
    for (*out = 0; *out < info->components; (*out)++)
        if ((size_t)*out < n && is_called(channels[*out].name, word, length))
            return VV_OK;
    for (*out = 0; *out < info->components; (*out)++)
        if (is_called(vv_component_name(info, *out), word, length))
            return VV_OK;
    const bool number = length > 0 && length < 10 && strspn(word, "0123456789") >= length;
    *out = number ? (int)strtol(word, NULL, 10) : info->components;
    return *out < info->components ? VV_OK : fail_channel(input, word, length, channels, n);
}

vv_status cli_channel_numbers(vvi_text *out, const cli_input *input, const char *words)
{
    for (size_t n;; words += n + 1) {
        int number;
        n = strcspn(words, ",");
        const vv_status st = find_channel(&number, input, words, n);
        if (st != VV_OK)
            return st;
        vvi_text_printf(out, "%s%d", out->n ? "," : "", number);
        if (!words[n])
            return out->bad ? vv_fail_memory(out->n) : VV_OK;
    }
}

/* Numbers are left to the operation, which says more of those that there are not. */
static cli_given *find_names(const cli_args *args, const vv_class *cls)
{
    for (size_t i = 0; i < args->n_given; i++) {
        cli_given *given = &args->given[i];
        if (given->cls == cls && given->row->option && strcmp(given->row->option, "channel") == 0 &&
            given->text[strspn(given->text, "0123456789,+-. ")])
            return given;
    }
    return NULL;
}

vv_status cli_operation_params(vv_object **out, const cli_command *command, const cli_args *args, const vv_class *cls,
                               const vv_field_info *info, const cli_input *channels, const cli_label_names *labels)
{
    const vv_property_context context = cli_input_context(info, command->registry);
    cli_given *given = channels ? find_names(args, cls) : NULL;
    const char *typed = given ? given->text : NULL;
    vvi_text numbers = {0};
    vv_status st = given ? cli_channel_numbers(&numbers, channels, typed) : VV_OK;
    *out = NULL;
    if (st == VV_OK && given)
        given->text = numbers.s;
    if (st == VV_OK)
        st = cli_label_params(out, args, cls, &context, labels);
    if (given)
        given->text = typed;
    vvi_text_free(&numbers);
    return st;
}
